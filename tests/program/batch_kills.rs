//! A run over many scenes that is killed again and again and resumed ends with the files of an undisturbed run.

use std::collections::HashMap;
use std::process::Stdio;
use std::time::Instant;

use crate::batch::{log, tree};
use crate::harness::patches::is_long;
use crate::harness::program::{Folder, text};

/// Half of the scenes are small, an eighth are broken, a quarter are slow.
fn with_scenes(count: usize) -> Folder {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("in/sub")).unwrap();
    image::RgbImage::from_pixel(8, 8, image::Rgb([200, 90, 30]))
        .save(folder.path("in/t.png"))
        .unwrap();
    for number in 0..count {
        let color = format!("color = [{}, 0.5, 0.2]", number as f64 / count as f64);
        let surface = format!("[[surface]]\ncontrol_points = \"default\"\n{color}\n");
        let scene = match number % 8 {
            0 => "[[surface]]\ncontrol_points = 3\n".to_owned(),
            1 => "[[surface]]\ncontrol_points = \"default\"\ntexture = \"t.png\"\n".to_owned(),
            // A pass for each sample.
            2 | 3 => format!("[render]\nsamples = 256\n{surface}"),
            _ => surface,
        };
        let sub = if number % 8 > 4 { "sub/" } else { "" };
        folder.write(&format!("in/{sub}{number}.toml"), scene);
    }
    folder
}

#[test]
fn killed_and_resumed_runs_end_as_an_undisturbed_one() {
    let (count, kills) = if is_long() { (1000, 50) } else { (80, 6) };
    let folder = with_scenes(count);
    let command = |out: &str| {
        let log = format!("{out}.jsonl");
        let arguments =
            ["render", "in", "--recursive", "-o", out, "--log", &log, "--jobs", "2", "--resume"];
        let mut command = folder.command(&[&arguments[..], &["--resolution", "48x36"]].concat());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    };
    let start = Instant::now();
    let undisturbed = command("whole").output().unwrap();
    let time = start.elapsed();
    // What a run takes that makes nothing.
    let start = Instant::now();
    let _ = command("whole").output().unwrap();
    let idle = start.elapsed();
    let broken = count / 8;
    assert!(text(&undisturbed.stderr).contains(&format!("{broken} of {count} pictures failed")));
    let whole = tree(&folder.path("whole"));
    assert_eq!(whole.len(), 2 * (count - broken));

    std::fs::create_dir_all(folder.path("out")).unwrap();
    let mut random = 1_u64;
    for _ in 0..kills {
        let mut program = command("out").spawn().unwrap();
        random =
            random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let share = (random >> 33) as f64 / f64::from(1_u32 << 31);
        std::thread::sleep((idle + time / kills).mul_f64(2.0 * share));
        program.kill().unwrap();
        let _ = program.wait_with_output().unwrap();
        // Whatever is there is whole.
        let found = tree(&folder.path("out"));
        for (name, bytes) in found.iter().filter(|(name, _)| name.ends_with(".png")) {
            assert!(bytes == &whole[name], "{name} is torn");
        }
    }
    let resumed = command("out").output().unwrap();
    assert!(text(&resumed.stderr).contains(&format!("{broken} of {count} pictures failed")));
    let kept = text(&resumed.stdout).lines().filter(|line| line.starts_with("kept ")).count();
    assert!(kept > 0, "the killed runs made nothing");

    let found = tree(&folder.path("out"));
    let names = |files: &std::collections::BTreeMap<String, Vec<u8>>| {
        files.keys().cloned().collect::<Vec<_>>()
    };
    assert_eq!(names(&found), names(&whole));
    assert!(found == whole, "the bytes differ");
    let mut last = HashMap::new();
    for line in log(&folder.path("out.jsonl")) {
        let status = line["status"].as_str().unwrap().to_owned();
        last.insert(line["input"].as_str().unwrap().to_owned(), status);
    }
    assert_eq!(last.len(), count);
    assert_eq!(last.values().filter(|status| *status == "failed").count(), broken);
}

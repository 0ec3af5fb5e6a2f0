//! `freeform render` on many scenes: folders, lists, shards, records, the log, failures and time limits.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::harness::program::{Folder, SCENE, resource, text};

const SMALL: [&str; 2] = ["--resolution", "16x12"];

/// The bytes of all files in a folder and its folders, by their paths in it.
pub(crate) fn tree(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(root).unwrap().to_str().unwrap().to_owned();
                // A temporary file may be gone by now.
                files.extend(std::fs::read(&path).ok().map(|bytes| (name, bytes)));
            }
        }
    }
    files
}

/// The names of the pictures in a folder and its folders.
fn pictures(root: &Path) -> Vec<String> {
    tree(root).into_keys().filter(|name| name.ends_with(".png")).collect()
}

/// The lines of a log.
pub(crate) fn log(path: &Path) -> Vec<serde_json::Value> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{line}: {e}")))
        .collect()
}

/// A folder with scenes of different colours `0.toml`, `1.toml` …
fn with_scenes(count: usize) -> Folder {
    let folder = Folder::new();
    for number in 0..count {
        let color = number as f64 / count as f64;
        let surface = format!("control_points = \"default\", color = [1, {color}, 0]");
        folder.write(&format!("{number}.toml"), format!("surface = [{{ {surface} }}]"));
    }
    folder
}

#[test]
fn folders_and_lists_keep_their_folders_below_the_output() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("in/deep/er")).unwrap();
    for name in ["in/a.toml", "in/deep/b.toml", "in/deep/er/c.d.toml", "alone.toml"] {
        folder.write(name, SCENE);
    }
    folder.write("in/deep/texture.png", "no scene");
    let run = |arguments: &[&str], list: &str| {
        let _ = std::fs::remove_dir_all(folder.path("out"));
        let arguments = [&["render", "-o", "out"], &SMALL[..], arguments].concat();
        let output = folder.run_with(&arguments, list);
        assert!(output.status.success(), "{output:?}");
        (pictures(&folder.path("out")), text(&output.stdout))
    };
    assert_eq!(run(&["in"], "").0, ["a.png"]);
    let (made, said) = run(&["in", "alone.toml", "--recursive"], "");
    assert_eq!(made, ["a.png", "alone.png", "deep/b.png", "deep/er/c.d.png"]);
    assert!(
        said.contains("wrote out/deep/er/c.d.png") && said.contains("4 made, 0 kept, 0 failed")
    );
    let absolute = folder.path("in/a.toml");
    let absolute = absolute.to_str().unwrap();
    // A scene is drawn once however often it is named.
    let list = format!("in/deep/b.toml\n\n./alone.toml\n{absolute}\nin/deep/b.toml\n");
    let made = run(&["--list", "-"], &list).0;
    let below = format!("{}.png", absolute.trim_start_matches('/').trim_end_matches(".toml"));
    let mut expected = vec!["alone.png".to_owned(), "in/deep/b.png".into(), below];
    expected.sort();
    assert_eq!(made, expected);
    folder.write("list", "in/deep\n");
    let made = run(&["--list", "list", "--recursive"], "").0;
    assert_eq!(made, ["in/deep/b.png", "in/deep/er/c.d.png"]);
}

#[test]
fn many_pictures_are_those_that_are_drawn_alone() {
    let folder = Folder::new();
    let scenes = [
        "scenes/thesis/fig22.toml",
        "scenes/gallery/gear.toml",
        "surfaces/teapot.bpt",
        "models/flange.ffm",
    ];
    let list = scenes.map(resource).join("\n");
    let size = ["--resolution", "120x90"];
    for options in [&["--jobs", "1"][..], &["--jobs", "3"], &["--jobs", "1", "--samples", "4"]] {
        let all = [&["render", "--list", "-", "-o", "out"], &size[..], options].concat();
        let output = folder.run_with(&all, &list);
        assert!(output.status.success(), "{output:?}");
        for scene in scenes.map(resource) {
            let made = folder.path("out").join(Path::new(&scene[1..]).with_extension("png"));
            let alone = [&["render", &scene, "-o", "alone.png"], &size[..], &options[2..]].concat();
            assert!(folder.run(&alone).status.success());
            let alone = std::fs::read(folder.path("alone.png")).unwrap();
            assert!(std::fs::read(made).unwrap() == alone, "{scene} {options:?}");
        }
    }
}

#[test]
fn wrong_calls_write_nothing_and_say_why() {
    let folder = with_scenes(2);
    folder.write("empty", "\n");
    std::fs::create_dir_all(folder.path("sub")).unwrap();
    folder.write("sub/1.obj", "v 0 0 0");
    let before = tree(folder.root());
    for (arguments, status, words) in [
        (&["0.toml", "1.toml", "-o", "both.png"][..], 1, "both.png for several pictures"),
        (&["0.toml", "1.toml", "-o", "-"], 1, "a folder"),
        (&["1.toml", "sub/1.obj", "-o", "new"], 1, "new/1.png for 1.toml and sub/1.obj"),
        (&["0.toml", "-"], 1, "standard input alone"),
        (&["--list", "empty"], 1, "one a line"),
        (&["--list", "none"], 1, "none"),
        (&["0.toml", "1.toml", "--aov", "uv=a.exr"], 1, "one scene"),
        (&["0.toml", "--resume", "--aov", "uv=a.exr"], 1, "one scene"),
        (&["0.toml", "--log", "none/log"], 1, "none/log"),
        (&["0.toml", "--jobs", "0"], 2, "--jobs"),
        (&["0.toml", "--shard", "3/2"], 2, "I from 1 to N"),
        (&["0.toml", "--timeout", "0"], 2, "seconds"),
    ] {
        let output = folder.run(&[&["render"], arguments].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{said}");
        assert!(said.contains(words) && said.lines().count() == 1, "{words}: {said}");
        assert_eq!(tree(folder.root()), before, "{words}");
    }
}

#[test]
fn shards_are_the_whole_set_and_share_nothing() {
    let folder = with_scenes(20);
    let render = |list: &str, options: &[&str]| {
        let arguments = [&["render", "--list", "-"], &SMALL[..], options].concat();
        let output = folder.run_with(&arguments, list);
        assert!(output.status.success(), "{output:?}");
    };
    let names: Vec<String> = (0..20).map(|number| format!("{number}.toml\n")).collect();
    render(&names.concat(), &["-o", "whole"]);
    let whole = tree(&folder.path("whole"));
    assert_eq!(whole.len(), 40);
    for count in [1, 3, 7] {
        let mut all = BTreeMap::new();
        for number in 1..=count {
            // The order of the list does not matter.
            let mut list = names.clone();
            list.rotate_left(number * 2);
            let (shard, out) = (format!("{number}/{count}"), format!("out{number}-{count}"));
            render(&list.concat(), &["-o", &out, "--shard", &shard]);
            // A part may be empty.
            std::fs::create_dir_all(folder.path(&out)).unwrap();
            for (name, bytes) in tree(&folder.path(&out)) {
                assert!(all.insert(name.clone(), bytes).is_none(), "{name} twice of {count}");
            }
        }
        assert!(all == whole, "{count} shards");
    }
}

#[test]
fn resuming_keeps_what_is_whole_and_makes_the_rest_again() {
    let folder = with_scenes(4);
    let brick = std::fs::read(resource("textures/brick.png")).unwrap();
    folder.write("wall.png", &brick);
    folder.write("wall.toml", "[[surface]]\ncontrol_points = \"default\"\ntexture = \"wall.png\"");
    let kept = |options: &[&str]| {
        let arguments = ["render", ".", "-o", "out", "--resume", "--samples", "1"];
        let output = folder.run(&[&arguments, &SMALL[..], options].concat());
        assert!(output.status.success(), "{output:?}");
        let said = text(&output.stdout);
        let names = said.lines().filter_map(|line| line.strip_prefix("kept out/"));
        let names = names.filter_map(|name| name.strip_suffix(".png"));
        names.map(ToOwned::to_owned).collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>()
    };
    let set = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    assert_eq!(kept(&[]), set(&[]));
    let whole = tree(&folder.path("out"));
    assert_eq!(kept(&[]), set(&["0", "1", "2", "3", "wall"]));
    assert_eq!(kept(&["--jobs", "1", "--backend", "egl"]), set(&["0", "1", "2", "3", "wall"]));
    // What a killed run leaves; a torn picture, one without a record, one that is gone, a changed texture.
    let out = |name: &str| folder.path("out").join(name);
    for name in [".3.png.abcdef.part", ".freeform/.3.png.json.abcdef.part"] {
        std::fs::write(out(name), "half").unwrap();
    }
    std::fs::write(out("0.png"), &whole["0.png"][..40]).unwrap();
    std::fs::remove_file(out(".freeform/1.png.json")).unwrap();
    std::fs::remove_file(out("2.png")).unwrap();
    assert_eq!(kept(&[]), set(&["3", "wall"]));
    assert!(tree(&folder.path("out")) == whole);
    image::RgbaImage::new(2, 2).save(folder.path("wall.png")).unwrap();
    assert_eq!(kept(&[]), set(&["0", "1", "2", "3"]));
    folder.write("wall.png", &brick);
    assert_eq!(kept(&[]), set(&["0", "1", "2", "3"]));
    assert!(tree(&folder.path("out")) == whole);
    // Other settings. A picture is replaced, not written into: another name of the old file keeps the old picture.
    std::fs::hard_link(out("0.png"), folder.path("old.png")).unwrap();
    assert_eq!(kept(&["--wireframe"]), set(&[]));
    assert!(std::fs::read(out("0.png")).unwrap() != whole["0.png"]);
    assert!(std::fs::read(folder.path("old.png")).unwrap() == whole["0.png"]);
    assert_eq!(kept(&["--wireframe"]).len(), 5);
    assert_eq!(kept(&["--light", "thesis"]), set(&[]));
}

/// What is missing only leaves out materials. The picture is made again when it is there.
#[test]
fn a_missing_material_file_fails_no_picture() {
    let folder = Folder::new();
    let mesh = std::fs::read_to_string(resource("meshes/icosahedron.obj")).unwrap();
    std::fs::create_dir(folder.path("in")).unwrap();
    folder.write("in/a.obj", format!("mtllib gone.mtl\nusemtl red\n{mesh}"));
    let run = || {
        let arguments = ["render", "in", "-o", "out", "--resume"];
        let output = folder.run(&[&arguments, &SMALL[..]].concat());
        assert!(output.status.success(), "{output:?}");
        let whole = std::fs::read(folder.path("out/a.png")).unwrap();
        (text(&output.stdout).lines().any(|line| line.starts_with("kept")), whole)
    };
    let (kept, without) = run();
    assert!(!kept);
    assert_eq!(run(), (true, without.clone()));
    folder.write("in/gone.mtl", "newmtl red\nKd 1 0 0\n");
    let (kept, with) = run();
    assert!(!kept && with != without);
}

#[test]
fn the_log_has_a_line_for_each_picture() {
    let folder = with_scenes(2);
    folder.write("bad.toml", "surface = []");
    let arguments = ["render", ".", "-o", "out", "--log", "log.jsonl", "--resume"];
    for (run, made) in [(1, "made"), (2, "kept")] {
        let output = folder.run(&[&arguments, &SMALL[..]].concat());
        assert_eq!(output.status.code(), Some(1));
        assert!(text(&output.stderr).contains("bad.toml:1:"), "{output:?}");
        assert!(text(&output.stderr).ends_with("1 of 3 pictures failed\n"), "{output:?}");
        let lines = log(&folder.path("log.jsonl"));
        assert_eq!(lines.len(), 3 * run);
        for (name, status) in [("0", made), ("1", made), ("bad", "failed")] {
            let input = format!("./{name}.toml");
            let line = lines[3 * (run - 1)..].iter().find(|line| line["input"] == input).unwrap();
            assert_eq!(line["output"], format!("out/{name}.png"));
            assert_eq!(line["status"], status);
            assert_eq!(line["error"].is_string(), status == "failed", "{line}");
            if status == "made" {
                let ms = |part: &str| line["ms"][part].as_f64().unwrap();
                assert!(["read", "upload", "draw", "write"].iter().all(|part| ms(part) > 0.0));
                assert!(line["triangles"].as_u64().unwrap() >= 2, "{line}");
                assert!(line["largest_bound"].as_f64().unwrap() <= 0.5, "{line}");
                #[cfg(target_os = "linux")]
                assert!(line["peak_memory"].as_u64().unwrap() > 10 << 20, "{line}");
            }
        }
    }
    assert!(!folder.path("out/bad.png").exists());
}

/// The helper that reads CAD files is replaced by the shell, so that a file says how long it takes.
fn with_slow_files(folder: &Folder, arguments: &[&str]) -> Command {
    let mut command = folder.command(arguments);
    command.env("FREEFORM_OCCT", "/bin/sh").stdin(Stdio::null());
    command
}

#[cfg(target_os = "linux")]
#[test]
fn a_picture_that_takes_too_long_is_ended_with_all_its_processes() {
    let folder = with_scenes(3);
    folder.write("1slow.step", "echo $$ > id; exec sleep 600");
    let arguments = ["render", ".", "-o", "out", "--jobs", "1", "--timeout", "2"];
    let output = with_slow_files(&folder, &[&arguments, &SMALL[..]].concat()).output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("1slow.step: it was not finished within 2 s"), "{said}");
    assert_eq!(pictures(&folder.path("out")), ["0.png", "1.png", "2.png"]);
    let id = std::fs::read_to_string(folder.path("id")).unwrap();
    assert!(is_gone(&id), "the helper lives on");
}

/// Whether a process ends soon.
#[cfg(target_os = "linux")]
fn is_gone(id: &str) -> bool {
    let place = Path::new("/proc").join(id.trim());
    // A process that nobody has waited for yet is a zombie.
    let ended = || {
        std::fs::read_to_string(place.join("stat"))
            .map_or(true, |stat| stat.rsplit(')').next().unwrap().starts_with(" Z"))
    };
    (0..200).any(|_| {
        std::thread::sleep(std::time::Duration::from_millis(20));
        ended()
    })
}

#[cfg(target_os = "linux")]
#[test]
fn a_worker_that_dies_costs_one_picture() {
    let folder = with_scenes(6);
    // The helper's parent is the worker.
    folder.write("3dies.step", "echo $$ > id; kill -KILL $PPID; exec sleep 600");
    let arguments = ["render", ".", "-o", "out", "--jobs", "2"];
    let output = with_slow_files(&folder, &[&arguments, &SMALL[..]].concat()).output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("3dies.step: the process that drew it was killed by signal 9"), "{said}");
    assert_eq!(pictures(&folder.path("out")).len(), 6);
    assert!(is_gone(&std::fs::read_to_string(folder.path("id")).unwrap()));
}

#[cfg(target_os = "linux")]
#[test]
fn nothing_lives_on_when_the_program_is_killed() {
    let folder = Folder::new();
    folder.write("slow.step", "echo $PPID > parent; echo $$ > id; exec sleep 600");
    let arguments = ["render", "slow.step", "-o", "out/", "--jobs", "1"];
    let mut program = with_slow_files(&folder, &arguments).spawn().unwrap();
    let id = loop {
        std::thread::sleep(std::time::Duration::from_millis(20));
        match std::fs::read_to_string(folder.path("id")) {
            Ok(id) if id.ends_with('\n') => break id,
            _ => assert!(program.try_wait().unwrap().is_none(), "it has ended"),
        }
    };
    program.kill().unwrap();
    program.wait().unwrap();
    let worker = std::fs::read_to_string(folder.path("parent")).unwrap();
    assert!(is_gone(&worker) && is_gone(&id));
}

#[test]
fn several_runs_into_one_folder_tear_nothing() {
    let folder = with_scenes(60);
    let run = |out: &str| {
        let arguments = [&["render", ".", "-o", out, "--jobs", "2"], &SMALL[..]].concat();
        let mut command = folder.command(&arguments);
        command.stdout(Stdio::piped()).spawn().unwrap()
    };
    assert!(run("alone").wait_with_output().unwrap().status.success());
    for program in [run("out"), run("out"), run("out"), run("out")] {
        let output = program.wait_with_output().unwrap();
        assert!(output.status.success(), "{output:?}");
        assert!(text(&output.stdout).contains("60 made, 0 kept, 0 failed"), "{output:?}");
    }
    assert!(tree(&folder.path("out")) == tree(&folder.path("alone")));
}

#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_number_of_pictures() {
    let folder = Folder::new();
    let count = if crate::harness::patches::is_long() { 10_000 } else { 600 };
    let hole = "trim = [{ circle = { center = [0.5, 0.5], radius = 0.2 } }]";
    let mesh = std::fs::read_to_string(resource("meshes/icosahedron.obj")).unwrap();
    for number in 0..count {
        let color = format!("color = [1, 0, {}]", (number % 100) as f64 / 100.0);
        let scene = match number % 4 {
            0 => format!("surface = [{{ control_points = \"default\", {color} }}]"),
            1 => format!("surface = [{{ control_points = \"default\", {color}, {hole} }}]"),
            2 => "surface = []".to_owned(),
            _ => {
                folder.write(&format!("{number}.obj"), &mesh);
                continue;
            }
        };
        folder.write(&format!("{number}.toml"), scene);
    }
    let arguments = ["render", ".", "-o", "out", "--jobs", "1", "--log", "log.jsonl"];
    let output = folder.run(&[&arguments, &SMALL[..]].concat());
    let failed = format!("{} of {count} pictures failed", count / 4);
    assert!(text(&output.stderr).contains(&failed), "{output:?}");
    let memory: Vec<u64> = log(&folder.path("log.jsonl"))
        .iter()
        .filter_map(|line| line["peak_memory"].as_u64())
        .collect();
    assert_eq!(memory.len(), count - count / 4);
    let (early, late) = (memory[75], *memory.last().unwrap());
    assert!(late <= early + early / 20, "from {early} to {late} bytes");
}

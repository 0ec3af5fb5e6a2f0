//! Many small pictures: a process for each, one worker, two workers: `cargo bench --bench pictures`.
//!
//! It prints medians of alternating measurements, and ratios with what they should be at least.

use std::hint::black_box;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

const ROUNDS: usize = 7;
/// The pictures of a measurement by workers, whose start is part of the time.
const COUNT: usize = 600;
/// The pictures of a measurement by a process for each.
const ALONE: usize = 20;

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let teapot = Path::new(env!("CARGO_MANIFEST_DIR")).join("resources/surfaces/teapot.bpt");
    let teapot = std::fs::read(teapot).expect("the teapot");
    std::fs::create_dir(folder.path().join("in")).expect("a folder");
    for half in ["halves/0", "halves/1"] {
        std::fs::create_dir_all(folder.path().join(half)).expect("a folder");
    }
    for number in 0..COUNT {
        for place in ["in".to_owned(), format!("halves/{}", number % 2)] {
            let scene = folder.path().join(format!("{place}/{number}.bpt"));
            std::fs::write(scene, &teapot).expect("a scene");
        }
    }
    let mut found = [const { Vec::new() }; 6];
    for _ in 0..ROUNDS {
        let times = [
            alone(folder.path()),
            workers(folder.path(), "1", None),
            // Drawn by one thread, as by each of two workers.
            workers(folder.path(), "1", Some("0")),
            workers(folder.path(), "2", None),
            two_programs(folder.path()),
            cores(),
        ];
        found.iter_mut().zip(times).for_each(|(found, rate)| found.push(rate));
    }
    let [alone, one, one_thread, two, apart, cores] = found.map(|mut rates| {
        rates.sort_by(f64::total_cmp);
        rates[ROUNDS / 2]
    });
    println!("the teapot, 256 x 256, pictures a second");
    println!("a process for each   {alone:8.1}");
    println!("--jobs 1             {one:8.1}");
    println!("--jobs 1, one thread {one_thread:8.1}");
    println!("--jobs 2             {two:8.1}");
    println!("two programs         {apart:8.1}");
    println!("--jobs 1 over a process for each: {:.1}", one / alone);
    println!("--jobs 2 over a process for each: {:.1} (at least 8)", two / alone);
    println!("--jobs 2 over --jobs 1: {:.2}", two / one);
    println!("--jobs 2 over one worker of one thread: {:.2} (at least 1.7)", two / one_thread);
    println!("two programs over one worker of one thread: {:.2}", apart / one_thread);
    println!("arithmetic on two cores over one: {cores:.2}");
}

fn program(folder: &Path, input: &str, output: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_freeform"));
    command.args(["render", input, "-o", output, "--resolution", "256x256"]).current_dir(folder);
    command
}

/// Pictures a second.
fn run(count: usize, calls: impl IntoIterator<Item = Command>) -> f64 {
    let start = Instant::now();
    for mut call in calls {
        assert!(call.output().expect("the program").status.success());
    }
    count as f64 / start.elapsed().as_secs_f64()
}

fn alone(folder: &Path) -> f64 {
    let calls = (0..ALONE).map(|number| program(folder, &format!("in/{number}.bpt"), "out.png"));
    run(ALONE, calls)
}

fn workers(folder: &Path, jobs: &str, threads: Option<&str>) -> f64 {
    let mut command = program(folder, "in", "out/");
    command.args(["--jobs", jobs]);
    command.envs(threads.map(|threads| ("LP_NUM_THREADS", threads)));
    run(COUNT, [command])
}

/// The same as two workers, but each is of a program of its own, and knows nothing of the other.
fn two_programs(folder: &Path) -> f64 {
    let start = Instant::now();
    let programs = ["0", "1"].map(|half| {
        let mut command = program(folder, &format!("halves/{half}"), "apart/");
        command.args(["--jobs", "1"]).env("LP_NUM_THREADS", "0").stdout(Stdio::null());
        command.spawn().expect("the program")
    });
    for mut program in programs {
        assert!(program.wait().expect("the program").success());
    }
    COUNT as f64 / start.elapsed().as_secs_f64()
}

/// How many times as much two threads do as one, of what needs no memory: what the machine allows.
fn cores() -> f64 {
    let work = || {
        let sum = (0..200_000_000_u64).fold(1, |sum: u64, i| black_box(sum.wrapping_mul(i | 1)));
        black_box(sum);
    };
    let time = |threads: usize| {
        let start = Instant::now();
        std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
        start.elapsed().as_secs_f64()
    };
    2.0 * time(1) / time(2)
}

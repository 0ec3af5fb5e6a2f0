//! `freeform report`: its files, its figures, and what it says when it cannot work.
#![cfg(feature = "cli")]

mod common;

use common::program::{Folder, text};

/// The project's scenes.
const RESOURCES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/resources");

/// The rows of a section, as the program writes them.
fn rows(folder: &Folder, section: &str) -> Vec<serde_json::Value> {
    let arguments =
        ["report", "--quick", "--only", section, "--format", "json", "--resources", RESOURCES];
    let output = folder.run(&arguments);
    assert!(output.status.success(), "{output:?}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn a_page_and_its_data_are_written() {
    let folder = Folder::new();
    let arguments =
        ["report", "--quick", "--only", "triangles", "--out", "r", "--resources", RESOURCES];
    let output = folder.run(&arguments);
    assert!(output.status.success(), "{output:?}");
    let read = |name: &str| std::fs::read_to_string(folder.path(name)).expect("a file of text");
    let page = read("r/index.html");
    for words in
        ["<!DOCTYPE html>", "<svg role=\"img\"", "freeform report --out r --quick", "viewport"]
    {
        assert!(page.contains(words), "{words}");
    }
    // One file that needs nothing else, and no script.
    assert!(!page.contains("<script") && !page.contains("src=\"http"));
    let json: Vec<serde_json::Value> = serde_json::from_str(&read("r/report.json")).expect("JSON");
    let csv = read("r/triangles.csv");
    assert_eq!(csv.lines().count(), json.len() + 1);
    // The printed findings are those of the page.
    for line in text(&output.stdout).lines().filter(|line| line.starts_with("sphere")) {
        assert!(page.contains(line), "{line}");
    }
}

#[test]
fn no_pixel_is_wrong_by_exact_trims() {
    let rows = rows(&Folder::new(), "trimming");
    let of = |method: &str| rows.iter().filter(|row| row["method"] == method).collect::<Vec<_>>();
    let (exact, thesis) = (of("exact"), of("thesis"));
    assert!(exact.len() >= 12 && thesis.len() >= 20, "{} {}", exact.len(), thesis.len());
    for row in exact {
        assert_eq!(row["wrong_pixels"], 0, "{row}");
    }
    // The thesis' own figures of what goes wrong do go wrong.
    let wrong = thesis.iter().find(|row| row["scene"] == "figure 28").expect("figure 28");
    assert!(wrong["wrong_pixels"].as_u64() > Some(100), "{wrong}");
}

#[test]
fn a_folder_without_scenes_is_refused() {
    let folder = Folder::new();
    let output = folder.run(&["report", "--resources", "."]);
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    assert!(said.lines().count() == 1 && said.contains("--resources"), "{said}");
    let output = folder.run(&["report", "--only", "weather"]);
    assert_eq!(output.status.code(), Some(2));
}

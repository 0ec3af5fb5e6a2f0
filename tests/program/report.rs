//! `freeform report`: its files, its values, and its messages when it cannot work.

use std::path::Path;
use std::process::Command;

use freeform_surface::model::find_helper;

use crate::harness::program::{Folder, text};

/// The project's scenes.
const RESOURCES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/resources");

/// The rows of a section as the program writes them.
fn rows(folder: &Folder, section: &str) -> Vec<serde_json::Value> {
    rows_with(folder, section, &[])
}

/// The same, with further arguments.
fn rows_with(folder: &Folder, section: &str, more: &[&str]) -> Vec<serde_json::Value> {
    let arguments =
        ["report", "--quick", "--only", section, "--format", "json", "--resources", RESOURCES];
    let output = folder.run(&[&arguments, more].concat());
    assert!(output.status.success(), "{output:?}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn peers_are_measured_beside_exact_or_named_as_missing() {
    let rows = rows(&Folder::new(), "peers");
    let of = |method: &str| rows.iter().find(|row| row["method"] == method);
    let number = |row: &serde_json::Value, key: &str| row[key].as_f64().expect("a number");
    let (exact, floor) = (of("exact").expect("exact"), of("static mesh").expect("the floor"));
    assert!(number(exact, "max_error_px") <= 0.5, "{exact}");
    // The same triangles have the same error.
    assert_eq!(exact["triangles"], floor["triangles"]);
    assert!((number(exact, "max_error_px") - number(floor, "max_error_px")).abs() < 0.01);
    // libGLU stays within its tolerance on this model. Where it is not installed, the report says so.
    let glu = of("libGLU").expect("libGLU");
    if let Some(note) = glu["note"].as_str() {
        assert!(note.starts_with("not measured: ") && !everything_must_be_there(), "{note}");
    } else {
        assert!(
            number(glu, "triangles") > 10_000.0 && number(glu, "max_error_px") <= 0.75,
            "{glu}"
        );
        assert!(
            number(glu, "rms_error_px") > 0.01 && number(glu, "normal_error_deg") < 10.0,
            "{glu}"
        );
    }
}

#[test]
fn zebra_is_right_on_the_surface_and_wrong_on_its_mesh() {
    let rows = rows(&Folder::new(), "shading");
    for scene in ["teapot", "teapot, close-up"] {
        let share = |method: &str| {
            let of = |row: &&serde_json::Value| row["scene"] == scene && row["method"] == method;
            let row = rows.iter().find(of).expect(method);
            let [wrong, all] = ["wrong_pixels", "pixels"].map(|key| row[key].as_f64().unwrap());
            assert!(all > 10_000.0, "{row}");
            wrong / all
        };
        let (exact, mesh) = (share("exact"), share("static mesh"));
        assert!(exact <= 1e-3 && mesh > 5.0 * exact, "{scene}: {exact} {mesh}");
    }
}

/// A real STEP file, if it and the program that reads it are there.
fn step_file() -> Option<String> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/cad/io1-cm-214.stp");
    let is_there = Path::new(path).exists() && find_helper().is_some();
    if !is_there {
        eprintln!("left out: {path} or freeform-occt is absent");
    }
    is_there.then(|| path.to_owned())
}

#[test]
fn models_are_measured_from_the_file_to_the_picture_and_missing_others_are_named() {
    let file = step_file();
    let more = file.as_ref().map_or(Vec::new(), |file| vec!["--model", file]);
    let rows = rows_with(&Folder::new(), "models", &more);
    let find = |scene: &str, method: &str| {
        rows.iter().find(|row| row["scene"] == scene && row["method"] == method)
    };
    let number = |row: &serde_json::Value, key: &str| row[key].as_f64().expect("a number");
    let ms = |scene: &str, method: &str| number(find(scene, method).expect(method), "ms");
    for row in rows.iter().filter(|row| row["method"] == "exact") {
        assert!(number(row, "max_error_px") <= number(row, "tolerance"), "{row}");
        assert!(number(row, "ms") > 0.0 && number(row, "triangles") > 0.0, "{row}");
    }
    let at_half = |method: &str| {
        let mut of = rows.iter().filter(|row| row["method"] == method && row["scene"] == "flange");
        of.find(|row| row["tolerance"] == 0.5).expect("a row")
    };
    assert_eq!(at_half("exact")["triangles"], at_half("static mesh")["triangles"]);
    // A quick report measures first pictures once, so that the parts are those of the sum.
    let parts = ["reading", "projection", "upload", "shaders", "frame"];
    let sum: f64 = parts.iter().map(|part| ms("flange", &format!("first picture: {part}"))).sum();
    assert!((sum / ms("flange", "first picture") - 1.0).abs() < 1e-6, "{sum}");
    assert!(number(find("flange", "the program").expect("a row"), "memory") > 1e7);
    assert!(rows.iter().any(|row| row["scene"].as_str().unwrap_or("").ends_with(" faces")));
    for (other, key) in [("OCCT mesh", "triangles"), ("F3D", "ms")] {
        if let Some(missing) = find("all", other) {
            assert!(missing["note"].as_str().expect("a note").starts_with("not measured: "));
        } else {
            let row = find("io1-cm-214.stp", other).expect("a row");
            assert!(row["note"].is_null() && number(row, key) > 0.0, "{row}");
        }
    }
    if file.is_some() {
        let (own, other) = (ms("io1-cm-214.stp", "first picture from .ffm"), "first picture");
        assert!(own < ms("io1-cm-214.stp", other), "{own}");
    }
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
    // The page is one self-contained file without scripts.
    assert!(!page.contains("<script") && !page.contains("src=\"http"));
    let json: Vec<serde_json::Value> = serde_json::from_str(&read("r/report.json")).expect("JSON");
    let csv = read("r/triangles.csv");
    assert_eq!(csv.lines().count(), json.len() + 1);
    // Everything that is printed is also in the page.
    let said = text(&output.stdout);
    let advice: Vec<&str> = said.lines().filter(|line| !line.starts_with("wrote ")).collect();
    assert!(advice.len() == 1 && advice[0].starts_with("Meshes, nearest"), "{said}");
    assert!(page.contains(advice[0]), "{said}");
}

#[test]
fn no_pixel_is_wrong_by_exact_trims() {
    let rows = rows(&Folder::new(), "trimming");
    let of = |method: &str| rows.iter().filter(|row| row["method"] == method).collect::<Vec<_>>();
    let (exact, thesis) = (of("exact"), of("thesis"));
    assert!(exact.len() >= 12 && thesis.len() >= 20, "{} {}", exact.len(), thesis.len());
    // Figure 26 is figure 25 drawn as lines.
    for row in exact.iter().filter(|row| row["scene"] != "figure 26") {
        assert_eq!(row["wrong_pixels"], 0, "{row}");
    }
    // The figures in which the thesis shows its defects do have wrong pixels.
    let wrong = thesis.iter().find(|row| row["scene"] == "figure 28").expect("figure 28");
    assert!(wrong["wrong_pixels"].as_u64() > Some(100), "{wrong}");
}

/// Whether all tools that check the report must be installed (`sh setup.sh check`).
fn everything_must_be_there() -> bool {
    std::env::var_os("FREEFORM_TEST_REPORT").is_some()
}

/// A headless browser.
fn chromium() -> Option<&'static str> {
    let is_there = |name: &&str| Command::new(name).arg("--version").output().is_ok();
    let found = ["chromium", "chromium-browser", "google-chrome"].into_iter().find(is_there);
    assert!(found.is_some() || !everything_must_be_there(), "no Chromium");
    if found.is_none() {
        eprintln!("left out: no Chromium");
    }
    found
}

/// A browser's report on a page that is 400 pixels wide: the width after layout, the number of pictures and
/// plots without alternative text, and the number of all of them. Also returns the output of the console.
fn style(browser: &str, folder: &Folder, page: &str) -> ([usize; 3], String) {
    let source = page.replace('&', "&amp;").replace('"', "&quot;");
    let frame = format!(
        r#"<!DOCTYPE html><iframe id="page" width="400" height="800" srcdoc="{source}"></iframe>
        <output id="found"></output>
        <script>
            const page = document.getElementById("page");
            page.onload = () => {{
                const all = [...page.contentDocument.querySelectorAll("img, svg")];
                const named = all.filter(one => one.alt || one.getAttribute("aria-label"));
                const width = page.contentDocument.documentElement.scrollWidth;
                document.getElementById("found").textContent =
                    [width, all.length - named.length, all.length].join(" ");
            }};
        </script>"#
    );
    let path = folder.write("frame.html", frame);
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--v=0"])
        .args(["--virtual-time-budget=10000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", folder.path("profile").display()))
        .arg(format!("file://{}", path.display()))
        .output()
        .unwrap();
    let (page, log) = (text(&output.stdout), text(&output.stderr));
    let (_, found) = page.rsplit_once(r#"<output id="found">"#).unwrap_or_else(|| panic!("{log}"));
    let found = found.split_once('<').unwrap().0;
    let numbers: Vec<usize> = found.split(' ').map(|number| number.parse().unwrap()).collect();
    let console = log.lines().filter(|line| line.contains(":CONSOLE")).collect();
    (numbers.try_into().unwrap(), console)
}

#[test]
fn a_browser_shows_the_page_on_a_phone_without_complaint() {
    let Some(browser) = chromium() else { return };
    let folder = Folder::new();
    let output = folder.run(&["report", "--quick", "--out", "r", "--resources", RESOURCES]);
    assert!(output.status.success(), "{output:?}");
    let page = std::fs::read_to_string(folder.path("r/index.html")).unwrap();
    let ([width, unnamed, pictures], console) = style(browser, &folder, &page);
    assert!(width <= 400 && pictures > 40, "{width} pixels wide, {pictures} pictures");
    assert_eq!((unnamed, console.as_str()), (0, ""));
    // This check itself must notice faults.
    let bad = r#"<p style="width: 500px">a<img src="data:,"><script>console.error("bad")</script>"#;
    let ([width, unnamed, _], console) = style(browser, &folder, bad);
    assert!(width > 500 && unnamed == 1 && console.contains("bad"), "{width} {unnamed} {console}");
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

//! Checks `ARCHITECTURE.md` and other documents against the code: the floors of the rooms (the layers of the
//! modules), and the paths of files.

use std::collections::{HashMap, HashSet};
use std::path::Path;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The floors in the tables of `ARCHITECTURE.md`, library and program.
fn floors() -> Vec<HashMap<String, u32>> {
    let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let mut tables: Vec<HashMap<String, u32>> = Vec::new();
    let mut is_table = false;
    for line in text.lines() {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        if cells[0] == "floor" {
            tables.push(HashMap::new());
            is_table = true;
        } else if let (true, Ok(floor)) = (is_table, cells[0].parse()) {
            let rooms = cells[1].split('`').skip(1).step_by(2);
            tables.last_mut().unwrap().extend(rooms.map(|room| (room.to_owned(), floor)));
        } else if !line.starts_with("|--") {
            is_table = false;
        }
    }
    tables
}

/// All source files, by their paths in the folder without `.rs`.
fn files(folder: &Path, within: &str, found: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        let name = if within.is_empty() { name.to_owned() } else { format!("{within}/{name}") };
        if path.is_dir() {
            files(&path, &name, found);
        } else {
            found.push((name, std::fs::read_to_string(&path).unwrap()));
        }
    }
}

/// The room of a table that a path belongs to: the one of its file, or of its folder.
fn room<'a>(rooms: &'a HashMap<String, u32>, path: &str) -> Option<&'a str> {
    let mut names = path.split('/');
    let first = names.next()?;
    let two = names.next().map(|second| format!("{first}/{second}"));
    let known = |name: &str| rooms.get_key_value(name).map(|(name, _)| name.as_str());
    two.and_then(|two| known(&two)).or_else(|| known(first))
}

/// The first two names after `crate::` of a text, as a path.
fn imports(text: &str) -> impl Iterator<Item = String> {
    text.split("crate::").skip(1).map(|rest| {
        let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
        let names = rest[..end.unwrap_or(rest.len())].split("::").take(2);
        names.collect::<Vec<_>>().join("/")
    })
}

#[test]
fn every_import_goes_down() {
    let floors = floors();
    let [library, program] = floors.as_slice() else { panic!("two tables: {floors:?}") };
    let mut found = Vec::new();
    files(&root().join("src"), "", &mut found);
    assert!(found.len() > 100, "{}", found.len());
    let mut wrong = Vec::new();
    let mut checked = 0;
    let mut seen = HashSet::new();
    for (path, text) in &found {
        // `thesis.rs` has no floor of its own: it declares its files.
        if path == "thesis" {
            continue;
        }
        let in_a_table =
            [library, program].into_iter().find_map(|rooms| Some((rooms, room(rooms, path)?)));
        let Some((rooms, own)) = in_a_table else {
            wrong.push(format!("{path} has no floor"));
            continue;
        };
        seen.insert(own);
        for import in imports(text) {
            let below = room(rooms, &import);
            if below == Some(own) {
                continue;
            }
            checked += 1;
            if below.is_none_or(|below| rooms[below] >= rooms[own]) {
                wrong.push(format!("{path} uses {import}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(checked > 200, "{checked}");
    for room in library.keys().chain(program.keys()) {
        assert!(seen.contains(room.as_str()), "{room} is no room");
    }
}

/// Words of a text that look like paths of files of the project.
fn paths(text: &str) -> impl Iterator<Item = &str> {
    const FOLDERS: [&str; 7] =
        ["src/", "glsl/", "tests/", "docs/", "resources/", "benches/", "examples/"];
    text.split(|c: char| !(c.is_alphanumeric() || "./_-".contains(c)))
        .map(|word| word.trim_end_matches('.').trim_start_matches("./"))
        .filter(|word| FOLDERS.iter().any(|folder| word.starts_with(folder)))
        .filter(|word| word.rsplit('/').next().is_some_and(|name| name.contains('.')))
}

#[test]
fn every_file_that_a_document_or_a_comment_names_is_there() {
    let mut texts = Vec::new();
    for folder in ["src", "glsl", "benches", "examples"] {
        files(&root().join(folder), "", &mut texts);
    }
    let mut documents = 0;
    for folder in ["", "docs", "resources"] {
        for entry in std::fs::read_dir(root().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "md") {
                let text = std::fs::read_to_string(&path).unwrap();
                texts.push((path.display().to_string(), text));
                documents += 1;
            }
        }
    }
    assert!(documents >= 6, "{documents}");
    let named: Vec<(&str, &str)> = texts
        .iter()
        .flat_map(|(place, text)| paths(text).map(move |path| (place.as_str(), path)))
        .collect();
    let missing: Vec<_> = named.iter().filter(|(_, path)| !root().join(path).exists()).collect();
    assert!(missing.is_empty(), "{missing:#?}");
    assert!(named.len() > 40, "{}", named.len());
}

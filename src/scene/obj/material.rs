//! Materials of OBJ files: the colours and pictures of `.mtl` files.
//!
//! The parser is our own: tobj 4.0.5 refuses a whole file because of one number that it cannot parse, and it treats
//! the options of a picture as part of the picture's name.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::scene::file::{line_of, read_bytes};
use crate::scene::{Image, Paint, load_texture};

/// Options of pictures, and the maximum number of arguments of each. Arguments that the format's specification puts
/// in brackets may be missing.
const OPTIONS: [(&str, usize); 13] = [
    ("-blendu", 1),
    ("-blendv", 1),
    ("-boost", 1),
    ("-bm", 1),
    ("-cc", 1),
    ("-clamp", 1),
    ("-imfchan", 1),
    ("-mm", 2),
    ("-o", 3),
    ("-s", 3),
    ("-t", 3),
    ("-texres", 1),
    ("-type", 1),
];
/// Statements that every exporter writes, for lighting that is not drawn here.
const COMMON: [&str; 11] =
    ["Ka", "Ks", "Ke", "Ns", "Ni", "Tf", "Pr", "Pm", "illum", "sharpness", "aniso"];

/// The materials that an OBJ file can use, by their names.
#[derive(Debug, Default)]
pub(super) struct Materials {
    paints: HashMap<String, Paint>,
    pictures: HashMap<PathBuf, Option<Arc<Image>>>,
    /// Every file that was read or looked for.
    pub(super) files: Vec<PathBuf>,
}

impl Materials {
    /// Reads a material library. Missing files and unknown statements only cause warnings.
    pub(super) fn read(&mut self, path: &Path) {
        if self.files.iter().any(|file| file == path) {
            return;
        }
        self.files.push(path.to_owned());
        let text = match read_bytes(path) {
            Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
            Err(error) => return log::warn!("{error}; its materials are left out"),
        };
        let mut name = None;
        let (mut ignored, mut common) = (BTreeSet::new(), BTreeSet::new());
        let start = text.as_ptr() as usize;
        for line in text.lines() {
            let number = || line_of(&text, line.as_ptr() as usize - start);
            let line = line.trim_start_matches(crate::scene::file::BYTE_ORDER_MARK).trim();
            let (statement, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            let rest = rest.trim();
            match statement {
                "" => {}
                comment if comment.starts_with('#') => {}
                "newmtl" => {
                    name = Some(rest.to_owned());
                    self.paints.insert(rest.to_owned(), Paint::default());
                }
                "Kd" => match (&name, color(rest)) {
                    (Some(name), Some(color)) => {
                        // A picture overrides the colour, regardless of their order.
                        let paint = self.paints.entry(name.clone()).or_default();
                        if matches!(paint, Paint::Color(_)) {
                            *paint = Paint::Color(color);
                        }
                    }
                    _ => log::warn!(
                        "{}:{}: Kd {rest}: expected three numbers from 0 to 1 after newmtl",
                        path.display(),
                        number()
                    ),
                },
                "map_Kd" => {
                    let (file, options) = picture_name(rest);
                    if options {
                        ignored.insert("options of map_Kd");
                    }
                    if let (Some(name), Some(image)) = (&name, self.picture(path, file)) {
                        self.paints.insert(name.clone(), Paint::Texture(image));
                    }
                }
                "d" | "Tr" => {
                    let opaque = if statement == "d" { 1.0 } else { 0.0 };
                    let value =
                        rest.split_whitespace().last().and_then(|word| word.parse::<f32>().ok());
                    if value != Some(opaque) {
                        ignored.insert(if statement == "d" { "d" } else { "Tr" });
                    }
                }
                other if COMMON.contains(&other) => {
                    common.insert(other);
                }
                other => {
                    ignored.insert(other);
                }
            }
        }
        let listed = |names: BTreeSet<&str>| names.into_iter().collect::<Vec<_>>().join(", ");
        if !ignored.is_empty() {
            log::warn!("{}: not drawn: {}", path.display(), listed(ignored));
        }
        if !common.is_empty() {
            log::info!("{}: not drawn: {}", path.display(), listed(common));
        }
    }

    /// A picture beside a material library; each picture is read once.
    fn picture(&mut self, library: &Path, name: &str) -> Option<Arc<Image>> {
        let path = beside(library, name);
        if !self.pictures.contains_key(&path) {
            self.files.push(path.clone());
            let image = load_texture(&path)
                .inspect_err(|error| log::warn!("{error}; the material has its color"));
            self.pictures.insert(path.clone(), image.ok().map(Arc::new));
        }
        self.pictures[&path].clone()
    }

    /// The paint of a material's name; `None` if no library has it.
    pub(super) fn paint(&self, name: &str) -> Option<&Paint> {
        self.paints.get(name)
    }
}

/// The path of a file that another file names, also with the separators of Windows.
pub(super) fn beside(file: &Path, name: &str) -> PathBuf {
    file.parent().unwrap_or_else(|| Path::new("")).join(name.replace('\\', "/"))
}

fn color(text: &str) -> Option<[f32; 3]> {
    let mut numbers = text.split_whitespace().map(|word| word.parse::<f32>().ok());
    let red = numbers.next()??;
    // A single number is a grey value.
    let color = match (numbers.next(), numbers.next()) {
        (None, _) => [red; 3],
        (green, blue) => [red, green??, blue??],
    };
    color.iter().all(|value| (0.0..=1.0).contains(value)).then_some(color)
}

/// The name of a picture's file without the options before it, and whether there are any options.
fn picture_name(text: &str) -> (&str, bool) {
    let mut rest = text;
    let mut options = false;
    loop {
        let (word, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        let Some((_, max)) = OPTIONS.iter().find(|(option, _)| *option == word) else {
            return (rest, options);
        };
        options = true;
        rest = after.trim_start();
        for argument in 0..*max {
            let (word, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            // The first argument may be a word; arguments that may be missing are numbers.
            if after.is_empty() || argument > 0 && word.parse::<f32>().is_err() {
                break;
            }
            rest = after.trim_start();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_pictures_stand_after_their_options() {
        for (text, name, options) in [
            ("a b.png", "a b.png", false),
            ("-s 2 2 1 a.png", "a.png", true),
            ("-s 2 a b.png", "a b.png", true),
            ("-clamp on -o 0.5 0 x.png", "x.png", true),
            ("-bm 0.3 dir\\x.png", "dir\\x.png", true),
            ("-strange x.png", "-strange x.png", false),
            ("", "", false),
        ] {
            assert_eq!(picture_name(text), (name, options), "{text}");
        }
    }

    #[test]
    fn colors_have_three_numbers_or_one() {
        assert_eq!(color("0.5 0.25 1"), Some([0.5, 0.25, 1.0]));
        assert_eq!(color("0.5"), Some([0.5; 3]));
        for text in ["", "0.5 0.5", "2 0 0", "nan 0 0", "spectral x.rfl", "0 0 -1"] {
            assert_eq!(color(text), None, "{text}");
        }
    }
}

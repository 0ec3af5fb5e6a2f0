//! The CAD models of a scene, with the colours of single faces and those that are hidden.

use glam::DMat4;
use toml::Spanned;

use super::{Builder, placed, unit_range};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::scene::tables::{FaceColorTable, ModelTable};
use crate::scene::{CadModel, Paint, Surface};

impl Builder<'_> {
    /// A CAD model, which is the scene's model `number`, and its faces.
    pub(super) fn model(
        &mut self,
        table: Spanned<ModelTable>,
        number: usize,
    ) -> Result<(CadModel, Vec<Surface>)> {
        let start = table.span().start;
        let ModelTable { file, color, hide, colors, translate, rotate_degrees, scale, matrix } =
            table.into_inner();
        let path = self.beside_scene(file.get_ref());
        let color = color.map(|color| self.check(color, |rgb| unit_range("color", rgb)));
        let color = color.transpose()?;
        let transform: DMat4 = placed(translate, rotate_degrees, scale, matrix)
            .map_err(|error| self.at(start, error))?;
        let (model, mut faces) = self.check(file, |_| {
            CadModel::new(Model::load(&path, self.options)?, &path, number, transform, color)
        })?;
        let count = model.model.instances()?.len();
        for FaceColorTable { face, color } in colors {
            let face = self.check(face, |face| checked(face, count))?;
            let color = self.check(color, |rgb| unit_range("color", rgb))?;
            if let Some(surface) = in_place(&mut faces, face) {
                surface.paint = Paint::Color(color);
            }
        }
        for face in hide {
            let face = self.check(face, |face| checked(face, count))?;
            if let Some(surface) = in_place(&mut faces, face) {
                surface.hidden = true;
            }
        }
        self.from_files += faces.len();
        self.files.push(path);
        Ok((model, faces))
    }
}

/// Checks the number of a face among the faces in all places.
fn checked(face: usize, count: usize) -> Result<usize> {
    if face < count {
        return Ok(face);
    }
    Err(Error::invalid("number of a face", face, format!("0 to {}", count - 1)))
}

/// The surface of a face, by its number among the faces in all places. `None` if the face is left out.
fn in_place(faces: &mut [Surface], instance: usize) -> Option<&mut Surface> {
    // Faces are in the order of their places.
    let number = |surface: &Surface| surface.face.map(|face| face.instance);
    let found = faces.binary_search_by_key(&Some(instance), number).ok()?;
    faces.get_mut(found)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::Scene;

    fn parse(table: &str) -> Result<Scene> {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("resources/models").join("scene.toml");
        Scene::from_toml(&format!("\n[[model]]\nfile = \"assembly.ffm\"\n{table}\n"), &path)
    }

    #[test]
    fn faces_are_coloured_and_hidden_in_their_places() {
        let plain = parse("").unwrap();
        let last = plain.surfaces.len() - 1;
        let text = format!(
            "color = [0.5, 0.5, 0.5]\nhide = [0, {last}, 0]\ncolors = [{{ face = {last}, color = [1.0, 0.0, 0.0] }}]"
        );
        let scene = parse(&text).unwrap();
        for (number, surface) in scene.surfaces.iter().enumerate() {
            assert_eq!(surface.hidden, number == 0 || number == last);
            let rgb = if number == last { [1.0, 0.0, 0.0] } else { [0.5; 3] };
            assert_eq!(surface.paint, Paint::Color(rgb), "{number}");
        }
        // Hidden faces do not count for the camera.
        let all = format!("hide = {:?}", (1..=last).collect::<Vec<_>>());
        assert_ne!(parse(&all).unwrap().framed(1.0), plain.framed(1.0));
    }

    #[test]
    fn errors_name_the_line() {
        for (table, line, word) in [
            ("hide = [\n1,\n99999]", 6, "number of a face"),
            ("hide = [-1]", 4, "-1"),
            ("hide = true", 4, "sequence"),
            (
                "colors = [{ face = 1, color = [0, 0, 0] },\n{ face = 1, color = [0, 2, 0] }]",
                5,
                "color",
            ),
            ("colors = [{ face = 99999, color = [0, 0, 0] }]", 4, "number of a face"),
            ("colors = [{ face = 1 }]", 4, "color"),
            ("colors = [{ face = 1, color = [0, 0, 0], hide = true }]", 4, "hide"),
        ] {
            let error = parse(table).unwrap_err().to_string();
            assert!(error.contains(&format!("scene.toml:{line}: ")), "{table}: {error}");
            assert!(error.contains(word), "{table}: {error}");
        }
    }
}

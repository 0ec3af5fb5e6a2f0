//! The statements of an OBJ file, line by line.

use std::collections::HashMap;
use std::io::{BufRead, Read as _};
use std::path::Path;

use glam::{DVec2, DVec3};

use super::freeform::FreeForm;
use super::{Run, Surface, counted, polygon};
use crate::bezier::MAX_COORDINATE;
use crate::error::{Error, Result, shortened};
use crate::mesh::{Corner, Mesh};
use crate::scene::file::unreadable;

/// The maximum length of a line in bytes, including its continuation lines: a face of some ten thousand corners.
pub(super) const MAX_LINE: usize = 1 << 20;

/// Everything that was read so far.
#[derive(Default)]
pub(super) struct Obj {
    pub(super) positions: Vec<DVec3>,
    /// Colours of positions, from 0 to 1; empty if no position has a colour.
    pub(super) colors: Vec<[f32; 3]>,
    pub(super) normals: Vec<DVec3>,
    pub(super) coordinates: Vec<DVec2>,
    pub(super) triangles: Vec<[Corner; 3]>,
    /// Names of material libraries, and of the materials that are used.
    pub(super) libraries: Vec<String>,
    pub(super) material_names: Vec<String>,
    /// Which triangles have which material; empty if no face has a material.
    pub(super) runs: Vec<Run>,
    /// Weights of positions; empty if no position has a weight.
    weights: Vec<f64>,
    free_form: FreeForm,
    /// The current material, which new faces get.
    material: u32,
    numbers_of_materials: HashMap<String, u32>,
    /// Faces that refer to elements further down in the file.
    late: Vec<LateFace>,
    /// The numbers of elements that are not drawn.
    lines: usize,
    points: usize,
}

struct LateFace {
    line: usize,
    material: u32,
    /// Indices from 0.
    corners: Vec<Corner>,
}

impl Obj {
    /// Reads all statements.
    pub(super) fn read(mut text: impl BufRead, path: &Path) -> Result<Self> {
        let mut obj = Self::default();
        let (mut line, mut number) = (Vec::new(), 0);
        loop {
            let first = number + 1;
            let fail = |message| Error::Scene { path: path.to_owned(), line: first, message };
            line.clear();
            loop {
                let before = line.len();
                (&mut text)
                    .take((MAX_LINE + 1 - before) as u64)
                    .read_until(b'\n', &mut line)
                    .map_err(|error| unreadable(path, error))?;
                if line.len() > MAX_LINE {
                    return Err(fail(format!("the line is longer than {MAX_LINE} bytes")));
                }
                number += usize::from(line.len() > before);
                if line.len() == before || !goes_on(&mut line, before) {
                    break;
                }
            }
            if line.is_empty() && number < first {
                break;
            }
            if first == 1 {
                skip_mark(&mut line).map_err(fail)?;
            }
            obj.statement(&String::from_utf8_lossy(&line), first).map_err(fail)?;
        }
        obj.finish().map_err(|(line, message)| Error::Scene {
            path: path.into(),
            line,
            message,
        })?;
        let left_out = obj.free_form.left_out();
        if !left_out.is_empty() {
            log::warn!("{}: {} left out", path.display(), left_out.join(", "));
        }
        Ok(obj)
    }

    /// Reads a line; the error is a message.
    fn statement(&mut self, line: &str, number: usize) -> Result<(), String> {
        let line = line.split('#').next().unwrap_or_default().trim();
        let mut words = line.split_ascii_whitespace();
        let Some(name) = words.next() else { return Ok(()) };
        match name {
            "v" => self.position(words)?,
            "vn" => self.normals.push(DVec3::from_array(numbers("normal", words, 3)?)),
            "vt" => {
                // The second number may be missing, and a third may follow.
                let [u] = numbers("texture coordinate", words.clone(), 3)?;
                let v = words.nth(1).map_or(Ok(0.0), finite)?;
                self.coordinates.push(DVec2::new(u, v));
            }
            // Version 2 of the format called it "fo".
            "f" | "fo" => self.face(words, number)?,
            "l" => self.lines += 1,
            "p" => self.points += words.count().max(1),
            "mtllib" => self.libraries.extend(libraries(after(line, name))),
            "usemtl" => self.use_material(after(line, name)),
            _ => {
                self.free_form.statement(name, &mut words, self.positions.len(), number)?;
            }
        }
        Ok(())
    }

    fn position<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), String> {
        let mut values = [0.0; 7];
        let mut count = 0;
        for word in words {
            let value = finite(word)?;
            if let Some(place) = values.get_mut(count) {
                *place = value;
            }
            count += 1;
        }
        let [x, y, z, fourth, ..] = values;
        let position = DVec3::new(x, y, z);
        if !(3..=7).contains(&count) {
            return Err(format!("the position has {count} numbers; expected 3"));
        }
        if position.abs().max_element() > MAX_COORDINATE {
            return Err(format!("the position is {position}; expected at most 1e15"));
        }
        if count == 4 {
            self.weights.resize(self.positions.len(), 1.0);
            self.weights.push(fourth);
        }
        // Red, green and blue follow, and optionally the opacity.
        if count >= 6 {
            self.colors.resize(self.positions.len(), [1.0; 3]);
            self.colors.push([values[3], values[4], values[5]].map(|value| value as f32));
        }
        self.positions.push(position);
        Ok(())
    }

    fn use_material(&mut self, name: &str) {
        let next = self.material_names.len() as u32;
        let names = &mut self.material_names;
        self.material = *self.numbers_of_materials.entry(name.to_owned()).or_insert_with(|| {
            names.push(name.to_owned());
            next
        });
    }

    fn face<'a>(
        &mut self,
        words: impl Iterator<Item = &'a str>,
        line: usize,
    ) -> Result<(), String> {
        let counts = self.counts();
        // Most faces are triangles and quadrilaterals.
        let mut corners = [Corner { position: 0, normal: 0, coordinate: 0 }; 4];
        let mut many = Vec::new();
        let mut count = 0;
        for word in words {
            let corner = corner(word, counts)?;
            match corners.get_mut(count) {
                Some(place) => *place = corner,
                None => {
                    if many.is_empty() {
                        many.extend_from_slice(&corners);
                    }
                    many.push(corner);
                }
            }
            count += 1;
        }
        let corners = if many.is_empty() { &corners[..count] } else { &many };
        if count < 3 {
            return Err(format!("the face has {count} corners; expected at least 3"));
        }
        if self.triangles.len() + self.late.len() + count - 2 > Mesh::MAX_TRIANGLES {
            return Err(format!("there are more than {} triangles", Mesh::MAX_TRIANGLES));
        }
        if corners.iter().all(|corner| missing(corner, counts).is_none()) {
            self.add_face(corners, self.material);
        } else {
            self.late.push(LateFace { line, material: self.material, corners: corners.to_vec() });
        }
        Ok(())
    }

    /// The numbers of positions, texture coordinates and normals read so far.
    fn counts(&self) -> [usize; 3] {
        [self.positions.len(), self.coordinates.len(), self.normals.len()]
    }

    fn add_face(&mut self, corners: &[Corner], material: u32) {
        let before = self.triangles.len();
        if let [a, b, c] = *corners {
            self.triangles.push([a, b, c]);
        } else {
            let position = |corner: &Corner| self.positions[corner.position as usize];
            let positions: Vec<DVec3> = corners.iter().map(position).collect();
            let triangles = polygon::triangles(&positions);
            self.triangles.extend(triangles.iter().map(|triangle| triangle.map(|i| corners[i])));
        }
        let count = self.triangles.len() - before;
        match self.runs.last_mut() {
            Some(run) if run.material == material => run.count += count,
            // Until a material is named, triangles have no material.
            None if self.material_names.is_empty() => {}
            _ => {
                if self.runs.is_empty() && before > 0 {
                    let without = self.material_names.len() as u32;
                    self.material_names.push(String::new());
                    self.runs.push(Run { material: without, first: 0, count: before });
                }
                self.runs.push(Run { material, first: before, count });
            }
        }
    }

    /// Adds the faces that refer to later elements, and scales the colours. Errors come with their line.
    fn finish(&mut self) -> Result<(), (usize, String)> {
        self.free_form.finish()?;
        let counts = self.counts();
        for LateFace { line, material, corners } in std::mem::take(&mut self.late) {
            if let Some(missing) = corners.iter().find_map(|corner| missing(corner, counts)) {
                return Err((line, missing));
            }
            self.add_face(&corners, material);
        }
        if !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), [1.0; 3]);
            // Some programs write colours as bytes.
            let max = self.colors.iter().flatten().copied().fold(1.0, f32::max);
            let whole = if max > 1.0 { 255.0 } else { 1.0 };
            for value in self.colors.iter_mut().flatten() {
                *value = (*value / whole).clamp(0.0, 1.0);
            }
        }
        Ok(())
    }

    /// The reason why there is no mesh, with the elements that were found instead.
    pub(super) fn without_faces(&self) -> String {
        let mut found = Vec::new();
        match self.free_form.patches() {
            0 => {}
            1 => found.push("1 Bézier patch".to_owned()),
            count => found.push(format!("{count} Bézier patches")),
        }
        for (count, what) in [
            (self.free_form.nurbs_surfaces(), "NURBS surface"),
            (self.lines, "line"),
            (self.points, "point"),
        ] {
            if count > 0 {
                found.push(counted(count, what));
            }
        }
        found.extend(self.free_form.left_out());
        if found.is_empty() && !self.positions.is_empty() {
            found.push(counted(self.positions.len(), "position"));
        }
        let found = match found.as_slice() {
            [] => return "it has no face; expected at least one statement f".into(),
            [one] => one.clone(),
            [all @ .., last] => format!("{} and {last}", all.join(", ")),
        };
        format!("it has {found}, no face; expected at least one statement f")
    }

    /// The free-form surfaces.
    pub(super) fn take_surfaces(&mut self, path: &Path) -> Result<Vec<Surface>> {
        self.free_form
            .take_surfaces(&self.positions, &self.weights)
            .map_err(|(line, message)| Error::Scene { path: path.to_owned(), line, message })
    }
}

/// Whether the text of a line from the offset `from` on continues on the next line. If so, the continuation mark and
/// the end of the line are replaced by a space.
fn goes_on(line: &mut Vec<u8>, from: usize) -> bool {
    let end = line.trim_ascii_end().len();
    let ends_in_mark = line[..end].last() == Some(&b'\\') && line.last() == Some(&b'\n');
    // In a comment, a backslash does not count: it may be the end of a Windows path.
    let goes_on = ends_in_mark && !line[from..].contains(&b'#');
    if goes_on {
        line.truncate(end - 1);
        line.push(b' ');
    }
    goes_on
}

/// Takes a byte order mark from the first line.
fn skip_mark(line: &mut Vec<u8>) -> Result<(), String> {
    if line.starts_with(b"\xef\xbb\xbf") {
        line.drain(..3);
    }
    if line.starts_with(b"\xff\xfe") || line.starts_with(b"\xfe\xff") {
        return Err("the text is UTF-16; expected UTF-8 or plain ASCII".into());
    }
    Ok(())
}

/// The arguments of a statement.
fn after<'a>(line: &'a str, name: &str) -> &'a str {
    line[name.len()..].trim()
}

/// The names of `mtllib`: several, or one with spaces.
fn libraries(text: &str) -> Vec<String> {
    let ends = text.to_ascii_lowercase().matches(".mtl").count();
    if ends > 1 {
        text.split_ascii_whitespace().map(str::to_owned).collect()
    } else {
        vec![text.trim_matches('"').to_owned()]
    }
}

/// A corner: `position`, `position/coordinate`, `position//normal` or
/// `position/coordinate/normal`, as indices from 0.
fn corner(word: &str, [positions, coordinates, normals]: [usize; 3]) -> Result<Corner, String> {
    let mut parts = word.split('/');
    let mut index = |what: &str, count: usize| match parts.next() {
        None | Some("") => Ok(Corner::NONE),
        Some(text) => index(text, what, count),
    };
    let corner = Corner {
        position: index("position", positions)?,
        coordinate: index("texture coordinate", coordinates)?,
        normal: index("normal", normals)?,
    };
    if corner.position == Corner::NONE || parts.next().is_some() {
        return Err(format!(
            "\"{}\" is no corner of a face; expected position/texture/normal",
            shortened(word)
        ));
    }
    Ok(corner)
}

/// Converts an index of the file to an index from 0. The file counts from 1, or backwards from −1, which is the last
/// element above.
pub(super) fn index(text: &str, what: &str, count: usize) -> Result<u32, String> {
    let number: i64 = text.parse().map_err(|_| format!("\"{}\" is no index", shortened(text)))?;
    let index = if number < 0 { count as i64 + number } else { number - 1 };
    match u32::try_from(index) {
        Ok(index) if index != Corner::NONE => Ok(index),
        _ => Err(out_of_range(number, what, count)),
    }
}

pub(super) fn out_of_range(number: i64, what: &str, count: usize) -> String {
    let expected = match count {
        0 => "but there is none".to_owned(),
        _ if number < 0 => format!("expected −1 to −{count} from the last above"),
        _ => format!("expected 1 to {count}"),
    };
    format!("index {number} of a {what}; {expected}")
}

/// The first index of a corner that exceeds the number of positions, texture coordinates or normals.
fn missing(corner: &Corner, [positions, coordinates, normals]: [usize; 3]) -> Option<String> {
    let missing = |index: u32, what: &str, count: usize| {
        let gone = index != Corner::NONE && index as usize >= count;
        gone.then(|| out_of_range(i64::from(index) + 1, what, count))
    };
    missing(corner.position, "position", positions)
        .or_else(|| missing(corner.coordinate, "texture coordinate", coordinates))
        .or_else(|| missing(corner.normal, "normal", normals))
}

/// The first `N` numbers of a line that has at most `max`.
fn numbers<'a, const N: usize>(
    what: &str,
    words: impl Iterator<Item = &'a str>,
    max: usize,
) -> Result<[f64; N], String> {
    let mut values = [0.0; N];
    let mut count = 0;
    for word in words {
        let value = finite(word)?;
        if let Some(place) = values.get_mut(count) {
            *place = value;
        }
        count += 1;
    }
    if (N..=max).contains(&count) {
        Ok(values)
    } else {
        Err(format!("the {what} has {count} numbers; expected {N}"))
    }
}

pub(super) fn finite(word: &str) -> Result<f64, String> {
    let number: Option<f64> = word.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("\"{}\" is no finite number", shortened(word)))
}

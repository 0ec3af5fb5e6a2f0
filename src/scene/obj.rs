//! Wavefront OBJ: positions, normals, texture coordinates and faces. Everything else, groups and
//! materials too, is skipped.
//!
//! The reader is our own because tobj 4.0.5 gives no line with its errors, takes NaN, index 0 of a
//! normal and faces of two, panics on some indices, reads lines of any length into memory, and
//! numbers positions group by group, which tears meshes of several groups apart.

use std::io::{BufRead, BufReader, Read as _, Write};
use std::path::Path;

use glam::{DVec2, DVec3};

use super::bpt::shortened;
use super::file::{check_is_file, unreadable};
use crate::bezier::MAX_COORDINATE;
use crate::mesh::{SharedBorders, weld};
use crate::{Corner, CreaseAngle, Error, Mesh, MeshModel, Result, Smoothing};

/// The longest line, in bytes: a face of some ten thousand corners.
const MAX_LINE: usize = 1 << 20;

impl Mesh {
    /// Reads a Wavefront OBJ file; see [`Mesh::read_obj`].
    ///
    /// # Errors
    /// A file that cannot be read or is no mesh; with the line.
    pub fn load_obj(path: &Path, crease: CreaseAngle) -> Result<Self> {
        check_is_file(path)?;
        let file = std::fs::File::open(path).map_err(|error| unreadable(path, error))?;
        Self::read_obj(BufReader::new(file), path, crease)
    }

    /// Reads Wavefront OBJ. `path` stands in the errors.
    ///
    /// Faces of more than three corners are cut into a fan around their first corner, which takes
    /// convex ones. Equal positions are made one; triangles that have the same position twice are left out.
    /// Missing normals are computed up to creases, as in [`Mesh::new`].
    ///
    /// # Errors
    /// With the line: a line of more than 1 MiB, a number that is none or not finite, a position
    /// beyond 1e15, a face of fewer than three corners, an index of 0 or of what does not stand
    /// above. Without: no triangles, too many of them.
    pub fn read_obj(mut text: impl BufRead, path: &Path, crease: CreaseAngle) -> Result<Self> {
        let mut obj = Obj::default();
        let mut line = Vec::new();
        for number in 1.. {
            let fail = |message| Error::Scene { path: path.to_owned(), line: number, message };
            line.clear();
            (&mut text)
                .take(MAX_LINE as u64 + 1)
                .read_until(b'\n', &mut line)
                .map_err(|error| unreadable(path, error))?;
            if line.is_empty() {
                break;
            }
            if line.len() > MAX_LINE {
                return Err(fail(format!("the line is longer than {MAX_LINE} bytes")));
            }
            obj.statement(&String::from_utf8_lossy(&line)).map_err(fail)?;
        }
        let Obj { positions, normals, coordinates, mut triangles } = obj;
        let dropped = weld(&positions, &mut triangles);
        if dropped > 0 {
            let path = path.display();
            log::info!("{path}: {dropped} triangles that have a position twice are left out");
        }
        Self::new(positions, normals, coordinates, triangles, crease)
            .map_err(|error| unreadable(path, error))
    }

    /// Writes Wavefront OBJ that reads back as the same numbers.
    ///
    /// # Errors
    /// What the writer says.
    pub fn write_obj(&self, out: &mut impl Write) -> std::io::Result<()> {
        for DVec3 { x, y, z } in self.positions() {
            writeln!(out, "v {x} {y} {z}")?;
        }
        for DVec2 { x, y } in self.coordinates() {
            writeln!(out, "vt {x} {y}")?;
        }
        for DVec3 { x, y, z } in self.normals() {
            writeln!(out, "vn {x} {y} {z}")?;
        }
        for corners in self.triangles() {
            out.write_all(b"f")?;
            for Corner { position, normal, coordinate } in corners {
                // Files count from 1.
                let (position, normal) = (position + 1, normal + 1);
                if *coordinate == Corner::NONE {
                    write!(out, " {position}//{normal}")?;
                } else {
                    write!(out, " {position}/{}/{normal}", coordinate + 1)?;
                }
            }
            out.write_all(b"\n")?;
        }
        Ok(())
    }
}

impl MeshModel {
    /// Reads a Wavefront OBJ file as [`Mesh::load_obj`] does.
    ///
    /// # Errors
    /// As [`Mesh::load_obj`].
    pub(super) fn load_obj(path: &Path, crease: CreaseAngle, smoothing: Smoothing) -> Result<Self> {
        let model = Self::new(Mesh::load_obj(path, crease)?, smoothing);
        let shared = model.mesh().shared_borders();
        if shared != SharedBorders::default() {
            log::info!("{}: {shared}; they are borders", path.display());
        }
        Ok(model)
    }
}

/// What was read so far.
#[derive(Default)]
struct Obj {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    coordinates: Vec<DVec2>,
    triangles: Vec<[Corner; 3]>,
}

impl Obj {
    /// Reads a line; what is wrong with it is the error.
    fn statement(&mut self, line: &str) -> Result<(), String> {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                // A weight or a colour may follow.
                let position = DVec3::from_array(numbers("position", words, 7)?);
                if position.abs().max_element() > MAX_COORDINATE {
                    return Err(format!("the position is {position}; expected at most 1e15"));
                }
                self.positions.push(position);
            }
            Some("vn") => self.normals.push(DVec3::from_array(numbers("normal", words, 3)?)),
            Some("vt") => {
                // The second number may be missing, a third may follow.
                let [u] = numbers("texture coordinate", words.clone(), 3)?;
                let v = words.nth(1).map_or(Ok(0.0), number)?;
                self.coordinates.push(DVec2::new(u, v));
            }
            Some("f") => self.face(words)?,
            _ => {}
        }
        Ok(())
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), String> {
        let mut corners = words.map(|word| self.corner(word));
        let too_few = |count| format!("the face has {count} corners; expected at least 3");
        let first = corners.next().ok_or_else(|| too_few(0))??;
        let mut before = corners.next().ok_or_else(|| too_few(1))??;
        let mut fan = Vec::new();
        for corner in corners {
            let corner = corner?;
            fan.push([first, before, corner]);
            before = corner;
        }
        if fan.is_empty() {
            return Err(too_few(2));
        }
        if self.triangles.len() + fan.len() > Mesh::MAX_TRIANGLES {
            return Err(format!("there are more than {} triangles", Mesh::MAX_TRIANGLES));
        }
        self.triangles.append(&mut fan);
        Ok(())
    }

    /// A corner: `position`, `position/coordinate`, `position//normal` or
    /// `position/coordinate/normal`.
    fn corner(&self, word: &str) -> Result<Corner, String> {
        let mut parts = word.split('/');
        let mut index = |what: &str, count: usize| match parts.next() {
            None | Some("") => Ok(Corner::NONE),
            Some(text) => index(text, what, count),
        };
        let corner = Corner {
            position: index("position", self.positions.len())?,
            coordinate: index("texture coordinate", self.coordinates.len())?,
            normal: index("normal", self.normals.len())?,
        };
        if corner.position == Corner::NONE || parts.next().is_some() {
            return Err(format!(
                "\"{}\" is no corner of a face; expected position/texture/normal",
                shortened(word)
            ));
        }
        Ok(corner)
    }
}

/// An index from 0 of an index from 1, or of one from −1 that counts backwards.
fn index(text: &str, what: &str, count: usize) -> Result<u32, String> {
    let number: i64 = text.parse().map_err(|_| format!("\"{}\" is no index", shortened(text)))?;
    let count = count as i64;
    let index = if number < 0 { count + number } else { number - 1 };
    if (0..count).contains(&index) {
        return Ok(index as u32);
    }
    let expected = match count {
        0 => "but none stands above".to_owned(),
        _ => format!("expected 1 to {count}, or −1 to −{count} from the last above"),
    };
    Err(format!("index {number} of a {what}; {expected}"))
}

/// The first numbers of a line that has so many at most.
fn numbers<'a, const N: usize>(
    what: &str,
    words: impl Iterator<Item = &'a str>,
    most: usize,
) -> Result<[f64; N], String> {
    let mut values = [0.0; N];
    let mut count = 0;
    for word in words {
        let value = number(word)?;
        if let Some(place) = values.get_mut(count) {
            *place = value;
        }
        count += 1;
    }
    if (N..=most).contains(&count) {
        Ok(values)
    } else {
        Err(format!("the {what} has {count} numbers; expected {N}"))
    }
}

fn number(word: &str) -> Result<f64, String> {
    let number: Option<f64> = word.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("\"{}\" is no finite number", shortened(word)))
}

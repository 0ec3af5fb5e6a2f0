//! CAD models in a scene: each face, in each place of its product, is a surface.

use std::fs::File;
use std::io::BufReader;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DMat4;

use super::file::{check_is_file, extension, unreadable};
use super::{LoadOptions, Paint, Surface};
use crate::error::Result;
use crate::model::{
    DrawnFace, ENDED, ImportOptions, Instance, Joint, Model, Outside, import, is_cad_file,
};

/// A CAD model in a scene. Its faces are surfaces of the scene, which name the model by its number.
#[derive(Debug, Clone, PartialEq)]
pub struct CadModel {
    /// The file that it was read from.
    pub file: PathBuf,
    /// The model.
    pub model: Arc<Model>,
    /// Model space to world space.
    pub transform: DMat4,
    /// The colour of all its faces, instead of their own.
    pub color: Option<[f32; 3]>,
    /// The numbers of the faces that are left out, and why.
    pub left_out: Vec<(usize, String)>,
    /// Where its faces meet.
    pub joints: Arc<[Joint]>,
    /// Which of its faces enclose solids.
    pub outsides: Arc<[Option<Outside>]>,
    /// Its faces as they were read, without a place; `None` for those that are left out.
    faces: Arc<[Option<Surface>]>,
}

/// The face of a CAD model that a surface is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaceOfModel {
    /// The number of the model in the scene.
    pub model: usize,
    /// The number of the face in the model.
    pub face: usize,
    /// The number of the face among the faces of all places of the model's products, [`Model::instances`].
    pub instance: usize,
}

/// The extension of the project's own format.
const EXTENSION: &str = "ffm";
/// The largest distance between edges that are taken for one, as a share of the model's diagonal.
const SEWN: f64 = 1e-6;
/// The colour of faces that have none.
const UNPAINTED: [f32; 3] = [0.7, 0.72, 0.75];

impl Model {
    /// Reads a model of the project's own format (`.ffm`), or by a program of its own a STEP, IGES or BREP file.
    ///
    /// # Errors
    /// A file that cannot be read or is no model; as [`import`].
    pub fn load(path: &Path, options: &LoadOptions) -> Result<Self> {
        Self::load_sewn(path, options).map(|(model, _)| model)
    }

    /// The same, and how many edges of a STEP, IGES or BREP file were joined to others that are the same in space
    /// ([`Model::sew`]).
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn load_sewn(path: &Path, options: &LoadOptions) -> Result<(Self, usize)> {
        check_is_file(path)?;
        let LoadOptions { import_limit: limit, progress, .. } = *options;
        let (model, joined) = if is_cad_file(path) {
            let import_options = ImportOptions { limit, ..ImportOptions::default() };
            let note = |share| progress.map_or(ControlFlow::Continue(()), |note| note(share));
            let mut model = Self::from_text(&import(path, &import_options, note)?, path)?;
            // IGES files have no edges that faces share, and other files may lack some.
            let joined = model.sew(SEWN * model.diagonal());
            log::info!("{}: {joined} edges were joined to others", path.display());
            (model, joined)
        } else {
            let file = File::open(path).map_err(|error| unreadable(path, error))?;
            (Self::read(BufReader::new(file), path)?, 0)
        };
        if progress.is_some_and(|note| note(1.0).is_break()) {
            return Err(unreadable(path, ENDED));
        }
        Ok((model, joined))
    }
}

impl CadModel {
    /// Whether a file's extension is that of a CAD model.
    #[must_use]
    pub fn is_file_of_one(path: &Path) -> bool {
        extension(path) == EXTENSION || is_cad_file(path)
    }

    /// A model of a file with number `number` in its scene, and its surfaces. Faces that cannot be drawn are left out.
    ///
    /// # Errors
    /// A model without any face that can be drawn.
    pub(super) fn new(
        model: Model,
        path: &Path,
        number: usize,
        transform: DMat4,
        color: Option<[f32; 3]>,
    ) -> Result<(Self, Vec<Surface>)> {
        let diagonal = model.diagonal();
        let faces = model.drawn_faces();
        let joints = model.joints(&faces, diagonal);
        let outsides = model.outsides(&faces, &joints).into();
        let mut left_out = Vec::new();
        let mut surface_of = |(number, face): (usize, Result<DrawnFace>)| match face {
            Ok(face) => {
                let mut surface = Surface::from_nurbs(face.surface);
                surface.trims = face.trims;
                Some(surface)
            }
            Err(reason) => {
                log::warn!("{}: face {number} is left out: {reason}", path.display());
                left_out.push((number, reason.to_string()));
                None
            }
        };
        let faces: Arc<[_]> = faces.into_iter().enumerate().map(&mut surface_of).collect();
        let mut surfaces = Vec::new();
        for (instance, Instance { face, placement, color: own }) in
            model.instances()?.into_iter().enumerate()
        {
            let Some(mut surface) = faces[face].clone() else { continue };
            surface.transform = transform * DMat4::from(placement);
            surface.paint = Paint::Color(color_of(color, own));
            surface.face = Some(FaceOfModel { model: number, face, instance });
            surfaces.push(surface);
        }
        if surfaces.is_empty() {
            let reason = left_out.first().map_or("it has no face".into(), |(face, reason)| {
                format!("none of its faces can be drawn; face {face}: {reason}")
            });
            return Err(unreadable(path, reason));
        }
        let model = Self {
            file: path.to_owned(),
            model: Arc::new(model),
            transform,
            color,
            left_out,
            joints: joints.into(),
            outsides,
            faces,
        };
        Ok((model, surfaces))
    }

    /// Whether a surface still has the points and trims of one of its faces.
    pub(crate) fn has_face(&self, face: usize, surface: &Surface) -> bool {
        let as_read = self.faces.get(face).and_then(Option::as_ref);
        as_read.is_some_and(|as_read| surface.has_shape_of(as_read))
    }

    /// The colours of the faces in all places as the file and the model's own colour give them.
    ///
    /// # Errors
    /// As [`Model::instances`].
    pub(super) fn colors(&self) -> Result<Vec<[f32; 3]>> {
        let instances = self.model.instances()?;
        Ok(instances.into_iter().map(|instance| color_of(self.color, instance.color)).collect())
    }
}

/// The colour of a face: that of the whole model, else its own, else a neutral one.
fn color_of(all: Option<[f32; 3]>, own: Option<[f32; 3]>) -> [f32; 3] {
    all.or(own).unwrap_or(UNPAINTED)
}

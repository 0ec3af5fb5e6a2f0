//! A whole scene uploaded to the driver.

mod captures;
mod multisample;

use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

pub use multisample::sample_offsets;

use crate::error::Result;
use crate::gpu::Texture;
use crate::model::Joint;
use crate::model::JointKind;
use crate::parallel;
use crate::programs::Output;
use crate::renderer::{
    ControlPoints, DrawList, Frame, LocalFrame, PatchShapes, PreparedMesh, PreparedSurface,
    RaisedPatches, Renderer, Solids, Strokes, SurfaceJoint,
};
use crate::scene::{
    Analysis, CadModel, FaceOfModel, Method, Paint, Scene, Surface, first_alike, joined,
};
use crate::tessellation::{EdgeSource, EdgeTable, FrameStats, Raised, raised};

/// A scene uploaded to the driver, ready to be drawn from any viewpoint.
#[derive(Debug)]
pub struct PreparedScene {
    surfaces: Vec<PreparedSurface>,
    meshes: Vec<PreparedMesh>,
    draw_list: DrawList,
    strokes: Strokes,
    stats: FrameStats,
}

impl PreparedScene {
    /// Uploads the surfaces and meshes of a scene. A texture or colour that several of them share is uploaded once.
    ///
    /// # Errors
    /// Trims or transforms out of range, a texture that the driver cannot hold, or no memory.
    pub fn new(renderer: &Renderer, scene: &Scene) -> Result<Self> {
        let gl = renderer.gl();
        let mut textures: Vec<(&Paint, bool, Rc<Texture>)> = Vec::new();
        let mut texture = |paint, repeats| {
            let known = textures
                .iter()
                .find(|(other, as_well, _)| *as_well == repeats && same(other, paint));
            if let Some((.., texture)) = known {
                return Ok(Rc::clone(texture));
            }
            let texture = paint.upload(gl)?;
            let texture = Rc::new(if repeats { texture.repeating() } else { texture });
            textures.push((paint, repeats, Rc::clone(&texture)));
            Result::Ok(texture)
        };
        let mut surfaces = Vec::with_capacity(scene.surfaces.len());
        let mut draw_list = DrawList::default();
        let mut strokes = Strokes::default();
        if !scene.surfaces.is_empty() {
            let Neighbours { table, centerings, raised } = neighbours(scene);
            let places = places_of_faces(scene);
            let models = scene.models.iter().map(|model| Arc::clone(&model.model)).collect();
            strokes = Strokes::new(all_joints(scene, &table, &places), models);
            let mut points = Vec::with_capacity(scene.surfaces.len());
            for ((surface, raised), centering) in scene.surfaces.iter().zip(&raised).zip(centerings)
            {
                points.push((surface.patch_points(), centering));
                points.extend(raised.iter().map(|raised| (&raised.points[..], centering)));
            }
            let mut uploaded = ControlPoints::upload(gl, &points)?.into_iter();
            let mut uploaded = || uploaded.next().expect("all points were uploaded");
            // Raised patches are like no others.
            let own = scene.surfaces.iter().zip(&raised);
            let alike = first_alike(own.map(|(own, raised)| raised.is_none().then_some(own)));
            let shapes = parallel::map_alike(&alike, |number| match &raised[number] {
                Some(raised) => PatchShapes::new(raised.degree, &raised.points),
                None => {
                    let surface = &scene.surfaces[number];
                    PatchShapes::new(surface.degree(), surface.patch_points())
                }
            });
            for ((surface, raised), shapes) in scene.surfaces.iter().zip(raised).zip(shapes) {
                let points = uploaded();
                let raised =
                    raised.map(|patches| RaisedPatches { patches, control_points: uploaded() });
                let texture = match &surface.paint {
                    Paint::Color(_) => None,
                    picture @ Paint::Texture(_) => Some(texture(picture, false)?),
                };
                surfaces.push(PreparedSurface::with_points(
                    surface.clone(),
                    texture,
                    points,
                    shapes,
                    raised,
                )?);
            }
            let solids = Solids::new(scene, &places);
            draw_list = DrawList::of_neighbours(table, &surfaces, strokes.close_gaps(), solids);
        }
        let mut meshes = Vec::with_capacity(scene.meshes.len());
        for model in &scene.meshes {
            meshes.push(PreparedMesh::new(gl, model, |paint| texture(paint, true))?);
        }
        Ok(Self { surfaces, meshes, draw_list, strokes, stats: FrameStats::default() })
    }

    fn draw_together(
        &mut self,
        renderer: &mut Renderer,
        frame: &Frame,
        output: Output,
    ) -> Result<()> {
        let (surfaces, draw_list) = (&mut self.surfaces, &mut self.draw_list);
        let mut stats = renderer.draw_surfaces(surfaces, draw_list, frame, output)?;
        self.strokes.update(renderer, surfaces, frame, draw_list)?;
        stats.draws += renderer.draw_strokes(&self.strokes, frame, output)?;
        for mesh in &mut self.meshes {
            mesh.update(renderer, frame)?;
            renderer.draw_mesh(mesh, frame, output, stats.patches, None)?;
            stats.add(&mesh.stats());
        }
        self.stats = stats;
        Ok(())
    }

    /// Statistics of the last frame drawn.
    pub const fn stats(&self) -> FrameStats {
        self.stats
    }

    /// The curvature at the end of the scale of an analysis, if it shows curvature: its own limit, or the one that suits
    /// the scene. The latter is found when the analysis is first drawn or prepared, and stays; without a surface there is
    /// none. It is 1, 2 or 5 times a power of ten,
    /// at least as large as that of 80 % of the area that is curved, from samples.
    #[must_use]
    pub fn curvature_limit(&self, analysis: &Analysis) -> Option<f64> {
        self.draw_list.curvature_limit(Some(*analysis))
    }

    /// The surfaces.
    #[must_use]
    pub fn surfaces(&self) -> &[PreparedSurface] {
        &self.surfaces
    }

    /// The surfaces, to be changed between frames.
    pub fn surfaces_mut(&mut self) -> &mut [PreparedSurface] {
        &mut self.surfaces
    }

    /// Builds and uploads the data that a frame needs, unless it is up to date. Drawing does this automatically;
    /// call this function to choose the moment.
    ///
    /// # Errors
    /// No memory, or trim loops that the frame's method does not support.
    pub fn prepare(&mut self, renderer: &Renderer, frame: &Frame) -> Result<()> {
        match frame.settings.method {
            Method::Thesis => self
                .surfaces
                .iter_mut()
                .try_for_each(|surface| surface.upload_trims(renderer.gl(), &frame.settings))?,
            Method::Exact => self.draw_list.update(renderer, &mut self.surfaces, frame)?,
        }
        self.strokes.update(renderer, &self.surfaces, frame, &self.draw_list)?;
        self.meshes.iter_mut().try_for_each(|mesh| mesh.update(renderer, frame))
    }

    /// Clears the bound framebuffer, draws the scene into it, and returns statistics.
    ///
    /// The framebuffer determines the number of samples per pixel. [`PreparedScene::picture`] uses the number in the
    /// settings instead.
    ///
    /// # Errors
    /// A shader that the driver rejects, no memory for changed trims, or trim loops that the frame's method does not
    /// support.
    pub fn draw(&mut self, renderer: &mut Renderer, frame: &Frame) -> Result<FrameStats> {
        renderer.clear(frame.settings.background);
        self.draw_together(renderer, frame, Output::Picture)?;
        if frame.settings.control_points {
            for surface in self.surfaces.iter_mut().filter(|surface| !surface.surface().hidden) {
                renderer.draw_control_points(surface, frame)?;
            }
        }
        Ok(self.stats)
    }
}

/// For each surface, the face of a CAD model that it is, as it was read: `None` if its points or trims were edited.
fn places_of_faces(scene: &Scene) -> Vec<Option<FaceOfModel>> {
    let as_read = |surface: &Surface| {
        let place = surface.face?;
        scene.models.get(place.model)?.has_face(place.face, surface).then_some(place)
    };
    scene.surfaces.iter().map(as_read).collect()
}

/// The joints of all faces of CAD models, and those of all other surfaces.
fn all_joints(
    scene: &Scene,
    table: &EdgeTable,
    places: &[Option<FaceOfModel>],
) -> Vec<SurfaceJoint> {
    let mut patches = 0;
    let firsts = scene.surfaces.iter().map(|surface| {
        patches += surface.patches().len();
        patches - surface.patches().len()
    });
    let firsts: Vec<usize> = firsts.collect();
    let mut found = joints_of_models(scene, places, &firsts);
    let (joints, patches): (Vec<Joint>, Vec<[usize; 2]>) =
        joined(&scene.surfaces, &table.open_sides())
            .into_iter()
            .map(|joined| (joined.joint, joined.patches))
            .unzip();
    let joints: Arc<[Joint]> = joints.into();
    found.extend(patches.into_iter().enumerate().map(|(number, patches)| {
        let surfaces = joints[number].faces;
        SurfaceJoint {
            joints: Arc::clone(&joints),
            number,
            surfaces,
            patches: [0, 1].map(|i| firsts[surfaces[i]] + patches[i]),
            closes_gap: true,
            model: None,
            made_for: Some(surfaces.map(|surface| scene.surfaces[surface].transform)),
        }
    }));
    found
}

/// The joints of all faces of CAD models. `places` are those of the surfaces, and `firsts` the numbers of their first
/// patches.
fn joints_of_models(
    scene: &Scene,
    places: &[Option<FaceOfModel>],
    firsts: &[usize],
) -> Vec<SurfaceJoint> {
    // The surface of each face in each place of its product.
    let mut surfaces: HashMap<(usize, usize), usize> = HashMap::new();
    let mut joints_of: HashMap<(usize, usize), Vec<usize>> = HashMap::new();
    for (number, place) in places.iter().enumerate() {
        if let Some(place) = place {
            surfaces.insert((place.model, place.instance), number);
        }
    }
    for (model, CadModel { joints, .. }) in scene.models.iter().enumerate() {
        for (number, joint) in joints.iter().enumerate() {
            joints_of.entry((model, joint.faces[0])).or_default().push(number);
        }
    }
    let mut found = Vec::new();
    for (number, place) in places.iter().enumerate() {
        let Some(FaceOfModel { model, face, instance }) = *place else { continue };
        for joint in joints_of.get(&(model, face)).into_iter().flatten() {
            let joints = &scene.models[model].joints;
            // The faces of a product are numbered alike in all of its places.
            let other = (instance + joints[*joint].faces[1]).checked_sub(face);
            let other = other.and_then(|other| surfaces.get(&(model, other)));
            found.extend(other.map(|other| SurfaceJoint {
                joints: Arc::clone(joints),
                number: *joint,
                surfaces: [number, *other],
                patches: [number, *other].map(|surface| firsts[surface]),
                closes_gap: joints[*joint].kind != JointKind::Open
                    && [number, *other].iter().all(|surface| scene.surfaces[*surface].join),
                model: Some(model),
                made_for: None,
            }));
        }
    }
    found
}

/// What the surfaces of a scene have to do with each other.
struct Neighbours {
    /// Of the patches that the exact method draws.
    table: EdgeTable,
    /// How each surface's control points are centred.
    centerings: Vec<LocalFrame>,
    /// For each surface, its patches at a higher degree, if a neighbour has one.
    raised: Vec<Option<Raised>>,
}

/// Finds which patches are neighbours, and how each surface's control points are centred. Each surface is centred
/// on its own, except that surfaces with shared edges use one centring, so that the shared control points stay
/// bit-identical.
fn neighbours(scene: &Scene) -> Neighbours {
    let mut transforms: HashMap<[u64; 16], u32> = HashMap::new();
    let mut sources: Vec<EdgeSource<'_>> = scene
        .surfaces
        .iter()
        .map(|surface| {
            let next = transforms.len() as u32;
            let bits = surface.transform.to_cols_array().map(f64::to_bits);
            let group = *transforms.entry(bits).or_insert(next);
            EdgeSource {
                degree: surface.degree(),
                points: surface.patch_points(),
                group,
                grid: surface.patch_grid(),
            }
        })
        .collect();
    let raised = raised(&sources);
    for (source, raised) in sources.iter_mut().zip(&raised) {
        if let Some(raised) = raised {
            (source.degree, source.points) = (raised.degree, &raised.points);
        }
    }
    let table = EdgeTable::new(&sources);
    let groups = table.connected(&sources);
    let mut members: HashMap<usize, Vec<&Surface>> = HashMap::new();
    for (surface, group) in scene.surfaces.iter().zip(&groups) {
        members.entry(*group).or_default().push(surface);
    }
    let centered: HashMap<usize, LocalFrame> = members
        .into_iter()
        .map(|(group, surfaces)| {
            (group, LocalFrame::of(surfaces.into_iter().flat_map(Surface::patch_points)))
        })
        .collect();
    let centerings = groups.iter().map(|group| centered[group]).collect();
    Neighbours { table, centerings, raised }
}

/// Whether two paints can share a texture: they have the same colour, or the same image in memory.
fn same(a: &Paint, b: &Paint) -> bool {
    match (a, b) {
        (Paint::Color(a), Paint::Color(b)) => a == b,
        (Paint::Texture(a), Paint::Texture(b)) => Arc::ptr_eq(a, b),
        _ => false,
    }
}

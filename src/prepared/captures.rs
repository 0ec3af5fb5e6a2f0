//! A scene as data instead of colours: AOVs of each pixel, and the triangles that the tessellator generates.

use glam::{DMat3, DVec2, DVec3};

use super::PreparedScene;
use crate::aov::Aovs;
use crate::error::Result;
use crate::gpu::FloatTarget;
use crate::programs::Output;
use crate::renderer::{DrawnVertex, Frame, PreparedSurface, Renderer};
use crate::scene::{Analysis, CurvatureKind, CurvatureLimit, Method, Normals, Surface};

impl PreparedScene {
    /// Renders the AOVs of a frame at pixel centres. Wireframe lines and control points are not drawn.
    ///
    /// # Errors
    /// As [`PreparedScene::draw`].
    pub fn aovs(
        &mut self,
        renderer: &mut Renderer,
        target: &FloatTarget,
        frame: &Frame,
    ) -> Result<Aovs> {
        let mut frame = *frame;
        frame.settings.wireframe = false;
        // The kind and the limit matter for colours only.
        let curvature = Analysis::Curvature {
            of: CurvatureKind::Gaussian,
            limit: CurvatureLimit::new(1.0).ok(),
        };
        frame.settings.analysis = target.has_curvature().then_some(curvature);
        target.bind_cleared();
        self.draw_together(renderer, &frame, Output::Aovs)?;
        let mut aovs = target.aovs();
        self.set_surfaces(&mut aovs, target.has_curvature());
        Ok(aovs)
    }

    /// Replaces u and v in the patches by those in the domains of NURBS surfaces, finds those of strokes, and sets the
    /// faces of CAD models. Pixels of strokes get the curvature too, if it is asked for.
    fn set_surfaces(&self, aovs: &mut Aovs, with_curvature: bool) {
        let surfaces = self.surfaces.iter().map(PreparedSurface::surface);
        // For each surface, the number of its first patch.
        let mut firsts = Vec::new();
        let mut next = 0;
        for surface in surfaces.clone() {
            firsts.push(next);
            next += surface.patches().len();
        }
        let has_strokes = self.strokes.closed_gaps();
        if !has_strokes && surfaces.clone().all(|surface| surface.nurbs().is_none()) {
            return;
        }
        let pixels = aovs.uv.iter_mut().zip(&mut aovs.patch_uv).zip(&mut aovs.face);
        let pixels = pixels.zip(&mut aovs.curvature).zip(&aovs.position);
        for ((((uv, own), face), curvature), position) in pixels {
            let is_stroke = uv[3] != 0.0 && uv[2] < 0.0;
            if is_stroke {
                self.find_patch(&firsts, uv, own, *position);
            }
            let patch = uv[2] as usize;
            if uv[3] == 0.0 || patch >= next {
                continue;
            }
            let number = firsts.partition_point(|first| *first <= patch) - 1;
            let surface = self.surfaces[number].surface();
            let [low, high] = surface.patch_domain(patch - firsts[number]);
            let place = low + DVec2::new(own[0].into(), own[1].into()) * (high - low);
            [uv[0], uv[1]] = place.as_vec2().to_array();
            if is_stroke && with_curvature {
                *curvature = curvature_at(surface, patch - firsts[number], place);
            }
            if let Some(of) = surface.face {
                *face = [of.face as f32, of.instance as f32, of.model as f32, 1.0];
            }
        }
    }

    /// Sets (u, v) and the patch of a pixel that a stroke draws to those of the point of its surface that is nearest to
    /// the drawn position. The stroke states a patch of its surface, for a NURBS surface any, and shares of its domain,
    /// which are roughly right.
    fn find_patch(
        &self,
        firsts: &[usize],
        uv: &mut [f32; 4],
        own: &mut [f32; 2],
        position: [f32; 4],
    ) {
        let patch = (-1.0 - uv[2]) as usize;
        let number = firsts.partition_point(|first| *first <= patch) - 1;
        let surface = self.surfaces[number].surface();
        let patch = patch - firsts[number];
        let [x, y, z, _] = position.map(f64::from);
        let point = surface.transform.inverse().transform_point3(DVec3::new(x, y, z));
        let [low, high] = surface.domain();
        let share = DVec2::new(own[0].into(), own[1].into());
        let place = surface.nearest(patch, point, low + share * (high - low));
        let patch = surface.patch_grid().map_or(patch, |grid| grid.patch_at(place));
        let [low, high] = surface.patch_domain(patch);
        uv[2] = (firsts[number] + patch) as f32;
        *own = ((place - low) / (high - low)).as_vec2().to_array();
    }

    /// Captures the vertices of all triangles that a frame of the exact method draws, three for each triangle. The
    /// triangles are not trimmed, and they include degenerate ones (without area). A framebuffer must be bound; its
    /// contents are not changed.
    ///
    /// # Errors
    /// As [`PreparedScene::draw`].
    pub fn triangles(
        &mut self,
        renderer: &mut Renderer,
        frame: &Frame,
    ) -> Result<Vec<DrawnVertex>> {
        let mut frame = *frame;
        frame.settings.method = Method::Exact;
        frame.settings.wireframe = false;
        frame.settings.analysis = None;
        // Per-pixel normals are not captured.
        frame.settings.normals = Normals::Vertex;
        let mut captured = Vec::new();
        let output = Output::Triangles;
        self.draw_list.update(renderer, &mut self.surfaces, &frame)?;
        renderer.draw_patches(
            &self.surfaces,
            &self.draw_list,
            &frame,
            output,
            Some(&mut captured),
        )?;
        let mut patches = self.draw_list.stats().patches;
        for mesh in &mut self.meshes {
            mesh.update(renderer, &frame)?;
            renderer.draw_mesh(mesh, &frame, output, patches, Some(&mut captured))?;
            patches += mesh.stats().patches;
        }
        Ok(captured)
    }
}

/// The AOV of a place in the domain of a surface; `patch` is a patch there.
fn curvature_at(surface: &Surface, patch: usize, place: DVec2) -> [f32; 4] {
    let here = surface.curved_at(patch, place).mapped(&DMat3::from_mat4(surface.transform));
    here.curvature().map_or([0.0, 0.0, 0.0, 1.0], |curvature| {
        [curvature.gaussian as f32, curvature.mean as f32, curvature.largest() as f32, 1.0]
    })
}

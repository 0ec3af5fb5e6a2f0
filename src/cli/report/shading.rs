//! Section 8: zebra on the surface and on a mesh of it, pixel by pixel against `f64`.

use crate::io::Result;
use freeform_surface::inspect::measure::{AnalysisErrors, measure_analysis};
use freeform_surface::inspect::programs::TrimFeatures;
use freeform_surface::inspect::{StaticMesh, StaticStyle};
use freeform_surface::{
    Analysis, AnalysisKind, Camera, Image, Lens, Method, Scene, Shading, Tessellation, Tolerance,
};

use super::bench::{Bench, Moving};
use super::peers::{STATIC, indexed};
use super::row::Row;
use super::{Figure, Section};

const SCENE: &str = "surfaces/teapot.bpt";
const EXACT: &str = "exact";
const LIT: &str = "exact, lit";
/// Half a pixel: of the frames, and of the mesh in the view that shows the whole scene.
const TOLERANCE: f64 = 0.5;
/// How much nearer the close-up is.
const CLOSER: f64 = 6.0;

pub(super) fn section(bench: &mut Bench) -> Result<Section> {
    let mut section = Section::new(
        "shading",
        "Shading: zebra on the surface and on its mesh",
        "Zebra stripes at each pixel, compared with f64. The mesh is made once, of the exact method's own triangles \
         within half a pixel of the view that shows everything, with the true normals at its vertices; between them \
         normals are interpolated, as in mesh viewers. (OCCT's own meshes are not shown: its helper gives figures only.) Pixels within a tenth of a pixel of a stripe's border, and those \
         beside the true silhouette, are not counted. The close-up shows the same mesh from nearer.",
    );
    let mut scene = bench.scene(SCENE)?;
    scene.settings.method = Method::Exact;
    scene.settings.samples = Default::default();
    scene.settings.tessellation = Tessellation::Within(Tolerance::new(TOLERANCE)?);
    scene.meshes.clear();
    scene.camera = Some(scene.framed(f64::from(bench.size.0) / f64::from(bench.size.1)));
    let whole = bench.frame(&scene).camera.view;
    let (vertices, indices) = indexed(&bench.triangles(&scene)?, whole);
    let mesh = StaticMesh::new(&bench.gl(), &vertices, &indices)?;
    let analysis = AnalysisKind::Zebra.with_defaults();
    let mut close = scene.clone();
    close.camera = scene.camera.map(closer).transpose()?;
    bench.begin(2);
    for (name, scene) in [("teapot", scene), ("teapot, close-up", close)] {
        bench.step(format!("shading: {name}"));
        measure(bench, &mut section, name, &scene, &mesh, analysis)?;
    }
    section.findings.extend(findings(&section.rows));
    Ok(section)
}

/// The camera, seeing a part that is smaller by a factor.
fn closer(camera: Camera) -> Result<Camera> {
    let lens = match camera.lens() {
        Lens::Perspective { fov_y_radians } => {
            Lens::Perspective { fov_y_radians: 2.0 * ((0.5 * fov_y_radians).tan() / CLOSER).atan() }
        }
        Lens::Orthographic { height } => Lens::Orthographic { height: height / CLOSER },
    };
    Ok(Camera::new(camera.eye(), camera.target(), camera.up(), lens)?)
}

fn measure(
    bench: &mut Bench,
    section: &mut Section,
    name: &str,
    scene: &Scene,
    mesh: &StaticMesh,
    analysis: Analysis,
) -> Result<()> {
    let mut shown = scene.clone();
    shown.settings.analysis = Some(analysis);
    let texture = shown.surfaces[0].paint.upload(&bench.gl())?;
    let style = StaticStyle {
        method: Method::Exact,
        shading: Shading::Unlit,
        trims: TrimFeatures::NONE,
        texture: &texture,
    };
    let frame = bench.frame(&shown);
    let judge = |aovs: &_, image: &Image| {
        measure_analysis(&shown, &frame.camera, (&analysis, 1.0), aovs, image)
    };
    let own_image = bench.picture(&shown)?;
    let (own_aovs, stats) = bench.numbers(&shown)?;
    let (own, true_image) = judge(&own_aovs, &own_image);
    let (mesh_image, mesh_aovs) = bench.static_picture(mesh, &style, &shown)?;
    let (of_mesh, _) = judge(&mesh_aovs, &mesh_image);

    let mut prepared = [bench.prepare(&shown)?, bench.prepare(scene)?];
    let mut cameras = [bench.frame(&shown), bench.frame(scene), frame].map(Moving::new);
    let background = scene.settings.background;
    let timings = bench.time_frames(cameras.len(), |renderer, way| {
        let frame = cameras[way].next();
        match prepared.get_mut(way) {
            Some(prepared) => Ok(prepared.draw(renderer, &frame).map(drop)?),
            None => {
                renderer.clear(background);
                Ok(renderer.draw_static(mesh, &style, &frame)?)
            }
        }
    })?;
    let command = bench.report_command("shading");
    let row = |method: &str, errors: Option<AnalysisErrors>, triangles: u64| Row {
        tolerance: (method != STATIC).then_some(TOLERANCE),
        triangles: Some(triangles),
        wrong_pixels: errors.map(|errors| errors.wrong),
        pixels: errors.map(|errors| errors.compared),
        command: command.clone(),
        ..Row::new("shading", name, method)
    };
    section.rows.extend([
        row(EXACT, Some(own), stats.triangles).timed(timings[0]),
        row(LIT, None, stats.triangles).timed(timings[1]),
        row(STATIC, Some(of_mesh), mesh.triangles() as u64).timed(timings[2]),
    ]);
    let figure = |what: &str, wrong: Option<usize>, image| {
        let wrong = wrong.map_or(String::new(), |wrong| format!(": {wrong} wrong pixels"));
        Figure { caption: format!("{name}, {what}{wrong}"), image }
    };
    section.figures.extend([
        figure("mesh", Some(of_mesh.wrong), mesh_image),
        figure(EXACT, Some(own.wrong), own_image),
        figure("in f64", None, true_image),
    ]);
    Ok(())
}

/// The share of wrong pixels of both, and what the shading costs.
fn findings(rows: &[Row]) -> Vec<String> {
    let scenes = rows.iter().filter(|row| row.method == EXACT);
    let told = scenes.filter_map(|own| {
        let of = |method: &str| {
            rows.iter().find(|row| row.scene == own.scene && row.method == method)
        };
        let share = |row: &Row| {
            Some(100.0 * row.wrong_pixels? as f64 / row.pixels.filter(|all| *all > 0)? as f64)
        };
        Some(format!(
            "{}: {:.3} % of the pixels are wrong on the surface, {:.2} % on the mesh. A frame takes {:.2} times as long \
             as a lit one.",
            own.scene,
            share(own)?,
            share(of(STATIC)?)?,
            own.ms? / of(LIT)?.ms?,
        ))
    });
    told.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_of_the_pixels_that_were_compared() {
        let row = |method: &str, wrong, pixels, ms| Row {
            wrong_pixels: wrong,
            pixels,
            ms: Some(ms),
            ..Row::new("shading", "teapot", method)
        };
        let rows = [
            row(EXACT, Some(1), Some(1000), 3.0),
            row(LIT, None, None, 2.0),
            row(STATIC, Some(40), Some(800), 1.0),
        ];
        assert_eq!(
            findings(&rows),
            [
                "teapot: 0.100 % of the pixels are wrong on the surface, 5.00 % on the mesh. A frame takes 1.50 times as \
              long as a lit one."
            ]
        );
        assert!(findings(&rows[..2]).is_empty());
    }
}

use super::*;
use crate::camera::{Camera, Lens};
use crate::scene::Surface;
use crate::trim::Trims;
use glam::{DMat4, DVec3, UVec2, dvec3};

/// A row of patches along x with increasing curvature. Every third one is back-facing. The ends of
/// a long row are out of view.
fn row(patches: usize) -> Surface {
    let points = (0..patches).flat_map(|patch| {
        (0..16).map(move |i| {
            let (u, v) = (f64::from(i % 4) / 3.0, f64::from(i / 4) / 3.0);
            let bend = 0.01 * patch as f64 * u * u * (1.0 - u);
            let along = if patch % 3 == 0 { 1.0 - u } else { u };
            let x = patch as f64 - 0.5 * patches as f64 + along;
            dvec3(x, v, bend).extend(1.0)
        })
    });
    Surface::new(Degree::CUBIC, points.collect()).expect("whole patches")
}

#[test]
fn many_patches_need_what_each_needs_alone() {
    let lens = Lens::Orthographic { height: 50.0 };
    let camera = Camera::new(DVec3::Z, DVec3::ZERO, DVec3::Y, lens).expect("a camera");
    let projection = camera.projection([-DVec3::ONE, DVec3::ONE].into_iter(), 2.0);
    let screen = Screen::new(&projection, UVec2::new(4000, 2000), 0.5);
    let to_clip: DMat4 = projection.projection * projection.view;
    for patches in [1, 2, 63, 64, 65, 130, 200] {
        let surface = row(patches);
        let points = surface.control_points();
        let cones: Vec<NormalCone> =
            points.chunks(16).map(|points| NormalCone::new(Degree::CUBIC, points)).collect();
        let mut trims = SurfaceTrims::new(&Trims::default(), None);
        let lists = Lists { kept: [0; 3], trimmed: Vec::new() };
        let (mut seen, mut backs) = (0, 0);
        for back in [None, Some((Eye::Towards(DVec3::Z), 1.0))] {
            let surface = SurfacePatches {
                degree: Degree::CUBIC,
                net_side: 4,
                nets: points,
                to_clip: to_clip.into(),
                rounding: Rounding::new(&to_clip, 1.0),
                cones: &cones,
                back,
                hidden: false,
                trims: &mut trims,
                first_point: 0,
                first_patch: 0,
                number: 0,
                lists: &lists,
            };
            let needs =
                (0..patches).step_by(TOGETHER).flat_map(|first| surface.needs::<4>(first, &screen));
            for (patch, need) in needs.take(patches).enumerate() {
                let net = surface.net::<4>(patch);
                let is_back = surface.is_back::<4>(patch);
                let alone = (!is_back && !net.is_outside())
                    .then(|| Need::new(net.bound(&screen, &surface.rounding), &screen));
                assert_eq!(need, alone, "patch {patch} of {patches}");
                seen += usize::from(need.is_some());
                backs += usize::from(is_back);
            }
        }
        assert!(seen > 0, "{patches}");
        assert_eq!(backs, patches.div_ceil(3));
    }
}

//! Interactive editing of trims: keys switch them on and off, and their points are dragged in the (u, v) inset.

use freeform_surface::inspect::inside_loops;
use freeform_surface::{Circle, Ellipse, Error, Rect, Result, Scene, Segment, TrimLoop, Trims};
use glam::{DVec2, dvec2};

use super::action::TrimKind;
use super::undo::Change;

/// A point of a trim that can be dragged; numbers count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Handle {
    /// The centre of a circle.
    CircleCenter(usize),
    /// The right end of a circle.
    CircleRadius(usize),
    /// The corner of an interval with the minimum u and v.
    RectFirst(usize),
    /// The opposite corner.
    RectLast(usize),
    /// The centre of an ellipse.
    EllipseCenter(usize),
    /// The right end of an ellipse.
    EllipseU(usize),
    /// The upper end of an ellipse.
    EllipseV(usize),
    /// A point of a segment of a loop, including the loops of paths. The last point of a segment is excluded,
    /// since it is the first point of the next segment.
    Loop { number: usize, segment: usize, point: usize },
}

/// All points that can be dragged, with their places in the domain.
pub(crate) fn handles(trims: &Trims) -> Vec<(Handle, DVec2)> {
    let mut handles = Vec::new();
    for (i, Circle { center, radius }) in trims.circles.iter().enumerate() {
        handles.push((Handle::CircleCenter(i), *center));
        handles.push((Handle::CircleRadius(i), *center + dvec2(*radius, 0.0)));
    }
    for (i, Rect { u, v }) in trims.rects.iter().enumerate() {
        handles.push((Handle::RectFirst(i), dvec2(u.x, v.x)));
        handles.push((Handle::RectLast(i), dvec2(u.y, v.y)));
    }
    for (i, Ellipse { center, radii }) in trims.ellipses.iter().enumerate() {
        handles.push((Handle::EllipseCenter(i), *center));
        handles.push((Handle::EllipseU(i), *center + dvec2(radii.x, 0.0)));
        handles.push((Handle::EllipseV(i), *center + dvec2(0.0, radii.y)));
    }
    for (number, trim_loop) in trims.all_loops().enumerate() {
        for (segment, curve) in trim_loop.segments().iter().enumerate() {
            let points = curve.points();
            for (point, place) in points[..points.len() - 1].iter().enumerate() {
                handles.push((Handle::Loop { number, segment, point }, *place));
            }
        }
    }
    handles
}

/// The trims with one of their points dragged to a place.
///
/// # Errors
/// The place is not finite, or the point does not exist.
pub(crate) fn pulled(trims: &Trims, handle: Handle, to: DVec2) -> Result<Trims> {
    if !to.is_finite() {
        return Err(Error::invalid("point of a trim", to, "finite coordinates"));
    }
    let mut trims = trims.clone();
    let gone = || Error::invalid("point of a trim", format!("{handle:?}"), "one that is there");
    match handle {
        Handle::CircleCenter(i) | Handle::CircleRadius(i) => {
            let circle = trims.circles.get_mut(i).ok_or_else(gone)?;
            *circle = match handle {
                Handle::CircleCenter(_) => Circle::new(to, circle.radius)?,
                _ => Circle::new(circle.center, to.distance(circle.center))?,
            };
        }
        Handle::RectFirst(i) | Handle::RectLast(i) => {
            let interval = trims.rects.get_mut(i).ok_or_else(gone)?;
            let Rect { u, v } = *interval;
            *interval = match handle {
                Handle::RectFirst(_) => {
                    Rect::new(dvec2(to.x.min(u.y), u.y), dvec2(to.y.min(v.y), v.y))?
                }
                _ => Rect::new(dvec2(u.x, to.x.max(u.x)), dvec2(v.x, to.y.max(v.x)))?,
            };
        }
        Handle::EllipseCenter(i) | Handle::EllipseU(i) | Handle::EllipseV(i) => {
            let ellipse = trims.ellipses.get_mut(i).ok_or_else(gone)?;
            let Ellipse { center, radii } = *ellipse;
            let reach = (to - center).abs();
            *ellipse = match handle {
                Handle::EllipseCenter(_) => Ellipse::new(to, radii)?,
                Handle::EllipseU(_) => Ellipse::new(center, dvec2(reach.x, radii.y))?,
                _ => Ellipse::new(center, dvec2(radii.x, reach.y))?,
            };
        }
        Handle::Loop { number, segment, point } => {
            let of_paths = trims.paths.iter_mut().flat_map(|path| &mut path.loops);
            let trim_loop = trims.loops.iter_mut().chain(of_paths).nth(number).ok_or_else(gone)?;
            *trim_loop = with_point(trim_loop, segment, point, to)?;
        }
    }
    Ok(trims)
}

/// A loop with one point moved. If it is the first point of its segment, the end of the previous segment moves
/// with it.
fn with_point(trim_loop: &TrimLoop, segment: usize, point: usize, to: DVec2) -> Result<TrimLoop> {
    let mut points: Vec<Vec<DVec2>> =
        trim_loop.segments().iter().map(|segment| segment.points().to_vec()).collect();
    let count = points.len();
    if let Some(place) = points.get_mut(segment).and_then(|points| points.get_mut(point)) {
        *place = to;
    }
    if point == 0
        && let Some(end) = points[(segment + count - 1) % count].last_mut()
    {
        *end = to;
    }
    TrimLoop::new(points.iter().map(|points| Segment::new(points)).collect::<Result<_>>()?)
}

/// Switches a kind of trims on or off in all surfaces that have it. If no surface has it, the `selected` one
/// gets one.
pub(crate) fn switched(
    scene: &Scene,
    kind: TrimKind,
    selected: usize,
    put_by: &mut PutBy,
) -> Vec<Change> {
    if kind == TrimKind::Nested {
        return switched_nested(scene, selected, put_by);
    }
    let with_trims = |change: &dyn Fn(usize, &Trims) -> Option<Trims>| -> Vec<Change> {
        let surfaces = scene.surfaces.iter().enumerate();
        surfaces
            .filter_map(|(number, surface)| {
                Some(Change::Trims(number, Box::new(change(number, &surface.trims)?)))
            })
            .collect()
    };
    let count = |trims: &Trims| match kind {
        TrimKind::Circle => trims.circles.len(),
        TrimKind::Rect => trims.rects.len(),
        TrimKind::Ellipse => trims.ellipses.len(),
        TrimKind::Loop | TrimKind::Nested => trims.all_loops().count(),
    };
    if scene.surfaces.iter().all(|surface| count(&surface.trims) == 0) {
        return with_trims(&|number, trims| {
            (number == selected).then(|| {
                let mut trims = trims.clone();
                add(&mut trims, kind, scene.surfaces[number].domain());
                *switch(&mut trims, kind) = true;
                trims
            })
        });
    }
    let is_on = |trims: &Trims| count(trims) > 0 && is_on(trims, kind);
    let on = !scene.surfaces.iter().any(|surface| is_on(&surface.trims));
    with_trims(&|_, trims| {
        (count(trims) > 0).then(|| {
            let mut trims = trims.clone();
            *switch(&mut trims, kind) = on;
            trims
        })
    })
}

const fn is_on(trims: &Trims, kind: TrimKind) -> bool {
    match kind {
        TrimKind::Circle => trims.circles_on,
        TrimKind::Rect => trims.rects_on,
        TrimKind::Ellipse => trims.ellipses_on,
        TrimKind::Loop | TrimKind::Nested => trims.loops_on,
    }
}

const fn switch(trims: &mut Trims, kind: TrimKind) -> &mut bool {
    match kind {
        TrimKind::Circle => &mut trims.circles_on,
        TrimKind::Rect => &mut trims.rects_on,
        TrimKind::Ellipse => &mut trims.ellipses_on,
        TrimKind::Loop | TrimKind::Nested => &mut trims.loops_on,
    }
}

/// The loop that is added to a surface without loops: two quadratics in the form that the thesis' method needs.
fn lens_loop([low, high]: [DVec2; 2], scale: f64) -> Result<TrimLoop> {
    let at = |u: f64, v: f64| low.midpoint(high) + dvec2(u, v) * scale * (high - low);
    let (left, right) = (at(-0.3, 0.0), at(0.3, 0.0));
    TrimLoop::new(vec![
        Segment::Quadratic([left, at(0.0, 0.4), right]),
        Segment::Quadratic([right, at(0.0, -0.4), left]),
    ])
}

/// Adds a trim of a kind in a place of the domain where it is well visible.
fn add(trims: &mut Trims, kind: TrimKind, [low, high]: [DVec2; 2]) {
    let size = high - low;
    let at = |u: f64, v: f64| low + dvec2(u, v) * size;
    match kind {
        TrimKind::Circle => {
            trims.circles.extend(Circle::new(at(0.5, 0.5), 0.2 * size.min_element()));
        }
        TrimKind::Rect => {
            let (from, to) = (at(0.1, 0.6), at(0.3, 0.9));
            trims.rects.extend(Rect::new(dvec2(from.x, to.x), dvec2(from.y, to.y)));
        }
        TrimKind::Ellipse => {
            trims.ellipses.extend(Ellipse::new(at(0.5, 0.2), dvec2(0.3, 0.1) * size));
        }
        TrimKind::Loop | TrimKind::Nested => trims.loops.extend(lens_loop([low, high], 1.0)),
    }
}

/// The nested loops that were last removed from the surfaces, with the number of the surface. They are kept
/// here after they are put back; otherwise, if that edit is refused or undone, they would be lost.
pub(crate) type PutBy = Vec<(usize, Vec<TrimLoop>)>;

/// Removes the loops that lie inside others from all surfaces, or puts them back.
fn switched_nested(scene: &Scene, selected: usize, put_by: &mut PutBy) -> Vec<Change> {
    let surfaces = || scene.surfaces.iter().map(|surface| &surface.trims).enumerate();
    let with_loops = |number: usize, trims: &Trims, loops: Vec<TrimLoop>| {
        Change::Trims(number, Box::new(Trims { loops, loops_on: true, ..trims.clone() }))
    };
    let mut edits = Vec::new();
    let mut taken = PutBy::new();
    for (number, trims) in surfaces().filter(|(_, trims)| trims.loops_on) {
        let (nested, outer): (Vec<_>, Vec<_>) =
            trims.loops.iter().cloned().partition(|inner| is_nested(inner, trims));
        if !nested.is_empty() {
            taken.push((number, nested));
            edits.push(with_loops(number, trims, outer));
        }
    }
    if !edits.is_empty() {
        *put_by = taken;
        return edits;
    }
    for (number, trims) in surfaces() {
        let known = put_by.iter().filter(|(of, _)| *of == number).flat_map(|(_, loops)| loops);
        let mut loops = trims.loops.clone();
        loops.extend(known.filter(|known| !trims.loops.contains(known)).cloned());
        // This includes surfaces whose nested loops are present but switched off.
        if loops.len() > trims.loops.len() || loops.iter().any(|inner| is_nested(inner, trims)) {
            edits.push(with_loops(number, trims, loops));
        }
    }
    if edits.is_empty()
        && let Some((_, trims)) = surfaces().nth(selected)
    {
        let mut loops = trims.loops.clone();
        match loops.first().map(shrunk) {
            Some(inner) => loops.extend(inner),
            None => {
                let domain = scene.surfaces[selected].domain();
                loops.extend([1.0, 0.5].into_iter().flat_map(|scale| lens_loop(domain, scale)));
            }
        }
        edits.push(with_loops(selected, trims, loops));
    }
    edits
}

/// Whether a loop starts inside another one.
fn is_nested(inner: &TrimLoop, trims: &Trims) -> bool {
    let start = inner.segments()[0].start();
    let holds = |outer: &TrimLoop| inside_loops(std::slice::from_ref(outer), start);
    trims.loops.iter().any(|outer| outer != inner && holds(outer))
}

/// A loop of half the size around the same middle.
fn shrunk(outer: &TrimLoop) -> Result<TrimLoop> {
    let [min, max] = outer.control_box();
    let middle = min.midpoint(max);
    let segments = outer.segments().iter().map(|segment| {
        let points: Vec<DVec2> =
            segment.points().iter().map(|point| middle + (*point - middle) * 0.5).collect();
        Segment::new(&points)
    });
    TrimLoop::new(segments.collect::<Result<_>>()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::undo::History;
    use freeform_surface::inspect::NewtonTrims;
    use freeform_surface::{FillRule, TrimPath};

    const KINDS: [TrimKind; 5] =
        [TrimKind::Circle, TrimKind::Rect, TrimKind::Ellipse, TrimKind::Loop, TrimKind::Nested];

    fn press(scene: &mut Scene, kind: TrimKind, put_by: &mut PutBy) {
        let edits = switched(scene, kind, 0, put_by);
        assert!(!edits.is_empty());
        History::default().edit(scene, edits, 1);
    }

    #[test]
    fn a_key_adds_then_takes_away_then_brings_back() {
        for kind in KINDS {
            let mut scene = Scene::listing16();
            scene.surfaces[0].trims = Trims::default();
            let mut put_by = PutBy::new();
            let cut = |scene: &Scene| -> usize {
                let trims = &scene.surfaces[0].trims;
                assert!(NewtonTrims::of(trims).is_ok());
                let places = (0..400).map(|i| dvec2(f64::from(i % 20), f64::from(i / 20)) / 19.0);
                places.filter(|uv| trims.cut(*uv)).count()
            };
            press(&mut scene, kind, &mut put_by);
            let with = cut(&scene);
            assert!(with > 0, "{kind:?}");
            press(&mut scene, kind, &mut put_by);
            let without = cut(&scene);
            assert_ne!(with, without, "{kind:?}");
            press(&mut scene, kind, &mut put_by);
            assert_eq!(cut(&scene), with, "{kind:?}");
        }
    }

    #[test]
    fn nested_loops_are_neither_lost_nor_doubled() {
        let mut scene = Scene::listing16();
        scene.surfaces[0].trims = Trims::default();
        let mut put_by = PutBy::new();
        let loops = |scene: &Scene| scene.surfaces[0].trims.loops.len();
        press(&mut scene, TrimKind::Nested, &mut put_by);
        let nested = scene.clone();
        press(&mut scene, TrimKind::Nested, &mut put_by);
        assert_eq!((loops(&nested), loops(&scene)), (2, 1));
        // A refused edit left the loops unchanged.
        let outer = scene.clone();
        let _ = switched(&scene, TrimKind::Nested, 0, &mut put_by);
        press(&mut scene, TrimKind::Nested, &mut put_by);
        assert_eq!(scene.surfaces[0].trims, nested.surfaces[0].trims);
        // The removal of the loops was undone, and another key switched the loops off. N switches them on
        // again.
        scene = outer;
        scene.surfaces[0].trims = nested.surfaces[0].trims.clone();
        press(&mut scene, TrimKind::Loop, &mut put_by);
        assert!(!scene.surfaces[0].trims.loops_on);
        press(&mut scene, TrimKind::Nested, &mut put_by);
        assert_eq!(scene.surfaces[0].trims, nested.surfaces[0].trims);
    }

    /// The domain of a Bézier patch.
    const UNIT: [DVec2; 2] = [DVec2::ZERO, DVec2::ONE];

    #[test]
    fn a_pulled_point_is_where_it_was_pulled_to() {
        let mut trims = Trims::default();
        for kind in KINDS {
            add(&mut trims, kind, UNIT);
        }
        trims
            .paths
            .push(TrimPath { loops: vec![lens_loop(UNIT, 0.2).unwrap()], rule: FillRule::NonZero });
        let all = handles(&trims);
        assert_eq!(all.len(), 2 + 2 + 3 + 4 + 4 + 4);
        for (i, (handle, place)) in all.iter().enumerate() {
            // Radii change along one axis only, and corners keep their order.
            let to = match handle {
                Handle::CircleRadius(_) | Handle::EllipseU(_) => *place + dvec2(0.05, 0.0),
                Handle::EllipseV(_) => *place + dvec2(0.0, 0.05),
                Handle::RectFirst(_) => *place - 0.05,
                _ => *place + 0.05,
            };
            let moved = handles(&pulled(&trims, *handle, to).unwrap());
            assert!(moved[i].1.distance(to) < 1e-12, "{handle:?}");
            assert!(pulled(&trims, *handle, DVec2::NAN).is_err(), "{handle:?}");
        }
        assert!(pulled(&trims, Handle::CircleCenter(9), DVec2::ZERO).is_err());
        let crossed = pulled(&trims, Handle::RectFirst(0), DVec2::ONE).unwrap();
        assert_eq!(crossed.rects[0].u.x, crossed.rects[0].u.y);
    }
}

//! The inset in the panel: the domain of a surface with its trims and their draggable points.

use egui::{Color32, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};
use freeform_surface::{Result, Segment, Trims};
use glam::{DVec2, dvec2};

use super::pick::PICK_PX;
use super::trims::{Handle, handles, pulled};

/// Length of a side in points.
const SIDE: f32 = 200.0;
/// If there are more segments than this, no draggable points are shown, because they would hide the curves.
const MANY_TO_PULL: usize = 100;
/// If there are more segments than this, they are drawn coarsely.
const MANY: usize = 2_000;

const ON: Color32 = Color32::from_rgb(255, 170, 60);
const OFF: Color32 = Color32::from_gray(110);
const POINT: Color32 = Color32::from_rgb(0, 128, 255);
/// Gold: highlights the object under the cursor, here and in the picture.
pub(super) const HIGHLIGHT: Color32 = Color32::from_rgb(255, 220, 80);

/// Draws the trims over a domain, which is given by its first and last (u, v). Returns the changed trims if one of
/// their points was dragged.
pub(super) fn show(ui: &mut Ui, trims: &Trims, domain: [DVec2; 2]) -> Option<Result<Trims>> {
    let (response, painter) = ui.allocate_painter(vec2(SIDE, SIDE), Sense::drag());
    // Leaves room for points that lie a little outside.
    let square = response.rect.shrink(14.0);
    painter.rect_filled(response.rect, 2.0, Color32::from_gray(25));
    let border = Stroke::new(1.0, Color32::from_gray(160));
    painter.rect_stroke(square, 0.0, border, egui::StrokeKind::Middle);
    let [low, high] = domain;
    let place = |uv: DVec2| place(square, (uv - low) / (high - low));
    curves(&painter, trims, place);
    let points = if trims.segment_count() > MANY_TO_PULL { Vec::new() } else { handles(trims) };
    let id = response.id;
    let near = |at: Pos2| -> Option<Handle> {
        let distance = |uv: DVec2| place(uv).distance(at);
        let points = points.iter().map(|(handle, uv)| (*handle, distance(*uv)));
        let nearest = points.min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.filter(|(_, distance)| *distance <= PICK_PX as f32).map(|(handle, _)| handle)
    };
    if response.drag_started() {
        let held = ui.input(|input| input.pointer.press_origin()).and_then(near);
        ui.data_mut(|data| data.insert_temp(id, Held(held)));
    }
    let held = if response.dragged() {
        ui.data(|data| data.get_temp::<Held>(id)).and_then(|held| held.0)
    } else {
        None
    };
    let highlighted = held.or_else(|| response.hover_pos().and_then(near));
    for (handle, uv) in &points {
        let (radius, color) =
            if highlighted == Some(*handle) { (5.0, HIGHLIGHT) } else { (3.0, POINT) };
        painter.circle_filled(place(*uv), radius, color);
    }
    let pointer =
        response.interact_pointer_pos().filter(|_| response.drag_delta() != vec2(0.0, 0.0));
    let uv = |at: Pos2| low + share(square, at) * (high - low);
    held.zip(pointer).map(|(handle, at)| pulled(trims, handle, uv(at)))
}

/// The point that is being dragged.
#[derive(Debug, Clone, Copy, Default)]
struct Held(Option<Handle>);

/// The place in the inset of a point that is given as a share of the domain; v points upwards.
fn place(square: Rect, share: DVec2) -> Pos2 {
    let size = square.size();
    pos2(square.left() + share.x as f32 * size.x, square.bottom() - share.y as f32 * size.y)
}

fn share(square: Rect, at: Pos2) -> DVec2 {
    let size = square.size();
    dvec2(f64::from((at.x - square.left()) / size.x), f64::from((square.bottom() - at.y) / size.y))
}

fn curves(painter: &egui::Painter, trims: &Trims, place: impl Fn(DVec2) -> Pos2) {
    let stroke = |on: bool| Stroke::new(1.5, if on { ON } else { OFF });
    let closed = |points: Vec<Pos2>, on: bool| {
        painter.add(Shape::closed_line(points, stroke(on)));
    };
    let ring = |center: DVec2, radii: DVec2| -> Vec<Pos2> {
        let angles = (0..64).map(|i| f64::from(i) * std::f64::consts::TAU / 64.0);
        angles.map(|angle| place(center + radii * DVec2::from_angle(angle))).collect()
    };
    for circle in &trims.circles {
        closed(ring(circle.center, DVec2::splat(circle.radius)), trims.circles_on);
    }
    for ellipse in &trims.ellipses {
        closed(ring(ellipse.center, ellipse.radii), trims.ellipses_on);
    }
    for interval in &trims.rects {
        let (u, v) = (interval.u, interval.v);
        let corners = [dvec2(u.x, v.x), dvec2(u.y, v.x), dvec2(u.y, v.y), dvec2(u.x, v.y)];
        closed(corners.map(&place).to_vec(), trims.rects_on);
    }
    let segments = trims.segment_count();
    for trim_loop in trims.all_loops() {
        let points = trim_loop.segments().iter().flat_map(|segment| {
            let edits = match segment {
                Segment::Line(_) => 1,
                _ if segments > MANY => 2,
                _ => 16,
            };
            (0..edits).map(move |i| segment.point(f64::from(i) / f64::from(edits)))
        });
        closed(points.map(&place).collect(), trims.loops_on);
    }
}

//! The overlay over the picture: the panel, the help, the last message, and the control point under the cursor.

use egui::{Align2, Color32, Context, RichText, Stroke, Ui};
use freeform_surface::model::Continuity;
use freeform_surface::{
    EdgeColor, Edges, FrameStats, IsolineCount, Light, LineWidth, Method, Newton, Paint, Scene,
    TessLevel, Tessellation, Tolerance, Trims,
};
use glam::{DVec2, DVec3};

use super::inset::HIGHLIGHT;
use super::pick::{PICK_PX, on_screen, world_point};
use super::state::{Cover, Message, State};
use super::undo::Change;
use super::{action, inset, shading};

const ERROR: Color32 = Color32::from_rgb(255, 110, 90);
/// Behind names in the colours of lines.
const PAPER: Color32 = Color32::from_gray(170);

/// The picture that is shown.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drawn {
    pub(super) stats: FrameStats,
    /// How long it took, in milliseconds.
    pub(super) ms: f64,
    /// The curvature at the end of its scale, if it shows curvature.
    pub(super) curvature_limit: Option<f64>,
}

/// Lays out the overlay; returns the rectangles that receive the mouse.
pub(super) fn show(context: &Context, state: &mut State, drawn: &Drawn) -> Vec<egui::Rect> {
    let mut covered = Vec::new();
    let height = (context.content_rect().height() - 60.0).max(40.0);
    highlight(context, state);
    outline(context, state);
    if state.cover != Cover::Nothing {
        let window = egui::Window::new("freeform")
            .anchor(Align2::RIGHT_TOP, [-8.0, 8.0])
            .default_width(230.0)
            .resizable(false)
            .default_height(height)
            .max_height(height)
            .vscroll(true);
        let shown = window.show(context, |ui| contents(ui, state, drawn));
        covered.extend(shown.map(|shown| shown.response.rect));
    }
    if state.cover == Cover::Help {
        let window = egui::Window::new("keys and mouse")
            .anchor(Align2::LEFT_TOP, [8.0, 8.0])
            .resizable(false)
            .default_height(height)
            .max_height(height)
            .vscroll(true);
        let shown = window.show(context, help);
        covered.extend(shown.map(|shown| shown.response.rect));
    }
    message(context, state);
    covered
}

/// A ring around the control point under the cursor.
fn highlight(context: &Context, state: &State) {
    let Some(id) = state.pointer.point() else { return };
    let Some(point) = world_point(state.scene(), id) else { return };
    let Some(place) = on_screen(&state.projection(), state.size(), point) else { return };
    let scale = context.pixels_per_point();
    let center = egui::pos2(place.x as f32 / scale, place.y as f32 / scale);
    let painter = context.layer_painter(egui::LayerId::background());
    painter.circle_stroke(center, PICK_PX as f32 / scale, Stroke::new(2.0, HIGHLIGHT));
}

/// The outline of the face that was clicked. Parts behind the eye are left out.
fn outline(context: &Context, state: &State) {
    let Some(picked) = &state.picked else { return };
    let (projection, size) = (state.projection(), state.size());
    let scale = context.pixels_per_point();
    let painter = context.layer_painter(egui::LayerId::background());
    for line in &picked.outline {
        let places: Vec<_> =
            line.iter().map(|point| on_screen(&projection, size, *point)).collect();
        for (i, from) in places.iter().enumerate() {
            let to = places[(i + 1) % places.len()];
            if let (Some(from), Some(to)) = (from, to) {
                let place = |at: DVec3| egui::pos2(at.x as f32 / scale, at.y as f32 / scale);
                painter.line_segment([place(*from), place(to)], Stroke::new(2.0, HIGHLIGHT));
            }
        }
    }
}

/// How far the scene is that is being read, and the last message, at the bottom.
fn message(context: &Context, state: &State) {
    let message = state.message.as_ref().map(|message| match message {
        Message::Done(text) => (text, Color32::WHITE),
        Message::Error(text) => (text, ERROR),
    });
    let progress = state.progress.as_ref().map(|text| (text, Color32::WHITE));
    if message.is_none() && progress.is_none() {
        return;
    }
    egui::Window::new("message")
        .title_bar(false)
        .anchor(Align2::LEFT_BOTTOM, [8.0, -8.0])
        .resizable(false)
        .interactable(false)
        .show(context, |ui| {
            for (text, color) in message.into_iter().chain(progress) {
                ui.label(RichText::new(text).color(color));
            }
        });
}

fn help(ui: &mut Ui) {
    // The spacing is small so that the whole panel fits a small window.
    ui.spacing_mut().item_spacing.y = 1.0;
    egui::Grid::new("bindings").num_columns(2).min_row_height(0.0).show(ui, |ui| {
        for (keys, help) in action::lines() {
            ui.label(RichText::new(keys).small().strong());
            ui.label(RichText::new(help).small());
            ui.end_row();
        }
    });
}

fn contents(ui: &mut Ui, state: &mut State, drawn: &Drawn) {
    stats_grid(ui, drawn);
    ui.separator();
    method(ui, state);
    fineness(ui, state);
    style(ui, state);
    shading::show(ui, state, drawn.curvature_limit);
    if state.scene().settings.method == Method::Thesis {
        newton(ui, state);
    }
    if !state.scene().surfaces.is_empty() {
        ui.separator();
        surface(ui, state);
    }
    if !state.scene().meshes.is_empty() {
        ui.separator();
        mesh(ui, state);
    }
    ui.separator();
    ui.small("H or F1: help");
}

fn stats_grid(ui: &mut Ui, Drawn { stats, ms, .. }: &Drawn) {
    egui::Grid::new("figures").num_columns(2).show(ui, |ui| {
        let bound = stats.largest_bound.map_or("–".into(), |bound| format!("{bound:.3} px"));
        for (name, value) in [
            ("frame", format!("{ms:.1} ms")),
            ("triangles", stats.triangles.to_string()),
            ("patches", format!("{} of {}", stats.patches - stats.culled, stats.patches)),
            ("largest bound", bound),
        ] {
            ui.label(name);
            ui.monospace(value);
            ui.end_row();
        }
    });
    if let Some(unmet) = stats.unmet {
        ui.colored_label(ERROR, format!("tolerance not met, up to {unmet:.2} px"));
    }
}

fn method(ui: &mut Ui, state: &mut State) {
    let mut method = state.scene().settings.method;
    ui.horizontal(|ui| {
        ui.label("method");
        ui.selectable_value(&mut method, Method::Exact, "exact");
        ui.selectable_value(&mut method, Method::Thesis, "thesis");
    });
    if method != state.scene().settings.method {
        let set = state.set_method(method);
        state.report(set);
    }
}

fn fineness(ui: &mut Ui, state: &mut State) {
    let (level, tolerance) = state.finenesses();
    let before = state.scene().settings.tessellation;
    let mut at_level = matches!(before, Tessellation::Level(_));
    let (mut number, mut pixels) = (level.get(), tolerance.pixels());
    ui.horizontal(|ui| {
        ui.selectable_value(&mut at_level, false, "tolerance");
        ui.selectable_value(&mut at_level, true, "level");
        if at_level {
            ui.add(egui::DragValue::new(&mut number).range(1..=TessLevel::MAX.get()));
        } else {
            let value = egui::DragValue::new(&mut pixels).range(0.01..=100.0).speed(0.01);
            ui.add(value.suffix(" px"));
        }
    });
    let chosen = if at_level {
        TessLevel::new(number.into()).map(Tessellation::Level)
    } else {
        Tolerance::new(pixels).map(Tessellation::Within)
    };
    if let Some(chosen) = state.report(chosen).filter(|chosen| *chosen != before) {
        state.set_tessellation(chosen);
    }
}

fn style(ui: &mut Ui, state: &mut State) {
    let mut settings = state.scene().settings;
    let mut shading = settings.analysis.map(|own| own.kind());
    ui.horizontal(|ui| {
        ui.label("light");
        for light in Light::ALL {
            ui.selectable_value(&mut settings.light, light, light.name());
        }
        let is_exact = settings.method == Method::Exact;
        ui.add_enabled_ui(is_exact, |ui| shading::choose(ui, &mut shading));
    });
    ui.horizontal(|ui| {
        ui.checkbox(&mut settings.wireframe, "wireframe");
        ui.add_enabled_ui(settings.wireframe, |ui| ui.checkbox(&mut settings.red_lines, "red"));
        ui.checkbox(&mut settings.control_points, "points");
    });
    let mut edges = settings.edges.is_some();
    ui.horizontal(|ui| {
        ui.checkbox(&mut edges, "edges");
        if let Some(own) = &mut settings.edges {
            line_width(ui, &mut own.width);
            let is_plain = own.color != EdgeColor::Continuity;
            ui.add_enabled_ui(is_plain, |ui| ui.checkbox(&mut own.smooth, "smooth"));
        }
    });
    if let Some(own) = &mut settings.edges {
        edge_color(ui, &mut own.color);
    }
    let mut isolines = settings.isolines.is_some();
    ui.horizontal(|ui| {
        ui.checkbox(&mut isolines, "isolines");
        if let Some(own) = &mut settings.isolines {
            let mut count = own.count.get();
            ui.add(egui::DragValue::new(&mut count).range(1..=IsolineCount::MAX.get()).speed(0.1));
            own.count = IsolineCount::new(count.into()).unwrap_or(own.count);
            line_width(ui, &mut own.width);
            color(ui, &mut own.color);
        }
    });
    ui.horizontal(|ui| {
        ui.label("background");
        let [red, green, blue, _] = &mut settings.background;
        let mut rgb = [*red, *green, *blue];
        color(ui, &mut rgb);
        [*red, *green, *blue] = rgb;
    });
    if settings != state.scene().settings {
        state.change_settings(|own| *own = settings);
    }
    if shading != settings.analysis.map(|own| own.kind()) {
        state.show_analysis(shading);
    }
    if edges != settings.edges.is_some() {
        state.switch_edges();
    }
    if isolines != settings.isolines.is_some() {
        state.switch_isolines();
    }
}

/// A field for the width of lines.
fn line_width(ui: &mut Ui, own: &mut LineWidth) {
    let mut width = own.pixels();
    ui.add(egui::DragValue::new(&mut width).range(0.1..=100.0).speed(0.05).suffix(" px"));
    *own = LineWidth::new(width).unwrap_or(*own);
}

/// One colour for all edges, or one for each class, with its name.
fn edge_color(ui: &mut Ui, own: &mut EdgeColor) {
    let mut by_class = *own == EdgeColor::Continuity;
    ui.horizontal_wrapped(|ui| {
        ui.label("color");
        if let EdgeColor::Rgb(rgb) = own {
            color(ui, rgb);
        }
        ui.checkbox(&mut by_class, "by continuity");
        for class in Continuity::ALL.iter().filter(|_| *own == EdgeColor::Continuity) {
            let [red, green, blue] = to_bytes(class.color());
            let name = RichText::new(class.name()).color(Color32::from_rgb(red, green, blue));
            ui.label(name.background_color(PAPER));
        }
    });
    if by_class != (*own == EdgeColor::Continuity) {
        *own = if by_class { EdgeColor::Continuity } else { Edges::default().color };
    }
}

/// A colour in 8 bits for each channel.
fn to_bytes(rgb: [f32; 3]) -> [u8; 3] {
    rgb.map(|channel| (channel * 255.0).round() as u8)
}

/// A button for a colour. Its channels are used without conversion, as everywhere in this program.
fn color(ui: &mut Ui, rgb: &mut [f32; 3]) -> bool {
    let mut bytes = to_bytes(*rgb);
    let changed = ui.color_edit_button_srgb(&mut bytes).changed();
    if changed {
        *rgb = bytes.map(|byte| f32::from(byte) / 255.0);
    }
    changed
}

fn newton(ui: &mut Ui, state: &mut State) {
    let own = state.scene().settings.newton;
    let (mut iterations, mut epsilon) = (own.iterations(), own.epsilon());
    ui.horizontal(|ui| {
        ui.label("Newton");
        ui.add(egui::DragValue::new(&mut iterations).range(1..=Newton::MAX_ITERATIONS));
        let value = egui::DragValue::new(&mut epsilon).range(1e-9..=1.0).speed(1e-4);
        // A value from the scene is not clamped until it is edited.
        ui.add(value.clamp_existing_to_range(false).prefix("ε ").max_decimals(9));
    });
    let chosen = Newton::new(iterations, epsilon);
    if let Some(newton) = state.report(chosen).filter(|newton| *newton != own) {
        state.change_settings(|settings| settings.newton = newton);
    }
}

/// One mesh: its colour.
fn mesh(ui: &mut Ui, state: &mut State) {
    let count = state.scene().meshes.len();
    state.selected_mesh = state.selected_mesh.min(count - 1);
    let number = state.selected_mesh;
    ui.horizontal(|ui| {
        ui.label("mesh");
        if count > 1 {
            ui.add(egui::DragValue::new(&mut state.selected_mesh).range(0..=count - 1));
        }
        paint(ui, state, |scene, i| &scene.meshes[i].paint, Change::MeshPaint, number);
    });
}

/// A colour that can be edited, or the size of the texture.
fn paint(
    ui: &mut Ui,
    state: &mut State,
    own: fn(&Scene, usize) -> &Paint,
    edit: fn(usize, Paint) -> Change,
    number: usize,
) {
    match own(state.scene(), number) {
        Paint::Color(rgb) => {
            let mut rgb = *rgb;
            if color(ui, &mut rgb) {
                let edited = state.edit(vec![edit(number, Paint::Color(rgb))]);
                state.report(edited);
            }
        }
        Paint::Texture(image) => {
            let (width, height) = image.dimensions();
            ui.label(format!("picture, {width} × {height}"));
        }
    }
}

/// One surface: its colour, whether it is hidden, what is known about the face, and its trims with their inset.
fn surface(ui: &mut Ui, state: &mut State) {
    let count = state.scene().surfaces.len();
    state.selected = state.selected.min(count - 1);
    let mut number = state.selected;
    ui.horizontal(|ui| {
        ui.label("surface");
        if count > 1 {
            ui.add(egui::DragValue::new(&mut number).range(0..=count - 1));
        }
        if number != state.selected {
            state.select(Some(number));
        }
        paint(ui, state, |scene, i| &scene.surfaces[i].paint, Change::SurfacePaint, number);
    });
    if let Some(picked) = state.picked.as_ref().filter(|picked| picked.surface == number) {
        ui.label(&picked.facts);
    }
    hidden(ui, state, number);
    let surface = &state.scene().surfaces[number];
    if surface.face.is_some() {
        return;
    }
    let edited = numbers(ui, &surface.trims).map(Ok);
    if let Some(trims) = inset::show(ui, &surface.trims, surface.domain()).or(edited) {
        let done = trims.and_then(|trims| state.edit(vec![Change::Trims(number, Box::new(trims))]));
        state.report(done);
    }
}

/// Whether a surface is hidden, and a button that shows all that are.
fn hidden(ui: &mut Ui, state: &mut State, number: usize) {
    let mut hidden = state.scene().surfaces[number].hidden;
    let count = state.hidden_count();
    ui.horizontal(|ui| {
        let edited = if ui.checkbox(&mut hidden, "hide").changed() {
            state.edit(vec![Change::Hidden(number, hidden)])
        } else if count > 0 && ui.button(format!("show all ({count} hidden)")).clicked() {
            state.show_all()
        } else {
            Ok(())
        };
        state.report(edited);
    });
}

/// Fields for the values of shapes, if there are only a few, and the number of loops. Returns the changed trims
/// if a value was edited.
fn numbers(ui: &mut Ui, trims: &Trims) -> Option<Trims> {
    // There may be many loops, so they are copied only for a change.
    let own = Trims {
        circles: trims.circles.clone(),
        rects: trims.rects.clone(),
        ellipses: trims.ellipses.clone(),
        loops: Vec::new(),
        paths: Vec::new(),
        ..*trims
    };
    let mut edited = own.clone();
    shapes(ui, &mut edited);
    if trims.has_loops() {
        let (loops, segments) = (trims.all_loops().count(), trims.segment_count());
        let off = if trims.loops_on { "" } else { ", off" };
        ui.label(format!("{loops} loops, {segments} segments{off}"));
    }
    let (loops, paths) = (&trims.loops, &trims.paths);
    (edited != own).then(|| Trims { loops: loops.clone(), paths: paths.clone(), ..edited })
}

/// Fields for the values of circles, intervals and ellipses.
fn shapes(ui: &mut Ui, trims: &mut Trims) {
    const MAX: usize = 8;
    fn number(ui: &mut Ui, value: &mut f64) {
        ui.add(egui::DragValue::new(value).speed(0.002).max_decimals(4));
    }
    fn place(ui: &mut Ui, place: &mut DVec2) {
        number(ui, &mut place.x);
        number(ui, &mut place.y);
    }
    fn at_least(low: f64, value: &mut f64) {
        *value = value.max(low);
    }
    for circle in trims.circles.iter_mut().take(MAX) {
        ui.horizontal(|ui| {
            ui.add_enabled_ui(trims.circles_on, |ui| {
                ui.label("circle");
                place(ui, &mut circle.center);
                number(ui, &mut circle.radius);
                at_least(0.0, &mut circle.radius);
            });
        });
    }
    for interval in trims.rects.iter_mut().take(MAX) {
        ui.horizontal(|ui| {
            ui.add_enabled_ui(trims.rects_on, |ui| {
                ui.label("interval");
                place(ui, &mut interval.u);
                place(ui, &mut interval.v);
                at_least(interval.u.x, &mut interval.u.y);
                at_least(interval.v.x, &mut interval.v.y);
            });
        });
    }
    for ellipse in trims.ellipses.iter_mut().take(MAX) {
        ui.horizontal(|ui| {
            ui.add_enabled_ui(trims.ellipses_on, |ui| {
                ui.label("ellipse");
                place(ui, &mut ellipse.center);
                place(ui, &mut ellipse.radii);
                at_least(0.0, &mut ellipse.radii.x);
                at_least(0.0, &mut ellipse.radii.y);
            });
        });
    }
}

//! What the picture shows in place of light and colour: its part of the panel, and its scale in the picture.

use egui::{ComboBox, Context, DragValue, Rect, TextureHandle, TextureOptions, Ui, pos2, vec2};
use freeform_surface::{
    Analysis, AnalysisKind, CurvatureKind, CurvatureLimit, Direction, Draft, DraftLimit,
    RenderSettings, StripeCount, Stripes,
};
use glam::{DVec3, UVec2};

use super::state::State;
use crate::io::scale;

/// Directions that buttons offer.
const AXES: [(&str, DVec3); 6] = [
    ("x", DVec3::X),
    ("y", DVec3::Y),
    ("z", DVec3::Z),
    ("−x", DVec3::NEG_X),
    ("−y", DVec3::NEG_Y),
    ("−z", DVec3::NEG_Z),
];

/// A list of the kinds of shading; `None` is light.
pub(super) fn choose(ui: &mut Ui, shown: &mut Option<AnalysisKind>) {
    let name = |kind: Option<AnalysisKind>| kind.map_or("shading", AnalysisKind::name);
    ComboBox::from_id_salt("shading").width(76.0).selected_text(name(*shown)).show_ui(ui, |ui| {
        ui.selectable_value(shown, None, "light");
        for kind in AnalysisKind::ALL {
            ui.selectable_value(shown, Some(kind), kind.name());
        }
    });
}

/// The settings of the shading that is shown, if it is not light. `limit` is the curvature at the end of the scale in the
/// picture.
pub(super) fn show(ui: &mut Ui, state: &mut State, limit: Option<f64>) {
    let before = state.scene().settings.analysis;
    let mut own = before;
    match &mut own {
        None => {}
        Some(Analysis::Zebra(stripes) | Analysis::Isophotes(stripes)) => edit_stripes(ui, stripes),
        Some(Analysis::Curvature { of, limit: own }) => edit_curvature(ui, of, own, limit),
        Some(Analysis::Draft(draft)) => edit_draft(ui, draft),
    }
    if own != before {
        state.change_settings(|settings: &mut RenderSettings| settings.analysis = own);
    }
}

fn edit_stripes(ui: &mut Ui, Stripes { count, direction }: &mut Stripes) {
    ui.horizontal_wrapped(|ui| {
        let mut number = count.get();
        ui.add(DragValue::new(&mut number).range(1..=StripeCount::MAX.get()).speed(0.2));
        *count = StripeCount::new(number.into()).unwrap_or(*count);
        ui.label("stripes,");
        ui.selectable_value(direction, None, "upright");
        for (name, axis) in &AXES[..3] {
            ui.selectable_value(direction, Direction::new(*axis).ok(), *name);
        }
    });
}

fn edit_curvature(
    ui: &mut Ui,
    of: &mut CurvatureKind,
    own: &mut Option<CurvatureLimit>,
    shown: Option<f64>,
) {
    ui.horizontal_wrapped(|ui| {
        for kind in CurvatureKind::ALL {
            ui.selectable_value(of, kind, kind.name());
        }
    });
    let mut suits = own.is_none();
    let mut limit = own.map(CurvatureLimit::get).or(shown).unwrap_or(1.0);
    ui.horizontal(|ui| {
        ui.label("limit");
        ui.checkbox(&mut suits, "that suits");
        let speed = 0.01 * limit;
        let value = DragValue::new(&mut limit).range(1e-30..=1e30).max_decimals(15);
        ui.add_enabled(!suits, value.speed(speed));
    });
    *own = if suits { None } else { CurvatureLimit::new(limit).ok().or(*own) };
}

fn edit_draft(ui: &mut Ui, Draft { pull, limit }: &mut Draft) {
    ui.horizontal_wrapped(|ui| {
        let mut degrees = limit.degrees();
        ui.add(
            DragValue::new(&mut degrees).range(0.001..=90.0).speed(0.05).prefix("±").suffix("°"),
        );
        *limit = DraftLimit::new(degrees).unwrap_or(*limit);
        ui.label("pull");
        for (name, axis) in AXES {
            if let Ok(direction) = Direction::new(axis) {
                ui.selectable_value(pull, direction, name);
            }
        }
    });
}

/// The scale of the analysis in the picture, as `freeform render` draws it.
#[derive(Default)]
pub(super) struct ScaleView {
    /// What the texture shows: the analysis, the curvature at the end of the scale, and the size of the picture.
    key: Option<(Analysis, Option<f64>, UVec2)>,
    texture: Option<TextureHandle>,
}

impl ScaleView {
    /// Paints the scale in the lower left corner.
    pub(super) fn paint(&mut self, context: &Context, state: &State, limit: Option<f64>) {
        let size = state.size().as_uvec2();
        let shown = state.scene().settings.shown_analysis();
        let key = shown.map(|analysis| (analysis, limit, size));
        if key != self.key {
            self.key = key;
            let image =
                shown.and_then(|analysis| scale::for_picture(&analysis, limit, size.into()));
            self.texture = image.map(|image| {
                let size = [image.width() as usize, image.height() as usize];
                let pixels = egui::ColorImage::from_rgba_unmultiplied(size, image.as_raw());
                context.load_texture("scale", pixels, TextureOptions::NEAREST)
            });
        }
        let Some(texture) = &self.texture else { return };
        let [width, height] = texture.size();
        let (x, y) = scale::corner(size.y, height as u32);
        let point = context.pixels_per_point();
        let place = |x: f32, y: f32| pos2(x / point, y / point);
        let first = place(x as f32, y as f32);
        let area = Rect::from_min_size(first, vec2(width as f32, height as f32) / point);
        let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        let painter = context.layer_painter(egui::LayerId::background());
        painter.image(texture.id(), area, all, egui::Color32::WHITE);
    }
}

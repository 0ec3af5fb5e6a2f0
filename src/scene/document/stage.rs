//! The settings of a `[render]` table.

use super::{Builder, unit_range};
use crate::error::{Error, Result};
use crate::scene::tables::{
    AnalysisTable, AnalysisValue, EdgeColorValue, EdgesTable, EdgesValue, IsolinesTable,
    IsolinesValue, RenderTable,
};
use crate::scene::{
    Analysis, AnalysisChange, AnalysisKind, CurvatureLimit, Direction, DraftLimit, EdgeColor,
    Edges, IsolineCount, Isolines, LineWidth, RenderSettings, Samples, StripeCount, TessLevel,
    Tessellation, Tolerance, UpAxis,
};
use crate::thesis::newton::Newton;

/// The settings of a `[render]` table.
#[derive(Default)]
pub(super) struct Stage {
    pub(super) settings: RenderSettings,
    pub(super) up: Option<UpAxis>,
}

pub(super) fn stage_of(builder: &Builder<'_>, table: RenderTable) -> Result<Stage> {
    let mut settings = RenderSettings {
        wireframe: table.wireframe,
        red_lines: table.red_lines,
        control_points: table.control_points,
        ..RenderSettings::default()
    };
    if let Some(background) = table.background {
        settings.background = builder.check(background, |rgba| unit_range("background", rgba))?;
    }
    if let Some(method) = table.method {
        settings.method = builder.check(method, |name| name.parse())?;
    }
    if let Some(light) = table.light {
        settings.light = builder.check(light, |name| name.parse())?;
    }
    if let Some(samples) = table.samples {
        settings.samples = builder.check(samples, Samples::new)?;
    }
    settings.tessellation = match (table.level, table.tolerance) {
        (None, None) => Tessellation::default(),
        (Some(level), None) => Tessellation::Level(builder.check(level, TessLevel::new)?),
        (None, Some(tolerance)) => Tessellation::Within(builder.check(tolerance, Tolerance::new)?),
        (Some(_), Some(tolerance)) => {
            return Err(builder.at(
                tolerance.span().start,
                Error::invalid("render", "given level and tolerance", "one of them"),
            ));
        }
    };
    if let Some(normals) = table.normals {
        settings.normals = builder.check(normals, |name| name.parse())?;
    }
    if let Some(edges) = table.edges {
        settings.edges = builder.check(edges, edges_of)?;
    }
    if let Some(isolines) = table.isolines {
        settings.isolines = builder.check(isolines, isolines_of)?;
    }
    if let Some(shading) = table.shading {
        settings.analysis = Some(builder.check(shading, analysis_of)?);
    }
    if let Some(newton) = table.newton {
        settings.newton = builder.check(newton, |table| {
            let default = Newton::default();
            Newton::new(
                table.iterations.unwrap_or(default.iterations()),
                table.epsilon.unwrap_or(default.epsilon()),
            )
        })?;
    }
    let up = table.up.map(|up| builder.check(up, |name| name.parse())).transpose()?;
    Ok(Stage { settings, up })
}

fn edges_of(value: EdgesValue) -> Result<Option<Edges>> {
    let default = Edges::default();
    match value {
        EdgesValue::Shown(shown) => Ok(shown.then_some(default)),
        EdgesValue::As(EdgesTable { width, color, smooth }) => Ok(Some(Edges {
            width: width.map_or(Ok(default.width), LineWidth::new)?,
            color: match color {
                None => default.color,
                Some(EdgeColorValue::Rgb(rgb)) => EdgeColor::Rgb(unit_range("color", rgb)?),
                Some(EdgeColorValue::Named(name)) => name.parse()?,
            },
            smooth,
        })),
    }
}

fn analysis_of(value: AnalysisValue) -> Result<Analysis> {
    match value {
        AnalysisValue::Named(name) => Ok(name.parse::<AnalysisKind>()?.with_defaults()),
        AnalysisValue::As(table) => {
            let AnalysisTable { kind, stripes, direction, curvature, limit, limit_degrees } = table;
            let change = AnalysisChange {
                stripes: stripes.map(StripeCount::new).transpose()?,
                direction: direction.map(|own| Direction::new(own.into())).transpose()?,
                curvature: curvature.map(|name| name.parse()).transpose()?,
                limit: limit.map(CurvatureLimit::new).transpose()?,
                limit_degrees: limit_degrees.map(DraftLimit::new).transpose()?,
            };
            kind.parse::<AnalysisKind>()?.with_defaults().changed(&change)
        }
    }
}

fn isolines_of(value: IsolinesValue) -> Result<Option<Isolines>> {
    let default = Isolines::default();
    let IsolinesTable { count, width, color } = match value {
        IsolinesValue::Count(count) => {
            IsolinesTable { count: Some(count), ..IsolinesTable::default() }
        }
        IsolinesValue::As(table) => table,
    };
    let count = count.map_or(Ok(Some(default.count)), IsolineCount::or_none)?;
    let width = width.map_or(Ok(default.width), LineWidth::new)?;
    let color = unit_range("color", color.unwrap_or(default.color))?;
    Ok(count.map(|count| Isolines { count, width, color }))
}

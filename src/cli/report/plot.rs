//! Plots as SVG with logarithmic axes.

use crate::io::{Error, Result};
use plotters::prelude::*;

/// The points of one line of a plot.
#[derive(Debug, Clone)]
pub(super) struct Line {
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
}

/// Colours that people with red-green colour blindness can tell apart.
const COLORS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(120, 120, 120),
];

/// Lines over two logarithmic axes. Points that are not above 0 are left out. `mark` is a value of the second
/// axis at which a line is drawn across the plot.
///
/// # Errors
/// There is nothing to plot.
pub(super) fn plot(
    x_title: &str,
    y_title: &str,
    lines: &[Line],
    mark: Option<f64>,
) -> Result<String> {
    let is_drawn = |(x, y): &(f64, f64)| *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite();
    let points = || lines.iter().flat_map(|line| &line.points).filter(|point| is_drawn(point));
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) =
            values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        (0.8 * low)..(1.25 * high)
    };
    let x = range(&mut points().map(|(x, _)| *x));
    let y = range(&mut points().map(|(_, y)| *y).chain(mark));
    if !(x.start.is_finite() && y.start.is_finite()) {
        return Err(Error::invalid("plot", "empty", "something above 0"));
    }
    let mut svg = String::new();
    draw(&mut svg, (x_title, y_title), (x, y), lines, mark, is_drawn)
        .map_err(|error| Error::file("make", "a plot", error.to_string()))?;
    Ok(svg)
}

fn draw(
    svg: &mut String,
    (x_title, y_title): (&str, &str),
    (x, y): (std::ops::Range<f64>, std::ops::Range<f64>),
    lines: &[Line],
    mark: Option<f64>,
    is_drawn: impl Fn(&(f64, f64)) -> bool,
) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::with_string(svg, (720, 440)).into_drawing_area();
    area.fill(&WHITE)?;
    let ends = (x.start, x.end);
    let mut chart = ChartBuilder::on(&area)
        .margin(10)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(x.log_scale(), y.log_scale())?;
    chart
        .configure_mesh()
        .x_desc(x_title)
        .y_desc(y_title)
        .x_label_formatter(&|value| short(*value))
        .y_label_formatter(&|value| short(*value))
        .light_line_style(RGBColor(240, 240, 240))
        .draw()?;
    if let Some(mark) = mark {
        let across = [(ends.0, mark), (ends.1, mark)];
        chart.draw_series(LineSeries::new(across, BLACK.stroke_width(1)))?;
    }
    for (line, color) in lines.iter().zip(COLORS.iter().cycle()) {
        let points: Vec<_> = line.points.iter().copied().filter(|point| is_drawn(point)).collect();
        let style = color.stroke_width(2);
        chart
            .draw_series(LineSeries::new(points.iter().copied(), style))?
            .label(&line.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        chart.draw_series(points.iter().map(|point| Circle::new(*point, 3, color.filled())))?;
    }
    chart
        .configure_series_labels()
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(200, 200, 200))
        .draw()?;
    area.present()?;
    Ok(())
}

/// A number with as few digits as it needs on an axis.
fn short(value: f64) -> String {
    if (0.001..10_000.0).contains(&value) {
        let text = format!("{value:.3}");
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_become_an_svg() {
        let line =
            Line { name: "exact".into(), points: vec![(1.0, 0.5), (10.0, 0.0), (20.0, 0.1)] };
        let svg = plot("ms", "px", &[line], Some(0.5)).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        // The point at 0 is left out.
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(svg.contains("exact"));
        assert!(plot("ms", "px", &[], None).is_err());
    }

    #[test]
    fn labels_are_short() {
        assert_eq!([0.5, 10.0, 1e-4, 2e6].map(short), ["0.5", "10", "1e-4", "2e6"]);
    }
}

//! The trims of a `[[surface]]`.

use glam::{DVec2, DVec3};
use toml::Spanned;

use super::{Builder, KeepName, line_of};
use crate::error::{Error, Result};
use crate::scene::tables::{
    CircleTable, CurvePoint, EllipseTable, IntervalTable, NurbsTable, TrimTable,
};
use crate::scene::{Surface, svg, unreadable};
use crate::thesis::newton::NewtonTrims;
use crate::trim::{
    Circle, Ellipse, Keep, ParameterSizes, Rect, TrimCurve, TrimLoop, TrimPath, Trims,
};

/// The trims of one table, and where they are in the text.
pub(super) struct PlacedTrims {
    pub(super) trims: Trims,
    pub(super) places: TrimPlaces,
}

/// The byte offset in the text of the surface, of each loop and of each path.
#[derive(Clone, Default)]
pub(super) struct TrimPlaces {
    surface: usize,
    loops: Vec<usize>,
    paths: Vec<usize>,
}

impl TrimPlaces {
    /// Those of a surface without trims in the text.
    pub(super) fn of_surface(surface: usize) -> Self {
        Self { surface, ..Self::default() }
    }
}

impl Builder<'_> {
    pub(super) fn trims(
        &mut self,
        tables: Vec<Spanned<TrimTable>>,
        keep: KeepName,
        surface: &Surface,
        start: usize,
    ) -> Result<PlacedTrims> {
        let keep = match keep {
            KeepName::Outside => Keep::Outside,
            KeepName::Inside => Keep::Inside,
        };
        let mut trims = Trims { keep, ..Trims::default() };
        let mut places = TrimPlaces::of_surface(self.chunk + start);
        for table in tables {
            let start = table.span().start;
            let place = self.chunk + start;
            let (loops, paths) = (trims.loops.len(), trims.paths.len());
            self.add_trim(table.into_inner(), &mut trims, surface, place)
                .map_err(|error| self.at(start, error))?;
            let new_paths = trims.paths[paths..].iter().flat_map(|path| &path.loops);
            let [low, high] = surface.domain();
            if is_outside([low, high], trims.loops[loops..].iter().chain(new_paths)) {
                let [u, v] = [0, 1].map(|axis| format!("[{}, {}]", low[axis], high[axis]));
                let words = format!("this trim lies wholly outside of the domain, {u} × {v}");
                self.warn(place, &words);
            }
            places.loops.resize(trims.loops.len(), place);
            places.paths.resize(trims.paths.len(), place);
        }
        Ok(PlacedTrims { trims, places })
    }

    fn add_trim(
        &mut self,
        table: TrimTable,
        trims: &mut Trims,
        surface: &Surface,
        place: usize,
    ) -> Result<()> {
        let parameters = &surface.parameter_sizes();
        let TrimTable { circle, interval, ellipse, r#loop, nurbs, path, svg, fill_rule } = table;
        if fill_rule.is_some() && path.is_none() {
            return Err(Error::invalid("fill_rule", "without a path", "a path beside it"));
        }
        let curves = match (r#loop, nurbs) {
            (Some(_), Some(_)) => {
                return Err(Error::invalid("trim", "a loop beside nurbs", "one of them"));
            }
            (Some(segments), None) => Some(Curves::Bezier(segments)),
            (None, nurbs) => nurbs.map(Curves::Nurbs),
        };
        match (circle, interval, ellipse, curves, path, svg) {
            (Some(CircleTable { center, radius }), None, None, None, None, None) => {
                trims.circles.push(Circle::new(center.into(), radius)?);
            }
            (None, Some(IntervalTable { u, v }), None, None, None, None) => {
                trims.rects.push(Rect::new(u.into(), v.into())?);
            }
            (None, None, Some(EllipseTable { center, radii }), None, None, None) => {
                trims.ellipses.push(Ellipse::new(center.into(), radii.into())?);
            }
            (None, None, None, Some(curves), None, None) => {
                let trim_loop = loop_of(&curves, parameters)
                    .map_err(|error| error.within(format!("loop {}", trims.loops.len())))?;
                trims.add_loop(trim_loop)?;
            }
            (None, None, None, None, Some(data), None) => match fill_rule {
                None => trims.add_svg_path_over(&data, parameters)?,
                Some(rule) => {
                    let path = TrimPath::from_svg_path_over(&data, rule.into(), parameters)?;
                    trims.add_paths(vec![path])?;
                }
            },
            (None, None, None, None, None, Some(file)) => {
                self.add_svg(&file, trims, surface, place)?;
            }
            _ => {
                return Err(Error::invalid(
                    "trim",
                    "of no kind, or of several",
                    "one of circle, interval, ellipse, loop, nurbs, path, svg",
                ));
            }
        }
        Ok(())
    }

    /// Adds the paths of a document, which is fitted to the square [0, 1]² and then stretched over the domain.
    fn add_svg(
        &mut self,
        file: &str,
        trims: &mut Trims,
        surface: &Surface,
        place: usize,
    ) -> Result<()> {
        let path = self.beside_scene(file);
        let (mut paths, ignored) = svg::load(&path)?;
        let [low, high] = surface.domain();
        if [low, high] != [DVec2::ZERO, DVec2::ONE] {
            for one in paths.iter_mut().flat_map(|path| &mut path.loops) {
                *one = one.map(|place| low + place * (high - low));
            }
        }
        trims.add_paths(paths).map_err(|error| unreadable(&path, error))?;
        if !ignored.is_empty() {
            let (path, ignored) = (path.display(), ignored.join(", "));
            self.warn(place, &format!("of {path} only what is filled is taken, not its {ignored}"));
        }
        self.files.push(path);
        Ok(())
    }

    /// Logs a warning with the line of a byte of the text.
    fn warn(&self, place: usize, words: &str) {
        log::warn!("{}:{}: {words}", self.path.display(), line_of(self.text, place));
    }

    /// Refuses degrees that the thesis' method cannot draw and trims that it cannot cut.
    pub(super) fn check_for_thesis(&self, surface: &Surface, places: &TrimPlaces) -> Result<()> {
        surface.check_for_thesis().map_err(|error| self.at(places.surface, error))?;
        let trims = &surface.trims;
        let Err(error) = NewtonTrims::of(trims) else { return Ok(()) };
        if let Some(place) = places.paths.first() {
            return Err(self.at(*place, error));
        }
        // Only surfaces that were refused above have loops that are not in the text.
        Err(match NewtonTrims::sorted(&trims.loops) {
            Err((to_blame, error)) => self.at(places.loops[to_blame], error),
            Ok(_) => self.at(places.loops[0], error),
        })
    }
}

/// The curves of a loop.
enum Curves {
    Bezier(Vec<Vec<CurvePoint>>),
    Nurbs(Vec<NurbsTable>),
}

fn loop_of(curves: &Curves, parameters: &ParameterSizes) -> Result<TrimLoop> {
    let points_of =
        |points: &[CurvePoint]| points.iter().copied().map(DVec3::from).collect::<Vec<_>>();
    let curves: Vec<Result<TrimCurve>> = match curves {
        Curves::Bezier(segments) => {
            segments.iter().map(|points| TrimCurve::bezier(&points_of(points))).collect()
        }
        Curves::Nurbs(tables) => tables
            .iter()
            .map(|table| TrimCurve::nurbs(table.degree, &table.knots, &points_of(&table.points)))
            .collect(),
    };
    let curves = curves
        .into_iter()
        .enumerate()
        .map(|(number, curve)| curve.map_err(|error| error.within(format!("segment {number}"))));
    TrimLoop::from_curves_over(&curves.collect::<Result<Vec<_>>>()?, parameters)
}

/// Whether there are loops and all of them lie outside the domain.
fn is_outside<'a>(
    [first, last]: [DVec2; 2],
    mut loops: impl Iterator<Item = &'a TrimLoop> + Clone,
) -> bool {
    let beyond = |trim_loop: &TrimLoop| {
        let [low, high] = trim_loop.control_box();
        high.cmplt(first).any() || low.cmpgt(last).any()
    };
    loops.clone().next().is_some() && loops.all(beyond)
}

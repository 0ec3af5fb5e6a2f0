//! The grid against the oracle, on random and on hard loops.

use super::*;
use crate::trim::{Segment, TrimLoop, TrimPath};
use glam::{DVec2, dvec2, vec2};
use proptest::prelude::*;

impl TrimGrid {
    /// Whether a sample is inside even-odd loops, without the grid: every piece is tested.
    fn inside_by_all_pieces(&self, uv: Vec2) -> bool {
        self.words[self.pieces.clone()]
            .chunks_exact(8)
            .fold(false, |inside, words| inside ^ Piece::from_words(words).crosses(uv))
    }
}

fn closed(points: &[DVec2]) -> TrimLoop {
    let n = points.len();
    let segment = |i: usize| {
        let at = |k: usize| points[(3 * i + k) % n];
        Segment::Cubic([at(0), at(1), at(2), at(3)])
    };
    TrimLoop::new((0..n / 3).map(segment).collect()).unwrap()
}

fn even_odd(loops: &[TrimLoop]) -> Trims {
    Trims { loops: loops.to_vec(), ..Trims::default() }
}

fn grid_of(loops: &[TrimLoop]) -> TrimGrid {
    TrimGrid::new(&even_odd(loops))
}

/// Distance from a curve, by sampling.
fn distance(trims: &Trims, uv: DVec2) -> f64 {
    let mut min = f64::INFINITY;
    for segment in trims.all_loops().flat_map(TrimLoop::segments) {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..12 {
            let steps = 64;
            let at = |i: i32| low + (high - low) * f64::from(i) / f64::from(steps);
            let best = (0..=steps)
                .min_by(|a, b| {
                    let to = |i: i32| segment.point(at(i)).distance(uv);
                    to(*a).total_cmp(&to(*b))
                })
                .unwrap();
            min = min.min(segment.point(at(best)).distance(uv));
            (low, high) = (at((best - 1).max(0)), at((best + 1).min(steps)));
        }
    }
    min
}

fn check(loops: &[TrimLoop], samples: impl Iterator<Item = Vec2> + Clone) {
    let trims = even_odd(loops);
    let grid = TrimGrid::new(&trims);
    for uv in samples.clone() {
        assert_eq!(grid.cut(uv), grid.inside_by_all_pieces(uv), "grid and pieces at {uv:?}");
    }
    check_trims(&trims, samples);
}

/// Checks the grid against the oracle; returns how many samples are cut.
fn check_trims(trims: &Trims, samples: impl Iterator<Item = Vec2>) -> usize {
    let grid = TrimGrid::new(trims);
    let mut cut = 0;
    for uv in samples {
        let decided = grid.cut(uv);
        cut += usize::from(decided);
        let uv = uv.as_dvec2();
        if decided != trims.cut(uv) {
            let off = distance(trims, uv);
            assert!(off < 2e-7, "{uv}: decided {decided}, {off:e} from the curve");
        }
    }
    cut
}

fn lattice_samples(n: u32) -> impl Iterator<Item = Vec2> + Clone {
    (0..n * n).map(move |i| (vec2((i % n) as f32, (i / n) as f32) + 0.5) / n as f32)
}

fn point() -> impl Strategy<Value = DVec2> {
    (-0.3..1.3, -0.3..1.3).prop_map(|(x, y)| dvec2(x, y))
}

#[test]
fn a_sample_exactly_on_a_cell_edge_is_decided_right() {
    let points = [(0.13, 0.2), (0.3, 0.9), (0.9, 1.1), (0.8, 0.5), (0.7, 0.0), (0.2, -0.2)];
    let loops = [closed(&points.map(|(u, v)| dvec2(u, v)))];
    let grid = grid_of(&loops);
    let uniform_grid = grid.loops.unwrap().uniform_grid;
    let around = |x: f32| [x.next_down(), x, x.next_up()];
    let edges = |axis: usize| -> Vec<f32> {
        let edges = uniform_grid.bounds(axis).into_iter().flatten().flat_map(around);
        edges.filter(|x| (0.0..1.0).contains(x)).collect()
    };
    let (us, vs) = (edges(0), edges(1));
    check(&loops, vs.iter().flat_map(|v| us.iter().map(move |u| vec2(*u, *v))));
}

/// Samples on both sides of every curve, starting just outside the tolerance.
fn beside<'a>(loops: impl IntoIterator<Item = &'a TrimLoop>) -> Vec<Vec2> {
    let mut samples = Vec::new();
    for segment in loops.into_iter().flat_map(TrimLoop::segments) {
        for t in (0..=200).map(|i| f64::from(i) / 200.0) {
            let along = segment.point(t + 1e-4) - segment.point(t - 1e-4);
            let across = along.normalize_or(DVec2::X).perp();
            for off in [4e-7, 3e-6, 1e-4] {
                let at = segment.point(t);
                samples.extend([at + across * off, at - across * off].map(DVec2::as_vec2));
            }
        }
    }
    samples.retain(|uv| uv.cmpge(Vec2::ZERO).all() && uv.cmplt(Vec2::ONE).all());
    samples
}

#[test]
fn samples_close_to_curves_with_inflections_and_cusps_are_decided_right() {
    let s_curve = [(0.1, 0.5), (0.5, 0.5), (0.5, 0.52), (0.9, 0.52), (0.9, 0.1), (0.1, 0.1)];
    let steep = [(0.5, 0.1), (0.5, 0.5), (0.52, 0.5), (0.52, 0.9), (0.1, 0.9), (0.1, 0.1)];
    let cusp = [(0.2, 0.4), (0.8, 0.9), (0.2, 0.9), (0.8, 0.4), (0.7, 0.1), (0.3, 0.1)];
    let knot = [(0.2, 0.3), (1.2, 1.0), (-0.2, 1.0), (0.8, 0.3), (0.8, 0.3), (0.2, 0.3)];
    for points in [s_curve, steep, cusp, knot] {
        let loops = [closed(&points.map(|(u, v)| dvec2(u, v)))];
        let samples = beside(&loops);
        assert!(samples.len() > 2000);
        check(&loops, samples.into_iter());
    }
}

#[test]
fn a_crowd_in_one_cell_is_decided_right() {
    let lens = |i: i32| {
        let at = dvec2(0.5 + 0.0004 * f64::from(i % 20), 0.5 + 0.0004 * f64::from(i / 20));
        let off = [(0., 0.), (0.1, 0.1), (0.2, 0.1), (0.3, 0.), (0.2, -0.1), (0.1, -0.1)];
        closed(&off.map(|(u, v)| at + 0.001 * dvec2(u, v)))
    };
    let around = [(0.1, 0.1), (0.1, 0.9), (0.9, 0.9), (0.9, 0.1), (0.8, 0.0), (0.2, 0.0)];
    let mut loops: Vec<TrimLoop> = (0..400).map(lens).collect();
    loops.push(closed(&around.map(|(u, v)| dvec2(u, v))));
    assert!(grid_of(&loops).has_finer_cells());
    check(&loops, lattice_samples(64).map(|uv| 0.499 + 0.01 * uv));
    check(&loops, lattice_samples(64));
}

#[test]
fn lists_of_every_length_are_decided_right() {
    // Triangles that meet in one point: the cell there lists two pieces of each triangle and a few others.
    let mut kinds = [0; 2];
    for count in (3..=40).chain([120]) {
        let mut trims = Trims::default();
        for i in 0..count {
            let corner = |turn: f64| dvec2(0.47, 0.53) + 0.4 * DVec2::from_angle(turn);
            let [a, b] = [corner(0.051 * f64::from(i)), corner(0.051 * f64::from(i) + 0.03)];
            let path = format!("M.47 .53 L{} {} {} {}Z", a.x, a.y, b.x, b.y);
            trims.add_svg_path(&path).unwrap();
        }
        let grid = TrimGrid::new(&trims);
        kinds[usize::from(grid.has_long_lists())] += 1;
        check(&trims.loops, lattice_samples(64));
        check(&trims.loops, lattice_samples(64).map(|uv| 0.46 + 0.02 * uv + vec2(0.0, 0.06)));
    }
    assert!(kinds.iter().all(|kind| *kind > 3), "{kinds:?}");
}

#[test]
fn many_shapes_are_decided_as_their_equations_say() {
    use crate::trim::{Circle, Ellipse, Rect};
    let mut trims = Trims::default();
    for i in 0..300 {
        let i = f64::from(i);
        let center = dvec2((i * 0.618).fract() * 1.4 - 0.2, (i * 0.755).fract() * 1.4 - 0.2);
        let radius = 0.002 + 0.03 * (i * 0.37).fract();
        match i as u32 % 3 {
            0 => trims.circles.push(Circle::new(center, radius).unwrap()),
            1 => trims.ellipses.push(Ellipse::new(center, dvec2(radius, 0.01)).unwrap()),
            _ => {
                let range = |x: f64| dvec2(x - radius, x + 0.5 * radius);
                let interval = Rect::new(range(center.x), range(center.y)).unwrap();
                trims.rects.push(interval);
            }
        }
    }
    // Huge shapes far away, whose borders are nearly straight lines in the domain.
    trims.circles.push(Circle::new(dvec2(1e6 + 0.97, 0.3), 1e6).unwrap());
    trims.ellipses.push(Ellipse::new(dvec2(0.4, -1e5), dvec2(3e4, 1e5 + 0.05)).unwrap());
    let grid = TrimGrid::new(&trims);
    let mut cut = 0;
    for uv in lattice_samples(500) {
        let decided = grid.cut(uv);
        cut += usize::from(decided);
        let at = uv.as_dvec2();
        let near = |angle: f64| trims.cut(at + 2e-7 * DVec2::from_angle(angle)) == decided;
        if decided != trims.cut(at) {
            assert!((0..16).any(|i| near(f64::from(i) * 0.4)), "{uv:?}");
        }
    }
    assert!((20_000..230_000).contains(&cut), "{cut}");
    trims.circles_on = false;
    assert!(!TrimGrid::new(&trims).cut(vec2(0.999, 0.3)));
}

#[test]
fn rectangles_are_cut_throughout_only_if_all_their_samples_are() {
    let text = "M.1 .1 C.3 .9 .6 .9 .9 .2 Z";
    let mut trims = Trims::default();
    trims.add_svg_path(text).unwrap();
    trims.circles.push(crate::trim::Circle::new(dvec2(0.7, 0.7), 0.2).unwrap());
    for keep in [Keep::Outside, Keep::Inside] {
        trims.keep = keep;
        let grid = TrimGrid::new(&trims);
        let mut said = [0; 3];
        for i in 0..256 {
            let min = vec2((i % 16) as f32, (i / 16) as f32) / 16.0;
            let max = min + 1.0 / 16.0;
            let samples = || lattice_samples(9).map(|uv| min + uv * 9.0 / 8.0 * 0.0625);
            match grid.cut_throughout(min, max) {
                None => said[2] += 1,
                Some(cut) => {
                    said[usize::from(cut)] += 1;
                    let inside = |uv: Vec2| uv.min(max - f32::EPSILON);
                    assert!(samples().all(|uv| grid.cut(inside(uv)) == cut), "{min}");
                }
            }
        }
        assert!(said.iter().all(|count| *count > 20), "{said:?}");
    }
}

#[test]
fn paths_of_their_own_rules_are_decided_right_alone_together_and_in_crowds() {
    let star = "M.5 1 L.21 .1 L.98 .65 L.02 .65 L.79 .1 Z";
    let path = |rule: FillRule| TrimPath::from_svg_path(star, rule).unwrap();
    let ring = |at: DVec2, size: f64, rule: FillRule| {
        let square = |half: f64| {
            let (low, high) = (at - half * size, at + half * size);
            format!("M{} {}H{}V{}H{}Z", low.x, low.y, high.x, high.y, low.x)
        };
        TrimPath::from_svg_path(&(square(0.5) + &square(0.25)), rule).unwrap()
    };
    let middle = dvec2(0.5, 0.5);
    let islands = even_odd(&ring(middle, 0.3, FillRule::EvenOdd).loops);
    let crowd = |count: u32| {
        let rules = [FillRule::NonZero, FillRule::EvenOdd];
        let at = |i: u32| dvec2(f64::from(i * 37 % 101), f64::from(i * 53 % 89)) * 1e-4;
        let one = |i: u32| ring(0.5 + at(i), 0.002, rules[i as usize % 2]);
        (0..count).map(one).collect::<Vec<_>>()
    };
    let [odd, non_zero] = [FillRule::EvenOdd, FillRule::NonZero].map(path);
    let scene = |paths: Vec<TrimPath>, trims: &Trims| Trims { paths, ..trims.clone() };
    let mut cuts = Vec::new();
    for mut trims in [
        scene(vec![odd.clone()], &Trims::default()),
        scene(vec![non_zero.clone()], &Trims::default()),
        scene(vec![odd, ring(middle, 0.1, FillRule::NonZero)], &Trims::default()),
        scene(vec![non_zero], &islands),
        scene(crowd(3), &islands),
        scene(crowd(300), &islands),
    ] {
        for keep in [Keep::Outside, Keep::Inside] {
            trims.keep = keep;
            let near = lattice_samples(64).map(|uv| 0.499 + 0.013 * uv);
            let samples = lattice_samples(128).chain(near).chain(beside(trims.all_loops()));
            cuts.push(check_trims(&trims, samples));
        }
    }
    // The star's middle is cut by one rule and not by the other.
    assert!(cuts[2] > cuts[0] + 500, "{cuts:?}");
    assert!(TrimGrid::new(&scene(crowd(300), &islands)).has_finer_cells());
}

/// The border of the domain as a CAD system may write it: in several curves, off by rounding.
fn border(off: f64, reversed: bool) -> TrimLoop {
    let noise = |i: usize| off * [1.0, -1.0, 0.5, -0.3][i % 4];
    let mut points = Vec::new();
    for (i, [u, v]) in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].into_iter().enumerate() {
        let [next_u, next_v] = [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]][i];
        for k in 0..3 {
            let t = f64::from(k) / 3.0;
            let at = dvec2(u + (next_u - u) * t, v + (next_v - v) * t);
            points.push(at + dvec2(noise(points.len()), noise(points.len() + 1)));
        }
    }
    if reversed {
        points[1..].reverse();
    }
    closed(&points)
}

#[test]
fn loops_that_only_follow_the_border_cost_nothing() {
    for (off, reversed) in [(0.0, false), (0.0, true), (2e-8, false), (3e-8, true)] {
        for rule in [None, Some(FillRule::NonZero), Some(FillRule::EvenOdd)] {
            for keep in [Keep::Inside, Keep::Outside] {
                let loops = vec![border(off, reversed)];
                let mut trims = Trims { keep, ..Trims::default() };
                match rule {
                    None => trims.loops = loops,
                    Some(rule) => trims.paths.push(TrimPath { loops, rule }),
                }
                let grid = TrimGrid::new(&trims);
                assert_eq!(grid.loop_columns(), None, "{off} {reversed} {rule:?}");
                assert_eq!(grid.words().len(), HEADER_WORDS);
                let all = lattice_samples(33).all(|uv| grid.cut(uv) == (keep == Keep::Outside));
                assert!(all, "{off} {reversed} {rule:?} {keep:?}");
            }
        }
    }
}

#[test]
fn a_hole_within_the_border_costs_what_it_costs_alone() {
    let hole = || {
        closed(
            &[(0.3, 0.4), (0.5, 0.9), (0.7, 0.8), (0.8, 0.5), (0.7, 0.2), (0.4, 0.1)]
                .map(DVec2::from),
        )
    };
    let alone = Trims { loops: vec![hole()], ..Trims::default() };
    let within =
        Trims { loops: vec![border(0.0, false), hole()], keep: Keep::Inside, ..Trims::default() };
    let lists = |grid: &TrimGrid| {
        let cells = grid.loops.unwrap().uniform_grid.count();
        grid.words[HEADER_WORDS..][..cells].iter().filter(|cell| **cell & LIST != 0).count()
    };
    let [alone, grid] = [&alone, &within].map(TrimGrid::new);
    assert_eq!(lists(&grid), lists(&alone));
    assert!(lattice_samples(257).all(|uv| grid.cut(uv) == alone.cut(uv)));
}

#[test]
fn a_loop_along_part_of_the_border_is_decided_right() {
    // A corner of the domain, cut off by curves; its border runs along two sides of the domain.
    for (w, h) in [(0.5, 0.25), (0.7, 1.0), (1.0, 0.3)] {
        for [flip_u, flip_v] in [[false, false], [true, false], [false, true], [true, true]] {
            let at = |u: f64, v: f64| {
                dvec2(if flip_u { 1.0 - u } else { u }, if flip_v { 1.0 - v } else { v })
            };
            let corner = [
                at(0.0, 0.0),
                at(0.3 * w, 0.0),
                at(0.7 * w, 0.0),
                at(w, 0.0),
                at(w, 0.4 * h),
                at(0.4 * w, 0.8 * h),
                at(0.0, h),
                at(0.0, 0.7 * h),
                at(0.0, 0.3 * h),
            ];
            for keep in [Keep::Inside, Keep::Outside] {
                let trims = Trims { keep, ..even_odd(&[closed(&corner)]) };
                let grid = TrimGrid::new(&trims);
                for uv in lattice_samples(129) {
                    let place = uv.as_dvec2();
                    if grid.cut(uv) != trims.cut(place) {
                        let off = distance(&trims, place);
                        assert!(off < 2e-7, "{uv} is {off} from {w} {h} {flip_u} {flip_v}");
                    }
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn random_paths_are_decided_as_the_oracle_does(
        paths in prop::collection::vec(
            (prop::collection::vec(prop::collection::vec(point(), 6..=15), 1..4), any::<bool>()),
            1..6,
        ),
        together in prop::collection::vec(point(), 6..=15),
        inside in any::<bool>(),
    ) {
        let chain = |points: &Vec<DVec2>| closed(&points[..points.len() / 3 * 3]);
        let rule = |non_zero| if non_zero { FillRule::NonZero } else { FillRule::EvenOdd };
        let mut trims = even_odd(&[chain(&together)]);
        trims.keep = if inside { Keep::Inside } else { Keep::Outside };
        trims.paths = paths
            .iter()
            .map(|(loops, non_zero)| {
                TrimPath { loops: loops.iter().map(chain).collect(), rule: rule(*non_zero) }
            })
            .collect();
        check_trims(&trims, lattice_samples(48));
        check_trims(&trims, beside(trims.all_loops()).into_iter().step_by(7));
    }

    #[test]
    fn random_loops_are_decided_as_the_oracle_does(
        loops in prop::collection::vec(prop::collection::vec(point(), 6..=15), 1..4),
    ) {
        let loops: Vec<TrimLoop> =
            loops.iter().map(|points| closed(&points[..points.len() / 3 * 3])).collect();
        check(&loops, lattice_samples(48));
        check(&loops, beside(&loops).into_iter().step_by(7));
    }
}

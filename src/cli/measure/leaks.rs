//! The leaks of a scene's pictures, in words and as JSON.

use std::collections::BTreeMap;

use freeform_surface::inspect::measure::{LeakKind, Leaks};
use serde::Serialize;

/// No more edges than this are named.
const MOST: usize = 5;

/// The leaks of all pictures of a scene with CAD models.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct LeakCounts {
    /// By what they show: the background, a face from the inside of its solid, a hidden face from outside.
    kinds: [usize; 3],
    /// Pictures that have leaks.
    views: u64,
    /// The leaks at each edge: the number of the model, and that of the edge.
    edges: BTreeMap<[usize; 2], usize>,
    /// The largest gap of the data in a picture, in pixels.
    gap_px: f64,
    /// Open edges of the models.
    open_edges: usize,
    has_closed: bool,
}

/// The keys that a scene with CAD models adds to the JSON object.
#[derive(Serialize)]
pub(super) struct LeakObject {
    /// Null if no product is closed.
    leaks: Option<usize>,
    background_leaks: usize,
    back_side_leaks: usize,
    leaking_views: u64,
    leaking_edges: Vec<LeakingEdgeObject>,
    gap_px: f64,
    open_edges: usize,
}

#[derive(Serialize)]
struct LeakingEdgeObject {
    model: usize,
    edge: usize,
    leaks: usize,
}

impl LeakCounts {
    pub(super) fn new(open_edges: usize, has_closed: bool) -> Self {
        Self { open_edges, has_closed, ..Self::default() }
    }

    /// Adds the leaks of a picture.
    pub(super) fn add(&mut self, leaks: &Leaks) {
        for leak in &leaks.found {
            let kind = match leak.kind {
                LeakKind::Background => 0,
                LeakKind::BackSide => 1,
                LeakKind::Hidden => 2,
            };
            self.kinds[kind] += 1;
            if let Some(edge) = leak.edge {
                *self.edges.entry([edge.model, edge.edge]).or_default() += 1;
            }
        }
        self.views += u64::from(!leaks.found.is_empty());
        self.gap_px = self.gap_px.max(leaks.gap_px);
    }

    fn count(&self) -> usize {
        self.kinds.iter().sum()
    }

    /// The edges with the most leaks first.
    fn worst(&self) -> Vec<([usize; 2], usize)> {
        let mut edges: Vec<_> = self.edges.iter().map(|(edge, count)| (*edge, *count)).collect();
        edges.sort_by_key(|(edge, count)| (std::cmp::Reverse(*count), *edge));
        edges
    }

    /// The end of the line of text.
    pub(super) fn words(&self) -> String {
        let mut words = Vec::new();
        if self.has_closed {
            let mut leaks = format!("{} leaks", self.count());
            let worst = self.worst();
            if !worst.is_empty() {
                let name = |([model, edge], count): &([usize; 2], usize)| {
                    let of = if *model > 0 { format!(" of model {model}") } else { String::new() };
                    format!("{count} at edge {edge}{of}")
                };
                let named: Vec<_> = worst.iter().take(MOST).map(name).collect();
                let more = if worst.len() > MOST { ", …" } else { "" };
                leaks += &format!(" in {} views ({}{more})", self.views, named.join(", "));
            }
            words.push(leaks);
            words.push(format!("gaps of the data up to {:.1e} px", self.gap_px));
        }
        if self.open_edges > 0 {
            words.push(format!("not closed: {} open edges", self.open_edges));
        }
        words.join(", ")
    }

    pub(super) fn object(&self) -> LeakObject {
        let edge =
            |([model, edge], leaks): ([usize; 2], usize)| LeakingEdgeObject { model, edge, leaks };
        LeakObject {
            leaks: self.has_closed.then(|| self.count()),
            background_leaks: self.kinds[0],
            back_side_leaks: self.kinds[1],
            leaking_views: self.views,
            leaking_edges: self.worst().into_iter().map(edge).collect(),
            gap_px: self.gap_px,
            open_edges: self.open_edges,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use freeform_surface::inspect::measure::{Leak, LeakingEdge};
    use glam::UVec2;

    #[test]
    fn leaks_are_told_by_their_edges_and_open_models_by_their_open_ones() {
        let leak = |edge| {
            let edge = Some(LeakingEdge { model: 0, edge, distance_px: 0.5 });
            Leak { pixel: UVec2::ZERO, kind: LeakKind::BackSide, depth: 1.0, edge }
        };
        let mut counts = LeakCounts::new(0, true);
        assert_eq!(counts.words(), "0 leaks, gaps of the data up to 0.0e0 px");
        let found = [7, 3, 7].map(leak).to_vec();
        counts.add(&Leaks { found, gap_px: 0.002, suspects: 9 });
        counts.add(&Leaks::default());
        let words =
            "3 leaks in 1 views (2 at edge 7, 1 at edge 3), gaps of the data up to 2.0e-3 px";
        assert_eq!(counts.words(), words);
        let object = serde_json::to_value(counts.object()).unwrap();
        assert_eq!((&object["leaks"], &object["back_side_leaks"]), (&3.into(), &3.into()));
        assert_eq!(object["leaking_edges"][0]["edge"], 7);
        let open = LeakCounts::new(4, false);
        assert_eq!(open.words(), "not closed: 4 open edges");
        assert!(serde_json::to_value(open.object()).unwrap()["leaks"].is_null());
    }
}

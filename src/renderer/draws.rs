//! What patches of surfaces and triangles of meshes have in common when they are drawn: the key of
//! a plan, the division of OpenGL patches into draws, and the loop that makes the draw calls.
#![allow(unsafe_code, reason = "drawing is unsafe in glow")]

use glam::UVec2;
use glow::HasContext;

use super::capture::{DrawnVertex, Feedback};
use super::{Frame, Renderer};
use crate::camera::ViewProjection;
use crate::error::Result;
use crate::scene::Tessellation;
use crate::tessellation::{DrawSize, Tessellated, patches_of_next_draw};

/// The inputs of a plan that come from the frame. While they stay the same, the plan stays valid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlanKey {
    pub(super) camera: ViewProjection,
    /// Width and height in pixels.
    pub(super) size: UVec2,
    pub(super) tessellation: Tessellation,
}

impl PlanKey {
    pub(super) fn new(frame: &Frame, tessellation: Tessellation) -> Self {
        Self { camera: frame.camera, size: frame.viewport.pixels(), tessellation }
    }
}

/// One draw call: consecutive OpenGL patches that share the program and all bindings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Draw {
    /// The index of their batch; for meshes, of their paint.
    pub(super) batch: usize,
    /// The index of the first patch.
    pub(super) first: usize,
    /// The number of patches of an instance.
    pub(super) count: usize,
    /// The number of instances; each has the patches after those of the one before.
    pub(super) instances: usize,
    /// The number of triangles that the tessellator generates for them.
    pub(super) triangles: u64,
}

/// Divides the patches of a batch into draws of at most so many vertices, unless a patch has more. `first` is the
/// index of the first patch. Draws begin and end with a patch that has vertices.
pub(super) fn divide<T: Tessellated>(
    patches: &[T],
    first: usize,
    batch: usize,
    max_vertices: u32,
    draws: &mut Vec<Draw>,
) {
    let is_drawn = |patch: &T| patch.vertices() > 0;
    let mut begin = 0;
    while let Some(next) = patches[begin..].iter().position(is_drawn) {
        begin += next;
        let rest = &patches[begin..];
        let fitting = patches_of_next_draw(rest.iter().map(T::vertices), max_vertices);
        let count = rest[..fitting].iter().rposition(is_drawn).map_or(fitting, |last| last + 1);
        let triangles = rest[..count].iter().map(T::triangles).sum();
        draws.push(Draw { batch, first: first + begin, count, instances: 1, triangles });
        begin += count;
    }
}

/// The number of triangles that the software driver begins to fill beside the next draw.
const WORTH_A_FLUSH: u64 = 16_000;
/// A draw has at most so many instances,
const INSTANCES: usize = 20;
/// or those of so small a part of its batch.
const PARTS: usize = 16;

/// Divides the patches of a batch into few draws of several instances, so that an instance has the size that suits the
/// driver: at most `max_vertices`, if it is the only one, otherwise from half to twice as many. Drivers tessellate the
/// instances of a draw one after the other, as if they were draws. A large batch has several draws, so that pixels of
/// one can be filled while the next one is tessellated ([`Renderer::make_draws`]).
pub(super) fn divide_into_instances<T: Tessellated>(
    patches: &[T],
    first: usize,
    batch: usize,
    max_vertices: u32,
    draws: &mut Vec<Draw>,
) {
    let mut begin = 0;
    while begin < patches.len() {
        let rest = &patches[begin..];
        let count = patches_of_next_draw(rest.iter().map(T::vertices), max_vertices);
        let is_alike = |group: &&[T]| {
            let vertices: u32 = group.iter().map(T::vertices).sum();
            (max_vertices / 2..=2 * max_vertices).contains(&vertices)
        };
        let most = INSTANCES.max(patches.len() / count / PARTS);
        let others = rest[count..].chunks_exact(count).take(most - 1);
        let others = others.take_while(is_alike).count();
        let instances = 1 + others;
        let triangles = rest[..count * instances].iter().map(T::triangles).sum();
        draws.push(Draw { batch, first: first + begin, count, instances, triangles });
        begin += count * instances;
    }
}

impl Renderer {
    /// Makes the draw calls, for patches of `patch_vertices` vertices. `bind` binds what a draw needs
    /// and the caller has not bound; its second argument is whether the draw begins a batch. The
    /// triangles are written to `captured`, if it is given, otherwise to the framebuffer.
    ///
    /// # Errors
    /// Captured triangles that do not fit the driver's memory.
    pub(super) fn make_draws(
        &self,
        draws: &[Draw],
        patch_vertices: usize,
        mut bind: impl FnMut(&Draw, bool),
        mut captured: Option<&mut Vec<DrawnVertex>>,
    ) -> Result<()> {
        // Mesa's software driver fills no pixel before it is told to. It then does so beside the next draw.
        let overlaps = self.draw_size() == DrawSize::Small && captured.is_none();
        let mut waiting = 0;
        let mut bound = None;
        for draw in draws {
            bind(draw, bound.replace(draw.batch) != Some(draw.batch));
            let feedback = match captured {
                Some(_) => Some(
                    Feedback::begin(self.gl(), draw.triangles).inspect_err(|_| self.release())?,
                ),
                None => None,
            };
            let [first, count] = [draw.first, draw.count].map(|n| (n * patch_vertices) as i32);
            // SAFETY: the context is current (see the renderer); the range lies within the vertex
            // buffer that the caller or `bind` has bound, whose size in bytes was checked to fit an
            // i32.
            unsafe {
                match draw.instances {
                    1 => self.gl().draw_arrays(glow::PATCHES, first, count),
                    instances => self.gl().draw_arrays_instanced(
                        glow::PATCHES,
                        first,
                        count,
                        instances as i32,
                    ),
                }
            }
            waiting += draw.triangles;
            if overlaps && waiting >= WORTH_A_FLUSH {
                // SAFETY: the context is current (see the renderer).
                unsafe { self.gl().flush() };
                waiting = 0;
            }
            if let (Some(feedback), Some(captured)) = (feedback, captured.as_deref_mut()) {
                feedback.end(captured);
            }
        }
        self.release();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A patch of so many vertices.
    struct Vertices(u32);

    impl Tessellated for Vertices {
        fn vertices(&self) -> u32 {
            self.0
        }

        fn triangles(&self) -> u64 {
            u64::from(self.0)
        }
    }

    #[test]
    fn instances_hold_every_patch_once_and_are_neither_small_nor_large() {
        const MAX: u32 = 800;
        let sizes = |i: u32| match i {
            0..2_000 => 25,
            2_000..2_100 => 4_225,
            2_100..5_000 => 4 + i * 7919 % 300,
            _ => 289,
        };
        let patches: Vec<Vertices> = (0..9_000).map(|i| Vertices(sizes(i))).collect();
        let mut draws = Vec::new();
        divide_into_instances(&patches, 10, 3, MAX, &mut draws);
        let mut next = 10;
        for draw in &draws {
            assert_eq!((draw.first, draw.batch), (next, 3));
            let own = &patches[draw.first - 10..][..draw.count * draw.instances];
            next += own.len();
            assert_eq!(draw.triangles, own.iter().map(Vertices::triangles).sum::<u64>());
            for instance in own.chunks_exact(draw.count) {
                let vertices: u32 = instance.iter().map(Vertices::vertices).sum();
                assert!(vertices <= 2 * MAX || draw.count == 1, "{vertices}");
                assert!(vertices >= MAX / 2 || draw.instances == 1, "{vertices}");
            }
        }
        assert_eq!(next, 10 + patches.len());
        assert!(draws.len() < 250, "{} draws", draws.len());
    }
}

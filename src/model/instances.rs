//! The faces of a model in all places where its products are used.

use glam::DAffine3;

use super::{Face, Model, Product};
use crate::error::{Error, Result};

/// A face in a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// The number of the face.
    pub face: usize,
    /// From the face's space to that of the whole model.
    pub placement: DAffine3,
    /// The colour here: the face's own, else that of the nearest use or product around it that has one.
    pub color: Option<[f32; 3]>,
}

impl Model {
    /// The maximum number of faces in all places, and of uses of products.
    pub const MAX_INSTANCES: usize = 1_000_000;

    /// The faces of the last product and of the products that it uses, in every place. A product's own faces come
    /// before those of its uses, in the order of the file. Empty for a model without products.
    ///
    /// # Errors
    /// More than [`Model::MAX_INSTANCES`] faces or uses of products, which is found out before they are listed; a
    /// placement that is not finite.
    ///
    /// # Panics
    /// If a model that [`Model::check`] refuses names a face or product that does not exist.
    pub fn instances(&self) -> Result<Vec<Instance>> {
        let counts = self.counts();
        let Some((top, counts_of_top)) = self.products.last().zip(counts.last()) else {
            return Ok(Vec::new());
        };
        let Counts { faces, uses } = *counts_of_top;
        for (name, count) in [("faces in all places", faces), ("uses of products", uses)] {
            if count > Self::MAX_INSTANCES {
                let value = if count == usize::MAX {
                    format!("at least {count}")
                } else {
                    count.to_string()
                };
                let expected = format!("at most {}", Self::MAX_INSTANCES);
                return Err(Error::invalid(format!("number of {name}"), value, expected));
            }
        }
        let mut instances = Vec::with_capacity(faces);
        let mut next = vec![(top, DAffine3::IDENTITY, top.color)];
        while let Some((product, placement, color)) = next.pop() {
            let [first, count] = product.faces;
            let face = |(i, face): (usize, &Face)| Instance {
                face: first + i,
                placement,
                color: face.color.or(color),
            };
            instances.extend(self.faces[first..first + count].iter().enumerate().map(face));
            for used in product.uses.iter().rev().filter(|used| counts[used.product].faces > 0) {
                let placed = placement * used.placement;
                if !placed.is_finite() {
                    let name = format!("placement of product {}", used.product);
                    return Err(Error::invalid(
                        name,
                        "too large",
                        "finite numbers in the whole model",
                    ));
                }
                let product = &self.products[used.product];
                next.push((product, placed, used.color.or(product.color).or(color)));
            }
        }
        Ok(instances)
    }

    /// What is in each product and in the products that it uses, without walking through all uses.
    fn counts(&self) -> Vec<Counts> {
        let mut counts: Vec<Counts> = Vec::with_capacity(self.products.len());
        for Product { faces, uses, .. } in &self.products {
            let own = Counts { faces: faces[1], uses: 0 };
            let with_faces = uses.iter().map(|used| counts[used.product]).filter(|of| of.faces > 0);
            let sum = with_faces.fold(own, |sum, of| Counts {
                faces: sum.faces.saturating_add(of.faces),
                uses: sum.uses.saturating_add(of.uses).saturating_add(1),
            });
            counts.push(sum);
        }
        counts
    }
}

/// The faces in a product and in all that it uses, and the uses of products that have faces. They stop at `usize::MAX`.
#[derive(Debug, Clone, Copy)]
struct Counts {
    faces: usize,
    uses: usize,
}

#[cfg(test)]
mod tests;

//! What bends a primitive before its node places it: skins, at rest, and morph targets.

use super::document::Primitive;
use super::{Reader, label};
use glam::{DMat4, Vec3};
use windfall_core::InputError;
use windfall_core::InputErrorKind::{Malformed, NotFinite, OutOfRange};

impl Reader<'_> {
    /// For each vertex of a skinned primitive its transform to the file's world: the joints as their nodes stand,
    /// times the inverse bind matrices. By glTF the node of the mesh has no part in it.
    pub fn skinned(
        &mut self,
        skin: usize,
        primitive: &Primitive,
        vertices: usize,
        here: &str,
    ) -> Result<Vec<DMat4>, InputError> {
        let skins = &self.document.skins;
        let Some(source) = skins.get(skin) else {
            let cause = format!("names skin {skin}, but there are {}", skins.len());
            return Err(self.error(here, OutOfRange, cause));
        };
        let at = format!("{here}, {}", label("skin", skin, None));
        let inverse = match source.inverse_bind_matrices {
            Some(accessor) => self.matrices(accessor, &at)?,
            None => vec![DMat4::IDENTITY.as_mat4().to_cols_array(); source.joints.len()],
        };
        if inverse.len() < source.joints.len() {
            let (joints, have) = (source.joints.len(), inverse.len());
            let cause = format!("has {joints} joints and {have} inverse bind matrices");
            return Err(self.error(&at, Malformed, cause));
        }
        let mut joints = Vec::with_capacity(source.joints.len());
        for (&joint, inverse) in source.joints.iter().zip(inverse) {
            joints.push(self.world_from(joint)? * DMat4::from_cols_array(&inverse.map(f64::from)));
        }
        let mut sums = vec![DMat4::ZERO; vertices];
        let mut weights = vec![0.0f64; vertices];
        for set in 0.. {
            let attribute =
                |name: &str| primitive.attributes.get(&format!("{name}_{set}")).copied();
            let (Some(indices), Some(shares)) = (attribute("JOINTS"), attribute("WEIGHTS")) else {
                break;
            };
            let at = format!("{here}, JOINTS_{set}");
            let indices = self.vectors::<4>(indices, &at)?;
            let shares = self.vectors::<4>(shares, &format!("{here}, WEIGHTS_{set}"))?;
            self.same_count(indices.len().min(shares.len()), vertices, &at)?;
            for (vertex, (indices, shares)) in
                indices.iter().zip(&shares).enumerate().take(vertices)
            {
                for (&index, &share) in indices.iter().zip(shares) {
                    if share == 0.0 {
                        continue;
                    }
                    let Some(&joint) = joints.get(index as usize) else {
                        let cause =
                            format!("vertex {vertex} names joint {index} of {}", joints.len());
                        return Err(self.error(&at, OutOfRange, cause));
                    };
                    sums[vertex] += joint * f64::from(share);
                    weights[vertex] += f64::from(share);
                }
            }
        }
        for (vertex, (sum, weight)) in sums.iter_mut().zip(weights).enumerate() {
            // Forgiving: writers round weights.
            if !(1e-6..1e6).contains(&weight) {
                let cause = format!("the weights of vertex {vertex} add up to {weight}");
                return Err(self.error(here, NotFinite, cause));
            }
            *sum *= 1.0 / weight;
        }
        Ok(sums)
    }

    /// Adds the morph targets of one attribute at their weights.
    pub fn morph(
        &mut self,
        vectors: &mut [Vec3],
        attribute: &str,
        (primitive, weights): (&Primitive, &[f32]),
        here: &str,
    ) -> Result<(), InputError> {
        for (i, (target, &weight)) in primitive.targets.iter().zip(weights).enumerate() {
            let Some(&accessor) = target.get(attribute) else { continue };
            if weight == 0.0 {
                continue;
            }
            let at = format!("{here}, morph target {i}, {attribute}");
            let moves = self.vectors::<3>(accessor, &at)?;
            self.same_count(moves.len(), vectors.len(), &at)?;
            for (vector, by) in vectors.iter_mut().zip(moves) {
                *vector += Vec3::from(by) * weight;
            }
        }
        Ok(())
    }
}

//! Materials: base colour, its picture, and what becomes of alpha.

use super::container::way_out;
use super::document::TextureInfo;
use super::name::composed;
use super::picture::{blend_threshold, decode, fill_holes};
use super::{Reader, label};
use glam::{Affine2, Vec2, Vec3};
use windfall_core::InputErrorKind::{Malformed, OutOfRange, Unsupported};
use windfall_core::material::{Image, Material, Surface};
use windfall_core::{InputError, NoteCode};

const REPEAT: u32 = 10497;
const MIRRORED: u32 = 33648;

/// A material, and how a primitive's texture coordinates get to its picture.
#[derive(Debug, Clone)]
pub(super) struct Look {
    pub material: Material,
    /// Which `TEXCOORD_n` the picture uses.
    pub uv_set: u32,
    /// `KHR_texture_transform` of the picture.
    pub uv_transform: Affine2,
}

impl Reader<'_> {
    /// A material by its index in the file; `None` is the specification's default material.
    pub fn look(&mut self, index: Option<usize>, place: &str) -> Result<Look, InputError> {
        let file = self.file;
        let mut look = Look {
            material: Material {
                name: "default".into(),
                base_color: Vec3::ONE,
                roughness: 1.0,
                alpha_cutoff: None,
                surface: Surface::Plain,
            },
            uv_set: 0,
            uv_transform: Affine2::IDENTITY,
        };
        let Some(index) = index else { return Ok(look) };
        let materials = &self.document.materials;
        let Some(source) = materials.get(index) else {
            let cause = format!("names material {index}, but there are {}", materials.len());
            return Err(self.error(place, OutOfRange, cause));
        };
        let here = label("material", index, source.name.as_deref());
        let pbr = &source.pbr_metallic_roughness;
        let (factor, texture, roughness) = match &source.extensions.specular_glossiness {
            Some(gloss) => (
                gloss.diffuse_factor,
                &gloss.diffuse_texture,
                1.0 - gloss.glossiness_factor.unwrap_or(1.0),
            ),
            None => (
                pbr.base_color_factor,
                &pbr.base_color_texture,
                pbr.roughness_factor.unwrap_or(1.0),
            ),
        };
        let [r, g, b, alpha] = factor.unwrap_or([1.0; 4]);
        let material = &mut look.material;
        material.name =
            source.name.as_deref().map_or_else(|| format!("material {index}"), composed);
        // Forgiving: some writers have factors a little beyond one.
        material.base_color = Vec3::new(r, g, b).clamp(Vec3::ZERO, Vec3::ONE);
        material.roughness = roughness.clamp(0.0, 1.0);
        if let Some(info) = texture {
            let (image, repeat) = self.texture(info.index, &here)?;
            look.material.surface = Surface::Texture(image, repeat);
            (look.uv_set, look.uv_transform) = uv_access(info);
        }
        let blended = source.alpha_mode.as_deref() == Some("BLEND");
        let cutoff = match source.alpha_mode.as_deref() {
            None | Some("OPAQUE") => None,
            // The mask tests the picture's alpha times the factor: fold the factor into the threshold.
            Some("MASK") => Some(source.alpha_cutoff.unwrap_or(0.5) / alpha.max(1e-3)),
            // Blending needs an order that leaves in the wind have not: it becomes a mask.
            Some("BLEND") => Some(blend_threshold(&look.material.surface)),
            Some(other) => {
                let cause = format!("alphaMode \"{other}\" is not known");
                return Err(InputError::new(file, here, Malformed, cause));
            }
        };
        look.material.alpha_cutoff = cutoff.map(|c| c.clamp(0.0, 1.0));
        if let (Surface::Texture(image, _), Some(cutoff)) =
            (&mut look.material.surface, look.material.alpha_cutoff)
        {
            if blended {
                let message = format!(
                    "is blended; it is drawn as a mask instead, with holes where alpha is below {cutoff:.2}"
                );
                self.note(NoteCode::BlendAsMask, &here, message);
            }
            fill_holes(image, cutoff);
        }
        if look.material.alpha_cutoff.is_some() && look.material.holes().solid == 0.0 {
            let message = "no texel of its picture is as opaque as its cut-off: nothing of it is drawn; \
                           lower alphaCutoff";
            self.note(NoteCode::MaskLeavesNothing, &here, message);
        }
        let unread = [
            ("normalTexture", source.normal_texture.is_some()),
            ("occlusionTexture", source.occlusion_texture.is_some()),
            ("emissiveTexture", source.emissive_texture.is_some()),
            ("metallicRoughnessTexture", pbr.metallic_roughness_texture.is_some()),
            (
                "specularGlossinessTexture",
                source
                    .extensions
                    .specular_glossiness
                    .as_ref()
                    .is_some_and(|gloss| gloss.gloss_texture.is_some()),
            ),
        ];
        let unread: Vec<&str> = unread.iter().filter(|t| t.1).map(|t| t.0).collect();
        if !unread.is_empty() && !self.unread.textures.iter().any(|known| known.0 == here) {
            self.unread.textures.push((here, unread.join(", ")));
        }
        Ok(look)
    }

    fn texture(&mut self, index: usize, place: &str) -> Result<(Image, bool), InputError> {
        let document = self.document;
        let Some(texture) = document.textures.get(index) else {
            let cause = format!("names texture {index}, but there are {}", document.textures.len());
            return Err(self.error(place, OutOfRange, cause));
        };
        let here = format!("{place}, texture {index}");
        // A picture in WebP comes beside the one that everyone can read, or alone.
        let webp = texture.extensions.get("EXT_texture_webp");
        let webp = webp.and_then(|e| e.get("source")?.as_u64()).map(|i| i as usize);
        let Some(source) = texture.source.or(webp) else {
            let names: Vec<&str> = texture.extensions.keys().map(String::as_str).collect();
            let cause = if names.is_empty() {
                "has no image".to_string()
            } else {
                let ways: String = names.iter().map(|name| way_out(name)).collect();
                format!(
                    "has no image but through {}, which is not supported{ways}",
                    names.join(", ")
                )
            };
            return Err(self.error(&here, Unsupported, cause));
        };
        let repeat = match texture.sampler {
            None => true,
            Some(sampler) => {
                let Some(sampler) = document.samplers.get(sampler) else {
                    let count = document.samplers.len();
                    let cause = format!("names sampler {sampler}, but there are {count}");
                    return Err(self.error(&here, OutOfRange, cause));
                };
                // One mode for both directions: bark repeats if it repeats in any. Mirroring is
                // taken for repeating.
                [sampler.wrap_s, sampler.wrap_t]
                    .iter()
                    .any(|mode| matches!(mode.unwrap_or(REPEAT), REPEAT | MIRRORED))
            }
        };
        if !self.images.contains_key(&source) {
            let image = self.image(source, &here)?;
            self.images.insert(source, image);
        }
        Ok((self.images[&source].clone(), repeat))
    }

    fn image(&mut self, index: usize, place: &str) -> Result<Image, InputError> {
        let file = self.file;
        let images = &self.document.images;
        let Some(image) = images.get(index) else {
            let cause = format!("names image {index}, but there are {}", images.len());
            return Err(self.error(place, OutOfRange, cause));
        };
        let here = label("image", index, image.name.as_deref());
        let loaded;
        let bytes = match (&image.uri, image.buffer_view) {
            (_, Some(view)) => self.view(view, &here)?.0,
            (Some(uri), None) => {
                loaded = self.load(uri, &here)?;
                &loaded
            }
            (None, None) => {
                let cause = "has neither a URI nor a buffer view";
                return Err(self.error(&here, Malformed, cause));
            }
        };
        decode(bytes).map_err(|cause| {
            let cause = format!("the picture cannot be decoded: {cause}");
            InputError::new(file, here, Malformed, cause)
        })
    }
}

/// Which texture coordinates a picture uses, and the transform from them to the picture.
fn uv_access(info: &TextureInfo) -> (u32, Affine2) {
    let Some(transform) = &info.extensions.transform else {
        return (info.tex_coord, Affine2::IDENTITY);
    };
    let scale = Vec2::from(transform.scale.unwrap_or([1.0; 2]));
    // Counter-clockwise to the eye, and v points down: the angle's sign turns.
    let affine = Affine2::from_scale_angle_translation(
        scale,
        -transform.rotation,
        Vec2::from(transform.offset),
    );
    (transform.tex_coord.unwrap_or(info.tex_coord), affine)
}

//! Reads a baked tree, strictly.

use super::format::{self, Extension, Level, Shapes, View};
use super::records::{BranchRecord, LeafRecord, ShapeArrays, WoodVertexRecord};
use super::{About, BakedTree, EXTENSION, VERSION, check, digest};
use crate::import::container;
use crate::import::document::Document;
use crate::import::picture::decode;
use bytemuck::Pod;
use glam::{Mat3, Vec3};
use std::collections::BTreeMap;
use windfall_core::InputErrorKind::{Malformed, Missing, OutOfRange, Unsupported};
use windfall_core::foliage::{Foliage, Leaf, LeafShape, Palette, Shading, Visibility};
use windfall_core::material::{Bark, Image, Material, Surface};
use windfall_core::simplify::WoodLevel;
use windfall_core::tree::{Tree, Wood};
use windfall_core::{InputError, InputErrorKind, Note};

impl BakedTree {
    /// Reads a baked tree. `file` is what errors call the file.
    ///
    /// Memory: the bytes are borrowed, and every array is copied once.
    ///
    /// # Errors
    ///
    /// An [`InputError`]: the file is no baked tree, truncated, damaged, or of another version of the format.
    pub fn read(bytes: &[u8], file: &str) -> Result<Self, InputError> {
        let (document, binary) = container::open(bytes, file)?;
        if !document.is_baked() {
            let cause = format!("is no baked tree: it has no extension {EXTENSION}");
            return Err(InputError::new(file, "", Missing, cause));
        }
        read(bytes, file, &document, binary)
    }
}

/// Reads the baked tree of a document that has one; `bytes` are the whole file.
pub(crate) fn read(
    bytes: &[u8],
    file: &str,
    document: &Document,
    binary: Option<&[u8]>,
) -> Result<BakedTree, InputError> {
    let error = |kind, cause: String| InputError::new(file, EXTENSION, kind, cause);
    let content = document.extensions.baked.as_ref();
    let version = content.and_then(|content| content.get("version"));
    match version.and_then(serde_json::Value::as_u64) {
        Some(version) if version == u64::from(VERSION) => {}
        Some(version) if version > u64::from(VERSION) => {
            let cause = format!(
                "format version {version} is newer than {VERSION}, which this program reads: update \
                 the program, or bake the tree again"
            );
            return Err(error(Unsupported, cause));
        }
        Some(version) => {
            return Err(error(Unsupported, format!("there is no format version {version}")));
        }
        None => return Err(error(Malformed, "it has no version".into())),
    }
    let extension: Extension =
        serde::Deserialize::deserialize(content.unwrap_or(&serde_json::Value::Null))
            .map_err(|e| error(Malformed, e.to_string()))?;
    let whole = container::glb(bytes);
    if whole.and_then(|whole| digest::digest(whole, &extension.digest)).as_deref()
        != Some(&extension.digest)
    {
        let cause = "the digest is not that of the file: it is damaged, or another program has changed \
                     it; bake the tree again";
        return Err(error(Malformed, cause.into()));
    }
    let source = extension
        .source
        .parse()
        .map_err(|e| error(Malformed, format!("source \"{}\": {e}", extension.source)))?;
    let mut reader = Reader { file, document, binary, images: BTreeMap::new() };
    let tree = reader.tree(&extension)?;
    check::tree(&tree).map_err(|fault| {
        InputError::new(file, format!("{EXTENSION}, {}", fault.place), OutOfRange, fault.cause)
    })?;
    let prune_order = extension.prune_order.map(|order| (order.name, order.seed));
    let notes = extension.notes.into_iter();
    let notes = notes.map(|note| Note::new(note.code, file, note.place, note.message)).collect();
    Ok(BakedTree { tree, about: About { source, prune_order, notes } })
}

struct Reader<'a> {
    file: &'a str,
    document: &'a Document,
    binary: Option<&'a [u8]>,
    /// Those that were decoded.
    images: BTreeMap<usize, Image>,
}

impl<'a> Reader<'a> {
    fn error(&self, place: &str, kind: InputErrorKind, cause: impl Into<String>) -> InputError {
        InputError::new(self.file, format!("{EXTENSION}, {place}"), kind, cause)
    }

    fn tree(&mut self, extension: &Extension) -> Result<Tree, InputError> {
        let wood = self.wood(&extension.wood)?;
        let foliage = self.foliage(&extension.leaves)?;
        Ok(Tree { name: extension.name.clone(), wood, foliage })
    }

    fn wood(&mut self, wood: &format::Wood) -> Result<Wood, InputError> {
        let vertices: Vec<WoodVertexRecord> = self.array(wood.vertices, "wood, vertices")?;
        let branches: Vec<BranchRecord> = self.array(wood.branches, "wood, branches")?;
        let indices: Vec<u32> = self.array(wood.indices, "wood, indices")?;
        let mut levels = Vec::with_capacity(wood.levels.len() + 1);
        levels.push(WoodLevel { indices: indices.clone(), error: 0.0 });
        for (i, Level { indices, error }) in wood.levels.iter().enumerate() {
            let indices = self.array(*indices, &format!("wood, level {}", i + 1))?;
            levels.push(WoodLevel { indices, error: *error });
        }
        Ok(Wood {
            vertices: vertices.into_iter().map(From::from).collect(),
            indices,
            materials: self.materials(&wood.materials, "wood")?,
            levels,
            branches: branches.into_iter().map(From::from).collect(),
            outward: wood.outward,
        })
    }

    fn foliage(&mut self, leaves: &format::Leaves) -> Result<Foliage, InputError> {
        let records: Vec<LeafRecord> = self.array(leaves.records, "leaves")?;
        let list: Vec<Leaf> = records.into_iter().map(From::from).collect();
        // Ranks that are no permutation are refused with all else that is out of range.
        let mut shed_order = vec![0; list.len()];
        for (i, leaf) in (0..).zip(&list) {
            if let Some(place) = shed_order.get_mut(leaf.shed_rank as usize) {
                *place = i;
            }
        }
        let shapes: Option<Vec<LeafShape>> =
            self.shapes(&leaves.shapes, "leaves, shapes")?.into_iter().collect();
        let Some(shapes) = shapes else {
            return Err(self.error("leaves, shapes", Missing, "a shape is not there"));
        };
        let (seen, shading) = (&leaves.visibility, &leaves.shading);
        Ok(Foliage {
            leaves: list,
            shapes,
            materials: self.materials(&leaves.materials, "leaves")?,
            palette: leaves.palette.as_ref().map(|palette| Palette {
                stops: palette.stops.iter().copied().map(Vec3::from_array).collect(),
                spread: palette.spread,
            }),
            shed_order,
            crown_center: Vec3::from_array(leaves.crown_center),
            visibility: Visibility {
                share: seen.share,
                disocclusion: seen.disocclusion,
                sunlight: seen.sunlight,
            },
            shading: Shading {
                ambient: Vec3::from_array(shading.ambient),
                normals: Mat3::from_cols_array(&shading.normals),
            },
            simple_shapes: self.shapes(&leaves.simple_shapes, "leaves, simple shapes")?,
        })
    }

    fn shapes(&self, shapes: &Shapes, place: &str) -> Result<Vec<Option<LeafShape>>, InputError> {
        let arrays = ShapeArrays {
            counts: self.array(shapes.counts, place)?,
            vertices: self.array(shapes.vertices, place)?,
            indices: self.array(shapes.indices, place)?,
        };
        arrays.shapes().map_err(|cause| self.error(place, OutOfRange, cause))
    }

    fn materials(
        &mut self,
        materials: &[format::Material],
        part: &str,
    ) -> Result<Vec<Material>, InputError> {
        let mut list = Vec::with_capacity(materials.len());
        for (i, material) in materials.iter().enumerate() {
            let surface = match &material.surface {
                format::Surface::Plain => Surface::Plain,
                format::Surface::Texture { image, repeat } => {
                    let place = format!("{part}, material {i}, image {image}");
                    Surface::Texture(self.image(*image, &place)?, *repeat)
                }
                format::Surface::Bark { ridge, groove, scale, pattern } => Surface::Bark(Bark {
                    ridge: Vec3::from_array(*ridge),
                    groove: Vec3::from_array(*groove),
                    scale: *scale,
                    pattern: (*pattern).into(),
                }),
            };
            list.push(Material {
                name: material.name.clone(),
                base_color: Vec3::from_array(material.base_color),
                roughness: material.roughness,
                alpha_cutoff: material.alpha_cutoff,
                surface,
            });
        }
        Ok(list)
    }

    fn image(&mut self, index: usize, place: &str) -> Result<Image, InputError> {
        if let Some(image) = self.images.get(&index) {
            return Ok(image.clone());
        }
        let images = &self.document.images;
        let Some(image) = images.get(index) else {
            return Err(self.error(
                place,
                OutOfRange,
                format!("there are {} images", images.len()),
            ));
        };
        let Some(view) = image.buffer_view else {
            return Err(self.error(place, Missing, "is in no buffer view"));
        };
        let decoded = decode(self.view(view, place)?).map_err(|cause| {
            self.error(place, Malformed, format!("the picture cannot be decoded: {cause}"))
        })?;
        self.images.insert(index, decoded.clone());
        Ok(decoded)
    }

    /// The elements of an array.
    fn array<T: Pod>(&self, view: View, place: &str) -> Result<Vec<T>, InputError> {
        let Some(view) = view else { return Ok(Vec::new()) };
        let bytes = self.view(view, place)?;
        if !bytes.len().is_multiple_of(size_of::<T>()) {
            let cause = format!(
                "buffer view {view} has {} bytes, no multiple of {}",
                bytes.len(),
                size_of::<T>()
            );
            return Err(self.error(place, Malformed, cause));
        }
        Ok(bytemuck::pod_collect_to_vec(bytes))
    }

    /// The bytes of a buffer view of the binary chunk.
    fn view(&self, index: usize, place: &str) -> Result<&'a [u8], InputError> {
        let views = &self.document.buffer_views;
        let Some(view) = views.get(index) else {
            let cause = format!("names buffer view {index}, but there are {}", views.len());
            return Err(self.error(place, OutOfRange, cause));
        };
        let Some(binary) = self.binary.filter(|_| view.buffer == 0) else {
            let cause = format!("buffer view {index} is not in the binary chunk");
            return Err(self.error(place, Missing, cause));
        };
        let (from, length) = (view.byte_offset, view.byte_length);
        from.checked_add(length)
            .filter(|&end| end <= binary.len() as u64)
            .map(|end| &binary[from as usize..end as usize])
            .ok_or_else(|| {
                let have = binary.len();
                let cause = format!(
                    "buffer view {index}: {length} bytes from byte {from} do not fit a binary chunk \
                     of {have} bytes"
                );
                self.error(place, OutOfRange, cause)
            })
    }
}

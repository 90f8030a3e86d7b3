//! Reads accessors: every index, offset and count is held against what it refers to before a byte
//! is read or allocated.

use super::Reader;
use super::document::Accessor;
use windfall_core::InputError;
#[cfg(target_arch = "wasm32")]
use windfall_core::InputErrorKind::Unsupported;
use windfall_core::InputErrorKind::{Malformed, OutOfRange};

/// Elements that an accessor without data (all zeros, by the specification) may have: what it asks
/// for is not bounded by the size of the file.
const MOST_ZEROS: u64 = 1 << 20;

/// Component types of glTF.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn new(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    const fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// One component; `bytes` has [`Self::size`] bytes.
    fn number(self, bytes: &[u8], normalized: bool) -> f32 {
        // By the specification: f = c / 127 for i8, and -128 is -1.
        let (value, top) = match (self, bytes) {
            (Self::I8, &[a]) => (f32::from(a as i8), 127.0),
            (Self::U8, &[a]) => (f32::from(a), 255.0),
            (Self::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
            (Self::U16, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
            (Self::U32, &[a, b, c, d]) => {
                (u32::from_le_bytes([a, b, c, d]) as f32, 4_294_967_295.0)
            }
            (Self::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
            _ => (0.0, 1.0),
        };
        if normalized { (value / top).max(-1.0) } else { value }
    }

    /// One unsigned integer; `bytes` has [`Self::size`] bytes.
    fn integer(self, bytes: &[u8]) -> u32 {
        match (self, bytes) {
            (Self::U8, &[a]) => u32::from(a),
            (Self::U16, &[a, b]) => u32::from(u16::from_le_bytes([a, b])),
            (Self::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
            _ => 0,
        }
    }
}

/// What a reader of an accessor takes from each element.
trait Element: Copy {
    /// The element in `bytes`, which holds all its components.
    fn read(bytes: &[u8], component: Component, normalized: bool) -> Self;
    /// The element that an accessor without data has.
    const ZERO: Self;
}

impl<const N: usize> Element for [f32; N] {
    fn read(bytes: &[u8], component: Component, normalized: bool) -> Self {
        let size = component.size() as usize;
        std::array::from_fn(|i| component.number(&bytes[i * size..(i + 1) * size], normalized))
    }
    const ZERO: Self = [0.0; N];
}

impl Element for u32 {
    fn read(bytes: &[u8], component: Component, _: bool) -> Self {
        component.integer(bytes)
    }
    const ZERO: Self = 0;
}

impl<'a> Reader<'a> {
    /// Vectors of `N` numbers: the accessor's type must be `VECN`, of any component type but `U32`.
    pub fn vectors<const N: usize>(
        &mut self,
        index: usize,
        place: &str,
    ) -> Result<Vec<[f32; N]>, InputError> {
        let (accessor, here) = self.accessor(index, place)?;
        if accessor.kind != format!("VEC{N}") {
            let cause = format!("its type is \"{}\"; VEC{N} is needed", accessor.kind);
            return Err(self.error(&here, Malformed, cause));
        }
        self.elements::<[f32; N]>(accessor, &here, N as u64, |c| c != Component::U32)
    }

    /// Vectors of any length up to `N`, the rest filled with `fill`: colours with or without alpha.
    pub fn vectors_up_to<const N: usize>(
        &mut self,
        index: usize,
        place: &str,
        fill: f32,
    ) -> Result<Vec<[f32; N]>, InputError> {
        if N > 3 && self.is_vector(index, 3, place)? {
            let shorter = self.vectors::<3>(index, place)?;
            let longer = |v: [f32; 3]| std::array::from_fn(|i| *v.get(i).unwrap_or(&fill));
            return Ok(shorter.into_iter().map(longer).collect());
        }
        self.vectors(index, place)
    }

    /// Matrices of four by four floats, column by column.
    pub fn matrices(&mut self, index: usize, place: &str) -> Result<Vec<[f32; 16]>, InputError> {
        let (accessor, here) = self.accessor(index, place)?;
        if accessor.kind != "MAT4" {
            let cause = format!("its type is \"{}\"; MAT4 is needed", accessor.kind);
            return Err(self.error(&here, Malformed, cause));
        }
        self.elements::<[f32; 16]>(accessor, &here, 16, |c| c == Component::F32)
    }

    /// The distance between neighbouring values of an accessor: 0 for floats. Normalized 16-bit numbers are taken for
    /// 14 bits, as glTF-Transform writes by default.
    pub fn step(&self, index: usize, place: &str) -> Result<f32, InputError> {
        let accessor = self.accessor(index, place)?.0;
        Ok(match (Component::new(accessor.component_type), accessor.normalized) {
            (Some(Component::I8), true) => 1.0 / 127.0,
            (Some(Component::U8), true) => 1.0 / 255.0,
            (Some(Component::I16), true) => 4.0 / 32767.0,
            (Some(Component::U16), true) => 4.0 / 65535.0,
            (Some(Component::F32) | None, _) => 0.0,
            _ => 1.0,
        })
    }

    /// Whether an accessor has no data of its own, so that all of it is zero.
    pub fn is_empty(&self, index: usize, place: &str) -> Result<bool, InputError> {
        let accessor = self.accessor(index, place)?.0;
        Ok(accessor.buffer_view.is_none() && accessor.sparse.is_none())
    }

    /// Whether an accessor is of vectors of so many numbers.
    pub fn is_vector(&self, index: usize, size: u32, place: &str) -> Result<bool, InputError> {
        Ok(self.accessor(index, place)?.0.kind == format!("VEC{size}"))
    }

    /// Indices: unsigned integers of any size.
    pub fn indices(&mut self, index: usize, place: &str) -> Result<Vec<u32>, InputError> {
        let (accessor, here) = self.accessor(index, place)?;
        if accessor.kind != "SCALAR" {
            let cause = format!("its type is \"{}\"; SCALAR is needed", accessor.kind);
            return Err(self.error(&here, Malformed, cause));
        }
        self.elements::<u32>(accessor, &here, 1, is_index)
    }

    /// How many elements an accessor says it has.
    pub fn count(&self, index: usize, place: &str) -> Result<u64, InputError> {
        Ok(self.accessor(index, place)?.0.count)
    }

    fn accessor(&self, index: usize, place: &str) -> Result<(&'a Accessor, String), InputError> {
        let accessors = &self.document.accessors;
        let accessor = accessors.get(index).ok_or_else(|| {
            let cause = format!("names accessor {index}, but there are {}", accessors.len());
            self.error(place, OutOfRange, cause)
        })?;
        Ok((accessor, format!("{place}, accessor {index}")))
    }

    fn elements<T: Element>(
        &mut self,
        accessor: &Accessor,
        here: &str,
        components: u64,
        allowed: impl Fn(Component) -> bool,
    ) -> Result<Vec<T>, InputError> {
        let file = self.file;
        let out_of_range = |place: &str, cause| InputError::new(file, place, OutOfRange, cause);
        let component = self.component(accessor.component_type, here, allowed)?;
        let size = component.size() * components;
        let read = |bytes: &[u8]| T::read(bytes, component, accessor.normalized);
        let mut elements: Vec<T> = if let Some(view) = accessor.buffer_view {
            let (bytes, stride) = self.view(view, here)?;
            let stride = stride.unwrap_or(size);
            let bytes = span(bytes, accessor.byte_offset, accessor.count, size, stride)
                .map_err(|cause| out_of_range(here, cause))?;
            bytes.chunks(stride.max(1) as usize).map(|b| read(&b[..size as usize])).collect()
        } else if accessor.count <= MOST_ZEROS {
            vec![T::ZERO; accessor.count as usize]
        } else {
            let cause = format!(
                "{} elements without a buffer view; {MOST_ZEROS} are allowed",
                accessor.count
            );
            return Err(self.error(here, OutOfRange, cause));
        };
        if let Some(sparse) = &accessor.sparse {
            let here = format!("{here}, sparse");
            if sparse.count > accessor.count {
                let cause = format!("replaces {} of {} elements", sparse.count, accessor.count);
                return Err(self.error(&here, OutOfRange, cause));
            }
            let at = &sparse.indices;
            let kind = self.component(at.component_type, &here, is_index)?;
            let (bytes, _) = self.view(at.buffer_view, &here)?;
            let places: Vec<u32> =
                span(bytes, at.byte_offset, sparse.count, kind.size(), kind.size())
                    .map_err(|cause| out_of_range(&here, cause))?
                    .chunks(kind.size() as usize)
                    .map(|b| kind.integer(b))
                    .collect();
            let (bytes, _) = self.view(sparse.values.buffer_view, &here)?;
            let bytes = span(bytes, sparse.values.byte_offset, sparse.count, size, size)
                .map_err(|cause| out_of_range(&here, cause))?;
            for (&place, bytes) in places.iter().zip(bytes.chunks(size as usize)) {
                let Some(element) = elements.get_mut(place as usize) else {
                    let cause = format!("replaces element {place} of {}", accessor.count);
                    return Err(out_of_range(&here, cause));
                };
                *element = read(bytes);
            }
        }
        Ok(elements)
    }

    fn component(
        &self,
        code: u32,
        here: &str,
        allowed: impl Fn(Component) -> bool,
    ) -> Result<Component, InputError> {
        let component = Component::new(code).ok_or_else(|| {
            self.error(here, Malformed, format!("component type {code} is unknown"))
        })?;
        if allowed(component) {
            Ok(component)
        } else {
            let cause = format!("component type {code} is not allowed here");
            Err(self.error(here, Malformed, cause))
        }
    }

    /// The bytes of a buffer view, unpacked if need be, and its stride.
    pub fn view(&mut self, index: usize, place: &str) -> Result<(&[u8], Option<u64>), InputError> {
        let views = &self.document.buffer_views;
        let Some(view) = views.get(index) else {
            let cause = format!("names buffer view {index}, but there are {}", views.len());
            return Err(self.error(place, OutOfRange, cause));
        };
        let here = format!("{place}, buffer view {index}");
        if view.byte_stride == Some(0) || view.byte_stride > Some(u64::from(u32::MAX)) {
            return Err(self.error(&here, OutOfRange, "its byteStride is out of range"));
        }
        let Some(packed) = view.extensions.meshopt() else {
            let bytes = self.slice(view.buffer, view.byte_offset, view.byte_length, &here)?;
            return Ok((bytes, view.byte_stride));
        };
        if !self.unpacked.contains_key(&index) {
            #[cfg(not(target_arch = "wasm32"))]
            {
                let data =
                    self.slice(packed.buffer, packed.byte_offset, packed.byte_length, &here)?;
                let bytes = super::meshopt::unpack(data, packed)
                    .map_err(|cause| self.error(&here, Malformed, cause))?;
                self.unpacked.insert(index, bytes);
            }
            #[cfg(target_arch = "wasm32")]
            {
                let cause = "EXT_meshopt_compression is not supported in browsers";
                return Err(self.error(&here, Unsupported, cause));
            }
        }
        Ok((self.unpacked.get(&index).map_or(&[], Vec::as_slice), Some(packed.byte_stride)))
    }

    fn slice(
        &mut self,
        buffer: usize,
        offset: u64,
        length: u64,
        here: &str,
    ) -> Result<&[u8], InputError> {
        // The range is kept apart from the buffer's bytes, which borrow the reader.
        let have = self.buffer(buffer, here)?.len() as u64;
        let end = offset.checked_add(length).filter(|&end| end <= have).ok_or_else(|| {
            let cause = format!(
                "{length} bytes from byte {offset} do not fit buffer {buffer} of {have} bytes"
            );
            self.error(here, OutOfRange, cause)
        })?;
        Ok(&self.buffer(buffer, here)?[offset as usize..end as usize])
    }
}

/// The part of `bytes` that holds `count` elements of `size` bytes, `stride` bytes apart.
fn span(bytes: &[u8], offset: u64, count: u64, size: u64, stride: u64) -> Result<&[u8], String> {
    if stride < size {
        return Err(format!("a stride of {stride} bytes for elements of {size}"));
    }
    if count == 0 {
        return Ok(&[]);
    }
    let end = (count - 1)
        .checked_mul(stride)
        .and_then(|length| length.checked_add(size)?.checked_add(offset))
        .filter(|&end| end <= bytes.len() as u64)
        .ok_or_else(|| {
            let have = bytes.len();
            format!(
                "{count} elements, {stride} bytes apart from byte {offset}, do not fit the \
                 {have} bytes of the buffer view"
            )
        })?;
    Ok(&bytes[offset as usize..end as usize])
}

fn is_index(component: Component) -> bool {
    matches!(component, Component::U8 | Component::U16 | Component::U32)
}

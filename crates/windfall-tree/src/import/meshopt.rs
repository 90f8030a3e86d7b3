//! `EXT_meshopt_compression` and `KHR_meshopt_compression`: buffer views that are packed, sometimes behind a filter.
//!
//! The decoder is C++ and made for input that is not trusted; its preconditions are checked here.

use super::document::Compressed;
use ::meshopt as codec;

/// Unpacks one buffer view. The error says what is wrong with it.
pub(super) fn unpack(data: &[u8], packed: &Compressed) -> Result<Vec<u8>, String> {
    let stride = usize::try_from(packed.byte_stride).unwrap_or(usize::MAX);
    // What can be packed at most bounds what is allocated: a block of 256 elements costs two bits
    // per byte of an element at the least; a triangle costs a byte, and so does an index.
    let length = data.len() as u64;
    let most = match packed.mode.as_str() {
        "ATTRIBUTES" => length.saturating_mul(1024) / packed.byte_stride.max(1),
        "TRIANGLES" => length.saturating_mul(3),
        "INDICES" => length,
        other => return Err(format!("meshopt mode \"{other}\" is not known")),
    };
    if packed.count > most {
        let count = packed.count;
        return Err(format!("{count} elements cannot be in {length} packed bytes"));
    }
    let count = packed.count as usize;
    let bad = |e: codec::Error| format!("the packed data is damaged ({e})");
    let words = match packed.mode.as_str() {
        "ATTRIBUTES" => {
            if stride == 0 || stride > 256 || !stride.is_multiple_of(4) {
                return Err(format!("stride {stride}: a multiple of 4 up to 256 is allowed"));
            }
            if count == 0 { Ok(Vec::new()) } else { attributes(data, count, stride / 4) }
        }
        _ if stride != 2 && stride != 4 => {
            return Err(format!("stride {stride}: indices take 2 or 4 bytes"));
        }
        "TRIANGLES" if !count.is_multiple_of(3) => {
            return Err(format!("{count} indices are no whole triangles"));
        }
        "TRIANGLES" => codec::decode_index_buffer::<u32>(data, count),
        _ => codec::decode_index_sequence::<u32>(data, count),
    };
    let mut words = words.map_err(bad)?;
    match (packed.filter.as_deref().unwrap_or("NONE"), stride) {
        ("NONE", _) => {}
        ("OCTAHEDRAL", 4) => codec::decode_filter_oct::<i8>(bytemuck::cast_slice_mut(&mut words)),
        ("OCTAHEDRAL", 8) => codec::decode_filter_oct::<i16>(bytemuck::cast_slice_mut(&mut words)),
        ("QUATERNION", 8) => codec::decode_filter_quat(bytemuck::cast_slice_mut(&mut words)),
        ("COLOR", 4) => codec::decode_filter_color::<u8>(bytemuck::cast_slice_mut(&mut words)),
        ("COLOR", 8) => codec::decode_filter_color::<u16>(bytemuck::cast_slice_mut(&mut words)),
        ("EXPONENTIAL", _) => {
            codec::decode_filter_exp::<1>(bytemuck::cast_slice_mut(&mut words));
        }
        (filter, _) => {
            return Err(format!("filter \"{filter}\" with stride {stride} is not known"));
        }
    }
    Ok(if packed.mode != "ATTRIBUTES" && stride == 2 {
        words.iter().flat_map(|&w| (w as u16).to_le_bytes()).collect()
    } else {
        words.iter().flat_map(|w| w.to_le_bytes()).collect()
    })
}

/// An element of `N` words; the codec asks for a type of the element's size.
#[derive(Clone, Copy)]
struct Words<const N: usize>([u32; N]);

impl<const N: usize> Default for Words<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

fn attributes_of<const N: usize>(data: &[u8], count: usize) -> Result<Vec<u32>, codec::Error> {
    let elements = codec::decode_vertex_buffer::<Words<N>>(data, count)?;
    Ok(elements.iter().flat_map(|e| e.0).collect())
}

fn attributes(data: &[u8], count: usize, words: usize) -> Result<Vec<u32>, codec::Error> {
    macro_rules! by_size {
        ($($n:literal)*) => {
            match words {
                $($n => attributes_of::<$n>(data, count),)*
                _ => Ok(Vec::new()), // The caller has checked the stride.
            }
        };
    }
    by_size!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63
        64)
}

//! From the bytes of a file to its document and its buffers.

use super::Reader;
use super::document::Document;
use std::borrow::Cow;
use windfall_core::InputErrorKind::{Empty, Malformed, Missing, OutOfRange, Unsupported};
use windfall_core::{InputError, InputErrorKind};

const GLB_MAGIC: &[u8] = b"glTF";
const CHUNK_JSON: u32 = 0x4e4f_534a;
const CHUNK_BIN: u32 = 0x004e_4942;

/// What an extension that a file requires must be among: these change where the data is, and are
/// read. The rest change the look or the meaning in ways that are not known here.
const KNOWN_EXTENSIONS: &[&str] = &[
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    #[cfg(not(target_arch = "wasm32"))]
    "EXT_meshopt_compression",
    #[cfg(not(target_arch = "wasm32"))]
    "KHR_meshopt_compression",
    "EXT_texture_webp",
    "EXT_mesh_gpu_instancing",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_unlit",
    "MSFT_lod",
];

/// Whether nothing of an extension is lost.
pub(super) fn is_read(extension: &str) -> bool {
    KNOWN_EXTENSIONS.contains(&extension)
}

/// How to undo an extension that is not read, as the end of a sentence; empty where no way is known.
pub(super) fn way_out(extension: &str) -> &'static str {
    match extension {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "; `npx @gltf-transform/cli copy in.glb out.glb` writes the file without compression"
        }
        "KHR_texture_basisu" => {
            "; `npx @gltf-transform/cli ktxdecompress in.glb out.glb` turns KTX2 pictures into PNG"
        }
        "EXT_texture_avif" => {
            "; `npx @gltf-transform/cli png in.glb out.glb` turns the pictures into PNG"
        }
        _ => "",
    }
}

/// Splits a file into its document and, for a GLB, its binary chunk.
pub(crate) fn open<'a>(
    bytes: &'a [u8],
    file: &str,
) -> Result<(Document, Option<&'a [u8]>), InputError> {
    let error = |place: &str, kind, cause: String| InputError::new(file, place, kind, cause);
    if bytes.is_empty() {
        return Err(error("", Empty, "the file is empty (0 bytes)".into()));
    }
    let (json, binary) = if bytes.starts_with(GLB_MAGIC) {
        split_glb(bytes).map_err(|(place, kind, cause)| error(place, kind, cause))?
    } else {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        if text.iter().find(|b| !b.is_ascii_whitespace()) != Some(&b'{') {
            let cause = "neither a binary glTF (it would begin with \"glTF\") nor a glTF document \
                         (it would begin with \"{\")";
            return Err(error("", Malformed, cause.into()));
        }
        (text, None)
    };
    // Padding of the JSON chunk is spaces; some writers use zeros.
    let end = json.iter().rposition(|&b| b != 0).map_or(0, |i| i + 1);
    let document: Document = serde_json::from_slice(&json[..end])
        .map_err(|e| error("JSON", Malformed, format!("not a glTF document: {e}")))?;
    check(&document).map_err(|(place, kind, cause)| error(place, kind, cause))?;
    Ok((document, binary))
}

/// The bytes of a GLB, as many as it announces.
pub(crate) fn glb(bytes: &[u8]) -> Option<&[u8]> {
    let length = u32::from_le_bytes(bytes.get(8..12)?.try_into().ok()?);
    bytes.starts_with(GLB_MAGIC).then(|| bytes.get(..length as usize)).flatten()
}

/// What a file is, before its tree is read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Survey {
    /// Whether it is a baked tree ([`mod@crate::bake`]), of any version.
    pub baked: bool,
    /// What it names outside itself, percent signs decoded: what [`crate::import()`] may ask for.
    pub outside: Vec<String>,
}

/// Looks what a file is, and what it refers to. `file` is what errors call the file.
///
/// # Errors
///
/// An [`InputError`]: no glTF.
pub fn survey(bytes: &[u8], file: &str) -> Result<Survey, InputError> {
    let (document, _) = open(bytes, file)?;
    let baked = document.is_baked();
    let buffers = document.buffers.into_iter().map(|buffer| buffer.uri);
    let images = document.images.into_iter().map(|image| image.uri);
    let mut outside: Vec<String> = buffers
        .chain(images)
        .flatten()
        .filter(|uri| !uri.starts_with("data:"))
        .filter_map(|uri| percent_decoded(&uri))
        .collect();
    outside.sort();
    outside.dedup();
    Ok(Survey { baked, outside })
}

type Fault = (&'static str, InputErrorKind, String);

fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let word = |at: usize| -> Option<u32> {
        Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        let cause = format!("truncated: {} bytes, the header alone takes 12", bytes.len());
        return Err(("GLB header", Malformed, cause));
    };
    if version != 2 {
        return Err(("GLB header", Unsupported, format!("version {version}; 2 is supported")));
    }
    if length as usize > bytes.len() {
        let cause = format!("truncated: {} bytes of the {length} announced", bytes.len());
        return Err(("GLB header", Malformed, cause));
    }
    let bytes = &bytes[..length as usize];
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at < bytes.len() {
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else {
            return Err(("GLB chunk", Malformed, format!("truncated at byte {at}")));
        };
        let Some(data) = bytes.get(at + 8..at + 8 + size as usize) else {
            let left = bytes.len().saturating_sub(at + 8);
            let cause =
                format!("truncated: the chunk at byte {at} says {size} bytes, {left} are left");
            return Err(("GLB chunk", Malformed, cause));
        };
        match kind {
            CHUNK_JSON if json.is_none() => json = Some(data),
            CHUNK_BIN if binary.is_none() => binary = Some(data),
            _ => {} // The specification has readers ignore other chunks.
        }
        at += 8 + size as usize;
    }
    let json = json.ok_or(("GLB chunk", Missing, "there is no JSON chunk".to_string()))?;
    Ok((json, binary))
}

fn check(document: &Document) -> Result<(), Fault> {
    let asset = &document.asset;
    let version = asset.min_version.as_ref().unwrap_or(&asset.version);
    if version.is_empty() {
        return Err(("asset", Malformed, "no version: not a glTF document".into()));
    }
    if version != "2.0" {
        let cause = format!("glTF version \"{version}\" is not supported; 2.0 is");
        return Err(("asset", Unsupported, cause));
    }
    for name in &document.extensions_required {
        if !KNOWN_EXTENSIONS.contains(&name.as_str()) {
            let cause = format!(
                "the file requires the extension {name}, which is not supported{}",
                match way_out(name) {
                    "" => format!(" (supported: {})", KNOWN_EXTENSIONS.join(", ")),
                    way => way.to_string(),
                }
            );
            return Err(("extensionsRequired", Unsupported, cause));
        }
    }
    Ok(())
}

impl Reader<'_> {
    /// The bytes of a buffer, at least as many as it announces.
    pub fn buffer(&mut self, index: usize, place: &str) -> Result<&[u8], InputError> {
        let Some(buffer) = self.document.buffers.get(index) else {
            let count = self.document.buffers.len();
            return Err(self.error(
                place,
                OutOfRange,
                format!("names buffer {index}, but there are {count}"),
            ));
        };
        let length = buffer.byte_length;
        let here = format!("buffer {index}");
        if !self.buffers.contains_key(&index) {
            let bytes = match (&buffer.uri, self.binary) {
                (Some(uri), _) => Cow::Owned(self.load(uri, &here)?),
                (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
                _ => {
                    let cause = "has neither a URI nor a binary chunk: its data is missing";
                    return Err(self.error(&here, Missing, cause));
                }
            };
            if (bytes.len() as u64) < length {
                let cause = format!("announces {length} bytes, its data has {}", bytes.len());
                return Err(self.error(&here, OutOfRange, cause));
            }
            self.buffers.insert(index, bytes);
        }
        Ok(self.buffers.get(&index).map_or(&[], |bytes| &bytes[..length as usize]))
    }

    /// The bytes behind a URI: a data URI's own, or what the caller finds.
    pub fn load(&mut self, uri: &str, place: &str) -> Result<Vec<u8>, InputError> {
        if let Some(rest) = uri.strip_prefix("data:") {
            let Some((_, data)) = rest.split_once(";base64,") else {
                return Err(self.error(place, Malformed, "its data URI is not base64"));
            };
            return base64(data)
                .map_err(|at| self.error(place, Malformed, format!("base64 fails at byte {at}")));
        }
        let scheme = uri.split(['/', '?', '#']).next().is_some_and(|head| head.contains(':'));
        if scheme {
            let cause = format!("\"{uri}\" is not a relative path; nothing is fetched elsewhere");
            return Err(self.error(place, Unsupported, cause));
        }
        let Some(path) = percent_decoded(uri) else {
            let cause = format!("\"{uri}\" is not a URI: its percent signs are no UTF-8");
            return Err(self.error(place, Malformed, cause));
        };
        (self.resolve)(&path)
            .map_err(|cause| self.error(place, Missing, format!("\"{path}\": {cause}")))
    }
}

fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        if byte == b'%' {
            let (high, low) = (rest.next()?, rest.next()?);
            let digit = |b: u8| (b as char).to_digit(16);
            bytes.push((digit(high)? * 16 + digit(low)?) as u8);
        } else {
            bytes.push(byte);
        }
    }
    String::from_utf8(bytes).ok()
}

/// Decodes base64 with or without padding, in either alphabet; the position of a foreign byte if
/// there is one.
fn base64(text: &str) -> Result<Vec<u8>, usize> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    let (mut bits, mut held) = (0u32, 0u32);
    for (at, byte) in text.bytes().enumerate() {
        let value = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => break,
            _ => return Err(at),
        };
        bits = bits << 6 | u32::from(value);
        held += 6;
        if held >= 8 {
            held -= 8;
            bytes.push((bits >> held) as u8);
            bits &= (1 << held) - 1;
        }
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_decodes_the_examples_of_rfc_4648() {
        for (text, bytes) in
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYmE", "fooba")]
        {
            assert_eq!(base64(text).unwrap(), bytes.as_bytes());
        }
        assert_eq!(base64("Zm9*"), Err(3));
    }

    #[test]
    fn percent_signs_are_decoded_as_utf8() {
        assert_eq!(percent_decoded("oak%20bark%C3%A9.png").unwrap(), "oak barké.png");
        assert_eq!(percent_decoded("100%"), None);
        assert_eq!(percent_decoded("%ff"), None);
    }
}

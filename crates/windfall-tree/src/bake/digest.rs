//! The hash of a whole file that stands in the file.

/// Hexadecimal characters of a digest.
pub(super) const LENGTH: usize = 64;

/// What stands in a file in place of its digest while that is computed.
pub(super) fn blank() -> String {
    "0".repeat(LENGTH)
}

/// The digest of a file in which `own` stands as its digest; `None` if it does not stand there exactly once.
pub(super) fn digest(bytes: &[u8], own: &str) -> Option<String> {
    let at = place(bytes, own)?;
    let mut hasher = blake3::Hasher::new();
    hasher.update(&bytes[..at]).update(blank().as_bytes());
    update(&mut hasher, &bytes[at + LENGTH..]);
    Some(hasher.finalize().to_hex().to_string())
}

/// Puts the digest into a file in which another stands, or nothing of the kind.
pub(super) fn reseal(bytes: &mut [u8]) {
    let name = b"\"digest\":\"";
    let Some(at) = bytes.windows(name.len()).position(|window| window == name) else { return };
    if let Some(digest) = bytes.get_mut(at + name.len()..at + name.len() + LENGTH) {
        digest.fill(b'0');
        seal(bytes);
    }
}

/// Puts the digest into a file in which it is still [`blank`].
pub(super) fn seal(bytes: &mut [u8]) {
    let blank = blank();
    if let (Some(at), Some(digest)) = (place(bytes, &blank), digest(bytes, &blank)) {
        bytes[at..at + LENGTH].copy_from_slice(digest.as_bytes());
    }
}

/// Where the digest stands: behind its name, in the JSON before the arrays.
fn place(bytes: &[u8], own: &str) -> Option<usize> {
    const NAME: &str = "\"digest\":\"";
    let member = format!("{NAME}{own}\"");
    // The JSON is the first chunk; arrays behind it are not searched.
    let json = u32::from_le_bytes(bytes.get(12..16)?.try_into().ok()?) as usize;
    let json = bytes.get(20..20usize.checked_add(json)?)?;
    let mut found = json.windows(member.len()).enumerate();
    let (at, _) = found.find(|(_, window)| *window == member.as_bytes())?;
    let again = found.any(|(_, window)| window == member.as_bytes());
    (!again).then_some(20 + at + NAME.len())
}

#[cfg(feature = "parallel")]
pub(super) fn update(hasher: &mut blake3::Hasher, bytes: &[u8]) {
    hasher.update_rayon(bytes);
}

#[cfg(not(feature = "parallel"))]
pub(super) fn update(hasher: &mut blake3::Hasher, bytes: &[u8]) {
    hasher.update(bytes);
}

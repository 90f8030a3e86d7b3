//! The hash of what a tree is made of.

use super::digest;
use crate::{GrowOptions, ImportOptions, Species};
use std::fmt;
use std::str::FromStr;

/// Hash (BLAKE3) of a tree's source and of the options with which it was read or grown.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct SourceHash([u8; 32]);

impl SourceHash {
    /// Of a file. `outside` are the names of what it refers to outside itself ([`crate::survey`]) and their bytes.
    pub fn of_file(bytes: &[u8], outside: &[(&str, &[u8])], options: &ImportOptions) -> Self {
        let mut hasher = blake3::Hasher::new_derive_key("Windfall 2026 source of a tree: file");
        let mut add = |bytes: &[u8]| {
            hasher.update(&(bytes.len() as u64).to_le_bytes());
            digest::update(&mut hasher, bytes);
        };
        add(bytes);
        for (name, bytes) in outside {
            add(name.as_bytes());
            add(bytes);
        }
        add(format!("{options:?}").as_bytes());
        Self(*hasher.finalize().as_bytes())
    }

    /// Of a built-in species.
    pub fn of_species(species: Species, seed: u32, options: &GrowOptions) -> Self {
        let text = format!("{species} {seed} {options:?}");
        let context = "Windfall 2026 source of a tree: species";
        Self(blake3::derive_key(context, text.as_bytes()))
    }
}

impl fmt::Display for SourceHash {
    /// 64 hexadecimal characters.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&blake3::Hash::from_bytes(self.0).to_hex())
    }
}

impl fmt::Debug for SourceHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SourceHash({self})")
    }
}

impl FromStr for SourceHash {
    type Err = blake3::HexError;

    fn from_str(text: &str) -> Result<Self, blake3::HexError> {
        Ok(Self(*blake3::Hash::from_hex(text)?.as_bytes()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_changes_the_tree_changes_the_hash() {
        let none = ImportOptions::default();
        let some = ImportOptions { height: Some(3.0), ..none.clone() };
        let other = ImportOptions { leaves: vec!["a".into()], ..none.clone() };
        let usual = GrowOptions::default();
        let high = GrowOptions { height: Some(3.0), ..usual };
        let all = [
            SourceHash::of_file(b"a", &[], &none),
            SourceHash::of_file(b"b", &[], &none),
            SourceHash::of_file(b"a", &[], &some),
            SourceHash::of_file(b"a", &[], &other),
            SourceHash::of_file(b"a", &[("x", b"yz")], &none),
            SourceHash::of_file(b"a", &[("xy", b"z")], &none),
            SourceHash::of_species(Species::Oak, 1, &usual),
            SourceHash::of_species(Species::Oak, 2, &usual),
            SourceHash::of_species(Species::Oak, 1, &high),
            SourceHash::of_species(Species::Birch, 1, &usual),
        ];
        for (i, a) in all.iter().enumerate() {
            assert!(all[i + 1..].iter().all(|b| a != b), "{i}");
            assert!(a.to_string().parse().is_ok_and(|b: SourceHash| b == *a));
        }
        assert_eq!(all[0], SourceHash::of_file(b"a", &[], &none));
        assert!("x".repeat(64).parse::<SourceHash>().is_err());
    }
}

//! Names in a file, as people read and type them.

use unicode_normalization::UnicodeNormalization;

/// Longest name that a message prints, letters.
const LONGEST: usize = 60;
/// Nodes that a message lists before it only counts them.
const MOST_LISTED: usize = 40;

/// A name as it reads: composed, so that a letter and its accent are one.
pub(super) fn composed(name: &str) -> String {
    name.nfc().collect()
}

/// What two names have in common that differ in letter case or in how accents are stored.
pub(super) fn key(name: &str) -> String {
    name.nfc().collect::<String>().to_lowercase().nfc().collect()
}

/// A name in quotes, shortened and on one line.
pub(super) fn quoted(name: &str) -> String {
    let name = composed(name);
    let mut text = String::from("\"");
    for letter in name.chars().take(LONGEST) {
        match letter {
            '"' | '\\' => text.extend(['\\', letter]),
            _ if letter.is_control() => text.extend(letter.escape_default()),
            _ => text.push(letter),
        }
    }
    if name.chars().count() > LONGEST {
        text.push('…');
    }
    text + "\""
}

/// `node 3 "Tree"`, or `node 3`.
pub(super) fn label(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => format!("{kind} {index} {}", quoted(name)),
        _ => format!("{kind} {index}"),
    }
}

/// The words of a name, in lower case: parted by anything but letters, and where a capital follows
/// a small letter.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for letter in composed(name).chars() {
        if !letter.is_alphabetic() || (before.is_lowercase() && letter.is_uppercase()) {
            words.push(String::new());
        }
        if letter.is_alphabetic()
            && let Some(word) = words.last_mut()
        {
            word.extend(letter.to_lowercase());
        }
        before = letter;
    }
    words
}

/// The level of detail that a name tells, and what comes before: `("tree", 2)` for `Tree_LOD2`.
pub(super) fn level(name: &str) -> Option<(String, u32)> {
    let name = key(name);
    for (at, _) in name.rmatch_indices("lod") {
        let digits = name[at + 3..].trim_start_matches(['_', '-', ' ', '.']);
        let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
        // "explode1" is a word of its own.
        if name[..at].chars().next_back().is_some_and(char::is_alphabetic) {
            continue;
        }
        if let Ok(level) = digits[..end].parse() {
            let base = name[..at].trim_end_matches(['_', '-', ' ', '.']);
            return Some((base.to_string(), level));
        }
    }
    None
}

/// The first of some things, and how many more there are.
pub(super) fn listed(all: &[String]) -> String {
    let some = all.iter().take(MOST_LISTED).map(String::as_str).collect::<Vec<_>>().join(", ");
    match all.len().saturating_sub(MOST_LISTED) {
        0 => some,
        more => format!("{some} and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_as_they_are_typed() {
        assert_eq!(quoted("Bla\u{308}tter"), "\"Blätter\"");
        assert_eq!(quoted("a\n\"b\""), "\"a\\n\\\"b\\\"\"");
        assert_eq!(quoted(&"x".repeat(90)).chars().count(), 63);
        assert_eq!(key("BLA\u{308}TTER"), key("blätter"));
        assert_ne!(key("Blatter"), key("Blätter"));
    }

    #[test]
    fn levels_of_detail_are_told_by_names() {
        assert_eq!(level("Tree_LOD2"), Some(("tree".into(), 2)));
        assert_eq!(level("oak.lod_0.leaves"), Some(("oak".into(), 0)));
        assert_eq!(level("LOD1"), Some((String::new(), 1)));
        for name in ["tree", "explode1", "lodge", "LOD", ""] {
            assert_eq!(level(name), None, "{name}");
        }
    }
}

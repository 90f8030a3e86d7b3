//! Options that are known by name, on command lines and in files.

/// A name that is none of a list.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{kind} {name:?} is not known; there are: {known}")]
pub struct UnknownName {
    kind: &'static str,
    name: String,
    known: String,
}

impl UnknownName {
    /// `kind` says what the name is of, `known` has the names that there are.
    pub fn new(kind: &'static str, name: &str, known: &[&str]) -> Self {
        Self { kind, name: name.to_owned(), known: known.join(", ") }
    }
}

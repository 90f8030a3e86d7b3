//! One error for everything that is read: it names the file, the place in it, and the cause.

use std::fmt;

/// Why an input was refused, for programs that decide by the kind; people read the message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum InputErrorKind {
    /// The bytes are not of the format they claim: truncated, garbage, the wrong type.
    Malformed,
    /// Something that the file names is not there: a buffer, an image, a node.
    Missing,
    /// An index, count or number lies outside what is allowed.
    OutOfRange,
    /// A NaN or an infinity.
    NotFinite,
    /// Valid, but of a kind that is not supported; the message names it.
    Unsupported,
    /// Nothing to work with: no triangles, no leaves, no samples.
    Empty,
}

/// A refused input: `file: place: cause`.
///
/// The file is a name for people, as the caller gave it: this crate opens no files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError {
    /// Name of the file, as the caller knows it.
    pub file: String,
    /// Where in the file: `accessor 3`, `line 12, column 4`, `animation "fall", node "leaf"`.
    /// Empty when the whole file is meant.
    pub place: String,
    /// What kind of fault it is.
    pub kind: InputErrorKind,
    /// What is wrong, and where possible what would be right.
    pub cause: String,
}

impl InputError {
    /// An error of `kind` at `place` in `file`.
    pub fn new(
        file: impl Into<String>,
        place: impl Into<String>,
        kind: InputErrorKind,
        cause: impl Into<String>,
    ) -> Self {
        Self { file: file.into(), place: place.into(), kind, cause: cause.into() }
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.file)?;
        if !self.place.is_empty() {
            write!(f, "{}: ", self.place)?;
        }
        f.write_str(&self.cause)
    }
}

impl std::error::Error for InputError {}

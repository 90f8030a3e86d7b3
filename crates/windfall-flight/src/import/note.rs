//! Notes: remarks on a file that was read, next to [`InputError`](windfall_core::InputError) for one that was not.
//!
//! A note names what was left out, repaired, or looks wrong; it never stops an import. Programs match on the
//! [`NoteCode`], whose text is stable; people read the message. Nothing here is specific to paths and nothing depends
//! on the rest of the crate. To use notes for tree import too, move this file to `windfall-core` as it is, re-export it
//! here, and add the codes of trees to [`NoteCode`].

use std::fmt;

/// What a [`Note`] is about. The text of a code ([`NoteCode::code`]) never changes once released.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum NoteCode {
    /// `columns-left-out`: a table has columns that are not read.
    ColumnsLeftOut,
    /// `fast-turn`: more than 90 degrees from one key to the next. Above 180 degrees the shorter way round is taken,
    /// which is another motion than the one that was recorded.
    FastTurn,
    /// `no-rotation`: a node has no rotation channel and keeps its own rotation.
    NoRotation,
    /// `other-takes`: the node is animated in several animations, and the first was taken.
    OtherTakes,
    /// `parent-motion`: nodes above the leaf are animated too, and their motion is part of the path.
    ParentMotion,
    /// `resampled`: keys are unevenly spaced and were resampled.
    Resampled,
    /// `rotation-held`: a channel of rotations covers a part of the path only; before and after, the leaf keeps the
    /// first or last rotation (as glTF says).
    RotationHeld,
    /// `scale-left-out`: a node has a scale channel; leaves keep their size.
    ScaleLeftOut,
}

impl NoteCode {
    /// Every code.
    pub const ALL: [Self; 8] = [
        Self::ColumnsLeftOut,
        Self::FastTurn,
        Self::NoRotation,
        Self::OtherTakes,
        Self::ParentMotion,
        Self::Resampled,
        Self::RotationHeld,
        Self::ScaleLeftOut,
    ];

    /// The stable name: lower-case words with hyphens, for programs, documentation and switches.
    pub fn code(self) -> &'static str {
        match self {
            Self::ColumnsLeftOut => "columns-left-out",
            Self::FastTurn => "fast-turn",
            Self::NoRotation => "no-rotation",
            Self::OtherTakes => "other-takes",
            Self::ParentMotion => "parent-motion",
            Self::Resampled => "resampled",
            Self::RotationHeld => "rotation-held",
            Self::ScaleLeftOut => "scale-left-out",
        }
    }
}

impl fmt::Display for NoteCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.code())
    }
}

/// A remark on a file that was read: `note[code]: file: place: message`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// What it is about, for programs.
    pub code: NoteCode,
    /// Name of the file, as the caller knows it.
    pub file: String,
    /// Where in the file: `node "leaf"`, `line 12`. Empty when the whole file is meant.
    pub place: String,
    /// What was left out, repaired or looks wrong, and where possible the way out.
    pub message: String,
}

impl Note {
    /// A note on `place` in `file`.
    pub fn new(
        code: NoteCode,
        file: impl Into<String>,
        place: impl Into<String>,
        message: impl Into<String>,
    ) -> Self {
        Self { code, file: file.into(), place: place.into(), message: message.into() }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "note[{}]: {}: ", self.code, self.file)?;
        if !self.place.is_empty() {
            write!(f, "{}: ", self.place)?;
        }
        f.write_str(&self.message)
    }
}

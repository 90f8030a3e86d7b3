//! Notes: remarks on a file that was read, next to [`InputError`](crate::InputError) for one that was not.
//!
//! A note names what was left out, repaired, or looks wrong; it never stops an import. Programs match on the
//! [`NoteCode`], whose text is stable; people read the message. `docs/notes.md` says what to do about each.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// What a [`Note`] is about. The text of a code ([`NoteCode::code`]) never changes once released.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum NoteCode {
    /// `animation-left-out`, trees: the file has animations; the tree stands as its nodes do.
    AnimationLeftOut,
    /// `attribute-left-out`, trees: vertex attributes that are not used.
    AttributeLeftOut,
    /// `blend-as-mask`, trees: a blended material became a mask, at a threshold from its picture.
    BlendAsMask,
    /// `columns-left-out`, paths: a table has columns that are not read.
    ColumnsLeftOut,
    /// `extension-left-out`, trees: an extension that the file uses, but does not require, is not read.
    ExtensionLeftOut,
    /// `fast-turn`, paths: more than 90 degrees from one key to the next. Above 180 degrees the shorter way round is taken,
    /// which is another motion than the one that was recorded.
    FastTurn,
    /// `ground-plane`, trees: a flat, wide primitive at the foot of the tree looks like ground.
    GroundPlane,
    /// `height-unusual`, trees: lower than 0.5 m or higher than 120 m.
    HeightUnusual,
    /// `levels-left-out`, trees: the file has levels of detail, and one of each is read.
    LevelsLeftOut,
    /// `mask-leaves-nothing`, trees: no texel of a picture is as opaque as its material's cut-off.
    MaskLeavesNothing,
    /// `no-rotation`, paths: a node has no rotation channel and keeps its own rotation.
    NoRotation,
    /// `no-wood`, trees: nothing is left that would be wood.
    NoWood,
    /// `nodes-as-leaves`, trees: each node is one leaf, though its pieces share no edge.
    NodesAsLeaves,
    /// `one-leaf`, trees: there is a single leaf.
    OneLeaf,
    /// `other-takes`, paths: the node is animated in several animations, and the first was taken.
    OtherTakes,
    /// `parent-motion`, paths: nodes above the leaf are animated too, and their motion is part of the path.
    ParentMotion,
    /// `primitive-left-out`, trees: points, lines, or primitives that are neither leaves nor wood.
    PrimitiveLeftOut,
    /// `resampled`, paths: keys are unevenly spaced and were resampled.
    Resampled,
    /// `rotation-held`, paths: a channel of rotations covers a part of the path only; before and after, the leaf keeps the
    /// first or last rotation (as glTF says).
    RotationHeld,
    /// `scale-left-out`, paths: a node has a scale channel; leaves keep their size.
    ScaleLeftOut,
    /// `several-trees`, trees: several nodes have wood and leaves of their own.
    SeveralTrees,
    /// `solid-crowns`, trees: closed solids were to be leaves; leaves were scattered over their surfaces.
    SolidCrowns,
    /// `tall-leaf`, trees: a leaf is more than half as large as the tree.
    TallLeaf,
    /// `texture-left-out`, trees: pictures other than those of the base colour are not used.
    TextureLeftOut,
    /// `vertex-colors`, trees: colours of vertices multiply those of materials.
    VertexColors,
    /// `wider-than-tall`, trees: wider than tall.
    WiderThanTall,
    /// `wood-by-piece`, trees: pieces among the leaves were taken for wood.
    WoodByPiece,
    /// `wood-in-full`, trees: this build cannot simplify wood, as in browsers, and the tree was not baked.
    WoodInFull,
}

impl NoteCode {
    /// Every code, in alphabetical order.
    pub const ALL: [Self; 28] = [
        Self::AnimationLeftOut,
        Self::AttributeLeftOut,
        Self::BlendAsMask,
        Self::ColumnsLeftOut,
        Self::ExtensionLeftOut,
        Self::FastTurn,
        Self::GroundPlane,
        Self::HeightUnusual,
        Self::LevelsLeftOut,
        Self::MaskLeavesNothing,
        Self::NoRotation,
        Self::NoWood,
        Self::NodesAsLeaves,
        Self::OneLeaf,
        Self::OtherTakes,
        Self::ParentMotion,
        Self::PrimitiveLeftOut,
        Self::Resampled,
        Self::RotationHeld,
        Self::ScaleLeftOut,
        Self::SeveralTrees,
        Self::SolidCrowns,
        Self::TallLeaf,
        Self::TextureLeftOut,
        Self::VertexColors,
        Self::WiderThanTall,
        Self::WoodByPiece,
        Self::WoodInFull,
    ];

    /// The stable name: lower-case words with hyphens, for programs, documentation and switches.
    pub const fn code(self) -> &'static str {
        match self {
            Self::AnimationLeftOut => "animation-left-out",
            Self::AttributeLeftOut => "attribute-left-out",
            Self::BlendAsMask => "blend-as-mask",
            Self::ColumnsLeftOut => "columns-left-out",
            Self::ExtensionLeftOut => "extension-left-out",
            Self::FastTurn => "fast-turn",
            Self::GroundPlane => "ground-plane",
            Self::HeightUnusual => "height-unusual",
            Self::LevelsLeftOut => "levels-left-out",
            Self::MaskLeavesNothing => "mask-leaves-nothing",
            Self::NoRotation => "no-rotation",
            Self::NoWood => "no-wood",
            Self::NodesAsLeaves => "nodes-as-leaves",
            Self::OneLeaf => "one-leaf",
            Self::OtherTakes => "other-takes",
            Self::ParentMotion => "parent-motion",
            Self::PrimitiveLeftOut => "primitive-left-out",
            Self::Resampled => "resampled",
            Self::RotationHeld => "rotation-held",
            Self::ScaleLeftOut => "scale-left-out",
            Self::SeveralTrees => "several-trees",
            Self::SolidCrowns => "solid-crowns",
            Self::TallLeaf => "tall-leaf",
            Self::TextureLeftOut => "texture-left-out",
            Self::VertexColors => "vertex-colors",
            Self::WiderThanTall => "wider-than-tall",
            Self::WoodByPiece => "wood-by-piece",
            Self::WoodInFull => "wood-in-full",
        }
    }
}

impl<'de> Deserialize<'de> for NoteCode {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::ALL
            .into_iter()
            .find(|code| code.code() == name)
            .ok_or_else(|| serde::de::Error::custom(format!("no note has the code \"{name}\"")))
    }
}

impl fmt::Display for NoteCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.code())
    }
}

impl Serialize for NoteCode {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.code())
    }
}

/// A remark on a file that was read: `note[code]: file: place: message`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_in_order_and_unlike() {
        assert!(NoteCode::ALL.windows(2).all(|pair| pair[0].code() < pair[1].code()));
        let words = |c: NoteCode| c.code().bytes().all(|b| b.is_ascii_lowercase() || b == b'-');
        assert!(NoteCode::ALL.into_iter().all(words));
    }

    #[test]
    fn a_note_names_code_file_and_place() {
        let note = Note::new(NoteCode::OneLeaf, "a.glb", "", "one");
        assert_eq!(note.to_string(), "note[one-leaf]: a.glb: one");
        let note = Note::new(NoteCode::NoWood, "a.glb", "mesh 1", "none");
        assert_eq!(note.to_string(), "note[no-wood]: a.glb: mesh 1: none");
    }
}

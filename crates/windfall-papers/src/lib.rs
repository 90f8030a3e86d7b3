//! The published strategies of falling leaves.

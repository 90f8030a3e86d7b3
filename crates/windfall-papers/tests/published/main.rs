//! Pictures and numbers of the published strategies: one program, so that all tests share a device and pipelines.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod figure9;
mod harness;
mod leaf_occlusion;
mod strategies;

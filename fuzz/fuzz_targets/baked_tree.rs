//! Any bytes are a baked tree or an error, with the right digest too: `cargo +nightly fuzz run baked_tree`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use windfall_tree::bake::{Viewers, reseal};
use windfall_tree::{BakedTree, bake};

fuzz_target!(|bytes: &[u8]| {
    let mut sealed = bytes.to_vec();
    reseal(&mut sealed);
    for bytes in [bytes, &sealed] {
        if let Ok(baked) = BakedTree::read(bytes, "fuzz") {
            // What is read is whole: it can be measured and baked again.
            assert!(baked.tree.height().is_finite());
            bake(&baked.tree, &baked.about, Viewers::Everything)
                .expect("a tree that was read can be baked");
        }
    }
});

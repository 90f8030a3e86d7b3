//! Any bytes are a tree or an error: `cargo +nightly fuzz run tree_import`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use windfall_tree::{ImportOptions, export_glb, import};

fuzz_target!(|bytes: &[u8]| {
    let outside = &mut |_: &str| Ok(vec![0; 256]);
    if let Ok(read) = import(bytes, "fuzz", &ImportOptions::default(), outside) {
        let tree = read.tree;
        // What is read is whole: it can be measured and written.
        assert!(tree.height().is_finite());
        export_glb(&tree).expect("a tree that was read can be written");
    }
});

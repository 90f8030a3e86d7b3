//! The libraries run in browsers: no files, threads, clocks or waiting.
//!
//! A lint would ban these for the crates' tests too, which may open files; so the sources are read.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

use std::path::{Path, PathBuf};

const BANNED: [(&str, &str); 14] = [
    ("fs::", "opens files: take bytes, give bytes"),
    ("std::fs", "opens files: take bytes, give bytes"),
    ("File::", "opens files: take bytes, give bytes"),
    ("std::net", "there are no sockets in a browser"),
    ("std::process", "there are no processes in a browser"),
    ("std::env", "the host decides, not the environment"),
    ("std::thread", "there are no threads in a browser"),
    ("thread::", "there are no threads in a browser"),
    ("rayon", "there are no threads in a browser"),
    ("pollster", "blocks: give the host a future or ask again later"),
    ("block_on", "blocks: give the host a future or ask again later"),
    ("wait_indefinitely", "blocks: the host polls the device"),
    ("Instant", "panics in a browser: time is an argument"),
    ("SystemTime", "panics in a browser: time is an argument"),
];

/// What breaks the rule in a source: its line and the reason. Comments and test modules are free.
fn faults(source: &str) -> Vec<(usize, &'static str, &'static str)> {
    let mut faults = Vec::new();
    for (number, line) in source.lines().enumerate() {
        // Test modules stand at the end of a file; `mod tests;` names a file of its own.
        if line.trim() == "mod tests {" {
            break;
        }
        let code = line.split("//").next().unwrap_or("");
        for (word, why) in BANNED {
            let starts = code
                .match_indices(word)
                .any(|(at, _)| !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_'));
            if starts {
                faults.push((number + 1, word, why));
            }
        }
    }
    faults
}

fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.ends_with("tests") {
            continue;
        }
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("tests.rs") {
            into.push(path);
        }
    }
}

#[test]
fn the_libraries_use_nothing_that_a_browser_lacks() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut files = Vec::new();
    for room in ["core", "tree", "flight", "gpu", "papers"] {
        let name = format!("windfall-{room}/src");
        let before = files.len();
        sources(&crates.join(&name), &mut files);
        assert!(files.len() > before + 5, "{name} has sources");
    }
    let mut found = Vec::new();
    for file in files {
        for (line, word, why) in faults(&std::fs::read_to_string(&file).unwrap()) {
            // Behind a feature that is off unless a program asks for it, and in no other file.
            if word == "rayon" && file.ends_with("windfall-tree/src/parallel.rs") {
                continue;
            }
            found.push(format!("{}:{line}: {word}: {why}", file.display()));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn banned_words_are_found_in_code_and_not_in_comments_or_tests() {
    let source = "\
        //! std::fs is banned\n\
        use std::{fs, thread};\n\
        let text = fs::read(path);\n\
        let offs::et = 1; // Instant\n\
        #[cfg(test)]\n\
        mod tests {\n\
        use std::fs;\n";
    let lines: Vec<usize> = faults(source).iter().map(|f| f.0).collect();
    assert_eq!(lines, [3]);
}

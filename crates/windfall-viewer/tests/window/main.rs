//! The viewer in a real window, driven by mouse and keys as a person drives it: `Xvfb` is its display, `xdotool` its
//! hands. The last lines of a failure say at which step it was.
//!
//! It has a `main` of its own: a window wants the first thread of its process.
#![expect(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

#[cfg(target_os = "linux")]
mod eyes;
#[cfg(target_os = "linux")]
mod hands;
#[cfg(target_os = "linux")]
mod inputs;
#[cfg(target_os = "linux")]
mod person;
#[cfg(target_os = "linux")]
mod steps;

/// Tells the process that runs the window from the one that watches over it.
#[cfg(target_os = "linux")]
const INSIDE: &str = "WINDFALL_WINDOW_TEST";

#[cfg(target_os = "linux")]
fn main() {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    if asked.iter().any(|word| word == "--list") {
        println!("window: test");
        return;
    }
    let filter = asked.iter().find(|word| !word.starts_with('-'));
    if filter.is_some_and(|filter| !"window".contains(filter.as_str())) {
        println!("\ntest result: ok. 0 passed; 0 failed; 0 ignored; 0 measured; 1 filtered out");
        return;
    }
    if std::env::var_os(INSIDE).is_some() {
        person::window();
        return;
    }
    println!("\nrunning 1 test");
    let good = watch();
    let (word, passed) = if good { ("ok", 1) } else { ("FAILED", 0) };
    println!("test window ... {word}\n");
    println!(
        "test result: {word}. {passed} passed; {} failed; 0 ignored; 0 measured; 0 filtered out",
        1 - passed
    );
    std::process::exit(i32::from(!good));
}

/// Runs the window in a process of its own, on a display of its own, and ends it if it hangs.
#[cfg(target_os = "linux")]
fn watch() -> bool {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};
    const LONGEST: Duration = Duration::from_secs(400);

    let display = Command::new("Xvfb")
        .args(["-displayfd", "1", "-screen", "0", "1024x900x24", "-nolisten", "tcp"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn();
    let mut display = match display {
        Ok(display) => display,
        Err(error) => {
            eprintln!("this test opens a window on Xvfb ({error}): apt-get install xvfb xdotool");
            return false;
        }
    };
    let mut number = String::new();
    BufReader::new(display.stdout.take().unwrap()).read_line(&mut number).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut window = Command::new(std::env::current_exe().unwrap())
        .env("DISPLAY", format!(":{}", number.trim()))
        .env_remove("WAYLAND_DISPLAY")
        .env(INSIDE, "1")
        .env("WINDFALL_CACHE_DIR", folder.path().join("cache"))
        .current_dir(folder.path())
        .spawn()
        .unwrap();
    let start = Instant::now();
    let good = loop {
        if let Some(status) = window.try_wait().unwrap() {
            break status.success();
        }
        if start.elapsed() > LONGEST {
            eprintln!("the window is still open after {LONGEST:?}");
            let _ = window.kill();
            break false;
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    let _ = (display.kill(), display.wait());
    good
}

#[cfg(not(target_os = "linux"))]
fn main() {
    println!("\nrunning 1 test\ntest window ... ignored: it needs an X server\n");
    println!("test result: ok. 0 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out");
}

//! Memory of this process, where the system tells it: on Linux.

/// Bytes of memory that the process has now.
pub fn resident() -> Option<u64> {
    of_status("VmRSS:")
}

/// Most bytes of memory that the process had, since it began or since [`reset_peak`].
pub fn peak() -> Option<u64> {
    of_status("VmHWM:")
}

/// Begins [`peak`] anew; whether the system can.
pub fn reset_peak() -> bool {
    std::fs::write("/proc/self/clear_refs", "5").is_ok()
}

fn of_status(field: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(field))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn the_peak_holds_what_was_given_back() {
        assert!(reset_peak());
        let before = peak().unwrap();
        let size = 64 << 20;
        let large = vec![1u8; size];
        assert!(large.iter().map(|&b| usize::from(b)).sum::<usize>() == size);
        drop(large);
        let after = peak().unwrap();
        assert!(after > before + size as u64 * 9 / 10, "{before} {after}");
        assert!(resident().unwrap() <= after);
    }
}

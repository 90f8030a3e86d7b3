// When leaves detach, seconds since the shedding began: windfall_core::shed is the reference.

fn detach_time(tree_seed: u32, delay: f32, gust_phase: f32, leaf_count: u32, rank: u32) -> f32 {
    let jitter = unit(hash(tree_seed ^ 0x7e1ea5edu, rank));
    let x = (f32(rank) + jitter) / f32(max(leaf_count, 1u));
    let eased = x + fall.shed_peak / (2.0 * PI) * sin(2.0 * PI * x);
    let even = fall.shed_start + delay + fall.shed_duration * eased;
    let turns = fall.gust_rate * even + gust_phase;
    return even + fall.shed_burst / (2.0 * PI * fall.gust_rate) * sin(2.0 * PI * (turns - floor(turns)));
}

// How many leaves have detached `ahead` seconds after the moment of the frame: those of lower shed rank.
fn detached_by(ahead: f32, tree_seed: u32, delay: f32, gust_phase: f32, leaf_count: u32) -> u32 {
    var low = 0u;
    var high = leaf_count;
    while low < high {
        let middle = (low + high) / 2u;
        let time = detach_time(tree_seed, delay, gust_phase, leaf_count, middle);
        if (fall.time - time) + fall.time_low >= -ahead {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

//! The same work on many things: on all cores with the feature `parallel`, else one after the other.
//!
//! Results come in the order of the things, so that they do not depend on the number of threads.

/// What `work` makes of each thing.
#[cfg(feature = "parallel")]
pub(crate) fn map<T: Sync, R: Send>(things: &[T], work: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    use rayon::prelude::*;
    things.par_iter().map(work).collect()
}

/// What `work` makes of each thing.
#[cfg(not(feature = "parallel"))]
pub(crate) fn map<T: Sync, R: Send>(things: &[T], work: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    things.iter().map(work).collect()
}

/// Things that are worth beginning together, where the first of them say whether the rest is needed.
pub(crate) const AT_ONCE: usize = if cfg!(feature = "parallel") { 8 } else { 1 };

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

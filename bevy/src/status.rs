//! How far everything is that is made in the background.

use bevy::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// What is on the GPU, as of the frame that was rendered last: for loading screens and statistics.
#[derive(Resource, Debug, Clone, Default)]
pub struct WindfallStatus(Arc<Numbers>);

#[derive(Debug, Default)]
struct Numbers {
    waiting: AtomicUsize,
    forests: AtomicUsize,
    views: AtomicUsize,
    bytes: AtomicU64,
}

impl WindfallStatus {
    /// Pipelines, models and forests that are not there yet.
    pub fn waiting(&self) -> usize {
        self.0.waiting.load(Ordering::Relaxed)
    }

    /// Forests on the GPU.
    pub fn forests(&self) -> usize {
        self.0.forests.load(Ordering::Relaxed)
    }

    /// Pairs of a forest and a camera, or a cascade of a light, that see each other.
    pub fn views(&self) -> usize {
        self.0.views.load(Ordering::Relaxed)
    }

    /// Bytes of GPU memory of the forests' trees and leaves, without models and views.
    pub fn bytes(&self) -> u64 {
        self.0.bytes.load(Ordering::Relaxed)
    }

    pub(crate) fn set(&self, waiting: usize, forests: usize, views: usize, bytes: u64) {
        self.0.waiting.store(waiting, Ordering::Relaxed);
        self.0.forests.store(forests, Ordering::Relaxed);
        self.0.views.store(views, Ordering::Relaxed);
        self.0.bytes.store(bytes, Ordering::Relaxed);
    }
}

//! The viewer of Windfall: walk through a forest, in a window or in a browser tab.
//!
//! One application for both ([`app`]): egui draws what is around the picture, Windfall's own parts draw the picture
//! into a texture of their own. What does not need a window is in [`state`].
//!
//! | part | what it is |
//! |---|---|
//! | [`state`] | settings and their undo, camera, clock, links, command lines |
//! | [`load`] | from settings to a forest on the GPU, beside the frames |
//! | [`picture`] | the forest's picture, a frame at a time |
//! | [`app`] | the application |
//! | `film` | a film, which the program renders beside the window |
//! | `native` | the window, its device, and files named on the command line |
//! | `web` | the page and its JavaScript interface |

pub mod app;
pub mod files;
#[cfg(not(target_arch = "wasm32"))]
mod film;
pub mod input;
pub mod load;
#[cfg(not(target_arch = "wasm32"))]
pub mod native;
pub mod pick;
pub mod picture;
pub mod state;
pub mod statistics;
mod ui;
#[cfg(target_arch = "wasm32")]
pub mod web;

/// Where links lead to: the page, in a browser.
fn page_address() -> String {
    #[cfg(target_arch = "wasm32")]
    return web::address();
    #[cfg(not(target_arch = "wasm32"))]
    String::new()
}

/// What to ask an adapter for. One that cannot draw a forest is asked for the same; it says what it lacks.
fn device(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let (features, limits) = match windfall_gpu::Requirements::of(adapter) {
        Ok(windfall_gpu::Requirements { features, limits, .. }) => (features, limits),
        Err(_) => (wgpu::Features::empty(), wgpu::Limits::default()),
    };
    #[cfg(not(target_arch = "wasm32"))]
    let timers = windfall_gpu::wgpu_profiler::GpuProfiler::ALL_WGPU_TIMER_FEATURES;
    #[cfg(target_arch = "wasm32")]
    let timers = wgpu::Features::empty();
    wgpu::DeviceDescriptor {
        label: Some("windfall"),
        required_features: features | timers & adapter.features(),
        required_limits: limits,
        ..Default::default()
    }
}

//! The device of a program without a window.

use anyhow::{Context, bail};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use windfall_gpu::wgpu_profiler::{GpuProfiler, GpuProfilerSettings, GpuTimerQueryResult};

/// No adapter was found, or not the one that was asked for.
#[derive(Debug)]
pub struct NoAdapter(String);

impl std::fmt::Display for NoAdapter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for NoAdapter {}

/// A device, its queue and its clock.
pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub profiler: GpuProfiler,
    /// The adapter's name and backend, for people.
    pub adapter: String,
    /// Whether fragments may write to buffers, as leaf occlusion needs it.
    pub fragment_stores: bool,
    /// The first error that no one else took.
    failure: Arc<Mutex<Option<wgpu::Error>>>,
}

impl Gpu {
    /// Opens the adapter that `WGPU_BACKEND` and `WGPU_ADAPTER_NAME` ask for, or the best.
    pub fn open() -> anyhow::Result<Self> {
        let asked = std::env::var("WGPU_ADAPTER_NAME").ok().filter(|name| !name.is_empty());
        // OpenGL last: its loader complains aloud where there is no display.
        let tries = match wgpu::Backends::from_env() {
            Some(backends) => vec![backends],
            None => vec![wgpu::Backends::PRIMARY, wgpu::Backends::SECONDARY],
        };
        let mut seen = Vec::new();
        for backends in tries {
            let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
                backends,
                ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
            });
            let adapter = if let Some(asked) = &asked {
                let all = pollster::block_on(instance.enumerate_adapters(backends));
                seen.extend(all.iter().map(|a| a.get_info().name));
                let asked = asked.to_lowercase();
                all.into_iter().find(|a| a.get_info().name.to_lowercase().contains(&asked))
            } else {
                let options = wgpu::RequestAdapterOptions {
                    power_preference: wgpu::PowerPreference::HighPerformance,
                    ..Default::default()
                };
                pollster::block_on(instance.request_adapter(&options)).ok()
            };
            if let Some(adapter) = adapter {
                return Self::with_adapter(&adapter);
            }
        }
        Err(NoAdapter(match asked {
            Some(asked) => format!("no adapter is named {asked:?}; there are: {seen:?}"),
            None => "no graphics adapter; a software one will do, on Debian: \
                     apt-get install mesa-vulkan-drivers"
                .to_owned(),
        })
        .into())
    }

    fn with_adapter(adapter: &wgpu::Adapter) -> anyhow::Result<Self> {
        let info = adapter.get_info();
        tracing::info!("adapter {} ({}), driver {}", info.name, info.backend, info.driver_info);
        let timers = GpuProfiler::ALL_WGPU_TIMER_FEATURES & adapter.features();
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("windfall"),
            // Levels of wood are drawn from the middle of a list.
            required_features: timers
                | (adapter.features() & wgpu::Features::INDIRECT_FIRST_INSTANCE),
            required_limits: adapter.limits(),
            ..Default::default()
        }))
        .with_context(|| format!("the adapter {} gives no device", info.name))?;
        let failure = Arc::new(Mutex::new(None));
        let first = Arc::clone(&failure);
        // Without this, a device that runs out of memory is a panic.
        device.on_uncaptured_error(Arc::new(move |error| {
            first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        }));
        let settings = GpuProfilerSettings {
            enable_timer_queries: !timers.is_empty(),
            enable_debug_groups: false,
            ..Default::default()
        };
        let profiler = GpuProfiler::new(&device, settings).context("timers")?;
        let flags = adapter.get_downlevel_capabilities().flags;
        let fragment_stores = flags.contains(wgpu::DownlevelFlags::FRAGMENT_WRITABLE_STORAGE);
        let adapter = format!("{} ({})", info.name, info.backend);
        Ok(Self { device, queue, profiler, adapter, fragment_stores, failure })
    }

    /// Fails if the device has, as when its memory did not suffice.
    pub fn check(&self) -> anyhow::Result<()> {
        match self.failure.lock().unwrap_or_else(PoisonError::into_inner).take() {
            None => Ok(()),
            Some(wgpu::Error::OutOfMemory { .. }) => bail!(
                "{} has too little memory for this; a smaller --size or fewer kinds of trees take \
                 less",
                self.adapter
            ),
            Some(error) => Err(error).with_context(|| self.adapter.clone()),
        }
    }

    /// Waits until everything submitted is done; fails if the device has, so that no one measures
    /// frames in which nothing was drawn.
    pub fn wait(&self) -> anyhow::Result<()> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).context("the device was lost")?;
        self.check()
    }

    /// Milliseconds of every pass of the oldest finished frame; of those of one name together.
    pub fn pass_times(&mut self) -> BTreeMap<String, f64> {
        fn collect(results: &[GpuTimerQueryResult], into: &mut BTreeMap<String, f64>) {
            for result in results {
                if let Some(time) = &result.time {
                    *into.entry(result.label.clone()).or_default() += (time.end - time.start) * 1e3;
                }
                collect(&result.nested_queries, into);
            }
        }
        let mut times = BTreeMap::new();
        let period = self.queue.get_timestamp_period();
        if let Some(results) = self.profiler.process_finished_frame(period) {
            collect(&results, &mut times);
        }
        times
    }
}

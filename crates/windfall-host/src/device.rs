//! A GPU device without a window: adapter selection, errors, and pass timers.

use anyhow::{Context, bail};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use wgpu_profiler::{GpuProfiler, GpuProfilerSettings, GpuTimerQueryResult};

/// There is no adapter, or none with the requested name.
#[derive(Debug)]
pub struct NoAdapter(String);

impl std::fmt::Display for NoAdapter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for NoAdapter {}

/// A device with its queue and its pass timers.
pub struct Gpu {
    /// The device, with all limits of its adapter.
    pub device: wgpu::Device,
    /// The queue of the device.
    pub queue: wgpu::Queue,
    /// Pass timers; without timestamps where the adapter has none.
    pub profiler: GpuProfiler,
    /// Name and backend of the adapter, for people.
    pub adapter: String,
    /// Whether fragment shaders may write to storage buffers, which leaf occlusion needs.
    pub fragment_stores: bool,
    /// The first uncaptured error since the last [`Gpu::check`].
    failure: Arc<Mutex<Option<wgpu::Error>>>,
}

impl Gpu {
    /// Opens the adapter that `WGPU_BACKEND` and `WGPU_ADAPTER_NAME` select. By default, it is the
    /// one with the highest performance.
    ///
    /// # Errors
    ///
    /// [`NoAdapter`] if there is no such adapter; others if the adapter gives no device.
    pub fn open() -> anyhow::Result<Self> {
        let requested = std::env::var("WGPU_ADAPTER_NAME").ok().filter(|name| !name.is_empty());
        // OpenGL comes last: its loader prints errors where there is no display.
        let attempts = match wgpu::Backends::from_env() {
            Some(backends) => vec![backends],
            None => vec![wgpu::Backends::PRIMARY, wgpu::Backends::SECONDARY],
        };
        let mut found = Vec::new();
        for backends in attempts {
            let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
                backends,
                ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
            });
            let adapter = if let Some(requested) = &requested {
                let all = pollster::block_on(instance.enumerate_adapters(backends));
                found.extend(all.iter().map(|a| a.get_info().name));
                let requested = requested.to_lowercase();
                all.into_iter().find(|a| a.get_info().name.to_lowercase().contains(&requested))
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
        Err(NoAdapter(match requested {
            Some(requested) => format!("no adapter is named {requested:?}; there are: {found:?}"),
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
            // Wood levels are drawn with an indirect `first_instance` above 0.
            required_features: timers
                | (adapter.features() & wgpu::Features::INDIRECT_FIRST_INSTANCE),
            required_limits: adapter.limits(),
            ..Default::default()
        }))
        .with_context(|| format!("the adapter {} gives no device", info.name))?;
        let failure = Arc::new(Mutex::new(None));
        let first = Arc::clone(&failure);
        // Without a handler, a device that runs out of memory panics.
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

    /// Takes the first uncaptured error of the device, if it had one.
    ///
    /// # Errors
    ///
    /// The device had an error since the last call, such as too little memory.
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

    /// Waits until all submitted work is done. It fails after a device error, so that frames in
    /// which nothing was drawn are not measured.
    ///
    /// # Errors
    ///
    /// The device is lost, or had an error; see [`Self::check`].
    pub fn wait(&self) -> anyhow::Result<()> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).context("the device was lost")?;
        self.check()
    }

    /// Milliseconds of each pass of the oldest finished frame. Passes with the same label are added
    /// up. Empty without timestamps.
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

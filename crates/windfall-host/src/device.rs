//! A GPU device without a window: adapter selection, errors, and pass timers.

use anyhow::{Context, bail};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use wgpu_profiler::{GpuProfiler, GpuProfilerSettings, GpuTimerQueryResult};
use windfall_gpu::{Job, Requirements, Timing};

/// Backends that the program is built with, by their names in `WGPU_BACKEND`.
const BACKENDS: [(&str, wgpu::Backends); 3] = [
    ("vulkan", wgpu::Backends::VULKAN),
    ("metal", wgpu::Backends::METAL),
    ("dx12", wgpu::Backends::DX12),
];

/// There is no adapter, or none with the requested backend or name.
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
    /// The device, with what [`Requirements`] asks for.
    pub device: wgpu::Device,
    /// The queue of the device.
    pub queue: wgpu::Queue,
    /// Pass timers; without timestamps where the adapter has none.
    pub profiler: GpuProfiler,
    /// Name and backend of the adapter, for people.
    pub adapter: String,
    /// What drives the adapter, with its version.
    pub driver: String,
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
    /// [`NoAdapter`] if there is no such adapter; others if no forest can be drawn on it or it gives no
    /// device.
    pub fn open() -> anyhow::Result<Self> {
        let requested = std::env::var("WGPU_ADAPTER_NAME").ok().filter(|name| !name.is_empty());
        let backends = requested_backends(std::env::var("WGPU_BACKEND").ok().as_deref())?;
        // Builds for debugging would write the lines of shaders into SPIR-V, which takes a fifth of the time of all
        // pipelines; WGPU_DEBUG=1 asks for it.
        let flags = wgpu::InstanceFlags::from_build_config() - wgpu::InstanceFlags::DEBUG;
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends,
            flags: flags.with_env(),
            ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
        });
        let mut found = Vec::new();
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
        Err(NoAdapter(match requested {
            Some(requested) => format!("no adapter is named {requested:?}; there are: {found:?}"),
            None => "no graphics adapter; a software one will do, on Debian: \
                     apt-get install mesa-vulkan-drivers"
                .to_owned(),
        })
        .into())
    }

    /// Opens every adapter that `WGPU_BACKEND` lets through and that can draw a forest, one at a time, for `each`;
    /// with `WGPU_ADAPTER_NAME` the one of that name alone.
    ///
    /// # Errors
    ///
    /// [`NoAdapter`] if there is none; those of `each`.
    pub fn for_each(mut each: impl FnMut(Self) -> anyhow::Result<()>) -> anyhow::Result<()> {
        if std::env::var("WGPU_ADAPTER_NAME").is_ok_and(|name| !name.is_empty()) {
            return each(Self::open()?);
        }
        let backends = requested_backends(std::env::var("WGPU_BACKEND").ok().as_deref())?;
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends,
            ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
        });
        let mut any = false;
        for adapter in pollster::block_on(instance.enumerate_adapters(backends)) {
            match Self::with_adapter(&adapter) {
                Ok(gpu) => {
                    any = true;
                    each(gpu)?;
                }
                Err(error) => tracing::warn!("{}: {error:#}", adapter.get_info().name),
            }
        }
        // Says why there is none.
        if any { Ok(()) } else { each(Self::open()?) }
    }

    fn with_adapter(adapter: &wgpu::Adapter) -> anyhow::Result<Self> {
        let info = adapter.get_info();
        tracing::info!("adapter {} ({}), driver {}", info.name, info.backend, info.driver_info);
        let Requirements { features, limits, off } =
            Requirements::of(adapter).with_context(|| info.name.clone())?;
        for off in off {
            tracing::info!("{off}");
        }
        // Parts of passes are timed too, where the adapter can.
        let timers = GpuProfiler::ALL_WGPU_TIMER_FEATURES & adapter.features();
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("windfall"),
            required_features: features | timers,
            required_limits: limits,
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
        let driver = format!("{} {}", info.driver, info.driver_info).trim().to_owned();
        Ok(Self { device, queue, profiler, adapter, driver, fragment_stores, failure })
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

    /// What measures the passes of a frame: [`windfall_gpu::Recording::timing`].
    pub fn timing(&self) -> Timing<'_> {
        Timing::from(&self.profiler)
    }

    /// Milliseconds of each pass of the oldest finished frame, and of parts of passes. Passes with the
    /// same label are added up; `"frame"` is the sum of the passes. Empty without timestamps.
    pub fn pass_times(&mut self) -> BTreeMap<String, f64> {
        let period = self.queue.get_timestamp_period();
        self.profiler.process_finished_frame(period).map_or_else(BTreeMap::new, |r| by_label(&r))
    }
}

/// Runs the jobs of [`windfall_gpu::Renderer::new_with`] on as many threads as the machine has cores.
pub fn run_jobs(jobs: Vec<Job<'_>>) {
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(jobs.len());
    let jobs = Mutex::new(jobs.into_iter());
    let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work = || {
        while let Some(job) = next() {
            job();
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
}

/// The backends that `WGPU_BACKEND` asks for, by default all.
fn requested_backends(names: Option<&str>) -> Result<wgpu::Backends, NoAdapter> {
    let all = wgpu::Backends::from_iter(BACKENDS.map(|b| b.1));
    let Some(names) = names.filter(|names| !names.is_empty()) else { return Ok(all) };
    let backends = wgpu::Backends::from_comma_list(names) & all;
    if backends.is_empty() {
        let known = BACKENDS.map(|b| b.0).join(", ");
        return Err(NoAdapter(format!(
            "WGPU_BACKEND={names}: no graphics adapter is used through that; there are: {known}"
        )));
    }
    Ok(backends)
}

fn by_label(results: &[GpuTimerQueryResult]) -> BTreeMap<String, f64> {
    fn collect(results: &[GpuTimerQueryResult], into: &mut BTreeMap<String, f64>) -> f64 {
        let mut sum = 0.0;
        for result in results {
            if let Some(time) = &result.time {
                let time = (time.end - time.start) * 1e3;
                *into.entry(result.label.clone()).or_default() += time;
                sum += time;
            }
            collect(&result.nested_queries, into);
        }
        sum
    }
    let mut times = BTreeMap::new();
    let frame = collect(results, &mut times);
    if !times.is_empty() {
        times.insert("frame".to_owned(), frame);
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn backends_are_asked_for_by_name() {
        let all = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
        assert_eq!(requested_backends(None).unwrap(), all);
        assert_eq!(requested_backends(Some("")).unwrap(), all);
        assert_eq!(requested_backends(Some("vulkan, gl")).unwrap(), wgpu::Backends::VULKAN);
        for name in ["gl", "webgpu", "glide"] {
            let error = requested_backends(Some(name)).unwrap_err().to_string();
            assert!(error.starts_with(&format!("WGPU_BACKEND={name}: ")), "{error}");
            assert!(error.ends_with("there are: vulkan, metal, dx12"), "{error}");
        }
    }

    #[test]
    fn every_job_is_run_once() {
        for count in [0, 1, 2, 50] {
            let runs: Vec<AtomicUsize> = (0..count).map(|_| AtomicUsize::new(0)).collect();
            let job = |run| -> Job<'_> {
                Box::new(move || {
                    AtomicUsize::fetch_add(run, 1, Ordering::Relaxed);
                })
            };
            run_jobs(runs.iter().map(job).collect());
            assert!(runs.iter().all(|run| run.load(Ordering::Relaxed) == 1), "{count}");
        }
    }

    #[test]
    fn a_frame_takes_as_long_as_its_passes() {
        let result = |label: &str, seconds: f64, nested_queries| GpuTimerQueryResult {
            label: label.to_owned(),
            pid: 0,
            tid: std::thread::current().id(),
            time: Some(1.0..1.0 + seconds),
            nested_queries,
        };
        let parts = vec![result("wood", 0.25, Vec::new()), result("leaves", 0.5, Vec::new())];
        let passes = [
            result("shadows", 1.0, Vec::new()),
            result("shadows", 1.0, Vec::new()),
            result("forest", 1.0, parts),
        ];
        let times = by_label(&passes);
        let expected =
            [("forest", 1e3), ("frame", 3e3), ("leaves", 5e2), ("shadows", 2e3), ("wood", 250.0)];
        assert!(times.iter().map(|(label, ms)| (label.as_str(), *ms)).eq(expected), "{times:?}");
        assert_eq!(by_label(&[]), BTreeMap::new());
    }
}

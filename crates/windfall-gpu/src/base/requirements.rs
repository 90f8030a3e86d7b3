//! What a device must offer, and what is turned off where it offers less.

/// A device that no forest can be drawn on.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unsupported {
    /// No compute shaders, as OpenGL ES 3.0 and WebGL.
    #[error("the adapter has no compute shaders; use Vulkan, Metal, DirectX 12 or WebGPU")]
    NoCompute,
    /// A limit below what every WebGPU device has.
    #[error("the adapter's {limit} is {has}; {needs} are needed")]
    Limit {
        /// Name of the limit.
        limit: &'static str,
        /// What the adapter has.
        has: u64,
        /// What is needed.
        needs: u64,
    },
}

/// Something that is turned off, and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum TurnedOff {
    /// Wood is drawn in full at any distance, and so are leaves that have let go:
    /// [`wgpu::Features::INDIRECT_FIRST_INSTANCE`] is missing.
    LevelsOfDetail,
    /// GPU time by pass is not measured: [`wgpu::Features::TIMESTAMP_QUERY`] is missing.
    GpuTimes,
}

impl std::fmt::Display for TurnedOff {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::LevelsOfDetail => {
                "wood and leaves off their trees are drawn in full at any distance: no INDIRECT_FIRST_INSTANCE"
            }
            Self::GpuTimes => "GPU time by pass is not measured: no TIMESTAMP_QUERY",
        })
    }
}

/// What to ask an adapter for, found before anything is built.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirements {
    /// Features to request: those of use that the adapter has. None is required.
    pub features: wgpu::Features,
    /// Limits to request: WebGPU's defaults, and larger buffers where the adapter has them.
    pub limits: wgpu::Limits,
    /// What is turned off on this adapter.
    pub off: Vec<TurnedOff>,
}

impl Requirements {
    /// Asks an adapter.
    ///
    /// # Errors
    ///
    /// [`Unsupported`], if no forest can be drawn on it.
    pub fn of(adapter: &wgpu::Adapter) -> Result<Self, Unsupported> {
        let compute = wgpu::DownlevelFlags::COMPUTE_SHADERS;
        let has_compute = adapter.get_downlevel_capabilities().flags.contains(compute);
        Self::from_parts(has_compute, adapter.features(), &adapter.limits())
    }

    fn from_parts(
        compute: bool,
        features: wgpu::Features,
        limits: &wgpu::Limits,
    ) -> Result<Self, Unsupported> {
        if !compute {
            return Err(Unsupported::NoCompute);
        }
        check_limits(limits)?;
        let wanted = wgpu::Features::INDIRECT_FIRST_INSTANCE | wgpu::Features::TIMESTAMP_QUERY;
        let mut off = Vec::new();
        if !features.contains(wgpu::Features::INDIRECT_FIRST_INSTANCE) {
            off.push(TurnedOff::LevelsOfDetail);
        }
        if !features.contains(wgpu::Features::TIMESTAMP_QUERY) {
            off.push(TurnedOff::GpuTimes);
        }
        Ok(Self {
            features: features & wanted,
            limits: wgpu::Limits {
                max_buffer_size: limits.max_buffer_size,
                max_storage_buffer_binding_size: limits.max_storage_buffer_binding_size,
                max_texture_dimension_2d: limits.max_texture_dimension_2d,
                ..wgpu::Limits::default()
            },
            off,
        })
    }
}

/// Whether a device was made with enough.
pub(crate) fn check_device(device: &wgpu::Device) -> Result<(), Unsupported> {
    check_limits(&device.limits())
}

fn check_limits(limits: &wgpu::Limits) -> Result<(), Unsupported> {
    let needed = wgpu::Limits::default();
    let all = [
        (
            "max_storage_buffers_per_shader_stage",
            u64::from(limits.max_storage_buffers_per_shader_stage),
            u64::from(needed.max_storage_buffers_per_shader_stage),
        ),
        ("max_bind_groups", limits.max_bind_groups.into(), needed.max_bind_groups.into()),
        (
            "max_compute_invocations_per_workgroup",
            limits.max_compute_invocations_per_workgroup.into(),
            needed.max_compute_invocations_per_workgroup.into(),
        ),
        (
            "max_uniform_buffer_binding_size",
            limits.max_uniform_buffer_binding_size,
            needed.max_uniform_buffer_binding_size,
        ),
        (
            "max_storage_buffer_binding_size",
            limits.max_storage_buffer_binding_size,
            needed.max_storage_buffer_binding_size,
        ),
    ];
    match all.into_iter().find(|(_, has, needs)| has < needs) {
        Some((limit, has, needs)) => Err(Unsupported::Limit { limit, has, needs }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_of_webgpus_defaults_is_enough_and_says_what_it_lacks() {
        let limits = wgpu::Limits::default();
        let all = Requirements::from_parts(true, wgpu::Features::all(), &limits).unwrap();
        assert_eq!(all.off, []);
        assert!(all.features.contains(wgpu::Features::INDIRECT_FIRST_INSTANCE));
        let none = Requirements::from_parts(true, wgpu::Features::empty(), &limits).unwrap();
        assert_eq!(none.off, [TurnedOff::LevelsOfDetail, TurnedOff::GpuTimes]);
        assert_eq!(none.features, wgpu::Features::empty());
    }

    #[test]
    fn what_is_too_little_is_named() {
        let features = wgpu::Features::all();
        let of = |compute, limits: &wgpu::Limits| {
            Requirements::from_parts(compute, features, limits).unwrap_err()
        };
        assert_eq!(of(false, &wgpu::Limits::default()), Unsupported::NoCompute);
        let few =
            wgpu::Limits { max_storage_buffers_per_shader_stage: 4, ..wgpu::Limits::default() };
        let error = of(true, &few).to_string();
        assert_eq!(error, "the adapter's max_storage_buffers_per_shader_stage is 4; 8 are needed");
    }
}

//! Runs an example in a window; with `--screenshot FILE`, without one, and writes what its cameras see after some seconds.

use bevy::camera::{ImageRenderTarget, RenderTarget};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::TextureFormat;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_windfall::{WindfallPlugin, WindfallStatus, WindfallTime};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// An application without a window, whose frames are a 60th of a second apart.
pub struct Headless {
    pub app: App,
    target: Handle<Image>,
}

/// Where cameras that would draw into a window draw.
#[derive(Resource)]
struct Target(Handle<Image>);

/// Time after which something is wrong with what is waited for.
const MOST: Duration = Duration::from_secs(100);

impl Headless {
    /// An application with what `build` adds to Bevy's and Windfall's plugins.
    pub fn new(size: UVec2, build: impl FnOnce(&mut App)) -> Self {
        let mut app = App::new();
        let plugins = DefaultPlugins
            .build()
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
            .set(AssetPlugin {
                file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/assets").into(),
                ..default()
            })
            .disable::<WinitPlugin>()
            .disable::<bevy::render::pipelined_rendering::PipelinedRenderingPlugin>()
            .disable::<bevy::log::LogPlugin>();
        app.add_plugins((plugins, WindfallPlugin));
        let step = Duration::from_nanos(1_000_000_000 / 60);
        app.insert_resource(TimeUpdateStrategy::ManualDuration(step));
        let image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None);
        let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
        app.insert_resource(Target(target.clone()));
        app.add_systems(First, draw_into_target);
        app.add_systems(PostStartup, draw_into_target);
        build(&mut app);
        while app.plugins_state() == bevy::app::PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
        Self { app, target }
    }

    /// Frames until all that is made in the background is there, with the clock at `time` seconds.
    pub fn settle(&mut self, time: f64) {
        let mut calm = 0;
        let begin = Instant::now();
        while begin.elapsed() < MOST {
            *self.app.world_mut().resource_mut::<WindfallTime>() =
                WindfallTime { seconds: time, speed: 0.0 };
            self.app.update();
            let status = self.app.world().resource::<WindfallStatus>();
            calm = if status.waiting() == 0 { calm + 1 } else { 0 };
            if calm > 5 {
                return;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        panic!("after {MOST:?} something is still not there");
    }

    /// The picture at `time`: 4 bytes a pixel, row by row.
    pub fn picture(&mut self, time: f64) -> Image {
        self.settle(time);
        let got = Arc::new(Mutex::new(None));
        let put = got.clone();
        self.app.world_mut().spawn(Screenshot::image(self.target.clone())).observe(
            move |captured: On<ScreenshotCaptured>| {
                if let Ok(mut put) = put.lock() {
                    *put = Some(captured.image.clone());
                }
            },
        );
        let begin = Instant::now();
        while begin.elapsed() < MOST {
            self.app.update();
            if let Some(image) = got.lock().ok().and_then(|mut got| got.take()) {
                return image;
            }
        }
        panic!("no picture after {MOST:?}");
    }
}

/// Cameras of windows draw into the target.
fn draw_into_target(target: Res<Target>, mut cameras: Query<&mut RenderTarget>) {
    for mut camera in &mut cameras {
        if matches!(*camera, RenderTarget::Window(_)) {
            *camera = RenderTarget::Image(ImageRenderTarget::from(target.0.clone()));
        }
    }
}

/// The `main` of an example.
#[allow(dead_code, reason = "tests make applications of their own")]
pub fn main(build: impl FnOnce(&mut App), time: f64) {
    let mut arguments = std::env::args().skip(1);
    match arguments.next().as_deref() {
        Some("--screenshot") => {
            let file = arguments.next().unwrap_or_else(|| "screenshot.png".into());
            let image = Headless::new(UVec2::new(960, 540), build).picture(time);
            let saved = image.try_into_dynamic().map_err(|e| e.to_string());
            let saved =
                saved.and_then(|image| image.to_rgb8().save(&file).map_err(|e| e.to_string()));
            match saved {
                Ok(()) => println!("{file}"),
                Err(cause) => eprintln!("{file}: {cause}"),
            }
        }
        _ => {
            let mut app = App::new();
            app.add_plugins((DefaultPlugins, WindfallPlugin));
            app.world_mut().resource_mut::<WindfallTime>().seconds = time;
            build(&mut app);
            app.run();
        }
    }
}

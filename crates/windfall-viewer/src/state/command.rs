//! The command line that gives the same picture.

use crate::state::settings::Settings;
use windfall_core::simplify::Reduction;
use windfall_gpu::DebugView;
use windfall_scenes::{CameraKey, Scene};

/// The `windfall render` of a moment seen from `camera`, whose time is that moment; `file` is where the scene is to be
/// saved where options do not say it all. `None` as second: the command line needs no file.
pub fn line(settings: &Settings, camera: &CameraKey, file: &str) -> (String, Option<Scene>) {
    let Settings { scene, .. } = settings;
    let mut words = vec!["windfall render".to_owned()];
    let base = windfall_scenes::named(&settings.name);
    let options = base.as_ref().map(|base| options(base, scene));
    let saved = match options {
        Some((options, rest)) if rest => {
            words.push(settings.name.clone());
            words.extend(options);
            None
        }
        _ => {
            words.push(quoted(file));
            Some(scene.clone())
        }
    };
    let number = |v: f64| ((v * 1e4).round() / 1e4 + 0.0).to_string();
    let place = |p: (f64, f64, f64)| [p.0, p.1, p.2].map(number).join(",");
    words.push(format!("--camera {} {} {}", place(camera.eye), place(camera.target), camera.fov));
    words.push(format!("--time {}", number(camera.time)));
    if let Some(rate) = settings.throw_rate {
        words.push(format!("--throw-rate {rate}"));
    }
    if settings.show != DebugView::default() {
        words.push(format!("--view {}", settings.show.name()));
    }
    words.push("--out picture.png".to_owned());
    (words.join(" "), saved)
}

/// The `windfall render` of a film of a scene that is saved as `file`: along its path, or as long as its own film.
pub fn film(scene: &Scene, file: &str) -> String {
    let words: Vec<String> =
        film_words(scene, file, "film.mp4").iter().map(|word| quoted(word)).collect();
    format!("windfall {}", words.join(" "))
}

/// The same in words, without the program, into `out`.
pub fn film_words(scene: &Scene, file: &str, out: &str) -> Vec<String> {
    let end = scene.camera.last().map_or(0.0, |key| key.time);
    let (first, last) = match (end * f64::from(scene.fps)).round() as u32 {
        0 => scene.frames,
        last => (0, last),
    };
    let (frames, fps) = (format!("{first}-{last}"), scene.fps.to_string());
    ["render", file, "--frames", &frames, "--fps", &fps, "--out", out].map(str::to_owned).into()
}

/// Options that make `scene` of `base`, and whether they say all of it.
fn options(base: &Scene, scene: &Scene) -> (Vec<String>, bool) {
    let mut made = base.clone();
    let mut words = Vec::new();
    macro_rules! option {
        ($($name:literal $($field:ident).+;)+) => {$(
            if made.$($field).+ != scene.$($field).+ {
                made.$($field).+ = scene.$($field).+.clone();
                words.push(format!("{} {}", $name, made.$($field).+));
            }
        )+};
    }
    option! {
        "--trees" count;
        "--season" season;
        "--seed" seed;
        "--strategy" strategy;
        "--prune-order" prune_order;
        "--elimination" elimination;
        "--quality" quality;
        "--culling" culling;
        "--h" detail.h;
        "--soft-drop" fall.soft_drop;
        "--soft-time" fall.soft_time;
        "--settle-time" fall.settle_time;
        "--settle-turn" fall.settle_turn;
        "--wind-response" fall.wind_response;
    }
    if made.leaf_occlusion != scene.leaf_occlusion {
        made.leaf_occlusion = scene.leaf_occlusion;
        words.push(format!("--leaf-occlusion {}", if scene.leaf_occlusion { "on" } else { "off" }));
    }
    if made.size != scene.size {
        made.size = scene.size;
        words.push(format!("--size {}x{}", scene.size.0, scene.size.1));
    }
    if made.sky.picture != scene.sky.picture
        && let Some(picture) = &scene.sky.picture
    {
        made.sky.picture = Some(picture.clone());
        words.push(format!("--sky {}", quoted(picture)));
    }
    if made.detail.reduction != scene.detail.reduction {
        made.detail.reduction = scene.detail.reduction;
        words.push(match scene.detail.reduction {
            Reduction::Distance { d0 } => format!("--d0 {d0}"),
            Reduction::ProjectedArea { b0 } => format!("--b0 {b0}"),
        });
    }
    // The command line gives the camera and the moment.
    (made.camera, made.time, made.frames, made.fps) =
        (scene.camera.clone(), scene.time, scene.frames, scene.fps);
    (words, made == *scene)
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_say_what_they_can_and_a_file_the_rest() {
        let mut settings = Settings::named("autumn").unwrap();
        let camera =
            CameraKey { time: 7.25, eye: (1.0, 2.0, 30.0), target: (0.0, 5.0, 0.0), fov: 50.0 };
        settings.scene.season = 0.8;
        settings.scene.count = 12;
        let (text, file) = line(&settings, &camera, "my forest.ron");
        assert_eq!(
            text,
            "windfall render autumn --trees 12 --season 0.8 --camera 1,2,30 0,5,0 50 --time 7.25 \
             --out picture.png"
        );
        assert_eq!(file, None);
        let mut scene = settings.scene.clone();
        scene.camera.push(CameraKey { time: 4.0, ..camera });
        let seconds = (4.0 * scene.fps) as u32;
        assert_eq!(
            film(&scene, "a.ron"),
            format!(
                "windfall render a.ron --frames 0-{seconds} --fps {} --out film.mp4",
                scene.fps
            )
        );
        settings.scene.wind.speed = 9.0;
        let (text, file) = line(&settings, &camera, "my forest.ron");
        assert!(text.starts_with("windfall render 'my forest.ron' --camera"), "{text}");
        assert_eq!(file, Some(settings.scene));
    }
}

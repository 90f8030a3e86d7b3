//! Links: what differs from a built-in scene, as `key=value` pairs in a URL's hash.
//!
//! `#scene=autumn&time=12.5&season=0.8&wind.speed=3` - the keys are those of scene files, and so are the
//! values, as JSON. Beside them there are `scene`, `throw`, `view`, `effects` and `camera`.

use crate::state::settings::{Settings, effects, numbers};
use serde_json::{Map, Value};
use std::fmt::Write;
use windfall_gpu::DebugView;
use windfall_scenes::{CameraKey, Scene};

/// Why a text is no link.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LinkError {
    /// There is no such built-in scene.
    #[error("no built-in scene is called {0:?}")]
    Scene(String),
    /// A pair is wrong.
    #[error("{key}: {cause}")]
    Pair {
        /// Its key.
        key: String,
        /// What is wrong with it.
        cause: String,
    },
}

/// A place to stand and a moment.
pub type Shot = Option<CameraKey>;

/// The hash of settings at a moment, without `#`, seen from `camera`, whose time is that moment. Scenes of
/// files cannot be linked to; the link is then that of what they have in common with the default scene.
pub fn write(settings: &Settings, camera: Shot) -> String {
    let known = windfall_scenes::named(&settings.name).is_some();
    let name = if known { &settings.name } else { windfall_scenes::NAMES[0] };
    let Some(base) = Settings::named(name) else { return String::new() };
    let mut pairs = vec![("scene".to_owned(), name.to_owned())];
    let mut scene = settings.scene.clone();
    if let Some(key) = camera {
        scene.time = key.time;
    }
    differences("", &json(&base.scene), &json(&scene), &mut pairs);
    if let Some(rate) = settings.throw_rate {
        pairs.push(("throw".into(), rate.to_string()));
    }
    if settings.show != DebugView::default() {
        pairs.push(("view".into(), settings.show.name().into()));
    }
    let mut quality = settings.quality;
    let mut preset = settings.scene.quality_of_view();
    let mut changed: Vec<String> = effects(&mut quality)
        .into_iter()
        .zip(effects(&mut preset))
        .filter(|((_, now), (_, then))| *now != *then)
        .map(|((name, on), _)| format!("{}{}", if *on { "+" } else { "-" }, name.replace(' ', "_")))
        .collect();
    for ((name, now), (_, then)) in numbers(&mut quality).into_iter().zip(numbers(&mut preset)) {
        if now.get() != then.get() {
            changed.push(format!("{name}:{}", now.get()));
        }
    }
    if !changed.is_empty() {
        pairs.push(("effects".into(), changed.join(",")));
    }
    if let Some(CameraKey { eye, target, fov, .. }) = camera {
        let numbers = [eye.0, eye.1, eye.2, target.0, target.1, target.2, f64::from(fov)];
        let round = |v: f64| ((v * 1e4).round() / 1e4 + 0.0).to_string();
        pairs.push(("camera".into(), numbers.map(round).join(",")));
    }
    let mut hash = String::new();
    for (key, value) in pairs {
        let and = if hash.is_empty() { "" } else { "&" };
        let _ = write!(hash, "{and}{key}={}", escape(&value));
    }
    hash
}

/// Reads a hash, with or without `#`: the settings, and where the camera stands if it says so.
///
/// # Errors
///
/// An unknown scene or key, or a value that a scene cannot have.
pub fn read(hash: &str) -> Result<(Settings, Shot), LinkError> {
    let text = hash.trim_start_matches('#');
    let pairs: Vec<(String, String)> = text
        .split('&')
        .filter(|pair| !pair.is_empty())
        .map(|pair| {
            let (key, value) = pair.split_once('=').unwrap_or((pair, ""));
            (unescape(key), unescape(value))
        })
        .collect();
    let name =
        pairs.iter().find(|(key, _)| key == "scene").map_or(windfall_scenes::NAMES[0], |p| &p.1);
    let mut settings = Settings::named(name).ok_or_else(|| LinkError::Scene(name.to_owned()))?;
    let mut scene = json(&settings.scene);
    let mut camera = None;
    let mut switches = None;
    for (key, value) in &pairs {
        let wrong = |cause: String| LinkError::Pair { key: key.clone(), cause };
        match key.as_str() {
            "scene" => {}
            "throw" => {
                let rate: f32 = value.parse().map_err(|_| wrong("is no number".into()))?;
                if !(rate > 0.0 && rate.is_finite()) {
                    return Err(wrong(format!("{rate} is not above 0")));
                }
                settings.throw_rate = Some(rate);
            }
            "view" => settings.show = value.parse().map_err(|e| wrong(format!("{e}")))?,
            "effects" => switches = Some(value),
            "camera" if value.split(',').count() == 7 => {
                let numbers: Result<Vec<f64>, _> = value.split(',').map(str::parse).collect();
                let n = numbers.map_err(|_| wrong("is not seven numbers".into()))?;
                let (eye, target) = ((n[0], n[1], n[2]), (n[3], n[4], n[5]));
                camera = Some(CameraKey { time: 0.0, eye, target, fov: n[6] as f32 });
            }
            _ => set(&mut scene, key, value).map_err(wrong)?,
        }
    }
    let scene: Scene = serde_json::from_value(scene)
        .map_err(|e| LinkError::Pair { key: "link".into(), cause: e.to_string() })?;
    let check = |scene: &Scene| {
        scene
            .check("link")
            .map_err(|e| LinkError::Pair { key: e.place.clone(), cause: e.cause.clone() })
    };
    check(&scene)?;
    if let Some(key) = &mut camera {
        key.time = scene.time;
        check(&Scene { camera: vec![*key], ..scene.clone() })?;
    }
    (settings.quality, settings.scene) = (scene.quality_of_view(), scene);
    if let Some(switches) = switches {
        switch(&mut settings, switches)?;
    }
    Ok((settings, camera))
}

fn switch(settings: &mut Settings, list: &str) -> Result<(), LinkError> {
    for item in list.split(',') {
        let wrong = |cause| LinkError::Pair { key: "effects".into(), cause };
        if let Some((name, value)) = item.split_once(':') {
            let mut all = numbers(&mut settings.quality);
            let number = all.iter_mut().find(|(known, _)| *known == name);
            let (_, number) =
                number.ok_or_else(|| wrong(format!("no effect is called {name:?}")))?;
            let value = value.parse().map_err(|_| wrong(format!("{value:?} is no number")))?;
            number.set(value).map_err(wrong)?;
            continue;
        }
        let (on, name) = match item.split_at_checked(1) {
            Some(("+", name)) => (true, name),
            Some(("-", name)) => (false, name),
            _ => (true, item),
        };
        let mut all = effects(&mut settings.quality);
        let Some(effect) = all.iter_mut().find(|(known, _)| known.replace(' ', "_") == name) else {
            return Err(wrong(format!("no effect is called {name:?}")));
        };
        *effect.1 = on;
    }
    Ok(())
}

fn json(scene: &Scene) -> Value {
    serde_json::to_value(scene).unwrap_or_default()
}

/// Pairs of what `b` has other than `a`.
fn differences(path: &str, a: &Value, b: &Value, pairs: &mut Vec<(String, String)>) {
    if a == b || path == "about" || path == "version" {
        return;
    }
    match (a, b) {
        (Value::Object(of_a), Value::Object(of_b)) if same_keys(of_a, of_b) => {
            for (key, value) in of_b {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                differences(&path, &of_a[key], value, pairs);
            }
        }
        _ => pairs.push((path.to_owned(), short(b).to_string())),
    }
}

fn same_keys(a: &Map<String, Value>, b: &Map<String, Value>) -> bool {
    a.len() == b.len() && a.keys().all(|key| b.contains_key(key))
}

/// The same with numbers of single precision as short as they can be.
fn short(value: &Value) -> Value {
    match value {
        Value::Number(number) if !number.is_i64() && !number.is_u64() => {
            let exact = number.as_f64().unwrap_or(0.0);
            let single = exact as f32;
            if f64::from(single) != exact {
                return value.clone();
            }
            single.to_string().parse::<f64>().map_or_else(|_| value.clone(), Value::from)
        }
        Value::Array(items) => items.iter().map(short).collect(),
        Value::Object(map) => map.iter().map(|(k, v)| (k.clone(), short(v))).collect(),
        _ => value.clone(),
    }
}

/// Puts a value where a path of keys leads.
fn set(root: &mut Value, path: &str, text: &str) -> Result<(), String> {
    let value = serde_json::from_str(text).unwrap_or_else(|_| Value::from(text));
    let mut place = root;
    for key in path.split('.') {
        let map = place.as_object_mut().ok_or("has no such part")?;
        place = map.get_mut(key).ok_or_else(|| format!("a scene has no {key:?}"))?;
    }
    *place = value;
    Ok(())
}

fn escape(text: &str) -> String {
    let mut out = String::new();
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z'
            | b'A'..=b'Z'
            | b'0'..=b'9'
            | b'-'
            | b'.'
            | b'_'
            | b','
            | b':'
            | b'['
            | b']'
            | b'+' => out.push(byte as char),
            _ => {
                let _ = write!(out, "%{byte:02X}");
            }
        }
    }
    out
}

fn unescape(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let code = (bytes[i] == b'%')
            .then(|| text.get(i + 1..i + 3).and_then(|hex| u8::from_str_radix(hex, 16).ok()))
            .flatten();
        out.push(code.unwrap_or(bytes[i]));
        i += if code.is_some() { 3 } else { 1 };
    }
    String::from_utf8_lossy(&out).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use windfall_scenes::{QualityPreset, Strategy};

    fn key() -> CameraKey {
        CameraKey { time: 12.5, eye: (1.0, 1.7, 20.25), target: (0.0, 5.0, -3.5), fov: 42.0 }
    }

    #[test]
    fn a_link_is_the_picture() {
        for name in windfall_scenes::NAMES {
            let mut settings = Settings::named(name).unwrap();
            let (back, camera) = read(&write(&settings, None)).unwrap();
            assert_eq!((back, camera), (settings.clone(), None), "{name}");
            settings.scene.season = 0.123;
            settings.scene.wind.speed = 7.7;
            settings.scene.detail.h = 0.3;
            settings.scene.strategy = Strategy::VertexBuffer;
            settings.scene.quality = QualityPreset::Low;
            settings.quality = windfall_gpu::Quality::LOW;
            settings.quality.grass = true;
            (settings.quality.resolution, settings.quality.shadow_taps) = (0.75, 9);
            settings.scene.shedding = None;
            settings.scene.trees[0].height = Some(9.5);
            settings.show = DebugView::Loops;
            settings.throw_rate = Some(120.0);
            let link = write(&settings, Some(key()));
            let (back, camera) = read(&format!("#{link}")).unwrap();
            assert_eq!(camera, Some(key()), "{link}");
            settings.scene.time = 12.5;
            assert_eq!(back, settings, "{link}");
        }
    }

    #[test]
    fn links_are_short_and_legible() {
        let mut settings = Settings::named("lone-oak").unwrap();
        settings.scene.season = 0.7;
        settings.scene.sky.azimuth = 90.0;
        assert_eq!(write(&settings, None), "scene=lone-oak&season=0.7&sky.azimuth=90.0");
    }

    #[test]
    fn what_is_wrong_is_named() {
        let error = |hash: &str| read(hash).unwrap_err().to_string();
        assert_eq!(error("scene=nowhere"), "no built-in scene is called \"nowhere\"");
        assert_eq!(error("scene=autumn&saeson=1"), "saeson: a scene has no \"saeson\"");
        assert!(error("count=1e9").contains("link: "), "{}", error("count=1e9"));
        assert!(error("season=7").starts_with("season: "), "{}", error("season=7"));
        assert!(error("throw=-1").starts_with("throw: "));
        assert!(error("camera=1,2,3,1,2,3,50").starts_with("camera[0]: "));
        assert!(error("effects=-glitter").contains("glitter"));
        assert!(error("effects=glitter:1").contains("glitter"));
        assert!(error("effects=resolution:7").contains("0.25 to 1"));
        assert!(error("effects=shadow_taps:x").contains("\"x\""));
        assert!(error("view=sideways").contains("sideways"));
        assert_eq!(read("").unwrap().0, Settings::named("autumn").unwrap());
        // Bytes that are no letters do not panic.
        assert!(read("scene=%FF%e4%").is_err() && read("%=%&=&é=ü").is_err());
    }
}

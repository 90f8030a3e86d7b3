//! The built-in scenes.

use crate::Scene;

const SCENES: [(&str, &str); 7] = [
    ("autumn", include_str!("../scenes/autumn.ron")),
    ("against-the-sun", include_str!("../scenes/against-the-sun.ron")),
    ("forest-path", include_str!("../scenes/forest-path.ron")),
    ("hillside", include_str!("../scenes/hillside.ron")),
    ("leaves-in-the-air", include_str!("../scenes/leaves-in-the-air.ron")),
    ("lone-oak", include_str!("../scenes/lone-oak.ron")),
    ("under-the-canopy", include_str!("../scenes/under-the-canopy.ron")),
];

/// Names of the built-in scenes; the first is the default.
pub const NAMES: [&str; SCENES.len()] = {
    let mut names = [""; SCENES.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = SCENES[i].0;
        i += 1;
    }
    names
};

/// The built-in scene of this name.
///
/// # Panics
///
/// Never: a test reads every built-in scene.
pub fn named(name: &str) -> Option<Scene> {
    let (name, text) = SCENES.iter().find(|scene| scene.0 == name)?;
    Some(Scene::from_ron(text, name).expect("built-in scenes are tested"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_scene_reads_and_says_what_it_is() {
        for name in NAMES {
            assert!(!named(name).unwrap().about.is_empty(), "{name}");
        }
        assert_eq!(named("no such scene"), None);
    }
}

//! How a scene says how its trees are simplified.
//!
//! The options are [`Simplification`]'s own. A file has them in one list, without the groups that the
//! models keep them in; here is which key is which option.

use crate::Scene;
use crate::check::SceneName;
use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::ser::{SerializeStruct, Serializer};
use std::fmt;
use windfall_core::simplify::{FadeRange, Reduction, Simplification};
use windfall_core::{InputError, InputErrorKind};

/// Name that a file may give the list, before its parenthesis.
const NAME: &str = "DetailEntry";
/// Least and largest distance up to which trees are drawn in full, metres.
const D0: (f32, f32) = (0.01, 1e6);

/// Keys of a file whose value is an option as it is: the key, and the option in [`Simplification`].
macro_rules! options {
    ($($key:ident => $($option:ident).+,)+) => {
        /// Every key, in the order that files are written in.
        const KEYS: &[&str] = &["d0", "b0", "growth_factor", $(stringify!($key)),+];

        fn read<'de, A: MapAccess<'de>>(
            detail: &mut Simplification,
            key: &'static str,
            values: &mut A,
        ) -> Result<(), A::Error> {
            match key {
                $(stringify!($key) => detail.$($option).+ = values.next_value()?,)+
                _ => return Err(de::Error::unknown_field(key, KEYS)),
            }
            Ok(())
        }

        fn write<S: SerializeStruct>(
            detail: &Simplification,
            file: &mut S,
        ) -> Result<(), S::Error> {
            $(file.serialize_field(stringify!($key), &detail.$($option).+)?;)+
            Ok(())
        }
    };
}

options! {
    h => h,
    area_preservation => area_preservation,
    growth_pixels => growth.pixels,
    color_contrast => color_contrast,
    shading_contrast => shading_contrast,
    mean_cosine => mean_cosine,
    contrast_pixels => contrast_pixels,
    fade => fade.by,
    fade_range => fade.range,
    full_at_one => fade.full_at_one,
    early => fade.early,
    smooth => fade.smooth,
    wood_pixels => wood_pixels,
    leaf_pixels => leaf_pixels,
}

/// Writes a simplification as a scene file has it.
pub fn serialize<S: Serializer>(detail: &Simplification, serializer: S) -> Result<S::Ok, S::Error> {
    // Of `d0` and `b0` there is one.
    let mut file = serializer.serialize_struct(NAME, KEYS.len() - 1)?;
    match detail.reduction {
        Reduction::Distance { d0 } => {
            file.serialize_field("d0", &d0)?;
            file.skip_field("b0")?;
        }
        Reduction::ProjectedArea { b0 } => {
            file.skip_field("d0")?;
            file.serialize_field("b0", &Some(b0))?;
        }
    }
    let factor = detail.growth.factor;
    file.serialize_field("growth_factor", &(factor != f32::INFINITY).then_some(factor))?;
    write(detail, &mut file)?;
    file.end()
}

/// Reads a simplification as a scene file has it. What the file leaves out is as in
/// [`Simplification::DEFAULT`].
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Simplification, D::Error> {
    deserializer.deserialize_struct(NAME, KEYS, Options)
}

struct Options;

impl<'de> Visitor<'de> for Options {
    type Value = Simplification;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("options of a simplification")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut values: A) -> Result<Simplification, A::Error> {
        let mut detail = Simplification::DEFAULT;
        let mut seen = Vec::new();
        let (mut d0, mut b0): (Option<f32>, Option<f32>) = (None, None);
        while let Some(name) = values.next_key::<String>()? {
            let Some(&key) = KEYS.iter().find(|key| **key == name) else {
                return Err(de::Error::unknown_field(&name, KEYS));
            };
            if seen.contains(&key) {
                return Err(de::Error::duplicate_field(key));
            }
            seen.push(key);
            let result = match key {
                "d0" => values.next_value().map(|distance| d0 = Some(distance)),
                "b0" => values.next_value().map(|area| b0 = area),
                "growth_factor" => values.next_value().map(|factor: Option<f32>| {
                    detail.growth.factor = factor.unwrap_or(f32::INFINITY);
                }),
                _ => read(&mut detail, key, &mut values),
            };
            // An enum's error names the enum; the file knows the key.
            result.map_err(|error| de::Error::custom(format_args!("{key}: {error}")))?;
        }
        match (b0, d0) {
            // `b0` takes the place of `d0`, but does not excuse a `d0` that makes no sense.
            (Some(_), Some(d0)) if !(D0.0..=D0.1).contains(&d0) => {
                return Err(de::Error::custom(format_args!(
                    "d0: {d0} is not within {} to {}",
                    D0.0, D0.1
                )));
            }
            (Some(b0), _) => detail.reduction = Reduction::ProjectedArea { b0 },
            (None, Some(d0)) => detail.reduction = Reduction::Distance { d0 },
            (None, None) => {}
        }
        Ok(detail)
    }
}

/// Reads what `detail` of a scene says, `h: 0.7, fade: Opacity`, with or without its parentheses. What it leaves out is
/// as in [`Simplification::DEFAULT`].
///
/// # Errors
///
/// Keys that there are not, values that are not theirs or out of range; `name` is that of the text.
pub fn read_detail(text: &str, name: &str) -> Result<Simplification, InputError> {
    let inner = text.trim();
    let inner = inner.strip_prefix('(').and_then(|t| t.strip_suffix(')')).unwrap_or(inner);
    let malformed = |place: String, cause: String| {
        InputError::new(name, place, InputErrorKind::Malformed, cause)
    };
    let text = format!("({inner})");
    let mut file = ron::Deserializer::from_str(&text)
        .map_err(|e| malformed(String::new(), e.code.to_string()))?;
    let detail = deserialize(&mut file).map_err(|e| malformed(String::new(), e.to_string()))?;
    file.end().map_err(|e| malformed(String::new(), e.to_string()))?;
    check(&detail, &SceneName(name), "detail")?;
    Ok(detail)
}

impl Scene {
    pub(crate) fn check_detail(&self, scene: &SceneName<'_>) -> Result<(), InputError> {
        check(&self.detail, scene, "detail")?;
        check(&self.shadow_detail, scene, "shadow_detail")
    }
}

fn check(detail: &Simplification, scene: &SceneName<'_>, field: &str) -> Result<(), InputError> {
    let number = |key: &str, value: f32, (low, high): (f32, f32)| {
        scene.number(&format!("{field}.{key}"), value, low, high)
    };
    let optional =
        |key: &str, value: Option<f32>, range| value.map_or(Ok(()), |v| number(key, v, range));
    // Infinity sets no bound.
    let bound = |key: &str, value: f32, range| {
        if value == f32::INFINITY { Ok(()) } else { number(key, value, range) }
    };
    number("h", detail.h, (0.0, 0.99))?;
    match detail.reduction {
        Reduction::Distance { d0 } => number("d0", d0, D0)?,
        Reduction::ProjectedArea { b0 } => number("b0", b0, (0.01, 1e9))?,
    }
    bound("growth_factor", detail.growth.factor, (1.0, 1e6))?;
    bound("growth_pixels", detail.growth.pixels, (0.0, 1e6))?;
    optional("mean_cosine", detail.mean_cosine, (0.0, 1.0))?;
    optional("contrast_pixels", detail.contrast_pixels, (0.01, 1000.0))?;
    let (FadeRange::Constant(range)
    | FadeRange::Linear(range)
    | FadeRange::Quadratic(range)
    | FadeRange::Proportional(range)) = detail.fade.range;
    number("fade_range", range, (0.0, 1.0))?;
    number("wood_pixels", detail.wood_pixels, (0.0, 1000.0))?;
    number("leaf_pixels", detail.leaf_pixels, (0.0, 1000.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use windfall_core::simplify::{Fade, FadeBy, Growth};

    /// A list of options, alone.
    #[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
    struct Alone(#[serde(with = "super")] Simplification);

    fn read(text: &str) -> Result<Simplification, String> {
        match ron::from_str::<Alone>(&format!("({text})")) {
            Ok(alone) => Ok(alone.0),
            Err(error) => Err(error.code.to_string()),
        }
    }

    #[test]
    fn options_are_read_alone() {
        let smooth = read_detail("h: 0.7, fade: Opacity", "--detail").unwrap();
        assert_eq!((smooth.h, smooth.fade.by), (0.7, FadeBy::Opacity));
        assert_eq!(read_detail("(h: 0.7, fade: Opacity)", "--detail").unwrap(), smooth);
        for (text, cause) in [("h: 2", "detail.h"), ("hh: 1", "`hh`"), ("h 1", "colon")] {
            let error = read_detail(text, "--detail").unwrap_err().to_string();
            assert!(error.contains("--detail") && error.contains(cause), "{error}");
        }
    }

    #[test]
    fn every_key_is_its_option() {
        let text = "(h: 0.7, d0: 80, area_preservation: false, growth_factor: Some(1.75), \
            growth_pixels: 3, color_contrast: false, shading_contrast: false, \
            mean_cosine: Some(0.63), contrast_pixels: Some(2), fade: Opacity, \
            fade_range: Quadratic(0.1), full_at_one: false, early: true, smooth: true, \
            wood_pixels: 2, leaf_pixels: 9)";
        let expected = Simplification {
            reduction: Reduction::Distance { d0: 80.0 },
            h: 0.7,
            area_preservation: false,
            growth: Growth { factor: 1.75, pixels: 3.0 },
            color_contrast: false,
            shading_contrast: false,
            mean_cosine: Some(0.63),
            contrast_pixels: Some(2.0),
            fade: Fade {
                by: FadeBy::Opacity,
                range: FadeRange::Quadratic(0.1),
                full_at_one: false,
                early: true,
                smooth: true,
            },
            wood_pixels: 2.0,
            leaf_pixels: 9.0,
        };
        assert_eq!(read(text), Ok(expected));
        // None of them is what a file has that leaves it out.
        let lines = |detail| {
            let text = ron::ser::to_string_pretty(&Alone(detail), Default::default()).unwrap();
            text.lines().filter(|line| line.contains(": ")).map(str::to_owned).collect::<Vec<_>>()
        };
        let (given, left_out) = (lines(expected), lines(Simplification::DEFAULT));
        assert_eq!((given.len(), left_out.len()), (16, 16));
        for line in given {
            assert!(!left_out.contains(&line), "{line}");
        }
    }

    #[test]
    fn fades_have_the_names_of_the_paper() {
        for (text, range) in [
            ("(fade_range: Constant(0.1))", FadeRange::Constant(0.1)),
            ("(fade_range: Linear(0.2))", FadeRange::Linear(0.2)),
            ("(fade_range: Proportional(0.3))", FadeRange::Proportional(0.3)),
        ] {
            assert_eq!(read(text).unwrap().fade.range, range);
        }
        assert_eq!(read("(fade: Size)").unwrap().fade.by, FadeBy::Size);
    }

    #[test]
    fn a_tree_is_drawn_in_full_by_distance_or_by_area() {
        let reduction = |text| read(text).unwrap().reduction;
        let area = Reduction::ProjectedArea { b0: 900.0 };
        assert_eq!(reduction("()"), Reduction::Distance { d0: 30.0 });
        assert_eq!(reduction("(d0: 12, b0: None)"), Reduction::Distance { d0: 12.0 });
        assert_eq!(reduction("(b0: Some(900))"), area);
        // Files that were written with every key have both.
        assert_eq!(reduction("(d0: 12, b0: Some(900))"), area);
        assert_eq!(reduction("(b0: Some(900), d0: 12)"), area);
        assert_eq!(reduction("DetailEntry(b0: Some(900))"), area);
    }

    #[test]
    fn growth_without_a_bound_survives_writing_and_reading() {
        let free = read("(growth_factor: None, growth_pixels: 0)").unwrap();
        assert_eq!(free.growth, Growth { factor: f32::INFINITY, pixels: 0.0 });
        let unbounded = Simplification { growth: Growth::UNBOUNDED, ..free };
        for detail in [free, unbounded] {
            let text = ron::to_string(&Alone(detail)).unwrap();
            assert!(text.contains("growth_factor:None"), "{text}");
            assert_eq!(ron::from_str::<Alone>(&text), Ok(Alone(detail)), "{text}");
            assert_eq!(check(&detail, &SceneName("s.ron"), "detail"), Ok(()));
        }
    }

    #[test]
    fn what_is_no_option_is_refused() {
        for (text, message) in [
            (
                "(fade: Sise)",
                "fade: Unexpected variant named `Sise` in enum `FadeBy`, \
                 expected either `Size` or `Opacity`",
            ),
            ("(fade_range: Cubic(1))", "fade_range: Unexpected variant named `Cubic`"),
            (
                "(growth: 2)",
                "Unexpected field named `growth` in `DetailEntry`, expected one of `d0`, `b0`",
            ),
            ("(h: 0.5, h: 0.5)", "Unexpected duplicate field named `h`"),
            ("(d0: 1, d0: 1)", "Unexpected duplicate field named `d0`"),
            ("(h: true)", "h: Expected float"),
            ("(mean_cosine: 0.5)", "mean_cosine: Expected option"),
            ("(d0: -1, b0: Some(900))", "d0: -1 is not within 0.01 to 1000000"),
            ("(d0: NaN, b0: Some(900))", "d0: NaN is not within"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with(message), "{text}: {error}");
        }
    }

    #[test]
    fn numbers_out_of_range_are_refused_by_key() {
        for (text, message) in [
            ("(h: 1)", "h: 1 is not within 0 to 0.99"),
            ("(h: NaN)", "h: NaN is not within"),
            ("(d0: 0)", "d0: 0 is not within 0.01 to 1000000"),
            ("(b0: Some(0))", "b0: 0 is not within 0.01"),
            ("(growth_factor: Some(0.5))", "growth_factor: 0.5 is not within 1 to"),
            ("(growth_factor: Some(-inf))", "growth_factor: -inf"),
            ("(growth_pixels: -1)", "growth_pixels: -1"),
            ("(mean_cosine: Some(1.5))", "mean_cosine: 1.5"),
            ("(contrast_pixels: Some(0))", "contrast_pixels: 0"),
            ("(fade_range: Linear(2))", "fade_range: 2"),
            ("(wood_pixels: inf)", "wood_pixels: inf"),
            ("(leaf_pixels: NaN)", "leaf_pixels: NaN"),
        ] {
            let detail = read(text).unwrap();
            let error =
                check(&detail, &SceneName("s.ron"), "shadow_detail").unwrap_err().to_string();
            let message = format!("s.ron: shadow_detail.{message}");
            assert!(error.starts_with(&message), "{text}: {error}");
        }
    }
}

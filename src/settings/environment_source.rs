//! Sources of environments and backgrounds.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use crate::color::srgb8_to_linear;
use crate::scene::BuiltInLight;

use super::nearest::nearest;
use super::os_text::around;
use super::parse::{factor, finite};
use super::plate_pattern::PlatePattern;

/// Forms of an environment, for messages.
pub(crate) const ENVIRONMENT_FORMS: &str =
    "a .hdr or .exr file, R,G,B, studio, softbox, outdoor, dark or none";

/// Source of an environment.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum EnvironmentSource {
    /// No light.
    None,
    /// A light that needs no file.
    BuiltIn(BuiltInLight),
    /// Constant radiance, linear Rec.709.
    Constant([f32; 3]),
    /// Equirectangular image, rotated about +Y by degrees.
    File(PathBuf, f32),
}

impl EnvironmentSource {
    /// `none`, the name of a built-in light, `R,G,B`, or a file with `@degrees` behind it or not.
    ///
    /// # Errors
    /// One line that says what to write.
    pub fn parse(text: &OsStr) -> Result<Self, String> {
        match text.to_str() {
            Some("none") => return Ok(Self::None),
            Some(text) if is_number_list(text) => return constant(text).map(Self::Constant),
            Some(text) => {
                if let Some(light) = BuiltInLight::ALL.into_iter().find(|light| light.name() == text) {
                    return Ok(Self::BuiltIn(light));
                }
            }
            None => {}
        }
        let mark = text.as_encoded_bytes().iter().rposition(|&byte| byte == b'@');
        let turned = mark.and_then(|at| {
            let (file, degrees) = around(text, at)?;
            Some((file, finite(degrees).ok()?))
        });
        let (file, degrees) = turned.unwrap_or_else(|| (text.to_owned(), 0.0));
        if let Some(light) = BuiltInLight::ALL.into_iter().find(|light| file == light.name()) {
            return Err(format!("{} is built in and cannot be rotated; only images take @DEG", light.name()));
        }
        let looks_like_image = file.to_string_lossy().to_ascii_lowercase();
        let looks_like_image = [".hdr", ".exr"].iter().any(|end| looks_like_image.contains(end));
        if file.is_empty() || !(looks_like_image || Path::new(&file).exists()) {
            let suggestion = text.to_str().and_then(environment_suggestion).unwrap_or_default();
            return Err(format!("{suggestion}write {ENVIRONMENT_FORMS}"));
        }
        Ok(Self::File(PathBuf::from(file), degrees))
    }

    /// As the setting is written.
    pub fn to_text(&self) -> OsString {
        match self {
            Self::None => "none".into(),
            Self::BuiltIn(light) => light.name().into(),
            Self::Constant([r, g, b]) => format!("{r},{g},{b}").into(),
            Self::File(path, degrees) => {
                let mut text = path.clone().into_os_string();
                // Also where it is 0 and the name itself could be read as a rotation.
                if *degrees != 0.0 || path.to_string_lossy().contains('@') {
                    text.push(format!("@{degrees}"));
                }
                text
            }
        }
    }
}

/// What camera rays that leave the scene see.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum BackgroundSource {
    /// The environment that lights the scene.
    #[default]
    Light,
    /// An environment of its own; [`EnvironmentSource::None`] is transparent.
    Environment(EnvironmentSource),
    /// An exact sRGB colour of display images, behind the tone-mapped scene. EXR files are transparent there.
    Display([u8; 3]),
    /// Images behind the scene.
    Plate(PlatePattern),
}

impl BackgroundSource {
    /// A plate, `env` for the environment light, `white`, `black` or `#rrggbb` for an exact display colour, or an environment.
    ///
    /// # Errors
    /// One line that says what to write.
    pub fn parse(text: &OsStr) -> Result<Self, String> {
        if let Some(plate) = PlatePattern::parse(text)? {
            return Ok(Self::Plate(plate));
        }
        match text.to_str().map(str::to_ascii_lowercase).as_deref() {
            Some("env") => return Ok(Self::Light),
            Some("white") => return Ok(Self::Display([255; 3])),
            Some("black") => return Ok(Self::Display([0; 3])),
            Some(code) if code.starts_with('#') => {
                let color =
                    color_code(code).ok_or("write six hexadecimal digits after #, such as #ff8800")?;
                return Ok(Self::Display(color));
            }
            _ => {}
        }
        let source = EnvironmentSource::parse(text)
            .map_err(|why| format!("{why}, or env, white, black, #rrggbb, or an image such as plate.png"))?;
        Ok(Self::Environment(source))
    }

    /// As the setting is written.
    pub fn to_text(&self) -> OsString {
        match self {
            Self::Light => "env".into(),
            Self::Environment(source) => source.to_text(),
            Self::Plate(plate) => plate.to_text(),
            Self::Display([255, 255, 255]) => "white".into(),
            Self::Display([0, 0, 0]) => "black".into(),
            Self::Display([r, g, b]) => format!("#{r:02x}{g:02x}{b:02x}").into(),
        }
    }

    /// The separate environment that it shows, if any.
    pub fn environment(&self) -> Option<&EnvironmentSource> {
        match self {
            Self::Environment(source) => Some(source),
            Self::Light | Self::Display(_) | Self::Plate(_) => None,
        }
    }
}

/// Suggestions for words and colours of other programs.
fn environment_suggestion(text: &str) -> Option<String> {
    let suggestion = match text.to_ascii_lowercase().as_str() {
        "none" | "off" | "no" | "transparent" | "transparency" | "alpha" => "none".to_owned(),
        "white" => "1,1,1".to_owned(),
        "black" => "0,0,0".to_owned(),
        "grey" | "gray" => "0.18,0.18,0.18".to_owned(),
        other => {
            if let Some(name) = nearest(other, &BuiltInLight::ALL.map(BuiltInLight::name)) {
                return Some(format!("did you mean {name}? Else "));
            }
            let linear = color_code(other)?.map(|channel| format!("{:.3}", srgb8_to_linear(channel)));
            let short = linear.map(|text| text.trim_end_matches('0').trim_end_matches('.').to_owned());
            format!("{} (linear light)", short.join(","))
        }
    };
    Some(format!("did you mean {suggestion}? Else "))
}

/// The sRGB values of `#rrggbb`.
fn color_code(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6)?;
    let is_hexadecimal = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let [_, r, g, b] = u32::from_str_radix(digits, 16).ok().filter(|_| is_hexadecimal)?.to_be_bytes();
    Some([r, g, b])
}

fn is_number_list(text: &str) -> bool {
    text.contains(',') && text.split(',').all(|part| part.trim().parse::<f32>().is_ok())
}

fn constant(text: &str) -> Result<[f32; 3], String> {
    let values: Vec<f32> = text.split(',').map_while(|part| factor(part.trim()).ok()).collect();
    match (values.as_slice(), text.split(',').count()) {
        (&[r, g, b], 3) => Ok([r, g, b]),
        _ => Err("a constant environment is three numbers R,G,B that are not negative".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backgrounds_may_be_the_environment_light() {
        let parse = |text: &str| BackgroundSource::parse(OsStr::new(text));
        let of = |source| Ok(BackgroundSource::Environment(source));
        assert_eq!(parse("env"), Ok(BackgroundSource::Light));
        assert_eq!(parse("none"), of(EnvironmentSource::None));
        assert_eq!(parse("0,1,0"), of(EnvironmentSource::Constant([0.0, 1.0, 0.0])));
        assert_eq!(parse("sky.exr@-30"), of(EnvironmentSource::File("sky.exr".into(), -30.0)));
        assert!(parse("1,2").is_err() && parse("").is_err());
    }

    #[test]
    fn backgrounds_may_be_display_colours() {
        for (text, color) in [("white", [255; 3]), ("black", [0; 3]), ("#ff8800", [255, 136, 0])] {
            let parsed = BackgroundSource::parse(OsStr::new(text)).unwrap();
            assert_eq!(parsed, BackgroundSource::Display(color));
            assert_eq!(parsed.to_text(), text);
        }
        let orange = Ok(BackgroundSource::Display([255, 136, 0]));
        assert_eq!(BackgroundSource::parse(OsStr::new("#FF8800")), orange);
        assert_eq!(BackgroundSource::parse(OsStr::new("White")), Ok(BackgroundSource::Display([255; 3])));
        for text in ["#fff", "#+12345", "#ff88zz", "#", "#ff88001"] {
            assert!(BackgroundSource::parse(OsStr::new(text)).unwrap_err().contains("#ff8800"), "{text}");
        }
    }

    #[test]
    fn environments_are_files_colours_or_words() {
        let parse = |text: &str| EnvironmentSource::parse(OsStr::new(text));
        assert_eq!(parse("none"), Ok(EnvironmentSource::None));
        assert_eq!(parse("1,0.5,0"), Ok(EnvironmentSource::Constant([1.0, 0.5, 0.0])));
        assert_eq!(parse("a.hdr@90"), Ok(EnvironmentSource::File("a.hdr".into(), 90.0)));
        assert_eq!(parse("a@b.hdr"), Ok(EnvironmentSource::File("a@b.hdr".into(), 0.0)));
        for light in BuiltInLight::ALL {
            let source = EnvironmentSource::BuiltIn(light);
            assert_eq!((parse(light.name()), source.to_text()), (Ok(source.clone()), light.name().into()));
            assert!(ENVIRONMENT_FORMS.contains(light.name()));
            let background = BackgroundSource::parse(OsStr::new(light.name()));
            assert_eq!(background, Ok(BackgroundSource::Environment(source)));
        }
        for (text, suggested) in
            [("Studio", "studio"), ("soft_box", "softbox"), ("outdoors", "outdoor"), ("darc", "dark")]
        {
            assert!(parse(text).unwrap_err().contains(&format!("did you mean {suggested}?")), "{text}");
        }
        let transparent = BackgroundSource::parse(OsStr::new("transparent"));
        assert!(transparent.unwrap_err().contains("did you mean none?"));
        // They are not turned.
        assert!(parse("studio@90").unwrap_err().starts_with("studio is built in and cannot be rotated"));
        // sRGB 0x88 is 0.246 of linear light.
        assert!(parse("#ff8800").unwrap_err().contains("did you mean 1,0.246,0 (linear light)?"));
        assert!(parse("white").unwrap_err().contains("did you mean 1,1,1?"));
        assert_eq!(parse("a,b.hdr"), Ok(EnvironmentSource::File("a,b.hdr".into(), 0.0)));
        assert!(
            parse("1,2").is_err()
                && parse("1,2,-3").is_err()
                && parse("").is_err()
                && parse("1,2,inf").is_err()
        );
    }
}

//! Texts of single settings to values. Each error is one line that says what to write.

use crate::bvh::{Refit, Split};
use crate::film::PixelWindow;
use crate::render::{Aperture, EnvSamples, SampleRange};

use super::choices::FocusRequest;
use super::exposure::Exposure;
use crate::scene::{CameraRequest, ClipSelection, NameOrIndex, VariantRequest};

/// `1280x720`, or the name of a common size.
pub fn resolution(text: &str) -> Result<(u32, u32), String> {
    match text.to_ascii_lowercase().as_str() {
        "720p" => return Ok((1280, 720)),
        "1080p" => return Ok((1920, 1080)),
        "4k" | "2160p" => return Ok((3840, 2160)),
        _ => {}
    }
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| w.parse().ok().zip(h.parse().ok()));
    match sides {
        Some((0, _) | (_, 0)) => Err("an image needs at least one pixel each way".to_owned()),
        Some(sides) => Ok(sides),
        None => Err("write width and height in pixels, such as 1280x720, or 720p, 1080p or 4k".to_owned()),
    }
}

/// A whole number from `least` to `most`.
pub fn whole<T: TryFrom<i64>>(text: &str, least: i64, most: i64) -> Result<T, String> {
    let number = text.parse().ok().filter(|number| (least..=most).contains(number));
    number
        .and_then(|number: i64| T::try_from(number).ok())
        .ok_or_else(|| format!("write a whole number from {least} to {most}"))
}

/// A number of pixels, samples or frames; at least 1.
pub fn count(text: &str) -> Result<u32, String> {
    whole(text, 1, i32::MAX.into())
}

/// A frame number.
pub fn frame(text: &str) -> Result<i32, String> {
    whole(text, i32::MIN.into(), i32::MAX.into())
}

/// `50%` or `0.5`, as a factor. A bare number above 1 is ambiguous.
pub fn scale(text: &str) -> Result<f64, String> {
    let (number, unit) = match text.strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text, 1.0),
    };
    match number.parse::<f64>() {
        Ok(value) if unit == 1.0 && value > 1.0 && value <= 10_000.0 => {
            let factor = (value * 1e4).round() / 1e6;
            // A factor above 1 would be refused as well.
            let percent = if factor <= 1.0 { format!("{text}% or {factor}") } else { format!("{text}%") };
            // Up to ten times as large is likelier than up to a tenth.
            Err(if value < 10.0 {
                format!(
                    "write {}% for an image {text} times as large, or {percent} for a small one",
                    (value * 1e6).round() / 1e4
                )
            } else {
                format!("an image {text} times as large? Write {percent}")
            })
        }
        Ok(value) if value > 0.0 && value * unit <= 100.0 => Ok(value * unit),
        Ok(_) => Err("a scale lies above 0% and at most at 10000%; write 50%, 0.5 or 200%".to_owned()),
        Err(_) => Err("write a percentage such as 50% or 200%, or a factor up to 1 such as 0.5".to_owned()),
    }
}

/// `X0,Y0,X1,Y1`.
pub fn crop(text: &str) -> Result<PixelWindow, String> {
    let corners: Vec<u32> = text.split(',').map_while(|part| part.trim().parse().ok()).collect();
    match (corners.as_slice(), text.split(',').count()) {
        (&[x0, y0, x1, y1], 4) if x0 < x1 && y0 < y1 => Ok(PixelWindow { x0, y0, x1, y1 }),
        (&[_, _, _, _], 4) => Err("the crop is empty; X1 and Y1 lie beyond X0 and Y0".to_owned()),
        _ => Err("write X0,Y0,X1,Y1 in pixels from the top left".to_owned()),
    }
}

/// `4G`, `512MiB`, `2.5GB`, `4e9`, in bytes. Letters alone and with B are decimal, with iB binary.
pub fn memory_size(text: &str) -> Result<u64, String> {
    let (number, unit) = text.split_at(number_length(text));
    let unit: f64 = match unit.trim().to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kb" => 1e3,
        "m" | "mb" => 1e6,
        "g" | "gb" => 1e9,
        "t" | "tb" => 1e12,
        "kib" => 1024.0,
        "mib" => 1024.0 * 1024.0,
        "gib" => 1024.0 * 1024.0 * 1024.0,
        "tib" => 1024.0 * 1024.0 * 1024.0 * 1024.0,
        _ => return Err("write a size such as 4G, 512M or 8GiB".to_owned()),
    };
    match number.parse::<f64>() {
        Ok(value) if value * unit >= 1.0 && value * unit < 1e18 => Ok((value * unit) as u64),
        _ => Err("write a size such as 4G, 512M or 8GiB".to_owned()),
    }
}

/// Length of the decimal number that a text begins with, which may have an exponent.
fn number_length(text: &str) -> usize {
    let is_digit = |c: char| c.is_ascii_digit();
    let after_point = text.trim_start_matches(|c| is_digit(c) || c == '.');
    let exponent =
        after_point.strip_prefix(['e', 'E']).map(|rest| rest.strip_prefix(['+', '-']).unwrap_or(rest));
    let after =
        exponent.filter(|rest| rest.starts_with(is_digit)).map(|rest| rest.trim_start_matches(is_digit));
    text.len() - after.unwrap_or(after_point).len()
}

/// `auto`, `off` or an area in square metres.
pub fn split(text: &str) -> Result<Split, String> {
    match text {
        "auto" => Ok(Split::Auto),
        "off" => Ok(Split::Off),
        _ => match text.parse::<f32>() {
            Ok(area) if area > 0.0 && area.is_finite() => Ok(Split::Area(area)),
            _ => Err("write auto, off, or an area in square metres above 0".to_owned()),
        },
    }
}

/// References per triangle.
pub fn reference_budget(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if (1.0..=64.0).contains(&value) => Ok(value),
        _ => Err("write a number from 1 to 64".to_owned()),
    }
}

/// `auto`, `off` or a factor.
pub fn refit(text: &str) -> Result<Refit, String> {
    match text {
        "auto" => Ok(Refit::Auto),
        "off" => Ok(Refit::Off),
        _ => match text.parse::<f32>() {
            Ok(factor) if factor >= 1.0 => Ok(Refit::UpTo(factor)),
            _ => Err("write auto, off, or a factor of at least 1".to_owned()),
        },
    }
}

/// `0.5` frames or `180deg` of the shutter's turn, in frames.
pub fn shutter(text: &str) -> Result<f64, String> {
    const DEGREES: f64 = 360.0;
    const MOST: f64 = 100.0;
    let frames = match text.strip_suffix("deg") {
        Some(degrees) => degrees.trim().parse().map(|degrees: f64| degrees / DEGREES),
        None => text.parse(),
    };
    match frames {
        Ok(frames) if frames > 0.0 && frames <= MOST => Ok(frames),
        Ok(frames) if frames > MOST && frames / DEGREES <= MOST && !text.ends_with("deg") => {
            Err(format!("the shutter is open for 100 frames at most; did you mean {text}deg?"))
        }
        _ => {
            Err("write frames such as 0.5, or degrees such as 180deg, above 0 and up to 100 frames"
                .to_owned())
        }
    }
}

/// `0.01` metres or `f/2.8`.
pub fn aperture(text: &str) -> Result<Aperture, String> {
    let (number, of): (_, fn(f32) -> Aperture) = match text.strip_prefix("f/") {
        Some(number) => (number, Aperture::FNumber),
        None => (text, Aperture::Radius),
    };
    match finite(number) {
        Ok(value) if value > 0.0 => Ok(of(value)),
        _ => Err("write a radius in metres such as 0.01, or an f-number such as f/2.8".to_owned()),
    }
}

/// Degrees.
pub fn sun_angle(text: &str) -> Result<f32, String> {
    match finite(text) {
        Ok(degrees) if (0.0..=90.0).contains(&degrees) => Ok(degrees),
        _ => Err("write degrees from 0 to 90".to_owned()),
    }
}

/// A finite number.
pub fn finite(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("write a number".to_owned()),
    }
}

/// A finite number that is not negative.
pub fn factor(text: &str) -> Result<f32, String> {
    match finite(text) {
        Ok(value) if value >= 0.0 => Ok(value),
        _ => Err("write a number that is not negative".to_owned()),
    }
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f32, String> {
    match finite(text) {
        Ok(value) if value > 0.0 => Ok(value),
        _ => Err("write a number above 0, or leave it out".to_owned()),
    }
}

/// A number from 0 to 1.
pub fn share(text: &str) -> Result<f32, String> {
    match finite(text) {
        Ok(value) if (0.0..=1.0).contains(&value) => Ok(value),
        _ => Err("write a number from 0 to 1".to_owned()),
    }
}

/// `auto`, or stops.
pub fn exposure(text: &str) -> Result<Exposure, String> {
    match text {
        "auto" => Ok(Exposure::Auto),
        _ => match finite(text) {
            Ok(ev) if ev.abs() <= 64.0 => Ok(Exposure::Ev(ev)),
            _ => Err("write auto, or stops from -64 to 64".to_owned()),
        },
    }
}

/// `auto`, or a number of rays.
pub fn env_samples(text: &str) -> Result<EnvSamples, String> {
    match text {
        "auto" => Ok(EnvSamples::Auto),
        _ => whole(text, 0, 4096)
            .map(EnvSamples::Fixed)
            .map_err(|_| "write auto, or a whole number from 0 to 4096".to_owned()),
    }
}

/// Indices of the first and of the last sample, such as `0-63`.
pub fn sample_range(text: &str) -> Result<SampleRange, String> {
    let index = |text: &str| text.trim().parse::<u32>().ok();
    let range = text.split_once('-').and_then(|(first, last)| Some((index(first)?, index(last)?)));
    match range {
        Some((first, last)) if first <= last => Ok(SampleRange { first, last }),
        _ => Err("write the first and the last sample, such as 0-63".to_owned()),
    }
}

/// A time above 0 in seconds, or with the unit s, m or h.
pub fn time_span(text: &str) -> Result<f32, String> {
    let text = text.trim();
    let (number, unit) = match text.strip_suffix(['s', 'm', 'h']) {
        Some(number) if text.ends_with('m') => (number, 60.0),
        Some(number) if text.ends_with('h') => (number, 3600.0),
        Some(number) => (number, 1.0),
        None => (text, 1.0),
    };
    match number.trim().parse::<f32>() {
        Ok(number) if number > 0.0 && (number * unit).is_finite() => Ok(number * unit),
        _ => Err("write a time such as 30s, 5m or 1h".to_owned()),
    }
}

/// Distance in metres, `center`, or a node.
///
/// # Errors
/// For a distance that is not above 0.
pub fn focus(text: &str) -> Result<FocusRequest, String> {
    match text.parse::<f32>() {
        Ok(distance) if distance > 0.0 => Ok(FocusRequest::Metres(distance)),
        Ok(_) => Err("a distance lies above 0 metres".to_owned()),
        Err(_) if matches!(text, "center" | "middle") => Ok(FocusRequest::Center),
        Err(_) => Ok(FocusRequest::Node(NameOrIndex::parse(text))),
    }
}

/// `auto`, `each`, `#2` or a name.
pub fn camera(text: &str) -> CameraRequest {
    match text {
        "auto" => CameraRequest::Auto,
        "each" => CameraRequest::Each,
        _ => CameraRequest::Camera(NameOrIndex::parse(text)),
    }
}

/// `none`, `each`, `#2` or a name.
pub fn variant(text: &str) -> VariantRequest {
    match text {
        "none" => VariantRequest::None,
        "each" => VariantRequest::Each,
        _ => VariantRequest::Variant(NameOrIndex::parse(text)),
    }
}

/// `all`, `none`, `each`, `#2`, a name, or several with commas.
pub fn clips(text: &str) -> ClipSelection {
    match text {
        "each" => ClipSelection::Each,
        "all" => ClipSelection::All,
        "none" => ClipSelection::None,
        _ if text.contains(',') => ClipSelection::Together(text.to_owned()),
        _ => ClipSelection::One(NameOrIndex::parse(text)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_have_pixels() {
        assert_eq!(resolution("1280x720"), Ok((1280, 720)));
        assert_eq!((resolution("1080p"), resolution("4K")), (Ok((1920, 1080)), Ok((3840, 2160))));
        for text in ["0x1", "1x0", "1280", "x", "-1x1", "1.5x2", "99999999999x1"] {
            assert!(resolution(text).is_err(), "{text}");
        }
        assert_eq!(scale("50%"), Ok(0.5));
        assert_eq!(scale("0.25"), Ok(0.25));
        assert_eq!((scale("1"), scale("200%")), (Ok(1.0), Ok(2.0)));
        assert!(scale("50").unwrap_err().contains("rite 50% or 0.5"));
        assert!(
            scale("2").unwrap_err().starts_with("write 200% for an image 2 times as large, or 2% or 0.02")
        );
        assert!(scale("33.3").unwrap_err().ends_with("rite 33.3% or 0.333"));
        assert!(scale("150").unwrap_err().ends_with("rite 150%"));
        assert!(scale("20000").unwrap_err().starts_with("a scale lies above 0%"));
        assert!(scale("inf").is_err() && scale("1e300").is_err());
        assert!(
            scale("0%").is_err() && scale("NaN").is_err() && scale("-1").is_err() && scale("1e9%").is_err()
        );
        assert!(crop("1,2,3,4").is_ok());
        for text in ["1,2,1,4", "1,2,3", "1,2,3,4,5", "a,2,3,4", "-1,0,1,1"] {
            assert!(crop(text).is_err(), "{text}");
        }
    }

    #[test]
    fn counts_have_ends() {
        assert_eq!(whole(" 7".trim(), 1, 9), Ok(7_u16));
        assert_eq!(frame("-5"), Ok(-5));
        for text in ["0", "10", "-1", "1.5", "many", "", "99999999999999999999"] {
            let error = whole::<u16>(text, 1, 9).unwrap_err();
            assert_eq!(error, "write a whole number from 1 to 9", "{text}");
        }
        assert!(count("0").is_err() && count("2147483648").is_err() && frame("2147483648").is_err());
    }

    #[test]
    fn shutters_are_frames_or_degrees() {
        assert_eq!((shutter("0.5"), shutter("180deg"), shutter("36000 deg")), (Ok(0.5), Ok(0.5), Ok(100.0)));
        assert!(shutter("180").unwrap_err().contains("did you mean 180deg?"));
        // What is suggested is accepted.
        for text in ["36001", "1e9", "inf", "36001deg", "0", "-1", "nan"] {
            assert!(shutter(text).unwrap_err().starts_with("write frames such as 0.5"), "{text}");
        }
    }

    #[test]
    fn sizes_have_units() {
        assert_eq!(memory_size("4G"), Ok(4_000_000_000));
        assert_eq!(memory_size("1KiB"), Ok(1024));
        assert_eq!(memory_size("2.5MB"), Ok(2_500_000));
        // As TOML writes numbers.
        assert_eq!((memory_size("1e9"), memory_size("2.5E+3 kB")), (Ok(1_000_000_000), Ok(2_500_000)));
        assert!(memory_size("1e").is_err() && memory_size("1e-9").is_err() && memory_size("e9").is_err());
        assert!(memory_size("G").is_err() && memory_size("4X").is_err() && memory_size("0").is_err());
    }

    #[test]
    fn names_and_indices_are_distinguished() {
        assert_eq!(NameOrIndex::parse("#2"), NameOrIndex::Index(2));
        assert_eq!(NameOrIndex::parse("#x"), NameOrIndex::Name("#x".to_owned()));
        assert_eq!(camera("auto"), CameraRequest::Auto);
        assert_eq!((variant("none"), variant("each")), (VariantRequest::None, VariantRequest::Each));
        assert_eq!(variant("#0"), VariantRequest::Variant(NameOrIndex::Index(0)));
        assert_eq!(clips("Walk"), ClipSelection::One(NameOrIndex::Name("Walk".to_owned())));
    }
}

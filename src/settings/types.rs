//! The types of settings that are numbers, words or lists.

use std::ffi::{OsStr, OsString};
use std::fmt::{Debug, Display};
use std::marker::PhantomData;

use glam::Vec3;

use crate::bvh::{Refit, SimdLevel, Split};
use crate::film::PixelWindow;
use crate::image_file::ExrCompression;
use crate::output::{AovSet, LightSamples};
use crate::render::{Aperture, EnvSamples, SampleRange};
use crate::scene::{CameraRequest, ClipSelection, NameOrIndex, Orbit, VariantRequest};

use super::choices::{FocusRequest, GroundKind, LookAt};
use super::exposure::Exposure;
use super::frame_rate::FrameRate;
use super::frame_spec::{FrameSpec, frames_text};
use super::named::Named;
use super::setting_type::{NamedChoice, SettingType, ValueForm, check_text, unicode};
use super::{camera_values, lists, parse};

/// Declares types of settings: the value, how TOML writes it, text to value, value to text.
macro_rules! setting_types {
    ($($(#[doc = $doc:literal])+ $name:ident: $value:ty, $form:expr, $parse:expr, $write:expr;)+) => {$(
        $(#[doc = $doc])+
        #[derive(Debug)]
        pub struct $name;

        impl SettingType for $name {
            type Value = $value;
            const FORM: ValueForm = $form;

            fn parse(text: &OsStr) -> Result<$value, String> {
                let parse: fn(&str) -> Result<$value, String> = $parse;
                parse(unicode(text)?)
            }

            fn write(value: &$value) -> Vec<OsString> {
                let write: fn(&$value) -> String = $write;
                vec![write(value).into()]
            }

            fn check(value: &$value) -> Result<(), String> {
                check_text::<Self>(value)
            }
        }
    )+};
}

setting_types! {
    /// `true` or `false`.
    Flag: bool, ValueForm::FLAG, |text| text.parse().map_err(|_| "write true or false".to_owned()), bool::to_string;
    /// Number from 0.
    Factor: f32, ValueForm::NUMBER, parse::factor, f32::to_string;
    /// Number above 0.
    PositiveNumber: f32, ValueForm::NUMBER, parse::positive, f32::to_string;
    /// Number from 0 to 1.
    Share: f32, ValueForm::NUMBER, parse::share, f32::to_string;
    /// Degrees.
    Degrees: f32, ValueForm::NUMBER, parse::finite, f32::to_string;
    /// Degrees from -90 to 90.
    Elevation: f32, ValueForm::NUMBER, camera_values::elevation, f32::to_string;
    /// Vertical field of view in degrees.
    FieldOfView: f32, ValueForm::NUMBER, camera_values::field_of_view, f32::to_string;
    /// Focal length in millimetres.
    FocalLength: f32, ValueForm::NUMBER, camera_values::focal_length, f32::to_string;
    /// Azimuth, elevation and distance.
    OrbitType: Orbit, ValueForm::TEXT.or_list(","), camera_values::orbit, |orbit| {
        let Orbit { azimuth_degrees, elevation_degrees, distance } = orbit;
        format!("{azimuth_degrees},{elevation_degrees},{distance}")
    };
    /// Point or direction.
    Point: Vec3, ValueForm::TEXT.or_list(","), camera_values::point, point_text;
    /// Direction.
    Direction: Vec3, ValueForm::TEXT.or_list(","), camera_values::direction, point_text;
    /// Point or node.
    LookAtType: LookAt, ValueForm::TEXT.or_list(","), camera_values::look_at, |target| match target {
        LookAt::Point(point) => point_text(point),
        LookAt::Node(node) => name_or_index(node),
    };
    /// Degrees from 0 to 90.
    SunAngle: f32, ValueForm::NUMBER, parse::sun_angle, f32::to_string;
    /// Width and height in pixels.
    Resolution: (u32, u32), ValueForm::TEXT.or_list("x"), parse::resolution, |(width, height)| format!("{width}x{height}");
    /// Percentage or factor.
    Scale: f64, ValueForm::NUMBER_OR_TEXT, parse::scale,
        |&scale| if scale <= 1.0 { scale.to_string() } else { format!("{}%", scale * 100.0) };
    /// Rectangle of pixels.
    Crop: PixelWindow, ValueForm::TEXT.or_list(","), parse::crop,
        |window| format!("{},{},{},{}", window.x0, window.y0, window.x1, window.y1);
    /// Bytes.
    MemorySize: u64, ValueForm::NUMBER_OR_TEXT, parse::memory_size, u64::to_string;
    /// Early split clipping.
    SplitType: Split, ValueForm::NUMBER_OR_TEXT, parse::split, |split| match split {
        Split::Auto => "auto".to_owned(),
        Split::Off => "off".to_owned(),
        Split::Area(area) => area.to_string(),
    };
    /// References per triangle, from 1.
    ReferenceBudget: f32, ValueForm::NUMBER, parse::reference_budget, f32::to_string;
    /// Refitting.
    RefitType: Refit, ValueForm::NUMBER_OR_TEXT, parse::refit, |refit| match refit {
        Refit::Auto => "auto".to_owned(),
        Refit::Off => "off".to_owned(),
        Refit::UpTo(factor) => factor.to_string(),
    };
    /// Frames for which the shutter is open.
    ShutterFrames: f64, ValueForm::NUMBER_OR_TEXT, parse::shutter, f64::to_string;
    /// Radius or f-number of a lens.
    ApertureType: Aperture, ValueForm::NUMBER_OR_TEXT, parse::aperture, |aperture| match aperture {
        Aperture::Radius(radius) => radius.to_string(),
        Aperture::FNumber(number) => format!("f/{number}"),
    };
    /// Distance of focus.
    FocusType: FocusRequest, ValueForm::NUMBER_OR_TEXT, parse::focus, |focus| match focus {
        FocusRequest::Center => "center".to_owned(),
        FocusRequest::Metres(distance) => distance.to_string(),
        FocusRequest::Node(node) => name_or_index(node),
    };
    /// Brightness in stops.
    ExposureType: Exposure, ValueForm::NUMBER_OR_TEXT, parse::exposure, |exposure| match exposure {
        Exposure::Auto => "auto".to_owned(),
        Exposure::Ev(stops) => stops.to_string(),
    };
    /// Number of shadow rays to the environment.
    EnvSamplesType: EnvSamples, ValueForm::NUMBER_OR_TEXT, parse::env_samples, |samples| match samples {
        EnvSamples::Auto => "auto".to_owned(),
        EnvSamples::Fixed(rays) => rays.to_string(),
    };
    /// Indices of samples.
    SampleRangeType: SampleRange, ValueForm::TEXT, parse::sample_range,
        |range| format!("{}-{}", range.first, range.last);
    /// Seconds.
    TimeSpan: f32, ValueForm::NUMBER_OR_TEXT, parse::time_span, f32::to_string;
    /// Frame numbers.
    Frames: FrameSpec, ValueForm::NUMBER_OR_TEXT.or_list(","), FrameSpec::parse, |frames| match frames {
        FrameSpec::Listed(frames) => {
            frames_text(frames).trim_start_matches("frames ").trim_start_matches("frame ").to_owned()
        }
        FrameSpec::All | FrameSpec::Range { .. } | FrameSpec::Named(_) => "all".to_owned(),
    };
    /// Frames per second.
    Rate: FrameRate, ValueForm::NUMBER_OR_TEXT, FrameRate::parse, FrameRate::to_string;
    /// Name or index.
    NameOrIndexType: NameOrIndex, ValueForm::TEXT, |text| Ok(NameOrIndex::parse(text)), name_or_index;
    /// Camera.
    CameraType: CameraRequest, ValueForm::TEXT, |text| Ok(parse::camera(text)), |camera| match camera {
        CameraRequest::Auto => "auto".to_owned(),
        CameraRequest::Each => "each".to_owned(),
        CameraRequest::Camera(camera) => name_or_index(camera),
    };
    /// Material variant.
    VariantType: VariantRequest, ValueForm::TEXT, |text| Ok(parse::variant(text)), |variant| match variant {
        VariantRequest::None => "none".to_owned(),
        VariantRequest::Each => "each".to_owned(),
        VariantRequest::Variant(variant) => name_or_index(variant),
    };
    /// Animation clips.
    Clips: ClipSelection, ValueForm::TEXT.or_list(","), |text| Ok(parse::clips(text)), |clips| match clips {
        ClipSelection::All => "all".to_owned(),
        ClipSelection::None => "none".to_owned(),
        ClipSelection::Each => "each".to_owned(),
        ClipSelection::One(clip) => name_or_index(clip),
        ClipSelection::Together(clips) => clips.clone(),
    };
    /// AOVs.
    Aovs: AovSet, ValueForm::TEXT.or_list(","), lists::aovs,
        |aovs| aovs.as_slice().iter().map(|aov| aov.name()).collect::<Vec<_>>().join(",");
    /// Sample type and compression of EXR files.
    ExrEncoding: (LightSamples, ExrCompression), ValueForm::TEXT.or_list(","), lists::encoding,
        |(samples, compression)| format!("{},{}", samples.name(), compression.name());
}

fn point_text(point: &Vec3) -> String {
    let [x, y, z] = point.to_array();
    format!("{x},{y},{z}")
}

fn name_or_index(value: &NameOrIndex) -> String {
    match value {
        NameOrIndex::Name(name) => name.clone(),
        NameOrIndex::Index(index) => format!("#{index}"),
    }
}

/// Whole number from `MIN` to `MAX`.
#[derive(Debug)]
pub struct Whole<T, const MIN: i64, const MAX: i64>(PhantomData<T>);

impl<T, const MIN: i64, const MAX: i64> SettingType for Whole<T, MIN, MAX>
where
    T: TryFrom<i64> + Clone + Debug + Display + PartialEq,
{
    type Value = T;
    const FORM: ValueForm = ValueForm::NUMBER;

    fn parse(text: &OsStr) -> Result<T, String> {
        parse::whole(unicode(text)?, MIN, MAX)
    }

    fn write(value: &T) -> Vec<OsString> {
        vec![value.to_string().into()]
    }

    fn check(value: &T) -> Result<(), String> {
        check_text::<Self>(value)
    }
}

/// One of the names of an enum.
#[derive(Debug)]
pub struct OneOf<E>(PhantomData<E>);

impl<E: Named> SettingType for OneOf<E> {
    type Value = E;
    const FORM: ValueForm = ValueForm::TEXT;

    fn parse(text: &OsStr) -> Result<E, String> {
        let text = unicode(text)?;
        E::of_name(text).ok_or_else(|| no_choice(text, &Self::choices()))
    }

    fn write(value: &E) -> Vec<OsString> {
        vec![value.choice_name().into()]
    }

    fn choices() -> Vec<NamedChoice> {
        E::CHOICES.iter().map(|&(_, name, help)| (name, help)).collect()
    }
}

/// The message about a text that names none of the choices. Those without help have another name.
fn no_choice(text: &str, choices: &[NamedChoice]) -> String {
    let names: Vec<_> = choices.iter().filter(|(_, help)| !help.is_empty()).map(|&(name, _)| name).collect();
    lists::unknown(text, "one of the choices", &names)
}

/// Ground; `true` catches shadows.
#[derive(Debug)]
pub struct GroundType;

impl SettingType for GroundType {
    type Value = GroundKind;
    const FORM: ValueForm = ValueForm::FLAG_OR_TEXT;

    fn parse(text: &OsStr) -> Result<GroundKind, String> {
        match text.to_str() {
            Some("true") => Ok(GroundKind::Shadow),
            Some("false") => Ok(GroundKind::None),
            _ => OneOf::<GroundKind>::parse(text),
        }
    }

    fn write(value: &GroundKind) -> Vec<OsString> {
        OneOf::<GroundKind>::write(value)
    }

    fn choices() -> Vec<NamedChoice> {
        OneOf::<GroundKind>::choices()
    }
}

/// Instruction set; `best` is the best of this machine.
#[derive(Debug)]
pub struct Simd;

impl SettingType for Simd {
    type Value = Option<SimdLevel>;
    const FORM: ValueForm = ValueForm::TEXT;

    fn parse(text: &OsStr) -> Result<Option<SimdLevel>, String> {
        let text = unicode(text)?;
        if text == "best" {
            return Ok(None);
        }
        let level = SimdLevel::of_name(text).ok_or_else(|| no_choice(text, &Self::choices()))?;
        if !level.is_supported() {
            return Err("this machine lacks these instructions; leave the setting out".to_owned());
        }
        Ok(Some(level))
    }

    fn write(value: &Option<SimdLevel>) -> Vec<OsString> {
        vec![value.map_or("best", Named::choice_name).into()]
    }

    fn choices() -> Vec<NamedChoice> {
        let mut choices = vec![("best", "The best that this machine has")];
        choices.extend(OneOf::<SimdLevel>::choices());
        choices
    }
}

/// Names that add up.
#[derive(Debug)]
pub struct Names;

impl SettingType for Names {
    type Value = Vec<String>;
    const FORM: ValueForm = ValueForm { is_repeated: true, ..ValueForm::TEXT };

    fn parse(text: &OsStr) -> Result<Vec<String>, String> {
        Ok(vec![unicode(text)?.to_owned()])
    }

    fn write(value: &Vec<String>) -> Vec<OsString> {
        value.iter().map(OsString::from).collect()
    }

    fn add(earlier: &mut Vec<String>, later: Vec<String>) {
        earlier.extend(later);
    }
}

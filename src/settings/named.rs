//! Names and help of the choices of enums.

use crate::bvh::{BuilderKind, SimdLevel};
use crate::color::ToneCurve;
use crate::framing::NamedView;
use crate::image::PlateFit;
use crate::render::{GlassShadows, Integrator, PixelFilter};

use super::choices::{DenoiserKind, GroundKind, PreviewFormat, ProgressStyle, Switch};

/// An enum whose values have names.
pub trait Named: Copy + std::fmt::Debug + PartialEq + 'static {
    /// Every value with its name and its help, which is empty for a hidden one.
    const CHOICES: &'static [(Self, &'static str, &'static str)];

    /// Its name in settings.
    fn choice_name(self) -> &'static str {
        Self::CHOICES.iter().find(|(value, ..)| *value == self).map_or("", |(_, name, _)| name)
    }

    /// The value of a name.
    fn of_name(name: &str) -> Option<Self> {
        Self::CHOICES.iter().find(|(_, known, _)| *known == name).map(|(value, ..)| *value)
    }
}

macro_rules! named {
    ($($type:ident { $($value:ident = $name:literal, $help:literal;)+ })+) => {$(
        impl Named for $type {
            const CHOICES: &'static [(Self, &'static str, &'static str)] =
                &[$((Self::$value, $name, $help)),+];
        }
    )+};
}

named! {
    PreviewFormat {
        Png = "png", "sRGB with alpha, eight bits";
    }
    Integrator {
        Whitted = "whitted", "Whitted's tree of reflections, refractions and shadows";
        Path = "path", "Path tracing: light that bounces, and emissive surfaces as lamps; use 64 samples or more";
    }
    GlassShadows {
        Straight = "straight", "Light passes straight through, coloured by the glass";
        Opaque = "opaque", "Glass casts full shadows";
    }
    DenoiserKind {
        None = "none", "No denoiser";
        Oidn = "oidn", "Open Image Denoise, guided by albedo and normals; with 16 samples or more";
    }
    Switch {
        On = "on", "Yes";
        Off = "off", "No";
    }
    GroundKind {
        None = "none", "No ground";
        Shadow = "shadow", "Shadows; also true";
        Reflection = "reflection", "Shadows and mirror images, as on a polished floor";
    }
    PlateFit {
        Fill = "fill", "Covers the image; what reaches beyond is cut off";
        Fit = "fit", "Lies inside the image; the rest is transparent";
        Stretch = "stretch", "Takes the image's aspect ratio";
    }
    PixelFilter {
        Box = "box", "The pixel's square";
        Mitchell = "mitchell", "Four pixels wide, slightly sharper; use 16 samples or more";
        BlackmanHarris = "blackman-harris", "Three pixels wide and soft, as in Blender";
    }
    ToneCurve {
        Neutral = "neutral", "Khronos PBR Neutral: base colours keep their values";
        Standard = "standard", "Natural contrast; middle grey keeps its value, bright colours turn pale";
        Agx = "agx", "Low contrast, with headroom for bright and coloured light";
        Aces = "aces", "High contrast, as films made with ACES 1.0";
        Linear = "none", "No curve: unlit materials and textures keep their values, brighter light than white is cut off";
    }
    NamedView {
        Front = "front", "From +Z";
        Back = "back", "From -Z";
        Left = "left", "From -X";
        Right = "right", "From +X";
        Top = "top", "From above; the front is at the bottom";
        Bottom = "bottom", "From below; the front is at the top";
        ThreeQuarter = "three-quarter", "From the right, slightly above: orbit 30,20";
        ThreeQuarterBack = "three-quarter-back", "The same from the other side: orbit 210,20";
    }
    BuilderKind {
        Auto = "auto", "Karras' radix tree, clustered where that pays";
        Lbvh = "lbvh", "Karras' radix tree, not clustered";
        Ploc = "ploc", "Karras' radix tree, clustered (H-PLOC): better, slower to build";
        Karras = "karras", "Karras' radix tree, node by node as in the paper";
        BruteForce = "brute", "";
    }
    SimdLevel {
        Scalar = "scalar", "None";
        Sse42 = "sse4.2", "x86-64-v2, of 2008";
        Avx2 = "avx2", "x86-64-v3, of 2013";
        Avx512 = "avx512", "As of Ice Lake and Zen 4";
        Neon = "neon", "64-bit ARM";
    }
    ProgressStyle {
        Auto = "auto", "Bars on a terminal, one line per frame in a pipe";
        Bar = "bar", "Bars";
        Plain = "plain", "One line per frame";
        Json = "json", "JSON lines on the standard output";
        OpenJd = "openjd", "Open Job Description lines on the standard output, for AWS Deadline Cloud";
        None = "none", "No output";
    }
}

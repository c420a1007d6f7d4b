//! What was typed after `rayframe render`.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::bvh::{Refit, Split};
use crate::film::PixelWindow;
use crate::image_file::ExrCompression;
use crate::output::{AovSet, LightSamples};
use crate::render::Aperture;
use crate::settings::ProgressStyle;

use super::{layer_options, options};

/// Options of `rayframe render`, unchecked against each other and the scene.
#[derive(Clone, Debug, Args)]
#[expect(clippy::struct_excessive_bools, reason = "each is one flag of the command line")]
pub struct RenderArgs {
    /// The scene: .glb, .gltf, or a shot file .toml that names it and holds settings
    #[arg(required = false, required_unless_present_any = ["config", "set"])]
    pub scene: PathBuf,
    /// Settings from a shot file, for the scene given here or the one that it names; options and -D override them
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Any setting by its name in shot files, that of the long option; options override it
    #[arg(short = 'D', long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Output name; ####, %04d or {frame:04} is the frame number, .exr or .png the format
    /// [default: <scene>.####.exr in the current folder, <scene>.exr for a still]
    #[arg(short, long, visible_alias = "outfile", value_name = "PATTERN", help_heading = "Output")]
    pub output: Option<OsString>,
    /// Tone-mapped previews beside the EXR files
    #[arg(long, value_name = "FORMAT", help_heading = "Output")]
    pub preview: Option<PreviewFormat>,
    /// What EXR files hold besides the picture, separated by commas: depth, position, normal, geometric_normal, albedo,
    /// emission, direct, environment, reflection, refraction, pass_through, uv, object_id, material_id, node_id, motion,
    /// crypto_object, crypto_material; light, data, crypto and all stand for several
    #[arg(long, value_name = "LIST", value_parser = layer_options::layers, help_heading = "Output")]
    pub layers: Option<AovSet>,
    /// How EXR files are stored, in any order: half or float for the picture and its light (data is always float), and none,
    /// rle, zips, zip, piz, dwaa or dwab, of which the last two lose a little [default: half,zip]
    #[arg(long, value_name = "TYPE,COMPRESSION", value_parser = layer_options::encoding, help_heading = "Output")]
    pub exr: Option<(LightSamples, ExrCompression)>,
    /// A file for each layer beside the picture's, such as shot.depth.0001.exr, or with {layer} in the output's name
    #[arg(long, help_heading = "Output")]
    pub split_aovs: bool,
    /// EXR files tell when and on which machine they were made, and how long that took; without it equal runs make equal files
    #[arg(long, help_heading = "Output")]
    pub stamp: bool,
    /// All frames as one file that plays: .apng (exact), .gif, or .mp4, .mov, .webm, .mkv where ffmpeg is installed
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub movie: Option<PathBuf>,
    /// All frames small in one PNG picture, with their numbers
    #[arg(long, value_name = "FILE.png", help_heading = "Output")]
    pub contact_sheet: Option<PathBuf>,
    /// Show each finished frame on the terminal: as a picture (kitty, Ghostty, WezTerm, iTerm2), else in coloured blocks
    #[arg(long, help_heading = "Output")]
    pub show: bool,
    /// Keep whole frames of the same scene, settings and version; replace all others
    #[arg(long, conflicts_with = "overwrite", help_heading = "Output")]
    pub resume: bool,
    /// Render every frame, whatever is there
    #[arg(long, help_heading = "Output")]
    pub overwrite: bool,
    /// Per-frame statistics as JSON
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub stats: Option<PathBuf>,
    /// What became of each frame, with hashes of its files, as JSON that is kept up to date during the run
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub manifest: Option<PathBuf>,

    /// Frames: 7, 1-10, 1..10, 1-10x2, 1-10:2, 10-1:-1, 1,5,8-12, -3--2 or all [default: all]
    #[arg(short, long, value_name = "SPEC", allow_hyphen_values = true, help_heading = "Frames")]
    pub frames: Option<String>,
    /// All frames of the animation
    #[arg(short = 'a', long, conflicts_with = "frames", help_heading = "Frames")]
    pub all: bool,
    /// First frame [default: 0]
    #[arg(
        short,
        long,
        value_name = "FRAME",
        allow_negative_numbers = true,
        value_parser = options::frame,
        conflicts_with = "frames",
        help_heading = "Frames"
    )]
    pub start: Option<i32>,
    /// Last frame [default: the animation's]
    #[arg(
        short,
        long,
        value_name = "FRAME",
        allow_negative_numbers = true,
        value_parser = options::frame,
        conflicts_with = "frames",
        help_heading = "Frames"
    )]
    pub end: Option<i32>,
    /// Every so many frames
    #[arg(short = 'j', long, value_name = "FRAMES", conflicts_with = "frames", value_parser = |text: &str| options::whole::<i32>(text, 1, i32::MAX.into()), help_heading = "Frames")]
    pub step: Option<i32>,
    /// Frames a second; fractions such as 24000/1001 are exact
    #[arg(long, value_name = "RATE", default_value = "24", help_heading = "Frames")]
    pub fps: String,
    /// Go on with the other frames when one fails
    #[arg(long, help_heading = "Frames")]
    pub keep_going: bool,

    /// Width and height in pixels, or 720p, 1080p or 4k [default: 1280x720]
    #[arg(short, long, value_name = "WxH", value_parser = options::resolution, conflicts_with_all = ["width", "height"], help_heading = "Picture")]
    pub resolution: Option<(u32, u32)>,
    /// Width in pixels; the height follows from the camera unless given
    #[arg(short = 'W', long, value_name = "PIXELS", value_parser = options::count, help_heading = "Picture")]
    pub width: Option<u32>,
    /// Height in pixels; the width follows from the camera unless given
    #[arg(short = 'H', long, value_name = "PIXELS", value_parser = options::count, help_heading = "Picture")]
    pub height: Option<u32>,
    /// Scales the resolution: 50%, 0.5 or 200%; a number without % is a factor up to 1
    #[arg(long, value_name = "PERCENT|FACTOR", allow_negative_numbers = true, value_parser = options::scale, help_heading = "Picture")]
    pub scale: Option<f64>,
    /// Renders these pixels only, from (X0, Y0) up to but not including (X1, Y1), origin top left
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = options::crop, help_heading = "Picture")]
    pub crop: Option<PixelWindow>,
    /// Samples a pixel
    #[arg(long, allow_negative_numbers = true, visible_aliases = ["aa", "spp"], value_name = "N", default_value_t = 4, value_parser = |text: &str| options::whole::<u32>(text, 1, 65536), help_heading = "Picture")]
    pub samples: u32,
    /// Samples that pixels on edges take in all; the others take --samples
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = |text: &str| options::whole::<u32>(text, 1, 65536), help_heading = "Picture")]
    pub max_samples: Option<u32>,
    /// What is an edge: differences of display values, 0 to 1, above this
    #[arg(long, allow_negative_numbers = true, value_name = "X", default_value = "0.05", value_parser = options::share, requires = "max_samples", help_heading = "Picture")]
    pub aa_threshold: f32,
    /// How samples count for a pixel by where they lie
    #[arg(long, value_name = "NAME", default_value = "box", help_heading = "Picture")]
    pub filter: FilterArg,
    /// How long the shutter is open around a frame's time, in frames, or degrees of its turn such as 180deg: motion blur
    #[arg(long, allow_negative_numbers = true, value_name = "FRAMES|DEG", value_parser = options::shutter, help_heading = "Picture")]
    pub shutter: Option<f64>,
    /// Times at which the open shutter looks; the scene is built anew at each, and samples are dealt out to them
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 8, value_parser = |text: &str| options::whole::<u32>(text, 1, 4096), requires = "shutter", help_heading = "Picture")]
    pub time_samples: u32,
    /// Size of the lens: its radius in metres, or an f-number such as f/2.8 for a picture 24 mm high; depth of field, whose noise falls with --samples
    #[arg(long, allow_negative_numbers = true, value_name = "METRES|f/N", value_parser = options::aperture, help_heading = "Picture")]
    pub aperture: Option<Aperture>,
    /// What is sharp: a distance along the camera's axis in metres, a node's name or #I, or middle, what the picture's middle shows
    #[arg(
        long,
        value_name = "METRES|NODE|#I|middle",
        default_value = "middle",
        allow_negative_numbers = true,
        requires = "aperture",
        help_heading = "Picture"
    )]
    pub focus: String,
    /// Deepest reflection or refraction
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 8, value_parser = |text: &str| options::whole::<u32>(text, 0, 1024), help_heading = "Picture")]
    pub depth: u32,
    /// How light is followed
    #[arg(long, value_name = "NAME", default_value = "whitted", help_heading = "Picture")]
    pub integrator: Integrator,
    /// Rays that follow a rough mirror or frosted glass where it is seen first, one from there on; 0 looks the environment up
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 0, value_parser = |text: &str| options::whole::<u32>(text, 0, 4096), help_heading = "Picture")]
    pub glossy: u32,
    /// Shadows under glass
    #[arg(long, value_name = "KIND", default_value = "straight", help_heading = "Picture")]
    pub glass_shadows: GlassShadowsArg,
    /// Brightness of previews and PNG files in stops, or auto: one value for the whole animation
    #[arg(
        long,
        value_name = "EV",
        default_value = "auto",
        allow_negative_numbers = true,
        help_heading = "Picture"
    )]
    pub exposure: String,
    /// Tone curve of previews and PNG files [default: standard]
    #[arg(long, value_name = "NAME", help_heading = "Picture")]
    pub tone: Option<ToneArg>,

    /// Camera: a name, '#0' (in quotes) for the first, or auto to frame the whole scene [default: the first, else auto]
    #[arg(short, long, value_name = "NAME|#I|auto", help_heading = "Scene")]
    pub camera: Option<String>,
    /// Clip: a name, '#0' (in quotes) for the first, all or none
    #[arg(long, value_name = "NAME|#I|all|none", default_value = "all", help_heading = "Scene")]
    pub animation: String,
    /// Scene of the file: a name or '#0' (in quotes) for the first [default: the file's]
    #[arg(long = "scene", value_name = "NAME|#I", help_heading = "Scene")]
    pub scene_choice: Option<String>,
    /// Set of materials of the file: a name or '#0' (in quotes) for the first [default: none]
    #[arg(long, value_name = "NAME|#I", help_heading = "Scene")]
    pub variant: Option<String>,
    /// Multiplies all lights of the file
    #[arg(long, value_name = "X", default_value = "1", allow_negative_numbers = true, value_parser = options::factor, help_heading = "Scene")]
    pub light_scale: f32,
    /// Radius of points and spots in metres: soft shadows, whose noise falls with --samples
    #[arg(long, allow_negative_numbers = true, value_name = "METRES", default_value = "0", value_parser = options::factor, help_heading = "Scene")]
    pub light_radius: f32,
    /// Angle that directional lights take up in the sky, in degrees: soft shadows, whose noise falls with --samples; the
    /// sun's is 0.53
    #[arg(long, allow_negative_numbers = true, value_name = "DEG", default_value = "0", value_parser = options::sun_angle, help_heading = "Scene")]
    pub sun_angle: f32,
    /// Light from all around: an equirectangular .hdr or .exr turned by @degrees, a colour R,G,B, studio or none
    /// [default: studio if the scene has no light, else none]
    #[arg(
        long,
        value_name = "FILE[@DEG]|R,G,B|studio|none",
        allow_hyphen_values = true,
        help_heading = "Scene"
    )]
    pub env: Option<OsString>,
    /// Multiplies the light from all around
    #[arg(long, value_name = "X", default_value = "1", allow_negative_numbers = true, value_parser = options::factor, help_heading = "Scene")]
    pub env_intensity: f32,
    /// What the camera sees behind the scene, apart from what lights it: env for the light itself, none for transparency, or
    /// what --env takes. R,G,B is linear light, which previews expose and tone-map like the rest
    #[arg(
        long,
        value_name = "env|none|R,G,B|FILE[@DEG]",
        allow_hyphen_values = true,
        default_value = "env",
        help_heading = "Scene"
    )]
    pub background: OsString,
    /// A node or material that is invisible but for the shadows on it: a name, or '#0' (in quotes) for the first node; may be
    /// given more than once
    #[arg(long, value_name = "NAME|#I", help_heading = "Scene")]
    pub shadow_catcher: Vec<String>,
    /// Warnings about what is not supported become errors
    #[arg(long, help_heading = "Scene")]
    pub strict: bool,

    /// Threads [default: all cores]
    #[arg(short, long, value_name = "N", value_parser = |text: &str| options::whole::<u16>(text, 1, 65535), help_heading = "Work")]
    pub threads: Option<u16>,
    /// Most memory to use, such as 8G [default: 80 % of what there is]
    #[arg(long, value_name = "SIZE", value_parser = options::memory_size, help_heading = "Work")]
    pub max_memory: Option<u64>,
    /// How the hierarchy is built; never changes the picture
    #[arg(long, value_name = "KIND", default_value = "auto", help_heading = "Work")]
    pub bvh: BvhArg,
    /// Splits triangles whose boxes exceed an area in square metres; never changes the picture
    #[arg(long, value_name = "auto|off|AREA", default_value = "auto", allow_negative_numbers = true, value_parser = options::split, help_heading = "Work")]
    pub split: Split,
    /// Whether the last frame's hierarchy is fitted to triangles that moved: where it pays, never, or while its cost is at
    /// most FACTOR times the least since it was built; never changes the picture
    #[arg(long, allow_negative_numbers = true, value_name = "auto|off|FACTOR", default_value = "auto", value_parser = options::refit, help_heading = "Work")]
    pub refit: Refit,
    /// Instructions to use; never changes the picture
    #[arg(long, value_name = "LEVEL", default_value = "best", help_heading = "Work")]
    pub simd: SimdArg,
    /// Print the settings as a shot file and what would be done, frame by frame, and stop
    #[arg(short = 'n', long, help_heading = "Work")]
    pub dry_run: bool,
    /// How progress is told
    #[arg(long, value_name = "STYLE", default_value = "auto", help_heading = "Work")]
    pub progress: ProgressArg,
    /// Print warnings and errors only
    #[arg(short, long, conflicts_with = "verbose", help_heading = "Work")]
    pub quiet: bool,
    /// Print the phases of each frame
    #[arg(short, long, help_heading = "Work")]
    pub verbose: bool,
}

macro_rules! choices {
    ($($(#[$doc:meta])* $name:ident { $($(#[$of_variant:meta])* $variant:ident),+ $(,)? })+) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
        pub enum $name {
            $($(#[$of_variant])* $variant,)+
        }
    )+};
}

choices! {
    /// Formats of previews.
    PreviewFormat {
        /// sRGB with alpha, eight bits
        Png,
    }
    /// Integrators.
    Integrator {
        /// Whitted's tree of reflections, refractions and shadows
        Whitted,
    }
    /// Shadows under glass.
    GlassShadowsArg {
        /// Light passes straight through, coloured by the glass
        Straight,
        /// Glass casts full shadows
        Opaque,
    }
    /// Pixel filters.
    FilterArg {
        /// The pixel's square
        Box,
        /// Four pixels wide and a little sharper; wants 16 samples or more
        Mitchell,
        /// Three pixels wide and soft, as in Blender
        BlackmanHarris,
    }
    /// Tone curves.
    ToneArg {
        /// Natural contrast; middle grey stays where it is
        Standard,
        /// Low contrast, with room for bright and coloured light, as in Blender
        Agx,
        /// High contrast, as films made with ACES 1.0
        Aces,
        /// Base colours come out as they are: Khronos PBR Neutral
        Neutral,
    }
    /// Builders.
    BvhArg {
        /// What is fastest for the triangles and rays at hand
        Auto,
        /// Karras' radix tree, by a faster pass that gives the same tree
        Lbvh,
        /// A better tree for some more time, by merging neighbours
        Ploc,
        /// Karras' radix tree, node by node as in the paper
        Karras,
        /// None: every ray tests every triangle
        #[value(hide = true)]
        Brute,
    }
    /// Instruction sets.
    SimdArg {
        /// The best of this machine
        Best,
        /// None
        Scalar,
        /// x86-64-v2, of 2008
        #[value(name = "sse4.2")]
        Sse42,
        /// x86-64-v3, of 2013
        Avx2,
        /// As of Ice Lake and Zen 4
        Avx512,
        /// 64-bit ARM
        Neon,
    }
    /// Styles of progress.
    ProgressArg {
        /// Bars on a terminal, one line a frame when piped
        Auto,
        /// Bars
        Bar,
        /// One line a frame
        Plain,
        /// JSON lines on the standard output
        Json,
        /// Lines for Open Job Description, as AWS Deadline Cloud reads them, on the standard output
        #[value(name = "openjd")]
        OpenJd,
        /// Nothing
        None,
    }
}

impl From<ProgressArg> for ProgressStyle {
    fn from(arg: ProgressArg) -> Self {
        match arg {
            ProgressArg::Auto => Self::Auto,
            ProgressArg::Bar => Self::Bar,
            ProgressArg::Plain => Self::Plain,
            ProgressArg::Json => Self::Json,
            ProgressArg::OpenJd => Self::OpenJd,
            ProgressArg::None => Self::None,
        }
    }
}

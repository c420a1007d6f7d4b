//! The table of all settings. A new setting is one entry here and its use.

use crate::bvh::{BuilderKind, Refit, Split};
use crate::color::ToneCurve;
use crate::framing::NamedView;
use crate::image::PlateFit;
use crate::render::{EnvSamples, GlassShadows, Integrator, PixelFilter};
use crate::scene::ClipSelection;

use super::choices::{DenoiserKind, FocusRequest, GroundKind, PreviewFormat, ProgressStyle, Switch};
use super::definition::{Access, Assigned, DefinitionOf, Group, set};
use super::environment_source::BackgroundSource;
use super::exposure::Exposure;
use super::file_types::{
    BackgroundType, CameraPathType, EnvironmentType, FilePath, Folders, NamedFile, Pattern,
};
use super::frame_rate::FrameRate;
use super::setting_type::SettingType;
use super::table::{default_texts, settings, value_of, value_type};
use super::types::{
    Aovs, ApertureType, CameraType, Clips, Crop, Degrees, Direction, Elevation, EnvSamplesType, ExposureType,
    ExrEncoding, Factor, FieldOfView, Flag, FocalLength, FocusType, Frames, GroundType, LookAtType,
    MemorySize, NameOrIndexType, Names, OneOf, OrbitType, Point, PositiveNumber, Rate, ReferenceBudget,
    RefitType, Resolution, SampleRangeType, Scale, Share, ShutterFrames, Simd, SplitType, SunAngle, TimeSpan,
    VariantType, Whole,
};

/// One setting.
pub type Definition = DefinitionOf<Settings>;

impl Definition {
    /// The definition of the setting `name`.
    pub fn of(name: &str) -> Option<&'static Self> {
        DEFINITIONS
            .iter()
            .find(|definition| definition.name == name || definition.hidden_aliases.contains(&name))
    }
}

/// Largest side of an image and largest frame number: files store both in signed 32 bits.
const MAX: i64 = i32::MAX as i64;

settings! {
    /// The scene: .glb, .gltf, or a shot file .toml that names it and holds settings
    /// . Several are rendered one after another
    scene: FilePath, Input { value_name: "SCENE", is_common: true }

    /// Output name: shot.####.exr, shot.png, shot.mp4
    /// . ####, %04d or {frame:04} is the frame number, .exr or .png the format. A still has no number. .apng, .webp, .gif,
    /// and with ffmpeg .mp4, .mov, .webm and .mkv are one movie of all frames. {scene}, {shot}, {clip}, {camera} and {variant}
    /// are their names, here and in names of movies, contact sheets, statistics and manifests
    output: Pattern, Output {
        value_name: "PATTERN", short: Some('o'), hidden_aliases: &["outfile", "out"], is_common: true, is_for_runs: true,
        default_help: "<scene>.####.exr",
    }
    /// Tone-mapped previews beside the EXR files
    preview: OneOf<PreviewFormat>, Output { value_name: "FORMAT", is_common: true, is_for_runs: true }
    /// AOVs (extra channels) of EXR files, separated by commas
    /// : depth, position, normal, geometric_normal, albedo, emission, direct, environment, reflection, refraction,
    /// pass_through, uv, object_id, material_id, node_id, motion, crypto_object, crypto_material; light, data, crypto
    /// and all are groups. Of the path integrator also variance, sample_count, denoising_albedo, denoising_normal, in
    /// the groups noise and denoising
    aovs: Aovs, Output { value_name: "LIST", hidden_aliases: &["layers"], is_common: true }
    /// Sample type and compression of EXR files
    /// : half or float for light (data is always float), and none, rle, zips, zip, piz, dwaa or dwab, in any order.
    /// dwaa and dwab lose precision
    exr: ExrEncoding, Output { value_name: "TYPE,COMPRESSION", default_help: "half,zip" }
    /// A separate file for each AOV
    /// , such as shot.depth.0001.exr; {layer} in the output name is the name of the AOV
    split_aovs: Flag = false, Output { is_for_runs: true }
    /// Write time, machine and render duration to EXR files
    /// . Without it equal runs make equal files
    stamp: Flag = false, Output { is_for_runs: true }
    /// A movie of all frames
    /// : .apng and .webp (exact), .gif, or .mp4, .mov, .webm, .mkv with ffmpeg
    movie: NamedFile, Output { value_name: "FILE", is_common: true, is_for_runs: true }
    /// A PNG image with small versions of all frames and their numbers
    /// ; of several scenes, clips, cameras or variants with one frame and the names of each
    contact_sheet: NamedFile, Output { value_name: "FILE.png", is_for_runs: true }
    /// Show finished frames on the terminal
    /// : as images (kitty, Ghostty, WezTerm, iTerm2), else as coloured blocks
    show: Flag = false, Output { is_for_runs: true }
    /// Keep finished frames, render the rest
    /// : a frame is kept if its hash matches the scene, the settings and the version
    /// ; replaces other frames of this program, and no other files or links
    resume: Flag = false, Output { excludes: &["overwrite"], is_common: true, is_for_runs: true }
    /// Keep finished passes of the path integrator beside a frame until it is done, and continue from them
    checkpoint: Flag = false, Output { is_for_runs: true }
    /// Write a frame while the next one is rendered; never changes the image
    /// . off: write a frame before the next one begins, so that a killed run loses one frame at most
    write_behind: OneOf<Switch> = Switch::On, Output { value_name: "on|off", is_for_runs: true }
    /// Render every frame and replace existing files
    overwrite: Flag = false, Output { is_common: true, is_for_runs: true }
    /// Statistics of each frame as JSON
    stats: NamedFile, Output { value_name: "FILE", is_for_runs: true }
    /// State of each frame and hashes of its files as JSON, updated during the run
    manifest: NamedFile, Output { value_name: "FILE", is_for_runs: true }

    /// Frames: 7, 1-10, 1-10x2, 1,5,8-12, -3--2 or all
    /// ; also 1..10, 1-10:2 and 10-1:-1
    frames: Frames, Frames { value_name: "SPEC", short: Some('f'), default_help: "all", is_common: true }
    /// All frames of the animation
    all: Flag = false, Frames { short: Some('a'), excludes: &["frames"], is_for_runs: true }
    /// First frame
    start: Whole<i32, { -MAX - 1 }, MAX>, Frames {
        value_name: "FRAME", short: Some('s'), excludes: &["frames"], default_help: "0", is_common: true,
    }
    /// Last frame
    end: Whole<i32, { -MAX - 1 }, MAX>, Frames {
        value_name: "FRAME", short: Some('e'), excludes: &["frames"], default_help: "the last of the animation",
        is_common: true,
    }
    /// Distance between frames
    step: Whole<i32, 1, MAX>, Frames {
        value_name: "FRAMES", short: Some('j'), excludes: &["frames"], default_help: "1", is_common: true,
    }
    /// Frames per second; fractions such as 24000/1001 are exact
    fps: Rate = FrameRate::FILM, Frames { value_name: "RATE", hidden_aliases: &["framerate"], is_common: true }
    /// Render the other frames and scenes when one fails
    keep_going: Flag = false, Frames { is_for_runs: true }

    /// Width and height in pixels, or 720p, 1080p or 4k
    resolution: Resolution, Image {
        value_name: "WxH", short: Some('r'), hidden_aliases: &["size"], excludes: &["width", "height"], default_help: "1280x720", is_common: true,
    }
    /// Width in pixels; the camera decides the height unless given
    width: Whole<u32, 1, MAX>, Image { value_name: "PIXELS", short: Some('W') }
    /// Height in pixels; the camera decides the width unless given
    height: Whole<u32, 1, MAX>, Image { value_name: "PIXELS", short: Some('H') }
    /// Scale of the resolution: 50%, 0.5 or 200%
    /// ; a number without % is a factor up to 1
    scale: Scale, Image { value_name: "PERCENT|FACTOR", is_common: true }
    /// Render only the pixels from (X0, Y0) up to, not including, (X1, Y1); the origin is top left
    crop: Crop, Image { value_name: "X0,Y0,X1,Y1" }
    /// Samples per pixel
    samples: Whole<u32, 1, 65536> = 4, Image { value_name: "N", aliases: &["aa", "spp"], is_common: true }
    /// Samples of pixels on edges; other pixels take `samples`
    max_samples: Whole<u32, 1, 65536>, Image { value_name: "N" }
    /// Edge threshold: difference of display values, 0 to 1
    aa_threshold: Share = 0.05, Image { value_name: "X", requires: Some("max_samples") }
    /// Pixel reconstruction filter
    filter: OneOf<PixelFilter> = PixelFilter::Box, Image { value_name: "NAME" }
    /// Motion blur: open time in frames, or degrees such as 180deg
    /// . The shutter opens before the time of the frame and closes as long after it
    shutter: ShutterFrames, Image { value_name: "FRAMES|DEG" }
    /// Number of times within the open shutter
    /// . The scene is posed anew at each, and samples are distributed among them: all take the same number, at least one
    time_samples: Whole<u32, 1, 4096> = 8, Image { value_name: "N", requires: Some("shutter") }
    /// Depth of field: radius in metres, or an f-number such as f/2.8
    /// for a sensor 24 mm high. Its noise falls with more samples
    aperture: ApertureType, Image { value_name: "METRES|f/N" }
    /// Focus: distance in metres along the camera's axis, the middle of a node by its name or #I, or center
    focus: FocusType = FocusRequest::Center, Image {
        value_name: "METRES|NODE|#I|center", requires: Some("aperture"),
    }
    /// Maximum depth of reflection and refraction
    depth: Whole<u32, 0, 1024> = 8, Image { value_name: "N" }
    /// Light transport algorithm
    integrator: OneOf<Integrator> = Integrator::Whitted, Image { value_name: "NAME" }
    /// Seed of the path integrator's samples
    seed: Whole<u32, 0, 4294967295> = 0, Image { value_name: "N" }
    /// Noise of the path integrator that differs from frame to frame
    /// . Without it the noise stands still
    seed_per_frame: Flag = false, Image {}
    /// Noise of display values, 0 to 1, at which a pixel of the path integrator is done
    /// : the standard error of its mean, such as 0.01. `samples` is then the most that a pixel takes
    noise: Share, Image { value_name: "X", excludes: &["max_samples"] }
    /// Render only these samples of the path integrator, such as 0-63
    /// . Their EXR files hold the sums that `rayframe merge` adds up to what one run gives
    sample_range: SampleRangeType, Image { value_name: "FIRST-LAST" }
    /// Time after which a frame of the path integrator takes no more samples: 30s, 5m or 1h
    /// . Images then depend on the machine's speed
    time_limit: TimeSpan, Image { value_name: "TIME" }
    /// Denoiser of the path integrator: oidn is Intel's Open Image Denoise, where its program oidnDenoise is installed
    /// . EXR files then hold the noisy colours in the layer noisy
    denoise: OneOf<DenoiserKind> = DenoiserKind::None, Image { value_name: "NAME" }
    /// The program oidnDenoise, or the folder that it is in
    oidn: FilePath, Run { value_name: "PATH", requires: Some("denoise") }
    /// Largest radiance that a path brings from beyond its first surface
    /// . Removes fireflies, and with them light: off by default
    clamp_indirect: PositiveNumber, Image { value_name: "RADIANCE" }
    /// Roughens mirrors and glass that paths reach after a rough surface
    /// . Caustics become soft and much less noisy, but biased: off by default
    regularize: Flag = false, Image {}
    /// Rays traced for the first rough reflection or transmission; later ones trace one
    /// . 0: look up the prefiltered environment. Frosted glass still traces one ray a sample (not with --env-samples 0 under an environment), and so do rough metals in scenes without an environment
    glossy: Whole<u32, 0, 4096> = 0, Image { value_name: "N" }
    /// Shadow rays of the whitted integrator towards the environment
    /// , per sample at the first visible surface; surfaces seen in mirrors and through glass send one. A ray that hits something reflects light of the environment from there, once. 0: only the key light of a built-in light, and suns and lamps of environment images, cast shadows. auto: 1, and 4 on shadow catchers and the ground, unless what casts shadows covers a small part of the sky. Inside closed spaces auto fades
    /// these shadows out, by the same amount in every frame of an animation and with fewer rays, and lights them by what comes in and what walls reflect of it
    env_samples: EnvSamplesType = EnvSamples::Auto, Image { value_name: "N|auto" }
    /// Shadows of glass
    glass_shadows: OneOf<GlassShadows> = GlassShadows::Straight, Image { value_name: "KIND" }
    /// Exposure of previews and PNGs in stops, or auto
    /// : one value for the whole animation, from -16 to 2. It is 0 under a built-in light alone; elsewhere, in closed spaces, and with path where emissive surfaces
    /// bring more than two fifths of the light, it brings surfaces near the brightness of their base colours. `noise` and `max_samples` look at the image so, too
    exposure: ExposureType = Exposure::Auto, Image { value_name: "EV", is_common: true }
    /// Tone curve of previews and PNG files
    tone: OneOf<ToneCurve>, Image { value_name: "NAME", default_help: "neutral" }

    /// Camera: a name, '#0', auto or each
    /// . auto frames the whole scene, or stands inside where that shows more. each renders a sequence with every camera. Quote
    /// # in shells
    camera: CameraType, Camera {
        value_name: "CAMERA", short: Some('c'), default_help: "the first, else auto", is_common: true,
    }
    /// View of the framed scene: azimuth and elevation in degrees
    /// around its bounds, and the distance as a multiple of the one that fits (with --ortho, the height). 0,0 is the front, seen from +Z; azimuth 90 is
    /// the side of +X; a positive elevation looks down
    orbit: OrbitType, Camera { value_name: "AZ,EL[,DIST]", excludes: &["view", "camera_position"], is_common: true }
    /// View of the framed scene by name
    view: OneOf<NamedView>, Camera { value_name: "NAME", excludes: &["camera_position"] }
    /// Position of the camera, metres
    /// ; it looks at the middle of the scene unless `look_at` says otherwise
    camera_position: Point, Camera { value_name: "X,Y,Z", hidden_aliases: &["position"], is_common: true }
    /// Centre of the image: a point in metres, or a node's name or '#0'
    /// for the first. An orbit turns about it
    look_at: LookAtType, Camera { value_name: "X,Y,Z|NODE", hidden_aliases: &["target"], is_common: true }
    /// Direction that points up in the image
    /// . 0,0,1 suits scenes whose vertical axis is Z
    up: Direction, Camera { value_name: "X,Y,Z", default_help: "0,1,0" }
    /// Node that is framed instead of the whole scene
    /// : a name, or '#0' for the first
    frame_node: NameOrIndexType, Camera { value_name: "NAME|#I" }
    /// Vertical field of view in degrees
    fov: FieldOfView, Camera { value_name: "DEG", excludes: &["focal_length"], is_common: true }
    /// Focal length in millimetres for a sensor 24 mm high
    focal_length: FocalLength, Camera { value_name: "MM" }
    /// Parallel projection instead of perspective
    ortho: Flag = false, Camera { excludes: &["fov", "focal_length"] }
    /// Rotation of the camera about its axis in degrees
    /// : counter-clockwise as seen from behind, so that the image turns clockwise
    roll: Degrees = 0.0, Camera { value_name: "DEG" }
    /// Path of the camera: keys in a .toml file, or the animated camera of a .glb or .gltf
    /// ; FILE.glb#NAME or FILE.glb#0 names one of several. Time is in seconds from frame 0. All frames are those of the
    /// longer of path and animation
    camera_path: CameraPathType, Camera {
        value_name: "FILE",
        excludes: &["camera", "orbit", "view", "camera_position", "frame_node", "turntable"],
    }
    /// A whole turn of the camera around the scene in N frames
    /// . The loop is seamless: frame N equals frame 0. Clips play on; `animation` none stops them
    turntable: Whole<u32, 1, 1000000>, Camera { value_name: "N", hidden_aliases: &["spin"], is_common: true }
    /// Elevation of the turntable's camera in degrees
    elevation: Elevation = 20.0, Camera { value_name: "DEG", excludes: &["orbit", "view", "camera_position"], requires: Some("turntable") }

    /// Clip: a name, '#0' for the first, all, none or each
    /// . Several, separated by commas, play together. each renders a sequence of every clip, all with one automatic exposure and camera
    animation: Clips = ClipSelection::All, Scene { value_name: "CLIP", is_common: true }
    /// Scene of the file: a name or '#0' for the first
    scene_choice: NameOrIndexType, Scene {
        value_name: "NAME|#I", option: Some("scene"), default_help: "the default of the file",
    }
    /// Material variant: a name, '#0' for the first, none or each
    /// . each renders a sequence of every variant, all with one automatic exposure and camera
    variant: VariantType, Scene { value_name: "VARIANT", default_help: "none" }
    /// Factor of the point, spot and directional lights of the file
    /// . Its image-based light is an environment, which `env_intensity` scales
    light_scale: Factor = 1.0, Scene { value_name: "X" }
    /// Radius of point and spot lights in metres, for soft shadows
    /// . Their noise falls with more samples
    light_radius: Factor = 0.0, Scene { value_name: "METRES" }
    /// Angular diameter of directional lights in degrees, for soft shadows
    /// . The sun has 0.53. Noise falls with more samples
    sun_angle: SunAngle = 0.0, Scene { value_name: "DEG" }
    /// Light: .hdr, .exr, R,G,B, studio or none
    /// . softbox, outdoor and dark are built in like studio. FILE@DEG rotates the image by degrees
    env: EnvironmentType, Scene {
        value_name: "SOURCE", hidden_aliases: &["hdri"], default_help: "studio if unlit",
        is_common: true,
    }
    /// Factor of the environment light
    env_intensity: Factor = 1.0, Scene { value_name: "X" }
    /// Background behind the scene: env (the environment light), none, white, black, '#rrggbb', an image, or as for `env`
    /// . none is transparent. R,G,B is linear light, exposed and tone-mapped like the rest. white, black and '#rrggbb'
    /// are exact sRGB values of PNG files, previews and movies, whatever the exposure and tone curve; EXR files stay
    /// transparent there. An image is a PNG, JPEG or WebP file, a sequence such as plate.%04d.exr, or plate:FILE for a
    /// single .exr or .hdr file. It covers EXR files, too; PNG, JPEG and WebP files keep their exact values in PNG files,
    /// previews and movies. Quote # in shells
    background: BackgroundType = BackgroundSource::Light, Scene { value_name: "SOURCE", hidden_aliases: &["bg"] }
    /// How an image as background fills an image of another aspect ratio
    background_fit: OneOf<PlateFit> = PlateFit::Fill, Scene { value_name: "FIT" }
    /// Node or material that is invisible except for shadows on it
    /// : a name, or '#0' for the first node; may be repeated
    shadow_catcher: Names = Vec::new(), Scene { value_name: "NAME|#I" }
    /// Plane below the scene that is invisible except for shadows on it, and mirror images if asked
    /// . It lies under the lowest point of the framed scene over the whole animation, perpendicular to `up`. Its value
    /// follows =
    ground: GroundType = GroundKind::None, Scene { value_name: "KIND", value_alone: Some("true") }
    /// Turn warnings about unsupported features into errors
    strict: Flag = false, Scene {}

    /// Number of threads
    threads: Whole<u16, 1, 65535>, Run {
        value_name: "N", short: Some('t'), default_help: "all cores", is_common: true, is_for_runs: true,
    }
    /// Memory limit, such as 8G
    max_memory: MemorySize, Run { value_name: "SIZE", default_help: "80 % of the available memory" }
    /// Permit files of the scene in this folder, which is outside its own
    /// , such as ../textures; may be repeated. Where it is typed, it permits outputs of shot files elsewhere, too
    allow_dir: Folders = Vec::new(), Run { value_name: "DIR" }
    /// Folder that keeps decoded images between runs; never changes the image
    /// . Any number of processes share it. What cannot be written there is a warning
    asset_cache: FilePath, Run { value_name: "DIR", is_for_runs: true }
    /// Size that the folder of `asset_cache` may reach; what was used longest ago is removed
    asset_cache_size: MemorySize = 10 << 30, Run {
        value_name: "SIZE", default_help: "10G", requires: Some("asset_cache"), is_for_runs: true,
    }
    /// BVH builder; never changes the image
    bvh: OneOf<BuilderKind> = BuilderKind::Auto, Run { value_name: "KIND" }
    /// Split triangles whose boxes waste much area, where the rays of the frame save the time; never changes the image
    /// . AREA splits triangles whose boxes exceed this, in square metres
    split: SplitType = Split::Auto, Run { value_name: "auto|off|AREA" }
    /// Boxes that `split` makes for each triangle at most, on average; never changes the image
    split_budget: ReferenceBudget = 4.0, Run { value_name: "X" }
    /// Refit the BVH of the last frame to moved triangles; never changes the image
    /// . auto refits where that is faster, off never, FACTOR while the cost is at most FACTOR times the lowest since
    /// the last build
    refit: RefitType = Refit::Auto, Run { value_name: "auto|off|FACTOR" }
    /// SIMD instruction set; never changes the image
    simd: Simd = None, Run { value_name: "LEVEL" }
    /// Progress output style
    progress: OneOf<ProgressStyle> = ProgressStyle::Auto, Run { value_name: "STYLE", is_for_runs: true }
    /// Print warnings and errors only
    quiet: Flag = false, Run { short: Some('q'), excludes: &["verbose"], is_common: true, is_for_runs: true }
    /// Print the phases of each frame, and the hits of the asset cache
    verbose: Flag = false, Run { short: Some('v'), is_for_runs: true }
}

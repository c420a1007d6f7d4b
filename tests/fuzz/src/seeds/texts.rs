//! Files that people write, and reports.

use rayframe::settings::DEFINITIONS;

use super::{Seed, seed};

/// Shot files with settings of every kind.
pub(crate) fn shots() -> Vec<Seed> {
    let texts = [
        "scene = \"scene.gltf\"\nresolution = [64, 48]\nsamples = 2\nframes = \"1-10x2\"\nfps = \"24000/1001\"\n",
        "scene = \"scene.gltf\"\noutput = \"out/{clip}.####.exr\"\naovs = [\"depth\", \"crypto\"]\nexr = \"float,piz\"\nshutter = \"180deg\"\n",
        "scene = \"scene.gltf\"\ncamera = \"auto\"\norbit = [30, 20, 1.5]\nenv = \"studio\"\nbackground = \"#102030\"\nground = \"reflection\"\n",
        "scene = \"scene.gltf\"\nintegrator = \"path\"\nnoise = 0.01\nclamp_indirect = 3\nsplit = 0.01\nmax_memory = \"64M\"\n",
        "scene = \"scene.gltf\"\nturntable = 24\nelevation = 10\nmovie = \"turn.webp\"\ncontact_sheet = \"sheet.png\"\nvariant = \"#0\"\n",
        "scene = \"scene.gltf\"\nshadow_catcher = [\"floor\", \"#0\"]\ncamera_position = [1, 2, 3]\nlook_at = \"ball\"\nfov = 40\n",
        "scene = \"other.glb\"\nstrict = true\ncrop = [0, 0, 8, 8]\naperture = \"f/2.8\"\nfocus = \"center\"\n",
    ];
    (1..).zip(texts).map(|(number, text)| seed(format!("shot_{number}"), text)).collect()
}

/// Suite files.
pub(crate) fn suites() -> Vec<Seed> {
    let own = include_str!("../../../../scenes/suite.toml");
    let limits = "scenes = \"shots\"\nexclude = [\"shots/old\"]\nreferences = \"images\"\nreport = \"report\"\ncache = \"cache\"\n\
        [test]\npreset = \"visual\"\nmean_flip = 0.1\n[shot]\nsamples = 2\n";
    vec![seed("own", own), seed("limits", limits)]
}

/// Every setting with its default or a number, a few a file.
pub(crate) fn definitions() -> Vec<Seed> {
    let lines: Vec<String> = DEFINITIONS
        .iter()
        .map(|definition| {
            format!("{}={}\n", definition.name, definition.default_text().unwrap_or_else(|| "1".to_owned()))
        })
        .collect();
    (1..)
        .zip(lines.chunks(6))
        .map(|(number, lines)| seed(format!("definitions_{number}"), lines.concat()))
        .collect()
}

/// Output patterns and frame ranges.
pub(crate) fn patterns() -> Vec<Seed> {
    let texts = [
        "out/shot.####.exr\n%04d.png\n{frame:06}.exr\n{scene}_{clip}.{camera}.exr",
        "a%%b%#c%{d.####.exr\n{layer}/x.%d.exr\nmovie.mp4\n-####.exr",
        "1-10x2\n1,5,8-12\n-3--2\n10-1:-1",
        "all\n1..10\n1-10 every 3\n-5",
    ];
    (1..).zip(texts).map(|(number, text)| seed(format!("patterns_{number}"), text)).collect()
}

/// Approvals of a changed image and of a removal.
pub(crate) fn approvals() -> Vec<Seed> {
    let text = r#"{"schema": 1, "approved": [{"name": "a/b", "hash": "00ff"}, {"name": "c.0001"}]}"#;
    vec![seed("approvals", text)]
}

/// The list of images of a report.
pub(crate) fn rendered() -> Vec<Seed> {
    let hash = "0123456789abcdef".repeat(4);
    let text = format!(
        r#"{{"schema": 1, "images": [{{"name": "a/b", "verdict": "changed", "hash": "{hash}", "reference": "{hash}"}}, {{"name": "c", "verdict": "failed", "hash": null, "reference": null}}]}}"#
    );
    vec![seed("images", text)]
}

/// The result of one shard without images, and one with an image.
pub(crate) fn shards() -> Vec<Seed> {
    let empty = r#"{"shard": null, "seconds": 1.5, "shots": [], "dangling": ["old"], "not_tested": []}"#;
    let one = r#"{"shard": "1/1", "seconds": 1.5, "dangling": [], "not_tested": [], "shots": [{"name": "a", "seconds": 1, "cached": false, "warnings": [],
        "pictures": [{"name": "a", "frame": 0, "status": "passed", "verdict": "identical", "messages": [], "hash": null,
        "reference": null, "cause": {"materials": ["red"]}}]}]}"#;
    vec![seed("empty", empty), seed("one", one)]
}

/// A manifest with a written frame, one with a path that is not Unicode, and one that was not rendered.
pub(crate) fn manifests() -> Vec<Seed> {
    let hash = "0123456789abcdef".repeat(4);
    let text = format!(
        r#"{{"schema": 1, "software": "rayframe", "frames": [{{"frame": 1, "status": "written", "render_hash": "{hash}", "files": [{{"path": "out/a.0001.exr", "bytes": 1234, "sha256": "{hash}"}}]}},
        {{"frame": 2, "status": "kept", "files": [{{"path": "out/?", "path_percent": "out%2F%FF", "sha256": null}}]}}, {{"frame": -3, "status": "not_rendered", "files": []}}]}}"#
    );
    vec![seed("frames", text)]
}

/// Keys of a camera path.
pub(crate) fn camera_paths() -> Vec<Seed> {
    let text = "interpolation = \"smooth\"\nloop = true\n\n[[key]]\ntime = 0\nposition = [4, 2, 6]\nlook_at = [0, 1, 0]\n\n\
        [[key]]\ntime = 2.5\nposition = [-4, 2, 6]\nlook_at = [0, 1, 0]\nfov = 30\nroll = -20\n\n\
        [[key]]\ntime = 5\nposition = [4, 2, 6]\nlook_at = [0, 1, 0]\n";
    vec![
        seed("keys", text),
        seed("linear", text.replace("smooth", "linear").replace("loop = true", "loop = false")),
    ]
}

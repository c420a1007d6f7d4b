//! The report for people.

use super::super::summary::{counted, quoted, span_text};
use super::report::{NodeReport, Report, WarningReport};
use rayframe::count_text::grouped;

/// Items of a section that are listed.
const MOST_ITEMS: usize = 20;

/// Sections with one line an item; empty sections are left out.
pub(super) fn text(report: &Report) -> String {
    let mut lines = vec![report.file.clone()];
    let sections = [
        ("scenes", scenes(report)),
        ("nodes", nodes(report)),
        ("meshes", meshes(report)),
        ("materials", materials(report)),
        ("variants", variants(report)),
        ("textures", textures(report)),
        ("clips", clips(report)),
        ("cameras", cameras(report)),
        ("lights", lights(report)),
        ("image-based lights", image_lights(report)),
        ("extensions", extensions(report)),
        ("will be rendered", vec![rendered(report)]),
        ("left out", warnings(&report.left_out)),
        ("not supported", warnings(&report.not_supported)),
    ];
    for (title, items) in sections {
        if !items.is_empty() {
            lines.push(format!("{title}:"));
            lines.extend(items.iter().map(|item| format!("  {}", crate::progress::one_line(item))));
        }
    }
    lines.join("\n")
}

/// The line of each item by its index; of many the first, and how many more there are.
fn listed<T>(items: &[T], line: impl Fn(usize, &T) -> String) -> Vec<String> {
    let mut lines: Vec<_> =
        items.iter().take(MOST_ITEMS).enumerate().map(|(index, item)| line(index, item)).collect();
    if items.len() > MOST_ITEMS {
        lines.push(format!("{} more, which --json lists", items.len() - MOST_ITEMS));
    }
    lines
}

/// `#2 "name" facts` for the items.
fn numbered<T>(items: &[T], facts: impl Fn(&T) -> (Option<&str>, String)) -> Vec<String> {
    listed(items, |index, item| match facts(item) {
        (None, facts) => format!("#{index} {facts}"),
        (name, facts) => format!("#{index} {} {facts}", quoted(name, index)),
    })
}

fn scenes(report: &Report) -> Vec<String> {
    numbered(&report.scenes, |scene| {
        let default = if scene.is_default { ", the default" } else { "" };
        (scene.name.as_deref(), format!("{}{default}", counted(scene.triangles, "triangle")))
    })
}

/// How many there are, and those that options take by name.
fn nodes(report: &Report) -> Vec<String> {
    let counts =
        format!("{}, {}", counted(report.nodes as u64, "node"), counted(report.skins as u64, "skin"));
    let line = |_, node: &NodeReport| match node.name.as_deref() {
        Some(name) => format!("#{} {} {}", node.index, quoted(Some(name), node.index), node.holds.join(", ")),
        None => format!("#{} {}", node.index, node.holds.join(", ")),
    };
    [vec![counts], listed(&report.holding_nodes, line)].concat()
}

fn meshes(report: &Report) -> Vec<String> {
    numbered(&report.meshes, |mesh| {
        let morph = match mesh.morph_targets {
            0 => String::new(),
            count => format!(", {}", counted(count as u64, "morph target")),
        };
        let skin = if mesh.is_skinned { ", skinned" } else { "" };
        let facts = format!(
            "{}, {} {} in {}{morph}{skin}",
            counted(mesh.triangles as u64, "triangle"),
            grouped(mesh.vertices as u64),
            if mesh.vertices == 1 { "vertex" } else { "vertices" },
            counted(mesh.primitives as u64, "part"),
        );
        (mesh.name.as_deref(), facts)
    })
}

fn materials(report: &Report) -> Vec<String> {
    numbered(&report.materials, |material| {
        let features =
            if material.features.is_empty() { "plain".to_owned() } else { material.features.join(", ") };
        let default = if material.is_default { "(default) " } else { "" };
        (material.name.as_deref(), format!("{default}{features}"))
    })
}

fn variants(report: &Report) -> Vec<String> {
    listed(&report.variants, |index, name| format!("#{index} {}", quoted(Some(name), index)))
}

fn textures(report: &Report) -> Vec<String> {
    let mut lines = numbered(&report.textures, |texture| {
        let facts = format!(
            "{}x{}, {} bits, {}, {}",
            texture.width, texture.height, texture.bits, texture.sampling, texture.support
        );
        (texture.name.as_deref(), facts)
    });
    if report.unused_textures > 0 {
        lines.push(format!("{} more that nothing looks up", report.unused_textures));
    }
    lines
}

fn clips(report: &Report) -> Vec<String> {
    numbered(&report.clips, |clip| {
        let ignored = match clip.ignored_channels {
            0 => String::new(),
            count => format!(", {count} more left out"),
        };
        let channels = counted(clip.channels as u64, "channel");
        let span = span_text(clip.start_seconds, clip.seconds);
        (clip.name.as_deref(), format!("{span}, {channels}{ignored}, {}", clip.support))
    })
}

fn cameras(report: &Report) -> Vec<String> {
    numbered(&report.cameras, |camera| {
        (camera.name.as_deref(), usage(camera.kind, camera.is_placed, camera.support))
    })
}

fn lights(report: &Report) -> Vec<String> {
    numbered(&report.lights, |light| {
        (light.name.as_deref(), usage(light.kind, light.is_placed, light.support))
    })
}

fn image_lights(report: &Report) -> Vec<String> {
    numbered(&report.image_lights, |light| {
        let unused = if light.is_used { "" } else { ", not used by any scene" };
        let levels = counted(light.levels as u64, "level");
        let facts = format!("cube of {0}x{0} texels, {levels}{unused}, {1}", light.size, light.support);
        (light.name.as_deref(), facts)
    })
}

fn usage(kind: &str, is_used: bool, support: &str) -> String {
    if is_used { format!("{kind}, {support}") } else { format!("{kind}, not used by any node, {support}") }
}

fn extensions(report: &Report) -> Vec<String> {
    listed(&report.extensions, |_, extension| {
        let required = if extension.is_required { "required, " } else { "" };
        format!("{}: {required}{}", extension.name, extension.support)
    })
}

fn rendered(report: &Report) -> String {
    let rendered = &report.rendered;
    let frames = match rendered.last_frame_at_24_fps {
        0 => "frame 0".to_owned(),
        last => format!("frames 0-{last} at 24 fps"),
    };
    let clips = rendered_clips(&rendered.clips);
    let light =
        if rendered.is_lit_by_studio { ", lit by the studio, since the file has no light" } else { "" };
    format!("{clips}, {frames}, {}, {}{light}", rendered.camera, counted(rendered.triangles, "triangle"))
}

/// `clip #0`, `clips #0 #2`; of many the first, and how many more there are.
fn rendered_clips(clips: &[usize]) -> String {
    let listed: Vec<_> = clips.iter().take(MOST_ITEMS).map(|clip| format!("#{clip}")).collect();
    let listed = listed.join(" ");
    match clips.len() {
        0 => "no clip".to_owned(),
        1 => format!("clip {listed}"),
        2..=MOST_ITEMS => format!("clips {listed}"),
        count => format!("clips {listed} ({} more, which --json lists)", count - MOST_ITEMS),
    }
}

fn warnings(warnings: &[WarningReport]) -> Vec<String> {
    listed(warnings, |_, warning| match warning.pointer.as_str() {
        "" => warning.message.clone(),
        pointer => format!("{pointer}: {}", warning.message),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_say_how_many_items_are_left() {
        let lines = |count| numbered(&vec!["a"; count], |name| (Some(*name), "plain".to_owned()));
        assert!(lines(0).is_empty());
        assert_eq!((lines(20).len(), lines(20)[19].as_str()), (20, "#19 \"a\" plain"));
        assert_eq!((lines(37).len(), lines(37)[20].as_str()), (21, "17 more, which --json lists"));
    }

    #[test]
    fn the_line_of_rendered_clips_has_an_end() {
        let text = |count| rendered_clips(&(0..count).collect::<Vec<_>>());
        assert_eq!([text(0), text(1), text(3)], ["no clip", "clip #0", "clips #0 #1 #2"]);
        assert!(text(20).ends_with(" #18 #19"), "{}", text(20));
        assert!(text(300).ends_with(" #18 #19 (280 more, which --json lists)"), "{}", text(300));
    }
}

//! Names of colour channels in EXR files of other programs, brought to the form that comparisons know.

use std::collections::BTreeSet;

use crate::image::{Channel, Samples, is_cryptomatte};

/// Gives colours the names `R`, `G`, `B` and `A` in layers that have `r`, `g` and `b`, or `red`, `green` and `blue`, in any case. Integers in colours
/// become floats: they are light and no ids.
pub(super) fn unify_colors(channels: &mut [Channel]) {
    let names: BTreeSet<String> = channels.iter().map(|channel| channel.name.clone()).collect();
    for channel in channels {
        let (layer, component) = split(&channel.name);
        let Some(color) = color_of(component).filter(|_| !is_cryptomatte(layer.trim_end_matches('.'))) else {
            continue;
        };
        let has = |wanted: &str| {
            names.iter().any(|name| {
                let (other, component) = split(name);
                other == layer && color_of(component) == Some(wanted)
            })
        };
        let renamed = format!("{layer}{color}");
        if !["R", "G", "B"].into_iter().all(has) || (renamed != channel.name && names.contains(&renamed)) {
            continue;
        }
        channel.name = renamed;
        if let Samples::Uint(values) = &channel.samples {
            channel.samples = Samples::Float(values.iter().map(|&value| value as f32).collect());
        }
    }
}

/// The layer of a channel with its dot, and what is left.
fn split(name: &str) -> (&str, &str) {
    name.split_at(name.rfind('.').map_or(0, |dot| dot + 1))
}

/// The name of a colour channel.
fn color_of(component: &str) -> Option<&'static str> {
    match component.to_ascii_lowercase().as_str() {
        "r" | "red" => Some("R"),
        "g" | "green" => Some("G"),
        "b" | "blue" => Some("B"),
        "a" | "alpha" => Some("A"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unified(names: &[&str]) -> Vec<String> {
        let channel = |name: &&str| Channel { name: (*name).to_owned(), samples: Samples::Uint(vec![3]) };
        let mut channels: Vec<_> = names.iter().map(channel).collect();
        unify_colors(&mut channels);
        // Colours are numbers, all else keeps its type.
        for (channel, name) in channels.iter().zip(names) {
            let is_color = matches!(split(&channel.name).1, "R" | "G" | "B" | "A") && !name.contains("id");
            assert_eq!(channel.samples.floats().is_some(), is_color, "{name}");
        }
        channels.into_iter().map(|channel| channel.name).collect()
    }

    #[test]
    fn colors_have_one_name() {
        assert_eq!(unified(&["r", "g", "b", "z"]), ["R", "G", "B", "z"]);
        assert_eq!(unified(&["Red", "Green", "Blue", "Alpha"]), ["R", "G", "B", "A"]);
        assert_eq!(
            unified(&["view.r", "view.g", "view.b", "R", "G", "B"]),
            ["view.R", "view.G", "view.B", "R", "G", "B"]
        );
        // Neither motion nor an incomplete colour
        assert_eq!(unified(&["id.r", "id.g", "depth.b"]), ["id.r", "id.g", "depth.b"]);
    }

    #[test]
    fn cryptomattes_and_names_that_are_taken_stay() {
        let ranks = ["crypto_object00.r", "crypto_object00.g", "crypto_object00.b", "crypto_object00.a"];
        assert_eq!(unified(&ranks), ranks);
        assert_eq!(unified(&["R", "G", "B", "red"]), ["R", "G", "B", "red"]);
    }
}

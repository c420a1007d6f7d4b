//! Names of colour channels in EXR files of other programs, brought to the form that comparisons know.

use std::collections::BTreeMap;

use crate::image::{Channel, Samples, is_cryptomatte};

/// Largest integer up to which floats hold all.
const MOST_EXACT: u32 = 1 << 24;

/// Gives colours the names `R`, `G`, `B` and `A` in layers that have `r`, `g` and `b`, or `red`, `green` and `blue`, in any case. Integers in
/// colours become floats, unless they are so large that they must be ids. A layer with two channels of one colour stays as it is.
pub(super) fn unify_colors(channels: &mut [Channel]) {
    let mut layers = BTreeMap::<String, Vec<(usize, &'static str)>>::new();
    for (index, channel) in channels.iter().enumerate() {
        let (layer, component) = split(&channel.name);
        if let Some(color) = color_of(component).filter(|_| !is_cryptomatte(layer.trim_end_matches('.'))) {
            layers.entry(layer.to_owned()).or_default().push((index, color));
        }
    }
    for (layer, colors) in layers {
        let count = |wanted: &str| colors.iter().filter(|(_, color)| *color == wanted).count();
        if ["R", "G", "B"].map(count) != [1; 3] || count("A") > 1 {
            continue;
        }
        for (index, color) in colors {
            let channel = &mut channels[index];
            channel.name = format!("{layer}{color}");
            if let Samples::Uint(values) = &channel.samples
                && values.iter().all(|value| *value <= MOST_EXACT)
            {
                channel.samples = Samples::Float(values.iter().map(|&value| value as f32).collect());
            }
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

    /// The names of channels after [`unify_colors`], with a `*` after those that are numbers then.
    fn unified(names: &[&str], value: u32) -> Vec<String> {
        let channel =
            |name: &&str| Channel { name: (*name).to_owned(), samples: Samples::Uint(vec![3, value]) };
        let mut channels: Vec<_> = names.iter().map(channel).collect();
        unify_colors(&mut channels);
        let told = |Channel { name, samples }| match samples {
            Samples::Uint(_) => name,
            _ => format!("{name}*"),
        };
        channels.into_iter().map(told).collect()
    }

    #[test]
    fn colors_have_one_name() {
        assert_eq!(unified(&["r", "g", "b", "z"], 7), ["R*", "G*", "B*", "z"]);
        assert_eq!(unified(&["Red", "Green", "Blue", "Alpha"], 7), ["R*", "G*", "B*", "A*"]);
        let of_layer = ["view.r", "view.g", "view.b", "R", "G", "B"];
        assert_eq!(unified(&of_layer, 7), ["view.R*", "view.G*", "view.B*", "R*", "G*", "B*"]);
    }

    #[test]
    fn what_is_no_colour_stays() {
        for names in [
            &["id.r", "id.g", "depth.b"][..],
            &["crypto_object00.r", "crypto_object00.g", "crypto_object00.b", "crypto_object00.a"],
            // Two of one colour
            &["r", "g", "b", "red"],
            &["R", "G", "B", "a", "alpha"],
        ] {
            assert_eq!(unified(names, 7), names);
        }
        // Floats would make equal ids of these.
        assert_eq!(unified(&["id.r", "id.g", "id.b"], (1 << 24) + 1), ["id.R", "id.G", "id.B"]);
    }
}

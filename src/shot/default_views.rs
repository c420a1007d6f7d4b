//! The views in which a scene is seen whole where nothing else is asked for: those of `rayframe test` for a scene without a shot file,
//! and those of `rayframe diff` for two scenes.

use crate::framing::NamedView;
use crate::settings::Named as _;

/// Name of the view of the automatic camera in an interior.
const INSIDE: &str = "inside";

/// Cameras, clips and variants with their names, of one scene or paired of two.
#[derive(Debug)]
pub(crate) struct Elements<E> {
    /// The cameras that stand in the scene.
    pub(crate) cameras: Vec<(String, E)>,
    /// The clips.
    pub(crate) clips: Vec<(String, E)>,
    /// The material variants.
    pub(crate) variants: Vec<(String, E)>,
}

/// A view of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct DefaultView<E> {
    /// The name of the camera, clip or variant that it shows. Not unique.
    pub(crate) name: String,
    /// The camera.
    pub(crate) camera: DefaultCamera<E>,
    /// The clip that plays alone, of which the [first, middle and last](crate::settings::first_middle_last) frame are seen.
    pub(crate) clip: Option<E>,
    /// The material variant.
    pub(crate) variant: Option<E>,
}

/// The camera of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DefaultCamera<E> {
    /// A camera of the file.
    OfFile(E),
    /// The automatic camera, from three quarters or inside.
    Automatic,
    /// The automatic camera from the other side.
    OtherSide,
}

/// Stills without animation by every camera, or else by the automatic one and, unless it is inside, from the other side; then by the
/// first of these every clip, and a still of every variant.
pub(crate) fn default_views<E: Clone>(elements: Elements<E>, is_interior: bool) -> Vec<DefaultView<E>> {
    let Elements { cameras, clips, variants } = elements;
    let still = |name: String, camera| DefaultView { name, camera, clip: None, variant: None };
    let of_file = |(name, camera)| still(name, DefaultCamera::OfFile(camera));
    let mut views: Vec<_> = cameras.into_iter().map(of_file).collect();
    if views.is_empty() {
        let outside = NamedView::ThreeQuarter.choice_name();
        let name = if is_interior { INSIDE } else { outside };
        views.push(still(name.to_owned(), DefaultCamera::Automatic));
        if !is_interior {
            let name = NamedView::ThreeQuarterBack.choice_name();
            views.push(still(name.to_owned(), DefaultCamera::OtherSide));
        }
    }
    let first = views[0].camera.clone();
    for (name, clip) in clips {
        views.push(DefaultView { clip: Some(clip), ..still(name, first.clone()) });
    }
    for (name, variant) in variants {
        views.push(DefaultView { variant: Some(variant), ..still(name, first.clone()) });
    }
    views
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_of_the_file_replace_the_automatic_ones() {
        let elements = |cameras: &[&str]| {
            let named = |names: &[&str]| names.iter().map(|name| ((*name).to_owned(), 7)).collect();
            Elements { cameras: named(cameras), clips: named(&["walk"]), variants: named(&["night"]) }
        };
        let names = |cameras: &[&str], is_interior| {
            let views = default_views(elements(cameras), is_interior);
            views.into_iter().map(|view| view.name).collect::<Vec<_>>()
        };
        assert_eq!(names(&["lens"], false), ["lens", "walk", "night"]);
        assert_eq!(names(&[], false), ["three-quarter", "three-quarter-back", "walk", "night"]);
        assert_eq!(names(&[], true), ["inside", "walk", "night"]);
        let views = default_views(elements(&["near", "far"]), false);
        assert!(views[2..].iter().all(|view| view.camera == DefaultCamera::OfFile(7)));
    }
}

//! Traced shares of the environment's light that were found before.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use crate::render::EnvironmentShares;
use crate::scene::{Environment, Scene, Selection};

/// Selections that are known at most. Those before are forgotten first.
const MOST_KNOWN: usize = 64;

/// Shares that are known already, of scenes, environments and selections. Clones have them in common.
#[derive(Clone, Debug, Default)]
pub struct KnownShares(Arc<Mutex<Vec<Known>>>);

#[derive(Debug)]
struct Known {
    scene: Weak<Scene>,
    /// See [`crate::scene::Environment::content_key`].
    environment: String,
    selection: Selection,
    shares: EnvironmentShares,
}

impl KnownShares {
    /// Those of a selection of a scene in an environment.
    pub(super) fn get(
        &self,
        (scene, environment): (&Arc<Scene>, &Environment),
        selection: &Selection,
    ) -> Option<EnvironmentShares> {
        let (scene, environment) = (Arc::downgrade(scene), environment.content_key());
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |known: &&Known| {
            Weak::ptr_eq(&known.scene, &scene)
                && known.environment == environment
                && known.selection == *selection
        };
        known.iter().find(is_same).map(|known| known.shares.clone())
    }

    /// Adds those of a selection, and forgets scenes that are gone.
    pub(super) fn add(
        &self,
        (scene, environment): (&Arc<Scene>, &Environment),
        selection: &Selection,
        shares: EnvironmentShares,
    ) {
        let known = Known {
            scene: Arc::downgrade(scene),
            environment: environment.content_key(),
            selection: selection.clone(),
            shares,
        };
        let mut list = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        list.retain(|known| known.scene.strong_count() > 0);
        if list.len() == MOST_KNOWN {
            list.remove(0);
        }
        list.push(known);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::scene::{CameraChanges, NodeIndex, SelectedCamera};

    fn seen_by(camera: u32) -> Selection {
        Selection {
            roots: Vec::new(),
            clips: Vec::new(),
            camera: SelectedCamera::Node(NodeIndex(camera)),
            camera_changes: CameraChanges::default(),
            image_light: None,
            variant: None,
        }
    }

    #[test]
    fn the_first_selections_are_forgotten_where_there_are_many() {
        let (known, scene) = (KnownShares::default(), Arc::new(Scene::default()));
        let environment = Environment::Constant(glam::Vec3::ONE);
        let cameras = 0..MOST_KNOWN as u32 + 2;
        for camera in cameras.clone() {
            let occluded = camera as f32;
            let shares = EnvironmentShares { occluded, ..EnvironmentShares::NONE };
            known.clone().add((&scene, &environment), &seen_by(camera), shares);
        }
        let found = |scene, camera| known.get((scene, &environment), &seen_by(camera));
        for camera in cameras {
            let expected = (camera >= 2).then_some(camera as f32);
            assert_eq!(found(&scene, camera).map(|shares| shares.occluded), expected, "{camera}");
        }
        // An equal scene is another one.
        assert_eq!(found(&Arc::new(Scene::default()), 9), None);
    }

    #[test]
    fn scenes_that_are_gone_are_forgotten() {
        let (known, environment) = (KnownShares::default(), Environment::None);
        let add = |scene: &Arc<Scene>| {
            known.add((scene, &environment), &seen_by(0), EnvironmentShares::ALL);
        };
        add(&Arc::new(Scene::default()));
        let scene = Arc::new(Scene::default());
        add(&scene);
        assert_eq!(known.0.lock().unwrap().len(), 1);
        assert_eq!(known.get((&scene, &environment), &seen_by(0)), Some(EnvironmentShares::ALL));
    }
}

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

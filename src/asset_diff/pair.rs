//! Two versions of an asset, rendered alike.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::difference::AssetDifference;
use super::facts::AssetFacts;
use super::group_kind::GroupKind;
use super::same_ids::{FIRST_NEW_ID, RenamedIds, replace_ids};
use super::views::{PairedIndex, Sides, View, views};
use crate::cancel::CancelFlag;
use crate::error::{Result, Warning};
use crate::framing::{NamedView, is_interior};
use crate::gltf::ImageLoading;
use crate::image::{Image, content_text, quoted};
use crate::renderer::RenderedFrame;
use crate::scene::{
    AnimationIndex, CameraRequest, ClipSelection, Environment, NameOrIndex, Scene, VariantRequest,
};
use crate::sequence::{SequenceJob, clip_checksum};
use crate::settings::Settings;
use crate::shot::default_views::DefaultCamera;
use crate::shot::environment::environment_request;
use crate::shot::{ShotSettings, load_scene, resolve_scene};

/// Two versions of an asset: the actual one and its reference.
#[derive(Debug)]
pub struct AssetPair {
    actual: Asset,
    reference: Asset,
    difference: AssetDifference,
    views: Vec<View>,
    cancel: CancelFlag,
}

/// One version.
#[derive(Debug)]
struct Asset {
    scene: Arc<Scene>,
    facts: AssetFacts,
    settings: Settings,
    /// External files of the scene, and its environment.
    files: Vec<PathBuf>,
}

impl Asset {
    fn open(path: &Path, settings: &Settings) -> Result<Self> {
        let settings = Settings { scene: Some(path.to_owned().into()), ..settings.clone() };
        let shot = ShotSettings::merge([settings.clone()], None)?;
        let scene = Arc::new(load_scene(&shot, ImageLoading::Texels)?);
        let environment = environment_request(&shot.values);
        let files = scene.files.iter().cloned().chain(environment.files().map(PathBuf::from)).collect();
        Ok(Self { facts: AssetFacts::new(&scene), scene, settings, files })
    }

    /// The job of a view.
    fn job(&self, index: impl Fn(PairedIndex) -> usize, view: &View) -> Result<SequenceJob> {
        let named = |pair: PairedIndex| NameOrIndex::Index(index(pair));
        let mut settings = self.settings.clone();
        settings.camera = Some(match view.camera {
            DefaultCamera::OfFile(pair) => CameraRequest::Camera(named(pair)).into(),
            DefaultCamera::Automatic | DefaultCamera::OtherSide => CameraRequest::Auto.into(),
        });
        settings.animation =
            Some(view.clip.map_or(ClipSelection::None, |pair| ClipSelection::One(named(pair))).into());
        settings.variant = view.variant.map(|pair| VariantRequest::Variant(named(pair)).into());
        if view.camera == DefaultCamera::OtherSide {
            settings.view = Some(NamedView::ThreeQuarterBack.into());
        }
        let shot = ShotSettings::merge([settings], None)?;
        Ok(resolve_scene(&shot, Arc::clone(&self.scene))?.sequence)
    }
}

impl AssetPair {
    /// Imports two scenes and compares their facts. Of `settings`, those of image size, sampling, shading and environment apply;
    /// cameras, clips, variants and frames are those of the [views](AssetPair::views).
    ///
    /// # Errors
    /// Those of importing a scene, and [`Error::Setting`](crate::Error::Setting) for wrong settings.
    pub fn open(actual: &Path, reference: &Path, settings: &Settings, cancel: &CancelFlag) -> Result<Self> {
        let [actual, reference] = [Asset::open(actual, settings)?, Asset::open(reference, settings)?];
        let difference = AssetDifference::new(&actual.facts, &reference.facts);
        let sides = Sides {
            scenes: [&actual.scene, &reference.scene],
            reference: &reference.facts,
            difference: &difference,
        };
        let views = views(&sides, is_interior(&reference.scene)?);
        Ok(Self { actual, reference, difference, views, cancel: cancel.clone() })
    }

    /// The files that both scenes load, and their environments.
    pub fn files(&self) -> Vec<PathBuf> {
        [&self.actual.files[..], &self.reference.files].concat()
    }

    /// What changed in the file.
    pub fn difference(&self) -> &AssetDifference {
        &self.difference
    }

    /// The facts of the actual asset and of the reference.
    pub fn facts(&self) -> [&AssetFacts; 2] {
        [&self.actual.facts, &self.reference.facts]
    }

    /// Features of the actual asset and of the reference that are not honoured.
    pub fn warnings(&self) -> [&[Warning]; 2] {
        [&self.actual.scene.warnings, &self.reference.scene.warnings]
    }

    /// The views in which [`AssetPair::render`] renders both.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// What changed of the motion of the clip of a view, between the frames that are rendered or in them; `None` where nothing did.
    pub fn motion_change(&self, view: &View) -> Option<String> {
        let pair = view.clip?;
        let motion = |asset: &Asset, index: usize| {
            asset.scene.animations.get(index).map(|clip| clip_checksum(&asset.scene, clip))
        };
        let [ours, theirs] = [motion(&self.actual, pair.actual), motion(&self.reference, pair.reference)];
        let name = self.reference.scene.clip_label(AnimationIndex(pair.reference as u32));
        (ours != theirs).then(|| format!("{} changed", content_text("motion", &quoted(&name), 1)))
    }

    /// Renders both assets in each frame of `view`, and calls `on_frame` with the frame number, the actual and the reference image, and the
    /// names of their materials. Ids of meshes and materials are those of the reference, also of renamed ones.
    ///
    /// # Errors
    /// Those of rendering, and those of `on_frame`.
    pub fn render(
        &self,
        view: &View,
        mut on_frame: impl FnMut(i64, [Image; 2], &MaterialNames<'_>) -> Result<()>,
    ) -> Result<()> {
        let reference = self.reference.job(|pair| pair.reference, view)?;
        let mut actual = self.actual.job(|pair| pair.actual, view)?;
        if !matches!(view.camera, DefaultCamera::OfFile(_)) {
            actual.selection.camera = reference.selection.camera.clone();
        }
        share_light(&mut actual, &reference);
        let [actual, reference] = [Arc::new(actual), Arc::new(reference)];
        for &frame in &view.frames {
            let image = |job| RenderedFrame::render(Arc::clone(job), frame, &self.cancel)?.image();
            let (mut ours, theirs) =
                (image(&actual)?.rounded_to_halves(), image(&reference)?.rounded_to_halves());
            let names = self.replace_ids(&mut ours, &theirs);
            on_frame(frame, [ours, theirs], &names)?;
        }
        Ok(())
    }

    fn replace_ids(&self, actual: &mut Image, reference: &Image) -> MaterialNames<'_> {
        let mut replaced = |group, layer| match self.difference.matchings.get(&group) {
            Some(matching) => replace_ids(actual, reference, layer, matching),
            None => RenamedIds::new(),
        };
        replaced(GroupKind::Meshes, "object_id");
        let renamed = replaced(GroupKind::Materials, "material_id");
        MaterialNames { actual: &self.actual.scene, reference: &self.reference.scene, renamed }
    }
}

/// Names of the materials of two images that [`AssetPair::render`] rendered.
#[derive(Clone, Debug)]
pub struct MaterialNames<'a> {
    actual: &'a Scene,
    reference: &'a Scene,
    renamed: RenamedIds,
}

impl MaterialNames<'_> {
    /// The name of a material in quotes, or its number without one, for an id of the AOV `material_id` of the actual image. A renamed
    /// material has its new name.
    pub fn of_id(&self, id: u32) -> Option<String> {
        let id = self.renamed.get(&id).copied().unwrap_or(id);
        match id.checked_sub(FIRST_NEW_ID) {
            Some(index) => self.actual.material_of_id(index + 1),
            None => self.reference.material_of_id(id),
        }
    }
}

/// Lights the actual asset like the reference where the light depends on whether a file has its own. The light of an asset that has
/// lost its own is not replaced by the studio.
fn share_light(actual: &mut SequenceJob, reference: &SequenceJob) {
    if !reference.is_environment_default {
        return;
    }
    let has_own =
        |job: &SequenceJob| job.selection.image_light.is_some() || job.selection.has_lights(&job.scene);
    match (has_own(actual), has_own(reference)) {
        (_, false) => actual.environment = reference.environment.clone(),
        (false, true) => actual.environment = Environment::None,
        (true, true) => {}
    }
}

//! Resolves the requested view to a camera.

use std::cell::OnceCell;
use std::collections::BTreeSet;
use std::f32::consts::FRAC_PI_4;
use std::rc::Rc;

use glam::{Mat3, Mat4, Vec3};

use super::fit::{Fitted, fit, fit_parallel, fit_parallel_turntable, fit_turntable};
use super::inside::inside_camera;
use super::orbit::Direction;
use super::own_camera::{CameraRule, OwnCamera};
use super::shared::SharedFraming;
use super::subject::Subject;
use crate::frame::{Frame, PosedCamera};
use crate::scene::{
    AnimationIndex, CameraChanges, LensRequest, NodeIndex, Orbit, Projection, Scene, SelectedCamera,
    Selection, Target, Turntable, TurntableRequest, ViewRequest, look_along, rolled,
};

/// Vertical field of view of cameras inside interiors, unless requested: 60 degrees.
const INSIDE_FOV_RADIANS: f32 = std::f32::consts::FRAC_PI_3;
/// Least distance along the viewing axis at which a camera looks at the scene, as a share of the distance.
const LEAST_AHEAD: f32 = 0.1;

/// Replaces the camera of `selection` by what `request` makes of it, for images of `aspect_ratio` (width over height).
///
/// A requested position, orbit, node or turntable stands for itself unless the camera of the file is kept; that one then gives the
/// lens, and a turntable's start. All other requests change the selected camera.
pub fn resolve_camera(
    scene: &Scene,
    selection: Selection,
    request: &ViewRequest,
    aspect_ratio: f32,
) -> ResolvedCamera {
    SharedFraming::of_one(scene).resolve(selection, request, aspect_ratio).0
}

impl SharedFraming<'_> {
    /// [`resolve_camera`], with the surfaces of `selection` at the start of its clips where they had to be posed and are not kept.
    pub(crate) fn resolve(
        &self,
        selection: Selection,
        request: &ViewRequest,
        aspect_ratio: f32,
    ) -> (ResolvedCamera, Option<Frame>) {
        let of_file = match &selection.camera {
            SelectedCamera::Node(_) | SelectedCamera::Path(_) if !request.replaces_camera() => {
                Some(Frame::camera_at(self.scene(), &selection, 0.0))
            }
            _ => None,
        };
        let is_framed = request.orbit.is_some() || request.node.is_some() || request.turntable.is_some();
        let mut posed = None;
        let mut own_camera = || {
            let view = View::new(self, &selection, request, of_file, aspect_ratio);
            let (camera, rule) = view.camera(!request.places_camera());
            posed = view.into_pose();
            OwnCamera { camera, rule }
        };
        let OwnCamera { camera, rule } = match of_file {
            Some(_) if is_framed => own_camera(),
            // Without a camera of the file, that of other clips or variants may be the same.
            None => self.camera(Self::framed(&selection, request, aspect_ratio), own_camera),
            Some(_) => {
                let view = View::new(self, &selection, request, of_file, aspect_ratio);
                let camera_changes = view.changes();
                let is_changed = camera_changes != CameraChanges::default();
                let rule = if is_changed { CameraRule::Changed } else { CameraRule::OfFile };
                let posed = view.into_pose();
                return (
                    ResolvedCamera { selection: Selection { camera_changes, ..selection }, rule },
                    posed,
                );
            }
        };
        let selection = Selection { camera, camera_changes: CameraChanges::default(), ..selection };
        (ResolvedCamera { selection, rule }, posed)
    }
}

/// Indices of the nodes that cameras frame: all with meshes but backdrops and shadow catchers.
pub fn framed_nodes(scene: &Scene, selection: &Selection) -> BTreeSet<u32> {
    Subject::measure(scene, selection, None, &[]).framed_nodes()
}

/// A selection whose camera can be posed at any time.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedCamera {
    /// The selection.
    pub selection: Selection,
    /// What decided the camera.
    pub rule: CameraRule,
}

/// Everything that decides a camera.
struct View<'v, 'a> {
    framing: &'v SharedFraming<'a>,
    selection: &'v Selection,
    request: &'v ViewRequest,
    /// Measured where the camera depends on it: that poses the whole animation.
    subject: OnceCell<Rc<Subject<'a>>>,
    /// The selected camera of the file or of the path, at time 0.
    of_file: Option<PosedCamera>,
    /// Perspective projection that frames the subject.
    lens: Projection,
    /// The projection of the file's camera, for its near and far plane, unless the camera is framed anew.
    planes: Option<Projection>,
    target: Option<Vec3>,
    up: Vec3,
    aspect_ratio: f32,
}

impl<'v, 'a> View<'v, 'a> {
    fn new(
        framing: &'v SharedFraming<'a>,
        selection: &'v Selection,
        request: &'v ViewRequest,
        of_file: Option<PosedCamera>,
        aspect_ratio: f32,
    ) -> Self {
        let target = request.target.map(|target| match target {
            Target::Point(point) => point,
            Target::Node(node) => center_of(framing, selection, node, &request.measured_clips),
        });
        let lens = match (request.lens, of_file.map(|camera| camera.projection)) {
            (Some(LensRequest::FieldOfView(degrees)), _) => perspective(degrees.to_radians()),
            (_, Some(own @ Projection::Perspective { .. })) => own,
            _ => perspective(FRAC_PI_4),
        };
        // Planes of one place cut off what another camera frames.
        let is_framed = request.orbit.is_some() || request.node.is_some();
        let planes = of_file.filter(|_| !is_framed).map(|camera| camera.projection);
        Self {
            framing,
            selection,
            request,
            subject: OnceCell::new(),
            of_file,
            lens: limited(lens, planes),
            planes,
            target,
            up: request.up.and_then(Vec3::try_normalize).unwrap_or(Vec3::Y),
            aspect_ratio,
        }
    }

    fn subject(&self) -> &Subject<'a> {
        let clips = &self.request.measured_clips;
        self.subject.get_or_init(|| self.framing.subject(self.selection, self.request.node, clips))
    }

    /// The measured surfaces of the selection, unless its clips were measured each alone or the subject is kept.
    fn into_pose(self) -> Option<Frame> {
        let is_of_selection = self.request.measured_clips.is_empty();
        let subject = self.subject.into_inner().filter(|_| is_of_selection)?;
        Rc::into_inner(subject).map(|subject| subject.frame)
    }

    /// Changes to the camera of the file.
    fn changes(&self) -> CameraChanges {
        let moved = CameraChanges {
            position: self.request.position,
            target: self.target,
            up: self.request.up,
            roll_radians: self.request.roll_degrees.to_radians(),
            projection: None,
        };
        let projection = self.request.lens.map(|_| self.changed_projection(&moved));
        CameraChanges { projection, ..moved }
    }

    /// The projection of the camera of the file after `moved`, where one is requested.
    fn changed_projection(&self, moved: &CameraChanges) -> Projection {
        if !self.is_orthographic() {
            return self.lens;
        }
        let camera = moved.apply(self.of_file.unwrap_or_default().world_from_camera);
        let center = self.target.unwrap_or_else(|| self.subject().bounds.center());
        let to_center = center - camera.w_axis.truncate();
        let ahead = to_center.dot(-camera.z_axis.truncate());
        let distance = to_center.length();
        // A camera that looks past the scene has no height of its own there.
        self.parallel_at(if ahead > distance * LEAST_AHEAD { ahead } else { distance })
    }

    /// A camera of our own.
    fn camera(&self, is_automatic: bool) -> (SelectedCamera, CameraRule) {
        if let Some(turntable) = &self.request.turntable {
            return (self.turntable(turntable), CameraRule::Turntable);
        }
        let fitted = match self.request.position {
            Some(position) => self.look_from(position),
            None => self.around_target(&self.request.orbit.unwrap_or(Orbit::THREE_QUARTER)),
        };
        let (mut world_from_camera, mut projection) = (fitted.world_from_camera, self.projection(&fitted));
        let mut rule = if is_automatic { CameraRule::Outside } else { CameraRule::Requested };
        if is_automatic && self.target.is_none() && !self.is_orthographic() {
            let lens = if self.request.lens.is_some() { self.lens } else { perspective(INSIDE_FOV_RADIANS) };
            // What both cameras show is compared without the roll.
            let unrolled = rolled(world_from_camera, -self.request.roll_degrees.to_radians());
            if let Some(inside) = inside_camera(self.subject(), &lens, unrolled) {
                world_from_camera = self.rolled(inside);
                rule = CameraRule::Inside;
                projection = lens;
            }
        }
        (SelectedCamera::Fixed { world_from_camera, projection }, rule)
    }

    fn turntable(&self, turntable: &TurntableRequest) -> SelectedCamera {
        let center = self.target.unwrap_or_else(|| self.subject().bounds.center());
        let orbit = self.request.orbit.unwrap_or(Orbit {
            azimuth_degrees: 0.0,
            elevation_degrees: turntable.elevation_degrees.unwrap_or(Orbit::THREE_QUARTER.elevation_degrees),
            distance: 1.0,
        });
        let is_framed = self.request.orbit.is_some() || self.request.node.is_some();
        let fitted = match (self.request.position, self.of_file) {
            (Some(position), _) => self.look_from(position),
            (None, Some(camera)) if !is_framed => {
                let world_from_camera = self.changes().apply(camera.world_from_camera);
                let to_camera = world_from_camera.w_axis.truncate() - center;
                Fitted { world_from_camera, distance: to_camera.length(), half_height: None }
            }
            _ => self.around_turntable(&orbit),
        };
        SelectedCamera::Turntable(Turntable {
            start: fitted.world_from_camera,
            projection: self.projection(&fitted),
            center,
            axis: self.up,
            turn_seconds: turntable.turn_seconds,
        })
    }

    fn look_from(&self, position: Vec3) -> Fitted {
        let backward = position - self.target.unwrap_or_else(|| self.subject().bounds.center());
        let world_from_camera = self.rolled(look_along(position, backward, self.up));
        Fitted { world_from_camera, distance: backward.length(), half_height: None }
    }

    fn from(&self, orbit: &Orbit) -> Direction {
        Direction { orbit: *orbit, up: self.up, roll_radians: self.request.roll_degrees.to_radians() }
    }

    fn around_target(&self, orbit: &Orbit) -> Fitted {
        let axes = self.from(orbit).axes();
        let fitted = if self.is_orthographic() {
            fit_parallel(self.subject(), axes, self.aspect_ratio, orbit.distance)
        } else {
            fit(self.subject(), axes, &self.lens, self.aspect_ratio, orbit.distance)
        };
        self.moved_to_target(fitted, axes)
    }

    fn around_turntable(&self, orbit: &Orbit) -> Fitted {
        let from = self.from(orbit);
        let fitted = if self.is_orthographic() {
            fit_parallel_turntable(self.subject(), &from, self.aspect_ratio)
        } else {
            fit_turntable(self.subject(), &from, &self.lens, self.aspect_ratio)
        };
        self.moved_to_target(fitted, from.axes())
    }

    /// The camera around the target instead of the subject's centre. A parallel one stays beyond the subject.
    fn moved_to_target(&self, fitted: Fitted, axes: Mat3) -> Fitted {
        let Some(target) = self.target else { return fitted };
        let aside = (self.subject().bounds.center() - target).length();
        let distance = fitted.distance + if fitted.half_height.is_some() { aside } else { 0.0 };
        let mut world_from_camera = fitted.world_from_camera;
        world_from_camera.w_axis = (target + axes.z_axis * distance).extend(1.0);
        Fitted { world_from_camera, distance, ..fitted }
    }

    fn is_orthographic(&self) -> bool {
        match self.request.lens {
            Some(LensRequest::Orthographic) => true,
            Some(LensRequest::FieldOfView(_)) => false,
            None => self
                .of_file
                .is_some_and(|camera| matches!(camera.projection, Projection::Orthographic { .. })),
        }
    }

    fn projection(&self, fitted: &Fitted) -> Projection {
        match fitted.half_height {
            _ if !self.is_orthographic() => self.lens,
            Some(half_height) => limited(parallel(half_height, self.aspect_ratio), self.planes),
            None => self.parallel_at(fitted.distance),
        }
    }

    /// The parallel projection of the camera of the file, or one as high as its perspective is at `distance`.
    fn parallel_at(&self, distance: f32) -> Projection {
        if let Some(own @ Projection::Orthographic { .. }) = self.of_file.map(|camera| camera.projection) {
            return limited(own, self.planes);
        }
        let distance =
            if distance > 0.0 { distance } else { self.subject().bounds.extent().max_element().max(1.0) };
        let half_height = self.lens.half_size(self.aspect_ratio).y * distance;
        limited(parallel(half_height, self.aspect_ratio), self.planes)
    }

    fn rolled(&self, camera: Mat4) -> Mat4 {
        rolled(camera, self.request.roll_degrees.to_radians())
    }
}

/// A projection with the planes of a camera; without one, of all that is ahead.
fn limited(projection: Projection, planes: Option<Projection>) -> Projection {
    projection.with_planes_of(&planes.unwrap_or_else(|| perspective(FRAC_PI_4)))
}

/// Perspective projection without near and far planes.
fn perspective(fov_y_radians: f32) -> Projection {
    Projection::Perspective { fov_y_radians, aspect_ratio: None, z_near: 0.0, z_far: None }
}

/// Parallel projection of all that is ahead.
fn parallel(half_height: f32, aspect_ratio: f32) -> Projection {
    let (x_mag, y_mag) = (half_height * aspect_ratio, half_height);
    Projection::Orthographic { x_mag, y_mag, z_near: 0.0, z_far: f32::MAX }
}

/// Centre of the bounds of the nodes at and below `node` over the whole animation; its origin where it has no mesh.
fn center_of(
    framing: &SharedFraming<'_>,
    selection: &Selection,
    node: NodeIndex,
    clips: &[AnimationIndex],
) -> Vec3 {
    let subject = framing.subject(selection, Some(node), clips);
    let origin = subject.frame.node_position(node).unwrap_or(Vec3::ZERO);
    if subject.is_empty { origin } else { subject.bounds.center() }
}

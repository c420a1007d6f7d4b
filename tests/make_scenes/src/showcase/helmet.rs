//! A full-face helmet: a coated two-tone shell, an iridescent visor in a rubber seal, a chin guard with vents, and metal fittings.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};

use super::solids::{at, joined, lathe, limb, profile, ring_tube, rounded, smooth, surface};
use super::{Stage, metal, paint};
use scene_builder::document::Built;
use scene_builder::material::{ClearCoat, Iridescence, Material};
use scene_builder::shapes::TriangleMesh;

pub(super) fn helmet() -> Built {
    let mut stage = Stage::new(
        "A full-face helmet in ivory and petrol under clear coat, with a dark iridescent visor, black rubber seals, and side hubs of \
         brushed metal. Only the studio lights it; its softboxes show in coat and visor.",
    );
    shell(&mut stage);
    visor(&mut stage);
    chin(&mut stage);
    hubs(&mut stage);
    crest(&mut stage);
    Ok(stage.gltf)
}

/// The shell's surface in a direction from its centre, moved outwards by `offset`.
fn shell_point(direction: Vec3, offset: f32) -> Vec3 {
    let direction = direction.normalize();
    let half = Vec3::new(0.126, 0.142, 0.152);
    let sum: f32 = (direction / half).abs().to_array().map(|share| libm::powf(share, 2.25)).iter().sum();
    let bump =
        |toward: Vec3, sharpness: f32| libm::expf(sharpness * (direction.dot(toward.normalize()) - 1.0));
    // The chin juts out, and so does the back of the head a little.
    let radius = libm::powf(sum, -1.0 / 2.25)
        + 0.040 * bump(Vec3::new(0.0, -0.62, 1.0), 7.0)
        + 0.010 * bump(Vec3::new(0.0, 0.1, -1.0), 4.0);
    direction * (radius + offset)
}

/// A direction by azimuth from the front towards +X, and elevation, both in radians.
fn direction(azimuth: f32, elevation: f32) -> Vec3 {
    let (sin, cos) = libm::sincosf(azimuth);
    let (rise, across) = libm::sincosf(elevation);
    Vec3::new(sin * across, rise, cos * across)
}

/// Elevation of the lower rim: lower at the chin than at the back.
fn rim_elevation(azimuth: f32) -> f32 {
    -0.80 - 0.10 * libm::cosf(azimuth)
}

/// The elevation range from the rim up to the crown, as a surface.
fn shell_patch(
    [columns, rows]: [u32; 2],
    offset: f32,
    [low, high]: [f32; 2],
    azimuths: [f32; 2],
) -> TriangleMesh {
    surface(columns, rows, |u, v| {
        let azimuth = azimuths[0] + (azimuths[1] - azimuths[0]) * u;
        let rim = rim_elevation(azimuth);
        shell_point(direction(azimuth, rim + (TAU / 4.0 - rim) * (low + (high - low) * v)), offset)
    })
}

fn shell(stage: &mut Stage) {
    let coat = Some(ClearCoat { factor: 1.0, roughness: 0.03, normal_texture: None });
    let ivory = Material { clear_coat: coat, ..paint("ivory coat", 0xe9e3d6, 0.5) }.add_to(&mut stage.gltf);
    let petrol = Material { clear_coat: coat, metallic: 0.5, ..paint("petrol coat", 0x1d5a66, 0.4) };
    let petrol = petrol.add_to(&mut stage.gltf);
    let copper = Material { clear_coat: coat, ..metal("copper coat", 0xc9835a, 0.3) }.add_to(&mut stage.gltf);
    let whole = [-TAU / 2.0, TAU / 2.0];
    let upper = shell_patch([56, 16], 0.0, [0.33, 1.0], whole);
    let lower = shell_patch([56, 8], 0.0, [0.0, 0.33], whole);
    stage.add("shell", &[(upper, ivory), (lower, petrol)], [0.0; 3], 0.0);
    // A stripe over the crown, from the brow to the nape, and a line along the border of the two coats.
    let stripe = |half_width: f32, middle: f32, offset: f32| {
        surface(4, 26, |u, v| {
            let (rise, forward) = libm::sincosf(0.56 + (2.86 - 0.56) * v);
            let side = middle + half_width * (2.0 * u - 1.0);
            shell_point(
                Vec3::new(side, rise, forward),
                offset * (1.0 - libm::powf((2.0 * u - 1.0).abs(), 6.0)),
            )
        })
    };
    let stripes = joined([stripe(0.075, 0.15, 0.0013), stripe(0.075, -0.15, 0.0013)]);
    let line = shell_patch([56, 2], 0.0012, [0.325, 0.345], whole);
    stage.add("stripes", &[(stripes, petrol), (line, copper)], [0.0; 3], 0.0);
    // The rim and the dark inside.
    let rubber = paint("rubber", 0x1b1c1e, 0.7).add_to(&mut stage.gltf);
    let lining = Material { double_sided: true, ..paint("lining", 0x3a3634, 1.0) }.add_to(&mut stage.gltf);
    let rim = ring_tube(
        [48, 7],
        0.0065,
        |t| shell_point(direction(TAU * t, rim_elevation(TAU * t)), -0.002),
        |t| direction(TAU * t, 0.0),
    );
    let inside = shell_patch([28, 3], -0.008, [0.0, 0.35], whole);
    stage.add("rim", &[(rim, rubber), (inside, lining)], [0.0; 3], 0.0);
}

/// A point of the visor's opening: at `radius` 1 its border, a superellipse in azimuth and elevation.
fn opening(angle: f32, radius: f32, offset: f32) -> Vec3 {
    let (sin, cos) = libm::sincosf(angle);
    let power = |value: f32| value.signum() * libm::powf(value.abs(), 2.0 / 3.4);
    let (x, y) = (power(cos) * radius, power(sin) * radius);
    // The lower border sags towards the middle, as a visor's does.
    let elevation = 0.06 + 0.33 * y + if y < 0.0 { 0.10 * y * (1.0 - x * x) } else { 0.0 };
    shell_point(direction(1.28 * x, elevation), offset)
}

fn visor(stage: &mut Stage) {
    let glass = Material {
        iridescence: Some(Iridescence { ior: 1.8, thickness_nm: [100.0, 340.0], thickness_texture: None }),
        clear_coat: Some(ClearCoat { factor: 1.0, roughness: 0.0, normal_texture: None }),
        ..metal("visor", 0x95877c, 0.06)
    };
    let glass = glass.add_to(&mut stage.gltf);
    let pane = surface(56, 10, |u, v| {
        let radius = 1.0 - v;
        opening(TAU * u, radius, 0.0075 - 0.007 * libm::powf(radius, 10.0))
    });
    stage.add("visor", &[(pane, glass)], [0.0; 3], 0.0);
    let rubber = paint("seal", 0x202124, 0.55).add_to(&mut stage.gltf);
    let chrome = metal("chrome", 0xd6d8da, 0.12).add_to(&mut stage.gltf);
    let border = |radius: f32, offset: f32| move |t: f32| opening(TAU * t, radius, offset);
    let outward = |t: f32| opening(TAU * t, 1.0, 0.0).normalize();
    let seal = ring_tube([60, 7], 0.0052, border(1.0, 0.002), outward);
    let trim = ring_tube([60, 5], 0.0022, border(1.075, 0.0032), outward);
    stage.add("visor seal", &[(seal, rubber), (trim, chrome)], [0.0; 3], 0.0);
}

/// A dark guard over the chin with slanted vents of metal.
fn chin(stage: &mut Stage) {
    let guard = paint("chin guard", 0x26282b, 0.42).add_to(&mut stage.gltf);
    let steel = metal("vents", 0xb9b4aa, 0.25).add_to(&mut stage.gltf);
    let plate = surface(40, 7, |u, v| {
        let (sin, cos) = libm::sincosf(TAU * u);
        let power = |value: f32| value.signum() * libm::powf(value.abs(), 2.0 / 3.0);
        let radius = 1.0 - v;
        let target = direction(0.62 * power(cos) * radius, -0.56 + 0.145 * power(sin) * radius);
        shell_point(target, 0.0055 - 0.0065 * libm::powf(radius, 8.0))
    });
    let vents = [-2.0, -1.0, 0.0, 1.0, 2.0_f32].map(|index| {
        let ends = [-0.085, 0.085].map(|rise| {
            shell_point(direction(index * 0.2 - 0.4 * rise * index.signum(), -0.56 + rise), 0.0052)
        });
        limb(ends, [0.0042; 2], [8, 2])
    });
    stage.add("chin guard", &[(plate, guard), (joined(vents), steel)], [0.0; 3], 0.0);
}

/// Hubs of the visor's hinges with six bolts each.
fn hubs(stage: &mut Stage) {
    let steel = metal("brushed metal", 0xc4c1ba, 0.28).add_to(&mut stage.gltf);
    let dark = metal("gun metal", 0x55575c, 0.35).add_to(&mut stage.gltf);
    let copper = metal("copper", 0xd08c62, 0.18).add_to(&mut stage.gltf);
    let base = lathe(
        &rounded(&[(0.0, -0.012), (0.042, -0.012), (0.040, 0.006), (0.031, 0.009), (0.0, 0.009)], 0.003, 2),
        32,
    );
    let disc = lathe(
        &rounded(
            &[(0.022, 0.006), (0.030, 0.0115), (0.018, 0.0115), (0.012, 0.009), (0.0, 0.009)],
            0.0018,
            2,
        ),
        36,
    );
    let knob = lathe(&smooth(&[(0.0105, 0.008), (0.0105, 0.013), (0.007, 0.0155), (0.0, 0.0162)], 3), 20);
    let bolt = lathe(&rounded(&[(0.0034, 0.0085), (0.0034, 0.0112), (0.0, 0.0118)], 0.001, 1), 8);
    let bolts = (0..6).map(|index| {
        let (sin, cos) = libm::sincosf(TAU * (index as f32 + 0.5) / 6.0);
        at(bolt.clone(), 0.0352 * sin, 0.0, 0.0352 * cos)
    });
    let parts = [(base, dark), (disc, steel), (joined([knob, joined(bolts)]), copper)];
    let hub = stage.mesh(&parts);
    for (name, side) in [("hub left", 1.0), ("hub right", -1.0)] {
        let outward = direction(side * 1.52, 0.04);
        let turned = Quat::from_rotation_arc(Vec3::Y, Vec3::new(side, 0.12, 0.0).normalize());
        let place = shell_point(outward, 0.004);
        stage.pose(name, hub, place, turned);
    }
}

/// A low fin between the stripes, and two lamps above the brow.
fn crest(stage: &mut Stage) {
    let dark = paint("crest", 0x26282b, 0.35).add_to(&mut stage.gltf);
    let steel = metal("lamp bezel", 0xc4c1ba, 0.2).add_to(&mut stage.gltf);
    let light = Material { emissive: super::srgb(0xffe7bd), ..paint("lamp", 0xffffff, 0.2) };
    let light = light.add_to(&mut stage.gltf);
    let fin = surface(12, 26, |u, v| {
        let (rise, forward) = libm::sincosf(0.9 + 1.75 * v);
        let across = 2.0 * u - 1.0;
        let height = libm::sinf(TAU / 2.0 * v).max(0.0);
        let profile = 1.0 - libm::powf(across.abs(), 2.5);
        shell_point(
            Vec3::new(across * 0.055 * (0.25 + 0.75 * height.sqrt()), rise, forward),
            0.018 * profile * height.sqrt() - 0.001,
        )
    });
    stage.add("crest", &[(fin, dark)], [0.0; 3], 0.0);
    let bezel = lathe(
        &rounded(
            &[
                (0.0, -0.006),
                (0.0135, -0.006),
                (0.0125, 0.007),
                (0.0095, 0.007),
                (0.0095, 0.004),
                (0.0, 0.004),
            ],
            0.001,
            1,
        ),
        24,
    );
    let lens = lathe(&profile(&[(0.0095, 0.0035), (0.007, 0.0052), (0.004, 0.006), (0.0, 0.0063)]), 20);
    let lamp = stage.mesh(&[(bezel, steel), (lens, light)]);
    for (name, side) in [("lamp left", 1.0), ("lamp right", -1.0)] {
        let outward = direction(side * 0.62, 0.55);
        let turned = Quat::from_rotation_arc(Vec3::Y, direction(side * 0.45, 0.35));
        stage.pose(name, lamp, shell_point(outward, 0.004), turned);
    }
}

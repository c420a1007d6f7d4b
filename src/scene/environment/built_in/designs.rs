//! The built-in lights: their backdrops, areas and key lights. docs/shading.md has them as a table.

use glam::Vec3;

use super::area::AreaDesign;
use super::gradient::Gradient;

/// A light as it is stated.
pub(super) struct Design {
    pub(super) backdrop: Gradient,
    /// Later areas cover earlier ones.
    pub(super) areas: &'static [AreaDesign],
    pub(super) key: KeyDesign,
    /// Exposure that it is made for, in stops.
    pub(super) exposure_ev: f32,
}

/// Directional light that casts shadows.
pub(super) struct KeyDesign {
    pub(super) azimuth: f32,
    pub(super) elevation: f32,
    pub(super) irradiance: Vec3,
}

pub(super) const fn area(
    azimuth: f32,
    elevation: f32,
    size: [f32; 2],
    edge: f32,
    radiance: [f32; 3],
) -> AreaDesign {
    AreaDesign { azimuth, elevation, size, edge, radiance: Vec3::from_array(radiance) }
}

/// Key at the front left, fill at the right, two rims behind and a strip above.
pub(super) static STUDIO: Design = Design {
    backdrop: Gradient {
        floor: Vec3::new(0.09, 0.09, 0.09),
        horizon: Vec3::new(0.26, 0.265, 0.27),
        ceiling: Vec3::new(0.29, 0.295, 0.3),
        floor_height: -0.4,
    },
    areas: &[
        area(10.0, 0.0, [100.0, 70.0], 40.0, [0.06, 0.06, 0.06]),
        area(-46.0, 44.0, [46.0, 36.0], 6.0, [3.6, 3.5, 3.32]),
        area(65.0, 14.0, [32.0, 68.0], 8.0, [1.2, 1.25, 1.3]),
        area(-135.0, 20.0, [18.0, 70.0], 6.0, [4.0, 4.0, 4.0]),
        area(148.0, 25.0, [14.0, 70.0], 6.0, [4.0, 4.0, 4.0]),
        area(0.0, 80.0, [70.0, 26.0], 6.0, [2.1, 2.1, 2.1]),
    ],
    key: KeyDesign { azimuth: -40.0, elevation: 46.0, irradiance: Vec3::new(2.0, 1.93, 1.82) },
    exposure_ev: 0.0,
};

/// Large boxes above and at the sides.
pub(super) static SOFTBOX: Design = Design {
    backdrop: Gradient {
        floor: Vec3::new(0.45, 0.45, 0.45),
        horizon: Vec3::new(0.62, 0.62, 0.62),
        ceiling: Vec3::new(0.55, 0.55, 0.55),
        floor_height: -0.6,
    },
    areas: &[
        area(0.0, 5.0, [110.0, 90.0], 50.0, [0.1, 0.1, 0.1]),
        area(180.0, 10.0, [40.0, 110.0], 20.0, [0.25, 0.25, 0.25]),
        area(0.0, 88.0, [110.0, 70.0], 8.0, [2.2, 2.2, 2.2]),
        area(-62.0, 15.0, [50.0, 85.0], 6.0, [1.9, 1.9, 1.9]),
        area(70.0, 15.0, [50.0, 85.0], 6.0, [1.9, 1.9, 1.9]),
    ],
    key: KeyDesign { azimuth: -25.0, elevation: 60.0, irradiance: Vec3::new(0.8, 0.8, 0.8) },
    exposure_ev: 0.0,
};

/// Sky, sun and ground.
pub(super) static OUTDOOR: Design = Design {
    backdrop: Gradient {
        floor: Vec3::new(0.17, 0.15, 0.12),
        horizon: Vec3::new(0.52, 0.57, 0.63),
        ceiling: Vec3::new(0.09, 0.18, 0.4),
        floor_height: -0.12,
    },
    areas: &[
        area(35.0, 3.0, [70.0, 10.0], 6.0, [0.15, 0.16, 0.13]),
        area(150.0, 3.0, [80.0, 12.0], 6.0, [0.15, 0.16, 0.13]),
        area(-95.0, 3.0, [60.0, 9.0], 6.0, [0.15, 0.16, 0.13]),
        area(70.0, 28.0, [70.0, 20.0], 18.0, [0.95, 0.95, 0.95]),
        area(25.0, 50.0, [40.0, 14.0], 14.0, [0.8, 0.8, 0.8]),
        area(-130.0, 35.0, [60.0, 20.0], 18.0, [0.9, 0.9, 0.9]),
        area(170.0, 18.0, [90.0, 14.0], 12.0, [0.85, 0.85, 0.87]),
        area(-35.0, 44.0, [50.0, 50.0], 50.0, [1.5, 1.45, 1.35]),
        area(-35.0, 44.0, [13.0, 13.0], 10.0, [11.0, 10.0, 8.4]),
    ],
    key: KeyDesign { azimuth: -35.0, elevation: 44.0, irradiance: Vec3::new(2.7, 2.45, 2.1) },
    exposure_ev: 0.0,
};

/// Rims at both sides of the back.
pub(super) static DARK: Design = Design {
    backdrop: Gradient {
        floor: Vec3::new(0.008, 0.008, 0.01),
        horizon: Vec3::new(0.035, 0.035, 0.04),
        ceiling: Vec3::new(0.015, 0.015, 0.018),
        floor_height: -0.5,
    },
    areas: &[
        area(-120.0, 15.0, [24.0, 90.0], 6.0, [4.4, 4.6, 4.8]),
        area(124.0, 20.0, [20.0, 90.0], 6.0, [4.8, 4.5, 4.15]),
        area(0.0, 80.0, [70.0, 14.0], 6.0, [2.5, 2.5, 2.5]),
        area(-32.0, 25.0, [30.0, 50.0], 10.0, [1.0, 1.0, 1.0]),
        area(55.0, 5.0, [14.0, 70.0], 6.0, [1.0, 0.97, 0.92]),
    ],
    key: KeyDesign { azimuth: -100.0, elevation: 42.0, irradiance: Vec3::new(1.4, 1.45, 1.5) },
    exposure_ev: 0.0,
};

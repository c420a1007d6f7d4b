//! The systems of the table: what each builds, and how its rays are traced.

use rayon::ThreadPool;
use std::time::Instant;

use rayframe::bvh::{
    BuildSettings, Builder, BuilderKind, Bvh, Refit, Split, TraversalCounters, TriangleFlags,
};
use rayframe::cancel::{CancelFlag, Cancelled};
use rayframe::geometry::{Ray, Triangle};

use super::Result;
use super::hierarchy::{Bvh2, Closest, Counters};
use super::kd_tree::KdTree;
use super::late_split::late_split;
use super::overlap::end_point_overlap;
use super::references::{early_split, refined, whole};
use super::{lbvh, sah_bvh};

/// Most references of a system, beyond which it is left out.
const MOST_REFERENCES: usize = 24_000_000;

/// Most references a triangle of the product's early splits.
const MOST_PER_TRIANGLE: f32 = 16.0;
/// Name of the product's own choice.
pub(crate) const AUTOMATIC: &str = "Rayframe, automatic";
/// References a triangle whose gain is measured.
pub(crate) const BUDGETS: [f32; 3] = [1.25, 1.5, 2.0];

/// What a hierarchy is built over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Input {
    Whole,
    /// Early split clipping at this SA_max, square metres.
    Early(f64),
    /// Late split clipping.
    Late(f64),
    /// Geometry refinement.
    Refined(f64),
    /// The product's own choice of splits.
    Automatic,
    /// The product's early split clipping at the smallest SA_max with this many references a triangle.
    Budget(f32),
}

/// How it is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Karras,
    Hlbvh,
    BinnedSah,
    SweptSah,
    KdTree,
    ClippedKdTree,
    Product(BuilderKind),
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct System {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    pub(crate) input: Input,
}

/// A built hierarchy.
#[derive(Debug)]
pub(crate) enum Structure {
    Binary(Bvh2),
    Kd(KdTree),
    Product(Box<Bvh>),
}

/// Properties of a hierarchy.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Properties {
    pub(crate) references: usize,
    pub(crate) nodes: usize,
    pub(crate) depth: u32,
    pub(crate) sah_cost: f64,
    /// End-point overlap; of binary hierarchies only.
    pub(crate) overlap: Option<f64>,
    pub(crate) bytes: usize,
}

/// All systems. The SA_max of early splits are `factors` times the area of the scene's box over the number of triangles.
pub(crate) fn systems(factors: &[f64], area_a_triangle: f64) -> Vec<System> {
    let system = |name: &str, kind, input| System { name: name.to_owned(), kind, input };
    let mut systems = vec![
        system("LBVH (Karras)", Kind::Karras, Input::Whole),
        system("HLBVH", Kind::Hlbvh, Input::Whole),
        system("SAH BVH, binned", Kind::BinnedSah, Input::Whole),
        system("SAH BVH, full sweep", Kind::SweptSah, Input::Whole),
        system("SAH kd-tree", Kind::KdTree, Input::Whole),
        system("SAH kd-tree, split clipping", Kind::ClippedKdTree, Input::Whole),
    ];
    for factor in factors {
        let sa_max = factor * area_a_triangle;
        for (name, kind) in [("LBVH", Kind::Karras), ("SAH BVH", Kind::SweptSah)] {
            systems.push(system(&format!("{name}, early {factor}"), kind, Input::Early(sa_max)));
        }
    }
    if let Some(factor) = factors.get(factors.len() / 2) {
        let sa_max = factor * area_a_triangle;
        systems.push(system(&format!("SAH BVH, late {factor}"), Kind::SweptSah, Input::Late(sa_max)));
        systems.push(system(&format!("SAH BVH, refined {factor}"), Kind::SweptSah, Input::Refined(sa_max)));
    }
    systems.push(system("Rayframe, lbvh unsplit", Kind::Product(BuilderKind::Karras), Input::Whole));
    systems.push(system(AUTOMATIC, Kind::Product(BuilderKind::Auto), Input::Automatic));
    systems
}

/// The systems of a sweep: both unsplit baselines, early splits at each of the SA_max, and the product's choice.
pub(crate) fn sweep(factors: &[f64], area_a_triangle: f64) -> Vec<System> {
    let system = |name: String, kind, input| System { name, kind, input };
    let product = Kind::Product(BuilderKind::Auto);
    let mut systems = vec![
        system("LBVH (Karras)".into(), Kind::Karras, Input::Whole),
        system("SAH BVH, full sweep".into(), Kind::SweptSah, Input::Whole),
        system("Rayframe, unsplit".into(), product, Input::Whole),
    ];
    for factor in factors {
        let input = Input::Early(factor * area_a_triangle);
        for (name, kind) in [("LBVH", Kind::Karras), ("binned SAH", Kind::BinnedSah), ("Rayframe", product)] {
            systems.push(system(format!("{name}, early {factor}"), kind, input));
        }
    }
    systems.push(system(AUTOMATIC.into(), product, Input::Automatic));
    systems
}

/// The product with no, a few and many splits whatever the scene, and by its own choice.
pub(crate) fn splits() -> Vec<System> {
    let system = |name: String, input| System { name, kind: Kind::Product(BuilderKind::Auto), input };
    let mut systems = vec![system("Rayframe, unsplit".into(), Input::Whole)];
    for budget in BUDGETS {
        systems.push(system(format!("Rayframe, R {budget}"), Input::Budget(budget)));
    }
    systems.push(system(AUTOMATIC.into(), Input::Automatic));
    systems
}

impl System {
    /// Whether this is the product's automatic choice.
    pub(crate) fn is_automatic(&self) -> bool {
        self.input == Input::Automatic
    }

    /// Builds the hierarchy on `pool`; returns it with the seconds. `None` where there are too many references.
    ///
    /// # Errors
    /// Those of the product's builder.
    pub(crate) fn build(
        &self,
        triangles: &[Triangle],
        pool: &ThreadPool,
    ) -> Result<Option<(Structure, f64)>> {
        let start = Instant::now();
        if let Kind::Product(builder) = self.kind {
            let bvh = pool.install(|| product(builder, self.input, triangles))?;
            return Ok(Some((Structure::Product(Box::new(bvh)), start.elapsed().as_secs_f64())));
        }
        let references = match self.input {
            Input::Whole | Input::Late(_) | Input::Automatic | Input::Budget(_) => whole(triangles),
            Input::Early(sa_max) => early_split(triangles, sa_max),
            Input::Refined(sa_max) => refined(triangles, sa_max),
        };
        if references.len() > MOST_REFERENCES {
            return Ok(None);
        }
        let structure = pool.install(|| match self.kind {
            Kind::KdTree => Structure::Kd(KdTree::build(triangles, false)),
            Kind::ClippedKdTree => Structure::Kd(KdTree::build(triangles, true)),
            Kind::Karras => Structure::Binary(lbvh::karras(&references)),
            Kind::Hlbvh => Structure::Binary(lbvh::hlbvh(&references)),
            Kind::BinnedSah => Structure::Binary(sah_bvh::binned(references)),
            Kind::SweptSah | Kind::Product(_) => Structure::Binary(sah_bvh::full_sweep(references)),
        });
        let structure = match (structure, self.input) {
            (Structure::Binary(whole), Input::Late(sa_max)) => {
                Structure::Binary(late_split(&whole, triangles, sa_max))
            }
            (structure, _) => structure,
        };
        Ok(Some((structure, start.elapsed().as_secs_f64())))
    }
}

fn product(
    builder: BuilderKind,
    input: Input,
    triangles: &[Triangle],
) -> std::result::Result<Bvh, Cancelled> {
    let mut settings =
        BuildSettings { builder, split: Split::Off, refit: Refit::Off, ..BuildSettings::default() };
    match input {
        Input::Automatic => settings.split = Split::Auto,
        Input::Early(sa_max) => {
            (settings.split, settings.reference_budget) = (Split::Area(sa_max as f32), MOST_PER_TRIANGLE);
        }
        Input::Budget(budget) => {
            (settings.split, settings.reference_budget) = (Split::Area(f32::MIN_POSITIVE), budget);
        }
        Input::Whole | Input::Late(_) | Input::Refined(_) => {}
    }
    let flags = vec![TriangleFlags(0); triangles.len()];
    Builder::default().build(triangles, &flags, &settings, &CancelFlag::new(), None)
}

impl Structure {
    /// The closest hits of rays, one by one, and the work.
    pub(crate) fn trace(&self, rays: &[Ray], triangles: &[Triangle], hits: &mut Vec<Closest>) -> Counters {
        let mut counters = Counters::default();
        hits.clear();
        match self {
            Self::Binary(bvh) => {
                hits.extend(rays.iter().map(|ray| bvh.closest(ray, triangles, &mut counters)));
            }
            Self::Kd(tree) => hits.extend(rays.iter().map(|ray| tree.closest(ray, triangles, &mut counters))),
            Self::Product(bvh) => {
                let mut own = TraversalCounters::default();
                hits.extend(rays.iter().map(|ray| {
                    bvh.closest_hit_of_any_side(ray, None, |_| true, &mut own)
                        .map(|hit| (hit.t, hit.triangle))
                }));
                counters = Counters { nodes: own.nodes, triangles: own.triangles };
            }
        }
        counters
    }

    /// Size and quality.
    pub(crate) fn properties(&self, triangles: &[Triangle], has_overlap: bool) -> Properties {
        match self {
            Self::Binary(bvh) => Properties {
                references: bvh.references.len(),
                nodes: bvh.nodes.len(),
                depth: bvh.depth(),
                sah_cost: bvh.sah_cost(),
                overlap: has_overlap.then(|| end_point_overlap(bvh, triangles)),
                bytes: bvh.bytes(),
            },
            Self::Kd(tree) => Properties {
                references: tree.reference_count(),
                nodes: tree.node_count(),
                depth: tree.depth(),
                sah_cost: tree.sah_cost(),
                overlap: None,
                bytes: tree.bytes(),
            },
            Self::Product(bvh) => {
                let statistics = bvh.statistics();
                Properties {
                    references: statistics.references,
                    nodes: 0,
                    depth: statistics.depth,
                    sah_cost: f64::from(statistics.sah_cost),
                    overlap: None,
                    bytes: statistics.bytes,
                }
            }
        }
    }
}

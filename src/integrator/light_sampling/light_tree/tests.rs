use super::*;
use crate::integrator::zsobol::ZSobol;

fn light_tree(emitters: &[Emitter]) -> LightTree {
    LightTree::new(emitters, Level::new())
}

/// Numbers in [0, 1) by index.
struct Random(u32);

impl Random {
    fn number(&mut self) -> f32 {
        self.0 += 1;
        ZSobol::new(1, 0).sequence((self.0 & 0xFFFF, self.0 >> 16), 0).number(77)
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number()) * 2.0 - 1.0
    }

    fn unit(&mut self) -> Vec3 {
        self.vector().try_normalize().unwrap_or(Vec3::Y)
    }
}

fn area_power(corners: [Vec3; 3], radiance: f32, is_two_sided: bool) -> f32 {
    let area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
    radiance * area * std::f32::consts::PI * if is_two_sided { 2.0 } else { 1.0 }
}

/// Triangles of a size in a box, one- and two-sided, of powers that differ a thousandfold.
fn emitters(count: u32, size: f32) -> Vec<Emitter> {
    let mut random = Random(count * 1000);
    let emitter = |_| {
        let center = random.vector();
        let corners = std::array::from_fn(|_| center + random.vector() * size);
        let is_two_sided = random.number() < 0.3;
        let radiance = libm::powf(1000.0, random.number());
        Emitter { corners, power: area_power(corners, radiance, is_two_sided), is_two_sided }
    };
    (0..count).map(emitter).collect()
}

/// Sets of emitters: none, one, few, many; flat, large, small; equal ones; a wall of panels.
fn sets() -> Vec<Vec<Emitter>> {
    let panel = |i: u32| {
        let corner = Vec3::new((i % 8) as f32, (i / 8) as f32, 0.0) * 0.2;
        let corners = [corner, corner + Vec3::X * 0.2, corner + Vec3::Y * 0.2];
        Emitter { corners, power: 1.0, is_two_sided: false }
    };
    vec![
        Vec::new(),
        emitters(1, 0.5),
        emitters(2, 0.1),
        emitters(3, 2.0),
        emitters(200, 0.05),
        emitters(200, 1.0),
        vec![panel(0); 50],
        (0..64).map(panel).collect(),
    ]
}

/// The light from an emitter of radiance one at many of its points, by inverse squares and both cosines, without occlusion.
fn irradiance(emitter: &Emitter, point: Vec3, normal: Option<Vec3>, per_edge: u32) -> f64 {
    let [a, b, c] = emitter.corners.map(Vec3::as_dvec3);
    let emitter_normal = (b - a).cross(c - a);
    let mut sum = 0.0;
    for (i, j) in (0..per_edge).flat_map(|i| (0..per_edge - i).map(move |j| (i, j))) {
        let weight = |i: u32| (f64::from(i) + 1.0 / 3.0) / f64::from(per_edge);
        let to_light = a + (b - a) * weight(i) + (c - a) * weight(j) - point.as_dvec3();
        let direction = to_light.normalize();
        let at_light = -direction.dot(emitter_normal);
        let at_light = if emitter.is_two_sided { at_light.abs() } else { at_light.max(0.0) };
        let at_point = normal.map_or(1.0, |normal| direction.dot(normal.as_dvec3()).max(0.0));
        sum += at_light * at_point / to_light.length_squared().max(1e-6);
    }
    sum / f64::from(per_edge * (per_edge + 1))
}

/// Points in and around the emitters, with and without normals.
fn receivers(count: u32) -> impl Iterator<Item = (Vec3, Option<Vec3>)> {
    let mut random = Random(7);
    (0..count).map(move |i| {
        let point = random.vector() * if i % 5 == 0 { 100.0 } else { 1.5 };
        let normal = random.unit();
        (point, (i % 3 != 0).then_some(normal))
    })
}

#[test]
fn probabilities_sum_to_at_most_one_and_agree_with_samples() {
    for (set, emitters) in sets().iter().enumerate() {
        let tree = light_tree(emitters);
        for (point, normal) in receivers(60) {
            let probabilities: Vec<f32> =
                (0..emitters.len() as u32).map(|emitter| tree.probability(point, normal, emitter)).collect();
            let sum: f32 = probabilities.iter().sum();
            assert!(sum < 1.0 + 1e-4, "set {set}: {sum}");
            let mut found = 0;
            for i in 0..200 {
                if let Some((emitter, probability)) = tree.sample(point, normal, (i as f32 + 0.5) / 200.0) {
                    assert_eq!(probability, probabilities[emitter as usize], "set {set}");
                    assert!(probability > 0.0);
                    found += 1;
                }
            }
            assert!((sum - found as f32 / 200.0).abs() < 0.05, "set {set}: {sum} {found}");
        }
        assert_eq!(tree.probability(Vec3::ZERO, None, emitters.len() as u32), 0.0);
    }
}

#[test]
fn probabilities_sum_to_one_within_the_emitters() {
    // No node is rejected where the emitters are two-sided and the point has no normal, but for edge-on views.
    let mut emitters = emitters(300, 0.3);
    for emitter in &mut emitters {
        emitter.is_two_sided = true;
    }
    let tree = light_tree(&emitters);
    for (point, _) in receivers(100) {
        let sum: f32 = (0..300).map(|emitter| tree.probability(point, None, emitter)).sum();
        assert!((sum - 1.0).abs() < 1e-4, "{sum}");
    }
}

#[test]
fn every_emitter_that_lights_a_point_has_a_probability() {
    for (set, emitters) in sets().iter().enumerate() {
        let tree = light_tree(emitters);
        let mut lit = 0;
        for (point, normal) in receivers(300) {
            for (index, emitter) in emitters.iter().enumerate() {
                let probability = tree.probability(point, normal, index as u32);
                let light = irradiance(emitter, point, normal, 6);
                lit += usize::from(light > 0.0);
                assert!(
                    light == 0.0 || probability > 0.0,
                    "set {set}: {point} {normal:?} {emitter:?} {light}"
                );
            }
        }
        assert!(lit > 0 || emitters.is_empty(), "set {set}");
    }
}

#[test]
fn points_on_and_beside_emitters_see_the_others() {
    // The corners and centres of all emitters, and tiny triangles far from the origin.
    let mut emitters = emitters(100, 0.2);
    for scale in [1.0, 1e-4] {
        emitters
            .iter_mut()
            .flat_map(|emitter| &mut emitter.corners)
            .for_each(|c| *c = *c * scale + Vec3::X * 8.0);
        let tree = light_tree(&emitters);
        let mut lit = 0;
        for receiver in &emitters {
            let [a, b, c] = receiver.corners;
            let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
            for point in [a, (a + b + c) / 3.0] {
                for (index, emitter) in
                    emitters.iter().enumerate().filter(|(_, e)| e.corners != receiver.corners)
                {
                    let is_lit = irradiance(emitter, point, Some(normal), 4) > 1e-12;
                    lit += usize::from(is_lit);
                    assert!(!is_lit || tree.probability(point, Some(normal), index as u32) > 0.0);
                }
            }
        }
        assert!(lit > 0, "scale {scale}");
    }
}

#[test]
fn frequencies_of_samples_are_their_probabilities() {
    let emitters = emitters(50, 0.2);
    let tree = light_tree(&emitters);
    for (point, normal) in receivers(6) {
        let count = 40_000;
        let mut counts = vec![0_u32; emitters.len()];
        for i in 0..count {
            if let Some((emitter, _)) = tree.sample(point, normal, (i as f32 + 0.5) / count as f32) {
                counts[emitter as usize] += 1;
            }
        }
        for (emitter, &found) in counts.iter().enumerate() {
            let probability = tree.probability(point, normal, emitter as u32);
            assert!(
                (found as f32 / count as f32 - probability).abs() < 1e-3,
                "{emitter}: {found} {probability}"
            );
        }
    }
}

/// Variances of the light of one sample, over its square, in the mean of some points: by the tree, by power and by chance.
fn variances(emitters: &[Emitter]) -> [f64; 3] {
    let tree = light_tree(emitters);
    let total_power: f64 = emitters.iter().map(|emitter| f64::from(emitter.power)).sum();
    let mut sums = [0.0; 3];
    for (point, normal) in receivers(100) {
        let radiance =
            |e: &Emitter| f64::from(e.power) / f64::from(area_power(e.corners, 1.0, e.is_two_sided));
        let lights: Vec<f64> = emitters
            .iter()
            .map(|emitter| radiance(emitter) * irradiance(emitter, point, normal, 3))
            .collect();
        let sum: f64 = lights.iter().sum();
        let variance = |probability: &dyn Fn(usize) -> f64| -> f64 {
            let lit = lights.iter().enumerate().filter(|(_, light)| **light > 0.0);
            lit.map(|(i, light)| light * light / probability(i)).sum::<f64>() / (sum * sum) - 1.0
        };
        if sum > 0.0 {
            sums[0] += variance(&|i| f64::from(tree.probability(point, normal, i as u32)));
            sums[1] += variance(&|i| f64::from(emitters[i].power) / total_power);
            sums[2] += variance(&|_| 1.0 / emitters.len() as f64);
        }
    }
    sums.map(|sum| sum / 100.0)
}

#[test]
fn the_variance_of_direct_light_is_far_below_that_of_uniform_choice() {
    let panels: Vec<Emitter> = sets().pop().unwrap_or_default();
    for (name, emitters, least) in
        [("few", emitters(8, 0.1), 20.0), ("many", emitters(1000, 0.02), 30.0), ("wall", panels, 30.0)]
    {
        let [by_tree, by_power, uniform] = variances(&emitters);
        assert!(by_tree * least < by_power.min(uniform), "{name}: {by_tree} {by_power} {uniform}");
    }
}

#[test]
fn emitters_without_light_are_left_out() {
    let mut emitters = emitters(20, 0.2);
    emitters[3].power = 0.0;
    emitters[4].power = f32::NAN;
    emitters[5].corners = [Vec3::X; 3];
    emitters[6].corners[1] = Vec3::NAN;
    emitters[7].power = f32::INFINITY;
    emitters[8].power = 1e-38;
    let tree = light_tree(&emitters);
    for (point, _) in receivers(50) {
        for emitter in 3..8 {
            assert_eq!(tree.probability(point, None, emitter), 0.0);
        }
        if irradiance(&emitters[8], point, None, 4) > 0.0 {
            assert!(tree.probability(point, None, 8) > 0.0);
        }
    }
}

#[test]
fn thread_counts_do_not_matter_and_large_trees_are_whole() {
    let emitters = emitters(100_000, 0.01);
    let [one, four] = [1, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| light_tree(&emitters))
    });
    assert_eq!(one.tree.leaves, four.tree.leaves);
    assert_eq!(one.tree.parents, four.tree.parents);
    // Every emitter has a slot of its own, and nodes are nearly full.
    let mut slots = one.tree.leaves.clone();
    slots.sort_unstable();
    slots.dedup();
    assert_eq!(slots.len(), emitters.len());
    assert!(one.tree.leaves.iter().all(|&slot| (slot as usize) < one.tree.nodes.len() * WIDTH));
    assert!(one.tree.nodes.len() < emitters.len() / 3, "{} nodes", one.tree.nodes.len());
    for (point, normal) in receivers(20) {
        for u in [0.0, 0.3, 0.9, 1.0 - f32::EPSILON / 2.0] {
            let found = one.sample(point, normal, u);
            assert_eq!(found, four.sample(point, normal, u));
            if let Some((emitter, probability)) = found {
                assert_eq!(one.probability(point, normal, emitter), probability);
            }
        }
    }
}

#[test]
fn instruction_sets_choose_alike() {
    for emitters in sets() {
        let [scalar, best] = [Level::fallback(), Level::new()].map(|level| LightTree::new(&emitters, level));
        for (point, normal) in receivers(100) {
            for u in [0.0, 0.2, 0.5, 0.99] {
                assert_eq!(scalar.sample(point, normal, u), best.sample(point, normal, u));
            }
            for emitter in 0..emitters.len() as u32 {
                let [a, b] = [&scalar, &best].map(|tree| tree.probability(point, normal, emitter).to_bits());
                assert_eq!(a, b);
            }
        }
    }
}

/// The probabilities of all emitters below a node of this probability, child by child.
fn add_probabilities(tree: &LightTree, node: usize, at: LitPoint, probability: f64, sums: &mut [f64]) {
    let node = &tree.tree.nodes[node];
    let importances: Vec<f64> = (0..WIDTH).map(|lane| f64::from(node.importance(lane, at))).collect();
    let sum: f64 = importances.iter().sum();
    for (lane, importance) in importances.into_iter().enumerate().filter(|&(_, importance)| importance > 0.0)
    {
        let (index, probability) = (node.index(lane) as usize, probability * importance / sum);
        if node.is_emitter(lane) {
            sums[index] += probability;
        } else {
            add_probabilities(tree, index, at, probability, sums);
        }
    }
}

#[test]
fn probabilities_are_those_of_a_walk_over_the_whole_tree() {
    for emitters in sets().iter().filter(|emitters| !emitters.is_empty()) {
        let tree = light_tree(emitters);
        for (point, normal) in receivers(60) {
            let mut expected = vec![0.0; emitters.len()];
            add_probabilities(&tree, 0, LitPoint { point, normal }, 1.0, &mut expected);
            for (emitter, expected) in (0..).zip(expected) {
                let found = f64::from(tree.probability(point, normal, emitter));
                assert!((found - expected).abs() <= 1e-5 * expected + 1e-8, "{emitter}: {found} {expected}");
            }
        }
    }
}

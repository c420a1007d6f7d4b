//! The tables of albedos against the integrals they hold.

use super::super::albedo_slice::AlbedoSlice;
use super::super::{fresnel, internal_albedo, isotropic_albedo, microfacets::Microfacets};

/// Largest and root mean square differences of the total, Schlick's and the exact albedo over roughness and views, which are dense
/// around the critical angle.
fn errors(relative_ior: f32, cosines_from: f32) -> ([f32; 3], f32) {
    let slice = AlbedoSlice::new(relative_ior);
    let critical = if relative_ior < 1.0 { (1.0 - relative_ior * relative_ior).sqrt() } else { 0.3 };
    let (mut worst, mut squares, mut count) = ([0.0_f32; 3], 0.0, 0.0);
    for row in 0..24 {
        let share = (row as f32 + 0.37) / 24.0;
        let roughness = 0.001 + 0.999 * share * share;
        for view in 0..80 {
            let cosine = if view < 40 {
                let root = (view as f32 + 0.5) / 40.0;
                root * root
            } else {
                let root = (view as f32 - 59.5) / 20.0;
                critical + root * root.abs() * if root < 0.0 { critical } else { 1.0 - critical }
            };
            if cosine < cosines_from {
                continue;
            }
            let facets = Microfacets::isotropic(cosine, roughness * roughness);
            let [total, schlick] = facets.reflected(|cosine| [1.0, fresnel::schlick_weight(cosine)]);
            let exact = if relative_ior < 1.0 {
                total - internal_albedo::by_quadrature(&facets, relative_ior)
            } else {
                let [exact] = facets.reflected(|cosine| [fresnel::exact(cosine, relative_ior)]);
                exact
            };
            let found = slice.terms(cosine, roughness);
            let differences =
                [found.total - total, found.schlick - schlick, found.exact - exact].map(f32::abs);
            for (worst, difference) in worst.iter_mut().zip(differences) {
                *worst = worst.max(difference);
            }
            squares += differences[2] * differences[2];
            count += 1.0;
        }
    }
    (worst, (squares / count).sqrt())
}

#[test]
fn tables_of_the_thinner_side_are_within_a_thousandth_of_the_integrals() {
    for ior in [1.01_f32, 1.03, 1.07, 1.2, 1.33, 1.45, 1.5, 1.7, 2.0, 2.4, 3.1, 4.0, 6.0, 12.0, 25.0] {
        let ([total, schlick, exact], mean) = errors(ior, 0.0);
        assert!(
            total < 1e-3 && schlick < 1e-3 && exact < 1e-3 && mean < 3e-4,
            "{ior}: {total} {schlick} {exact} {mean}"
        );
    }
}

#[test]
fn tables_of_the_denser_side_are_within_two_thousandths_of_the_integrals() {
    for ior in [1.01_f32, 1.03, 1.07, 1.2, 1.33, 1.45, 1.5, 1.7, 2.0, 2.4, 3.1, 4.0, 6.0] {
        let ([.., exact], mean) = errors(1.0 / ior, 0.0);
        assert!(exact < 2e-3 && mean < 5e-4, "{ior}: {exact} {mean}");
    }
}

#[test]
fn indices_close_to_one_reuse_the_tables() {
    for ior in [1.000_01_f32, 1.000_3, 1.002, 1.008] {
        let ([.., exact], _) = errors(ior, 0.02);
        assert!(exact < 2e-3, "{ior}: {exact}");
        let ([.., exact], _) = errors(1.0 / ior, 0.15);
        assert!(exact < 2e-3, "{ior}: {exact}");
    }
}

#[test]
fn slices_are_continuous_over_the_index() {
    for larger in [1.009_f32, 1.05, 1.4999, 2.0, 27.0, 30.0] {
        for ior in [larger, 1.0 / larger] {
            for (cosine, roughness) in [(0.05, 0.2), (0.5, 0.5), (0.9, 0.05), (1.0, 1.0)] {
                let terms = |ior: f32| AlbedoSlice::new(ior).terms(cosine, roughness).exact;
                let difference = (terms(ior) - terms(ior * 1.000_01)).abs();
                assert!(difference < 3e-4, "{ior} {cosine} {roughness}: {difference}");
            }
        }
    }
}

#[test]
fn equal_media_reflect_nothing_at_any_roughness() {
    for roughness in [0.0, 0.3, 1.0] {
        let terms = AlbedoSlice::new(1.0).terms(0.4, roughness);
        assert_eq!((terms.exact, terms.total), (0.0, isotropic_albedo::total(0.4, roughness)));
    }
}

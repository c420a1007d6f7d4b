use super::*;
use crate::film::{AovFlags, Film};

const ALL: SumFlags = SumFlags { moments: true, light: true, coverage: true, guides: true };

/// Adds samples of a grey value and of instance 4, of weight 1 each.
fn add(sums: &mut SampleSums, pixel: usize, values: &[f32]) {
    for &value in values {
        let mut share = ExactSum::default();
        share.add(1.0);
        for channel in 0..4 {
            sums.pixels[pixel].light[channel].add(value);
            let moments = &mut sums.moments.as_mut().unwrap()[pixel];
            moments.sums[channel].add(value);
            moments.squares[channel].add_square(value);
        }
        sums.light.as_mut().unwrap()[pixel][2][1].add(value);
        add_exact_share(&mut sums.coverage.as_mut().unwrap()[pixel], 4, share);
        sums.pixels[pixel].weight += 1;
        sums.pixels[pixel].count += 1;
    }
}

fn film(window: PixelWindow) -> Film {
    let flags = AovFlags { light: true, coverage: true, noise: true, guides: true, centers: false };
    Film::with_aovs((8, 8), window, flags)
}

#[test]
fn means_and_variances_are_those_of_the_samples() {
    let window = PixelWindow { x0: 1, y0: 2, x1: 3, y1: 3 };
    let mut sums = SampleSums::new(window, ALL);
    add(&mut sums, 1, &[0.0, 0.0, 1.0, 1.0]);
    let mut film = film(window);
    sums.resolve_into(&mut film);
    assert_eq!(film.pixels, [[0.0; 4], [0.5; 4]]);
    assert_eq!(film.aovs.light.unwrap()[1][2], [0.0, 0.5, 0.0]);
    assert_eq!(film.aovs.coverage.unwrap(), [vec![], vec![(4, 1.0)]]);
    // The variance of a sample is 1/3, that of the mean of four 1/12.
    let noise = film.aovs.noise.unwrap();
    assert_eq!((noise[0].samples, noise[1].samples), (0, 4));
    assert!((noise[1].variance[0] - 1.0 / 12.0).abs() < 1e-7, "{:?}", noise[1]);
}

#[test]
fn windows_are_merged_at_their_place() {
    let mut whole = SampleSums::new(PixelWindow::full(4, 3), ALL);
    let mut apart = whole.clone();
    let corner = PixelWindow { x0: 2, y0: 1, x1: 4, y1: 3 };
    for values in [&[0.1_f32, 7.0][..], &[1e-5, 300.0, 2.0]] {
        let mut part = SampleSums::new(corner, ALL);
        add(&mut part, 3, values);
        apart.merge(&part);
    }
    add(&mut whole, 11, &[300.0, 0.1, 1e-5, 2.0, 7.0]);
    assert_eq!(apart, whole);
}

#[test]
fn negative_weights_leave_no_negative_colour() {
    let window = PixelWindow::full(1, 1);
    let mut sums = SampleSums::new(window, ALL);
    add(&mut sums, 0, &[1.0, 1.0]);
    let pixel = &mut sums.pixels[0];
    pixel.light[0].add(-3.0);
    pixel.light[3].add(9.0);
    let mut film = film(window);
    sums.resolve_into(&mut film);
    assert_eq!(film.pixels, [[0.0, 1.0, 1.0, 1.0]]);
}

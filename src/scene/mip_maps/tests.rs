//! Mip levels of images with known means.

use super::*;

fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y));
    Image { name: None, width, height, texels: Texels::Rgba8(texels.collect()) }
}

fn texels8(level: &MipLevel) -> &[[u8; 4]] {
    match &level.texels {
        Texels::Rgba8(texels) => texels,
        Texels::Rgba16(_) => &[],
    }
}

#[test]
fn sizes_halve_down_to_one_texel() {
    for (width, height, sizes) in [
        (8, 2, vec![(4, 1), (2, 1), (1, 1)]),
        (7, 5, vec![(3, 2), (1, 1)]),
        (1, 6, vec![(1, 3), (1, 1)]),
        (1, 1, vec![]),
    ] {
        let levels = mip_levels(&image(width, height, |_, _| [9; 4]), Encoding::Linear);
        let found: Vec<_> = levels.iter().map(|level| (level.width, level.height)).collect();
        assert_eq!(found, sizes);
        let texels: u64 = sizes.iter().map(|&(width, height)| u64::from(width * height)).sum();
        assert_eq!(mip_bytes(width, height, 4), 4 * texels);
        // A constant image remains constant.
        assert!(levels.iter().all(|level| texels8(level).iter().all(|texel| *texel == [9; 4])));
    }
}

#[test]
fn means_are_taken_in_linear_light() {
    // Black and white squares: half the light is sRGB 188 (0.5029), half the number is 127.5, rounded up.
    let chequer = image(4, 4, |x, y| if (x + y) % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] });
    for level in mip_levels(&chequer, Encoding::Srgb) {
        assert!(texels8(&level).iter().all(|texel| *texel == [188, 188, 188, 255]));
    }
    for level in mip_levels(&chequer, Encoding::Linear) {
        assert!(texels8(&level).iter().all(|texel| *texel == [128, 128, 128, 255]));
    }
}

#[test]
fn rounding_does_not_add_up_over_levels() {
    // One texel of 64 is not black. With 30 the means are 7.5, 1.875 and 0.469, which is 0; rounded at every level they would
    // be 8, 2 and 0.5, which is 1.
    let dot = |value| image(8, 8, move |x, y| if (x, y) == (0, 0) { [value; 4] } else { [0; 4] });
    for (value, last) in [(255, 4), (33, 1), (30, 0)] {
        let levels = mip_levels(&dot(value), Encoding::Linear);
        assert_eq!(texels8(&levels[2]), [[last; 4]], "{value}");
    }
}

#[test]
fn odd_sizes_weight_all_texels_equally() {
    // Three texels become one: each has a weight of a third. Five become two, which share the middle one: the first texel of the
    // next level is (a + b + c/2) / 2.5.
    let row = [0, 90, 180, 30, 60_u8];
    let three = mip_levels(&image(3, 1, |x, _| [row[x as usize]; 4]), Encoding::Linear);
    assert_eq!(texels8(&three[0]), [[90; 4]]);
    let five = mip_levels(&image(5, 1, |x, _| [row[x as usize]; 4]), Encoding::Linear);
    assert_eq!(texels8(&five[0]), [[72; 4], [72; 4]]);
    for (old, new) in [(2, 1), (3, 1), (5, 2), (9, 4), (4096, 2048), (4095, 2047), (1, 1)] {
        let spans = spans(old, new);
        let mut covered = vec![0.0_f32; old as usize + 2];
        for span in &spans {
            assert!((span.shares.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            for (texel, share) in span.shares.iter().enumerate() {
                covered[span.first + texel] += share;
            }
        }
        let even = new as f32 / old as f32;
        assert!(covered[..old as usize].iter().all(|share| (share - even).abs() < 1e-6), "{old} {new}");
        assert_eq!(covered[old as usize..], [0.0, 0.0]);
    }
}

#[test]
fn transparent_texels_do_not_affect_the_colour() {
    // Three transparent black texels and one green leaf: the mean is green with a coverage of a quarter.
    let leaf = image(2, 2, |x, y| if (x, y) == (1, 0) { [0, 200, 0, 255] } else { [0; 4] });
    assert_eq!(texels8(&mip_levels(&leaf, Encoding::CoveredSrgb)[0]), [[0, 200, 0, 64]]);
    // Without coverage, alpha does not weight the mean.
    let plain = mip_levels(&leaf, Encoding::Srgb);
    assert!(texels8(&plain[0])[0][1] < 110);
    // Without any coverage all colours count equally; here they are equal.
    let ghost = image(4, 4, |_, _| [10, 20, 30, 0]);
    let levels = mip_levels(&ghost, Encoding::CoveredSrgb);
    assert_eq!(texels8(&levels[1]), [[10, 20, 30, 0]]);
}

#[test]
fn normals_are_averaged_as_directions() {
    // Two normals tilted by ±45° about Y average to +Z at unit length; so do two opposite ones.
    let tilted = image(2, 1, |x, _| if x == 0 { [218, 128, 218, 255] } else { [37, 128, 218, 255] });
    assert_eq!(texels8(&mip_levels(&tilted, Encoding::Normal)[0]), [[128, 128, 255, 255]]);
    let opposite = image(2, 1, |x, _| if x == 0 { [255, 128, 128, 255] } else { [0, 128, 128, 255] });
    let levels = mip_levels(&opposite, Encoding::Normal);
    let texel = texels8(&levels[0])[0];
    assert!(texel[0].abs_diff(128) <= 1 && texel[2] >= 128, "{texel:?}");
    // The length of a normal does not weight it: directions are (0, 0, 1) and (1, 0, 0), their mean 45°.
    let uneven = image(2, 1, |x, _| if x == 0 { [128, 128, 160, 255] } else { [255, 128, 128, 255] });
    let levels = mip_levels(&uneven, Encoding::Normal);
    let texel = texels8(&levels[0])[0];
    assert!(texel[0].abs_diff(218) <= 2 && texel[2].abs_diff(218) <= 2, "{texel:?}");
}

#[test]
fn sixteen_bit_images_have_sixteen_bit_levels() {
    let texels = Texels::Rgba16(vec![[0, 1000, 65535, 65535], [0, 1001, 0, 65535]]);
    let deep = Image { name: None, width: 2, height: 1, texels };
    let levels = mip_levels(&deep, Encoding::Linear);
    assert_eq!(levels[0].texels, Texels::Rgba16(vec![[0, 1001, 32768, 65535]]));
    let Texels::Rgba16(light) = &mip_levels(&deep, Encoding::Srgb)[0].texels else { panic!() };
    // Half the light is 0.73536 in sRGB.
    assert!((f32::from(light[0][2]) / 65535.0 - 0.735_36).abs() < 1e-4, "{light:?}");
}

#[test]
fn levels_do_not_depend_on_threads() {
    let noise = image(37, 19, |x, y| (x * 977 + y * 7919).wrapping_mul(2654435761).to_le_bytes());
    for encoding in [Encoding::Srgb, Encoding::CoveredSrgb, Encoding::Normal, Encoding::Linear] {
        let build = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| mip_levels(&noise, encoding))
        };
        assert_eq!(build(1), build(3));
    }
}

#[test]
fn even_sizes_have_the_bits_of_the_general_mean() {
    let noise = |x: u32, y: u32, channel: u32| {
        ((x * 73 + y * 151 + channel * 37).wrapping_mul(0x9e37_79b9) >> 24) as u8
    };
    let texel = |x: usize, y: usize| {
        let code = |channel: u32| noise(x as u32, y as u32, channel);
        let alpha = if (x + y).is_multiple_of(3) { 0 } else { code(3) };
        linear8([code(0), code(1), code(2), alpha])
    };
    let (columns, rows) = (spans(16, 8), spans(8, 4));
    for is_covered in [false, true] {
        for (y, row) in rows.iter().enumerate() {
            for (x, column) in columns.iter().enumerate() {
                let general = mean_of(*column, *row, is_covered, &texel);
                let found = mean_of_four([x * 2, y * 2], is_covered, &texel);
                assert_eq!(found.to_array().map(f32::to_bits), general.to_array().map(f32::to_bits));
            }
        }
    }
}

#[test]
fn blocks_have_the_bits_of_single_texels() {
    let noise =
        |x: u32, y: u32| (x * 977 + y * 7919 + 5).wrapping_mul(2_654_435_761).rotate_left(y).to_le_bytes();
    let (width, height) = (72, 4);
    let wide = image(width, height, noise);
    for encoding in [Encoding::Srgb, Encoding::CoveredSrgb, Encoding::Normal, Encoding::Linear] {
        let levels = mip_levels(&wide, encoding);
        // Strips of one and two texels have no blocks. The second level shows the means of the first.
        for (level, texels) in [(0, 2), (1, 4)] {
            let width = width / texels;
            for column in 0..width {
                let strip = image(texels, height, |x, y| noise(texels * column + x, y));
                let rows = texels8(&levels[level]).chunks(width as usize).map(|row| row[column as usize]);
                let expected = mip_levels(&strip, encoding);
                let found: Vec<_> = rows.collect();
                assert_eq!(found, texels8(&expected[level]), "{encoding:?} {level} {column}");
            }
        }
    }
}

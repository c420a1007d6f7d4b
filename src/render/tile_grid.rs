//! The grid of tiles of an image, and the order of pixels in a tile.

use crate::film::PixelWindow;

/// Side of a tile in pixels, a power of two. Tiles are aligned to its multiples in the whole image.
pub(crate) const TILE_SIZE: u32 = 32;

/// Cuts a window into tiles, row by row. The grid is fixed in the whole image.
pub(super) fn tiles(window: PixelWindow) -> Vec<PixelWindow> {
    let starts = |low: u32, high: u32| (low / TILE_SIZE * TILE_SIZE..high).step_by(TILE_SIZE as usize);
    let rows = starts(window.y0, window.y1);
    rows.flat_map(|y| starts(window.x0, window.x1).map(move |x| (x, y)))
        .map(|(x, y)| PixelWindow {
            x0: x.max(window.x0),
            y0: y.max(window.y0),
            x1: (x.saturating_add(TILE_SIZE)).min(window.x1),
            y1: (y.saturating_add(TILE_SIZE)).min(window.y1),
        })
        .collect()
}

/// Number of tiles of a window.
pub(crate) fn tile_count(window: PixelWindow) -> usize {
    let count = |low: u32, high: u32| high.div_ceil(TILE_SIZE).saturating_sub(low / TILE_SIZE) as usize;
    count(window.x0, window.x1) * count(window.y0, window.y1)
}

/// The pixels of a tile in Morton order, which visits aligned squares of every size one after the other.
pub(super) fn pixels_in_morton_order(tile: PixelWindow) -> impl Iterator<Item = (u32, u32)> {
    let corner = (tile.x0 / TILE_SIZE * TILE_SIZE, tile.y0 / TILE_SIZE * TILE_SIZE);
    (0..TILE_SIZE * TILE_SIZE)
        .map(move |code| (corner.0 + even_bits(code), corner.1 + even_bits(code >> 1)))
        .filter(move |&(x, y)| (tile.x0..tile.x1).contains(&x) && (tile.y0..tile.y1).contains(&y))
}

/// The even ones of the low sixteen bits, moved together.
fn even_bits(code: u32) -> u32 {
    let pairs = code & 0x5555;
    let nibbles = (pairs | pairs >> 1) & 0x3333;
    let bytes = (nibbles | nibbles >> 2) & 0x0f0f;
    (bytes | bytes >> 4) & 0x00ff
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_of_the_window_once() {
        for window in [
            PixelWindow::full(33, 17),
            PixelWindow { x0: 5, y0: 16, x1: 40, y1: 31 },
            PixelWindow { x0: 15, y0: 15, x1: 16, y1: 16 },
        ] {
            let mut count = 0;
            for tile in tiles(window) {
                assert!(tile.x0 < tile.x1 && tile.x1 <= window.x1 && tile.x0 >= window.x0);
                assert!(tile.y0 < tile.y1 && tile.y1 <= window.y1 && tile.y0 >= window.y0);
                assert_eq!(tile.x0 / TILE_SIZE, (tile.x1 - 1) / TILE_SIZE);
                count += tile.width() * tile.height();
            }
            assert_eq!(count, window.width() * window.height());
            assert_eq!(tiles(window).len(), tile_count(window));
        }
    }

    #[test]
    fn blocks_of_64_pixels_are_squares() {
        let tile = PixelWindow { x0: 32, y0: 64, x1: 64, y1: 96 };
        let pixels: Vec<_> = pixels_in_morton_order(tile).collect();
        assert_eq!(pixels.len(), 1024);
        for block in pixels.chunks(64) {
            let (left, top) = block[0];
            assert_eq!((left % 8, top % 8), (0, 0));
            assert!(block.iter().all(|&(x, y)| x / 8 == left / 8 && y / 8 == top / 8));
        }
        // So are blocks of 16 pixels, which hold four samples each.
        assert!(pixels[..16].iter().all(|&(x, y)| x < 36 && y < 68));
    }

    #[test]
    fn every_pixel_of_a_cut_tile_comes_once() {
        let tile = PixelWindow { x0: 35, y0: 31, x1: 61, y1: 32 };
        let mut pixels: Vec<_> = pixels_in_morton_order(tile).collect();
        pixels.sort_unstable();
        assert_eq!(pixels, (35..61).map(|x| (x, 31)).collect::<Vec<_>>());
    }
}

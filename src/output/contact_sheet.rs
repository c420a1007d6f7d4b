//! Contact sheet: small versions of all frames of a sequence in one image, with their numbers.

use crate::image_file::{DisplayImage, over};

/// Least and greatest width of a frame on the sheet, pixels.
pub(super) const TILE_WIDTH: (u32, u32) = (64, 320);
/// Width above which frames shrink instead of the sheet growing.
pub(super) const SHEET_WIDTH: u32 = 3840;
/// Pixels between frames.
pub(super) const GAP: u32 = 4;
/// Colour around and between frames.
pub(super) const GROUND: [u8; 3] = [24; 3];
/// Colours of numbers and of their background.
const INK: [u8; 4] = [240, 240, 240, 255];
const PAPER: [u8; 4] = [0, 0, 0, 255];
/// Pixels of a dot of a digit, each way.
const DOT: u32 = 2;
/// Columns and rows of dots of a digit.
const GLYPH: (u32, u32) = (3, 5);

/// A contact sheet to which frames are added.
#[derive(Clone, Debug)]
pub struct ContactSheet {
    tile: (u32, u32),
    columns: u32,
    added: u32,
    sheet: DisplayImage,
}

impl ContactSheet {
    /// An empty sheet for `count` frames of one size, with about as many rows as columns.
    pub fn new(count: u32, frame_size: (u32, u32)) -> Self {
        let mut columns = 1;
        while columns * columns < count.max(1) {
            columns += 1;
        }
        let widest = (SHEET_WIDTH / columns).clamp(TILE_WIDTH.0, TILE_WIDTH.1);
        let width = widest.min(frame_size.0).max(1);
        let height = u64::from(frame_size.1) * u64::from(width) / u64::from(frame_size.0.max(1));
        let tile = (width, (height as u32).max(1));
        let rows = count.max(1).div_ceil(columns);
        let size = (GAP + columns * (tile.0 + GAP), GAP + rows * (tile.1 + GAP));
        let pixels = vec![over([0; 4], GROUND); size.0 as usize * size.1 as usize];
        Self { tile, columns, added: 0, sheet: DisplayImage { size, pixels } }
    }

    /// Adds the image of `frame` at the next position.
    pub fn add(&mut self, frame: i64, image: &DisplayImage) {
        let (column, row) = (self.added % self.columns, self.added / self.columns);
        let corner = (GAP + column * (self.tile.0 + GAP), GAP + row * (self.tile.1 + GAP));
        self.added += 1;
        let small = image.reduced(self.tile);
        for (index, pixel) in small.pixels.iter().enumerate() {
            let index = index as u32;
            self.set(
                (corner.0 + index % small.size.0, corner.1 + index / small.size.0),
                over(*pixel, GROUND),
            );
        }
        self.write(&frame.to_string(), (corner.0 + 2, corner.1 + 2));
    }

    /// The sheet with the frames added so far.
    pub fn image(&self) -> &DisplayImage {
        &self.sheet
    }

    /// Draws digits and a minus sign.
    fn write(&mut self, text: &str, corner: (u32, u32)) {
        let advance = (GLYPH.0 + 1) * DOT;
        for (place, character) in text.chars().enumerate() {
            let left = corner.0 + place as u32 * advance;
            for y in 0..(GLYPH.1 + 2) * DOT {
                for x in 0..advance + DOT {
                    self.set((left + x, corner.1 + y), PAPER);
                }
            }
            for (y, row) in glyph_rows(character).into_iter().enumerate() {
                for x in (0..GLYPH.0).filter(|x| row >> (GLYPH.0 - 1 - x) & 1 == 1) {
                    for dot in 0..DOT * DOT {
                        let at = ((x + 1) * DOT + dot % DOT, (y as u32 + 1) * DOT + dot / DOT);
                        self.set((left + at.0, corner.1 + at.1), INK);
                    }
                }
            }
        }
    }

    fn set(&mut self, (x, y): (u32, u32), pixel: [u8; 4]) {
        if x < self.sheet.size.0 && y < self.sheet.size.1 {
            self.sheet.pixels[y as usize * self.sheet.size.0 as usize + x as usize] = pixel;
        }
    }
}

/// Rows of dots of a character, the leftmost dot in the highest of three bits.
fn glyph_rows(character: char) -> [u8; 5] {
    match character {
        '0' => [0b111, 0b101, 0b101, 0b101, 0b111],
        '1' => [0b010, 0b110, 0b010, 0b010, 0b111],
        '2' => [0b111, 0b001, 0b111, 0b100, 0b111],
        '3' => [0b111, 0b001, 0b111, 0b001, 0b111],
        '4' => [0b101, 0b101, 0b111, 0b001, 0b001],
        '5' => [0b111, 0b100, 0b111, 0b001, 0b111],
        '6' => [0b111, 0b100, 0b111, 0b101, 0b111],
        '7' => [0b111, 0b001, 0b010, 0b010, 0b010],
        '8' => [0b111, 0b101, 0b111, 0b101, 0b111],
        '9' => [0b111, 0b101, 0b111, 0b001, 0b111],
        '-' => [0b000, 0b000, 0b111, 0b000, 0b000],
        _ => [0; 5],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_lie_in_rows_with_their_numbers() {
        let size = (64, 36);
        let plain = |value: u8| DisplayImage { size, pixels: vec![[value, value, value, 255]; 64 * 36] };
        let mut sheet = ContactSheet::new(5, size);
        for frame in 0..5_u8 {
            sheet.add(i64::from(frame) - 1, &plain(40 + frame * 40));
        }
        // Three columns and two rows; the last position stays empty.
        let image = sheet.image();
        assert_eq!(image.size, (4 + 3 * 68, 4 + 2 * 40));
        let at = |x: u32, y: u32| image.pixels[(y * image.size.0 + x) as usize];
        assert_eq!(at(4 + 60, 4 + 30), [40, 40, 40, 255]);
        assert_eq!(at(4 + 68 + 60, 4 + 40 + 30), [200, 200, 200, 255]);
        assert_eq!(at(4 + 2 * 68 + 30, 4 + 40 + 20), [24, 24, 24, 255]);
        // The number 0 has a hollow middle and a black frame.
        let ink =
            (0..12).flat_map(|y| (0..12).map(move |x| (x, y))).filter(|&(x, y)| at(74 + x, 6 + y) == INK);
        assert_eq!(ink.count() as u32, 12 * DOT * DOT);
    }

    #[test]
    fn sheets_of_many_frames_stay_small() {
        assert_eq!(ContactSheet::new(400, (1920, 1080)).tile, (192, 108));
        assert_eq!(ContactSheet::new(1, (16, 9)).tile, (16, 9));
        assert!(ContactSheet::new(9999, (1920, 1080)).image().size.0 < 8000);
    }
}

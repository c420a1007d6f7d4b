//! Contact sheet of images of different sizes, each with a text below it.

use crate::image_file::{DisplayImage, over};

use super::bitmap_font::{GLYPH, columns};
use super::contact_sheet::{GAP, GROUND, SHEET_WIDTH, TILE_WIDTH};

/// Greatest height of an image on the sheet, pixels.
const TILE_HEIGHT: u32 = 240;
/// Size of an empty tile where no image says another.
const EMPTY_TILE: (u32, u32) = (160, 90);
/// Colour of an empty tile.
const EMPTY: [u8; 4] = [64, 16, 16, 255];
/// Colour of texts.
const INK: [u8; 4] = [240, 240, 240, 255];
/// Pixels of a dot of the font, each way, where the text fits.
const DOT: u32 = 2;
/// Height of a text with its margin, pixels.
const TEXT_HEIGHT: u32 = GLYPH.1 * DOT + 4;

/// An image of a sheet, and its text.
#[derive(Clone, Debug)]
pub struct LabelledTile {
    label: String,
    image: Option<DisplayImage>,
}

/// Tiles in rows, about as many as there are columns.
#[derive(Clone, Debug, Default)]
pub struct LabelledSheet {
    tiles: Vec<LabelledTile>,
}

impl LabelledTile {
    /// A tile of a small version of `image`; an empty one without an image.
    pub fn new(label: String, image: Option<&DisplayImage>) -> Self {
        Self { label, image: image.map(|image| fitted(image, (TILE_WIDTH.1, TILE_HEIGHT))) }
    }
}

impl LabelledSheet {
    /// Adds a tile at the next position.
    pub fn add(&mut self, tile: LabelledTile) {
        self.tiles.push(tile);
    }

    /// The sheet.
    pub fn image(&self) -> DisplayImage {
        let count = (self.tiles.len() as u32).max(1);
        let across = (1..=count).find(|across| across * across >= count).unwrap_or(count);
        let widest = (SHEET_WIDTH / across).clamp(TILE_WIDTH.0, TILE_WIDTH.1);
        let images: Vec<_> = self
            .tiles
            .iter()
            .map(|tile| tile.image.as_ref().map(|image| fitted(image, (widest, TILE_HEIGHT))))
            .collect();

        // All cells have the size of the largest image.
        let sizes = images.iter().flatten().map(|image| image.size);
        let largest = sizes.reduce(|a, b| (a.0.max(b.0), a.1.max(b.1))).unwrap_or(EMPTY_TILE);
        let cell = (largest.0.max(TILE_WIDTH.0), largest.1 + TEXT_HEIGHT);
        let rows = count.div_ceil(across);
        let size = (GAP + across * (cell.0 + GAP), GAP + rows * (cell.1 + GAP));
        let pixels = vec![over([0; 4], GROUND); size.0 as usize * size.1 as usize];
        let mut sheet = DisplayImage { size, pixels };

        // Small dots where a text is long.
        let longest = self.tiles.iter().map(|tile| tile.label.chars().count()).max().unwrap_or(0);
        let dot = if longest <= fitting(cell.0, DOT) { DOT } else { 1 };
        for (index, (tile, image)) in self.tiles.iter().zip(&images).enumerate() {
            let (column, row) = (index as u32 % across, index as u32 / across);
            let corner = (GAP + column * (cell.0 + GAP), GAP + row * (cell.1 + GAP));
            match image {
                Some(image) => blit(&mut sheet, image, corner, (cell.0, largest.1)),
                None => fill(&mut sheet, corner, (cell.0, largest.1)),
            }
            write_text(&mut sheet, &tile.label, (corner.0, corner.1 + largest.1 + 2), cell.0, dot);
        }
        sheet
    }
}

/// The image in at most `size`, with its aspect ratio.
fn fitted(image: &DisplayImage, size: (u32, u32)) -> DisplayImage {
    let (width, height) = (u64::from(image.size.0.max(1)), u64::from(image.size.1.max(1)));
    let (most_width, most_height) = (u64::from(size.0), u64::from(size.1));
    if width <= most_width && height <= most_height {
        return image.clone();
    }
    let fitted = if width * most_height >= height * most_width {
        (most_width, (height * most_width / width).max(1))
    } else {
        ((width * most_height / height).max(1), most_height)
    };
    image.reduced((fitted.0 as u32, fitted.1 as u32))
}

/// Draws an image in the middle of a cell.
fn blit(sheet: &mut DisplayImage, image: &DisplayImage, corner: (u32, u32), cell: (u32, u32)) {
    let (left, top) = (corner.0 + (cell.0 - image.size.0) / 2, corner.1 + (cell.1 - image.size.1) / 2);
    for (index, pixel) in image.pixels.iter().enumerate() {
        let index = index as u32;
        let at = (left + index % image.size.0, top + index / image.size.0);
        set(sheet, at, over(*pixel, GROUND));
    }
}

fn fill(sheet: &mut DisplayImage, corner: (u32, u32), cell: (u32, u32)) {
    for y in 0..cell.1 {
        for x in 0..cell.0 {
            set(sheet, (corner.0 + x, corner.1 + y), EMPTY);
        }
    }
}

/// Characters that fit into `width` pixels.
fn fitting(width: u32, dot: u32) -> usize {
    (width / ((GLYPH.0 + 1) * dot)) as usize
}

/// The text, without its middle where it has more than `longest` characters: its end may be what tells it from others.
fn shortened(text: &str, longest: usize) -> String {
    let count = text.chars().count();
    if count <= longest {
        return text.to_owned();
    }
    let kept = longest.saturating_sub(2);
    let end = kept / 3;
    text.chars().take(kept - end).chain("..".chars()).chain(text.chars().skip(count - end)).collect()
}

/// Draws a text in one line of `width` pixels, shortened where it is longer.
fn write_text(sheet: &mut DisplayImage, text: &str, corner: (u32, u32), width: u32, dot: u32) {
    for (place, character) in shortened(text, fitting(width, dot)).chars().enumerate() {
        let left = corner.0 + place as u32 * (GLYPH.0 + 1) * dot;
        for (x, column) in columns(character).into_iter().enumerate() {
            for y in (0..GLYPH.1).filter(|y| column >> y & 1 == 1) {
                for part in 0..dot * dot {
                    let at = (left + x as u32 * dot + part % dot, corner.1 + y * dot + part / dot);
                    set(sheet, at, INK);
                }
            }
        }
    }
}

fn set(sheet: &mut DisplayImage, (x, y): (u32, u32), pixel: [u8; 4]) {
    if x < sheet.size.0 && y < sheet.size.1 {
        sheet.pixels[y as usize * sheet.size.0 as usize + x as usize] = pixel;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(size: (u32, u32)) -> DisplayImage {
        DisplayImage { size, pixels: vec![[200, 200, 200, 255]; size.0 as usize * size.1 as usize] }
    }

    #[test]
    fn images_of_any_size_share_a_grid() {
        let mut sheet = LabelledSheet::default();
        for (label, size) in [("wide", (100, 50)), ("tall", (40, 80)), ("big", (1280, 720))] {
            sheet.add(LabelledTile::new(label.to_owned(), Some(&plain(size))));
        }
        sheet.add(LabelledTile::new("broken".to_owned(), None));
        let image = sheet.image();
        // Two columns and two rows of cells as large as the largest tile, 320x180, and the text.
        assert_eq!(image.size, (4 + 2 * 324, 4 + 2 * (180 + TEXT_HEIGHT + 4)));
        let at = |x: u32, y: u32| image.pixels[(y * image.size.0 + x) as usize];
        // Each is in the middle of its cell.
        assert_eq!((at(4 + 160, 4 + 90), at(4 + 60, 4 + 90)), ([200, 200, 200, 255], [24, 24, 24, 255]));
        assert_eq!((at(328 + 160, 4 + 52), at(328 + 130, 4 + 90)), ([200, 200, 200, 255], [24, 24, 24, 255]));
        assert_eq!(at(328 + 5, 4 + 180 + TEXT_HEIGHT + 4 + 5), EMPTY);
        let ink = |left: u32| {
            let row = 4 + 180..4 + 180 + TEXT_HEIGHT;
            row.flat_map(|y| (left..left + 320).map(move |x| (x, y)))
                .filter(|&(x, y)| at(x, y) == INK)
                .count()
        };
        let dots = |text: &str| text.chars().flat_map(columns).map(u8::count_ones).sum::<u32>() as usize;
        assert_eq!(ink(4), dots("wide") * 4);
        assert_eq!(ink(328), dots("tall") * 4);
    }

    #[test]
    fn long_texts_lose_their_middle() {
        assert_eq!(shortened("walk / red", 10), "walk / red");
        assert_eq!(shortened("camera (2) / red (2)", 14), "camera (.. (2)");
        assert_eq!(shortened("äöüäöüäöü", 8), "äöüä..öü");
        assert_eq!([3, 2, 1].map(|longest| shortened("walking", longest)), ["w..", "..", ".."]);
    }

    #[test]
    fn long_texts_are_cut_and_many_tiles_shrink() {
        let mut sheet = LabelledSheet::default();
        let tile = LabelledTile::new("x".repeat(1000), Some(&plain((640, 360))));
        for _ in 0..400 {
            sheet.add(tile.clone());
        }
        let image = sheet.image();
        assert_eq!(image.size.0, 4 + 20 * (192 + 4));
        assert_eq!(LabelledSheet::default().image().size, (4 + 164, 4 + 90 + TEXT_HEIGHT + 4));
    }
}

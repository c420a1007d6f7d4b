//! Images on a terminal: by a graphics protocol where the terminal has one, or else as coloured half blocks.
//!
//! Sources: the terminal graphics protocol of kitty (also Ghostty, Konsole, `WezTerm`), the inline images protocol of iTerm2, and
//! 24-bit colours of ISO 8613-6.

use std::fmt::Write as _;
use std::io::IsTerminal as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use rayframe::image_file::{DisplayImage, encode_png, over};

/// Greatest width of an image sent to the terminal, pixels.
const WIDEST: u32 = 480;
/// Greatest width in half blocks, columns.
const COLUMNS: u32 = 72;
/// Characters of one chunk of kitty's protocol.
const CHUNK: usize = 4096;

/// Way of showing images on a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TerminalImages {
    /// Graphics protocol of kitty.
    Kitty,
    /// Inline images protocol of iTerm2.
    Iterm,
    /// Half blocks in 24-bit colours.
    HalfBlocks,
}

impl TerminalImages {
    /// Way of the terminal on the standard error stream, as its environment variables tell; `None` without a terminal or with
    /// few colours.
    pub(crate) fn of_stderr() -> Option<Self> {
        if !std::io::stderr().is_terminal() {
            return None;
        }
        Self::of_environment(|name| std::env::var(name).ok())
    }

    fn of_environment(variable: impl Fn(&str) -> Option<String>) -> Option<Self> {
        let value = |name: &str| variable(name).unwrap_or_default();
        let (term, program) = (value("TERM"), value("TERM_PROGRAM"));
        let is_kitty = term.contains("kitty") || !value("KITTY_WINDOW_ID").is_empty();
        // Terminal multiplexers pass neither protocol on.
        let is_direct = value("TMUX").is_empty() && !term.starts_with("screen");
        if is_direct && (is_kitty || matches!(program.as_str(), "ghostty" | "WezTerm")) {
            return Some(Self::Kitty);
        }
        if is_direct && matches!(program.as_str(), "iTerm.app" | "mintty") {
            return Some(Self::Iterm);
        }
        let colors = value("COLORTERM");
        (colors == "truecolor" || colors == "24bit" || term.ends_with("-direct")).then_some(Self::HalfBlocks)
    }

    /// Text that shows an image, with a newline; empty where the image cannot be encoded.
    pub(crate) fn text(self, image: &DisplayImage) -> String {
        match self {
            Self::HalfBlocks => half_blocks(&narrowed(image, COLUMNS)),
            Self::Kitty | Self::Iterm => {
                let small = narrowed(image, WIDEST);
                let Ok(png) = encode_png(small.size, &small.pixels, "") else {
                    return String::new();
                };
                let encoded = STANDARD.encode(&png);
                if self == Self::Kitty { kitty(&encoded) } else { iterm(&encoded, png.len()) }
            }
        }
    }
}

fn narrowed(image: &DisplayImage, widest: u32) -> DisplayImage {
    let (width, height) = image.size;
    let new_width = width.min(widest).max(1);
    let new_height = (u64::from(height) * u64::from(new_width) / u64::from(width.max(1))) as u32;
    image.reduced((new_width, new_height.max(1)))
}

fn kitty(encoded: &str) -> String {
    let mut text = String::new();
    let mut keys = "a=T,f=100,";
    let mut rest = encoded;
    while !rest.is_empty() {
        let (chunk, after) = rest.split_at(rest.len().min(CHUNK));
        let more = u8::from(!after.is_empty());
        let _ = write!(text, "\x1b_G{keys}m={more};{chunk}\x1b\\");
        (rest, keys) = (after, "");
    }
    text.push('\n');
    text
}

fn iterm(encoded: &str, bytes: usize) -> String {
    format!("\x1b]1337;File=inline=1;size={bytes}:{encoded}\x07\n")
}

/// Terminals are mostly dark.
const BLACK: [u8; 3] = [0; 3];

/// Text of two pixels a character, one above the other.
fn half_blocks(image: &DisplayImage) -> String {
    let width = image.size.0.max(1) as usize;
    let mut text = String::new();
    let rows: Vec<&[[u8; 4]]> = image.pixels.chunks(width).collect();
    for pair in rows.chunks(2) {
        for (column, upper) in pair[0].iter().enumerate() {
            let [r, g, b, _] = over(*upper, BLACK);
            let _ = write!(text, "\x1b[38;2;{r};{g};{b}m");
            if let Some(lower) = pair.get(1).and_then(|row| row.get(column)) {
                let [r, g, b, _] = over(*lower, BLACK);
                let _ = write!(text, "\x1b[48;2;{r};{g};{b}m");
            }
            text.push('▀');
        }
        text.push_str("\x1b[0m\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminals_are_recognised_by_their_environment() {
        let of = |pairs: &[(&str, &str)]| {
            TerminalImages::of_environment(|name| {
                pairs.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned())
            })
        };
        assert_eq!(of(&[("TERM", "xterm-kitty")]), Some(TerminalImages::Kitty));
        assert_eq!(of(&[("TERM_PROGRAM", "iTerm.app")]), Some(TerminalImages::Iterm));
        assert_eq!(
            of(&[("TERM", "xterm-256color"), ("COLORTERM", "truecolor")]),
            Some(TerminalImages::HalfBlocks)
        );
        let multiplexed = [("KITTY_WINDOW_ID", "1"), ("TMUX", "/tmp/x"), ("COLORTERM", "24bit")];
        assert_eq!(of(&multiplexed), Some(TerminalImages::HalfBlocks));
        assert_eq!(of(&[("TERM", "vt100")]), None);
    }

    #[test]
    fn half_blocks_hold_two_rows_a_line() {
        let pixels = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [9, 9, 9, 0], [1; 4], [2; 4]];
        let text = half_blocks(&DisplayImage { size: (2, 3), pixels });
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines.len(), 2);
        assert!(
            lines[0].starts_with("\x1b[38;2;255;0;0m\x1b[48;2;0;0;255m▀\x1b[38;2;0;255;0m\x1b[48;2;0;0;0m▀")
        );
        assert!(!lines[1].contains("[48;") && lines[1].ends_with("\x1b[0m"));
    }

    #[test]
    fn images_are_sent_in_chunks_that_say_whether_more_follow() {
        let noise = (0..200 * 100_u32).map(|i| i.wrapping_mul(2_654_435_761).to_le_bytes()).collect();
        let image = DisplayImage { size: (200, 100), pixels: noise };
        let text = TerminalImages::Kitty.text(&image);
        let chunks: Vec<_> = text.split("\x1b\\").filter(|chunk| chunk.starts_with("\x1b_G")).collect();
        assert!(chunks.len() > 2 && chunks[0].starts_with("\x1b_Ga=T,f=100,m=1;"));
        assert!(chunks[1].starts_with("\x1b_Gm=1;") && chunks[chunks.len() - 1].starts_with("\x1b_Gm=0;"));
        assert!(TerminalImages::Iterm.text(&image).starts_with("\x1b]1337;File=inline=1;size="));
    }
}

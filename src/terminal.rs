//! Characters that mislead on a terminal.

/// Whether a terminal obeys the character, reorders text by it, or shows nothing: control characters, bidirectional controls, zero-width
/// characters, separators of lines and tags.
pub fn misleads(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

//! Portable float maps: three 32-bit floats a pixel, rows from the bottom (Debevec, "The PFM Portable FloatMap Image Format").

/// Encodes pixels, given row by row from the top. Values that are not finite become 0.
pub(super) fn encode((width, height): (u32, u32), pixels: &[[f32; 3]]) -> Vec<u8> {
    let mut bytes = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
    bytes.reserve(size_of_val(pixels));
    for row in pixels.chunks(width.max(1) as usize).rev() {
        for value in row.as_flattened() {
            let value = if value.is_finite() { *value } else { 0.0 };
            bytes.extend_from_slice(&value.to_le_bytes());
        }
    }
    bytes
}

/// Decodes little-endian pixels; `None` for anything else and for another size.
pub(super) fn decode((width, height): (u32, u32), bytes: &[u8]) -> Option<Vec<[f32; 3]>> {
    let (kind, rest) = line(bytes)?;
    let (size, rest) = line(rest)?;
    let (scale, values) = line(rest)?;
    let is_little_endian = scale.trim().parse::<f32>().is_ok_and(|scale| scale < 0.0);
    let expected = format!("{width} {height}");
    let row_bytes = width as usize * size_of::<[f32; 3]>();
    let is_whole = values.len() == row_bytes * height as usize;
    if kind.trim() != "PF" || size.trim() != expected || !is_little_endian || !is_whole {
        return None;
    }
    let float = |bytes: &[u8]| bytes.try_into().map_or(0.0, f32::from_le_bytes);
    let pixel = |bytes: &[u8]| [float(&bytes[..4]), float(&bytes[4..8]), float(&bytes[8..])];
    let rows = values.chunks_exact(row_bytes.max(1)).rev();
    Some(rows.flat_map(|row| row.chunks_exact(size_of::<[f32; 3]>()).map(pixel)).collect())
}

fn line(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let end = bytes.iter().position(|&byte| byte == b'\n')?;
    Some((std::str::from_utf8(&bytes[..end]).ok()?, &bytes[end + 1..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_stored_from_the_bottom() {
        let pixels = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0], [0.5, f32::NAN, -1.0]];
        let bytes = encode((2, 2), &pixels);
        assert!(bytes.starts_with(b"PF\n2 2\n-1.0\n"));
        assert_eq!(bytes[12..16], 7.0_f32.to_le_bytes());
        let stored = decode((2, 2), &bytes).unwrap();
        assert_eq!((stored[..3].to_vec(), stored[3]), (pixels[..3].to_vec(), [0.5, 0.0, -1.0]));
    }

    #[test]
    fn other_sizes_and_truncated_files_are_refused() {
        let bytes = encode((2, 1), &[[1.0; 3]; 2]);
        assert!(decode((1, 2), &bytes).is_none());
        for length in 0..bytes.len() {
            assert!(decode((2, 1), &bytes[..length]).is_none(), "{length}");
        }
    }
}

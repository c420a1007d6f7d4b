//! Attribute codec: elements split into byte planes, byte planes into deltas, deltas into groups of sixteen.
//!
//! Source: *KHR_meshopt_compression* (Khronos Group), appendix A, mode 0, versions 0 and 1.

use super::reader::{Malformed, Reader};

/// Bytes of one channel of an element.
const CHANNEL_BYTES: usize = 4;
/// Number of deltas that share one bit width.
const GROUP: usize = 16;
/// Largest number of elements in a block.
const BLOCK_ELEMENTS: usize = 256;
/// Largest number of bytes in a block.
const BLOCK_BYTES: usize = 8192;

/// Deltas of one byte position over a block.
type Plane = [u8; BLOCK_ELEMENTS];

/// Stream split into its header, body and tail.
struct Stream<'a> {
    /// Whether blocks begin with a control header.
    has_control: bool,
    body: Reader<'a>,
    /// Predecessor of the first element.
    baseline: &'a [u8],
    /// Mode of each channel; empty in version 0, where every mode is 0.
    channel_modes: &'a [u8],
}

/// Decodes `count` elements of `stride` bytes, a multiple of four up to 256, and appends them to `output`.
pub(super) fn decode(
    bytes: &[u8],
    count: usize,
    stride: usize,
    output: &mut Vec<u8>,
) -> Result<(), Malformed> {
    let mut stream = open(bytes, stride)?;
    let max_elements = BLOCK_BYTES.checked_div(stride).unwrap_or(0) & !(GROUP.wrapping_sub(1));
    let max_elements = max_elements.clamp(GROUP, BLOCK_ELEMENTS);
    let mut previous = stream.baseline.to_vec();
    let mut remaining = count;
    while remaining > 0 {
        let elements = remaining.min(max_elements);
        decode_block(&mut stream, elements, &mut previous, output)?;
        remaining = remaining.saturating_sub(elements);
    }
    stream.body.finish()
}

/// Splits off the header byte and the tail.
fn open(bytes: &[u8], stride: usize) -> Result<Stream<'_>, Malformed> {
    let channels = stride.div_ceil(CHANNEL_BYTES);
    let (has_control, mode_bytes, min_tail) = match bytes.first() {
        Some(0xa0) => (false, 0, 32),
        Some(0xa1) => (true, channels, 24),
        _ => return Err(Malformed("does not begin with the header of the attribute codec")),
    };
    let tail = stride.saturating_add(mode_bytes);
    let body_end = bytes.len().checked_sub(tail.max(min_tail));
    let tail_start = bytes.len().checked_sub(tail);
    let (Some(body), Some((baseline, channel_modes))) = (
        body_end.and_then(|end| bytes.get(1..end)),
        tail_start.and_then(|start| bytes.get(start..)?.split_at_checked(stride)),
    ) else {
        return Err(Malformed::TRUNCATED);
    };
    // Byte and 16-bit deltas have no parameter. XOR deltas have a rotation.
    if channel_modes.iter().any(|mode| !(matches!(mode, 0 | 1) || mode & 15 == 2)) {
        return Err(Malformed("has an unknown channel mode"));
    }
    Ok(Stream { has_control, body: Reader::new(body), baseline, channel_modes })
}

/// Decodes `elements` elements that follow `previous`, and sets `previous` to the last of them.
fn decode_block(
    stream: &mut Stream,
    elements: usize,
    previous: &mut [u8],
    output: &mut Vec<u8>,
) -> Result<(), Malformed> {
    let stride = previous.len();
    let control_bytes = if stream.has_control { stride.div_ceil(CHANNEL_BYTES) } else { 0 };
    let control = stream.body.take(control_bytes)?;
    let start = output.len();
    output.resize(start.saturating_add(elements.saturating_mul(stride)), 0);
    let rows = output.get_mut(start..).unwrap_or_default();
    for (channel, previous) in previous.chunks_exact_mut(CHANNEL_BYTES).enumerate() {
        let control = control.get(channel).copied();
        let mut planes = [[0_u8; BLOCK_ELEMENTS]; CHANNEL_BYTES];
        for (byte, plane) in planes.iter_mut().enumerate() {
            let mode = control.map(|control| two_bits(control, byte));
            read_plane(&mut stream.body, mode, elements, plane)?;
        }
        let mode = stream.channel_modes.get(channel).copied().unwrap_or(0);
        let mut value: [u8; CHANNEL_BYTES] = previous.first_chunk().copied().unwrap_or_default();
        for (i, row) in rows.chunks_exact_mut(stride).enumerate() {
            let delta = planes.each_ref().map(|plane| plane.get(i).copied().unwrap_or(0));
            value = add_delta(value, delta, mode);
            let (slots, _) = row.as_chunks_mut::<CHANNEL_BYTES>();
            if let Some(slot) = slots.get_mut(channel) {
                *slot = value;
            }
        }
        previous.copy_from_slice(&value);
    }
    Ok(())
}

/// Reads the deltas of one byte position; `mode` comes from the control header.
fn read_plane(
    body: &mut Reader,
    mode: Option<u8>,
    elements: usize,
    plane: &mut Plane,
) -> Result<(), Malformed> {
    let widths = match mode {
        None => [0, 2, 4, 8],
        Some(0) => [0, 1, 2, 4],
        Some(1) => [1, 2, 4, 8],
        Some(2) => return Ok(()),
        Some(_) => {
            let bytes = body.take(elements)?;
            plane.iter_mut().zip(bytes).for_each(|(slot, byte)| *slot = *byte);
            return Ok(());
        }
    };
    let groups = elements.div_ceil(GROUP);
    let header = body.take(groups.div_ceil(4))?;
    let (slots, _) = plane.as_chunks_mut::<GROUP>();
    for (i, group) in slots.iter_mut().take(groups).enumerate() {
        let byte = header.get(i / 4).copied().unwrap_or(0);
        let code = two_bits(byte, i & 3);
        let width = widths.get(usize::from(code)).copied().unwrap_or(0);
        read_group(body, width, group)?;
    }
    Ok(())
}

/// Bit pair `index` of a byte, counted from the lowest.
fn two_bits(byte: u8, index: usize) -> u8 {
    let shift = u32::try_from(index).unwrap_or(u32::MAX).saturating_mul(2);
    byte.checked_shr(shift).unwrap_or(0) & 3
}

/// Reads sixteen deltas of `width` bits. A delta with all bits set is an escape for a whole byte after the group.
fn read_group(body: &mut Reader, width: u32, group: &mut [u8; GROUP]) -> Result<(), Malformed> {
    if width == 0 {
        return Ok(());
    }
    if width == 8 {
        let bytes = body.take(GROUP)?;
        group.copy_from_slice(bytes);
        return Ok(());
    }
    let packed = body.take((width as usize).saturating_mul(2))?;
    let sentinel = u8::MAX.checked_shr(8_u32.saturating_sub(width)).unwrap_or(0);
    for (i, slot) in group.iter_mut().enumerate() {
        let bit = (i as u32).saturating_mul(width);
        let byte = packed.get((bit / 8) as usize).copied().unwrap_or(0);
        // One-bit deltas start at the lowest bit of a byte, wider ones at the highest.
        let within = bit & 7;
        let shift = if width == 1 { within } else { 8_u32.saturating_sub(width).saturating_sub(within) };
        let value = byte.checked_shr(shift).unwrap_or(0) & sentinel;
        *slot = if value == sentinel { body.byte()? } else { value };
    }
    Ok(())
}

/// The value that follows `value`.
fn add_delta(value: [u8; 4], delta: [u8; 4], mode: u8) -> [u8; 4] {
    match mode & 15 {
        0 => {
            let mut sum = value;
            for (byte, delta) in sum.iter_mut().zip(delta) {
                let half = delta >> 1;
                *byte = byte.wrapping_add(if delta & 1 == 0 { half } else { !half });
            }
            sum
        }
        1 => {
            let pair = |[low, high]: [u8; 2], delta: [u8; 2]| {
                let delta = u16::from_le_bytes(delta);
                let half = delta >> 1;
                let step = if delta & 1 == 0 { half } else { !half };
                u16::from_le_bytes([low, high]).wrapping_add(step).to_le_bytes()
            };
            let [a, b, c, d] = value;
            let [e, f, g, h] = delta;
            let ([low0, high0], [low1, high1]) = (pair([a, b], [e, f]), pair([c, d], [g, h]));
            [low0, high0, low1, high1]
        }
        _ => {
            let rotated = u32::from_le_bytes(delta).rotate_right(u32::from(mode >> 4));
            (u32::from_le_bytes(value) ^ rotated).to_le_bytes()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worked example of the specification: sixteen four-bit deltas.
    #[test]
    fn the_example_of_the_specification_is_decoded() {
        let bytes = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut group = [0; GROUP];
        let mut body = Reader::new(&bytes);
        read_group(&mut body, 4, &mut group).unwrap();
        body.finish().unwrap();
        let steps = group.map(|delta| add_delta([0; 4], [delta, 0, 0, 0], 0)[0] as i8);
        assert_eq!(steps, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
    }

    #[test]
    fn one_bit_deltas_start_at_the_lowest_bit() {
        // Bits 1, 0, 0 ... and 0 ... 0, 1: the first and the last delta are whole bytes.
        let mut group = [0; GROUP];
        read_group(&mut Reader::new(&[0x01, 0x80, 7, 9]), 1, &mut group).unwrap();
        let mut expected = [0; GROUP];
        (expected[0], expected[15]) = (7, 9);
        assert_eq!(group, expected);
    }

    #[test]
    fn sixteen_bit_deltas_carry_and_xor_deltas_rotate() {
        // 0x00ff + 1 = 0x0100; 0x0000 − 1 = 0xffff: zigzag 2 and 1.
        assert_eq!(add_delta([0xff, 0, 0, 0], [2, 0, 1, 0], 1), [0, 1, 0xff, 0xff]);
        assert_eq!(add_delta([1, 0, 0, 0], [0, 0, 0, 0x80], 2), [1, 0, 0, 0x80]);
    }

    #[test]
    fn elements_continue_from_the_baseline() {
        // Version 0, one element of four bytes: all deltas are zero except that of the first byte, which is stored whole.
        let mut bytes = vec![0xa0];
        bytes.extend([3, 4]);
        bytes.extend([0; 15]);
        bytes.extend([0, 0, 0]);
        bytes.resize(bytes.len() + 28, 0);
        bytes.extend([10, 20, 30, 40]);
        let mut output = Vec::new();
        decode(&bytes, 1, 4, &mut output).unwrap();
        assert_eq!(output, [12, 20, 30, 40]);
        // One byte more or less is an error.
        let mut longer = bytes.clone();
        longer.insert(1, 0);
        assert!(decode(&longer, 1, 4, &mut Vec::new()).is_err());
        bytes.remove(5);
        assert!(decode(&bytes, 1, 4, &mut Vec::new()).is_err());
    }
}

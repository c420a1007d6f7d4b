//! The attribute codec: elements are split into bytes, bytes into differences, differences into groups of sixteen.
//!
//! Source: *KHR_meshopt_compression* (Khronos Group), appendix A, mode 0, versions 0 and 1.

use super::reader::{Malformed, Reader};

/// Bytes that an element has in each channel.
const CHANNEL_BYTES: usize = 4;
/// Elements that share the width of their differences.
const GROUP: usize = 16;
/// Most elements of one block.
const BLOCK_ELEMENTS: usize = 256;
/// Most bytes of one block.
const BLOCK_BYTES: usize = 8192;

/// The differences of one byte position over a block.
type Plane = [u8; BLOCK_ELEMENTS];

/// What the first byte and the end of a stream say.
struct Stream<'a> {
    /// Whether blocks begin with a control header.
    has_control: bool,
    body: Reader<'a>,
    /// The element that the first one differs from.
    baseline: &'a [u8],
    /// One byte a channel; empty in version 0, where all are 0.
    channel_modes: &'a [u8],
}

/// Appends `count` elements of `stride` bytes, a multiple of four up to 256, to `output`.
pub(super) fn decode(
    bytes: &[u8],
    count: usize,
    stride: usize,
    output: &mut Vec<u8>,
) -> Result<(), Malformed> {
    let mut stream = open(bytes, stride)?;
    let most = BLOCK_BYTES.checked_div(stride).unwrap_or(0) & !(GROUP.wrapping_sub(1));
    let most = most.clamp(GROUP, BLOCK_ELEMENTS);
    let mut previous = stream.baseline.to_vec();
    let mut remaining = count;
    while remaining > 0 {
        let elements = remaining.min(most);
        decode_block(&mut stream, elements, &mut previous, output)?;
        remaining = remaining.saturating_sub(elements);
    }
    stream.body.finish()
}

/// Takes the header byte off the front and the tail off the end.
fn open(bytes: &[u8], stride: usize) -> Result<Stream<'_>, Malformed> {
    let channels = stride.div_ceil(CHANNEL_BYTES);
    let (has_control, mode_bytes, least_tail) = match bytes.first() {
        Some(0xa0) => (false, 0, 32),
        Some(0xa1) => (true, channels, 24),
        _ => return Err(Malformed("does not begin as attributes do")),
    };
    let tail = stride.saturating_add(mode_bytes);
    let body_end = bytes.len().checked_sub(tail.max(least_tail));
    let tail_start = bytes.len().checked_sub(tail);
    let (Some(body), Some((baseline, channel_modes))) = (
        body_end.and_then(|end| bytes.get(1..end)),
        tail_start.and_then(|start| bytes.get(start..)?.split_at_checked(stride)),
    ) else {
        return Err(Malformed::TRUNCATED);
    };
    // Differences of bytes and of pairs have no parameter, exclusive ors have a rotation.
    if channel_modes.iter().any(|mode| !(matches!(mode, 0 | 1) || mode & 15 == 2)) {
        return Err(Malformed("has an unknown channel mode"));
    }
    Ok(Stream { has_control, body: Reader::new(body), baseline, channel_modes })
}

/// Decodes `elements` rows behind `previous`, which becomes the last of them.
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
            let difference = planes.map(|plane| plane.get(i).copied().unwrap_or(0));
            value = add_difference(value, difference, mode);
            let (slots, _) = row.as_chunks_mut::<CHANNEL_BYTES>();
            if let Some(slot) = slots.get_mut(channel) {
                *slot = value;
            }
        }
        previous.copy_from_slice(&value);
    }
    Ok(())
}

/// Reads the differences of one byte position; `mode` is that of the control header.
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

/// The pair of bits `place` of a byte, from the lowest.
fn two_bits(byte: u8, place: usize) -> u8 {
    let shift = u32::try_from(place).unwrap_or(u32::MAX).saturating_mul(2);
    byte.checked_shr(shift).unwrap_or(0) & 3
}

/// Sixteen differences of `width` bits; one with all bits set stands for a whole byte behind the group.
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
        // Single bits run upwards in their byte, wider ones downwards.
        let within = bit & 7;
        let shift = if width == 1 { within } else { 8_u32.saturating_sub(width).saturating_sub(within) };
        let value = byte.checked_shr(shift).unwrap_or(0) & sentinel;
        *slot = if value == sentinel { body.byte()? } else { value };
    }
    Ok(())
}

/// The value behind `value`.
fn add_difference(value: [u8; 4], difference: [u8; 4], mode: u8) -> [u8; 4] {
    match mode & 15 {
        0 => {
            let mut sum = value;
            for (byte, difference) in sum.iter_mut().zip(difference) {
                let half = difference >> 1;
                *byte = byte.wrapping_add(if difference & 1 == 0 { half } else { !half });
            }
            sum
        }
        1 => {
            let pair = |[low, high]: [u8; 2], difference: [u8; 2]| {
                let difference = u16::from_le_bytes(difference);
                let half = difference >> 1;
                let step = if difference & 1 == 0 { half } else { !half };
                u16::from_le_bytes([low, high]).wrapping_add(step).to_le_bytes()
            };
            let [a, b, c, d] = value;
            let [e, f, g, h] = difference;
            let ([low0, high0], [low1, high1]) = (pair([a, b], [e, f]), pair([c, d], [g, h]));
            [low0, high0, low1, high1]
        }
        _ => {
            let turned = u32::from_le_bytes(difference).rotate_right(u32::from(mode >> 4));
            (u32::from_le_bytes(value) ^ turned).to_le_bytes()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The worked example of the specification: sixteen differences of four bits.
    #[test]
    fn the_example_of_the_specification_is_understood() {
        let bytes = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut group = [0; GROUP];
        let mut body = Reader::new(&bytes);
        read_group(&mut body, 4, &mut group).unwrap();
        body.finish().unwrap();
        let steps = group.map(|difference| add_difference([0; 4], [difference, 0, 0, 0], 0)[0] as i8);
        assert_eq!(steps, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
    }

    #[test]
    fn single_bits_run_upwards() {
        // Bits 1, 0, 0 ... and 0 ... 0, 1: the first and the last are whole bytes.
        let mut group = [0; GROUP];
        read_group(&mut Reader::new(&[0x01, 0x80, 7, 9]), 1, &mut group).unwrap();
        let mut expected = [0; GROUP];
        (expected[0], expected[15]) = (7, 9);
        assert_eq!(group, expected);
    }

    #[test]
    fn pairs_carry_and_words_turn() {
        // 0x00ff + 1 = 0x0100; 0x0000 − 1 = 0xffff: zigzag 2 and 1.
        assert_eq!(add_difference([0xff, 0, 0, 0], [2, 0, 1, 0], 1), [0, 1, 0xff, 0xff]);
        assert_eq!(add_difference([1, 0, 0, 0], [0, 0, 0, 0x80], 2), [1, 0, 0, 0x80]);
    }

    #[test]
    fn rows_continue_from_the_baseline() {
        // Version 0, one element of four bytes: all differences zero but the first byte's, which is stored whole.
        let mut bytes = vec![0xa0];
        bytes.extend([3, 4]);
        bytes.extend([0; 15]);
        bytes.extend([0, 0, 0]);
        bytes.resize(bytes.len() + 28, 0);
        bytes.extend([10, 20, 30, 40]);
        let mut output = Vec::new();
        decode(&bytes, 1, 4, &mut output).unwrap();
        assert_eq!(output, [12, 20, 30, 40]);
        // A byte more or less does not fit.
        let mut longer = bytes.clone();
        longer.insert(1, 0);
        assert!(decode(&longer, 1, 4, &mut Vec::new()).is_err());
        bytes.remove(5);
        assert!(decode(&bytes, 1, 4, &mut Vec::new()).is_err());
    }
}

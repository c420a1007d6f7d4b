//! Index codecs: triangles coded by recent edges and vertices, and index sequences coded by deltas.
//!
//! Source: *KHR_meshopt_compression* (Khronos Group), appendix A, modes 1 and 2; names follow the appendix.

use super::reader::{Malformed, Reader};

/// Entries of a FIFO.
const FIFO_LENGTH: usize = 16;

/// FIFO of the last sixteen values.
#[derive(Clone, Copy, Debug)]
struct Fifo<T> {
    entries: [T; FIFO_LENGTH],
    pushed: usize,
}

impl<T: Copy + Default> Fifo<T> {
    fn new() -> Self {
        Self { entries: [T::default(); FIFO_LENGTH], pushed: 0 }
    }

    fn push(&mut self, value: T) {
        if let Some(slot) = self.entries.get_mut(self.pushed & 15) {
            *slot = value;
        }
        self.pushed = self.pushed.wrapping_add(1);
    }

    /// The value that was pushed `age` pushes before the newest.
    fn at(&self, age: usize) -> Result<T, Malformed> {
        let index = self.pushed.checked_sub(age.saturating_add(1));
        let entry = index.and_then(|index| self.entries.get(index & 15));
        entry.copied().ok_or(Malformed("refers to a value before its beginning"))
    }
}

/// Decodes `count` triangle indices, a multiple of three.
pub(super) fn decode_triangles(
    bytes: &[u8],
    count: usize,
    emit: &mut impl FnMut(u32),
) -> Result<(), Malformed> {
    let (codes, data, table) = open_triangles(bytes, count)?;
    let mut decoder = Triangles { data, next: 0, last: 0, edges: Fifo::new(), vertices: Fifo::new() };
    for &code in codes {
        let [a, b, c] = match code {
            0xfe | 0xff => decoder.explicit(code)?,
            0xf0..=0xfd => {
                let pair = table.get(usize::from(code & 15)).copied().unwrap_or(0);
                decoder.detached(0, pair)?
            }
            _ => decoder.attached(code)?,
        };
        emit(a);
        emit(b);
        emit(c);
    }
    decoder.data.finish()
}

/// Splits a stream into codes, data and the table at its end.
fn open_triangles(bytes: &[u8], count: usize) -> Result<(&[u8], Reader<'_>, &[u8]), Malformed> {
    let Some((&0xe1, rest)) = bytes.split_first() else {
        return Err(Malformed("does not begin with the header of the triangle codec"));
    };
    let Some((codes, rest)) = rest.split_at_checked(count / 3) else {
        return Err(Malformed::TRUNCATED);
    };
    let Some((data, table)) = rest.split_last_chunk::<16>() else {
        return Err(Malformed::TRUNCATED);
    };
    let has_fifteen = table.iter().any(|byte| byte & 15 == 15 || byte >> 4 == 15);
    if has_fifteen || !table.ends_with(&[0, 0]) {
        return Err(Malformed("has an invalid table at its end"));
    }
    Ok((codes, Reader::new(data), table))
}

/// State of the triangle decoder.
struct Triangles<'a> {
    data: Reader<'a>,
    next: u32,
    last: u32,
    edges: Fifo<[u32; 2]>,
    vertices: Fifo<u32>,
}

impl Triangles<'_> {
    fn fresh(&mut self) -> u32 {
        let fresh = self.next;
        self.next = self.next.wrapping_add(1);
        fresh
    }

    fn by_difference(&mut self) -> Result<u32, Malformed> {
        let value = self.data.number()?;
        self.last = self.last.wrapping_add(unzigzag(value));
        Ok(self.last)
    }

    /// Decodes a triangle that shares a recent edge.
    fn attached(&mut self, code: u8) -> Result<[u32; 3], Malformed> {
        let [a, b] = self.edges.at(usize::from(code >> 4))?;
        let (c, is_new) = match code & 15 {
            0 => (self.fresh(), true),
            13 => {
                self.last = self.last.wrapping_sub(1);
                (self.last, true)
            }
            14 => {
                self.last = self.last.wrapping_add(1);
                (self.last, true)
            }
            15 => (self.by_difference()?, true),
            age => (self.vertices.at(usize::from(age))?, false),
        };
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        if is_new {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }

    /// Decodes a triangle whose data names the source of each vertex.
    fn explicit(&mut self, code: u8) -> Result<[u32; 3], Malformed> {
        let pair = self.data.byte()?;
        if pair == 0 {
            self.next = 0;
        }
        self.detached(if code == 0xfe { 0 } else { 15 }, pair)
    }

    /// Decodes a triangle without a recent edge. Each vertex is new (0), recent (1 to 14) or a delta (15).
    fn detached(&mut self, first: u8, pair: u8) -> Result<[u32; 3], Malformed> {
        let sources = [first, pair >> 4, pair & 15];
        let mut corners = [0; 3];
        for (corner, source) in corners.iter_mut().zip(sources) {
            *corner = match source {
                0 => self.fresh(),
                15 => self.by_difference()?,
                age => self.vertices.at(usize::from(age.saturating_sub(1)))?,
            };
        }
        let [a, b, c] = corners;
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        for (corner, source) in corners.into_iter().zip(sources) {
            if matches!(source, 0 | 15) {
                self.vertices.push(corner);
            }
        }
        Ok(corners)
    }
}

/// Decodes `count` indices of any topology.
pub(super) fn decode_sequence(
    bytes: &[u8],
    count: usize,
    emit: &mut impl FnMut(u32),
) -> Result<(), Malformed> {
    let Some((&0xd1, rest)) = bytes.split_first() else {
        return Err(Malformed("does not begin with the header of the index codec"));
    };
    let Some((data, _)) = rest.split_last_chunk::<4>() else {
        return Err(Malformed::TRUNCATED);
    };
    let mut data = Reader::new(data);
    let mut last = [0_u32; 2];
    for _ in 0..count {
        let value = data.number()?;
        let [even, odd] = &mut last;
        let baseline = if value & 1 == 0 { even } else { odd };
        *baseline = baseline.wrapping_add(unzigzag(value >> 1));
        emit(*baseline);
    }
    data.finish()
}

/// Zigzag decoding: 0, 1, 2, 3, … to 0, −1, 1, −2, … in two's complement.
fn unzigzag(value: u32) -> u32 {
    let half = value >> 1;
    if value & 1 == 0 { half } else { !half }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(bytes: &[u8], count: usize) -> Result<Vec<u32>, Malformed> {
        let mut list = Vec::new();
        decode_triangles(bytes, count, &mut |index| list.push(index)).map(|()| list)
    }

    #[test]
    fn triangles_share_recent_edges() {
        // 0xf0 with table entry 0: three new vertices 0 1 2 and the edges 10, 21, 02. Then code 0x00: the newest edge 0 2 and
        // a new vertex 3.
        let mut stream = vec![0xe1, 0xf0, 0x00];
        stream.extend([0; 16]);
        assert_eq!(triangles(&stream, 6), Ok(vec![0, 1, 2, 0, 2, 3]));
    }

    #[test]
    fn explicit_vertices_are_deltas_to_the_last() {
        // 0xff, all three as deltas: +5, −2 and +1 are coded 10, 3, 2.
        let mut stream = vec![0xe1, 0xff, 0xff, 10, 3, 2];
        stream.extend([0; 16]);
        assert_eq!(triangles(&stream, 3), Ok(vec![5, 3, 4]));
    }

    #[test]
    fn values_before_the_beginning_are_errors() {
        let mut stream = vec![0xe1, 0x00];
        stream.extend([0; 16]);
        assert!(triangles(&stream, 3).is_err());
        stream[1] = 0xf0;
        assert!(triangles(&stream, 3).is_ok());
        stream[2] = 0x10;
        assert!(triangles(&stream, 3).is_err(), "the second corner is recent, but there is none");
    }

    #[test]
    fn sequences_have_two_baselines() {
        // +3 on the even baseline (3 · 4 = 12), +7 on the odd one (29), −1 on the even one (value 1 · 2, so 2).
        let stream = [0xd1, 12, 29, 2, 0, 0, 0, 0];
        let mut list = Vec::new();
        decode_sequence(&stream, 3, &mut |index| list.push(index)).unwrap();
        assert_eq!(list, [3, 7, 2]);
        assert!(decode_sequence(&stream, 4, &mut |_| {}).is_err());
        assert!(decode_sequence(&stream, 2, &mut |_| {}).is_err());
    }
}

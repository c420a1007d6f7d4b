//! Numbers and parts from the bytes of an input. Bytes beyond the end are zero, so that every input means something.

use glam::Vec3;

/// Reader of an input.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Input<'a> {
    rest: &'a [u8],
}

impl<'a> Input<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Whether nothing is left.
    pub(crate) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// All that is left.
    pub(crate) fn rest(self) -> &'a [u8] {
        self.rest
    }

    fn array<const N: usize>(&mut self) -> [u8; N] {
        let (taken, rest) = self.rest.split_at(N.min(self.rest.len()));
        self.rest = rest;
        let mut array = [0; N];
        array[..taken.len()].copy_from_slice(taken);
        array
    }

    pub(crate) fn u8(&mut self) -> u8 {
        let [byte] = self.array();
        byte
    }

    pub(crate) fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.array())
    }

    pub(crate) fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    /// Any bits: NaN and infinity too.
    pub(crate) fn f32(&mut self) -> f32 {
        f32::from_bits(self.u32())
    }

    /// One of a few hundred numbers, so that points coincide and triangles share planes.
    pub(crate) fn grid_number(&mut self) -> f32 {
        f32::from(self.u8().cast_signed()) * 0.125
    }

    pub(crate) fn point(&mut self, is_on_grid: bool) -> Vec3 {
        let mut number = || if is_on_grid { self.grid_number() } else { self.f32() };
        Vec3::new(number(), number(), number())
    }

    /// The next part: a length of four bytes, cut to what is there, and as many bytes.
    pub(crate) fn part(&mut self) -> &'a [u8] {
        let length = self.u32() as usize;
        let (part, rest) = self.rest.split_at(length.min(self.rest.len()));
        self.rest = rest;
        part
    }
}

/// An input of parts, as [`Input::part`] reads them.
pub(crate) fn joined(parts: &[&[u8]]) -> Vec<u8> {
    let with_length = |part: &&[u8]| [&(part.len() as u32).to_le_bytes()[..], part].concat();
    parts.iter().flat_map(with_length).collect()
}

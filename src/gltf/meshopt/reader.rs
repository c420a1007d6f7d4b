//! Byte reader over a compressed stream, and its error.

/// Decoding error. The text continues a sentence about the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Malformed(pub(super) &'static str);

impl Malformed {
    /// The stream ends too early.
    pub(super) const TRUNCATED: Self = Self("ends too early; the file is damaged");
}

/// Unread bytes of a stream.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Reads `count` bytes.
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], Malformed> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(Malformed::TRUNCATED)?;
        self.0 = rest;
        Ok(taken)
    }

    /// Reads one byte.
    pub(super) fn byte(&mut self) -> Result<u8, Malformed> {
        let (&byte, rest) = self.0.split_first().ok_or(Malformed::TRUNCATED)?;
        self.0 = rest;
        Ok(byte)
    }

    /// Reads a variable-length number: seven bits per byte, lowest first, at most five bytes.
    pub(super) fn number(&mut self) -> Result<u32, Malformed> {
        let mut value = 0_u32;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            value |= u32::from(byte & 127) << shift;
            if byte < 128 {
                return Ok(value);
            }
        }
        Err(Malformed("has a number of more than five bytes"))
    }

    /// Errors unless everything has been read.
    pub(super) fn finish(self) -> Result<(), Malformed> {
        if self.0.is_empty() { Ok(()) } else { Err(Malformed("has trailing bytes")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_lowest_bits_first() {
        for (bytes, expected) in
            [(&[0x7f][..], 0x7f), (&[0x81, 0x04], 0x201), (&[0xff, 0xa0, 0x05], 0x0001_507f)]
        {
            let mut reader = Reader::new(bytes);
            assert_eq!(reader.number(), Ok(expected));
            assert_eq!(reader.finish(), Ok(()));
        }
        assert!(Reader::new(&[0x80; 6]).number().is_err());
        assert!(Reader::new(&[0x80]).number().is_err());
    }
}

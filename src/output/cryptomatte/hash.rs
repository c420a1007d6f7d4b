//! Cryptomatte ids: hashes of names.
//!
//! Sources: Austin Appleby, MurmurHash3 (x86, 32 bits), 2011; Jonah Friedman and Andrew C. Jones, "Fully automatic ID mattes
//! with support for motion blur and transparency", 2015, and the Cryptomatte specification 1.2, section on ids.

/// MurmurHash3_x86_32 of `bytes` with seed 0.
pub(super) fn murmur3(bytes: &[u8]) -> u32 {
    const C1: u32 = 0xcc9e_2d51;
    const C2: u32 = 0x1b87_3593;
    let mixed = |k: u32| k.wrapping_mul(C1).rotate_left(15).wrapping_mul(C2);

    // Body: blocks of four bytes.
    let (blocks, tail) = bytes.as_chunks::<4>();
    let mut hash = 0_u32;
    for &block in blocks {
        hash ^= mixed(u32::from_le_bytes(block));
        hash = hash.rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64);
    }

    // Tail: up to three bytes, the first lowest.
    let last = tail.iter().rev().fold(0_u32, |k, &byte| k << 8 | u32::from(byte));
    hash ^= mixed(last);

    // Finalization.
    hash ^= bytes.len() as u32;
    hash ^= hash >> 16;
    hash = hash.wrapping_mul(0x85eb_ca6b);
    hash ^= hash >> 13;
    hash = hash.wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

/// Id of a name: its hash, with the lowest exponent bit flipped where the bits would be an infinity, NaN, zero or a denormal
/// float (`uint32_to_float32`).
pub(super) fn name_id(name: &str) -> u32 {
    const LOWEST_EXPONENT_BIT: u32 = 1 << 23;
    let hash = murmur3(name.as_bytes());
    match hash >> 23 & 0xff {
        0 | 0xff => hash ^ LOWEST_EXPONENT_BIT,
        _ => hash,
    }
}

/// Key of a layer in the names of its attributes: seven hexadecimal digits.
pub(super) fn layer_key(layer: &str) -> String {
    let mut digits = format!("{:08x}", murmur3(layer.as_bytes()));
    digits.truncate(7);
    digits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_equal_those_of_the_reference_implementation() {
        // Values of the reference implementation: every length of the tail, and UTF-8.
        for (text, expected) in [
            ("", 0),
            ("a", 0x3c25_69b2),
            ("ab", 0x9bbf_d75f),
            ("abc", 0xb3dd_93fa),
            ("test", 0xba6b_d213),
            ("Hello, world!", 0xc036_3e43),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
            ("Žlutý kůň", 0xc3be_dc71),
        ] {
            assert_eq!(murmur3(text.as_bytes()), expected, "{text}");
        }
    }

    #[test]
    fn ids_equal_published_ones() {
        // From the tests of the Cryptomatte plug-in for Nuke, as that prints floats.
        for (name, expected) in [
            ("hello", 6.070_562_710_24e-17),
            ("cube", -4.084_619_125_19e15),
            ("sphere", 2.790_186_043_83e15),
            ("plane", 3.665_576_175_93e-11_f64),
        ] {
            assert_eq!(f32::from_bits(name_id(name)), expected as f32, "{name}");
        }
    }

    #[test]
    fn ids_are_ordinary_floats() {
        let mut flipped = 0;
        for i in 0..20_000 {
            let name = format!("node{i}");
            let (hash, id) = (murmur3(name.as_bytes()), name_id(&name));
            let value = f32::from_bits(id);
            assert!(value.is_normal(), "{name}");
            assert!(id == hash || id == hash ^ 1 << 23);
            flipped += u32::from(id != hash);
        }
        // Two of 256 exponents are flipped: about 156 of 20,000.
        assert!((100..220).contains(&flipped), "{flipped}");
    }

    #[test]
    fn keys_are_the_first_digits_of_the_hash() {
        // "hello" is 0x248bfa47.
        assert_eq!(murmur3(b"hello"), 0x248b_fa47);
        assert_eq!(layer_key("hello"), "248bfa4");
    }
}

//! Components of accessor elements: byte layout and conversion to numbers.
//!
//! Source: glTF 2.0 specification, sections 3.6.2.2 (data types), 3.6.2.4 (alignment) and 3.11 (normalized integers).

use gltf::json::accessor::{ComponentType, Type};

/// Columns of a matrix start at multiples of four bytes.
const COLUMN_ALIGNMENT: usize = 4;

/// Byte layout of one element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ElementLayout {
    /// Byte offset of each component from the start of the element.
    pub(super) offsets: Vec<usize>,
    /// Bytes from the start of the element to the end of its last component.
    pub(super) occupied_bytes: usize,
    /// Bytes from one tightly packed element to the next.
    pub(super) packed_bytes: usize,
}

impl ElementLayout {
    /// Layout of elements of type `shape` with components of type `component`.
    pub(super) fn new(shape: Type, component: ComponentType) -> Self {
        let (columns, rows) = match shape {
            Type::Scalar => (1_usize, 1_usize),
            Type::Vec2 => (1, 2),
            Type::Vec3 => (1, 3),
            Type::Vec4 => (1, 4),
            Type::Mat2 => (2, 2),
            Type::Mat3 => (3, 3),
            Type::Mat4 => (4, 4),
        };
        let size = component.size();
        let column_bytes = rows.saturating_mul(size);
        let column_stride =
            if columns > 1 { column_bytes.next_multiple_of(COLUMN_ALIGNMENT) } else { column_bytes };
        let offsets: Vec<usize> = (0..columns)
            .flat_map(|column| (0..rows).map(move |row| (column, row)))
            .map(|(column, row)| {
                column.saturating_mul(column_stride).saturating_add(row.saturating_mul(size))
            })
            .collect();
        Self {
            occupied_bytes: offsets.last().map_or(0, |last| last.saturating_add(size)),
            packed_bytes: columns.saturating_mul(column_stride),
            offsets,
        }
    }
}

/// Converts the component at the start of `bytes` to a float. Returns zero if `bytes` is too short.
pub(super) fn float(bytes: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let (value, largest) = match component {
        ComponentType::F32 => return f32::from_le_bytes(leading(bytes)),
        ComponentType::U32 => return u32::from_le_bytes(leading(bytes)) as f32,
        ComponentType::I8 => (f32::from(i8::from_le_bytes(leading(bytes))), 127.0),
        ComponentType::U8 => (f32::from(u8::from_le_bytes(leading(bytes))), 255.0),
        ComponentType::I16 => (f32::from(i16::from_le_bytes(leading(bytes))), 32767.0),
        ComponentType::U16 => (f32::from(u16::from_le_bytes(leading(bytes))), 65535.0),
    };
    if !normalized {
        return value;
    }
    let scaled = value / largest;
    if scaled < -1.0 { -1.0 } else { scaled }
}

/// Converts the component at the start of `bytes` to an unsigned integer. Returns zero for signed and float types.
pub(super) fn unsigned(bytes: &[u8], component: ComponentType) -> u32 {
    match component {
        ComponentType::U8 => u32::from(u8::from_le_bytes(leading(bytes))),
        ComponentType::U16 => u32::from(u16::from_le_bytes(leading(bytes))),
        ComponentType::U32 => u32::from_le_bytes(leading(bytes)),
        ComponentType::I8 | ComponentType::I16 | ComponentType::F32 => 0,
    }
}

fn leading<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.first_chunk().copied().unwrap_or([0; N])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrix_columns_are_padded_to_four_bytes() {
        // 3 x u8 a column, padded to 4: columns start at 0, 4, 8; the last component ends at 8 + 3.
        let layout = ElementLayout::new(Type::Mat3, ComponentType::U8);
        assert_eq!(layout.offsets, [0, 1, 2, 4, 5, 6, 8, 9, 10]);
        assert_eq!((layout.occupied_bytes, layout.packed_bytes), (11, 12));
        // 2 x u8 a column, padded to 4.
        let layout = ElementLayout::new(Type::Mat2, ComponentType::I8);
        assert_eq!(layout.offsets, [0, 1, 4, 5]);
        // 3 x u16 = 6 bytes a column, padded to 8.
        let layout = ElementLayout::new(Type::Mat3, ComponentType::I16);
        assert_eq!(layout.offsets, [0, 2, 4, 8, 10, 12, 16, 18, 20]);
        // Floats and vectors need no padding.
        assert_eq!(ElementLayout::new(Type::Mat4, ComponentType::F32).packed_bytes, 64);
        assert_eq!(ElementLayout::new(Type::Vec3, ComponentType::U8).packed_bytes, 3);
    }

    #[test]
    fn normalized_integers_map_to_the_unit_interval() {
        // Section 3.11: c/127 and c/32767, not below -1; c/255; c/65535.
        assert_eq!(float(&[0x80], ComponentType::I8, true), -1.0);
        assert_eq!(float(&[0x81], ComponentType::I8, true), -1.0);
        assert_eq!(float(&[127], ComponentType::I8, true), 1.0);
        assert_eq!(float(&[51], ComponentType::U8, true), 0.2);
        assert_eq!(float(&(-32768_i16).to_le_bytes(), ComponentType::I16, true), -1.0);
        assert_eq!(float(&u16::MAX.to_le_bytes(), ComponentType::U16, true), 1.0);
        assert_eq!(float(&[0xfe], ComponentType::I8, false), -2.0);
    }
}

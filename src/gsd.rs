//! The part of the file format GSD, version 2, that trajectories need:
//! <https://gsd.readthedocs.io>, "File layer".
//!
//! The header gives the positions of two blocks. The index has an entry of 32 bytes for each chunk
//! of data, ordered by frame and name, and ends with an entry of zeros. The list of names ends with
//! zeros too. All numbers are little-endian.

/// The first eight bytes of a file.
pub(crate) const MAGIC: [u8; 8] = 0x65df_65df_65df_65df_u64.to_le_bytes();
/// Bytes of the header.
pub(crate) const HEADER: usize = 256;
/// Bytes of an entry of the index.
pub(crate) const ENTRY: usize = 32;
/// The size of the list of names is given in units of this number of bytes.
pub(crate) const NAME: usize = 64;
/// Schema that defines the meaning of the chunks, version 1.4.
pub(crate) const SCHEMA: &[u8] = b"hoomd";

/// A kind of chunk, named by the schema `hoomd`. Names that begin with `log/` are extensions of the
/// writer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Chunk {
    pub(crate) name: &'static str,
    pub(crate) element: Element,
    pub(crate) columns: u32,
}

/// Type of the numbers in a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Element {
    Byte = 1,
    Short = 3,
    Long = 4,
    Character = 5,
    Single = 9,
    Double = 10,
}

impl Element {
    pub(crate) fn bytes(self) -> u64 {
        match self {
            Self::Byte | Self::Character => 1,
            Self::Short | Self::Single => 4,
            Self::Long | Self::Double => 8,
        }
    }
}

const fn chunk(name: &'static str, element: Element, columns: u32) -> Chunk {
    Chunk { name, element, columns }
}

/// Number of the sweep.
pub(crate) const STEP: Chunk = chunk("configuration/step", Element::Long, 1);
/// Centers relative to the middle of the slab.
pub(crate) const POSITION: Chunk = chunk("particles/position", Element::Single, 3);
/// Centers in the coordinates of the slab.
pub(crate) const EXACT_POSITION: Chunk = chunk("log/particles/exact_position", Element::Double, 3);
pub(crate) const DIMENSIONS: Chunk = chunk("configuration/dimensions", Element::Byte, 1);
/// Three extents and three tilts.
pub(crate) const BOX: Chunk = chunk("configuration/box", Element::Single, 1);
pub(crate) const PARTICLES: Chunk = chunk("particles/N", Element::Short, 1);
pub(crate) const TYPES: Chunk = chunk("particles/types", Element::Character, 2);
pub(crate) const TYPE: Chunk = chunk("particles/typeid", Element::Short, 1);
pub(crate) const DIAMETER: Chunk = chunk("particles/diameter", Element::Single, 1);
/// Height and widths of the slab.
pub(crate) const SLAB: Chunk = chunk("log/slab", Element::Double, 1);

/// An entry of the index: kind and position of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Entry {
    pub(crate) frame: u64,
    pub(crate) rows: u64,
    /// Position in bytes from the beginning of the file; 0 in the last entry.
    pub(crate) location: u64,
    pub(crate) columns: u32,
    /// Index in the list of names.
    pub(crate) name: u16,
    pub(crate) element: u8,
}

impl Entry {
    pub(crate) fn to_bytes(self) -> [u8; ENTRY] {
        let mut bytes = [0; ENTRY];
        bytes[..8].copy_from_slice(&self.frame.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.rows.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.location.to_le_bytes());
        bytes[24..28].copy_from_slice(&self.columns.to_le_bytes());
        bytes[28..30].copy_from_slice(&self.name.to_le_bytes());
        bytes[30] = self.element;
        bytes
    }

    pub(crate) fn from_bytes(bytes: &[u8; ENTRY]) -> Self {
        Self {
            frame: long(bytes, 0),
            rows: long(bytes, 8),
            location: long(bytes, 16),
            columns: short(bytes, 24),
            name: u16::from_le_bytes([bytes[28], bytes[29]]),
            element: bytes[30],
        }
    }
}

/// The number at a position of the bytes, which must be inside.
pub(crate) fn long(bytes: &[u8], place: usize) -> u64 {
    u64::from(short(bytes, place)) | u64::from(short(bytes, place + 4)) << 32
}

/// The number at a position of the bytes, which must be inside.
pub(crate) fn short(bytes: &[u8], place: usize) -> u32 {
    u32::from_le_bytes([bytes[place], bytes[place + 1], bytes[place + 2], bytes[place + 3]])
}

/// The header, with position and capacity of index and names.
pub(crate) fn header(index: [u64; 2], names: [u64; 2]) -> [u8; HEADER] {
    let mut bytes = [0; HEADER];
    bytes[..8].copy_from_slice(&MAGIC);
    for (place, number) in [index, names].into_iter().flatten().enumerate() {
        bytes[8 + 8 * place..16 + 8 * place].copy_from_slice(&number.to_le_bytes());
    }
    // Versions of the schema and of the file.
    bytes[40..44].copy_from_slice(&0x0001_0004_u32.to_le_bytes());
    bytes[44..48].copy_from_slice(&0x0002_0000_u32.to_le_bytes());
    let writer = concat!("gradient-mc ", env!("CARGO_PKG_VERSION")).as_bytes();
    bytes[48..48 + writer.len()].copy_from_slice(writer);
    bytes[112..112 + SCHEMA.len()].copy_from_slice(SCHEMA);
    bytes
}

/// A coordinate relative to the middle of a slab of this extent, always less than half of it.
pub(crate) fn centered(coordinate: f64, extent: f64) -> f32 {
    let [center, end] = [single(coordinate - 0.5 * extent), 0.5 * single(extent)];
    // Rounding may move a coordinate up to the end of the period.
    if center.to_bits() == end.to_bits() { -end } else { center }
}

/// Rounds to single precision, as the schema `hoomd` requires.
#[allow(clippy::cast_possible_truncation)]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}

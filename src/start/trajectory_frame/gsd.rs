//! Reads frames of GSD.

use super::{Extents, TrajectoryError, TrajectoryFrame};
use crate::gsd::{
    BOX, Chunk, DIAMETER, ENTRY, EXACT_POSITION, Entry, HEADER, NAME, PARTICLES, POSITION, SCHEMA, SLAB,
    STEP, centered, long, short,
};
use nalgebra::Vector3;
use std::io::{BufReader, Read, Seek, SeekFrom};

/// The chunks that are read.
const CHUNKS: [Chunk; 7] = [STEP, POSITION, EXACT_POSITION, BOX, PARTICLES, DIAMETER, SLAB];

/// The places of the chunks of a frame, if it has them.
type Places = [Option<Entry>; CHUNKS.len()];

struct Reader<R> {
    source: BufReader<R>,
    length: u64,
}

fn malformed(place: &str, what: impl Into<String>) -> TrajectoryError {
    TrajectoryError::malformed(place, what)
}

pub(super) fn read(
    mut source: impl Read + Seek,
    number: Option<u64>,
) -> Result<TrajectoryFrame, TrajectoryError> {
    let length = source.seek(SeekFrom::End(0))?;
    Reader { source: BufReader::new(source), length }.frame(number)
}

impl<R: Read + Seek> Reader<R> {
    /// Reads `length` bytes of the file.
    fn bytes(&mut self, what: &str, place: u64, length: u64) -> Result<Vec<u8>, TrajectoryError> {
        // Checked before memory is allocated.
        if place.checked_add(length).is_none_or(|end| end > self.length) {
            return Err(malformed(what, "it lies beyond the end of the file, which is cut off or damaged"));
        }
        self.source.seek(SeekFrom::Start(place))?;
        let mut bytes = Vec::new();
        self.source.by_ref().take(length).read_to_end(&mut bytes)?;
        if bytes.len() as u64 == length {
            Ok(bytes)
        } else {
            Err(malformed(what, "the file has become shorter"))
        }
    }

    fn frame(&mut self, number: Option<u64>) -> Result<TrajectoryFrame, TrajectoryError> {
        let header = self.bytes("header", 0, HEADER as u64)?;
        let version = short(&header, 44);
        if version >> 16 != 2 {
            let what =
                format!("version {}.{} of GSD is not supported, only 2.x", version >> 16, version & 0xffff);
            return Err(malformed("header", what));
        }
        if !header[112..].starts_with(SCHEMA) || header[112 + SCHEMA.len()] != 0 {
            return Err(malformed("header", "the schema is not hoomd"));
        }
        let [index, room, names, names_length] = [8, 16, 24, 32].map(|place| long(&header, place));
        let names = self.bytes("list of names", names, names_length.saturating_mul(NAME as u64))?;
        // For each name in the file, its index in `CHUNKS`.
        let names: Vec<Option<usize>> = names
            .split(|&byte| byte == 0)
            .take_while(|name| !name.is_empty())
            .map(|name| CHUNKS.iter().position(|chunk| chunk.name.as_bytes() == name))
            .collect();
        let (first, found, number) = self.find(index, room, &names, number)?;
        self.gather(number, |place| found[place].or(first[place]))
    }

    /// The places of the chunks of the first frame, and of the frame `number` or the last.
    fn find(
        &mut self,
        index: u64,
        room: u64,
        names: &[Option<usize>],
        number: Option<u64>,
    ) -> Result<(Places, Places, u64), TrajectoryError> {
        if room
            .checked_mul(ENTRY as u64)
            .and_then(|bytes| bytes.checked_add(index))
            .is_none_or(|end| end > self.length)
        {
            return Err(malformed(
                "index",
                "it lies beyond the end of the file, which is cut off or damaged",
            ));
        }
        self.source.seek(SeekFrom::Start(index))?;
        let (mut first, mut found): (Places, Places) = Default::default();
        let mut current = None;
        let mut bytes = [0; ENTRY];
        for _ in 0..room {
            self.source.read_exact(&mut bytes)?;
            let entry = Entry::from_bytes(&bytes);
            if entry.location == 0 {
                break;
            }
            if current.is_some_and(|current| entry.frame < current) {
                return Err(malformed("index", "frames are out of order"));
            }
            if current != Some(entry.frame) && number.is_none() {
                found = Places::default();
            }
            current = Some(entry.frame);
            let Some(&name) = names.get(usize::from(entry.name)) else {
                return Err(malformed("index", format!("a chunk of frame {} has no name", entry.frame)));
            };
            let Some(place) = name else { continue };
            if entry.frame == 0 {
                first[place] = Some(entry);
            }
            if number.is_none_or(|number| number == entry.frame) {
                found[place] = Some(entry);
            }
        }
        match (number, current) {
            (Some(number), Some(last)) if number <= last => Ok((first, found, number)),
            (None, Some(last)) => Ok((first, found, last)),
            _ => {
                let frames = current.map_or(0, |last| last.saturating_add(1));
                Err(TrajectoryError::NoSuchFrame { number: number.unwrap_or(0), frames })
            }
        }
    }

    fn gather(
        &mut self,
        frame: u64,
        found: impl Fn(usize) -> Option<Entry>,
    ) -> Result<TrajectoryFrame, TrajectoryError> {
        // The bytes of a chunk with this number of rows, if it exists.
        let mut chunk = |chunk: Chunk, rows: u64| -> Result<Option<Vec<u8>>, TrajectoryError> {
            let place = CHUNKS.iter().position(|other| *other == chunk);
            let Some(entry) = place.and_then(&found) else { return Ok(None) };
            let what = format!("frame {frame}, {}", chunk.name);
            if (entry.rows, entry.columns, entry.element) != (rows, chunk.columns, chunk.element as u8) {
                let message = format!(
                    "there are {} x {} numbers of type {}, instead of {rows} x {} of type {}",
                    entry.rows, entry.columns, entry.element, chunk.columns, chunk.element as u8
                );
                return Err(malformed(&what, message));
            }
            // No overflow, because the number of rows fits 32 bits.
            let length = rows * u64::from(chunk.columns) * chunk.element.bytes();
            self.bytes(&what, entry.location, length).map(Some)
        };
        let place = format!("frame {frame}");
        let particles = chunk(PARTICLES, 1)?.ok_or_else(|| malformed(&place, "there is no particles/N"))?;
        let rows = u64::from(short(&particles, 0));
        let sweep = chunk(STEP, 1)?.map(|bytes| long(&bytes, 0));
        if let Some(diameters) = chunk(DIAMETER, rows)?
            && singles(&diameters).any(|diameter| diameter != 1.0)
        {
            return Err(malformed(&place, "diameters must be 1: they are the unit of length"));
        }
        let sides = chunk(BOX, 6)?.ok_or_else(|| malformed(&place, "there is no configuration/box"))?;
        let (sides, tilts) = (triple(singles(&sides)), triple(singles(&sides[12..])));
        if tilts != [0.0; 3] {
            return Err(malformed(&place, "the box must not be tilted"));
        }
        let rounded =
            chunk(POSITION, rows)?.ok_or_else(|| malformed(&place, "there is no particles/position"))?;
        let exact = chunk(SLAB, 3)?.map(|slab| triple(doubles(&slab))).zip(chunk(EXACT_POSITION, rows)?);
        let Some((slab, exact)) = exact else {
            let positions = triples(singles(&rounded).map(f64::from));
            let inside = |center: &Vector3<f64>| {
                center.iter().zip(sides).all(|(center, side)| center.abs() <= 0.5 * f64::from(side))
            };
            // NaN is outside, too.
            return match positions.iter().position(|center| !inside(center)) {
                Some(sphere) => Err(malformed(&place, format!("sphere {sphere} is outside the box"))),
                None => Ok(TrajectoryFrame { sweep, extents: Extents::Box(sides), positions }),
            };
        };
        let positions = triples(doubles(&exact));
        let same = |(exact, rounded): (&Vector3<f64>, [f32; 3])| {
            let coordinates = exact.iter().zip(rounded).zip(slab.into_iter().zip(sides));
            coordinates.into_iter().all(|((&exact, rounded), (extent, side))| {
                let difference = (rounded - centered(exact, extent)).abs();
                // At the end of a period other programs may round to either side. NaN always
                // differs.
                difference.min((difference - side).abs()) <= f32::EPSILON * side
            })
        };
        let rounded = rounded.chunks_exact(12).map(|three| triple(singles(three)));
        match positions.iter().zip(rounded).position(|both| !same(both)) {
            Some(sphere) => {
                let message = format!(
                    "{} and {} of sphere {sphere} differ: remove the former if you changed the latter",
                    EXACT_POSITION.name, POSITION.name
                );
                Err(malformed(&place, message))
            }
            None => Ok(TrajectoryFrame { sweep, extents: Extents::Slab(slab), positions }),
        }
    }
}

fn singles(bytes: &[u8]) -> impl Iterator<Item = f32> + '_ {
    bytes.chunks_exact(4).map(|bytes| f32::from_bits(short(bytes, 0)))
}

fn doubles(bytes: &[u8]) -> impl Iterator<Item = f64> + '_ {
    bytes.chunks_exact(8).map(|bytes| f64::from_bits(long(bytes, 0)))
}

fn triple<N: Default>(mut numbers: impl Iterator<Item = N>) -> [N; 3] {
    std::array::from_fn(|_| numbers.next().unwrap_or_default())
}

fn triples(mut numbers: impl Iterator<Item = f64>) -> Vec<Vector3<f64>> {
    let three = || {
        let [x, y, z] = [numbers.next()?, numbers.next()?, numbers.next()?];
        Some(Vector3::new(x, y, z))
    };
    std::iter::from_fn(three).collect()
}

//! Trajectories in the binary format of HOOMD-blue, GSD.

use super::one_run::OneRun;
use crate::gsd::{
    BOX, Chunk, DIAMETER, DIMENSIONS, ENTRY, EXACT_POSITION, Entry, HEADER, NAME, PARTICLES, POSITION, SLAB,
    STEP, TYPE, TYPES, centered, header, single,
};
use crate::{Frame, Observer, ObserverError};
use std::fs::File;
#[cfg(feature = "checkpoint")]
use std::io::Read as _;
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::Path;

/// Writes every frame in the binary format [GSD](https://gsd.readthedocs.io), which `gsd`, OVITO,
/// freud, `MDAnalysis` and HOOMD-blue read. A frame takes 36 bytes per sphere, and readers can
/// access any frame directly.
///
/// The step of a frame is the number of the sweep. The centers are stored in single precision, as
/// the schema `hoomd` of the format requires, and in double precision as
/// `log/particles/exact_position`. The first frame also stores what is the same in all: box,
/// number, type `X` and diameters of the spheres, and the exact height and widths of the slab as
/// `log/slab`. A simulation starts from a frame by
/// [`TrajectoryFrame`](crate::start::TrajectoryFrame).
///
/// # Box and walls
/// The box of the format is periodic along all axes and centered at the origin. The height is again
/// x: the base is at x = −height/2 and the lid at height/2; y and z are from −width/2 to width/2.
/// The box is longer than the slab by half the smaller width. Programs search for neighbors up to
/// half the smallest width, so they find none across the walls. The volume of the box is therefore
/// larger than that of the slab. Exact positions are in the coordinates of the slab, with the base
/// at x = 0, and y and z from 0.
///
/// # Interruptions
/// A frame is added to the index after it is written, so the file of a killed run has only complete
/// frames. With the feature `checkpoint` the observer can be part of a run that is interrupted and
/// continued.
///
/// ```
/// use gradient_mc::observers::Gsd;
/// use gradient_mc::start::TrajectoryFrame;
/// use gradient_mc::{Every, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// # let path = std::env::temp_dir().join(format!("gradient-mc-column-{}.gsd", std::process::id()));
/// # std::fs::remove_file(&path).ok();
/// // let path = "column.gsd";
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut trajectory = Every::new(10, Gsd::open(&path)?);
/// let mut simulation = Simulation::builder(scene).build()?;
/// simulation.run(100, &mut trajectory)?;
/// let last = TrajectoryFrame::last(&path)?;
/// assert_eq!((last.sweep(), last.positions()), (Some(100), &simulation.positions()[..]));
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Gsd {
    file: File,
    run: OneRun,
    layout: Layout,
    frames: u64,
    /// Buffer of the frame that is being written.
    bytes: Vec<u8>,
}

/// Chunks of every frame.
const EVERY: [Chunk; 3] = [STEP, POSITION, EXACT_POSITION];
/// Additional chunks of the first frame.
const ONCE: [Chunk; 7] = [DIMENSIONS, BOX, PARTICLES, TYPES, TYPE, DIAMETER, SLAB];
/// Capacity of the first index in entries; it doubles whenever it is full.
const FIRST_INDEX: u64 = 128;
/// Position of the list of names; below, its length.
const NAMES: u64 = HEADER as u64 + FIRST_INDEX * ENTRY as u64;
const NAMES_LENGTH: u64 = 4 * NAME as u64;

/// Layout of a file of frames of equal size. All positions follow from the number of frames.
#[derive(Debug, Clone, Copy, Default)]
struct Layout {
    particles: u64,
}

impl Layout {
    fn rows(self, chunk: Chunk) -> u64 {
        match chunk {
            POSITION | EXACT_POSITION | TYPE | DIAMETER => self.particles,
            BOX => 6,
            SLAB => 3,
            _ => 1,
        }
    }

    fn bytes(self, chunk: Chunk) -> u64 {
        self.rows(chunk) * u64::from(chunk.columns) * chunk.element.bytes()
    }

    fn bytes_of_all(self, chunks: &[Chunk]) -> u64 {
        chunks.iter().map(|&chunk| self.bytes(chunk)).sum()
    }

    /// Number of entries of this number of frames.
    fn entries(frames: u64) -> u64 {
        if frames == 0 { 0 } else { ONCE.len() as u64 + EVERY.len() as u64 * frames }
    }

    /// Number of times that the index has doubled after this number of frames. The new index is
    /// written before the frame that did not fit.
    fn doublings(frames: u64) -> u32 {
        Self::entries(frames).div_ceil(FIRST_INDEX).max(1).next_power_of_two().ilog2()
    }

    /// Position of the first chunk of a frame.
    fn data(self, frame: u64) -> u64 {
        let indices = FIRST_INDEX * ENTRY as u64 * ((2 << Self::doublings(frame + 1)) - 2);
        let first = if frame > 0 { self.bytes_of_all(&ONCE) } else { 0 };
        NAMES + NAMES_LENGTH + indices + first + frame * self.bytes_of_all(&EVERY)
    }

    /// Position and capacity of the index after this number of frames.
    fn index(self, frames: u64) -> [u64; 2] {
        let room = FIRST_INDEX << Self::doublings(frames);
        if room == FIRST_INDEX {
            return [HEADER as u64, room];
        }
        // The first frame that did not fit the index of half the size.
        let frame = (room / 2 - ONCE.len() as u64) / EVERY.len() as u64;
        [self.data(frame) - room * ENTRY as u64, room]
    }

    fn header(self, frames: u64) -> [u8; HEADER] {
        header(self.index(frames), [NAMES, NAMES_LENGTH / NAME as u64])
    }

    /// Entries of a frame, for the index.
    fn entries_of(self, frame: u64) -> Vec<u8> {
        let once = if frame == 0 { &ONCE[..] } else { &[] };
        let mut location = self.data(frame);
        let entries = (0..).zip(EVERY.iter().chain(once)).flat_map(|(name, &chunk)| {
            let (rows, columns, element) = (self.rows(chunk), chunk.columns, chunk.element as u8);
            let entry = Entry { frame, rows, location, columns, name, element };
            location += self.bytes(chunk);
            entry.to_bytes()
        });
        entries.collect()
    }
}

impl Gsd {
    /// Opens a file, or creates it. Frames are never overwritten: the file must be empty, or
    /// written by the run whose checkpoint is continued.
    ///
    /// # Errors
    /// The error of the system.
    pub fn open(path: impl AsRef<Path>) -> io::Result<Self> {
        let file = File::options().read(true).write(true).create(true).truncate(false).open(path)?;
        Ok(Self { file, run: OneRun::default(), layout: Layout::default(), frames: 0, bytes: Vec::new() })
    }

    /// Number of frames written.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Refuses a file that is not empty.
    fn require_empty(&self) -> io::Result<()> {
        let length = self.file.metadata()?.len();
        if self.frames > 0 || length == 0 {
            return Ok(());
        }
        let what = format!(
            "the file of the trajectory already holds {length} bytes: use another file, or remove this one"
        );
        Err(io::Error::new(io::ErrorKind::AlreadyExists, what))
    }

    fn write_at(&mut self, place: u64, bytes: &[u8]) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(place))?;
        self.file.write_all(bytes)
    }

    /// The bytes before the first frame: header, an empty index, names.
    fn preamble(&self) -> Vec<u8> {
        let mut bytes = self.layout.header(0).to_vec();
        bytes.resize(usize::try_from(NAMES).unwrap_or_default(), 0);
        for chunk in EVERY.iter().chain(&ONCE) {
            bytes.extend_from_slice(chunk.name.as_bytes());
            bytes.push(0);
        }
        bytes
    }

    /// Writes the chunks of a frame to the buffer.
    fn gather(&mut self, frame: &Frame<'_>) {
        let bytes = &mut self.bytes;
        bytes.clear();
        let (height, [width_y, width_z]) = (frame.slab().height(), frame.slab().widths());
        let extents = [height, width_y, width_z];
        bytes.extend(frame.sweep().to_le_bytes());
        let coordinates =
            frame.positions().flat_map(|position| <[f64; 3]>::from(position).into_iter().zip(extents));
        bytes.extend(coordinates.clone().flat_map(|(center, extent)| centered(center, extent).to_le_bytes()));
        bytes.extend(coordinates.flat_map(|(center, _)| center.to_le_bytes()));
        if self.frames > 0 {
            return;
        }
        bytes.push(3);
        // Programs search for neighbors up to half the smaller width.
        let length = height + 0.5 * width_y.min(width_z);
        let walled = [length, width_y, width_z, 0.0, 0.0, 0.0];
        bytes.extend(walled.map(single).into_iter().flat_map(f32::to_le_bytes));
        // A scene has fewer than 2³².
        bytes.extend(u32::try_from(frame.particles()).unwrap_or(u32::MAX).to_le_bytes());
        bytes.extend(b"X\0");
        bytes.extend(frame.positions().flat_map(|_| 0_u32.to_le_bytes()));
        bytes.extend(frame.positions().flat_map(|_| 1_f32.to_le_bytes()));
        bytes.extend(extents.into_iter().flat_map(f64::to_le_bytes));
    }
}

impl Observer for Gsd {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        let (layout, frames) = (Layout { particles: frame.particles() as u64 }, self.frames);
        if frames == 0 {
            self.require_empty()?;
            self.layout = layout;
            let preamble = self.preamble();
            self.write_at(0, &preamble)?;
            self.file.set_len(layout.data(0))?;
        }
        let [index, room] = layout.index(frames + 1);
        let grows = Layout::doublings(frames + 1) > Layout::doublings(frames);
        if grows {
            let mut entries: Vec<u8> = (0..frames).flat_map(|frame| layout.entries_of(frame)).collect();
            entries.resize(usize::try_from(room * ENTRY as u64)?, 0);
            self.write_at(index, &entries)?;
        }
        self.gather(frame);
        let bytes = std::mem::take(&mut self.bytes);
        let written = self.write_at(layout.data(frames), &bytes);
        self.bytes = bytes;
        written?;
        // After the data, because readers follow these positions.
        if grows {
            self.write_at(0, &layout.header(frames + 1))?;
        }
        self.write_at(index + Layout::entries(frames) * ENTRY as u64, &layout.entries_of(frames))?;
        self.frames += 1;
        Ok(())
    }
}

/// A checkpoint stores the number of frames, and a continued run cuts off frames that were written
/// later.
#[cfg(feature = "checkpoint")]
impl crate::checkpoint::Persist for Gsd {
    fn persist(&mut self, archive: &mut crate::checkpoint::Archive<'_>) -> Result<(), crate::Error> {
        let failed = |error: io::Error| crate::Error::Custom(error.into());
        if !archive.is_reading() {
            self.require_empty().map_err(failed)?;
        }
        // The frames must be on the disk before the checkpoint.
        self.file.sync_data().map_err(failed)?;
        archive.part("run", &mut self.run)?;
        archive.count("particles", &mut self.layout.particles)?;
        archive.count("frames", &mut self.frames)?;
        if archive.is_reading() {
            let now = self.file.metadata().map_err(failed)?.len();
            // A file that is shorter than at the checkpoint is not the same file.
            archive.check(self.frames == 0 || (1..=now / 36).contains(&self.layout.particles))?;
            archive.check(self.frames <= now / self.layout.bytes_of_all(&EVERY))?;
            archive.check(self.layout.length(self.frames) <= now)?;
            archive.check(self.frames == 0 || self.is_ours().map_err(failed)?)?;
            self.go_back().map_err(failed)?;
        }
        Ok(())
    }
}

#[cfg(feature = "checkpoint")]
impl Layout {
    /// Length of a file with this number of frames.
    fn length(self, frames: u64) -> u64 {
        let Some(last) = frames.checked_sub(1) else { return 0 };
        let first = if last == 0 { self.bytes_of_all(&ONCE) } else { 0 };
        self.data(last) + first + self.bytes_of_all(&EVERY)
    }
}

#[cfg(feature = "checkpoint")]
impl Gsd {
    /// Whether the beginning of the file is that of a file of this observer, for any position of
    /// the index.
    fn is_ours(&mut self) -> io::Result<bool> {
        let (mut found, expected) = ([0; HEADER], self.layout.header(self.frames));
        self.file.rewind()?;
        self.file.read_exact(&mut found)?;
        Ok(found[..8] == expected[..8] && found[24..] == expected[24..])
    }

    /// Cuts the file back to the current number of frames. It is valid for readers at any time.
    fn go_back(&mut self) -> io::Result<()> {
        let (layout, frames) = (self.layout, self.frames);
        if frames > 0 {
            let [index, room] = layout.index(frames);
            self.write_at(0, &layout.header(frames))?;
            let used = Layout::entries(frames);
            let later = vec![0; usize::try_from((room - used) * ENTRY as u64).unwrap_or_default()];
            self.write_at(index + used * ENTRY as u64, &later)?;
        }
        self.file.set_len(layout.length(frames))
    }
}

//! Trajectories as text, in the extended XYZ format.

use crate::{Frame, Observer, ObserverError};
use std::io::Write;
#[cfg(feature = "checkpoint")]
use std::io::{Seek as _, SeekFrom};

/// Writes every frame in the extended XYZ format, which OVITO, ASE and others read.
///
/// A frame is the number of spheres, a line with the box, and a line for each sphere: the species
/// `X`, the center x, y, z in diameters with x up, and the radius 0.5. The box extends from wall to
/// wall and is periodic along y and z (`pbc="F T T"`); `sweep` is the number of the sweep. Numbers
/// read back as the same bits, and the order of the spheres is the same in all frames. Use
/// [`Every`](crate::Every) to write fewer frames.
///
/// With the feature `checkpoint`, an `ExtendedXyz` that writes to a file can be part of a run that
/// is interrupted and continued. Open the file by `File::options().create(true).append(true)`,
/// which keeps its content.
///
/// A frame is passed to the writer in one call and then flushed, so a file needs no buffer. An
/// error of the writer ends the run as the error of an observer.
///
/// ```
/// use gradient_mc::observers::ExtendedXyz;
/// use gradient_mc::{Every, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// // Usually `File::create("column.xyz")?`; a vector of bytes here.
/// let mut trajectory = Every::new(10, ExtendedXyz::new(Vec::new()));
/// Simulation::builder(scene).build()?.run(100, &mut trajectory)?;
/// let text = String::from_utf8(trajectory.observer.into_inner()).unwrap();
/// assert_eq!(text.lines().count(), 10 * (36 + 2));
/// assert!(text.starts_with("36\nLattice=\"60 0 0 0 6 0 0 0 6\" "));
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ExtendedXyz<W> {
    writer: W,
    /// The frame that is being written.
    text: Vec<u8>,
}

impl<W: Write> ExtendedXyz<W> {
    /// Makes an observer that writes frames to `writer`.
    pub fn new(writer: W) -> Self {
        Self { writer, text: Vec::new() }
    }

    /// The writer, after the last frame.
    pub fn into_inner(self) -> W {
        self.writer
    }
}

impl<W: Write> Observer for ExtendedXyz<W> {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        let text = &mut self.text;
        text.clear();
        let (height, [width_y, width_z]) = (frame.slab().height(), frame.slab().widths());
        writeln!(text, "{}", frame.particles())?;
        writeln!(
            text,
            "Lattice=\"{height} 0 0 0 {width_y} 0 0 0 {width_z}\" Properties=species:S:1:pos:R:3:radius:R:1 \
             sweep={} pbc=\"F T T\"",
            frame.sweep(),
        )?;
        for position in frame.positions() {
            writeln!(text, "X {} {} {} 0.5", position.x, position.y, position.z)?;
        }
        self.writer.write_all(text)?;
        Ok(self.writer.flush()?)
    }
}

/// For files only: a checkpoint stores the length of the file, and a continued run cuts off what
/// was written later.
#[cfg(feature = "checkpoint")]
impl crate::checkpoint::Persist for ExtendedXyz<std::fs::File> {
    fn persist(&mut self, archive: &mut crate::checkpoint::Archive<'_>) -> Result<(), crate::Error> {
        let file = &mut self.writer;
        let failed = |error: std::io::Error| crate::Error::Custom(error.into());
        // The frames must be on the disk before the checkpoint.
        file.sync_data().map_err(failed)?;
        let now = file.metadata().map_err(failed)?.len();
        let mut length = now;
        archive.count("bytes", &mut length)?;
        // A file that is shorter than at the checkpoint is not the same file.
        archive.check(length <= now)?;
        if archive.is_reading() {
            file.set_len(length).and_then(|()| file.seek(SeekFrom::Start(length))).map_err(failed)?;
        }
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // compares what is written with what is read
mod tests {
    use super::super::test_frame::Scene;
    use super::*;
    use crate::Slab;
    use std::io;

    /// Sweep, extents and centers of the frames of a file.
    fn parse(text: &str) -> Vec<(u64, [f64; 3], Vec<[f64; 3]>)> {
        let mut lines = text.lines();
        let mut frames = Vec::new();
        while let Some(count) = lines.next() {
            let comment = lines.next().unwrap();
            let value = |key: &str| {
                let rest = comment.split_once(&format!("{key}=")).unwrap().1;
                match rest.strip_prefix('"') {
                    Some(quoted) => quoted.split('"').next().unwrap(),
                    None => rest.split(' ').next().unwrap(),
                }
            };
            assert_eq!(value("Properties"), "species:S:1:pos:R:3:radius:R:1");
            assert_eq!(value("pbc"), "F T T");
            let lattice: Vec<f64> = value("Lattice").split(' ').map(|cell| cell.parse().unwrap()).collect();
            let &[height, a, b, c, width_y, d, e, f, width_z] = &lattice[..] else { panic!("{lattice:?}") };
            assert!([a, b, c, d, e, f].iter().all(|cell| *cell == 0.0));
            let centers = (0..count.parse::<usize>().unwrap()).map(|_| {
                let cells: Vec<&str> = lines.next().unwrap().split(' ').collect();
                assert_eq!((cells.len(), cells[0], cells[4]), (5, "X", "0.5"));
                [1, 2, 3].map(|cell| cells[cell].parse().unwrap())
            });
            let centers = centers.collect();
            frames.push((value("sweep").parse().unwrap(), [height, width_y, width_z], centers));
        }
        frames
    }

    #[test]
    fn frames_read_back_as_they_were() {
        let mut scene = Scene::new(10.1, &[]);
        scene.slab = Slab::new(10.1, 5.0, 4.0 + 1.0 / 3.0).unwrap();
        let mut trajectory = ExtendedXyz::new(Vec::new());
        let mut expected = Vec::new();
        for sweep in [0, 7, 123_456_789_012] {
            scene.sweep.set(sweep);
            let shift = 1.0 / (sweep as f64 + 3.0);
            scene.positions =
                vec![[0.5, 0.0, 1e-17], [9.6 - shift, 0.1 + 0.2, 4.3], [1.0 / 3.0 + 1.0, shift, 1e-3]];
            trajectory.observe(&scene.frame()).unwrap();
            expected.push((sweep, [10.1, 5.0, 4.0 + 1.0 / 3.0], scene.positions.clone()));
        }
        let bytes = trajectory.into_inner();
        assert_eq!(parse(std::str::from_utf8(&bytes).unwrap()), expected);
    }

    /// A disk that is full.
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::Error::new(io::ErrorKind::StorageFull, "the disk is full"))
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_writer_that_fails_is_an_error_of_the_observer() {
        let scene = Scene::new(10.0, &[1.0]);
        let error = ExtendedXyz::new(Full).observe(&scene.frame()).unwrap_err();
        let error = error.downcast_ref::<io::Error>().unwrap();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    }
}

//! Reads frames of extended XYZ.

use super::{Extents, TrajectoryError, TrajectoryFrame};
use nalgebra::Vector3;
use std::io::{BufRead as _, BufReader, Read, Seek, SeekFrom};
use std::str::FromStr;

/// Longest line, in bytes.
const LONGEST: u64 = 1 << 16;

/// Lines with their numbers.
struct Lines<R> {
    reader: BufReader<R>,
    line: Vec<u8>,
    /// Number of the last line read, from 1.
    number: u64,
    /// Position of its end in the file.
    place: u64,
    /// Number of the current frame.
    frame: u64,
}

impl<R: Read> Lines<R> {
    /// The next line, if there is one. It must end with a newline; otherwise it may be cut off
    /// within a number.
    fn next(&mut self) -> Result<Option<&str>, TrajectoryError> {
        self.line.clear();
        let length = self.reader.by_ref().take(LONGEST).read_until(b'\n', &mut self.line)?;
        self.number += 1;
        self.place += length as u64;
        if length == 0 {
            return Ok(None);
        }
        if self.line.last() != Some(&b'\n') {
            return Err(if length as u64 == LONGEST {
                self.malformed("the line is too long: this is not a trajectory")
            } else {
                TrajectoryError::CutOff { frame: self.frame }
            });
        }
        match std::str::from_utf8(&self.line) {
            Ok(line) => Ok(Some(line.trim())),
            Err(_) => Err(self.malformed("this is not text")),
        }
    }

    /// The next line of the current frame.
    fn within(&mut self) -> Result<&str, TrajectoryError> {
        let frame = self.frame;
        self.next()?.ok_or(TrajectoryError::CutOff { frame })
    }

    /// The number of spheres of the next frame, if there is one.
    fn begin(&mut self) -> Result<Option<u32>, TrajectoryError> {
        loop {
            let Some(line) = self.next()? else { return Ok(None) };
            // Some files end with empty lines.
            if line.is_empty() {
                continue;
            }
            return match line.parse() {
                Ok(count) => Ok(Some(count)),
                Err(_) => Err(self.malformed("a frame must begin with the number of spheres")),
            };
        }
    }

    fn malformed(&self, what: impl Into<String>) -> TrajectoryError {
        TrajectoryError::malformed(format!("line {}", self.number), what)
    }

    /// The rest of a frame.
    fn frame(&mut self, count: u32) -> Result<TrajectoryFrame, TrajectoryError> {
        let comment = Comment::of(self.within()?).map_err(|what| self.malformed(what))?;
        let Comment { sweep, extents, columns } = comment;
        let mut positions = Vec::new();
        for _ in 0..count {
            let position = columns.position(self.within()?);
            positions.push(position.map_err(|what| self.malformed(what))?);
        }
        Ok(TrajectoryFrame { sweep, extents: Extents::Slab(extents), positions })
    }
}

pub(super) fn read(
    source: impl Read + Seek,
    number: Option<u64>,
) -> Result<TrajectoryFrame, TrajectoryError> {
    let reader = BufReader::new(source);
    let mut lines = Lines { reader, line: Vec::new(), number: 0, place: 0, frame: 0 };
    let mut last = None;
    loop {
        let before = (lines.number, lines.place);
        let Some(count) = lines.begin()? else { break };
        if number == Some(lines.frame) {
            return lines.frame(count);
        }
        for _ in 0..=count {
            lines.within()?;
        }
        last = Some(before);
        lines.frame += 1;
    }
    let (Some((line, place)), None) = (last, number) else {
        return Err(TrajectoryError::NoSuchFrame { number: number.unwrap_or(0), frames: lines.frame });
    };
    lines.reader.seek(SeekFrom::Start(place))?;
    (lines.number, lines.place, lines.frame) = (line, place, lines.frame - 1);
    match lines.begin()? {
        Some(count) => lines.frame(count),
        None => Err(TrajectoryError::CutOff { frame: lines.frame }),
    }
}

/// The content of the second line of a frame.
struct Comment {
    sweep: Option<u64>,
    extents: [f64; 3],
    columns: Columns,
}

impl Comment {
    fn of(line: &str) -> Result<Self, String> {
        let (mut lattice, mut sweep, mut columns) = (None, None, Columns::default());
        for (key, value) in pairs(line) {
            match key {
                "Lattice" => lattice = Some(value),
                "Properties" => columns = Columns::of(value)?,
                "sweep" => {
                    sweep = Some(
                        value.parse().map_err(|_| format!("sweep={value} is not the number of a sweep"))?,
                    );
                }
                "Origin" if numbers::<3>(value)? != [0.0; 3] => {
                    return Err("Origin must be 0 0 0, the corner of the slab at its base".into());
                }
                _ => {}
            }
        }
        let lattice = lattice.ok_or("there is no Lattice: this is not extended XYZ")?;
        let [height, a, b, c, width_y, d, e, f, width_z] = numbers(lattice)?;
        if [a, b, c, d, e, f].iter().any(|&cell| cell != 0.0) {
            return Err(format!("Lattice=\"{lattice}\" must be a box along the axes"));
        }
        Ok(Self { sweep, extents: [height, width_y, width_z], columns })
    }
}

/// Keys and values. Values may be in quotation marks; a word without a value has an empty one.
fn pairs(line: &str) -> impl Iterator<Item = (&str, &str)> {
    let mut rest = line;
    std::iter::from_fn(move || {
        rest = rest.trim_start();
        if rest.is_empty() {
            return None;
        }
        let (key, after) = rest.split_at(
            rest.find(|letter: char| letter == '=' || letter.is_whitespace()).unwrap_or(rest.len()),
        );
        let Some(after) = after.strip_prefix('=') else {
            rest = after;
            return Some((key, ""));
        };
        let (value, after) = match after.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"').unwrap_or((quoted, "")),
            None => after.split_at(after.find(char::is_whitespace).unwrap_or(after.len())),
        };
        rest = after;
        Some((key, value))
    })
}

/// The columns that are read: that of x, and that of the radius if there is one.
#[derive(Clone, Copy)]
struct Columns {
    position: usize,
    radius: Option<usize>,
    count: usize,
}

/// Columns if `Properties` is missing.
impl Default for Columns {
    fn default() -> Self {
        Self { position: 1, radius: None, count: 4 }
    }
}

impl Columns {
    /// Columns by `name:type:number`, repeated.
    fn of(properties: &str) -> Result<Self, String> {
        let parts: Vec<&str> = properties.split(':').collect();
        let (mut position, mut radius, mut count) = (None, None, 0_usize);
        for part in parts.chunks(3) {
            let &[name, element, width] = part else {
                return Err(format!("Properties={properties} must be made of name:type:number"));
            };
            let width = u8::from_str(width).map_err(|_| format!("Properties: {name} has {width} columns"))?;
            match (name, element, width) {
                ("pos", "R", 3) => position = Some(count),
                ("radius", "R", 1) => radius = Some(count),
                _ => {}
            }
            count += usize::from(width);
        }
        let position = position.ok_or_else(|| format!("Properties={properties} must contain pos:R:3"))?;
        Ok(Self { position, radius, count })
    }

    fn position(&self, line: &str) -> Result<Vector3<f64>, String> {
        let mut cells = line.split_ascii_whitespace();
        let mut position = Vector3::zeros();
        let mut found = 0;
        for (column, cell) in cells.by_ref().enumerate() {
            if let Some(coordinate) =
                column.checked_sub(self.position).and_then(|axis| position.get_mut(axis))
            {
                *coordinate = number(cell)?;
            } else if Some(column) == self.radius && number(cell)? != 0.5 {
                return Err(format!("the radius is {cell}, and must be 0.5: lengths are in diameters"));
            }
            found += 1;
        }
        if found != self.count {
            return Err(format!("there are {found} columns instead of {}", self.count));
        }
        Ok(position)
    }
}

fn numbers<const COUNT: usize>(value: &str) -> Result<[f64; COUNT], String> {
    let mut numbers = [0.0; COUNT];
    let mut cells = value.split_ascii_whitespace();
    for place in &mut numbers {
        *place = number(cells.next().unwrap_or(""))?;
    }
    if cells.next().is_some() {
        return Err(format!("\"{value}\" has more than {COUNT} numbers"));
    }
    Ok(numbers)
}

fn number(cell: &str) -> Result<f64, String> {
    match cell.parse() {
        Ok(number) if f64::is_finite(number) => Ok(number),
        _ => Err(format!("\"{cell}\" is not a finite number")),
    }
}

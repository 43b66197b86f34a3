//! Pictures: panels of lines (theory) and points with error bars (simulation), as SVG and PNG.

mod clip;
mod draw;

use super::{Failure, output};
use gradient_mc::statistics::Estimate;
use plotters::prelude::*;
pub use plotters::style::RGBColor;
use plotters::style::{FontStyle, register_font};
use std::path::Path;

/// Colors that remain apart for color-blind readers (Okabe and Ito), and on gray paper by
/// lightness.
pub mod colors {
    use plotters::style::RGBColor;
    pub const INK: RGBColor = RGBColor(34, 34, 34);
    pub const BLUE: RGBColor = RGBColor(0, 92, 158);
    pub const VERMILION: RGBColor = RGBColor(213, 94, 0);
    pub const GREEN: RGBColor = RGBColor(0, 140, 105);
    pub const PURPLE: RGBColor = RGBColor(170, 80, 140);
    pub const BROWN: RGBColor = RGBColor(150, 100, 20);
    pub const SKY: RGBColor = RGBColor(86, 180, 233);
    pub const GRAY: RGBColor = RGBColor(140, 140, 140);
}

/// Font family; viewers of the SVG may replace the embedded font.
const FONT: &str = "sans-serif";
static REGULAR: &[u8] = include_bytes!("fonts/DejaVuSans.ttf");
static BOLD: &[u8] = include_bytes!("fonts/DejaVuSans-Bold.ttf");

/// Plotters places everything on whole pixels, so pictures are drawn this many times larger and
/// then reduced: fine positions in the SVG, smooth edges in the PNG.
const OVERSAMPLING: u32 = 3;

/// A point with its error bar, if it has one.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    pub error: f64,
}

impl Point {
    pub fn of(x: f64, Estimate { mean, standard_error, .. }: Estimate) -> Self {
        Self { x, y: mean, error: standard_error }
    }

    /// With y in per cent.
    pub fn percent(x: f64, Estimate { mean, standard_error, .. }: Estimate) -> Self {
        Self { x, y: 100.0 * mean, error: 100.0 * standard_error }
    }
}

/// Style of a series.
#[derive(Debug, Clone, Copy)]
pub enum Mark {
    /// Theory.
    Line,
    /// Another theory.
    Dashed,
    /// Simulation.
    Points,
    /// Many points of simulation, too close for symbols of full size.
    Dots,
    /// Unreliable points, or points to be distinguished from others: open circles.
    Rings,
}

/// One set of data.
#[derive(Debug, Clone)]
pub struct Series {
    label: String,
    color: RGBColor,
    mark: Mark,
    points: Vec<Point>,
}

/// An axis with its label (quantity and unit), range, and about how many numbers it carries.
#[derive(Debug, Clone)]
#[must_use]
pub struct Axis {
    label: String,
    low: f64,
    high: f64,
    numbers: usize,
    logarithmic: bool,
}

impl Axis {
    pub fn new(label: &str, low: f64, high: f64) -> Self {
        Self { label: label.to_owned(), low, high, numbers: 6, logarithmic: false }
    }

    /// An axis with a number at every power of ten, or at fewer where there are many.
    pub fn logarithmic(label: &str, low: f64, high: f64) -> Self {
        Self { logarithmic: true, ..Self::new(label, low, high) }
    }

    /// Position of a value along the axis, on a linear scale.
    fn position(&self, value: f64) -> f64 {
        if self.logarithmic { libm::log10(value) } else { value }
    }

    /// The positions of both ends.
    fn range(&self) -> (f64, f64) {
        (self.position(self.low), self.position(self.high))
    }

    pub fn with_numbers(mut self, numbers: usize) -> Self {
        self.numbers = numbers;
        self
    }
}

/// A corner of a panel.
#[derive(Debug, Clone, Copy)]
pub enum Corner {
    TopLeft,
    TopRight,
    BottomLeft,
    BottomRight,
}

/// Place of a panel in the picture, as fractions of its size from the left and top.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

/// A rectangle of one color in a map.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    /// Both ends along x and along y.
    pub x: [f64; 2],
    pub y: [f64; 2],
    pub color: RGBColor,
}

/// Text inside a panel.
#[derive(Debug, Clone)]
struct Note {
    x: f64,
    y: f64,
    text: String,
    color: RGBColor,
}

/// A panel: axes and their content.
#[derive(Debug, Clone)]
#[must_use]
pub struct Panel {
    place: Place,
    title: Option<String>,
    x: Axis,
    y: Axis,
    cells: Vec<Cell>,
    series: Vec<Series>,
    notes: Vec<Note>,
    legend: Option<Corner>,
    /// Shares the axis below with the next panel.
    without_x_labels: bool,
    /// Is inside another panel, which is drawn before.
    inset: bool,
    /// Has neither axes nor numbers.
    bare: bool,
}

impl Panel {
    pub fn new(place: Place, x: Axis, y: Axis) -> Self {
        Self {
            place,
            title: None,
            x,
            y,
            cells: Vec::new(),
            series: Vec::new(),
            notes: Vec::new(),
            legend: None,
            without_x_labels: false,
            inset: false,
            bare: false,
        }
    }

    /// Sets the title above the panel.
    pub fn with_title(mut self, title: &str) -> Self {
        self.title = Some(title.to_owned());
        self
    }

    /// Makes the panel an inset of another, on white and with smaller letters; add it to the figure
    /// after the other panel.
    pub fn inset(mut self) -> Self {
        self.inset = true;
        self
    }

    /// Leaves out axes and numbers: for maps that name their rows and columns themselves.
    pub fn without_axes(mut self) -> Self {
        self.bare = true;
        self
    }

    /// Adds colored rectangles, below everything else.
    pub fn cells(mut self, cells: impl IntoIterator<Item = Cell>) -> Self {
        self.cells.extend(cells);
        self
    }

    /// Writes text centered at (x, y).
    pub fn note(mut self, x: f64, y: f64, text: &str, color: RGBColor) -> Self {
        self.notes.push(Note { x, y, text: text.to_owned(), color });
        self
    }

    pub fn with_legend(mut self, corner: Corner) -> Self {
        self.legend = Some(corner);
        self
    }

    /// Leaves the labels of the x axis to the panel below.
    pub fn without_x_labels(mut self) -> Self {
        self.without_x_labels = true;
        self
    }

    /// Adds a line through points (x, y); an empty label keeps it out of the legend.
    pub fn line(
        mut self,
        label: &str,
        color: RGBColor,
        mark: Mark,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let points = points.into_iter().map(|(x, y)| Point { x, y, error: 0.0 }).collect();
        self.series.push(Series { label: label.to_owned(), color, mark, points });
        self
    }

    /// Adds points with error bars.
    pub fn points(
        mut self,
        label: &str,
        color: RGBColor,
        mark: Mark,
        points: impl IntoIterator<Item = Point>,
    ) -> Self {
        let points = points.into_iter().collect();
        self.series.push(Series { label: label.to_owned(), color, mark, points });
        self
    }
}

/// A picture: a title above its panels.
#[derive(Debug, Clone)]
#[must_use]
pub struct Figure {
    title: String,
    size: (u32, u32),
    panels: Vec<Panel>,
}

impl Figure {
    pub fn new(title: &str) -> Self {
        Self { title: title.to_owned(), size: (1600, 700), panels: Vec::new() }
    }

    /// Sets width and height in pixels; the default is 1600 x 700.
    pub fn with_size(mut self, width: u32, height: u32) -> Self {
        self.size = (width, height);
        self
    }

    pub fn panel(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }

    /// Writes `<path>.svg` and `<path>.png`.
    pub fn save(&self, path: &Path) -> Result<(), Failure> {
        for (style, bytes) in [(FontStyle::Normal, REGULAR), (FontStyle::Bold, BOLD)] {
            register_font(FONT, style, bytes).map_err(|_| "the embedded font is damaged")?;
        }
        self.save_svg(&path.with_extension("svg"))?;
        self.save_png(&path.with_extension("png"))
    }

    fn drawn_size(&self) -> (u32, u32) {
        (self.size.0 * OVERSAMPLING, self.size.1 * OVERSAMPLING)
    }

    fn save_svg(&self, path: &Path) -> Result<(), Failure> {
        let (width, height) = self.drawn_size();
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
            draw::figure(self, &root, OVERSAMPLING)?;
            root.present().map_err(|error| error.to_string())?;
        }
        // Displayed at the size of the PNG; the view box keeps the finer grid.
        let drawn = format!("width=\"{width}\" height=\"{height}\"");
        let shown = format!("width=\"{}\" height=\"{}\"", self.size.0, self.size.1);
        output::write(path, text.replacen(&drawn, &shown, 1))
    }

    fn save_png(&self, path: &Path) -> Result<(), Failure> {
        let drawn = self.drawn_size();
        let mut pixels = vec![255; drawn.0 as usize * drawn.1 as usize * 3];
        {
            let root = BitMapBackend::with_buffer(&mut pixels, drawn).into_drawing_area();
            draw::figure(self, &root, OVERSAMPLING)?;
            root.present().map_err(|error| error.to_string())?;
        }
        let reduced = reduce(&pixels, self.size);
        let image: BitMapElement<'_, (i32, i32)> =
            BitMapElement::with_owned_buffer((0, 0), self.size, reduced)
                .ok_or("the picture has no pixels")?;
        output::write_by(path, |path| {
            let root = BitMapBackend::new(path, self.size).into_drawing_area();
            root.draw(&image).map_err(|error| error.to_string())?;
            root.present().map_err(|error| error.to_string().into())
        })
    }
}

/// Averages squares of pixels down to `size`.
fn reduce(pixels: &[u8], (width, height): (u32, u32)) -> Vec<u8> {
    let factor = OVERSAMPLING as usize;
    let (width, height) = (width as usize, height as usize);
    let mut reduced = Vec::with_capacity(width * height * 3);
    for index in 0..width * height * 3 {
        let (row, column, channel) = (index / (3 * width), index / 3 % width, index % 3);
        let sum: usize = (0..factor * factor)
            .map(|part| {
                let (y, x) = (row * factor + part / factor, column * factor + part % factor);
                usize::from(pixels[(y * width * factor + x) * 3 + channel])
            })
            .sum();
        // A mean of bytes is a byte.
        reduced.push(u8::try_from(sum / (factor * factor)).unwrap_or(u8::MAX));
    }
    reduced
}

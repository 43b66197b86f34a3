//! The one drawing routine, for whatever backend.

use super::{Axis, Corner, FONT, Figure, Mark, Panel, Series, clip, colors};
use crate::Failure;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

type Area<DB> = DrawingArea<DB, Shift>;
type Plane<DB> = DrawingArea<DB, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Sizes in pixels of the finished picture, times the oversampling.
#[derive(Clone, Copy)]
struct Pen {
    scale: u32,
}

impl Pen {
    fn pixels(self, size: f64) -> u32 {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let pixels = (size * f64::from(self.scale)).round() as u32;
        pixels
    }

    fn offset(self, size: f64) -> i32 {
        #[allow(clippy::cast_possible_truncation)]
        let offset = (size * f64::from(self.scale)).round() as i32;
        offset
    }

    fn stroke(self, color: RGBColor, width: f64) -> ShapeStyle {
        color.stroke_width(self.pixels(width))
    }

    fn text(self, size: f64) -> TextStyle<'static> {
        TextStyle::from((FONT, self.pixels(size))).color(&colors::INK)
    }
}

fn explain(error: impl std::fmt::Display) -> Failure {
    format!("cannot draw: {error}").into()
}

pub(crate) fn figure<DB: DrawingBackend>(
    figure: &Figure,
    root: &Area<DB>,
    scale: u32,
) -> Result<(), Failure> {
    let pen = Pen { scale };
    root.fill(&WHITE).map_err(explain)?;
    let (width, height) = (figure.size.0, figure.size.1);
    let title = TextStyle::from((FONT, pen.pixels(24.0), FontStyle::Bold))
        .color(&colors::INK)
        .pos(Pos::new(HPos::Center, VPos::Center));
    root.draw(&Text::new(
        figure.title.clone(),
        (pen.offset(f64::from(width) / 2.0), pen.offset(26.0)),
        title,
    ))
    .map_err(explain)?;
    for panel in &figure.panels {
        let place = panel.place;
        let corner = (pen.offset(place.left * f64::from(width)), pen.offset(place.top * f64::from(height)));
        let size = (pen.pixels(place.width * f64::from(width)), pen.pixels(place.height * f64::from(height)));
        draw_panel(panel, &root.clone().shrink(corner, size), pen)?;
    }
    Ok(())
}

fn draw_panel<DB: DrawingBackend>(panel: &Panel, area: &Area<DB>, pen: Pen) -> Result<(), Failure> {
    let letters = if panel.inset { 15.0 } else { 20.0 };
    if panel.inset {
        area.fill(&WHITE).map_err(explain)?;
    }
    let below = if panel.without_x_labels || panel.bare { 8.0 } else { 3.1 * letters };
    let beside = if panel.bare { 1.2 } else { 4.6 };
    let above = if panel.title.is_some() { 1.7 * letters } else { 6.0 };
    let ((x_low, x_high), (y_low, y_high)) = (panel.x.range(), panel.y.range());
    let mut chart = ChartBuilder::on(area)
        .margin_top(pen.pixels(above))
        .margin_right(pen.pixels(1.2 * letters))
        .x_label_area_size(pen.pixels(below))
        .y_label_area_size(pen.pixels(beside * letters))
        .build_cartesian_2d(x_low..x_high, y_low..y_high)
        .map_err(explain)?;
    let x_number =
        |value: &f64| if panel.without_x_labels { String::new() } else { number(*value, &panel.x) };
    let y_number = |value: &f64| number(*value, &panel.y);
    let plane = chart.plotting_area().clone();
    let mut mesh = chart.configure_mesh();
    if panel.bare {
        mesh.disable_mesh().disable_axes();
    }
    mesh.axis_style(pen.stroke(colors::INK, 1.3))
        .light_line_style(TRANSPARENT)
        .bold_line_style(pen.stroke(RGBColor(232, 232, 232), 1.0))
        .set_all_tick_mark_size(pen.pixels(5.0))
        .x_labels(ticks(&panel.x))
        .y_labels(ticks(&panel.y))
        .x_label_formatter(&x_number)
        .y_label_formatter(&y_number)
        .label_style(pen.text(letters - 2.0))
        .draw()
        .map_err(explain)?;

    draw_axis_labels(panel, area, &plane.get_pixel_range(), pen, letters)?;
    draw_cells(panel, &plane)?;
    for series in &panel.series {
        draw_series(series, panel, &plane, pen)?;
    }
    for note in &panel.notes {
        let (x, y) = plane.map_coordinate(&(panel.x.position(note.x), panel.y.position(note.y)));
        let style = pen.text(letters - 3.0).color(&note.color).pos(Pos::new(HPos::Center, VPos::Center));
        plane.use_screen_coord().draw(&Text::new(note.text.clone(), (x, y), style)).map_err(explain)?;
    }
    if let Some(corner) = panel.legend {
        draw_legend(panel, corner, &plane.strip_coord_spec(), pen, letters - 2.0)?;
    }
    Ok(())
}

/// About how many numbers an axis carries; on a logarithmic one, whole powers of ten if they are
/// not too many.
fn ticks(axis: &Axis) -> usize {
    if axis.logarithmic {
        let (low, high) = axis.range();
        // At most some hundreds.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let decades = (high - low).abs().ceil() as usize;
        (decades + 1).min(axis.numbers.max(9))
    } else {
        axis.numbers
    }
}

/// Colored rectangles, cut at the edges of the panel.
fn draw_cells<DB: DrawingBackend>(panel: &Panel, plane: &Plane<DB>) -> Result<(), Failure> {
    let inside = |value: f64, axis: &Axis| {
        let (low, high) = axis.range();
        axis.position(value).clamp(low.min(high), high.max(low))
    };
    for cell in &panel.cells {
        let corners = [0, 1].map(|end| (inside(cell.x[end], &panel.x), inside(cell.y[end], &panel.y)));
        plane.draw(&Rectangle::new(corners, cell.color.filled())).map_err(explain)?;
    }
    Ok(())
}

/// Labels of both axes, centered along them; `frame` is the plane in pixels of the whole picture.
fn draw_axis_labels<DB: DrawingBackend>(
    panel: &Panel,
    area: &Area<DB>,
    frame: &(Range<i32>, Range<i32>),
    pen: Pen,
    letters: f64,
) -> Result<(), Failure> {
    let (corner_x, corner_y) = area.get_base_pixel();
    let (_, height) = area.dim_in_pixel();
    let middle = |range: &Range<i32>| i32::midpoint(range.start, range.end);
    let style = pen.text(letters).pos(Pos::new(HPos::Center, VPos::Center));
    let vertical = style.clone().transform(FontTransform::Rotate270);
    let y_label = (pen.offset(0.9 * letters), middle(&frame.1) - corner_y);
    if let Some(title) = &panel.title {
        let place = (middle(&frame.0) - corner_x, pen.offset(0.8 * letters));
        area.draw(&Text::new(title.clone(), place, style.clone())).map_err(explain)?;
    }
    area.draw(&Text::new(panel.y.label.clone(), y_label, vertical)).map_err(explain)?;
    if !panel.without_x_labels {
        let x_label = (middle(&frame.0) - corner_x, i32::try_from(height)? - pen.offset(0.7 * letters));
        area.draw(&Text::new(panel.x.label.clone(), x_label, style)).map_err(explain)?;
    }
    Ok(())
}

fn draw_series<DB: DrawingBackend>(
    series: &Series,
    panel: &Panel,
    plane: &Plane<DB>,
    pen: Pen,
) -> Result<(), Failure> {
    let (x, y) = (panel.x.range(), panel.y.range());
    let place = |x: f64, y: f64| (panel.x.position(x), panel.y.position(y));
    let mark = Stroke::of(series, pen);
    if let Stroke::Line { .. } = mark {
        let points: Vec<_> = series.points.iter().map(|point| place(point.x, point.y)).collect();
        for part in clip::visible(&points, x, y) {
            let pixels = part.iter().map(|point| plane.map_coordinate(point)).collect();
            mark.draw_line(pixels, &plane.use_screen_coord())?;
        }
        return Ok(());
    }
    for point in &series.points {
        let center = place(point.x, point.y);
        if !((x.0..=x.1).contains(&center.0) && (y.0..=y.1).contains(&center.1)) {
            continue;
        }
        // On a logarithmic axis an error bar may reach below everything; the position is then not a number,
        // or -inf.
        let ends = [point.y - point.error, point.y + point.error].map(|end| panel.y.position(end));
        let ends = ends.map(|end| if end.is_nan() { y.0 } else { end.clamp(y.0, y.1) });
        let [low, high] = ends.map(|end| plane.map_coordinate(&(center.0, end)));
        mark.draw_point(plane.map_coordinate(&center), [low, high], &plane.use_screen_coord())?;
    }
    Ok(())
}

/// A mark with its sizes.
enum Stroke {
    Line { style: ShapeStyle, dash: Option<(u32, u32)> },
    Point { color: RGBColor, radius: u32, bar: ShapeStyle, open: bool },
}

impl Stroke {
    fn of(series: &Series, pen: Pen) -> Self {
        let style = pen.stroke(series.color, 2.6);
        let point = |radius, bar| Self::Point {
            color: series.color,
            radius: pen.pixels(radius),
            bar: pen.stroke(series.color, bar),
            open: matches!(series.mark, Mark::Rings),
        };
        match series.mark {
            Mark::Line => Self::Line { style, dash: None },
            Mark::Dashed => Self::Line { style, dash: Some((pen.pixels(11.0), pen.pixels(7.0))) },
            Mark::Points => point(4.0, 1.6),
            Mark::Rings => point(5.0, 1.6),
            Mark::Dots => point(2.3, 0.9),
        }
    }

    fn draw_line<DB: DrawingBackend>(
        &self,
        pixels: Vec<(i32, i32)>,
        area: &DrawingArea<DB, Shift>,
    ) -> Result<(), Failure> {
        let Self::Line { style, dash } = *self else { return Ok(()) };
        match dash {
            None => area.draw(&PathElement::new(pixels, style)).map_err(explain),
            Some((length, gap)) => {
                area.draw(&DashedPathElement::new(pixels, length, gap, style)).map_err(explain)
            }
        }
    }

    fn draw_point<DB: DrawingBackend>(
        &self,
        center: (i32, i32),
        ends: [(i32, i32); 2],
        area: &DrawingArea<DB, Shift>,
    ) -> Result<(), Failure> {
        let Self::Point { color, radius, bar, open } = *self else { return Ok(()) };
        area.draw(&PathElement::new(ends.to_vec(), bar)).map_err(explain)?;
        if open {
            area.draw(&Circle::new(center, radius, WHITE.filled())).map_err(explain)?;
            area.draw(&Circle::new(center, radius, bar)).map_err(explain)
        } else {
            area.draw(&Circle::new(center, radius, color.filled())).map_err(explain)
        }
    }
}

fn draw_legend<DB: DrawingBackend>(
    panel: &Panel,
    corner: Corner,
    area: &Area<DB>,
    pen: Pen,
    letters: f64,
) -> Result<(), Failure> {
    let entries: Vec<_> = panel.series.iter().filter(|series| !series.label.is_empty()).collect();
    let style = pen.text(letters).pos(Pos::new(HPos::Left, VPos::Center));
    let (sample, row, margin) = (pen.offset(44.0), pen.offset(1.45 * letters), pen.offset(14.0));
    let mut widest = 0;
    for series in &entries {
        let (width, _) = area.estimate_text_size(&series.label, &style).map_err(explain)?;
        widest = widest.max(i32::try_from(width)?);
    }
    let (width, height) = area.dim_in_pixel();
    let size = (sample + pen.offset(10.0) + widest, row * i32::try_from(entries.len())?);
    let right = i32::try_from(width)? - margin - size.0;
    let bottom = i32::try_from(height)? - margin - size.1;
    let (left, top) = match corner {
        Corner::TopLeft => (margin, margin),
        Corner::TopRight => (right, margin),
        Corner::BottomLeft => (margin, bottom),
        Corner::BottomRight => (right, bottom),
    };
    let pad = pen.offset(5.0);
    let frame = [(left - pad, top - pad), (left + size.0 + pad, top + size.1 + pad)];
    area.draw(&Rectangle::new(frame, WHITE.mix(0.85).filled())).map_err(explain)?;
    let mut middle = top + row / 2;
    for series in entries {
        let mark = Stroke::of(series, pen);
        mark.draw_line(vec![(left, middle), (left + sample, middle)], area)?;
        let (center, bar) = (left + sample / 2, pen.offset(9.0));
        mark.draw_point((center, middle), [(center, middle - bar), (center, middle + bar)], area)?;
        area.draw(&Text::new(
            series.label.clone(),
            (left + sample + pen.offset(10.0), middle),
            style.clone(),
        ))
        .map_err(explain)?;
        middle += row;
    }
    Ok(())
}

/// The number at a tick, with the decimals that the range of the axis calls for; a power of ten on
/// a logarithmic axis.
fn number(position: f64, axis: &Axis) -> String {
    if axis.logarithmic {
        return power_of_ten(position);
    }
    let step = (axis.high - axis.low).abs() / axis.numbers.max(1) as f64;
    let decimals = if step >= 1.0 {
        0
    } else if step >= 0.1 {
        1
    } else if step >= 0.01 {
        2
    } else {
        3
    };
    let text = format!("{position:.decimals$}");
    // A true minus sign, and no negative zero.
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|digit| digit == '0' || digit == '.') => digits.to_owned(),
        Some(digits) => format!("−{digits}"),
        None => text,
    }
}

/// 10 to a whole power as words; nothing between whole powers.
fn power_of_ten(exponent: f64) -> String {
    if (exponent - exponent.round()).abs() > 1e-6 {
        return String::new();
    }
    let raised = |character: char| match character {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => digit.to_digit(10).and_then(|digit| char::from_u32(0x2070 + digit)).unwrap_or(digit),
    };
    match format!("{:.0}", exponent.round()).as_str() {
        "0" | "-0" => "1".to_owned(),
        "1" => "10".to_owned(),
        exponent => std::iter::once("10".to_owned())
            .chain(exponent.chars().map(|character| raised(character).to_string()))
            .collect(),
    }
}

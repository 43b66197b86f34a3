//! Cuts lines at the edges of a panel.

/// The parts of a polyline that lie within the rectangle.
pub(crate) fn visible(points: &[(f64, f64)], x: (f64, f64), y: (f64, f64)) -> Vec<Vec<(f64, f64)>> {
    let mut parts: Vec<Vec<(f64, f64)>> = Vec::new();
    for pair in points.windows(2) {
        let Some((start, end)) = segment(pair[0], pair[1], x, y) else { continue };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&start) => part.push(end),
            _ => parts.push(vec![start, end]),
        }
    }
    parts
}

/// The part of a segment within the rectangle (Liang and Barsky).
fn segment(
    (x0, y0): (f64, f64),
    (x1, y1): (f64, f64),
    x: (f64, f64),
    y: (f64, f64),
) -> Option<((f64, f64), (f64, f64))> {
    let (dx, dy) = (x1 - x0, y1 - y0);
    let (mut enter, mut leave) = (0.0, 1.0);
    for (rise, room) in [(-dx, x0 - x.0), (dx, x.1 - x0), (-dy, y0 - y.0), (dy, y.1 - y0)] {
        if rise == 0.0 && room < 0.0 {
            return None;
        }
        if rise < 0.0 {
            enter = f64::max(enter, room / rise);
        } else if rise > 0.0 {
            leave = f64::min(leave, room / rise);
        }
    }
    let at = |t: f64| {
        if t == 0.0 {
            (x0, y0)
        } else if t >= 1.0 {
            (x1, y1)
        } else {
            (x0 + t * dx, y0 + t * dy)
        }
    };
    (enter < leave).then(|| (at(enter), at(leave)))
}

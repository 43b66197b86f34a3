//! Quadrature and differentiation shared by fields, temperatures, equations of state and drives.

/// Nodes on (0, 1) of the 8-point Gauss-Legendre rule, lower half; the rest by symmetry.
const NODES: [f64; 4] =
    [0.019_855_071_751_231_88, 0.101_666_761_293_186_63, 0.237_233_795_041_835_5, 0.408_282_678_752_175_1];
/// Weights of [`NODES`]; both halves together sum to 1.
const WEIGHTS: [f64; 4] =
    [0.050_614_268_145_188_13, 0.111_190_517_226_687_24, 0.156_853_322_938_943_64, 0.181_341_891_689_181];

/// Integral of `f` from `a` to `b` with one 8-point Gauss-Legendre panel (exact to degree 15).
pub(crate) fn integrate_panel(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let width = b - a;
    let sum: f64 = NODES
        .iter()
        .zip(WEIGHTS)
        .map(|(node, weight)| weight * (f(a + width * node) + f(b - width * node)))
        .sum();
    sum * width
}

/// Derivative of `f` at `x` by the five-point central difference with step `h`.
pub(crate) fn differentiate(f: impl Fn(f64) -> f64, x: f64, h: f64) -> f64 {
    (8.0 * (f(x + h) - f(x - h)) - (f(x + 2.0 * h) - f(x - 2.0 * h))) / (12.0 * h)
}

/// [`differentiate`] without values below `lowest`: within two steps of it the five points begin
/// there.
pub(crate) fn differentiate_above(f: impl Fn(f64) -> f64, x: f64, h: f64, lowest: f64) -> f64 {
    if !(x >= lowest && x < lowest + 2.0 * h) {
        return differentiate(f, x, h);
    }
    let t = (x - lowest) / h;
    // The derivative at t of the polynomial through the points 0 to 4.
    let points = 0..5_u32;
    let slope = |point: u32| {
        let others = move || (0..5_u32).filter(move |&other| other != point);
        let product = |left_out: u32| {
            others().filter(|&other| other != left_out).map(|other| t - f64::from(other)).product::<f64>()
        };
        let scale: f64 = others().map(|other| f64::from(point) - f64::from(other)).product();
        others().map(product).sum::<f64>() / scale
    };
    points.map(|point| slope(point) * f(lowest + f64::from(point) * h)).sum::<f64>() / h
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panel_is_exact_for_polynomials() {
        let integral = integrate_panel(|x| 16.0 * x.powi(15), 0.0, 2.0);
        approx::assert_relative_eq!(integral, 65_536.0, max_relative = 1e-14);
    }

    #[test]
    fn difference_is_exact_for_quartics() {
        let slope = differentiate(|x| x.powi(4), 1.5, 0.01);
        approx::assert_relative_eq!(slope, 13.5, max_relative = 1e-12);
        for x in [0.0, 0.004, 0.01, 0.019, 0.02, 0.5] {
            let above = |y: f64| if y < 0.0 { f64::NAN } else { 1.0 + y + y.powi(2) - y.powi(4) };
            let slope = differentiate_above(above, x, 0.01, 0.0);
            approx::assert_relative_eq!(slope, 1.0 + 2.0 * x - 4.0 * x.powi(3), max_relative = 1e-12);
        }
    }
}

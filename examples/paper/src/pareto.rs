//! Pareto fronts: points for which no other point has both a smaller cost and a smaller error.

/// Indices of the points (cost, error) on the front, ordered by cost, without NaN. Of equal points
/// the first is on the front.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&index| !points[index].0.is_nan() && !points[index].1.is_nan()).collect();
    order.sort_by(|&one, &other| {
        points[one].0.total_cmp(&points[other].0).then(points[one].1.total_cmp(&points[other].1))
    });
    let mut smallest = f64::INFINITY;
    order.retain(|&index| {
        let better = points[index].1 < smallest;
        if better {
            smallest = points[index].1;
        }
        better
    });
    order
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_is_dearer_and_no_better_is_not_on_the_front() {
        let points = [(2.0, 0.5), (1.0, 1.0), (3.0, 0.5), (4.0, 0.1), (0.5, f64::NAN), (1.0, 2.0)];
        assert_eq!(super::front(&points), [1, 0, 3]);
        assert!(super::front(&[]).is_empty());
    }
}

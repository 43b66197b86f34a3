//! From when on a series is steady.

use gradient_mc::observers::CenterOfMass;

/// The sweep from which on a center of mass is steady, by the marginal standard error rule: where
/// cutting makes Σ(x − x̄)²/n² of the rest least (White, doi:10.1177/003754979706900601). None if
/// that is in the second half.
///
/// `statistics::equilibration` asks for a rest of fifty correlation times, which the shortest of
/// these columns do not have: it would refuse them. This rule needs no correlation time.
pub(crate) fn steady_from(series: &CenterOfMass) -> Option<u64> {
    let heights = series.heights();
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    let mut best: Option<(f64, usize)> = None;
    // The steady value is near the last ones: less of them, sums of squares lose no digits.
    let last = *heights.last()?;
    for (start, height) in heights.iter().enumerate().rev() {
        let value = height - last;
        sum += value;
        squares += value * value;
        count += 1.0;
        let error = (squares - sum * sum / count) / (count * count);
        // The last few numbers are always similar.
        if count >= 16.0 && best.is_none_or(|(least, _)| error < least) {
            best = Some((error, start));
        }
    }
    let (_, start) = best?;
    (start <= heights.len() / 2).then(|| series.sweeps().get(start).copied())?
}

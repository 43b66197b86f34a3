#![allow(clippy::float_cmp)] // compares only what is exact

use super::*;
use crate::statistics::test_series::{Autoregressive, autoregressive};
use approx::assert_relative_eq;

fn averages(series: impl IntoIterator<Item = f64>) -> BlockAverages {
    let mut averages = BlockAverages::new(1).unwrap();
    for value in series {
        averages.push(&[value]).unwrap();
    }
    averages
}

#[test]
fn blocks_are_bounded_and_the_mean_is_of_everything() {
    let mut averages = BlockAverages::new(2).unwrap();
    let mut sum = 0.0;
    for (index, value) in Autoregressive::new(0.3, 3).take(10_007).enumerate() {
        averages.push(&[value, 1.0]).unwrap();
        sum += value;
        let count = index + 1;
        assert_eq!(averages.observations(), count as u64);
        let blocks = averages.blocks().len();
        assert!(blocks < 128 && (count < 64 || blocks >= 64));
        if count % 997 == 0 {
            assert_relative_eq!(averages.mean()[0], sum / count as f64, epsilon = 1e-13);
        }
    }
    assert_eq!(averages.block_length(), 128);
    assert_eq!(averages.blocks().len(), 10_007 / 128);
    assert!(averages.blocks().all(|block| (block[1] - 1.0).abs() < 1e-15));
    assert_eq!(averages.standard_errors().unwrap()[1], 0.0);
}

#[test]
fn errors_of_autoregressive_series_are_right() {
    const SERIES: u64 = 400;
    // Measured ratios to the exact error, each ± 20 %/√400 = 1 %, within four of those: the
    // documented bias.
    for (correlation, length, low, high) in [
        (0.0, 4096_u32, 1.12, 1.2),
        (0.0, 8190, 1.05, 1.13),
        (0.9, 4096, 1.1, 1.18),
        (0.98, 4096, 1.15, 1.25),
    ] {
        let exact = ((1.0 + correlation) / (1.0 - correlation) / f64::from(length)).sqrt();
        let ratio = (0..SERIES)
            .map(|seed| {
                let series = autoregressive(correlation, length as usize, seed);
                averages(series).standard_errors().unwrap()[0] / exact
            })
            .sum::<f64>()
            / SERIES as f64;
        assert!(ratio > low && ratio < high, "{correlation}, {length}: {ratio}");
    }
}

#[test]
fn jackknife_of_the_mean_is_the_standard_error_and_ratios_cancel_common_noise() {
    let mut averages = BlockAverages::new(2).unwrap();
    let mut noise = Autoregressive::new(0.0, 9);
    for common in Autoregressive::new(0.8, 8).take(5000) {
        // Correlated numerator and denominator, 2 % common and 0.2 % own noise.
        let denominator = 1.0 + 0.02 * common;
        averages.push(&[3.0 * denominator + 0.006 * noise.next().unwrap(), denominator]).unwrap();
    }
    let errors = averages.standard_errors().unwrap();
    let identity = averages.jackknife(<[f64]>::to_vec).unwrap();
    for ((estimate, error), mean) in identity.iter().zip(&errors).zip(averages.mean()) {
        assert_relative_eq!(estimate.standard_error, *error, max_relative = 1e-6);
        assert_eq!(estimate.mean, mean);
    }
    let ratio = averages.jackknife(|means| [means[0] / means[1]]).unwrap()[0];
    let exact = 0.006 / 5000.0_f64.sqrt();
    // The error of 4 to 7 % upward bias and 13 % scatter, three of them.
    assert!((ratio.standard_error / exact - 1.05).abs() < 0.4, "{}", ratio.standard_error / exact);
    assert!(ratio.deviation_from(3.0).abs() < 4.0);
    assert!(errors[0] > 3.0 * ratio.standard_error);
}

#[test]
fn merging_replicas_is_pushing_everything() {
    let series = autoregressive(0.5, 3 * 512, 4);
    let whole = averages(series.iter().copied());
    let mut pooled = averages(series[..512].iter().copied());
    pooled.merge(&averages(series[512..1024].iter().copied())).unwrap();
    pooled.merge(&averages(series[1024..].iter().copied())).unwrap();
    assert_eq!(pooled.observations(), 1536);
    assert_relative_eq!(pooled.mean()[0], whole.mean()[0], epsilon = 1e-14);
    // Replicas of 512 keep 64 blocks of 8 each; the whole has 96 of 16.
    assert_eq!((pooled.block_length(), pooled.blocks().len()), (8, 192));
    assert_eq!((whole.block_length(), whole.blocks().len()), (16, 96));
    let exact = (3.0_f64 / 1536.0).sqrt();
    for averages in [pooled, whole] {
        // Some 5 % too large, with a scatter of 15 %.
        let ratio = averages.standard_errors().unwrap()[0] / exact;
        assert!((ratio - 1.05).abs() < 0.6, "{ratio}");
    }
}

#[test]
fn replicas_of_any_lengths_lose_nothing_and_are_never_joined_to_blocks() {
    // Replica r holds only the number r: a block that crossed a boundary would mix them.
    let mut pooled = averages([]);
    let (mut sum, mut count) = (0.0, 0_u32);
    for (replica, length) in [(1.0, 777_u32), (2.0, 5), (3.0, 10_001), (4.0, 130), (5.0, 0), (6.0, 4000)] {
        let mut other = averages((0..length).map(|_| replica));
        // Merging merged accumulators, and pushing to one afterwards.
        other.merge(&averages([replica; 3])).unwrap();
        other.push(&[replica]).unwrap();
        pooled.merge(&other).unwrap();
        pooled.push(&[0.0]).unwrap();
        sum += replica * f64::from(length + 4);
        count += length + 5;
    }
    for _ in 0..300 {
        pooled.push(&[0.0]).unwrap();
    }
    count += 300;
    assert_eq!(pooled.observations(), u64::from(count));
    assert_relative_eq!(pooled.mean()[0], sum / f64::from(count), max_relative = 1e-14);
    assert!(pooled.blocks().all(|block| block[0].fract() == 0.0));
}

#[test]
fn misuse_is_a_typed_error_and_broken_numbers_stay_in_their_component() {
    assert!(matches!(BlockAverages::new(0), Err(Error::InvalidParameter { .. })));
    assert!(matches!(BlockAverages::new(usize::MAX), Err(Error::InvalidParameter { .. })));
    let mut two = BlockAverages::new(2).unwrap();
    assert!(matches!(two.push(&[1.0]), Err(Error::InvalidParameter { .. })));
    assert!(matches!(two.merge(&averages([])), Err(Error::InvalidParameter { .. })));
    assert!(two.mean()[0].is_nan());
    for index in 0..15 {
        two.push(&[f64::from(index), f64::from(index)]).unwrap();
    }
    let what = "observations for a standard error";
    let few = Err(Error::TooFewObservations { what, available: 15, needed: 16 });
    assert_eq!(format!("{:?}", two.standard_errors()), format!("{:?}", few as Result<(), Error>));
    two.push(&[f64::NAN, 1.0]).unwrap();
    let estimates = two.estimates().unwrap();
    assert!(estimates[0].mean.is_nan() && estimates[0].standard_error.is_nan());
    assert!(estimates[1].standard_error > 0.0);
    // Values missing from some calls count as NaN.
    let mut calls = 0;
    let uneven = two.jackknife(|means| {
        calls += 1;
        if calls == 1 { means.to_vec() } else { means[1..].to_vec() }
    });
    assert!(uneven.unwrap()[1].standard_error.is_nan());
}

#[test]
fn functions_of_halves_see_both_halves_and_lose_no_observation() {
    // Odd numbers of blocks, incomplete blocks, and a merged replica.
    let mut both = averages((0..5003).map(f64::from));
    both.merge(&averages((0..71).map(f64::from))).unwrap();
    let halves = both.of_halves(2, |[first, second], values| {
        values.copy_from_slice(&[0.5 * (first[0] + second[0]), second[0] - first[0]]);
    });
    assert_eq!(halves.observations(), both.observations());
    assert_eq!((both.block_length(), halves.block_length()), (64, 128));
    assert_eq!((both.blocks().len(), halves.blocks().len()), (78 + 1, 39));
    assert_relative_eq!(halves.mean()[0], both.mean()[0], max_relative = 1e-12);
    // What is not half of a complete block has no difference.
    for block in halves.blocks() {
        assert_relative_eq!(block[1], 64.0, max_relative = 1e-12);
    }
    assert_relative_eq!(halves.mean()[1], 64.0 * (39.0 * 128.0) / 5074.0, max_relative = 1e-12);
}

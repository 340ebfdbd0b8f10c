//! Random numbers of pixels and the functions they are made with, against closed forms.

use std::f32::consts::FRAC_PI_4;

use super::Random;
use crate::sensor_model::elementary::{cos_sin, exp, ln, rounded};
use crate::sensor_model::noise::{Key, Numbers, Patches, Stream};
use crate::sensor_model::texture::texture;

const ROWS: usize = 256;
const COLUMNS: usize = 2048;
const COUNT: usize = ROWS * COLUMNS;

/// How far the mean of so many numbers of deviation 1 may be off: 4 standard errors.
fn error(count: usize) -> f64 {
    4.0 / (count as f64).sqrt()
}

/// The first normal, the other normal and the exponential numbers of all rows.
fn sampled(seed: u64, stream: Stream) -> [Vec<f64>; 3] {
    let (mut numbers, mut all) = (Numbers::default(), [const { Vec::new() }; 3]);
    for row in 0..ROWS {
        numbers.sample(Key::new(seed, stream, row), COLUMNS);
        for (all, row) in all.iter_mut().zip([&numbers.normal, &numbers.other, &numbers.exponential]) {
            all.extend(row.iter().map(|&x| f64::from(x)));
        }
    }
    all
}

fn mean(numbers: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for x in numbers {
        sum += x;
        count += 1;
    }
    sum / f64::from(count)
}

fn correlation(one: &[f64], two: &[f64]) -> f64 {
    mean(one.iter().zip(two).map(|(a, b)| a * b))
}

/// The standard normal distribution: Abramowitz and Stegun, "Handbook of Mathematical Functions", 7.1.6, as a series.
fn below(x: f64) -> f64 {
    let (mut term, mut sum) = (x, x);
    for n in 1..200 {
        term *= x * x / f64::from(2 * n + 1);
        sum += term;
    }
    0.5 + sum * (-x * x / 2.0).exp() / (2.0 * std::f64::consts::PI).sqrt()
}

/// Kolmogorov and Smirnov's test, at 1 in 1000.
fn follows(mut numbers: Vec<f64>, distribution: impl Fn(f64) -> f64) {
    numbers.sort_by(f64::total_cmp);
    let count = numbers.len() as f64;
    let gap = |(k, &x): (usize, &f64)| (distribution(x) - (k as f64 + 0.5) / count).abs();
    let gap = numbers.iter().enumerate().map(gap).fold(0.0, f64::max);
    assert!(gap < 1.95 / count.sqrt(), "{gap}");
}

#[test]
fn normal_numbers_have_the_moments_the_shape_and_the_tails_of_a_normal_distribution() {
    for (seed, stream) in [(0, Stream::Pulses), (0, Stream::Stains), (u64::MAX, Stream::Pulses)] {
        let [one, other, _] = sampled(seed, stream);
        for numbers in [one, other] {
            let moment = |power: i32| mean(numbers.iter().map(|x| x.powi(power)));
            // the moments 1 to 4 and their standard deviations, roots of 1, 2, 15 and 96
            assert!(moment(1).abs() < error(COUNT));
            assert!((moment(2) - 1.0).abs() < 2_f64.sqrt() * error(COUNT));
            assert!(moment(3).abs() < 15_f64.sqrt() * error(COUNT));
            assert!((moment(4) - 3.0).abs() < 96_f64.sqrt() * error(COUNT));
            for limit in [2.0, 3.0, 4.0] {
                for side in [-1.0, 1.0] {
                    let beyond = numbers.iter().filter(|&&x| x * side > limit).count() as f64;
                    let expected = COUNT as f64 * below(-limit);
                    assert!(
                        (beyond - expected).abs() < 4.0 * expected.sqrt(),
                        "{beyond} beyond {limit}, not {expected}"
                    );
                }
            }
            assert!(numbers.iter().all(|x| x.abs() < 5.8));
            follows(numbers, below);
        }
    }
}

#[test]
fn exponential_numbers_have_the_moments_and_the_shape_of_an_exponential_distribution() {
    let [_, _, numbers] = sampled(3, Stream::Pulses);
    assert!((mean(numbers.iter().copied()) - 1.0).abs() < error(COUNT));
    assert!((mean(numbers.iter().map(|x| x * x)) - 2.0).abs() < 20_f64.sqrt() * error(COUNT));
    assert!(numbers.iter().all(|&x| x > 0.0 && x < 16.7));
    follows(numbers, |x| 1.0 - (-x).exp());
}

#[test]
fn numbers_are_independent_of_each_other_in_both_directions_and_from_stream_to_stream() {
    let [one, other, exponential] = sampled(5, Stream::Pulses);
    let exponential: Vec<f64> = exponential.iter().map(|x| x - 1.0).collect();
    let ([seeded, ..], [stains, ..]) = (sampled(6, Stream::Pulses), sampled(5, Stream::Stains));
    for (a, b) in [(&one, &other), (&one, &exponential), (&other, &exponential), (&one, &seeded), (&one, &stains)] {
        assert!(correlation(a, b).abs() < error(COUNT));
        // nor is one wide where the other is
        let square = |numbers: &[f64]| numbers.iter().map(|x| x * x - 1.0).collect::<Vec<_>>();
        assert!(correlation(&square(a), &square(b)).abs() < 5.0 * error(COUNT));
    }
    for numbers in [&one, &other, &exponential] {
        for away in [1, 2, 8, COLUMNS, 4 * COLUMNS] {
            assert!(correlation(&numbers[away..], numbers).abs() < error(COUNT), "{away}");
        }
    }
}

#[test]
fn patches_have_variance_1_change_slowly_and_are_independent_further_off() {
    let patches = Patches::new(1, Stream::Fading, ROWS, COLUMNS);
    let mut rows = vec![vec![0.0; COLUMNS]; ROWS];
    rows.iter_mut().enumerate().for_each(|(number, row)| patches.blend(number, row));
    let numbers: Vec<f64> = rows.concat().iter().map(|&x| f64::from(x)).collect();
    // as many independent numbers as there are patches
    let error = error(COUNT / 32);
    assert!(mean(numbers.iter().copied()).abs() < error);
    assert!((mean(numbers.iter().map(|x| x * x)) - 1.0).abs() < 2_f64.sqrt() * error);
    assert!(correlation(&numbers[1..], &numbers) > 0.9);
    assert!(correlation(&numbers[COLUMNS..], &numbers) > 0.8);
    assert!(correlation(&numbers[16..], &numbers).abs() < error);
    assert!(correlation(&numbers[8 * COLUMNS..], &numbers).abs() < error);
    follows(numbers.iter().copied().step_by(17).step_by(8).collect(), below);
}

#[test]
fn texture_has_variance_1_everywhere_is_alike_close_by_and_independent_further_off() {
    let mut random = Random(4);
    let points: Vec<[f32; 3]> = (0..100_000).map(|_| [(); 3].map(|()| random.between(0.0, 4000.0) as f32)).collect();
    let fields = |off: f32| {
        let (mut noise, mut heights) = (vec![0.0; points.len()], vec![0.0; points.len()]);
        let moved = [0, 1, 2].map(|axis| points.iter().map(|point| point[axis] + off).collect());
        texture(&moved, &mut noise, &mut heights);
        [noise, heights].map(|field| field.into_iter().map(f64::from).collect::<Vec<_>>())
    };
    for (field, least) in [(0, 0.6), (1, 0.7)] {
        let here = &fields(0.0)[field];
        assert!(mean(here.iter().copied()).abs() < error(points.len()));
        assert!((mean(here.iter().map(|x| x * x)) - 1.0).abs() < 2_f64.sqrt() * error(points.len()));
        let alike = [0.002, 0.02, 0.2, 2.0, 20.0].map(|off| correlation(here, &fields(off)[field]));
        assert!(alike.windows(2).take(3).all(|pair| pair[0] > pair[1]), "{alike:?}");
        assert!(alike[0] > 0.995 && alike[2] > least && alike[4].abs() < error(points.len()), "{alike:?}");
    }
}

#[test]
fn elementary_functions_are_right_to_some_units_in_the_last_place() {
    let mut random = Random(1);
    for _ in 0..200_000 {
        let x = random.between(-80.0, 80.0) as f32;
        let (found, expected) = (f64::from(exp(x)), f64::from(x).exp());
        assert!((found / expected - 1.0).abs() < 5e-7, "exp {x} is {found}, not {expected}");
        let x = expected as f32;
        let (found, expected) = (f64::from(ln(x)), f64::from(x).ln());
        assert!((found - expected).abs() < 3e-7 * expected.abs().max(0.5), "ln {x} is {found}, not {expected}");
        let x = random.between(0.5, 2.0) as f32;
        let (found, expected) = (f64::from(ln(x)), f64::from(x).ln());
        assert!((found - expected).abs() < 4e-7 * expected.abs().max(1e-3), "ln {x} is {found}, not {expected}");
        let x = random.between(-1.0, 1.0) as f32 * FRAC_PI_4;
        let (cosine, sine) = cos_sin(x);
        assert!((f64::from(cosine) - f64::from(x).cos()).abs() < 2e-7);
        assert!((f64::from(sine) - f64::from(x).sin()).abs() < 4e-7);
        let x = random.between(0.0, 2.1e6) as f32;
        assert_eq!(rounded(x), x.round_ties_even());
    }
    assert_eq!((exp(0.0), ln(1.0), rounded(0.5), rounded(1.5), rounded(1e9)), (1.0, 0.0, 0.0, 2.0, 1e9));
    assert!(exp(-1e9) < 2e-38 && exp(1e9) > 1e38);
}

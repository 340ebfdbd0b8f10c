//! Sub-rays become echoes: what is one, which counts, and how strong it is.

use super::Random;
use super::observe::ideal;
use crate::Backend;
use crate::sensor_model::mixed::Mixed;
use crate::sensor_model::receiver::{Echoes, receive, received_power};
use crate::sensor_model::{INCIDENCES, Returns, SensorModel, Surfaces};
use crate::simd::{self, Kernel, Lanes};

/// A model that sums up sub-rays of these shares in pulses of 75 cm, which last 5 ns.
fn model(shares: Vec<f32>) -> SensorModel {
    SensorModel { shares, ..ideal() }
}

/// The range, power and winning sub-ray of one beam.
fn echo(depth: &[f32], power: &[f32], last_return: bool) -> (f32, f32, u32) {
    let mut mixed = Mixed::default();
    (mixed.columns, mixed.depth, mixed.power) = (vec![0], depth.to_vec(), power.to_vec());
    mixed.separate(&SensorModel { last_return, ..model(Vec::new()) });
    (mixed.echo.depth[0], mixed.echo.power[0], mixed.echo.winner[0])
}

fn close(found: (f32, f32, u32), (depth, power, winner): (f32, f32, u32)) {
    let near = |a: f32, b: f32| (a - b).abs() <= 2e-6 * b.abs();
    assert!(near(found.0, depth) && near(found.1, power) && found.2 == winner, "{found:?}");
}

/// The powers of echoes of these responses and ranges.
fn power(depth: f32, response: f32, extinction: f32, model: &SensorModel) -> f32 {
    let mut power = [0.0];
    received_power(&[depth], response, extinction, model, &mut power);
    power[0]
}

#[test]
fn power_falls_with_the_square_of_range() {
    let model = SensorModel { detection_threshold: 0.1 / 50.0_f32.powi(2), ..ideal() };
    for (depth, response, expected) in [(10.0, 0.1, 25.0), (20.0, 0.1, 6.25), (0.0, 0.0, 0.0)] {
        let found = power(depth, response, 0.0, &model);
        assert!((found - expected).abs() <= 1e-6 * expected, "{found}, not {expected}");
    }
}

#[test]
fn the_air_takes_its_share_there_and_back() {
    let through = |extinction| power(30.0, 1.0, extinction, &SensorModel { detection_threshold: 1e-4, ..ideal() });
    let (passed, expected) = (through(0.02) / through(0.0), (-2.0 * 0.02 * 30.0_f32).exp());
    assert!((passed / expected - 1.0).abs() < 1e-6);
}

#[test]
fn echoes_within_a_pulse_are_one_at_their_mean_weighted_by_power() {
    close(echo(&[10.0, 10.0, 10.6], &[1.0, 1.0, 2.0], false), (10.3, 4.0, 2));
}

#[test]
fn of_echoes_apart_the_strongest_counts_though_a_single_ray_is_brighter() {
    close(echo(&[10.0, 30.0, 30.0], &[3.0, 2.0, 2.5], false), (30.0, 4.5, 2));
    close(echo(&[10.0, 30.0, 30.0], &[5.0, 2.0, 2.5], false), (10.0, 5.0, 0));
}

#[test]
fn the_last_return_counts_if_it_is_above_the_threshold() {
    close(echo(&[10.0, 30.0, 30.0], &[5.0, 0.6, 0.7], true), (30.0, 1.3, 2));
    close(echo(&[10.0, 30.0, 30.0], &[5.0, 0.2, 0.3], true), (10.0, 5.0, 0));
    close(echo(&[10.0, 30.0, 30.0], &[0.4, 0.2, 0.3], true), (30.0, 0.5, 2));
}

#[test]
fn sub_rays_that_meet_nothing_only_take_power_away() {
    assert_eq!(echo(&[0.0, 20.0, 0.0], &[0.0, 1.5, 0.0], false), (20.0, 1.5, 1));
    let nothing = echo(&[0.0; 3], &[0.0; 3], false);
    assert_eq!((nothing.0, nothing.1), (0.0, 0.0));
}

#[test]
fn a_single_ray_is_its_own_echo() {
    assert_eq!(echo(&[12.0], &[0.5], false), (12.0, 0.5, 0));
}

/// A row of beams of five sub-rays, which met these primitives; all surfaces send back half of the light.
fn received(depth: &[f32], primitive: &[i32], model: &SensorModel) -> Echoes {
    let (table, column) = (vec![[0.5; INCIDENCES]; 7], vec![0.0; 7]);
    let surfaces = Surfaces {
        table: &table,
        transmission: &column,
        behind: &column,
        grain: &column,
        texture: &column,
        rms_height: &column,
        unevenness: &column,
    };
    let (label, instance, incidence) = (vec![1; depth.len()], vec![0; depth.len()], vec![1.0; depth.len()]);
    let rays = Returns { depth, label: &label, instance: &instance, primitive, incidence: &incidence };
    let mut echoes = Echoes::default();
    simd::run(Backend::fastest(), Receive(&rays, &surfaces, model, &mut echoes));
    echoes
}

struct Receive<'a>(&'a Returns<'a>, &'a Surfaces<'a>, &'a SensorModel, &'a mut Echoes);

impl Kernel for Receive<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        receive::<L>(self.0, self.1, 0.0, self.2, self.3);
    }
}

#[test]
fn the_quick_way_and_the_careful_way_agree() {
    let mut random = Random(4);
    let (beams, rays) = (400, 5);
    let depth: Vec<f32> = (0..beams * rays).map(|_| random.between(10.0, 10.7) as f32).collect();
    let model = model(vec![0.1, 0.3, 0.2, 0.15, 0.25]);
    let many: Vec<i32> = (0..beams * rays).map(|k| (k / beams) as i32).collect();
    let quick = received(&depth, &vec![3; depth.len()], &model);
    let careful = received(&depth, &many, &model);
    assert_eq!((quick.mixed.columns.len(), careful.mixed.columns.len()), (0, beams));
    assert!(quick.primitive.iter().all(|&primitive| primitive == 3));
    for beam in 0..beams {
        let (a, b) = ((quick.depth[beam], quick.power[beam]), (careful.depth[beam], careful.power[beam]));
        assert!((a.0 / b.0 - 1.0).abs() < 1e-6 && (a.1 / b.1 - 1.0).abs() < 1e-6, "{a:?} and {b:?}");
        let power = |ray: usize| model.shares[ray] / depth[ray * beams + beam].powi(2);
        let brightest = (0..rays).max_by(|&a, &b| power(a).total_cmp(&power(b))).unwrap();
        assert_eq!(careful.mixed.echo.winner[beam] as usize, brightest);
        assert_eq!(careful.primitive[beam], brightest as i32);
    }
}

#[test]
fn sub_rays_far_apart_on_one_primitive_are_not_one_echo() {
    let model = model(vec![0.5, 0.3, 0.2]);
    let echoes = received(&[10.0, 0.0, 20.0, 0.0, 20.0, 0.0], &[2, -1, 2, -1, 2, -1], &model);
    assert_eq!((echoes.depth[0], echoes.mixed.echo.winner[0], echoes.depth[1]), (10.0, 0, 0.0));
}

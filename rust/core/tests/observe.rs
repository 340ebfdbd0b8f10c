//! The sensor model as a whole: what it checks, and that threads change nothing.

use crate::sensor_model::{
    Backscatter, INCIDENCES, Light, Places, Ranging, Returns, ReturnsMut, SensorModel, Surfaces, observe_with,
};
use crate::{Backend, Error, Pose, SensorPattern, SensorSpec};

/// A model with every effect off.
pub(super) fn ideal() -> SensorModel {
    SensorModel {
        shares: vec![1.0],
        pulse_duration: 5e-9,
        detection_threshold: 0.0,
        last_return: false,
        glass_transmission: false,
        speckle: 0.0,
        texture: 0.0,
        material_noise: false,
        dust: 0.0,
        fading: 0.0,
        drop_exponent: 0.0,
        edge_drop: 0.0,
        unit: 0,
        range_offsets: Vec::new(),
        offset_spread: 0.0,
        gain_spread: 0.0,
        jitter: 0.0,
        range_step: 0.0,
        full_scale: 1.0,
        knee: 1.0,
        cutoff: 0.0,
        cutoff_spread: 0.0,
        levels: 0.0,
        least_reading: 0.0,
        compensation_range: f32::INFINITY,
        intensity_curve: None,
    }
}

/// Rays of so many rows, one at least, and columns, a whole turn.
fn pattern(rows: usize, columns: usize) -> SensorPattern {
    let rows = rows.max(1);
    SensorPattern::new(SensorSpec {
        elevations: (0..rows).map(|row| 0.2 - 0.0005 * row as f64).collect(),
        azimuth_offsets: vec![0.0; rows],
        origins: vec![[0.0; 3]; rows],
        columns,
        azimuth_start: std::f64::consts::PI,
        azimuth_span: std::f64::consts::TAU,
        min_range: 0.5,
        max_range: 120.0,
    })
    .unwrap()
}

/// Every effect on.
fn lively() -> SensorModel {
    SensorModel {
        shares: vec![0.2, 0.3, 0.5],
        detection_threshold: 1e-4,
        glass_transmission: true,
        speckle: 0.05,
        texture: 0.06,
        material_noise: true,
        dust: 1.0,
        fading: 1.6,
        drop_exponent: 0.01,
        edge_drop: 0.5,
        unit: 3,
        offset_spread: 0.02,
        cutoff: 0.1,
        cutoff_spread: 0.05,
        gain_spread: 0.1,
        jitter: 0.09,
        range_step: 0.002,
        knee: 0.4,
        full_scale: 300.0,
        levels: 255.0,
        compensation_range: 40.0,
        intensity_curve: None,
        ..ideal()
    }
}

/// A sensor with noise.
const RANGING: Ranging = Ranging { sigma: 0.02, min: 0.5, max: 120.0 };

/// Rows and columns, and rows that no number of threads divides.
const SHAPE: [usize; 2] = [19, 61];

/// The images of a scan, to be compared.
#[derive(Clone, Debug, PartialEq)]
struct Scan {
    depth: Vec<f32>,
    label: Vec<u8>,
    instance: Vec<u32>,
    primitive: Vec<i32>,
    incidence: Vec<f32>,
    intensity: Vec<f32>,
}

/// What a model makes of walls, windows and sky in turn; `spoil` changes what it is given.
fn seen(model: &SensorModel, seed: u64, threads: usize, spoil: impl Fn(&mut Light<'_>)) -> Result<Scan, Error> {
    seen_with(Backend::fastest(), model, seed, threads, spoil)
}

fn seen_with(
    backend: Backend,
    model: &SensorModel,
    seed: u64,
    threads: usize,
    spoil: impl Fn(&mut Light<'_>),
) -> Result<Scan, Error> {
    let [rows, columns] = SHAPE;
    let (pixels, rays) = (rows * columns, rows * columns * model.shares.len());
    let met = |k: usize| (k / 7 % 4) as i32 - 1;
    let depth: Vec<f32> = (0..rays).map(|k| if met(k) < 0 { 0.0 } else { 5.0 + 9.0 * met(k) as f32 }).collect();
    let label: Vec<u8> = (0..rays).map(|k| (met(k) + 1) as u8).collect();
    let instance: Vec<u32> = label.iter().map(|&label| u32::from(label) * 100).collect();
    let primitive: Vec<i32> = (0..rays).map(met).collect();
    let incidence: Vec<f32> = (0..rays).map(|k| if met(k) < 0 { 0.0 } else { 0.7 }).collect();
    let table: Vec<[f32; INCIDENCES]> = [0.0, 0.4, 0.02, 0.3].map(|back| [back; INCIDENCES]).to_vec();
    let pattern = pattern(rows * model.shares.len(), columns);
    let places = Places { rays: &pattern, poses: &[Pose::IDENTITY] };
    let (fog, weak) = (vec![2.0; pixels], vec![1e-4; pixels]);
    let returns =
        Returns { depth: &depth, label: &label, instance: &instance, primitive: &primitive, incidence: &incidence };
    let surfaces = Surfaces {
        table: &table,
        transmission: &[0.0, 0.0, 0.7, 0.0],
        behind: &[0.0, 0.0, 0.3, 0.0],
        grain: &[0.0, 0.1, 0.05, 0.2],
        texture: &[0.0, 1.0, 0.0, 1.0],
        rms_height: &[0.0, 0.0, 0.0, 0.02],
        unevenness: &[0.0, 0.01, 0.0, 0.03],
    };
    let backscatter = [Backscatter { depth: &fog, response: &weak }];
    let mut light = Light { returns, surfaces, backscatter: &backscatter, extinction: 0.001, shape: SHAPE, places };
    spoil(&mut light);
    let mut scan = Scan {
        depth: vec![9.0; pixels],
        label: vec![9; pixels],
        instance: vec![9; pixels],
        primitive: vec![9; pixels],
        incidence: vec![9.0; pixels],
        intensity: vec![9.0; pixels],
    };
    let mut written = ReturnsMut {
        depth: &mut scan.depth,
        label: &mut scan.label,
        instance: &mut scan.instance,
        primitive: &mut scan.primitive,
        incidence: &mut scan.incidence,
        intensity: &mut scan.intensity,
    };
    observe_with(backend, &light, RANGING, model, seed, &mut written, threads)?;
    Ok(scan)
}

#[test]
fn a_scan_is_the_same_for_any_number_of_threads_and_another_for_another_seed() {
    let model = lively();
    let one = seen(&model, 7, 1, |_| ()).unwrap();
    for threads in [0, 2, 5] {
        assert_eq!(seen(&model, 7, threads, |_| ()).unwrap(), one);
    }
    assert_ne!(seen(&model, 8, 1, |_| ()).unwrap(), one);
    assert_ne!(seen(&SensorModel { unit: 4, ..model }, 7, 1, |_| ()).unwrap(), one);
}

#[test]
fn a_scan_is_the_same_bit_for_bit_with_every_backend() {
    for model in [lively(), SensorModel { last_return: true, knee: 1.0, ..lively() }] {
        let plain = seen_with(Backend::Portable, &model, 7, 1, |_| ()).unwrap();
        for backend in Backend::available() {
            assert_eq!(seen_with(backend, &model, 7, 1, |_| ()).unwrap(), plain, "{}", backend.name());
        }
    }
}

#[test]
fn no_return_is_nothing_in_every_image() {
    let scan = seen(&SensorModel { drop_exponent: 0.5, ..lively() }, 0, 1, |_| ()).unwrap();
    let dropped = |k: &usize| scan.depth[*k] == 0.0;
    assert!((0..scan.depth.len()).filter(dropped).count() > scan.depth.len() / 3);
    for k in (0..scan.depth.len()).filter(dropped) {
        assert_eq!((scan.label[k], scan.instance[k], scan.primitive[k]), (0, 0, -1));
        assert_eq!((scan.incidence[k], scan.intensity[k]), (0.0, 0.0));
    }
    // and what returns is a surface, or the air
    for k in (0..scan.depth.len()).filter(|k| !dropped(k)) {
        assert_eq!(i32::from(scan.label[k]), scan.primitive[k] + 1);
        assert_eq!(scan.instance[k], u32::from(scan.label[k]) * 100);
        assert!(scan.primitive[k] >= 0 || scan.depth[k] < 3.0);
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let refused = |model: &SensorModel, spoil: fn(&mut Light<'_>)| seen(model, 0, 1, spoil).unwrap_err().to_string();
    let model = ideal();
    assert_eq!(
        refused(&model, |light| light.returns.label = &light.returns.label[1..]),
        "the label image has 1158 pixels; the sensor model needs 1159"
    );
    assert_eq!(
        refused(&model, |light| light.shape = [18, 61]),
        "the depth image has 1159 pixels; the sensor model needs 1098"
    );
    assert_eq!(
        refused(&model, |light| light.surfaces.grain = &light.surfaces.grain[1..]),
        "grain has 3 entries; the table of responses has 4"
    );
    let short = |light: &mut Light<'_>| {
        let surfaces = &mut light.surfaces;
        (surfaces.table, surfaces.transmission) = (&surfaces.table[..3], &surfaces.transmission[..3]);
        (surfaces.grain, surfaces.rms_height) = (&surfaces.grain[..3], &surfaces.rms_height[..3]);
        surfaces.unevenness = &surfaces.unevenness[..3];
        (surfaces.behind, surfaces.texture) = (&surfaces.behind[..3], &surfaces.texture[..3]);
    };
    assert_eq!(refused(&model, short), "the image shows primitive 2; the layout has 2");
    let many = SensorModel { shares: vec![0.03; 33], ..ideal() };
    assert_eq!(refused(&many, |_| ()), "a beam has 33 sub-rays; it must be 1 to 32");
    assert_eq!(
        refused(&SensorModel { shares: Vec::new(), ..ideal() }, |_| ()),
        "a beam has 0 sub-rays; it must be 1 to 32"
    );
}

#[test]
fn a_number_that_cannot_be_is_named_with_its_limit() {
    let says = |model: SensorModel, message: &str| assert_eq!(model.check().unwrap_err().to_string(), message);
    says(SensorModel { speckle: -1.0, ..ideal() }, "speckle is -1; it must be finite and 0 or more");
    says(SensorModel { levels: f32::NAN, ..ideal() }, "levels is NaN; it must be finite and 0 or more");
    says(SensorModel { jitter: f32::INFINITY, ..ideal() }, "jitter is inf; it must be finite and 0 or more");
    says(SensorModel { pulse_duration: 0.0, ..ideal() }, "pulse_duration is 0; it must be finite and greater than 0");
    says(SensorModel { full_scale: 0.0, ..ideal() }, "full_scale is 0; it must be finite and greater than 0");
    says(SensorModel { drop_exponent: 1.5, ..ideal() }, "drop_exponent is 1.5; it must be 0 to 1");
    says(SensorModel { knee: 1.25, ..ideal() }, "knee is 1.25; it must be greater than 0 and at most 1");
    says(SensorModel { compensation_range: 0.0, ..ideal() }, "compensation_range is 0; it must be greater than 0");
    let broken = SensorModel { knee: 0.0, ..ideal() };
    assert_eq!(seen(&broken, 0, 1, |_| ()).unwrap_err(), broken.check().unwrap_err());
    assert!(ideal().check().is_ok() && lively().check().is_ok());
}

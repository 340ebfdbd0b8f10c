//! From clean returns to the returns of a real sensor. `effects` has one function for each effect; [`observe`] calls
//! them all.

mod effects;
pub(crate) mod elementary;
mod images;
mod intensity_curve;
pub(crate) mod mixed;
mod model;
pub(crate) mod noise;
pub(crate) mod receiver;
mod surfaces;
pub(crate) mod texture;

pub use images::{Backscatter, Returns, ReturnsMut};
pub use intensity_curve::IntensityCurve;
pub use model::{MOST_RAYS, Ranging, SensorModel};
pub use surfaces::{INCIDENCES, Surfaces};
pub use texture::Places;

use crate::simd::{self, Kernel, Lanes};
use crate::threads::spread;
use crate::{Backend, Result};
use effects::{
    add_backscatter, dim_by_dust, drop_rays, intensity, range_noise, roughness, scatter_power, transmit_through_glass,
    uneven,
};
use noise::{Key, Numbers, Patches, Stream};
use receiver::{Echoes, receive};
use texture::{Points, texture};

/// Rows that one thread takes at once.
const BAND: usize = 8;

/// The light that comes back to a sensor.
#[derive(Clone, Copy, Debug)]
pub struct Light<'a> {
    /// Where the sub-rays ended.
    pub returns: Returns<'a>,
    /// The light that the surfaces there return.
    pub surfaces: Surfaces<'a>,
    /// The light that the air in front of them returns.
    pub backscatter: &'a [Backscatter<'a>],
    /// Light lost on a metre of air [1/m]; there and back it is twice that.
    pub extinction: f32,
    /// Rows and columns of the sensor.
    pub shape: [usize; 2],
    /// Where its beams end in the world.
    pub places: Places<'a>,
}

/// Writes to `scan` the sensor's returns of the light that comes back.
///
/// `seed` decides all that is random: a pure function of it, the row and the column; what belongs to the unit of the
/// sensor is one of `model.unit`. `threads` is 0 for as many as there are cores; the images are the same for any
/// number.
///
/// # Errors
/// Those of [`SensorModel::check`], [`Error::CurveTable`], [`Error::OffsetTable`], [`Error::ObservedSize`],
/// [`Error::SurfaceColumn`] or [`Error::ImagePrimitive`], before anything is written.
pub fn observe(
    light: &Light<'_>,
    ranging: Ranging,
    model: &SensorModel,
    seed: u64,
    scan: &mut ReturnsMut<'_>,
    threads: usize,
) -> Result<()> {
    observe_with(Backend::fastest(), light, ranging, model, seed, scan, threads)
}

/// The same with the vectors of one backend; all of them make the same bits.
pub(crate) fn observe_with(
    backend: Backend,
    light: &Light<'_>,
    ranging: Ranging,
    model: &SensorModel,
    seed: u64,
    scan: &mut ReturnsMut<'_>,
    threads: usize,
) -> Result<()> {
    let [rows, columns] = light.shape;
    model.check()?;
    model.intensity_curve.as_ref().map_or(Ok(()), |curve| curve.check(rows))?;
    model.check_offsets(rows)?;
    light.returns.check(rows * columns * model.shares.len())?;
    light.surfaces.check(light.returns.primitive)?;
    light.places.check(rows * model.shares.len(), columns)?;
    light.backscatter.iter().try_for_each(|echoes| echoes.check(rows * columns))?;
    scan.check(rows * columns)?;

    let observer = Observer::new(light, ranging, model, seed);
    let bands = scan.bands(BAND * columns).into_iter().enumerate().collect();
    spread(threads, bands, |(band, scan): (usize, ReturnsMut<'_>)| {
        simd::run(backend, ObserveRows { observer: &observer, first: band * BAND, scan });
    });
    Ok(())
}

/// The values shared by all rows of a scan.
struct Observer<'a> {
    light: &'a Light<'a>,
    ranging: Ranging,
    model: &'a SensorModel,
    seed: u64,
    /// The pose of the head in each column, if surfaces have a texture or are uneven.
    heads: [Points; 4],
    /// Where echoes fade.
    patches: Patches,
    /// The dust on the window.
    stains: Option<Patches>,
    /// Two normal numbers for each beam of the unit, for offset and gain.
    beams: Numbers,
    /// And two more, for the cut-off.
    cutoffs: Numbers,
}

/// Some rows, to be observed with the widest vectors of this machine: the compiler makes them of loops over pixels.
///
/// Nothing is fused or reordered, so the bits are the same with any. What is called is inlined, or it would be compiled
/// for any machine.
struct ObserveRows<'a> {
    observer: &'a Observer<'a>,
    first: usize,
    scan: ReturnsMut<'a>,
}

impl Kernel for ObserveRows<'_> {
    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        self.observer.observe_rows::<L>(self.first, &mut self.scan);
    }
}

/// The buffers of a row.
struct Row {
    echoes: Echoes,
    numbers: Numbers,
    patches: Vec<f32>,
    points: Points,
    texture: Vec<f32>,
    heights: Vec<f32>,
    stains: Vec<f32>,
    work: Vec<f32>,
    dropped: Vec<bool>,
}

impl Row {
    fn new(columns: usize) -> Row {
        Row {
            echoes: Echoes::default(),
            numbers: Numbers::default(),
            patches: vec![0.0; columns],
            points: Points::default(),
            texture: vec![0.0; columns],
            heights: vec![0.0; columns],
            stains: vec![0.0; columns],
            work: vec![0.0; columns],
            dropped: vec![false; columns],
        }
    }
}

impl<'a> Observer<'a> {
    fn new(light: &'a Light<'a>, ranging: Ranging, model: &'a SensorModel, seed: u64) -> Observer<'a> {
        let [rows, columns] = light.shape;
        let patches = Patches::new(seed, Stream::Fading, rows, columns);
        let stains = (model.dust > 0.0).then(|| Patches::new(model.unit, Stream::Stains, rows, columns));
        let mut beams = Numbers::default();
        beams.sample(Key::new(model.unit, Stream::Beams, 0), rows);
        let mut cutoffs = Numbers::default();
        cutoffs.sample(Key::new(model.unit, Stream::Cutoffs, 0), rows);
        let heads = if model.texture > 0.0 || model.material_noise { light.places.heads() } else { Default::default() };
        Observer { light, ranging, model, seed, heads, patches, stains, beams, cutoffs }
    }

    #[inline(always)]
    fn observe_rows<L: Lanes>(&self, first: usize, scan: &mut ReturnsMut<'_>) {
        let columns = self.light.shape[1];
        let mut row = Row::new(columns);
        for (k, mut scan) in scan.bands(columns).into_iter().enumerate() {
            self.observe_row::<L>(first + k, &mut row, &mut scan);
        }
    }

    /// The effects in the order of the light.
    #[inline(always)]
    fn observe_row<L: Lanes>(&self, number: usize, row: &mut Row, scan: &mut ReturnsMut<'_>) {
        let (model, surfaces, extinction) = (self.model, &self.light.surfaces, self.light.extinction);
        let columns = self.light.shape[1];
        let Row { echoes, numbers, patches, points, texture: field, heights, stains, work, dropped } = row;
        let returns = self.light.returns.row(number, columns * model.shares.len());
        numbers.sample(Key::new(self.seed, Stream::Pulses, number), columns);
        self.patches.blend(number, patches);
        if let Some(dust) = &self.stains {
            dust.blend(number, stains);
        }

        receive::<L>(&returns, surfaces, extinction, model, echoes);
        if model.texture > 0.0 || model.material_noise {
            let rays = model.shares.len();
            self.light.places.along(&self.heads, number * rays + rays / 2, &echoes.depth, points);
            texture(points, field, heights);
            echoes.look_up::<L>(surfaces.texture, work);
            field.iter_mut().zip(&*work).for_each(|(field, &of_surface)| *field *= of_surface);
        }
        transmit_through_glass(echoes, patches, surfaces, model);
        let gain = self.beams.other[number] * model.gain_spread;
        scatter_power::<L>(echoes, gain, field, work, &numbers.normal, surfaces, model);
        dim_by_dust(echoes, stains, model);
        for backscatter in self.light.backscatter {
            add_backscatter(echoes, &backscatter.row(number, columns), work, extinction, model);
        }
        drop_rays(echoes, patches, &numbers.exponential, model, dropped);
        let cutoff = model.cutoff + model.cutoff_spread * self.cutoffs.normal[number];
        intensity(echoes, number, cutoff, model, scan.intensity);
        uneven::<L>(echoes, heights, surfaces, model, work);
        roughness::<L>(echoes, surfaces, model, work);
        let known = model.range_offsets.get(number).copied().unwrap_or(0.0);
        range_noise(
            echoes,
            known + self.beams.normal[number] * model.offset_spread,
            work,
            &numbers.other,
            &self.ranging,
            model,
        );
        scan.write(&returns, echoes, dropped);
    }
}

//! The images that the sensor model reads and writes.

use super::Surfaces;
use super::receiver::Echoes;
use crate::{Error, Result};

/// Clean returns of the sub-rays of a sensor: row h * S + s is sub-ray s of beam h.
#[derive(Clone, Copy, Debug)]
pub struct Returns<'a> {
    /// Distances along the rays [m], 0 for no return.
    pub depth: &'a [f32],
    /// Classes.
    pub label: &'a [u8],
    /// Instances.
    pub instance: &'a [u32],
    /// Indices of the primitives, -1 for no return.
    pub primitive: &'a [i32],
    /// Cosines of incidence.
    pub incidence: &'a [f32],
}

/// The images of a sensor's scan, to be written: 0 in all images and -1 in `primitive` without a return.
#[derive(Debug)]
pub struct ReturnsMut<'a> {
    /// Measured ranges [m].
    pub depth: &'a mut [f32],
    /// Classes.
    pub label: &'a mut [u8],
    /// Instances.
    pub instance: &'a mut [u32],
    /// Indices of the primitives.
    pub primitive: &'a mut [i32],
    /// Cosines of incidence.
    pub incidence: &'a mut [f32],
    /// Intensities, 0 to 1.
    pub intensity: &'a mut [f32],
}

/// The echo of something in the air in front of each beam.
#[derive(Clone, Copy, Debug)]
pub struct Backscatter<'a> {
    /// Distances [m], 0 without a hit.
    pub depth: &'a [f32],
    /// The share of the light that comes back.
    pub response: &'a [f32],
}

impl Returns<'_> {
    pub(super) fn check(&self, pixels: usize) -> Result<()> {
        same_size("depth", self.depth.len(), pixels)?;
        same_size("label", self.label.len(), pixels)?;
        same_size("instance", self.instance.len(), pixels)?;
        same_size("primitive", self.primitive.len(), pixels)?;
        same_size("incidence", self.incidence.len(), pixels)
    }

    /// Row `number` of rows of this many pixels.
    pub(super) fn row(&self, number: usize, pixels: usize) -> Returns<'_> {
        let row = number * pixels..(number + 1) * pixels;
        Returns {
            depth: &self.depth[row.clone()],
            label: &self.label[row.clone()],
            instance: &self.instance[row.clone()],
            primitive: &self.primitive[row.clone()],
            incidence: &self.incidence[row],
        }
    }
}

impl Backscatter<'_> {
    pub(super) fn check(&self, pixels: usize) -> Result<()> {
        same_size("backscatter depth", self.depth.len(), pixels)?;
        same_size("backscatter response", self.response.len(), pixels)
    }

    pub(super) fn row(&self, number: usize, columns: usize) -> Backscatter<'_> {
        let row = number * columns..(number + 1) * columns;
        Backscatter { depth: &self.depth[row.clone()], response: &self.response[row] }
    }
}

impl ReturnsMut<'_> {
    pub(super) fn check(&self, pixels: usize) -> Result<()> {
        same_size("observed depth", self.depth.len(), pixels)?;
        same_size("observed label", self.label.len(), pixels)?;
        same_size("observed instance", self.instance.len(), pixels)?;
        same_size("observed primitive", self.primitive.len(), pixels)?;
        same_size("observed incidence", self.incidence.len(), pixels)?;
        same_size("observed intensity", self.intensity.len(), pixels)
    }

    /// Pieces of this many pixels.
    pub(super) fn bands(&mut self, pixels: usize) -> Vec<ReturnsMut<'_>> {
        let depth_label = self.depth.chunks_mut(pixels).zip(self.label.chunks_mut(pixels));
        let instance_primitive = self.instance.chunks_mut(pixels).zip(self.primitive.chunks_mut(pixels));
        let incidence_intensity = self.incidence.chunks_mut(pixels).zip(self.intensity.chunks_mut(pixels));
        let all = depth_label.zip(instance_primitive).zip(incidence_intensity);
        all.map(|(((depth, label), (instance, primitive)), (incidence, intensity))| ReturnsMut {
            depth,
            label,
            instance,
            primitive,
            incidence,
            intensity,
        })
        .collect()
    }

    /// Writes a row: the echoes, what the sub-rays behind them saw, and nothing where they are `dropped`.
    #[inline(always)]
    pub(super) fn write(&mut self, returns: &Returns<'_>, echoes: &Echoes, dropped: &[bool]) {
        let columns = dropped.len();
        self.label.copy_from_slice(&returns.label[..columns]);
        self.instance.copy_from_slice(&returns.instance[..columns]);
        for (&column, &winner) in echoes.mixed.columns.iter().zip(&echoes.mixed.echo.winner) {
            let (column, pixel) = (column as usize, winner as usize * columns + column as usize);
            (self.label[column], self.instance[column]) = (returns.label[pixel], returns.instance[pixel]);
        }
        self.depth.copy_from_slice(&echoes.depth);
        self.primitive.copy_from_slice(&echoes.primitive);
        self.incidence.copy_from_slice(&echoes.incidence);
        // particles in the air are not primitives
        let (label, instance) = (self.label.iter_mut(), self.instance.iter_mut());
        for ((label, instance), &primitive) in label.zip(instance).zip(&echoes.primitive) {
            *label = if primitive < 0 { 0 } else { *label };
            *instance = if primitive < 0 { 0 } else { *instance };
        }
        blank(self.depth, dropped, 0.0);
        blank(self.label, dropped, 0);
        blank(self.instance, dropped, 0);
        blank(self.primitive, dropped, -1);
        blank(self.incidence, dropped, 0.0);
        blank(self.intensity, dropped, 0.0);
    }
}

impl Surfaces<'_> {
    pub(super) fn check(&self, primitive: &[i32]) -> Result<()> {
        let entries = self.table.len();
        for (column, found) in [
            ("transmission", self.transmission.len()),
            ("behind", self.behind.len()),
            ("grain", self.grain.len()),
            ("texture", self.texture.len()),
            ("rms_height", self.rms_height.len()),
            ("unevenness", self.unevenness.len()),
        ] {
            if found != entries {
                return Err(Error::SurfaceColumn { column, found, entries });
            }
        }
        match primitive.iter().copied().max() {
            Some(primitive) if i64::from(primitive) + 1 >= entries as i64 => {
                Err(Error::ImagePrimitive { primitive, primitives: entries.saturating_sub(1) })
            }
            _ => Ok(()),
        }
    }
}

fn same_size(image: &'static str, pixels: usize, expected: usize) -> Result<()> {
    if pixels == expected { Ok(()) } else { Err(Error::ObservedSize { image, pixels, expected }) }
}

#[inline(always)]
fn blank<T: Copy>(image: &mut [T], dropped: &[bool], nothing: T) {
    for (pixel, &dropped) in image.iter_mut().zip(dropped) {
        *pixel = if dropped { nothing } else { *pixel };
    }
}

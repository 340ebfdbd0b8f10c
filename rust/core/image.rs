//! The images that a scan writes.

use glam::DVec3;

use crate::{Error, Result, Scene, SceneHit};

/// The return of one ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Return {
    /// The distance along the ray [m].
    pub(crate) depth: f32,
    /// The class of the primitive.
    pub(crate) label: u8,
    /// The instance of the primitive.
    pub(crate) instance: u32,
    /// The index of the primitive in the scene.
    pub(crate) primitive: usize,
    /// The cosine of the angle between the ray and the surface normal, 0 to 1.
    pub(crate) incidence: f32,
    /// The unit normal of the surface in the world, on the side that the ray comes from.
    pub(crate) normal: DVec3,
}

impl Return {
    /// The return of a ray that hit a scene; `depth` is the distance as stored in the image.
    pub(crate) fn new(scene: &Scene, origin: DVec3, direction: DVec3, hit: &SceneHit, depth: f32) -> Return {
        let length = direction.length();
        let normal = if scene.is_medium(hit.primitive) {
            // Leaves face any way: the medium returns like a surface that faces the ray.
            -direction / length
        } else {
            scene.normal(hit.primitive, hit.part, origin + direction * hit.distance)
        };
        let cosine = normal.dot(direction) / length;
        Return {
            depth,
            label: hit.label,
            instance: hit.instance,
            primitive: hit.primitive,
            incidence: cosine.abs().min(1.0) as f32,
            normal: if cosine > 0.0 { -normal } else { normal },
        }
    }
}

/// The images of one scan, row by row; a pixel without return is 0 in all of them and -1 in `primitive`.
#[derive(Clone, Debug, PartialEq)]
pub struct Images {
    /// Distances along the rays [m].
    pub depth: Vec<f32>,
    /// Classes.
    pub label: Vec<u8>,
    /// Instances.
    pub instance: Vec<u32>,
    /// Indices of the primitives.
    pub primitive: Vec<i32>,
    /// Cosines of incidence.
    pub incidence: Vec<f32>,
    /// Unit normals in the world, turned towards the sensor.
    pub normal: Vec<[f32; 3]>,
}

/// The images of one scan, or of several in order, to be written; those that are `None` are not wanted.
#[derive(Debug)]
pub struct ImagesMut<'a> {
    /// Distances along the rays [m].
    pub depth: &'a mut [f32],
    /// Classes.
    pub label: &'a mut [u8],
    /// Instances.
    pub instance: &'a mut [u32],
    /// Indices of the primitives.
    pub primitive: Option<&'a mut [i32]>,
    /// Cosines of incidence.
    pub incidence: Option<&'a mut [f32]>,
    /// Unit normals in the world, turned towards the sensor.
    pub normal: Option<&'a mut [[f32; 3]]>,
}

impl Images {
    /// Images without any return.
    pub fn new(rows: usize, columns: usize) -> Images {
        let pixels = rows * columns;
        Images {
            depth: vec![0.0; pixels],
            label: vec![0; pixels],
            instance: vec![0; pixels],
            primitive: vec![-1; pixels],
            incidence: vec![0.0; pixels],
            normal: vec![[0.0; 3]; pixels],
        }
    }

    /// All of them, to be written.
    pub fn as_mut(&mut self) -> ImagesMut<'_> {
        ImagesMut {
            depth: &mut self.depth,
            label: &mut self.label,
            instance: &mut self.instance,
            primitive: Some(&mut self.primitive),
            incidence: Some(&mut self.incidence),
            normal: Some(&mut self.normal),
        }
    }
}

impl<'a> ImagesMut<'a> {
    /// The images before a pixel, and those from it on.
    pub(crate) fn split_at(self, pixel: usize) -> (ImagesMut<'a>, ImagesMut<'a>) {
        let (depth, label) = (self.depth.split_at_mut(pixel), self.label.split_at_mut(pixel));
        let instance = self.instance.split_at_mut(pixel);
        let primitive = self.primitive.map(|image| image.split_at_mut(pixel)).unzip();
        let incidence = self.incidence.map(|image| image.split_at_mut(pixel)).unzip();
        let normal = self.normal.map(|image| image.split_at_mut(pixel)).unzip();
        let images = |depth, label, instance, primitive, incidence, normal| ImagesMut {
            depth,
            label,
            instance,
            primitive,
            incidence,
            normal,
        };
        (
            images(depth.0, label.0, instance.0, primitive.0, incidence.0, normal.0),
            images(depth.1, label.1, instance.1, primitive.1, incidence.1, normal.1),
        )
    }
}

impl ImagesMut<'_> {
    /// The images in pieces of `pixels` pixels: scans of a batch, or rows of a scan. A shorter rest is left out.
    pub fn pieces(&mut self, pixels: usize) -> Vec<ImagesMut<'_>> {
        let mut label = self.label.chunks_exact_mut(pixels);
        let mut instance = self.instance.chunks_exact_mut(pixels);
        let mut primitive = self.primitive.as_deref_mut().map(|image| image.chunks_exact_mut(pixels));
        let mut incidence = self.incidence.as_deref_mut().map(|image| image.chunks_exact_mut(pixels));
        let mut normal = self.normal.as_deref_mut().map(|image| image.chunks_exact_mut(pixels));
        let piece = |depth| {
            Some(ImagesMut {
                depth,
                label: label.next()?,
                instance: instance.next()?,
                primitive: primitive.as_mut().and_then(Iterator::next),
                incidence: incidence.as_mut().and_then(Iterator::next),
                normal: normal.as_mut().and_then(Iterator::next),
            })
        };
        self.depth.chunks_exact_mut(pixels).map_while(piece).collect()
    }

    /// Writes one pixel.
    pub(crate) fn set(&mut self, pixel: usize, value: Option<&Return>) {
        self.depth[pixel] = value.map_or(0.0, |v| v.depth);
        self.label[pixel] = value.map_or(0, |v| v.label);
        self.instance[pixel] = value.map_or(0, |v| v.instance);
        if let Some(primitive) = &mut self.primitive {
            primitive[pixel] = value.map_or(-1, |v| v.primitive as i32);
        }
        if let Some(incidence) = &mut self.incidence {
            incidence[pixel] = value.map_or(0.0, |v| v.incidence);
        }
        if let Some(normal) = &mut self.normal {
            normal[pixel] = value.map_or([0.0; 3], |v| v.normal.as_vec3().to_array());
        }
    }

    /// Whether every image has as many pixels as a pattern.
    ///
    /// # Errors
    /// [`Error::ImageSize`].
    pub(crate) fn check(&self, rows: usize, columns: usize) -> Result<()> {
        let pixels = rows * columns;
        let sizes = [
            ("depth", Some(self.depth.len())),
            ("label", Some(self.label.len())),
            ("instance", Some(self.instance.len())),
            ("primitive", self.primitive.as_ref().map(|image| image.len())),
            ("incidence", self.incidence.as_ref().map(|image| image.len())),
            ("normal", self.normal.as_ref().map(|image| image.len())),
        ];
        match sizes.into_iter().find(|(_, size)| size.is_some_and(|size| size != pixels)) {
            Some((image, size)) => Err(Error::ImageSize { image, pixels: size.unwrap_or_default(), rows, columns }),
            None => Ok(()),
        }
    }
}

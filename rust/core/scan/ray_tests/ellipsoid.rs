//! Rays against an ellipsoid.

use super::{MediumTest, RayTest, ShapeFrame, ShapeInView, Tolerance, UNBOUNDED, root_error, three};
use crate::simd::{Lanes, Matrix, Vector};

/// An ellipsoid, in the frame in which it is the unit ball.
#[derive(Clone, Copy)]
pub(in crate::scan) struct Ellipsoid(pub(in crate::scan) ShapeFrame);

/// Rows: along the line to the centre, and twice across it.
#[derive(Clone, Copy)]
pub(in crate::scan) struct EllipsoidTest<L> {
    rows: [Vector<L>; 4],
    /// 1 from outside, -1 from inside.
    side: L,
    /// Inverse depth = `along` * first row + `root` * sqrt(discriminant).
    along: L,
    root: L,
    /// The error of the discriminant for a unit of the first row.
    error: L,
    /// The relative error of the inputs of the roots.
    root_error: L,
}

impl ShapeInView for Ellipsoid {
    type Test<L: Lanes> = EllipsoidTest<L>;

    /// For a ray start + t d, let s be the distance of the start from the centre, c the direction to it, a = c . d and
    /// b the part of d across c. It meets the unit ball at t^2 d^2 - 2 t s a + s^2 - 1 = 0, so 1 / t = (s a + sqrt(a^2
    /// - (s^2 - 1) b^2)) / (s^2 - 1). Nothing cancels, however far and small the ball is.
    #[inline(always)]
    fn test_from<L: Lanes>(&self, start: Vector<L>) -> EllipsoidTest<L> {
        let (axes, origin) = self.0.axes_and_start(start);
        let (_, scale) = self.0.sizes();
        let axes = Matrix { x: axes.x * scale.x, y: axes.y * scale.y, z: axes.z * scale.z };
        let from = origin.times(scale);
        let one = L::splat(1.0);
        let distance = from.length();
        // From the very middle, any direction will do.
        let away = distance.gt(L::splat(1e-12));
        let inverse = -(one / distance.max(L::splat(1e-20)));
        let center = Vector::new(
            L::select(away, from.x * inverse, one),
            L::select(away, from.y * inverse, L::splat(0.0)),
            L::select(away, from.z * inverse, L::splat(0.0)),
        );
        let power = (distance - one) * (distance + one);
        let span = power.abs().sqrt();
        let [left, up] = across(center);
        let finest = L::splat(self.0.half.iter().fold(0.0, |all, half| (1.0 / half).max(all)) * self.0.rounding);
        EllipsoidTest {
            rows: three(axes.combine(center), axes.combine(left * span), axes.combine(up * span)),
            side: one.copysign(power),
            along: distance / power,
            root: one / power.abs(),
            error: finest * L::splat(12.0) * (span + one + one / span),
            root_error: root_error(distance, power),
        }
    }
}

/// Two unit vectors across a third: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
#[inline(always)]
fn across<L: Lanes>(Vector { x, y, z }: Vector<L>) -> [Vector<L>; 2] {
    let one = L::splat(1.0);
    let sign = one.copysign(z);
    let a = -(one / (sign + z));
    let b = x * y * a;
    [Vector::new((sign * x * x).mul_add(a, one), sign * b, -(sign * x)), Vector::new(b, (y * y).mul_add(a, sign), -y)]
}

impl<L: Lanes> EllipsoidTest<L> {
    #[inline(always)]
    fn discriminant(&self, d: &[L; 4]) -> L {
        let across = d[1].mul_add(d[1], d[2] * d[2]);
        d[0].mul_add(d[0], -(self.side * across))
    }
}

impl<L: Lanes> RayTest<L> for EllipsoidTest<L> {
    #[inline(always)]
    fn rows(&self) -> &[Vector<L>; 4] {
        &self.rows
    }

    #[inline(always)]
    fn upper_bounds(&self, d: [L; 4]) -> (L, L) {
        let discriminant = d[0].abs().mul_add(self.error, self.discriminant(&d));
        let root = discriminant.max(L::splat(0.0)).sqrt();
        (d[0].mul_add(self.along, self.root * root), discriminant)
    }

    #[inline(always)]
    fn resolved(&self, d: [L; 4], tolerance: Tolerance) -> (L, L::Mask) {
        let (discriminant, error) = (self.discriminant(&d), d[0].abs() * self.error);
        let root = discriminant.max(L::splat(0.0)).sqrt();
        let inverse_depth = d[0].mul_add(self.along, self.root * root);
        // The error of the root is half the error of the radicand, divided by the root.
        let exact = (tolerance.allowed_error(inverse_depth) * root).ge(error * self.root);
        (inverse_depth, discriminant.gt(error) & exact)
    }
}

impl<L: Lanes> EllipsoidTest<L> {
    /// The entry and exit of a ray: the former at the most and the latter at the least (sign 1), or the other way
    /// round; and discriminant and error.
    #[inline(always)]
    fn passes(&self, d: &[L; 4], sign: f32) -> (L, L, [L; 2]) {
        let (zero, signed) = (L::splat(0.0), L::splat(sign));
        let discriminant = self.discriminant(d);
        let root = discriminant.abs().sqrt();
        let error = d[0].abs().max(root) * self.error;
        let middle = d[0] * self.along;
        let root_error = self.root.mul_add(root, middle.abs()) * self.root_error * signed;
        let outside = self.side.gt(zero);
        // Seen from inside, it is left at the other root.
        let entering = (error.mul_add(signed, discriminant)).max(zero).sqrt();
        let leaving = (error * self.side).mul_add(signed, discriminant).max(zero).sqrt();
        let enter = self.root.mul_add(entering, middle) + root_error;
        let leave = (-(self.root * self.side)).mul_add(leaving, middle) - root_error;
        (L::select(outside, enter, L::splat(UNBOUNDED)), leave, [discriminant, error])
    }
}

impl<L: Lanes> MediumTest<L> for EllipsoidTest<L> {
    #[inline(always)]
    fn widest_interval(&self, d: [L; 4]) -> (L, L, L) {
        let (enter, leave, [discriminant, error]) = self.passes(&d, 1.0);
        (enter, leave, discriminant + error)
    }

    #[inline(always)]
    fn narrowest_interval(&self, d: [L; 4]) -> (L, L, L::Mask) {
        let (enter, leave, [discriminant, error]) = self.passes(&d, -1.0);
        (enter, leave, discriminant.gt(error))
    }
}

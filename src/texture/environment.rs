//! Environment maps: the colour of what is seen in a direction (Blinn and Newell, "Texture and Reflection in
//! Computer Generated Images", CACM 19(10), 1976).
//!
//! A direction with its derivatives is brought to a place on a picture with its derivatives, by their
//! rule and not by differences, which would be wrong across seams. There the ellipse is found that a pixel
//! sees, and sampled along its longer axis as other textures are, but every sample is found by its own
//! direction, and every texel beyond a picture's edge on the picture that goes on there. So
//! there are no seams: neither where a picture's two ends meet, nor at poles, nor between faces.

use glam::{Mat3, Vec2, Vec3, Vec4, vec2};

use crate::fragment::Fragment;
use crate::texture::build::Texture;
use crate::texture::error::TextureError;
use crate::texture::level::{MOST_PROBES, MipFilter, Sides};
use crate::texture::minify::probe_at;
use crate::texture::sample::{Filter, mix};

/// A direction with its derivatives: what a pixel sees of an environment, to first order. It may have any
/// length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectionFootprint {
    /// The direction at the pixel's centre.
    pub direction: Vec3,
    /// Its change per pixel to the right.
    pub dx: Vec3,
    /// Its change per pixel downwards.
    pub dy: Vec3,
}

impl From<Vec3> for DirectionFootprint {
    /// A direction of no extent.
    fn from(direction: Vec3) -> Self {
        Self { direction, ..Self::default() }
    }
}

impl DirectionFootprint {
    /// The vector that three parameters of a fragment are, from number `first` on: a position, a normal, or
    /// anything else that vertices carry.
    #[must_use]
    pub fn of<const N: usize>(fragment: &Fragment<'_, N>, first: usize) -> Self {
        let number = |i: usize| fragment.params.get(first + i).copied().unwrap_or(0.0);
        let [x, y, z] = [0, 1, 2].map(|i| match first + i < N {
            true => fragment.derivative(first + i),
            false => [0.0; 2],
        });
        Self {
            direction: Vec3::new(number(0), number(1), number(2)),
            dx: Vec3::new(x[0], y[0], z[0]),
            dy: Vec3::new(x[1], y[1], z[1]),
        }
    }

    /// The direction that is seen in a mirror, looked at along this direction, whose normal is given with its
    /// derivatives, of any length.
    ///
    /// Where `self` is the way from the eye to a point on a surface, the mirrored direction is that to
    /// where the surface shows the environment, with the derivatives that the curvature gives it.
    #[must_use]
    pub fn reflected(&self, normal: &Self) -> Self {
        // r = d - 2 n (n d) / (n n)
        let (n, d) = (normal.direction, self.direction);
        let square = n.length_squared().max(f32::MIN_POSITIVE);
        let part = n.dot(d) / square;
        let change = |dn: Vec3, dd: Vec3| {
            let of_part = (dn.dot(d) + n.dot(dd) - part * 2.0 * n.dot(dn)) / square;
            dd - (dn * part + n * of_part) * 2.0
        };
        Self {
            direction: d - n * (2.0 * part),
            dx: change(normal.dx, self.dx),
            dy: change(normal.dy, self.dy),
        }
    }
}

/// Pictures of what is around, in all directions.
///
/// ```
/// use polyscan::glam::{Vec3, Vec4, vec4};
/// use polyscan::texture::{EnvironmentMap, Texture};
///
/// // Blue above, brown below.
/// let (sky, ground) = (vec4(0.3, 0.5, 0.9, 1.0), vec4(0.3, 0.2, 0.1, 1.0));
/// let picture = Texture::from_fn(64, 32, |_, y| if y < 16 { sky } else { ground })?;
/// let around = EnvironmentMap::equirectangular(picture.with_mipmaps()?);
/// assert_eq!(around.sample(Vec3::new(0.3, 2.0, -0.1)), sky);
/// assert_eq!(around.sample(Vec3::NEG_Y), ground);
/// # Ok::<(), polyscan::texture::TextureError>(())
/// ```
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    /// One, or six.
    faces: Vec<Texture>,
}

/// A place on one of the pictures, in texels of level 0.
#[derive(Clone, Copy)]
struct Place {
    face: usize,
    uv: Vec2,
    sides: Sides,
}

impl EnvironmentMap {
    /// The environment in one picture, twice as wide as high for the most part: longitude along its width, all
    /// around, and latitude along its height. Its centre is in the direction -z, its right half towards
    /// +x, its upper edge the direction +y.
    ///
    /// Filter and mip filter are the texture's own; wraps do not matter.
    #[must_use]
    pub fn equirectangular(picture: Texture) -> Self {
        Self { faces: vec![picture] }
    }

    /// The environment in six square pictures of the same size, towards +x, -x, +y, -y, +z and -z, each as wgpu,
    /// Direct3D, Vulkan and OpenGL have it: on +z u runs along +x and v along -y, and on the others as the
    /// table of OpenGL's specification says (version 4.6, section 8.13). Filter and mip filter are those
    /// of the first.
    ///
    /// # Errors
    /// [`TextureError::Cube`] if they are not square, or differ in size or in the number of levels.
    pub fn cube(faces: [Texture; 6]) -> Result<Self, TextureError> {
        let side = faces[0].width();
        for (number, face) in faces.iter().enumerate() {
            let (width, height) = (face.width(), face.height());
            let has_levels = face.level_count() == faces[0].level_count();
            if (width, height) != (side, side) || !has_levels {
                return Err(TextureError::Cube { number, width, height, side });
            }
        }
        Ok(Self { faces: faces.into() })
    }

    /// The colour in a direction of any length: linear light, premultiplied by alpha. It is filtered as where a
    /// picture is magnified. A direction that is zero, or not finite, counts as some direction.
    #[must_use]
    pub fn sample(&self, direction: Vec3) -> Vec4 {
        self.sample_footprint(&direction.into())
    }

    /// The colour of what a pixel sees, by the first picture's [mip filter](Texture::mip_filter): linear
    /// light, premultiplied by alpha. [`MipFilter::Ewa`] counts as probes along the ellipse's longer axis, as
    /// many as its eccentricity, and bicubic filters as bilinear.
    #[must_use]
    pub fn sample_footprint(&self, seen: &DirectionFootprint) -> Vec4 {
        let place = self.place(seen);
        let most = match self.faces[0].mip_filter() {
            MipFilter::Off => return self.between_texels(0, place.face, place.uv),
            MipFilter::Anisotropic { probes } => probes,
            MipFilter::Ewa { eccentricity } => eccentricity,
            MipFilter::Nearest | MipFilter::Linear => 1,
        };
        let how = &self.faces[0].how;
        if most <= 1 {
            return self.between_levels(how.adjusted(place.sides.lambda()), place.face, place.uv);
        }
        let ellipse = place.sides.ellipse();
        let (count, lambda) = ellipse.probes(most.min(MOST_PROBES));
        let lambda = how.adjusted(lambda);
        // The direction on the screen that becomes the longer axis.
        let (dx, dy) =
            (place.sides.dx.dot(ellipse.direction), place.sides.dy.dot(ellipse.direction));
        let along =
            if count > 1 { (seen.dx * dx + seen.dy * dy) / ellipse.major } else { Vec3::ZERO };
        let mut sum = Vec4::ZERO;
        for i in 0..count {
            let (face, uv) = self.point(seen.direction + along * probe_at(i, count));
            sum += self.between_levels(lambda, face, uv);
        }
        sum / count as f32
    }

    /// The picture that a direction leads to, and where on it.
    fn point(&self, direction: Vec3) -> (usize, Vec2) {
        if self.faces.len() == 1 {
            let horizontal = length(direction.x, direction.z);
            let u = 0.5 + turns(direction.x, -direction.z);
            return (0, vec2(u, 2.0 * turns(horizontal, direction.y)));
        }
        let face = face_of(direction);
        let seen = axes_of(face) * direction;
        let uv = vec2(seen.x, seen.y) / (2.0 * seen.z.max(f32::MIN_POSITIVE)) + 0.5;
        (face, if uv.is_finite() { uv } else { Vec2::splat(0.5) })
    }

    /// Where a footprint's centre is on its picture, and how it lies there.
    fn place(&self, seen: &DirectionFootprint) -> Place {
        let (face, uv) = self.point(seen.direction);
        let size = vec2(self.faces[0].width() as f32, self.faces[0].height() as f32);
        let sides = |by: Vec3| {
            let d = seen.direction;
            let change = if self.faces.len() == 1 {
                by_angle(d, by)
            } else {
                let axes = axes_of(face);
                let (s, ds) = (axes * d, axes * by);
                let depth = s.z.max(f32::MIN_POSITIVE);
                (vec2(ds.x, ds.y) - vec2(s.x, s.y) * (ds.z / depth)) / (2.0 * depth)
            };
            change * size
        };
        Place { face, uv, sides: Sides { dx: sides(seen.dx), dy: sides(seen.dy) } }
    }

    fn between_levels(&self, lambda: f32, face: usize, uv: Vec2) -> Vec4 {
        let last = (self.faces[0].level_count() - 1) as f32;
        let lambda = if lambda > 0.0 { lambda.min(last) } else { 0.0 };
        if self.faces[0].mip_filter() == MipFilter::Nearest {
            // Half a level goes down.
            return self.between_texels((lambda - 0.5).ceil().max(0.0) as u32, face, uv);
        }
        let level = lambda as u32;
        let (finer, fraction) = (self.between_texels(level, face, uv), lambda - level as f32);
        if fraction > 0.0 {
            mix(finer, self.between_texels(level + 1, face, uv), fraction)
        } else {
            finer
        }
    }

    /// The colour at a point of a level, between its texels.
    fn between_texels(&self, level: u32, face: usize, uv: Vec2) -> Vec4 {
        let (width, height) = self.faces[face].level_size(level);
        let at = uv * vec2(width as f32, height as f32);
        if self.faces[0].filter() == Filter::Nearest {
            return self.texel(level, face, at.x.floor() as i32, at.y.floor() as i32);
        }
        let low = (at - 0.5).floor();
        let (x, y, part) = (low.x as i32, low.y as i32, at - 0.5 - low);
        let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        let [a, b, c, d] = if self.faces.len() == 1 {
            corners.map(|(x, y)| self.texel(level, face, x, y))
        } else {
            self.texels_of_cube(level, face, corners, width as i32)
        };
        mix(mix(a, b, part.x), mix(c, d, part.x), part.y)
    }

    /// Four texels of a cube. Beyond one of its corners there is no texel, but the mean of the other three.
    fn texels_of_cube(
        &self,
        level: u32,
        face: usize,
        corners: [(i32, i32); 4],
        side: i32,
    ) -> [Vec4; 4] {
        let is_outside = |i: i32| i < 0 || i >= side;
        let is_missing = |&(x, y): &(i32, i32)| is_outside(x) && is_outside(y);
        let missing = corners.iter().position(is_missing);
        let mut texels = corners.map(|(x, y)| self.texel(level, face, x, y));
        if let (Some(missing), true) = (missing, side > 1) {
            texels[missing] = Vec4::ZERO;
            texels[missing] = texels.iter().sum::<Vec4>() / 3.0;
        }
        texels
    }

    /// A texel, which may be one beyond the edge of its picture.
    fn texel(&self, level: u32, face: usize, x: i32, y: i32) -> Vec4 {
        let (width, height) = self.faces[face].level_size(level);
        let (w, h) = (width as i32, height as i32);
        if self.faces.len() == 1 {
            // Over the pole and down on the other side.
            let is_over = y < 0 || y >= h;
            let y = if y < 0 {
                -1 - y
            } else if y >= h {
                2 * h - 1 - y
            } else {
                y
            };
            let x = if is_over { x + w / 2 } else { x };
            return self.faces[0].level_texel(
                level,
                x.rem_euclid(w) as u32,
                y.clamp(0, h - 1) as u32,
            );
        }
        if (0..w).contains(&x) && (0..h).contains(&y) {
            return self.faces[face].level_texel(level, x as u32, y as u32);
        }
        // Where the centre of its neighbour on this face touches the edge, the other face has it.
        let centre = |i: i32| ((i as f32 + 0.5) / w as f32 * 2.0 - 1.0).clamp(-1.0, 1.0);
        let across = Vec3::new(centre(x), centre(y), 1.0);
        let direction = axes_of(face).transpose() * across;
        let other = neighbour(face, across);
        let seen = axes_of(other) * direction;
        let index = |s: f32| (((s / seen.z + 1.0) * 0.5 * w as f32) as i32).clamp(0, w - 1) as u32;
        self.faces[other].level_texel(level, index(seen.x), index(seen.y))
    }
}

/// How far a change of a direction goes on a picture of longitude and latitude: eastwards as a part of the
/// equator, and southwards as a part of the way from pole to pole.
///
/// At the poles longitude would change without bound, but there the picture has more texels than an angle needs.
fn by_angle(d: Vec3, by: Vec3) -> Vec2 {
    use std::f32::consts::{PI, TAU};
    let (horizontal, square) = (length(d.x, d.z), d.length_squared().max(f32::MIN_POSITIVE));
    let out = if horizontal > 0.0 { vec2(d.x, d.z) / horizontal } else { Vec2::Y };
    let change = vec2(by.x, by.z);
    let south = (d.y * out.dot(change) - horizontal * by.y) / square;
    vec2(out.perp_dot(change) / square.sqrt() / TAU, south / PI)
}

/// The rows of the matrix that takes directions to a face of a cube: where u grows, where v grows, and
/// where the face is.
fn axes_of(face: usize) -> Mat3 {
    let (u, v, out) = match face {
        0 => (Vec3::NEG_Z, Vec3::NEG_Y, Vec3::X),
        1 => (Vec3::Z, Vec3::NEG_Y, Vec3::NEG_X),
        2 => (Vec3::X, Vec3::Z, Vec3::Y),
        3 => (Vec3::X, Vec3::NEG_Z, Vec3::NEG_Y),
        4 => (Vec3::X, Vec3::NEG_Y, Vec3::Z),
        _ => (Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z),
    };
    Mat3::from_cols(u, v, out).transpose()
}

/// The face of a cube that a direction leads to: that of its longest axis.
fn face_of(direction: Vec3) -> usize {
    let Vec3 { x, y, z } = direction.abs();
    let (axis, value) = if x >= y && x >= z {
        (0, direction.x)
    } else if y >= z {
        (1, direction.y)
    } else {
        (2, direction.z)
    };
    2 * axis + usize::from(value < 0.0)
}

/// The face on the other side of the edge that a point of a face is at.
fn neighbour(face: usize, at: Vec3) -> usize {
    let edge = if at.x.abs() >= 1.0 { Vec3::X * at.x.signum() } else { Vec3::Y * at.y.signum() };
    face_of(axes_of(face).transpose() * edge)
}

/// The angle of the point (y to the right, x up) in turns, from -1/2 to 1/2: atan2(y, x) / (2 pi), to 2^-23, by
/// the same arithmetic on every machine.
fn turns(y: f32, x: f32) -> f32 {
    let (most, least) = (y.abs().max(x.abs()), y.abs().min(x.abs()));
    let ratio =
        if most > 0.0 && most.is_finite() { f64::from(least) / f64::from(most) } else { 0.0 };
    // The arc tangent of a half angle's tangent, which is below 0.42: a series of 11 terms.
    let t = ratio / (1.0 + (1.0 + ratio * ratio).sqrt());
    let square = t * t;
    let series = (0..11).rev().fold(0.0, |sum, k| {
        let term = 1.0 / f64::from(2 * k + 1);
        (if k % 2 == 0 { term } else { -term }) + sum * square
    });
    let eighth = 2.0 * t * series / std::f64::consts::TAU;
    let quarter = if y.abs() > x.abs() { 0.25 - eighth } else { eighth };
    let half = if x < 0.0 { 0.5 - quarter } else { quarter };
    (if y < 0.0 { -half } else { half }) as f32
}

/// The length of a vector, by the same arithmetic on every machine.
fn length(a: f32, b: f32) -> f32 {
    let (a, b) = (f64::from(a), f64::from(b));
    (a * a + b * b).sqrt() as f32
}

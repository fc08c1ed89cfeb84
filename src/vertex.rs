//! The vertex record: a position in clip space and `N` parameters.
//!
//! Only the position has a meaning to the library. The parameters (what GPUs call varyings or
//! attributes) are interpolated blindly, as in Heckbert's "Generic Convex Polygon Scan Conversion
//! and Clipping" (Graphics Gems, 1990), so a vertex stays a plain array of floats. The [`record!`]
//! macro gives that array names and types, so that nobody has to count floats.
//!
//! [`record!`]: crate::record

use glam::{Vec2, Vec3, Vec4};

/// A polygon's corner: homogeneous clip-space position and parameters `r_1 .. r_N`.
///
/// ```
/// use glam::{Vec2, vec4};
/// use polyscan::Vertex;
///
/// let vertex = Vertex::new(vec4(0.0, 0.5, 0.0, 1.0), Vec2::new(0.25, 0.75));
/// assert_eq!(vertex.params, [0.25, 0.75]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex<const N: usize> {
    /// Clip-space position (xw, yw, zw, w): x right, y up, visible inside the view volume.
    pub position: Vec4,
    /// The parameters; any unit, any range.
    pub params: [f32; N],
}

impl<const N: usize> Vertex<N> {
    /// A vertex from a position and anything that turns into an array of floats: an array, a
    /// `glam` vector, a [`record!`](crate::record).
    pub fn new(position: Vec4, params: impl Into<[f32; N]>) -> Self {
        Self { position, params: params.into() }
    }
}

/// How a parameter is interpolated between the vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Interpolation {
    /// Rational linear interpolation: linear on the polygon, correct in perspective (Heckbert and
    /// Moreton 1991, section 3.5).
    #[default]
    Perspective,
    /// Linear in screen space: the paper's "linear interpolation", GLSL's `noperspective`. Cheaper
    /// by a multiplication, and wrong on a polygon seen in perspective.
    Linear,
    /// The value of the polygon's first vertex, all over the polygon.
    Flat,
}

/// A value of `LEN` floats that can be a field of a [`record!`](crate::record).
pub trait Parameter: Sized {
    /// The number of floats.
    const LEN: usize;
    /// Stores the value in the first `LEN` elements of `floats`.
    fn write(&self, floats: &mut [f32]);
    /// Reads the value from the first `LEN` elements of `floats`.
    fn read(floats: &[f32]) -> Self;
}

impl Parameter for f32 {
    const LEN: usize = 1;
    fn write(&self, floats: &mut [f32]) {
        floats[0] = *self;
    }
    fn read(floats: &[f32]) -> Self {
        floats[0]
    }
}

impl<const K: usize> Parameter for [f32; K] {
    const LEN: usize = K;
    fn write(&self, floats: &mut [f32]) {
        floats[..K].copy_from_slice(self);
    }
    fn read(floats: &[f32]) -> Self {
        std::array::from_fn(|i| floats[i])
    }
}

macro_rules! vector_parameter {
    ($($vector:ty: $len:literal),*) => {$(
        impl Parameter for $vector {
            const LEN: usize = $len;
            fn write(&self, floats: &mut [f32]) {
                self.to_array().write(floats);
            }
            fn read(floats: &[f32]) -> Self {
                Self::from_slice(floats)
            }
        }
    )*};
}
vector_parameter!(Vec2: 2, Vec3: 3, Vec4: 4);

/// Defines a struct of named parameters that converts to and from the array of floats in a
/// [`Vertex`] and a [`Fragment`](crate::Fragment).
///
/// Fields may be `f32`, `[f32; K]`, `glam`'s `Vec2`, `Vec3`, `Vec4`, or another record. The struct
/// is `Clone`, `Copy`, `Debug` and `PartialEq`; `LEN` is its number of floats.
///
/// ```
/// use glam::{Vec2, Vec3, vec4};
/// use polyscan::{Vertex, record};
///
/// record! {
///     /// What the surface carries from its vertices to its pixels.
///     pub struct Surface {
///         pub uv: Vec2,
///         pub normal: Vec3,
///     }
/// }
///
/// let corner = Surface { uv: Vec2::new(0.0, 1.0), normal: Vec3::Z };
/// let vertex = Vertex::new(vec4(-1.0, -1.0, 0.0, 1.0), corner);
/// assert_eq!(vertex.params, [0.0, 1.0, 0.0, 0.0, 1.0]);
///
/// let Surface { normal, .. } = vertex.params.into();
/// assert_eq!(normal, Vec3::Z);
/// ```
#[macro_export]
macro_rules! record {
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident {
            $($(#[$field_meta:meta])* $field_vis:vis $field:ident: $ty:ty),+ $(,)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $vis struct $name {
            $($(#[$field_meta])* $field_vis $field: $ty),+
        }

        impl $name {
            /// The number of floats in the record.
            $vis const LEN: usize = 0 $(+ <$ty as $crate::Parameter>::LEN)+;
        }

        impl $crate::Parameter for $name {
            const LEN: usize = $name::LEN;
            fn write(&self, floats: &mut [f32]) {
                $(
                    $crate::Parameter::write(&self.$field, floats);
                    let floats = &mut floats[<$ty as $crate::Parameter>::LEN..];
                )+
                let _ = floats;
            }
            fn read(floats: &[f32]) -> Self {
                $(
                    let $field = <$ty as $crate::Parameter>::read(floats);
                    let floats = &floats[<$ty as $crate::Parameter>::LEN..];
                )+
                let _ = floats;
                Self { $($field),+ }
            }
        }

        impl From<$name> for [f32; $name::LEN] {
            fn from(record: $name) -> Self {
                let mut floats = [0.0; $name::LEN];
                $crate::Parameter::write(&record, &mut floats);
                floats
            }
        }

        impl From<[f32; $name::LEN]> for $name {
            fn from(floats: [f32; $name::LEN]) -> Self {
                $crate::Parameter::read(&floats)
            }
        }
    };
}

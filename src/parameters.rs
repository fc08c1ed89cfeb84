//! Which parameters can be interpolated, and how.
mod error;
mod projective;
mod quad;
mod polygon;
mod subdivision;

pub use self::error::ParameterError;
pub use self::polygon::PolygonValues;
pub use self::projective::Projective;
pub use self::quad::quad;
pub use self::subdivision::Subdivision;

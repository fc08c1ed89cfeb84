//! Baking: a mesh scan-converted in its (u, v) plane, so that each texel of a texture is computed for the
//! place on the surface that it will cover: light maps, ambient occlusion, normals of a finer model.
//!
//! ```text
//!     +--------------+
//!     |  /\    ___   |     charts of the mesh in the texture. First the texels whose centres a face
//!     | /  \  |   |  |     covers, then those that it merely touches: a filter reads them, too. Then
//!     |/____\ |___|  |     the border of each chart is continued by some texels.
//!     +--------------+
//! ```
//!
//! Of a dense atlas a quarter of the triangles and more cover no texel's centre. By conservative coverage
//! none is missed.

use fearless_simd::Level;
use glam::{Vec2, vec4};

use crate::coverage::{CoverageRule, OutsidePolygon};
use crate::fragment::Fragment;
use crate::render::{DepthTest, Framebuffer, Geometry, Paint, ZBufferRenderer};
use crate::vertex::Vertex;
use crate::viewport::{Rect, SizeError, Viewport};

mod dilate;

/// A vertex at its place in a texture: at (0, 0) in the top left corner, at (1, 1) in the lower right one,
/// as textures are sampled. Its parameters, mostly its place in the world and its normal, are what each
/// texel is computed from. What lies outside of the texture is cut off, not repeated.
#[must_use]
pub fn vertex<const N: usize>(uv: Vec2, params: impl Into<[f32; N]>) -> Vertex<N> {
    let at = uv * 2.0 - 1.0;
    Vertex { position: vec4(at.x, -at.y, 0.5, 1.0), params: params.into() }
}

/// Bakes textures of one size from the faces of meshes, with the memory that this takes.
///
/// ```
/// use glam::{Vec2, Vec3, vec2, vec3};
/// use polyscan::bake::{self, Baker};
/// use polyscan::{Mesh, record};
///
/// record! {
///     /// What a texel is computed from.
///     struct Surfel {
///         place: Vec3,
///         normal: Vec3,
///     }
/// }
///
/// // A wall whose texture is to show how much light it has from a lamp.
/// let wall = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)].map(|(x, y)| {
///     let surfel = Surfel { place: vec3(x, y, 0.0), normal: Vec3::Z };
///     bake::vertex(vec2(x, y) / 5.0 + 0.1, surfel)
/// });
/// let lamp = vec3(1.0, 1.0, 2.0);
/// let mut baker = Baker::<{ Surfel::LEN }>::new(64, 64)?;
/// baker.margin = 2;
/// let baked = baker.bake(Mesh::new(&wall, [[0, 1, 2, 3]]), 0.0, |texel| {
///     let Surfel { place, normal } = texel.params.into();
///     let to_lamp = lamp - place;
///     normal.dot(to_lamp.normalize()) / to_lamp.length_squared()
/// })?;
/// assert!(baked.overlaps.is_empty());
/// let brightest = baked.texels.color().iter().copied().fold(0.0, f32::max);
/// assert!((brightest - 0.25).abs() < 0.001);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Baker<const N: usize> {
    /// By how many texels the border of what is covered is continued, so that a filter, or a smaller
    /// picture of a mip chain, does not mix in the background: 4 unless changed.
    pub margin: u32,
    /// The SIMD instructions to use: the best that the machine has, unless changed. The texture is the
    /// same with any.
    pub simd_level: Level,
    renderer: ZBufferRenderer<N>,
}

/// A texture that was baked.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Baked<C> {
    /// The texels. Their depth is 0.5 where a face covers or touches them, 1 elsewhere, in the margin,
    /// too.
    pub texels: Framebuffer<C>,
    /// The faces that share texels, which then are right for one of them only, in the order of their
    /// numbers.
    pub overlaps: Vec<Overlap>,
}

/// Two faces that cover the centres of the same texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Overlap {
    /// Their numbers in the mesh; the texels are computed for the first.
    pub faces: [u32; 2],
    /// How many texels these are. Of a texel in more than two faces, only two are reported.
    pub texels: u32,
}

impl<C: Copy> Baked<C> {
    /// How many texels a face covers or touches.
    #[must_use]
    pub fn covered(&self) -> usize {
        self.texels.depth().iter().filter(|&&depth| depth < 1.0).count()
    }
}

impl<const N: usize> Baker<N> {
    /// A baker of textures of a size in texels.
    ///
    /// # Errors
    /// When a side is longer than [`MAX_SIZE`](crate::viewport::MAX_SIZE).
    pub fn new(width: u32, height: u32) -> Result<Self, SizeError> {
        let renderer = ZBufferRenderer::new(Viewport::new(width, height)?);
        Ok(Self { margin: 4, simd_level: renderer.simd_level, renderer })
    }

    /// Bakes a texture from faces whose vertices are [at their places](vertex) in it. `shader` is called
    /// once for each texel that a face covers or touches. Where its centre is covered the parameters are
    /// those of the surface there, else those of the nearest point of a face that touches it. Of several
    /// faces the first has the texel. `background` is the colour of all texels that are left.
    ///
    /// # Errors
    /// When there is not enough memory for the texels.
    pub fn bake<C>(
        &mut self,
        geometry: impl Geometry<N> + Clone,
        background: C,
        shader: impl Fn(&Fragment<'_, N>) -> C + Sync,
    ) -> Result<Baked<C>, SizeError>
    where
        C: Copy + Send + Sync,
    {
        let Self { margin, simd_level, renderer } = self;
        renderer.simd_level = *simd_level;
        let viewport = renderer.settings.viewport;
        let overlaps = overlaps(renderer, geometry.clone())?;
        let Rect { width, height, .. } = viewport.rect();
        let mut texels = Framebuffer::new(width, height, background)?;
        renderer.depth_test = DepthTest::Nearer;
        renderer.depth_write = true;
        for rule in [CoverageRule::Centre, CoverageRule::Outer(OutsidePolygon::Clamp)] {
            renderer.settings.coverage_rule = rule;
            renderer.draw(&mut texels, geometry.clone(), texel(&shader));
        }
        dilate::dilate(&mut texels, *margin);
        Ok(Baked { texels, overlaps })
    }
}

/// A texel's colour, whatever its type: none is blended.
struct Texel<C>(C);

impl<C> Paint<C> for Texel<C> {
    #[inline(always)]
    fn paint(self, pixel: &mut C) -> bool {
        *pixel = self.0;
        true
    }
}

/// A shader of texels. Its type is the same for any geometry, so that it is compiled once.
fn texel<C, const N: usize>(
    shader: &(impl Fn(&Fragment<'_, N>) -> C + Sync),
) -> impl Fn(&Fragment<'_, N>) -> Texel<C> + Sync {
    |fragment| Texel(shader(fragment))
}

/// The faces that cover a texel's centre: the first, and another.
#[derive(Clone, Copy)]
struct Owners([u32; 2]);

const NONE: u32 = u32::MAX;

/// One of a texel's faces.
struct Owner(u32);

impl Paint<Owners> for Owner {
    #[inline(always)]
    fn paint(self, pixel: &mut Owners) -> bool {
        let place = usize::from(pixel.0[0] != NONE);
        if pixel.0[1] == NONE {
            pixel.0[place] = self.0;
        }
        true
    }
}

/// The shader of owners, for any geometry.
fn owner<const N: usize>() -> impl Fn(&Fragment<'_, N>) -> Owner + Sync {
    |fragment| Owner(fragment.face)
}

/// Which faces cover the same texels' centres.
fn overlaps<const N: usize>(
    renderer: &mut ZBufferRenderer<N>,
    geometry: impl Geometry<N>,
) -> Result<Vec<Overlap>, SizeError> {
    let Rect { width, height, .. } = renderer.settings.viewport.rect();
    let mut owners = Framebuffer::new(width, height, Owners([NONE; 2]))?;
    renderer.settings.coverage_rule = CoverageRule::Centre;
    renderer.depth_test = DepthTest::Always;
    renderer.depth_write = false;
    renderer.draw(&mut owners, geometry, owner::<N>());
    let shared = owners.color().iter().filter(|owners| owners.0[1] != NONE);
    let mut pairs: Vec<_> = shared.map(|owners| owners.0).collect();
    pairs.sort_unstable();
    let same = pairs.chunk_by(|a, b| a == b);
    Ok(same.map(|pairs| Overlap { faces: pairs[0], texels: pairs.len() as u32 }).collect())
}

//! What is seen at each pixel, as a picture of numbers: the visibility buffer (C. Burns and W. Hunt, "The
//! Visibility Buffer: A Cache-Friendly Approach to Deferred Shading", JCGT 2(2), 2013). It is what
//! rasterizers for differentiable rendering and for data sets return.
//!
//! Faces and depths come from the renderers' own test: one layer by the z-buffer, several by the
//! scanline renderer, which has all faces at a pixel in their order (`visibility::layers`), several samples a
//! pixel by the renderer of samples. What else is known of a face at a pixel is found once for each pixel
//! that shows it, from the vertices that faces share (`visibility::weights`).

mod layers;
mod weights;

use fearless_simd::Level;

use crate::fragment::{FragmentBlock, LANES};
use crate::render::band::Band;
use crate::render::depth::DepthTest;
use crate::render::faces::{FaceIndices, FaceList, MOST_AT_ONCE};
use crate::render::framebuffer::filled;
use crate::render::front::DrawFaces;
use crate::render::geometry::{Batch, GeometryMemory, Mesh, Order, Submit};
use crate::render::parallel::{Shading, for_each, for_each_part};
use crate::render::raster::plan::Plan;
use crate::render::samples::{MultisampleFramebuffer, MultisampleRenderer, Samples};
use crate::render::shader::{Painter, PerBlock, Shared};
use crate::render::stroke_style::Figure;
use crate::render::visibility::layers::LayerKeeper;
use crate::render::visibility::weights::{SeenRows, Weights};
use crate::render::{scanline, z_buffer};
use crate::settings::{DepthMode, DrawCall, Settings};
use crate::simd::for_level;
use crate::vertices::Positions;
use crate::view_volume::ClipPlane;
use crate::viewport::{Rect, SizeError, Viewport};

/// What a [`Visibility`] holds besides faces and depths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Product {
    /// [`Visibility::w`].
    W,
    /// [`Visibility::barycentrics`].
    Barycentrics,
    /// [`Visibility::corners`].
    Corners,
    /// [`Visibility::derivatives`].
    Derivatives,
}

/// What is seen at each pixel: faces, depths and, if asked for, where on the face. Drawn by a
/// [`VisibilityRenderer`].
///
/// All lists have an element for each layer or sample of each pixel: row by row from the top, and of each
/// pixel the layers one after the other, the nearest first, or the samples in the order of their
/// [places](Samples::places). Those that were not asked for are empty. They may be taken away, by
/// [`std::mem::take`] for example: the renderer makes new ones. What is said of a pixel's centre holds of a
/// sample's place where there are samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Visibility {
    /// The number of the face in its mesh, from 0; [`Visibility::NO_FACE`] where there is none.
    pub face: Vec<u32>,
    /// The depth of the same face by [`Settings::depth`], to the bit as a z-buffer stores it: z/w in the
    /// viewport's range. Where there is no face, the [farthest](DepthMode::farthest).
    pub depth: Vec<f32>,
    /// The w of clip space, which with the usual matrices is the distance from the eye along the direction
    /// of view, in the units of object space; between those of the face's corners. 0 where there is no
    /// face.
    pub w: Vec<f32>,
    /// The weights of the face's three corners in their order, correct in perspective: what is given at
    /// the vertices is at the pixel the mean under these weights. They are within 1e-5 of exact
    /// arithmetic, none is negative, and they sum to 1. Where rounding by up to 1/256 pixel
    /// has put the pixel's centre outside of the face, they are those outside, with 0 for what would be
    /// negative, divided by their sum. 0 where there is no face.
    ///
    /// Of a face of more than three sides they are the weights of three of its corners, its first and
    /// two neighbours, so that the centre lies in their triangle: [`corners`](Self::corners) has which.
    /// Of a concave face it is the triangle that the centre lies in, or least outside.
    pub barycentrics: Vec<[f32; 3]>,
    /// The vertices that the weights belong to, by their numbers in the mesh. 0 where there is no face.
    pub corners: Vec<[u32; 3]>,
    /// The changes of the weights per pixel to the right and per pixel downwards, at the pixel's centre;
    /// exact derivatives, not differences of pixels. 0 where there is no face.
    pub derivatives: Vec<[[f32; 2]; 3]>,
    width: u32,
    height: u32,
    /// How many elements a pixel has.
    per_pixel: u32,
    /// Where samples are drawn, if they are wanted.
    samples: Option<MultisampleFramebuffer<u32>>,
    products: [bool; 4],
}

impl Visibility {
    /// The face where there is none.
    pub const NO_FACE: u32 = u32::MAX;

    /// A buffer that shows nothing yet, for the nearest face of each pixel.
    ///
    /// # Errors
    /// As [`Framebuffer::new`](crate::Framebuffer::new).
    pub fn new(width: u32, height: u32, products: &[Product]) -> Result<Self, SizeError> {
        Self::with_layers(width, height, 1, products)
    }

    /// The same for the nearest `layers` faces of each pixel, at least 1.
    ///
    /// # Errors
    /// As [`Framebuffer::new`](crate::Framebuffer::new).
    pub fn with_layers(
        width: u32,
        height: u32,
        layers: u32,
        products: &[Product],
    ) -> Result<Self, SizeError> {
        Self::with_elements((width, height), layers.max(1), products)
    }

    /// The same for several samples a pixel, each of which shows the face that is nearest there, as a
    /// [`MultisampleRenderer`] has it. The share of the samples that show a face is how much of the pixel it
    /// covers; the mean of what is interpolated at them has no steps at edges.
    ///
    /// ```
    /// use glam::vec4;
    /// use polyscan::render::{Samples, Visibility, VisibilityRenderer};
    /// use polyscan::{Mesh, Vertex};
    ///
    /// // A square over one pixel and half of the next.
    /// let square = [(-1.0, -1.0), (0.5, -1.0), (0.5, 1.0), (-1.0, 1.0)]
    ///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
    /// let mut seen = Visibility::with_samples(2, 1, Samples::Eight, &[])?;
    /// VisibilityRenderer::new(seen.viewport()).draw(&mut seen, Mesh::new(&square, [[0, 1, 2, 3]]));
    /// let covers = |samples: &[u32]| samples.iter().filter(|face| **face == 0).count() as f32 / 8.0;
    /// assert_eq!(seen.face.chunks(8).map(covers).collect::<Vec<_>>(), [1.0, 0.5]);
    /// # Ok::<(), polyscan::SizeError>(())
    /// ```
    ///
    /// # Errors
    /// As [`MultisampleFramebuffer::new`].
    pub fn with_samples(
        width: u32,
        height: u32,
        samples: Samples,
        products: &[Product],
    ) -> Result<Self, SizeError> {
        let frame = MultisampleFramebuffer::new(width, height, samples, Self::NO_FACE)?;
        let seen = Self::with_elements((width, height), samples.count() as u32, products)?;
        Ok(Self { samples: Some(frame), ..seen })
    }

    fn with_elements(
        (width, height): (u32, u32),
        per_pixel: u32,
        products: &[Product],
    ) -> Result<Self, SizeError> {
        SizeError::check(width, height)?;
        let reason = "there is not enough memory for it; draw in tiles with \
                      `Viewport::with_corner`, or with fewer layers or samples";
        let error = SizeError::new(width, height, reason);
        let pixels = u64::from(width) * u64::from(height);
        let len = pixels.checked_mul(per_pixel.into()).and_then(|len| usize::try_from(len).ok());
        let len = len.ok_or(error)?;
        let all = [Product::W, Product::Barycentrics, Product::Corners, Product::Derivatives];
        let products = all.map(|product| products.contains(&product));
        let len_of = |product: Product| if products[product as usize] { len } else { 0 };
        Ok(Self {
            face: filled(len, Self::NO_FACE).ok_or(error)?,
            depth: filled(len, 1.0).ok_or(error)?,
            w: filled(len_of(Product::W), 0.0).ok_or(error)?,
            barycentrics: filled(len_of(Product::Barycentrics), [0.0; 3]).ok_or(error)?,
            corners: filled(len_of(Product::Corners), [0; 3]).ok_or(error)?,
            derivatives: filled(len_of(Product::Derivatives), [[0.0; 2]; 3]).ok_or(error)?,
            width,
            height,
            per_pixel,
            samples: None,
            products,
        })
    }

    /// The number of columns.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The number of rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// How many faces are kept of each pixel.
    #[must_use]
    pub fn layers(&self) -> u32 {
        if self.samples.is_some() { 1 } else { self.per_pixel }
    }

    /// How many samples a pixel has, and where; `None` for its centre alone.
    #[must_use]
    pub fn samples(&self) -> Option<Samples> {
        self.samples.as_ref().map(MultisampleFramebuffer::samples)
    }

    /// The viewport that covers the whole buffer.
    #[must_use]
    pub fn viewport(&self) -> Viewport {
        Viewport::whole(self.rect())
    }

    /// Distances as a depth camera gives them: each [`w`](Self::w) times `per_unit`, rounded to the nearest
    /// whole number; 0 where there is no face, 65,535 for what is farther than that. With w in metres, a
    /// `per_unit` of 1000 gives millimetres. Empty if w was not asked for.
    #[must_use]
    pub fn distances(&self, per_unit: f32) -> Vec<u16> {
        // The cast keeps what is too large at the greatest number.
        let distance = |w: &f32| (f64::from(*w) * f64::from(per_unit)).round() as u16;
        self.w.iter().map(distance).collect()
    }

    fn rect(&self) -> Rect {
        Rect { x: 0, y: 0, width: self.width, height: self.height }
    }

    /// Forgets what is seen.
    fn clear(&mut self, depth: f32) {
        let len = self.width as usize * self.height as usize * self.per_pixel as usize;
        if let Some(samples) = &mut self.samples {
            samples.clear(Self::NO_FACE, depth);
        }
        let [w, barycentrics, corners, derivatives] =
            self.products.map(|is_wanted| if is_wanted { len } else { 0 });
        refill(&mut self.face, len, Self::NO_FACE);
        refill(&mut self.depth, len, depth);
        refill(&mut self.w, w, 0.0);
        refill(&mut self.barycentrics, barycentrics, [0.0; 3]);
        refill(&mut self.corners, corners, [0; 3]);
        refill(&mut self.derivatives, derivatives, [[0.0; 2]; 3]);
    }

    /// The lists in parts of so many rows.
    fn rows(&mut self, rows: usize) -> Vec<SeenRows<'_>> {
        let len = (self.width as usize * self.per_pixel as usize * rows).max(1);
        let mut w = self.w.chunks_mut(len);
        let mut barycentrics = self.barycentrics.chunks_mut(len);
        let mut corners = self.corners.chunks_mut(len);
        let mut derivatives = self.derivatives.chunks_mut(len);
        let parts = self.face.chunks(len).enumerate().map(|(i, face)| SeenRows {
            first: i * rows,
            face,
            w: w.next().unwrap_or_default(),
            barycentrics: barycentrics.next().unwrap_or_default(),
            corners: corners.next().unwrap_or_default(),
            derivatives: derivatives.next().unwrap_or_default(),
        });
        parts.collect()
    }
}

fn refill<T: Copy>(list: &mut Vec<T>, len: usize, value: T) {
    list.clear();
    list.resize(len, value);
}

/// Draws what is seen at each pixel: the face, its depth, where on the face.
///
/// ```
/// use glam::vec4;
/// use polyscan::render::{Product, Visibility, VisibilityRenderer};
/// use polyscan::{Mesh, Vertex};
///
/// let vertices = [(-1.0, -1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, 3.0), (-1.0, 1.0, 3.0)]
///     .map(|(x, y, w)| Vertex::new(vec4(x * w, y * w, 0.5 * w, w), []));
/// let faces = [[0, 1, 2], [0, 2, 3]];
/// let mut seen = Visibility::new(320, 240, &[Product::Barycentrics, Product::W])?;
/// let mut renderer = VisibilityRenderer::new(seen.viewport());
/// renderer.draw(&mut seen, Mesh::new(&vertices, &faces));
///
/// // Any value of the vertices at a pixel: here each vertex's w.
/// let pixel = 120 * 320 + 160;
/// let corners = faces[seen.face[pixel] as usize].map(|i| vertices[i as usize].position.w);
/// let weights = seen.barycentrics[pixel];
/// let w: f32 = corners.iter().zip(weights).map(|(w, weight)| w * weight).sum();
/// assert!((w - seen.w[pixel]).abs() < 1e-5);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
///
/// The vertices' parameters are not looked at. Faces and depths are those that a
/// [`ZBufferRenderer`](crate::ZBufferRenderer) with the same settings draws; of several
/// [layers](Visibility::with_layers), which the scanline renderer finds, those of the first. Layers are
/// in the order of their depths at each pixel, of equals that of the lower number is nearer, and
/// [`DepthMode::InverseW`] counts as [`DepthMode::Standard`] if there are several. With
/// [samples](Visibility::with_samples) they are those of a [`MultisampleRenderer`] at each sample, whatever
/// the [rule](Settings::coverage_rule) of coverage is.
///
/// With the feature `parallel` all processors take part. The result is the same to the bit on any number
/// of them, at every SIMD level, and in tiles.
#[derive(Clone, Debug)]
pub struct VisibilityRenderer {
    /// Where and how polygons are brought to the screen.
    pub settings: Settings<0>,
    /// The SIMD instructions to use: the best that the machine has, unless changed.
    pub simd_level: Level,
    planes: Vec<ClipPlane>,
    faces: FaceList,
    z_buffer: z_buffer::Drawer,
    scanline: scanline::Drawer,
    samples: MultisampleRenderer<0>,
    /// The depths that layers are tested against: all the farthest.
    farthest: Vec<f32>,
}

/// Rows whose weights one thread finds at a time.
const ROWS: usize = 16;

impl VisibilityRenderer {
    /// A renderer to a viewport, with the settings of [`Settings::new`].
    #[must_use]
    pub fn new(viewport: Viewport) -> Self {
        Self {
            settings: Settings::new(viewport),
            simd_level: Level::new(),
            planes: Vec::new(),
            faces: FaceList::default(),
            z_buffer: z_buffer::Drawer::default(),
            scanline: scanline::Drawer::default(),
            samples: MultisampleRenderer::new(viewport),
            farthest: Vec::new(),
        }
    }

    /// Draws a mesh instead of what the buffer holds. Which of its faces are transparent makes no
    /// difference, nor does an order that was asked for.
    pub fn draw<F: IntoIterator<Item: FaceIndices>, const N: usize>(
        &mut self,
        seen: &mut Visibility,
        mesh: Mesh<'_, F, N>,
    ) {
        let (vertices, faces) = mesh.into_parts();
        let Self { settings, simd_level: level, planes, faces: list, .. } = self;
        let has_layers = seen.layers() > 1;
        let mode = match settings.depth {
            DepthMode::InverseW if has_layers => DepthMode::Standard,
            mode => mode,
        };
        seen.clear(mode.farthest());
        settings.collect_planes(planes);
        let call = settings.call(seen.rect(), planes);
        if call.window.is_empty() {
            return;
        }
        let drawing = (*level, Plan::new(DepthTest::Nearer, true, mode));
        let vertices = &Positions(vertices);
        let most = if has_layers { usize::MAX } else { MOST_AT_ONCE };
        self.samples.settings.clone_from(settings);
        self.samples.simd_level = *level;
        let (mut rest, mut is_first) = (faces.into_iter().fuse(), true);
        list.restart();
        while list.collect(&mut rest, most) {
            let batch = Batch {
                vertices,
                faces: list,
                order: Order::AsGiven,
                figure: Figure::Faces,
                transparent: Some(&|_| true),
                is_first,
            };
            if has_layers {
                let farthest = &mut self.farthest;
                refill(farthest, seen.width as usize * seen.height as usize, mode.farthest());
                draw_layers(&call, drawing, &batch, seen, &mut self.scanline, farthest);
            } else if let Some(mut frame) = seen.samples.take() {
                draw_samples(&mut self.samples, &batch, seen, &mut frame);
                seen.samples = Some(frame);
            } else {
                draw_nearest(&call, drawing, &batch, seen, &mut self.z_buffer);
            }
            find_weights(&call, *level, &batch, seen);
            is_first = false;
        }
    }
}

/// Draws faces that are nearer than those that are there.
fn draw_nearest(
    call: &DrawCall<'_>,
    (level, plan): (Level, Plan),
    batch: &Batch<'_>,
    seen: &mut Visibility,
    drawer: &mut z_buffer::Drawer,
) {
    let mut target = Band::new((0, 0), seen.width as usize, &mut seen.depth);
    let shader = |block: &mut FragmentBlock<'_, 0>, faces: &mut [u32; LANES]| {
        *faces = [block.face; LANES];
    };
    let (colors, shader) = (&mut seen.face[..], PerBlock(Shared(&shader)));
    for_level!(level, simd => {
        let mut painter = Painter::<_, _, _, 0> { simd, colors, pixels_before: 0, shader };
        let shading = Shading::OnThreads(&mut painter);
        drawer.draw(call, (level, plan), batch, &mut target, shading);
    });
}

/// Draws the nearest layers of a scene.
fn draw_layers(
    call: &DrawCall<'_>,
    (level, plan): (Level, Plan),
    batch: &Batch<'_>,
    seen: &mut Visibility,
    drawer: &mut scanline::Drawer,
    farthest: &mut [f32],
) {
    let mut target = Band::new((0, 0), seen.width as usize, farthest);
    let (faces, depths) = (&mut seen.face[..], &mut seen.depth[..]);
    let layers = seen.per_pixel as usize;
    for_level!(level, simd => {
        let mut keeper = LayerKeeper { simd, layers, faces, depths, pixels_before: 0 };
        let shading = Shading::OnThreads(&mut keeper);
        drawer.draw(call, (level, plan), batch, &mut target, shading);
    });
}

/// Faces that are drawn as they are handed over.
struct Given<'b, 'a>(&'b Batch<'a>);

impl Submit<0> for Given<'_, '_> {
    fn submit(self, _: &mut GeometryMemory<0>, _: usize, draw: &mut dyn FnMut(&Batch<'_>)) {
        draw(self.0);
    }
}

/// Draws faces where they are nearer at samples than those that are there.
fn draw_samples(
    renderer: &mut MultisampleRenderer<0>,
    batch: &Batch<'_>,
    seen: &mut Visibility,
    frame: &mut MultisampleFramebuffer<u32>,
) {
    renderer.draw_blocks(frame, Given(batch), |block, faces| *faces = [block.face; LANES]);
    let (count, in_row) = (seen.per_pixel as usize, seen.width as usize * seen.per_pixel as usize);
    let parts = ((&mut seen.face[..], in_row), (&mut seen.depth[..], in_row));
    for_each_part(parts.0, parts.1, |row, faces, depths| {
        let samples = (0..frame.width()).flat_map(|x| (0..count).map(move |sample| (x, sample)));
        for ((x, sample), (face, depth)) in samples.zip(faces.iter_mut().zip(depths)) {
            if let Some(found) = frame.sample(x, row as u32, sample) {
                (*face, *depth) = found;
            }
        }
    });
}

/// Finds what else is wanted of the pixels where faces of a batch are seen.
fn find_weights(call: &DrawCall<'_>, level: Level, batch: &Batch<'_>, seen: &mut Visibility) {
    if seen.products == [false; 4] {
        return;
    }
    let Batch { vertices, faces, .. } = *batch;
    let (width, per_pixel) = (seen.width as usize, seen.per_pixel as usize);
    let places = seen.samples().map_or(&[][..], Samples::in_pixels);
    let weights = Weights { call, vertices, faces, width, per_pixel, places };
    for_each(&mut seen.rows(ROWS), |_, rows| {
        for_level!(level, _simd => weights.find(rows));
    });
}

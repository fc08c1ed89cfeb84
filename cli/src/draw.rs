//! Models to pictures: colours, strip by strip, and what is seen at each sample.
//!
//! A [`Scene`] is a model with its looks, a [`Shot`] one view of it, whose vertices are in clip space. Models that
//! have neither textures nor colours of vertices carry normals alone (`looks`), which is faster.

use std::ops::Range;

use polyscan::color::Color as _;
use polyscan::glam::{Mat3, Vec2, Vec3, Vec4};
use polyscan::model::{Face, Model, ModelVertex};
use polyscan::{
    BspTree, Fragment, Framebuffer, Mesh, PainterRenderer, ScanlineRenderer, SizeError, Texture,
    Vertex, Viewport, ZBufferRenderer, record,
};
use rayon::prelude::*;

use crate::looks::{FullLook, Look, PlainLook};
use crate::view::View;

record! {
    /// What goes from the vertices to the pixels.
    pub(crate) struct Surface {
        pub(crate) uv: Vec2,
        pub(crate) normal: Vec3,
        pub(crate) color: Vec4,
    }
}

/// How many numbers that is.
pub(crate) const FULL: usize = Surface::LEN;

/// How many numbers a normal alone is.
pub(crate) const PLAIN: usize = 3;

/// A model as it is drawn, from wherever.
pub(crate) struct Scene<'a> {
    pub(crate) model: &'a Model,
    pub(crate) faces: Vec<Face<'a>>,
    /// Whether vertices need no more than normals.
    is_plain: bool,
}

/// How faces are brought into their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    ZBuffer,
    Scanline,
    /// By a tree, which is built at the first picture.
    #[cfg_attr(not(feature = "view"), expect(dead_code, reason = "only the viewer offers it"))]
    Painter,
}

/// Which lines are drawn.
#[derive(Clone, Copy, Default)]
pub(crate) struct Lines {
    /// Those between all faces.
    pub(crate) wireframe: bool,
    /// Those where the surface bends or ends.
    pub(crate) edges: bool,
}

impl Lines {
    fn any(self) -> bool {
        self.wireframe || self.edges
    }
}

/// How a picture is drawn.
#[derive(Clone, Copy)]
pub(crate) struct Style {
    pub(crate) method: Method,
    /// A pixel has so many samples in x, and in y.
    pub(crate) samples: u32,
    /// Linear light, premultiplied by alpha.
    pub(crate) background: Vec4,
    pub(crate) lines: Lines,
}

/// What is seen at a sample.
#[derive(Clone, Copy)]
pub(crate) struct Seen {
    /// The number of the face from 1 on; 0 for nothing.
    pub(crate) face: u32,
    /// The distance along the view, in the model's units, or depth for a parallel projection.
    pub(crate) distance: f32,
    /// In the camera's axes, of length 1.
    pub(crate) normal: Vec3,
}

impl Seen {
    const NOTHING: Self = Self { face: 0, distance: 0.0, normal: Vec3::ZERO };
}

impl<'a> Scene<'a> {
    pub(crate) fn new(model: &'a Model) -> Self {
        let is_plain = model.textures.is_empty()
            && model.vertices.iter().all(|vertex| vertex.color == Vec4::ONE);
        Self { model, faces: model.faces().collect(), is_plain }
    }

    /// The method that draws everything right, the fastest.
    pub(crate) fn method(&self) -> Method {
        // A z-buffer knows no order of glass and cut-outs.
        if self.model.has_transparency() { Method::Scanline } else { Method::ZBuffer }
    }

    fn is_transparent(&self, face: u32) -> bool {
        self.model.materials[self.faces[face as usize].material].is_transparent()
    }
}

/// What draws, with memory that is kept from picture to picture.
#[derive(Default)]
pub(crate) struct Renderers {
    plain: Kept<PLAIN>,
    full: Kept<FULL>,
    /// The colours and depths of a strip, if one was drawn.
    strip: Option<Framebuffer<Vec4>>,
}

#[derive(Default)]
struct Kept<const N: usize> {
    z_buffer: Option<ZBufferRenderer<N>>,
    scanline: Option<ScanlineRenderer<N>>,
    painter: Option<PainterRenderer<N>>,
    tree: Option<BspTree<N>>,
}

/// The vertices of a shot, by what they carry.
enum Vertices {
    Plain(Vec<Vertex<PLAIN>>),
    Full(Vec<Vertex<FULL>>),
}

/// One view of a scene.
pub(crate) struct Shot<'a> {
    scene: &'a Scene<'a>,
    textures: &'a [Texture],
    view: View,
    vertices: Vertices,
}

/// Samples that are drawn at a time, of 20 bytes each: as many as are worth looking at all faces.
const STRIP: u32 = 1 << 20;

/// A picture has at most so many strips, however large it is.
const MOST_STRIPS: u32 = 64;

impl<'a> Shot<'a> {
    /// A shot with these textures for the model's own.
    pub(crate) fn new(scene: &'a Scene<'a>, textures: &'a [Texture], view: View) -> Self {
        let (model, matrix) = (scene.model, view.clip_from_object);
        let vertices = if scene.is_plain {
            Vertices::Plain(model.vertices_with(matrix, |v| v.normal))
        } else {
            Vertices::Full(model.vertices_with(matrix, surface))
        };
        Self { scene, textures, view, vertices }
    }

    /// Draws some rows from top to bottom and hands over their pixels, several rows at a time, each pixel the
    /// mean of its samples: linear light, premultiplied by alpha.
    pub(crate) fn pixels(
        &self,
        renderers: &mut Renderers,
        ((width, height), all): ((u32, u32), Range<u32>),
        Style { method, samples, background, lines }: Style,
        mut sink: impl FnMut(&[Vec4]) -> Result<(), String>,
    ) -> Result<(), String> {
        let wide = width * samples;
        let count = all.len() as u32;
        let rows = (STRIP / (wide * samples)).max(count.div_ceil(MOST_STRIPS)).max(1);
        // Whole bands of the renderers' 32 rows; and lines are found in the whole picture.
        let rows = rows.next_multiple_of(if samples % 2 == 0 { 16 } else { 32 });
        let rows = if lines.any() { height } else { rows.min(count) };
        let viewport = Viewport::new(wide, height * samples).map_err(size_error)?;
        let mut frame = match renderers.strip.take() {
            Some(frame) if (frame.width(), frame.height()) == (wide, rows * samples) => frame,
            _ => Framebuffer::new(wide, rows * samples, background).map_err(size_error)?,
        };
        let mut means = Vec::new();
        for top in all.clone().step_by(rows as usize) {
            frame.clear(background, 1.0);
            let tile = viewport.with_corner(0, -((top * samples) as i32));
            self.draw(renderers, method, tile, &mut frame);
            if lines.any() {
                let size = (wide, height * samples);
                let seen = self.seen((size, 0..size.1)).map_err(size_error)?;
                draw_lines(&mut frame, &seen, lines);
            }
            let rows = rows.min(all.end - top);
            let drawn = &frame.color()[..wide as usize * (rows * samples) as usize];
            if samples == 1 {
                sink(drawn)?;
            } else {
                average(drawn, (width as usize, samples as usize), &mut means);
                sink(&means)?;
            }
        }
        renderers.strip = Some(frame);
        Ok(())
    }

    /// Draws to a framebuffer of colours.
    fn draw(
        &self,
        renderers: &mut Renderers,
        method: Method,
        viewport: Viewport,
        frame: &mut Framebuffer<Vec4>,
    ) {
        let (scene, lamp) = (self.scene, self.view.lamp());
        match &self.vertices {
            Vertices::Plain(vertices) => {
                let look = PlainLook::new(scene, lamp);
                let kept = &mut renderers.plain;
                self.draw_with(kept, (method, viewport), frame, vertices, &look, |v| v.normal);
            }
            Vertices::Full(vertices) => {
                let look = FullLook { scene, textures: self.textures, lamp };
                let kept = &mut renderers.full;
                self.draw_with(kept, (method, viewport), frame, vertices, &look, surface);
            }
        }
    }

    fn draw_with<P: Into<[f32; N]>, const N: usize>(
        &self,
        kept: &mut Kept<N>,
        (method, viewport): (Method, Viewport),
        frame: &mut Framebuffer<Vec4>,
        vertices: &[Vertex<N>],
        look: &impl Look<N>,
        params: impl FnMut(&ModelVertex) -> P,
    ) {
        let scene = self.scene;
        let mesh = Mesh::new(vertices, &scene.faces);
        match method {
            Method::ZBuffer => {
                let renderer = kept.z_buffer.get_or_insert_with(|| ZBufferRenderer::new(viewport));
                renderer.settings.viewport = viewport;
                renderer.draw_blocks(frame, mesh, |block, colors| look.shade(block, colors));
            }
            Method::Scanline => {
                let renderer = kept.scanline.get_or_insert_with(|| ScanlineRenderer::new(viewport));
                renderer.settings.viewport = viewport;
                let is_transparent = |face| scene.is_transparent(face);
                let mesh = match scene.model.has_transparency() {
                    true => mesh.with_transparent(&is_transparent),
                    false => mesh,
                };
                renderer.draw_blocks(frame, mesh, |block, colors| look.shade(block, colors));
            }
            Method::Painter => {
                let renderer = kept.painter.get_or_insert_with(|| PainterRenderer::new(viewport));
                renderer.settings.viewport = viewport;
                let tree = kept.tree.get_or_insert_with(|| {
                    let still = scene.model.vertices_with(Default::default(), params);
                    BspTree::new(&still, &scene.faces)
                });
                let seen = tree.seen_by(self.view.clip_from_object);
                renderer.draw_blocks(frame, seen, |block, colors| look.shade(block, colors));
            }
        }
    }

    /// Draws from top to bottom and hands over each row of samples, of pictures that are too large for strips.
    pub(crate) fn stream(
        &self,
        viewport: Viewport,
        background: Vec4,
        row: impl FnMut(u32, &[Vec4]) -> Result<(), String>,
    ) -> Result<(), String> {
        let (scene, lamp) = (self.scene, self.view.lamp());
        match &self.vertices {
            Vertices::Plain(vertices) => {
                let look = PlainLook::new(scene, lamp);
                self.stream_with(viewport, background, vertices, &look, row)
            }
            Vertices::Full(vertices) => {
                let look = FullLook { scene, textures: self.textures, lamp };
                self.stream_with(viewport, background, vertices, &look, row)
            }
        }
    }

    fn stream_with<const N: usize>(
        &self,
        viewport: Viewport,
        background: Vec4,
        vertices: &[Vertex<N>],
        look: &impl Look<N>,
        row: impl FnMut(u32, &[Vec4]) -> Result<(), String>,
    ) -> Result<(), String> {
        let is_transparent = |face| self.scene.is_transparent(face);
        let mesh = Mesh::new(vertices, &self.scene.faces).with_transparent(&is_transparent);
        ScanlineRenderer::new(viewport).stream_blocks(
            mesh,
            background,
            |block, colors| look.shade(block, colors),
            row,
        )
    }

    /// What is seen at each sample of some rows of a picture. Holes of cut-outs are holes; glass is seen
    /// itself.
    pub(crate) fn seen(
        &self,
        (size, rows): ((u32, u32), Range<u32>),
    ) -> Result<Framebuffer<Seen>, SizeError> {
        let (scene, lamp) = (self.scene, Vec3::ZERO);
        match &self.vertices {
            Vertices::Plain(vertices) => {
                self.seen_with((size, rows), vertices, &PlainLook::new(scene, lamp))
            }
            Vertices::Full(vertices) => {
                let look = FullLook { scene, textures: self.textures, lamp };
                self.seen_with((size, rows), vertices, &look)
            }
        }
    }

    fn seen_with<const N: usize>(
        &self,
        ((width, height), rows): ((u32, u32), Range<u32>),
        vertices: &[Vertex<N>],
        look: &impl Look<N>,
    ) -> Result<Framebuffer<Seen>, SizeError> {
        let mut frame = Framebuffer::new(width, rows.len() as u32, Seen::NOTHING)?;
        let viewport = Viewport::new(width, height)?.with_corner(0, -(rows.start as i32));
        let mesh = Mesh::new(vertices, &self.scene.faces);
        let turn: Mat3 = self.view.axes.transpose();
        ZBufferRenderer::new(viewport).draw(&mut frame, mesh, |f: &Fragment<'_, N>| {
            let normal = (turn * look.normal(f)?).normalize_or_zero();
            Some(Seen { face: f.face + 1, distance: f.w, normal })
        });
        Ok(frame)
    }
}

fn surface(vertex: &ModelVertex) -> Surface {
    Surface { uv: vertex.uv, normal: vertex.normal, color: vertex.color }
}

pub(crate) fn size_error(error: SizeError) -> String {
    error.to_string()
}

/// The mean of each block of `n` by `n` samples; `width` is that of the result.
fn average(samples: &[Vec4], (width, n): (usize, usize), means: &mut Vec<Vec4>) {
    let weight = 1.0 / (n * n) as f32;
    means.resize(samples.len() / (n * n), Vec4::ZERO);
    let blocks = samples.par_chunks_exact(width * n * n);
    means.par_chunks_exact_mut(width).zip(blocks).for_each(|(means, block)| {
        means.fill(Vec4::ZERO);
        for row in block.chunks_exact(width * n) {
            for (mean, samples) in means.iter_mut().zip(row.chunks_exact(n)) {
                *mean += samples.iter().sum::<Vec4>();
            }
        }
        for mean in means {
            *mean *= weight;
        }
    });
}

/// The bytes of pixels, four each: sRGB, and alpha.
pub(crate) fn encode(pixels: &[Vec4], bytes: &mut Vec<u8>) {
    /// So many pixels are one thread's at a time.
    const PART: usize = 4096;
    let start = bytes.len();
    bytes.resize(start + 4 * pixels.len(), 0);
    let parts = bytes[start..].par_chunks_mut(4 * PART).zip(pixels.par_chunks(PART));
    parts.for_each(|(bytes, pixels)| {
        for (bytes, color) in bytes.chunks_exact_mut(4).zip(pixels) {
            bytes.copy_from_slice(&color.to_srgb8());
        }
    });
}

/// Darkens the samples of a picture on both sides of lines.
pub(crate) fn draw_lines(frame: &mut Framebuffer<Vec4>, seen: &Framebuffer<Seen>, lines: Lines) {
    let (width, seen) = (frame.width() as usize, seen.color());
    let is_line = |a: &Seen, b: &Seen| {
        let nearer = a.distance.min(b.distance);
        let ends = a.face == 0 || b.face == 0 || (a.distance - b.distance).abs() > 0.02 * nearer;
        // The cosine of 30 degrees, whichever way the faces are turned.
        let bends = a.normal.dot(b.normal).abs() < 0.866;
        a.face != b.face && (lines.wireframe || lines.edges && (ends || bends))
    };
    let mut darken = |place: usize| {
        let color = &mut frame.color_mut()[place];
        *color = (color.truncate() * 0.1).extend(color.w.max(1.0));
    };
    for (place, here) in seen.iter().enumerate() {
        let right = (place % width + 1 < width).then_some(place + 1);
        let below = (place + width < seen.len()).then_some(place + width);
        for other in [right, below].into_iter().flatten() {
            if is_line(here, &seen[other]) {
                darken(place);
                darken(other);
            }
        }
    }
}

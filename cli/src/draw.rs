//! Models to pictures: colours, strip by strip, and what is seen at each sample.
//!
//! A [`Scene`] is a model with its looks, a [`Shot`] one view of it, whose vertices are in clip space. Models that
//! have neither textures nor colours of vertices carry normals alone (`looks`), which is faster.

use std::ops::Range;
use std::sync::OnceLock;

use polyscan::glam::{Mat3, Mat4, Vec2, Vec3, Vec4};
use polyscan::model::{Material, Model, ModelVertex};
use polyscan::render::{Cap, Join};
use polyscan::{
    BspTree, DepthBias, Fragment, Framebuffer, Mesh, PainterRenderer, ScanlineRenderer, SizeError,
    Target, TargetError, Texture, Vertex, Viewport, ZBufferRenderer, record,
};
use rayon::prelude::*;

use crate::edges::Edges;
use crate::looks::{FullLook, Look, PlainLook};
use crate::pixels::{average, clear, framebuffer};
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

record! {
    /// What goes from the vertices to the pixels where normals are bent.
    pub(crate) struct BentSurface {
        pub(crate) uv: Vec2,
        pub(crate) normal: Vec3,
        pub(crate) color: Vec4,
        pub(crate) tangent: Vec4,
    }
}

/// How many numbers that is.
pub(crate) const BENT: usize = BentSurface::LEN;

/// How many numbers a normal alone is.
pub(crate) const PLAIN: usize = 3;

/// A model as it is drawn, from wherever.
pub(crate) struct Scene<'a> {
    pub(crate) model: &'a Model,
    /// For each face its material; nothing if all have the first.
    material_of: Vec<u32>,
    /// The material of the first face.
    first_material: usize,
    /// For each face the number of that which it is a part of; nothing if none was diced.
    sources: Vec<u32>,
    /// Whether vertices need no more than normals.
    is_plain: bool,
    /// Whether they need tangents.
    is_bent: bool,
    /// Found when lines are drawn at first.
    edges: OnceLock<Edges>,
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

/// Lines of one kind, and their width in pixels.
struct Drawn<'a> {
    lines: &'a [[u32; 2]],
    width: f32,
}

/// The colour of lines.
const INK: Vec4 = Vec4::new(0.02, 0.03, 0.06, 1.0);

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
        let is_bent = model.materials.iter().any(|material| material.normal_texture.is_some());
        let materials = || model.faces().map(|face| face.material);
        let first_material = materials().next().unwrap_or(0);
        let material_of = match materials().all(|material| material == first_material) {
            true => Vec::new(),
            false => materials().map(|material| material as u32).collect(),
        };
        let sources = match model.faces().enumerate().all(|(face, it)| it.source == face) {
            true => Vec::new(),
            false => model.faces().map(|face| face.source as u32).collect(),
        };
        let edges = OnceLock::new();
        Self { model, material_of, first_material, sources, is_plain, is_bent, edges }
    }

    /// The number in the file of the face that one is, or is a part of.
    fn source(&self, face: u32) -> u32 {
        self.sources.get(face as usize).copied().unwrap_or(face)
    }

    /// The number of a face's material.
    #[inline(always)]
    pub(crate) fn material_number(&self, face: u32) -> usize {
        self.material_of
            .get(face as usize)
            .map_or(self.first_material, |&material| material as usize)
    }

    /// A face's material.
    #[inline(always)]
    pub(crate) fn material(&self, face: u32) -> &'a Material {
        &self.model.materials[self.material_number(face)]
    }

    /// The method that draws everything right, the fastest.
    pub(crate) fn method(&self) -> Method {
        // A z-buffer knows no order of glass and cut-outs.
        if self.model.has_transparency() { Method::Scanline } else { Method::ZBuffer }
    }

    fn is_transparent(&self, face: u32) -> bool {
        self.material(face).is_transparent()
    }
}

/// What draws, with memory that is kept from picture to picture.
#[derive(Default)]
pub(crate) struct Renderers {
    plain: Kept<PLAIN>,
    full: Kept<FULL>,
    bent: Kept<BENT>,
    /// The colours and depths of a strip, if one was drawn.
    strip: Option<Framebuffer<Vec4>>,
    /// The pixels of a strip, where they are means of samples.
    means: Vec<Vec4>,
    /// The depths of a strip that lines are compared with.
    depths: Vec<f32>,
    /// The edges that are lines in a view.
    seen: Vec<[u32; 2]>,
}

#[derive(Default)]
struct Kept<const N: usize> {
    z_buffer: Option<ZBufferRenderer<N>>,
    scanline: Option<ScanlineRenderer<N>>,
    painter: Option<PainterRenderer<N>>,
    tree: Option<BspTree<N>>,
}

/// The vertices of a shot, by what they carry.
pub(crate) enum Vertices {
    Plain(Vec<Vertex<PLAIN>>),
    Full(Vec<Vertex<FULL>>),
    Bent(Vec<Vertex<BENT>>),
}

impl Default for Vertices {
    fn default() -> Self {
        Self::Plain(Vec::new())
    }
}

impl Vertices {
    /// Those of a scene in clip space, in memory that may have been in use before.
    fn of(scene: &Scene<'_>, matrix: Mat4, memory: Self) -> Self {
        let all = &scene.model.vertices;
        if scene.is_plain {
            let memory = if let Self::Plain(memory) = memory { memory } else { Vec::new() };
            Self::Plain(filled(memory, all, matrix, |v| v.normal))
        } else if scene.is_bent {
            let memory = if let Self::Bent(memory) = memory { memory } else { Vec::new() };
            Self::Bent(filled(memory, all, matrix, bent_surface))
        } else {
            let memory = if let Self::Full(memory) = memory { memory } else { Vec::new() };
            Self::Full(filled(memory, all, matrix, surface))
        }
    }
}

/// As [`Model::vertices_with`], on all processors and in given memory.
fn filled<P: Into<[f32; N]>, const N: usize>(
    mut memory: Vec<Vertex<N>>,
    vertices: &[ModelVertex],
    matrix: Mat4,
    params: impl Fn(&ModelVertex) -> P + Sync,
) -> Vec<Vertex<N>> {
    let vertex = |v: &ModelVertex| Vertex::new(matrix * v.position.extend(1.0), params(v));
    vertices.par_iter().with_min_len(2048).map(vertex).collect_into_vec(&mut memory);
    memory
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
    /// A shot with these textures for the model's own, in the memory of an earlier one's vertices.
    pub(crate) fn new(
        scene: &'a Scene<'a>,
        textures: &'a [Texture],
        view: View,
        memory: Vertices,
    ) -> Self {
        let vertices = Vertices::of(scene, view.clip_from_object, memory);
        Self { scene, textures, view, vertices }
    }

    /// The memory of its vertices, for the next shot.
    #[cfg(feature = "view")]
    pub(crate) fn into_memory(self) -> Vertices {
        self.vertices
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
        // Whole bands of the renderers' 32 rows.
        let rows = rows.next_multiple_of(if samples % 2 == 0 { 16 } else { 32 }).min(count);
        let viewport = Viewport::new(wide, height * samples).map_err(size_error)?;
        let (mut frame, mut is_clear) = match renderers.strip.take() {
            Some(frame) if (frame.width(), frame.height()) == (wide, rows * samples) => {
                (frame, false)
            }
            _ => (framebuffer((wide, rows * samples), background)?, true),
        };
        for top in all.clone().step_by(rows as usize) {
            if !is_clear {
                clear(&mut frame, background);
            }
            is_clear = false;
            let tile = viewport.with_corner(0, -((top * samples) as i32));
            self.draw(renderers, method, tile, &mut frame);
            self.draw_lines(renderers, (tile, samples), &mut frame, lines)?;
            let rows = rows.min(all.end - top);
            let drawn = &frame.color()[..wide as usize * (rows * samples) as usize];
            if samples == 1 {
                sink(drawn)?;
            } else {
                average(drawn, (width as usize, samples as usize), &mut renderers.means);
                sink(&renderers.means)?;
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
                let look = FullLook { scene, textures: self.textures, view: self.view };
                let kept = &mut renderers.full;
                self.draw_with(kept, (method, viewport), frame, vertices, &look, surface);
            }
            Vertices::Bent(vertices) => {
                let look = FullLook { scene, textures: self.textures, view: self.view };
                let kept = &mut renderers.bent;
                self.draw_with(kept, (method, viewport), frame, vertices, &look, bent_surface);
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
        let mesh = Mesh::new(vertices, scene.model.faces());
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
                    BspTree::new(&still, scene.model.faces())
                });
                let seen = tree.seen_by(self.view.clip_from_object);
                renderer.draw_blocks(frame, seen, |block, colors| look.shade(block, colors));
            }
        }
    }

    /// Draws those lines over the colours of a framebuffer that faces do not hide.
    fn draw_lines(
        &self,
        renderers: &mut Renderers,
        (viewport, samples): (Viewport, u32),
        frame: &mut Framebuffer<Vec4>,
        lines: Lines,
    ) -> Result<(), String> {
        if !lines.wireframe && !lines.edges {
            return Ok(());
        }
        let (scene, lamp) = (self.scene, Vec3::ZERO);
        let edges = scene.edges.get_or_init(|| Edges::of(scene.model));
        let mut seen = std::mem::take(&mut renderers.seen);
        seen.clear();
        if lines.edges {
            edges.seen_by(self.view.clip_from_object, &mut seen);
        }
        let all = if lines.wireframe { &edges.all[..] } else { &[] };
        let (samples, depths) = (samples as f32, &mut renderers.depths);
        depths.clear();
        depths.resize(frame.color().len(), 1.0);
        let kinds =
            [Drawn { lines: all, width: samples }, Drawn { lines: &seen, width: 1.75 * samples }];
        let memory = (frame, &mut depths[..]);
        let drawn = match &self.vertices {
            Vertices::Plain(vertices) => {
                let look = PlainLook::new(scene, lamp);
                self.lines_with(&mut renderers.plain, viewport, (vertices, &look), kinds, memory)
            }
            Vertices::Full(vertices) => {
                let look = FullLook { scene, textures: self.textures, view: self.view };
                self.lines_with(&mut renderers.full, viewport, (vertices, &look), kinds, memory)
            }
            Vertices::Bent(vertices) => {
                let look = FullLook { scene, textures: self.textures, view: self.view };
                self.lines_with(&mut renderers.bent, viewport, (vertices, &look), kinds, memory)
            }
        };
        renderers.seen = seen;
        drawn.map_err(|error| error.to_string())
    }

    fn lines_with<const N: usize>(
        &self,
        kept: &mut Kept<N>,
        viewport: Viewport,
        (vertices, look): (&[Vertex<N>], &impl Look<N>),
        kinds: [Drawn<'_>; 2],
        (frame, depths): (&mut Framebuffer<Vec4>, &mut [f32]),
    ) -> Result<(), TargetError> {
        let mesh = Mesh::new(vertices, self.scene.model.faces());
        let renderer = kept.z_buffer.get_or_insert_with(|| ZBufferRenderer::new(viewport));
        renderer.settings.viewport = viewport;
        // What a line is on lies back by as much as it is nearer to the eye half a line beside it, or half a
        // sample.
        let drawn = kinds.iter().filter(|kind| !kind.lines.is_empty());
        let widest = drawn.map(|kind| kind.width).fold(0.0, f32::max);
        renderer.settings.depth_bias = DepthBias { constant: 1e-6, slope: 0.75 * widest + 0.75 };
        if self.scene.model.has_transparency() {
            // Holes hide nothing.
            let mut colors = vec![(); depths.len()];
            let mut target = Target::new(frame.width(), &mut colors, depths)?;
            renderer.draw(&mut target, mesh, |f: &Fragment<'_, N>| look.normal(f).map(|_| ()));
        } else {
            renderer.draw_depth(&mut Target::new(frame.width(), frame.color_mut(), depths)?, mesh);
        }
        let target = &mut Target::new(frame.width(), frame.color_mut(), depths)?;
        renderer.settings.depth_bias = DepthBias::default();
        for Drawn { lines, width } in kinds {
            let lines = polyscan::Lines::new(vertices, lines);
            let lines = if width > 1.0 {
                lines.with_width(width).with_join(Join::Bevel).with_cap(Cap::Round)
            } else {
                lines
            };
            renderer.draw(target, lines, |_: &Fragment<'_, N>| INK);
        }
        Ok(())
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
                let look = FullLook { scene, textures: self.textures, view: self.view };
                self.stream_with(viewport, background, vertices, &look, row)
            }
            Vertices::Bent(vertices) => {
                let look = FullLook { scene, textures: self.textures, view: self.view };
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
        let mesh = Mesh::new(vertices, self.scene.model.faces()).with_transparent(&is_transparent);
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
                let look = FullLook { scene, textures: self.textures, view: self.view };
                self.seen_with((size, rows), vertices, &look)
            }
            Vertices::Bent(vertices) => {
                let look = FullLook { scene, textures: self.textures, view: self.view };
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
        let mesh = Mesh::new(vertices, self.scene.model.faces());
        let turn: Mat3 = self.view.axes.transpose();
        ZBufferRenderer::new(viewport).draw(&mut frame, mesh, |f: &Fragment<'_, N>| {
            let normal = (turn * look.normal(f)?).normalize_or_zero();
            Some(Seen { face: self.scene.source(f.face) + 1, distance: f.w, normal })
        });
        Ok(frame)
    }
}

fn surface(vertex: &ModelVertex) -> Surface {
    Surface { uv: vertex.uv, normal: vertex.normal, color: vertex.color }
}

fn bent_surface(vertex: &ModelVertex) -> BentSurface {
    let ModelVertex { uv, normal, color, tangent, .. } = *vertex;
    BentSurface { uv, normal, color, tangent }
}

pub(crate) fn size_error(error: SizeError) -> String {
    error.to_string()
}

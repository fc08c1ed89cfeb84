//! Models to pictures, in memory or row by row.

use polyscan::glam::{Mat3, Vec2, Vec3, Vec4};
use polyscan::model::{Face, Model};
use polyscan::render::Over;
use polyscan::{
    Fragment, Framebuffer, Mesh, ScanlineRenderer, SizeError, Vertex, Viewport, ZBufferRenderer,
    record,
};

use crate::view::View;

record! {
    /// What goes from the vertices to the pixels.
    struct Surface {
        uv: Vec2,
        normal: Vec3,
        color: Vec4,
    }
}

const N: usize = Surface::LEN;

/// A model as one view of it is drawn.
pub(crate) struct Scene<'a> {
    model: &'a Model,
    vertices: Vec<Vertex<N>>,
    faces: Vec<Face<'a>>,
    view: View,
    lamp: Vec3,
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
    pub(crate) fn new(model: &'a Model, view: View) -> Self {
        let surface = |v: &polyscan::model::ModelVertex| Surface {
            uv: v.uv,
            normal: v.normal,
            color: v.color,
        };
        let vertices = model.vertices_with(view.clip_from_object, surface);
        Self { model, vertices, faces: model.faces().collect(), view, lamp: view.lamp() }
    }

    /// The colour of a surface in white light.
    fn color(&self, fragment: &Fragment<'_, N>) -> Vec4 {
        let Surface { color, .. } = fragment.params.into();
        let material = self.faces[fragment.face as usize].material;
        // The texture coordinates are the first two of the surface's values.
        self.model.color_at(material, &fragment.footprint(0, 1), color)
    }

    /// The colour of a surface: lit alike from both sides, for many files have faces that are turned over.
    fn shade(&self, fragment: &Fragment<'_, N>) -> Over {
        let Surface { normal, .. } = fragment.params.into();
        let color = self.color(fragment);
        let light = 0.2 + 0.8 * normal.normalize_or_zero().dot(self.lamp).abs();
        Over((color.truncate() * light).extend(color.w))
    }

    /// The picture, of so many samples: linear light, premultiplied by alpha.
    pub(crate) fn colors(
        &self,
        (width, height): (u32, u32),
        background: Vec4,
    ) -> Result<Framebuffer<Vec4>, SizeError> {
        let mut frame = Framebuffer::new(width, height, background)?;
        if self.model.has_transparency() {
            // Glass and cut-outs in their true order, which a z-buffer does not know.
            let is_transparent = |face| self.is_transparent(face);
            let mesh = Mesh::new(&self.vertices, &self.faces).with_transparent(&is_transparent);
            ScanlineRenderer::new(frame.viewport()).draw(&mut frame, mesh, |f| self.shade(f));
        } else {
            let mesh = Mesh::new(&self.vertices, &self.faces);
            ZBufferRenderer::new(frame.viewport()).draw(&mut frame, mesh, |f| self.shade(f));
        }
        Ok(frame)
    }

    /// Draws from top to bottom and hands over each row of samples.
    pub(crate) fn stream<E>(
        &self,
        viewport: Viewport,
        background: Vec4,
        row: impl FnMut(u32, &[Vec4]) -> Result<(), E>,
    ) -> Result<(), E> {
        let is_transparent = |face| self.is_transparent(face);
        let mesh = Mesh::new(&self.vertices, &self.faces).with_transparent(&is_transparent);
        let mut renderer = ScanlineRenderer::new(viewport);
        renderer.stream(mesh, background, |f: &Fragment<'_, N>| self.shade(f), row)
    }

    fn is_transparent(&self, face: u32) -> bool {
        self.model.materials[self.faces[face as usize].material].is_transparent()
    }

    /// What is seen at each of so many samples. Holes of cut-outs are holes; glass is seen itself.
    pub(crate) fn seen(&self, (width, height): (u32, u32)) -> Result<Framebuffer<Seen>, SizeError> {
        let mut frame = Framebuffer::new(width, height, Seen::NOTHING)?;
        let mesh = Mesh::new(&self.vertices, &self.faces);
        let turn: Mat3 = self.view.axes.transpose();
        ZBufferRenderer::new(frame.viewport()).draw(&mut frame, mesh, |f: &Fragment<'_, N>| {
            let Surface { normal, .. } = f.params.into();
            let color = self.color(f);
            let normal = (turn * normal).normalize_or_zero();
            (color.w > 0.0).then_some(Seen { face: f.face + 1, distance: f.w, normal })
        });
        Ok(frame)
    }
}

/// Which lines are drawn.
#[derive(Clone, Copy)]
pub(crate) struct Lines {
    /// Those between all faces.
    pub(crate) wireframe: bool,
    /// Those where the surface bends or ends.
    pub(crate) edges: bool,
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

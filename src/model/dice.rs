//! Displacement mapping: faces diced to micropolygons, which are moved along their normals by a picture of heights.
//!
//! What flows in is a [`Model`] and how it is seen; what flows out is the same model, whose faces with heights are
//! triangles of about a pixel (R. Cook, L. Carpenter and E. Catmull, "The Reyes Image Rendering Architecture", SIGGRAPH
//! 1987, section 3.2: dicing; R. Cook, "Shade Trees", SIGGRAPH 1984, section 6: displacement).
//!
//! - `model::dice::sight` says how large things are on the screen, and what is outside;
//! - `model::dice::cut` cuts polygons into triangles;
//! - `model::dice::net` has triangles that share edges, and cuts edges in two;
//! - `model::dice::base` makes the first net of a model's faces;
//! - `model::dice::heights` moves points, and finds normals.

use std::borrow::Cow;
use std::f32::consts::SQRT_2;

use glam::Mat4;

use crate::model::Model;
use crate::model::dice::base::Base;
use crate::model::dice::heights::Heights;
use crate::model::dice::net::{Net, Piece};
use crate::model::dice::sight::Sight;
use crate::model::faces::FacesByMaterial;
use crate::model::material::Material;
use crate::model::vertex::ModelVertex;
use crate::viewport::Viewport;

mod sight;
mod cut;
mod net;
mod base;
mod heights;

/// The most micropolygons of a model. They take some 300 bytes each while they are made.
const MOST_PIECES: usize = 1 << 23;

/// The shortest edges, in pixels, that may be asked for.
const SHORTEST: f32 = 0.125;

impl Model {
    /// The model with its displacement maps as geometry: faces whose material has one are diced to triangles with
    /// edges of about `edge` pixels, and moved along their normals by
    /// [`Material::displacement_at`]. The model itself where no face is.
    ///
    /// Unlike a normal map this changes the outline, hides what is behind a bump, and needs as many triangles as there
    /// are pixels; so they are made for one view, by the matrix and the viewport that it is drawn with. A viewport
    /// [moved to a tile](Viewport::with_corner) gives the same triangles as the whole.
    ///
    /// ```
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("square.obj");
    /// use glam::Vec4;
    /// use polyscan::{Framebuffer, Mesh, Model, ZBufferRenderer};
    ///
    /// # std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
    /// let model = Model::load(&path)?.model;
    /// let clip_from_object = model.camera(4.0 / 3.0).clip_from_object();
    /// let mut frame = Framebuffer::new(320, 240, Vec4::ONE)?;
    ///
    /// let model = model.displaced(clip_from_object, frame.viewport(), 1.0);
    /// let vertices = model.vertices_with(clip_from_object, |v| v.normal);
    /// ZBufferRenderer::new(frame.viewport()).draw(&mut frame, Mesh::new(&vertices, model.faces()), |f| {
    ///     let [x, y, z] = f.params;
    ///     Vec4::new(0.5 + 0.5 * x, 0.5 + 0.5 * y, 0.5 + 0.5 * z, 1.0)
    /// });
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// **Size.** An edge is cut in two while it is longer than √2 times `edge` pixels where it is nearest to the eye, as
    /// if it lay across the view: what is seen edge-on is diced alike, for its bumps make the outline. The longer of the
    /// two lengths counts that it has before and after it was moved, but edges that were shorter than a quarter of
    /// that are never cut, so that cliffs in the heights stretch some. Faces outside of the view volume, and of what could be
    /// moved into it, are not cut. If the model would have more than 2^23 triangles, `edge` is made larger until
    /// it has not; what is below 1/8, or no number, counts as 1/8.
    ///
    /// **No cracks.** An edge is cut or not whatever face one looks at it from, and a place is moved once: along one
    /// direction, the mean of the normals there where faces have their own, and by one height, the mean of those that the
    /// faces' texture coordinates lead to. Where normals cancel, and beside faces that have no heights, the surface stays
    /// at its place. Such neighbours are cut into triangles for their edges to meet, and stay where they are.
    ///
    /// **Heights** are sampled by the texture's own filters, with the footprint of an edge. Normals are bent by their
    /// slopes (J. Blinn, "Simulation of Wrinkled Surfaces", SIGGRAPH 1978), taken over two texels at least. Materials that
    /// have a normal map as well keep the normals of the faces as they are, for such maps are made of the same heights.
    ///
    /// Faces without texture coordinates, or with numbers that are not finite, have no heights. The materials of what is
    /// returned name no displacement map any more, its textures are shared with the model, and
    /// [`Face::source`](crate::model::Face::source) tells which face a triangle is part of.
    #[must_use]
    pub fn displaced(
        &self,
        clip_from_object: Mat4,
        viewport: Viewport,
        edge: f32,
    ) -> Cow<'_, Self> {
        self.displaced_within(clip_from_object, viewport, edge, MOST_PIECES)
    }

    /// The same with so many pieces at the most, or as many as the faces need.
    fn displaced_within(
        &self,
        clip_from_object: Mat4,
        viewport: Viewport,
        edge: f32,
        most: usize,
    ) -> Cow<'_, Self> {
        let heights = Heights::of(&self.materials, &self.textures);
        let Some(base) = Base::of(self, &heights) else { return Cow::Borrowed(self) };
        let mut sight = Sight::new(clip_from_object, viewport, heights.most());
        sight.edge = if sight.is_usable() { edge.max(SHORTEST) } else { f32::INFINITY };
        let net = diced_within(&base.net, &mut sight, &heights, most);
        Cow::Owned(self.with_pieces(&base, net, &sight, &heights))
    }

    /// The model whose faces in the net are its pieces.
    fn with_pieces(&self, base: &Base, net: Net, sight: &Sight, heights: &Heights<'_>) -> Self {
        let mut vertices = heights.vertices(&net, sight);
        let mut pieces = net.done;
        pieces.sort_by_key(|piece| piece.face);
        let mut pieces = pieces.into_iter().peekable();
        let mut index_of = vec![None; self.vertices.len()];
        let mut faces = FacesByMaterial::default();
        let mut add = |indices: &[u32], has_uv: bool, source: usize| {
            faces.indices.extend(indices);
            faces.ends.push(faces.indices.len() as u32);
            faces.has_uv.push(has_uv);
            faces.sources.push(source as u32);
            faces.ends.len() as u32
        };
        let mut material_ends = Vec::new();
        let mut number = 0;
        for material in 0..self.faces.material_ends.len() {
            let mut end = material_ends.last().copied().unwrap_or(0);
            for face in self.faces_of(material) {
                if base.is_in_net[number] {
                    while let Some(Piece { corners, .. }) =
                        pieces.next_if(|piece| piece.face as usize == number)
                    {
                        end = add(&corners, face.has_uv, face.source);
                    }
                } else {
                    let indices: Vec<u32> = face
                        .indices
                        .iter()
                        .map(|&index| kept(&self.vertices, index, &mut index_of, &mut vertices))
                        .collect();
                    end = add(&indices, face.has_uv, face.source);
                }
                number += 1;
            }
            material_ends.push(end);
        }
        faces.material_ends = material_ends;
        let plain =
            |material: &Material| Material { displacement_texture: None, ..material.clone() };
        Self {
            vertices,
            materials: self.materials.iter().map(plain).collect(),
            textures: self.textures.clone(),
            origin: self.origin,
            faces,
        }
    }
}

/// The new index of a vertex that stays, which is added at its first use. That of one which is not there is not there.
fn kept(
    all: &[ModelVertex],
    index: u32,
    index_of: &mut [Option<u32>],
    vertices: &mut Vec<ModelVertex>,
) -> u32 {
    let (Some(new), Some(vertex)) = (index_of.get_mut(index as usize), all.get(index as usize))
    else {
        return u32::MAX;
    };
    *new.get_or_insert_with(|| {
        vertices.push(*vertex);
        vertices.len() as u32 - 1
    })
}

/// The net with edges that are short enough, or that have been made so much longer that it has no more than the most
/// pieces.
fn diced_within(net: &Net, sight: &mut Sight, heights: &Heights<'_>, most: usize) -> Net {
    if let Some(net) = diced(net.clone(), sight, heights, most) {
        return net;
    }
    // Edges of half the length make four times as many pieces, if these are more than the faces.
    let enough = 8 * net.waiting.len();
    let shortest = sight.edge;
    sight.edge *= 65_536.0;
    let count = loop {
        let count = diced(net.clone(), sight, heights, most).map_or(most, |net| net.done.len());
        if count >= enough || sight.edge <= shortest {
            break count;
        }
        sight.edge *= 0.5;
    };
    sight.edge *= (count as f32 / (most / 2) as f32).sqrt();
    let mut growth = SQRT_2;
    loop {
        if let Some(net) = diced(net.clone(), sight, heights, most) {
            return net;
        }
        (sight.edge, growth) = (sight.edge * growth, growth * growth);
    }
}

/// The net with edges that are short enough; `None` if it would have too many pieces.
fn diced(mut net: Net, sight: &Sight, heights: &Heights<'_>, most: usize) -> Option<Net> {
    let most = most.max(net.waiting.len());
    heights.place(&mut net, (0, 0), sight);
    while !net.waiting.is_empty() {
        let before = (net.points.len(), net.corners.len());
        net.mark(sight);
        net.halve_edges();
        if net.count_of_next() > most {
            return None;
        }
        heights.place(&mut net, before, sight);
        net.cut_triangles();
    }
    Some(net)
}

#[cfg(all(test, feature = "obj"))]
mod tests {
    use glam::Vec4;

    use super::*;
    use crate::texture::Texture;

    /// What would take too many pieces takes larger ones, of the size that the number allows.
    #[test]
    fn dicing_is_bounded() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("square.obj");
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
        std::fs::write(&path, text).expect("a file");
        let mut model = Model::load(&path).expect("a model").model;
        model.textures.push(Texture::from_fn(1, 1, |_, _| Vec4::splat(0.1)).expect("a texel"));
        model.materials[0].displacement_texture = Some(0);
        let matrix = model.camera(1.0).clip_from_object();
        let viewport = Viewport::new(20_000, 20_000).expect("a size");
        for most in [1, 2, 3, 100, 5000, 50_000] {
            let diced = model.displaced_within(matrix, viewport, 1.0, most);
            let (least, most) = (most / 8, most.max(2));
            assert!((least..=most).contains(&diced.face_count()), "{}", diced.face_count());
        }
    }
}

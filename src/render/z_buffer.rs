//! The z-buffer renderer (Catmull 1974): each fragment is compared with the depth that its pixel
//! has so far, and drawn if it is nearer.
//!
//! The comparison comes before the reciprocal and the shader, so hidden pixels cost neither.

use crate::fragment::{Block, Fragment, LANES, Lanes};
use crate::project::Viewport;
use crate::render::framebuffer::Framebuffer;
use crate::render::shader::IntoColor;
use crate::scan::ScanConverter;
use crate::vertex::Vertex;

/// When a fragment passes, by its depth and the depth stored for its pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthTest {
    /// Never.
    Never,
    /// If its depth is less: the nearest wins, and the first of equals.
    #[default]
    Less,
    /// If its depth is equal.
    Equal,
    /// If its depth is less or equal.
    LessEqual,
    /// If its depth is greater: for reversed depth, and for [`DepthSource::InverseW`].
    Greater,
    /// If its depth is different.
    NotEqual,
    /// If its depth is greater or equal.
    GreaterEqual,
    /// Always.
    Always,
}

impl DepthTest {
    /// Which lanes pass, a bit a lane.
    #[inline(always)]
    fn passes(self, new: &Lanes, old: &Lanes) -> u32 {
        #[inline(always)]
        fn compare(new: &Lanes, old: &Lanes, test: impl Fn(f32, f32) -> bool) -> u32 {
            (0..LANES).fold(0, |bits, lane| bits | u32::from(test(new[lane], old[lane])) << lane)
        }
        match self {
            Self::Never => 0,
            Self::Less => compare(new, old, |new, old| new < old),
            Self::Equal => compare(new, old, |new, old| new == old),
            Self::LessEqual => compare(new, old, |new, old| new <= old),
            Self::Greater => compare(new, old, |new, old| new > old),
            Self::NotEqual => compare(new, old, |new, old| new != old),
            Self::GreaterEqual => compare(new, old, |new, old| new >= old),
            Self::Always => (1 << LANES) - 1,
        }
    }
}

/// What is compared and stored as depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthSource {
    /// z/w in the viewport's depth range. Right for any projection.
    #[default]
    Z,
    /// 1/w, which is interpolated anyway (Low, "Perspective-Correct Interpolation", 2002). It grows
    /// towards the eye: clear the depth to 0 and test with [`DepthTest::Greater`]. It tells nothing
    /// in an orthographic projection, where all w are equal.
    InverseW,
}

/// Draws polygons into a framebuffer, hidden surfaces removed.
///
/// ```
/// use glam::vec4;
/// use polyscan::{Framebuffer, Vertex, ZBuffer};
///
/// let mut frame = Framebuffer::new(4, 2, '.')?;
/// let mut renderer = ZBuffer::new(frame.viewport());
/// let quad = [(-1.0, -1.0), (0.0, -1.0), (0.0, 1.0), (-1.0, 1.0)]
///     .map(|(x, y)| Vertex::new(vec4(x, y, 0.5, 1.0), []));
/// renderer.draw(&mut frame, &quad, |_| '#');
/// assert_eq!(frame.color(), ['#', '#', '.', '.', '#', '#', '.', '.']);
/// # Ok::<(), polyscan::SizeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ZBuffer<const N: usize> {
    /// Where and how polygons are scan-converted: viewport, scissor, culling, interpolation.
    pub scan: ScanConverter<N>,
    /// When a fragment is drawn.
    pub depth_test: DepthTest,
    /// Whether the depth of a fragment that is drawn is stored.
    pub depth_write: bool,
    /// What is compared and stored.
    pub depth_source: DepthSource,
}

impl<const N: usize> ZBuffer<N> {
    /// A renderer to a viewport, with the settings of [`ScanConverter::new`], that draws what has
    /// less depth and stores it.
    pub fn new(viewport: Viewport) -> Self {
        Self {
            scan: ScanConverter::new(viewport),
            depth_test: DepthTest::default(),
            depth_write: true,
            depth_source: DepthSource::default(),
        }
    }

    /// Draws a polygon. `shader` is called once for each fragment that passes the depth test; it
    /// returns a colour, or an `Option` of one, where `None` discards the fragment.
    ///
    /// What does not lie on the framebuffer is left out. Any polygon is safe; see
    /// [`ScanConverter::spans`] for what it covers.
    pub fn draw<C, R>(
        &mut self,
        frame: &mut Framebuffer<C>,
        polygon: &[Vertex<N>],
        shader: impl Fn(&Fragment<'_, N>) -> R,
    ) where
        C: Copy,
        R: IntoColor<C>,
    {
        let depth_write = self.depth_write;
        self.visit(frame, polygon, |block, visible, depth, colors, depths| {
            let params = block.params();
            for (i, lane) in block.lanes.clone().enumerate() {
                if visible >> lane & 1 == 0 {
                    continue;
                }
                let fragment = block.fragment(lane, depth[lane], &params);
                if let Some(color) = shader(&fragment).into_color() {
                    colors[i] = color;
                    if depth_write {
                        depths[i] = depth[lane];
                    }
                }
            }
        });
    }

    /// Draws the faces of a mesh, each a list of indices into `vertices`, in order. A face with an
    /// index out of range is left out.
    pub fn draw_mesh<C, R, F>(
        &mut self,
        frame: &mut Framebuffer<C>,
        vertices: &[Vertex<N>],
        faces: F,
        shader: impl Fn(&Fragment<'_, N>) -> R,
    ) where
        C: Copy,
        R: IntoColor<C>,
        F: IntoIterator<Item: AsRef<[u32]>>,
    {
        let mut polygon = Vec::new();
        for face in faces {
            polygon.clear();
            let corners = face.as_ref().iter().map_while(|&i| vertices.get(i as usize));
            polygon.extend(corners);
            if polygon.len() == face.as_ref().len() {
                self.draw(frame, &polygon, &shader);
            }
        }
    }

    /// Draws the depth of a polygon alone: nothing is shaded, no parameter is evaluated.
    pub fn draw_depth<C: Copy>(&mut self, frame: &mut Framebuffer<C>, polygon: &[Vertex<N>]) {
        if !self.depth_write {
            return;
        }
        self.visit(frame, polygon, |block, visible, depth, _, depths| {
            for (i, lane) in block.lanes.clone().enumerate() {
                if visible >> lane & 1 != 0 {
                    depths[i] = depth[lane];
                }
            }
        });
    }

    /// Calls `draw` for each block with a pixel that passes the depth test: the block, the lanes
    /// that pass, their depths, and the framebuffer's colours and depths at the block's columns.
    #[inline(always)]
    fn visit<C: Copy>(
        &mut self,
        frame: &mut Framebuffer<C>,
        polygon: &[Vertex<N>],
        mut draw: impl FnMut(&Block<'_, N>, u32, &Lanes, &mut [C], &mut [f32]),
    ) {
        for span in self.scan.spans_within(polygon, frame.rect()) {
            let Some((colors, depths)) = frame.row_mut(span.y()) else { continue };
            for block in span.blocks() {
                let columns = block.columns();
                let columns = columns.start as usize..columns.end as usize;
                let (colors, depths) = (&mut colors[columns.clone()], &mut depths[columns]);
                let depth = match self.depth_source {
                    DepthSource::Z => block.depth(),
                    DepthSource::InverseW => block.inverse_w(),
                };
                let mut stored = [0.0; LANES];
                stored[block.lanes.clone()].copy_from_slice(depths);
                let lanes = (1u32 << block.lanes.end) - (1 << block.lanes.start);
                let visible = self.depth_test.passes(&depth, &stored) & lanes;
                if visible != 0 {
                    draw(&block, visible, &depth, colors, depths);
                }
            }
        }
    }
}

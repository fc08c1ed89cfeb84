//! Outlines that fall into parts.
//!
//! A concave polygon, or one with holes, may cross a plane more than twice. Sutherland and Hodgman
//! leave one contour then, its parts joined by edges that run to and fro along the plane: harmless
//! on paper, but when their ends are rounded to the grid of the screen they do not lie on one line
//! any more, and slivers open between them. Here the pieces of the outline on the inner side are
//! closed anew instead. Their ends are sorted along the plane; between each and the next one runs a
//! single edge that counts as often as the outline winds around the points inside of it, which is
//! the sum of the ends so far:
//!
//! ```text
//!     inside  |  |    |  |      pieces of the outline, down +1, up -1 at their ends
//!     --------A--B----C--D---   the plane: edges from A to B and from C to D, none from B to C
//!     outside
//! ```
//!
//! No two edges run along the same stretch of the plane, so nothing is left to cancel. The result
//! is a list of [`Chain`]s; the plane's may have any winding.
//!
//! Where the outline touches a plane from outside, a vertex that lies on it parts the edge along the
//! plane, too, if the plane's other side may be wanted. For what is left there has that vertex, and once
//! it is rounded it does not lie on the line between its neighbours.

use glam::{DVec2, Vec4Swizzles};

use crate::clip::records::Records;
use crate::outline::Chain;

/// A cut of chains by a plane, with the memory that it takes.
#[derive(Clone, Debug, Default)]
pub(crate) struct ChainCutter {
    crossings: Vec<Crossing>,
    /// The vertices on the plane that are ends of edges outside, or of edges in the plane.
    touching: Vec<usize>,
}

/// Where a chain of the clipped outline begins or ends on the plane.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    /// The index of the vertex.
    vertex: usize,
    /// Where it lies along the plane.
    along: f64,
    /// The winding of the chain if it ends here, less that if it begins; 0 if it merely touches.
    change: i32,
}

impl ChainCutter {
    /// Writes what lies on the inner side of a plane to `next` and `next_chains`. `distances` are
    /// those of the vertices from the plane, and `cross` adds the vertex in which the edge between two
    /// of them crosses it.
    #[cold]
    pub(crate) fn cut(
        &mut self,
        (vertices, chains): (&Records, &[Chain]),
        (next, next_chains): (&mut Records, &mut Vec<Chain>),
        has_two_sides: bool,
        distance: impl Fn(usize) -> f64,
        cross: impl Fn(&mut Records, [usize; 2], [f64; 2]),
    ) {
        next.clear(vertices.width());
        next_chains.clear();
        self.crossings.clear();
        self.touching.clear();
        let mut start = 0;
        for &Chain { end, winding } in chains {
            let mut pieces = Pieces {
                vertices: next,
                chains: next_chains,
                crossings: &mut self.crossings,
                winding,
                is_open: false,
            };
            let mut da = if start < end { distance(start) } else { 0.0 };
            for (a, b) in (start..end).zip(start + 1..end) {
                let db = distance(b);
                // An edge in the plane is left out: the edges along the plane take its place.
                if da > 0.0 || db > 0.0 {
                    let add = |records: &mut Records, inside: bool, vertex: usize| {
                        if inside {
                            records.push_from(vertices, vertex);
                        } else {
                            cross(records, [a, b], [da, db]);
                        }
                    };
                    pieces.add(
                        |records| add(records, da >= 0.0, a),
                        |records| add(records, db >= 0.0, b),
                        [da <= 0.0, db <= 0.0],
                    );
                } else {
                    self.touching.extend((da == 0.0).then_some(a));
                    self.touching.extend((db == 0.0).then_some(b));
                }
                da = db;
            }
            pieces.end();
            start = end;
        }
        if has_two_sides && !self.crossings.is_empty() {
            for &touching in &self.touching {
                self.crossings.push(Crossing { vertex: next.len(), along: 0.0, change: 0 });
                next.push_from(vertices, touching);
                next_chains.push(Chain { end: next.len(), winding: 0 });
            }
        }
        self.close_along_plane(next, next_chains);
    }

    /// Joins the ends of the pieces along the plane.
    fn close_along_plane(&mut self, vertices: &mut Records, chains: &mut Vec<Chain>) {
        sort_along_plane(vertices, &mut self.crossings);
        let mut winding = 0i32;
        for (crossing, after) in self.crossings.iter().zip(self.crossings.iter().skip(1)) {
            winding = crossing.change.wrapping_add(winding);
            let (a, b) = (crossing.vertex, after.vertex);
            if winding != 0 && vertices.positions()[a] != vertices.positions()[b] {
                vertices.repeat(a);
                vertices.repeat(b);
                chains.push(Chain { end: vertices.len(), winding });
            }
        }
    }
}

/// The pieces of a chain on the inner side of a plane.
struct Pieces<'a> {
    vertices: &'a mut Records,
    chains: &'a mut Vec<Chain>,
    crossings: &'a mut Vec<Crossing>,
    winding: i32,
    is_open: bool,
}

impl Pieces<'_> {
    /// Adds the next edge, whose ends are given by what adds them, and whether its start and its end
    /// lie on the plane: there pieces begin and end.
    fn add(
        &mut self,
        start: impl FnOnce(&mut Records),
        end: impl FnOnce(&mut Records),
        [starts, ends]: [bool; 2],
    ) {
        if !self.is_open {
            start(self.vertices);
            self.is_open = true;
        }
        if starts {
            self.cross(self.winding.wrapping_neg());
        }
        end(self.vertices);
        if ends {
            self.cross(self.winding);
            self.end();
        }
    }

    /// Notes that the last vertex lies on the plane.
    fn cross(&mut self, change: i32) {
        self.crossings.push(Crossing { vertex: self.vertices.len() - 1, along: 0.0, change });
    }

    /// Ends the piece, if there is one.
    fn end(&mut self) {
        if std::mem::take(&mut self.is_open) {
            self.chains.push(Chain { end: self.vertices.len(), winding: self.winding });
        }
    }
}

/// Sorts crossings with a plane along the line in which it cuts the polygon's own plane, as it is
/// seen on the screen: by x/w or y/w, whichever varies more. All w are positive here.
fn sort_along_plane(vertices: &Records, crossings: &mut [Crossing]) {
    let on_screen = |crossing: &Crossing| {
        let position = vertices.positions()[crossing.vertex];
        position.xy() / position.w
    };
    let (min, max) = crossings
        .iter()
        .map(on_screen)
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), along| {
            (min.min(along), max.max(along))
        });
    let axis = usize::from(max.y - min.y > max.x - min.x);
    for crossing in crossings.iter_mut() {
        crossing.along = on_screen(crossing)[axis];
    }
    crossings.sort_unstable_by(|a, b| a.along.total_cmp(&b.along).then(a.vertex.cmp(&b.vertex)));
}

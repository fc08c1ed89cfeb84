//! For each point the face corners that meet there.

use crate::model::corners::Corners;
use crate::model::faces::range_before;

/// For each point the corners that meet there, in one list.
pub(super) struct Fans {
    corners: Vec<u32>,
    /// Where each point's corners end.
    ends: Vec<u32>,
}

impl Fans {
    /// Counting sort of the corners by point, which keeps the order of the file.
    pub(super) fn new(corners: &Corners) -> Self {
        let mut starts = vec![0; corners.points.len()];
        for &point in &corners.point {
            starts[point as usize] += 1;
        }
        let mut total = 0;
        for start in &mut starts {
            (*start, total) = (total, total + *start);
        }
        // Each start moves on to its end as corners are put in.
        let mut ends = starts;
        let mut sorted = vec![0; corners.point.len()];
        for (corner, &point) in (0..).zip(&corners.point) {
            sorted[ends[point as usize] as usize] = corner;
            ends[point as usize] += 1;
        }
        Self { corners: sorted, ends }
    }

    /// The number of points.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// All corners, point by point.
    pub(super) fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// The corners at a point, in the order of the file.
    pub(super) fn of(&self, point: usize) -> &[u32] {
        &self.corners[range_before(&self.ends, point)]
    }
}

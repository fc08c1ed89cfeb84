//! Continues the border of what is covered in a texture.
//!
//! The nearest covered texel is found in two steps: first in each row for itself, by a sweep in each
//! direction, then among those of the rows above and below.

use crate::render::Framebuffer;

/// No column.
const NONE: u32 = u32::MAX;

/// Gives each texel that has covered ones, whose depth is less than 1, within so many rows and columns the
/// colour of the nearest of these; of equals that of the first.
pub(crate) fn dilate<C: Copy>(texels: &mut Framebuffer<C>, margin: u32) {
    let (width, height) = (texels.width() as usize, texels.height() as usize);
    let margin = (margin as usize).min(width.max(height));
    if margin == 0 || width == 0 {
        return;
    }
    let mut nearest = vec![NONE; width * height];
    for (depths, nearest) in texels.depth().chunks(width).zip(nearest.chunks_mut(width)) {
        find_in_row(depths, nearest, margin);
    }
    let mut found = Vec::new();
    for (i, _) in texels.depth().iter().enumerate().filter(|(_, depth)| **depth >= 1.0) {
        let (x, y) = (i % width, i / width);
        let rows = y.saturating_sub(margin)..height.min(y + margin + 1);
        let sources = rows.filter_map(|row| {
            let column = nearest[row * width + x];
            let (dx, dy) = ((column as usize).abs_diff(x), row.abs_diff(y));
            let source = row * width + column as usize;
            (column != NONE).then_some((dx * dx + dy * dy, source))
        });
        found.extend(sources.min().map(|(_, source)| (i, source)));
    }
    let colors = texels.color_mut();
    for (texel, source) in found {
        colors[texel] = colors[source];
    }
}

/// Finds the nearest covered texel in a row for each, within so many columns; of two the left one.
fn find_in_row(depths: &[f32], nearest: &mut [u32], margin: usize) {
    let mut last = None;
    for (x, (depth, nearest)) in depths.iter().zip(&mut *nearest).enumerate() {
        last = if *depth < 1.0 { Some(x) } else { last };
        *nearest = last.filter(|last| x - last <= margin).map_or(NONE, |last| last as u32);
    }
    last = None;
    for (x, (depth, nearest)) in depths.iter().zip(&mut *nearest).enumerate().rev() {
        last = if *depth < 1.0 { Some(x) } else { last };
        let Some(right) = last.filter(|right| right - x <= margin) else { continue };
        if *nearest == NONE || right - x < x - *nearest as usize {
            *nearest = right as u32;
        }
    }
}

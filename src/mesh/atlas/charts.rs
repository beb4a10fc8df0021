//! The `charts` method: how a surface is cut into few charts, and how each is flattened.

use glam::DVec2;

use super::super::surface::Surface;
use super::flat::FlatChart;
use super::{AtlasError, Control};

/// Cuts and flattens all objects.
pub(super) fn flat_charts(
    surface: &Surface,
    control: &Control<'_>,
) -> Result<Vec<FlatChart>, AtlasError> {
    control.step("cutting into charts", 0.0)?;
    Ok((0..surface.triangles.len() as u32)
        .map(|t| {
            let shape = surface.triangles[t as usize];
            FlatChart {
                object: shape.object,
                triangles: vec![t],
                corners: vec![[
                    DVec2::ZERO,
                    DVec2::new(f64::from(shape.ab), 0.0),
                    DVec2::new(f64::from(shape.cp), f64::from(shape.ch)),
                ]],
            }
        })
        .collect())
}

/// Cuts a chart into two pieces or more, each a disc, flattened as before.
pub(super) fn split(_surface: &Surface, flat: &FlatChart) -> Vec<FlatChart> {
    let triangles = flat.triangles.iter().zip(&flat.corners);
    triangles
        .map(|(&t, &corners)| FlatChart {
            object: flat.object,
            triangles: vec![t],
            corners: vec![corners],
        })
        .collect()
}

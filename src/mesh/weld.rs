//! One vertex for each position, and no triangle without an inside.

use glam::Vec3;
use rayon::slice::ParallelSliceMut;

use super::MeshReport;
use super::error::MeshProblem;
use super::soup::{FARTHEST, MOST_TRIANGLES};
use super::stitch::{has_inside, stitch};

/// Lengths outside of this range overflow or vanish when a float32 kernel multiplies them.
const EXTENT: std::ops::RangeInclusive<f64> = 1e-12..=FARTHEST;

/// Triangles that share their vertices.
pub(crate) struct Welded {
    /// Every vertex is a corner of some triangle; in the order of the file.
    pub positions: Vec<Vec3>,
    pub corners: Vec<[u32; 3]>,
    /// The number of each triangle in the file.
    pub file_triangle: Vec<u32>,
}

/// Makes vertices with identical float32 coordinates one, then drops triangles that cannot be walked on:
/// those of which two corners are now one vertex, those without area (in double precision, an edge or a height below
/// 1e-30), and those with the same three vertices as an earlier one, whichever way they face.
pub(crate) fn weld(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    report: &mut MeshReport,
) -> Result<Welded, MeshProblem> {
    if triangles.len() > MOST_TRIANGLES {
        return Err(MeshProblem::TooMany {
            what: "triangles",
            count: triangles.len() as u64,
            most: MOST_TRIANGLES as u64,
        });
    }
    check_coordinates(positions, triangles, report)?;
    let first_at = first_vertices(positions);

    let mut kept = Vec::with_capacity(triangles.len());
    let mut file_triangle = Vec::with_capacity(triangles.len());
    for (file, corners) in triangles.iter().enumerate() {
        let [a, b, c] = corners.map(|vertex| first_at[vertex as usize]);
        if a == b || b == c || c == a {
            report.repeated_corners += 1;
        } else if !has_inside([a, b, c].map(|vertex| positions[vertex as usize].as_dvec3())) {
            report.without_area += 1;
        } else {
            kept.push([a, b, c]);
            file_triangle.push(file as u32);
        }
    }
    drop_duplicates(&mut kept, &mut file_triangle, report);
    if stitch(positions, &mut kept, report) {
        drop_duplicates(&mut kept, &mut file_triangle, report);
    }
    if kept.is_empty() {
        return Err(MeshProblem::AllDegenerate {
            count: triangles.len(),
        });
    }

    // Number the vertices that are left, in the order of the file.
    let mut number = vec![u32::MAX; positions.len()];
    for &vertex in kept.iter().flatten() {
        number[vertex as usize] = 0;
    }
    let mut left = Vec::with_capacity(positions.len());
    for (number, &position) in number.iter_mut().zip(positions) {
        if *number == 0 {
            *number = left.len() as u32;
            left.push(position);
        }
    }
    for vertex in kept.iter_mut().flatten() {
        *vertex = number[*vertex as usize];
    }
    Ok(Welded {
        positions: left,
        corners: kept,
        file_triangle,
    })
}

/// Refuses vertices of triangles that are not finite or out of reach of float32 arithmetic; counts those that no
/// triangle uses, and those that welding makes one with another.
fn check_coordinates(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    report: &mut MeshReport,
) -> Result<(), MeshProblem> {
    let mut used = vec![false; positions.len()];
    for (triangle, corners) in triangles.iter().enumerate() {
        for &vertex in corners {
            let position = positions[vertex as usize];
            used[vertex as usize] = true;
            if !position.is_finite() {
                return Err(MeshProblem::NonFiniteVertex {
                    vertex: u64::from(vertex),
                    line: None,
                    position: position.to_array(),
                    face: triangle as u64,
                });
            }
        }
    }
    let mut low = Vec3::INFINITY;
    let mut high = Vec3::NEG_INFINITY;
    for (&position, &used) in positions.iter().zip(&used) {
        if used {
            low = low.min(position);
            high = high.max(position);
        } else {
            report.unreferenced_vertices += 1;
            report.unreferenced_non_finite += usize::from(!position.is_finite());
        }
    }
    let farthest = f64::from(low.abs().max(high.abs()).max_element());
    let extent = (high.as_dvec3() - low.as_dvec3()).max_element();
    if farthest > *EXTENT.end() {
        return Err(MeshProblem::TooFar { farthest });
    }
    if extent > 0.0 && !EXTENT.contains(&extent) {
        return Err(MeshProblem::TooSmall { extent });
    }
    Ok(())
}

/// For each vertex, the first one with the same float32 coordinates; minus zero is zero.
fn first_vertices(positions: &[Vec3]) -> Vec<u32> {
    let mut sorted: Vec<([u32; 3], u32)> = positions
        .iter()
        .enumerate()
        .map(|(vertex, &position)| {
            (
                (position + Vec3::ZERO).to_array().map(f32::to_bits),
                vertex as u32,
            )
        })
        .collect();
    sorted.par_sort_unstable();
    let mut first_at = vec![0; positions.len()];
    for same in sorted.chunk_by(|a, b| a.0 == b.0) {
        for &(_, vertex) in same {
            first_at[vertex as usize] = same[0].1;
        }
    }
    first_at
}

fn drop_duplicates(
    corners: &mut Vec<[u32; 3]>,
    file_triangle: &mut Vec<u32>,
    report: &mut MeshReport,
) {
    let mut sorted: Vec<([u32; 3], u32)> = corners
        .iter()
        .enumerate()
        .map(|(triangle, &corners)| {
            let mut key = corners;
            key.sort_unstable();
            (key, triangle as u32)
        })
        .collect();
    sorted.par_sort_unstable();
    let mut duplicate = vec![false; corners.len()];
    for same in sorted.chunk_by(|a, b| a.0 == b.0) {
        for &(_, triangle) in &same[1..] {
            duplicate[triangle as usize] = true;
            report.duplicates += 1;
        }
    }
    if report.duplicates > 0 {
        let mut is_duplicate = duplicate.iter();
        corners.retain(|_| !is_duplicate.next().copied().unwrap_or(false));
        let mut is_duplicate = duplicate.iter();
        file_triangle.retain(|_| !is_duplicate.next().copied().unwrap_or(false));
    }
}

//! Flattening a disc: Boundary First Flattening (Sawhney and Crane, 2017) with the boundary neither stretched nor shrunk.
//!
//! A conformal map changes lengths by a factor `exp(u)`, and to end flat, `u` must solve a Poisson equation with the
//! curvature on its right side. Of all of them the one with `u = 0` on the boundary has the least spread of `exp(u)`
//! (Chebyshev's principle for maps, proved by Grave). Its solution gives the curvature of the flat boundary, which gives a closed curve in
//! the plane, and the interior follows by harmonic extension. One factorisation serves both.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, Par, Side};
use glam::{DMat2, DVec2};
use std::f64::consts::{PI, TAU};

use super::metric::Metric;
use super::patch::Patch;
use crate::mesh::edges::next;
use crate::mesh::surface::NONE;
use crate::portable::{self, exp};

/// Patches with fewer inner vertices are factored at once; for larger ones the scaling is estimated first.
const WORTH_A_LOOK: usize = 300;

/// Rounds of the rough solver at the most.
const ROUGH_ROUNDS: usize = 400;

/// The position of each vertex of a disc in the plane. `None` if the numerics fail, or if `hopeful` rejects the estimated growth of
/// areas, one factor per triangle.
pub(super) fn flatten(
    patch: &Patch,
    metric: &Metric,
    hopeful: impl Fn(&[f64]) -> bool,
) -> Option<Vec<DVec2>> {
    let laplacian = Laplacian::new(patch, metric);
    let mut bend = vec![0.0; patch.vertex_count];
    for (i, corners) in patch.corners.iter().enumerate() {
        let shape = patch.shape(metric, i);
        for (&vertex, angle) in corners.iter().zip(shape.angles) {
            bend[vertex as usize] -= angle;
        }
    }
    // Angle defects of inner vertices; the border's are handled later.
    let inner = laplacian.inner.iter();
    let defects: Vec<f64> = inner.map(|&v| -(bend[v as usize] + TAU)).collect();
    if defects.len() >= WORTH_A_LOOK {
        let about = laplacian.solve_roughly(&defects);
        let mut u = vec![0.0; patch.vertex_count];
        for (&vertex, value) in laplacian.inner.iter().zip(about) {
            u[vertex as usize] = value;
        }
        let growth = |corners: &[u32; 3]| {
            let sum: f64 = corners.iter().map(|&v| u[v as usize]).sum();
            exp(2.0 / 3.0 * sum)
        };
        let growths: Vec<f64> = patch.corners.iter().map(growth).collect();
        if !hopeful(&growths) {
            return None;
        }
    }
    let factor = laplacian.factor()?;
    if let Some(factor) = &factor {
        let mut u = Mat::from_fn(defects.len(), 1, |i, _| defects[i]);
        factor.solve_in_place(&mut u);
        for &(border, inner, weight) in &laplacian.across {
            bend[border as usize] -= weight * u[(inner as usize, 0)];
        }
    }
    let mut positions = vec![DVec2::ZERO; patch.vertex_count];
    border_curve(patch, metric, &bend, &mut positions)?;
    if let Some(factor) = &factor {
        let mut inside = Mat::<f64>::zeros(laplacian.inner.len(), 2);
        for &(border, inner, weight) in &laplacian.across {
            let at = positions[border as usize];
            inside[(inner as usize, 0)] += weight * at.x;
            inside[(inner as usize, 1)] += weight * at.y;
        }
        factor.solve_in_place(&mut inside);
        for (i, &vertex) in laplacian.inner.iter().enumerate() {
            positions[vertex as usize] = DVec2::new(inside[(i, 0)], inside[(i, 1)]);
        }
    }
    Some(positions)
}

/// The border as a closed curve in the plane, from its lengths and its turning angle at each vertex.
fn border_curve(
    patch: &Patch,
    metric: &Metric,
    bend: &[f64],
    positions: &mut [DVec2],
) -> Option<()> {
    let mut direction = 0.0_f64;
    let steps: Vec<(f64, DVec2)> = patch
        .border
        .iter()
        .map(|&h| {
            direction += PI + bend[patch.vertex_of(h) as usize];
            let shape = patch.shape(metric, h as usize / 3);
            (
                shape.lengths[h as usize % 3],
                portable::direction(direction),
            )
        })
        .collect();
    // Least change of lengths, relative to themselves, that closes the curve.
    let mut gap = DVec2::ZERO;
    let mut normal = DMat2::ZERO;
    for &(length, along) in &steps {
        gap += length * along;
        normal += DMat2::from_cols(along * along.x, along * along.y) * length;
    }
    let pull = normal.inverse() * gap;
    let mut at = DVec2::ZERO;
    for (&h, (length, along)) in patch.border.iter().zip(steps) {
        positions[patch.vertex_of(h) as usize] = at;
        let length = length * (1.0 - along.dot(pull));
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        at += length * along;
    }
    Some(())
}

/// The cotangent Laplacian of the inner vertices, and their weights with border vertices.
struct Laplacian {
    /// The vertex of each row.
    inner: Vec<u32>,
    /// Lower triangle by columns.
    column_starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
    /// Border vertex, row of an inner one, weight.
    across: Vec<(u32, u32, f64)>,
}

impl Laplacian {
    fn new(patch: &Patch, metric: &Metric) -> Self {
        let mut row_of = vec![0; patch.vertex_count];
        for &h in &patch.border {
            row_of[patch.vertex_of(h) as usize] = NONE;
        }
        let mut inner = Vec::new();
        for (vertex, row) in row_of.iter_mut().enumerate() {
            if *row != NONE {
                *row = inner.len() as u32;
                inner.push(vertex as u32);
            }
        }
        let n = inner.len();
        let mut diagonal = vec![0.0; n];
        let mut across = Vec::new();
        let mut entries = Vec::new();
        for (h, &twin) in patch.twins.iter().enumerate() {
            // Border edges join two border vertices, which have no rows.
            if twin == NONE || (twin as usize) < h {
                continue;
            }
            let weight = |h: u32| patch.shape(metric, h as usize / 3).weights[h as usize % 3];
            let h = h as u32;
            let w = weight(h) + weight(twin);
            let ends = [h, next(h)].map(|h| patch.vertex_of(h));
            let rows = ends.map(|vertex| row_of[vertex as usize]);
            for k in 0..2 {
                if rows[k] != NONE {
                    diagonal[rows[k] as usize] += w;
                    if rows[1 - k] == NONE {
                        across.push((ends[1 - k], rows[k], w));
                    }
                }
            }
            if rows[0] != NONE && rows[1] != NONE {
                entries.push((rows[0].min(rows[1]), rows[0].max(rows[1]), -w));
            }
        }
        let (column_starts, rows, values) = columns(&diagonal, &entries);
        Self {
            inner,
            column_starts,
            rows,
            values,
            across,
        }
    }

    /// A few digits of the solution, by conjugate gradients, preconditioned by the diagonal.
    fn solve_roughly(&self, right: &[f64]) -> Vec<f64> {
        let n = right.len();
        let scale: Vec<f64> = (0..n)
            .map(|i| 1.0 / self.values[self.column_starts[i]])
            .collect();
        let mut solution = vec![0.0; n];
        let mut rest = right.to_vec();
        let mut along: Vec<f64> = rest.iter().zip(&scale).map(|(r, s)| r * s).collect();
        let mut image = vec![0.0; n];
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut size = dot(&rest, &along);
        let (mut energy, mut of_late) = (0.0, 0.0);
        for round in 1..=ROUGH_ROUNDS {
            self.multiply(&along, &mut image);
            let step = size / dot(&along, &image);
            if !step.is_finite() {
                break;
            }
            for i in 0..n {
                solution[i] += step * along[i];
                rest[i] -= step * image[i];
            }
            // The progress of the solution, in the norm of the matrix.
            energy += step * size;
            of_late += step * size;
            if round % 10 == 0 {
                if of_late < 1e-3 * energy {
                    break;
                }
                of_late = 0.0;
            }
            let new_size: f64 = (0..n).map(|i| rest[i] * rest[i] * scale[i]).sum();
            let keep = new_size / size;
            size = new_size;
            for i in 0..n {
                along[i] = rest[i] * scale[i] + keep * along[i];
            }
        }
        solution
    }

    fn multiply(&self, vector: &[f64], product: &mut [f64]) {
        product.fill(0.0);
        for (column, range) in self.column_starts.windows(2).enumerate() {
            let value = vector[column];
            let mut sum = self.values[range[0]] * value;
            for k in range[0] + 1..range[1] {
                let (row, weight) = (self.rows[k], self.values[k]);
                sum += weight * vector[row];
                product[row] += weight * value;
            }
            product[column] += sum;
        }
    }

    /// `Some(None)` if there are no inner vertices; `None` if the matrix cannot be factored.
    fn factor(&self) -> Option<Option<Factor>> {
        let n = self.inner.len();
        if n == 0 {
            return Some(None);
        }
        if !self.values.iter().all(|value| value.is_finite()) {
            return None;
        }
        let symbolic =
            SymbolicSparseColMatRef::new_checked(n, n, &self.column_starts, None, &self.rows);
        let matrix = SparseColMatRef::new(symbolic, &self.values);
        Some(Some(Factor::of(matrix)?))
    }
}

/// A matrix as `L L^T`, column by column.
///
/// Blocks of columns would be faster for large matrices, but the crate multiplies them with the widest instructions of the processor, and
/// sums in another order have other bits. With one column at a time it adds in the order of the columns.
struct Factor {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl Factor {
    /// `None` if the matrix is not positive definite.
    fn of(lower: SparseColMatRef<'_, usize, f64>) -> Option<Self> {
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..Default::default()
        };
        let order = SymmetricOrdering::Amd;
        let symbolic =
            factorize_symbolic_cholesky(lower.symbolic(), Side::Lower, order, params).ok()?;
        let mut values = vec![0.0; symbolic.len_val()];
        let room = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        symbolic
            .factorize_numeric_llt(
                &mut values,
                lower,
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut MemBuffer::new(room)),
                Default::default(),
            )
            .ok()?;
        Some(Self { symbolic, values })
    }

    fn solve_in_place(&self, right: &mut Mat<f64>) {
        let room = self
            .symbolic
            .solve_in_place_scratch::<f64>(right.ncols(), Par::Seq);
        LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            right.as_mut(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(room)),
        );
    }
}

/// Compressed columns of a lower triangle from its diagonal and entries (column, row, value), which may contain the same place more than
/// once.
fn columns(diagonal: &[f64], entries: &[(u32, u32, f64)]) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
    let n = diagonal.len();
    let mut ends = vec![0; n + 1];
    for &(column, ..) in entries {
        ends[column as usize + 1] += 1;
    }
    for column in 0..n {
        ends[column + 1] += ends[column];
    }
    let mut sorted = vec![(0, 0.0); entries.len()];
    let mut at = ends.clone();
    for &(column, row, value) in entries {
        sorted[at[column as usize]] = (row, value);
        at[column as usize] += 1;
    }
    let mut starts = vec![0];
    let (mut rows, mut values) = (Vec::new(), Vec::new());
    for column in 0..n {
        rows.push(column);
        values.push(diagonal[column]);
        let of_column = &mut sorted[ends[column]..ends[column + 1]];
        of_column.sort_by_key(|&(row, _)| row);
        for &(row, value) in &*of_column {
            if rows.last() == Some(&(row as usize)) {
                *values.last_mut().expect("rows and values are as long") += value;
            } else {
                rows.push(row as usize);
                values.push(value);
            }
        }
        starts.push(rows.len());
    }
    (starts, rows, values)
}

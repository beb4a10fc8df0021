//! A flattened chart while it is packed: its border, its orientations, and the cells that it takes.

use glam::{DVec2, IVec2};

use super::super::surface::{NONE, Surface};
use super::fixed::{Fixed, only_texel};
use super::flat::FlatChart;
use super::outline::{Cells, Filled, Mask, fill};

/// A chart to be packed.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub flat: FlatChart,
    /// Its border's edges: triangle (by its place in `flat`) and corner, loop by loop, each counter-clockwise.
    pub border: Vec<[u32; 2]>,
    /// Per border edge: the loop that it is in.
    pub loops: Vec<u32>,
    /// Cosine and sine of the rotation after which its box has the least area.
    pub upright: DVec2,
    /// The sides of that box, weighted.
    pub extent: DVec2,
    /// Texels per world unit, relative to the other charts.
    pub weight: f64,
}

impl Piece {
    pub(super) fn new(surface: &Surface, flat: FlatChart, weight: f64) -> Self {
        let (border, loops) = border(surface, &flat);
        let mut piece = Self {
            flat,
            border,
            loops,
            upright: DVec2::X,
            extent: DVec2::ZERO,
            weight,
        };
        piece.turn_to(upright(&piece.border_points()));
        piece
    }

    /// Sets the upright orientation.
    pub(super) fn turn_to(&mut self, turn: DVec2) {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in self.border_points() {
            let turned = turn.rotate(point);
            low = low.min(turned);
            high = high.max(turned);
        }
        self.upright = turn;
        self.extent = (high - low) * self.weight;
    }

    fn border_points(&self) -> Vec<DVec2> {
        self.border
            .iter()
            .map(|&[triangle, corner]| self.flat.corners[triangle as usize][corner as usize])
            .collect()
    }

    /// The sum of its triangles' areas as they are flattened, weighted.
    pub(super) fn area(&self) -> f64 {
        let twice: f64 = self
            .flat
            .corners
            .iter()
            .map(|[a, b, c]| (b - a).perp_dot(c - a).abs())
            .sum();
        0.5 * twice * self.weight * self.weight
    }

    /// Area of the box along the axes, when the piece is upright.
    pub(super) fn box_area(&self) -> f64 {
        self.extent.x * self.extent.y
    }

    /// Is it far longer than wide, so that a slanted orientation would waste space?
    pub(super) fn is_needle(&self) -> bool {
        self.extent.min_element() < 0.2 * self.extent.max_element()
    }

    /// Orientations to try, the most promising first.
    pub(super) fn turns(&self) -> [DVec2; 8] {
        let upright = self.upright;
        let slanted = upright.rotate(DVec2::splat(std::f64::consts::FRAC_1_SQRT_2));
        [
            upright,
            -upright,
            upright.perp(),
            -upright.perp(),
            slanted,
            -slanted,
            slanted.perp(),
            -slanted.perp(),
        ]
    }

    /// Whether a triangle has the wrong orientation.
    pub(super) fn is_folded(&self) -> bool {
        let mut corners = self.flat.corners.iter();
        corners.any(|[a, b, c]| (b - a).perp_dot(c - a) < 0.0)
    }

    /// Its border in units when it is turned and scaled.
    pub(super) fn edges(&self, fixed: Fixed, turn: DVec2, scale: f64) -> Vec<[IVec2; 2]> {
        let snap = Snap::new(fixed, turn, scale * self.weight);
        self.border
            .iter()
            .map(|&[triangle, corner]| {
                let corners = &self.flat.corners[triangle as usize];
                let end = (corner as usize + 1) % 3;
                [corners[corner as usize], corners[end]].map(|p| snap.place(p))
            })
            .collect()
    }

    /// All its triangles' corners in units, moved by so much.
    pub(super) fn corners(
        &self,
        fixed: Fixed,
        turn: DVec2,
        scale: f64,
        shift: IVec2,
    ) -> impl Iterator<Item = (u32, [IVec2; 3])> + '_ {
        let snap = Snap::new(fixed, turn, scale * self.weight);
        let triangles = self.flat.triangles.iter().copied();
        triangles.zip(&self.flat.corners).map(move |(t, corners)| {
            let corners = corners.map(|p| snap.place(p) + shift);
            (t, corners)
        })
    }

    /// The cells that it takes, `side` texels each (an odd number), when it is turned and scaled.
    pub(super) fn footprint(&self, fixed: Fixed, turn: DVec2, scale: f64, side: i32) -> Footprint {
        let mut edges = self.edges(fixed, turn, scale);
        let low = edges
            .iter()
            .fold(IVec2::MAX, |low, edge| low.min(edge[0]).min(edge[1]));
        // As far down and left as possible such that the first texels' centres are still within reach.
        let start = fixed.reach - fixed.texel / 2 + 1;
        let mut shift = start - low;
        move_by(&mut edges, shift);
        let texels = Cells {
            side: fixed.texel,
            reach: fixed.reach,
        };
        let cells = Cells {
            side: side * fixed.texel,
            reach: fixed.reach + (side - 1) / 2 * fixed.texel,
        };
        let mut filled = fill(&edges, cells);
        // Cells of an odd number of texels have a texel's centre in their centre.
        if filled.inside == 0 && (side == 1 || fill(&edges, texels).inside == 0) {
            // The one texel that it owns takes its gutter, too.
            let gutter = fixed.gutter.min(1 << 15) as i32;
            let (_, texel) = only_texel(fixed, self.corners(fixed, turn, scale, shift));
            let more = (gutter - texel).max(IVec2::ZERO);
            if more != IVec2::ZERO {
                shift += more * fixed.texel;
                move_by(&mut edges, more * fixed.texel);
                filled = fill(&edges, cells);
            }
            filled.mask = with_square(
                &filled.mask,
                texel + more - gutter,
                texel + more + gutter,
                side,
            );
        }
        Footprint {
            filled,
            edges,
            shift,
        }
    }
}

/// The texels of a chart, and its translation.
pub(super) struct Footprint {
    pub filled: Filled,
    /// The border, moved.
    pub edges: Vec<[IVec2; 2]>,
    pub shift: IVec2,
}

/// Turns, scales and rounds to the grid.
#[derive(Clone, Copy)]
struct Snap {
    turn: DVec2,
}

impl Snap {
    fn new(fixed: Fixed, turn: DVec2, scale: f64) -> Self {
        Self {
            turn: turn * scale * f64::from(fixed.texel),
        }
    }

    fn place(self, position: DVec2) -> IVec2 {
        self.turn.rotate(position).round().as_ivec2()
    }
}

fn move_by(edges: &mut [[IVec2; 2]], shift: IVec2) {
    for edge in edges {
        *edge = edge.map(|place| place + shift);
    }
}

/// A mask with the cells of a square of texels, both ends included.
fn with_square(mask: &Mask, low: IVec2, high: IVec2, side: i32) -> Mask {
    let (low, high) = (low / side, high / side + 1);
    let mut larger = Mask::new(
        mask.width.max(high.x as usize),
        mask.height.max(high.y as usize),
    );
    for y in 0..mask.height {
        for (from, to) in mask.runs(y) {
            larger.take(y, from, to);
        }
    }
    for y in low.y..high.y {
        larger.take(y as usize, low.x as usize, high.x as usize);
    }
    larger
}

/// The border of a chart, edges in the order along it.
fn border(surface: &Surface, flat: &FlatChart) -> (Vec<[u32; 2]>, Vec<u32>) {
    // The twin of an edge, if it is in the chart.
    let across = |[triangle, corner]: [u32; 2]| {
        let h = 3 * flat.triangles[triangle as usize] + corner;
        let twin = surface.halfedges[h as usize].twin;
        if twin == NONE {
            return None;
        }
        let found = flat.triangles.binary_search(&(twin / 3)).ok()?;
        Some([found as u32, twin % 3])
    };
    let count = flat.triangles.len();
    let mut is_border = vec![false; 3 * count];
    for triangle in 0..count as u32 {
        for corner in 0..3 {
            is_border[(3 * triangle + corner) as usize] = across([triangle, corner]).is_none();
        }
    }
    let mut seen = vec![false; 3 * count];
    let (mut edges, mut loops) = (Vec::new(), Vec::new());
    let mut loop_count = 0;
    for first in 0..3 * count {
        if !is_border[first] || seen[first] {
            continue;
        }
        let mut edge = first;
        while !seen[edge] {
            seen[edge] = true;
            let [triangle, corner] = [edge as u32 / 3, edge as u32 % 3];
            edges.push([triangle, corner]);
            loops.push(loop_count);
            // Goes around the edge's end until there is a border edge again.
            let mut next = [triangle, (corner + 1) % 3];
            while let Some([triangle, corner]) = across(next) {
                next = [triangle, (corner + 1) % 3];
            }
            edge = (3 * next[0] + next[1]) as usize;
        }
        loop_count += 1;
    }
    (edges, loops)
}

/// The turn after which the box along the axes has the least area, the longer side level: one side of it lies on an edge of
/// the convex hull (Freeman and Shapira 1975).
fn upright(points: &[DVec2]) -> DVec2 {
    let hull = convex_hull(points);
    let mut best = (f64::INFINITY, DVec2::X);
    for k in 0..hull.len() {
        let Some(along) = (hull[(k + 1) % hull.len()] - hull[k]).try_normalize() else {
            continue;
        };
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for &point in &hull {
            let turned = DVec2::new(along.dot(point), along.perp_dot(point));
            low = low.min(turned);
            high = high.max(turned);
        }
        let size = high - low;
        // The inverse rotation of the edge's angle, and a quarter turn more if the longer side would be vertical.
        let back = DVec2::new(along.x, -along.y);
        let turn = if size.x >= size.y { back } else { back.perp() };
        if size.x * size.y < best.0 * (1.0 - 1e-9) {
            best = (size.x * size.y, turn);
        }
    }
    best.1
}

/// Counter-clockwise, by Andrew's monotone chain (1979).
fn convex_hull(points: &[DVec2]) -> Vec<DVec2> {
    let mut sorted = points.to_vec();
    sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    let mut hull: Vec<DVec2> = Vec::new();
    let chain = |hull: &mut Vec<DVec2>, points: &mut dyn Iterator<Item = &DVec2>| {
        let start = hull.len();
        for &point in points {
            while let [.., a, b] = hull[start..] {
                if (b - a).perp_dot(point - a) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
    };
    chain(&mut hull, &mut sorted.iter());
    chain(&mut hull, &mut sorted.iter().rev());
    hull
}

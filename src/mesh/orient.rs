//! Makes neighbouring triangles wind the same way, and closed parts face outwards.

use std::collections::VecDeque;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::MeshReport;
use super::edges::{EdgeGroups, ends};
use super::surface::NONE;
use crate::portable::atan2;

/// Flips triangles until neighbours agree, and returns which were flipped: their corners 1 and 2 are swapped.
///
/// Triangles that share an edge with no third one are oriented first, breadth first from the lowest number, so that a surface that cannot
/// be oriented (a Moebius band) is cut along a short line. Then the components that meet at edges of three or more triangles are
/// oriented, so that the first half-edge there gets a twin. In each component the majority keeps its winding, unless the component is
/// closed: then it is made to face outwards, or into the cavity whose wall it is ([`is_outwards`]).
pub(crate) fn orient(
    positions: &[Vec3],
    corners: &mut [[u32; 3]],
    groups: &mut EdgeGroups,
    report: &mut MeshReport,
) -> Vec<bool> {
    let (mut flipped, part_of, part_count) = flood(corners, groups);
    let mut components = Components::new(part_count);
    for group in groups.iter().filter(|group| group.len() > 2) {
        join_at_shared_edge(corners, group, &flipped, &part_of, &mut components);
    }
    let mut component_of = Vec::with_capacity(corners.len());
    for (part, flipped) in part_of.iter().zip(&mut flipped) {
        let (component, turned) = components.find(*part);
        component_of.push(component);
        *flipped ^= turned;
    }
    keep_majority(&component_of, &mut flipped, part_count);
    apply(corners, &flipped);
    groups.flip(&flipped);
    report.mended_triangles = flipped.iter().filter(|&&flipped| flipped).count();

    let twins = groups.twins(corners);
    report.cut_edges = groups
        .iter()
        .filter(|group| group.len() == 2 && twins[group[0].1 as usize] == NONE)
        .count();

    let inside_out = inside_out_components(positions, corners, &twins, &component_of, part_count);
    report.turned_parts = inside_out.iter().filter(|&&turned| turned).count();
    if report.turned_parts > 0 {
        let turned: Vec<bool> = component_of
            .iter()
            .map(|&component| inside_out[component as usize])
            .collect();
        apply(corners, &turned);
        groups.flip(&turned);
        for (flipped, turned) in flipped.iter_mut().zip(turned) {
            *flipped ^= turned;
        }
    }
    flipped
}

/// Spreads winding over edges of exactly two triangles; returns the triangles to flip, the part of each triangle, and the number of parts.
fn flood(corners: &[[u32; 3]], groups: &EdgeGroups) -> (Vec<bool>, Vec<u32>, usize) {
    let mut across = vec![NONE; 3 * corners.len()];
    for group in groups.iter() {
        if let &[(_, one), (_, other)] = group {
            across[one as usize] = other;
            across[other as usize] = one;
        }
    }
    let mut flipped = vec![false; corners.len()];
    let mut part_of = vec![NONE; corners.len()];
    let mut parts = 0;
    let mut queue = VecDeque::new();
    for first in 0..corners.len() {
        if part_of[first] != NONE {
            continue;
        }
        part_of[first] = parts;
        queue.push_back(first as u32);
        while let Some(triangle) = queue.pop_front() {
            for halfedge in 3 * triangle..3 * triangle + 3 {
                let other = across[halfedge as usize];
                if other == NONE || part_of[other as usize / 3] != NONE {
                    continue;
                }
                let same_way = ends(corners, halfedge).0 == ends(corners, other).0;
                part_of[other as usize / 3] = parts;
                flipped[other as usize / 3] = flipped[triangle as usize] ^ same_way;
                queue.push_back(other / 3);
            }
        }
        parts += 1;
    }
    (flipped, part_of, parts as usize)
}

/// Finds the first half-edge that can be the twin of the edge's first one, and joins their parts accordingly.
fn join_at_shared_edge(
    corners: &[[u32; 3]],
    group: &[(u64, u32)],
    flipped: &[bool],
    part_of: &[u32],
    components: &mut Components,
) {
    let (_, first) = group[0];
    for &(_, second) in &group[1..] {
        let [one, other] = [first, second].map(|h| h as usize / 3);
        let same_way = ends(corners, first).0 == ends(corners, second).0;
        let differ = same_way ^ flipped[one] ^ flipped[other];
        if components.join(part_of[one], part_of[other], differ) {
            return;
        }
    }
}

/// Inverts the flips of every component in which more triangles would be flipped than not.
fn keep_majority(component_of: &[u32], flipped: &mut [bool], component_count: usize) {
    let mut balance = vec![0_i64; component_count];
    for (&component, &flipped) in component_of.iter().zip(flipped.iter()) {
        balance[component as usize] += if flipped { 1 } else { -1 };
    }
    for (&component, flipped) in component_of.iter().zip(flipped.iter_mut()) {
        *flipped ^= balance[component as usize] > 0;
    }
}

fn apply(corners: &mut [[u32; 3]], flipped: &[bool]) {
    for (corners, &flipped) in corners.iter_mut().zip(flipped) {
        if flipped {
            corners.swap(1, 2);
        }
    }
}

/// Which closed components are to be turned, so that each one faces outwards, or into the cavity whose wall it is.
fn inside_out_components(
    positions: &[Vec3],
    corners: &[[u32; 3]],
    twins: &[u32],
    component_of: &[u32],
    component_count: usize,
) -> Vec<bool> {
    let mut components = vec![Component::default(); component_count];
    for (triangle, &component) in component_of.iter().enumerate() {
        let component = &mut components[component as usize];
        let points = corners[triangle].map(|vertex| positions[vertex as usize].as_dvec3());
        let halfedges = &twins[3 * triangle..3 * triangle + 3];
        component.add(points, halfedges.contains(&NONE));
    }
    let mut turned = vec![false; component_count];
    if !components.iter().any(Component::is_inside_out) {
        return turned;
    }
    let mut triangles_of = vec![Vec::new(); component_count];
    for (triangle, &component) in component_of.iter().enumerate() {
        triangles_of[component as usize].push(triangle);
    }
    // All others stay: what faces outwards in the file, and has only such shells.
    let inwards: Vec<&Component> = (components.iter())
        .filter(|component| component.is_inside_out())
        .collect();
    let may_turn = |&index: &usize| {
        let component = &components[index];
        let is_in = |shell: &&Component| shell.could_contain(component);
        component.is_closed() && (component.is_inside_out() || inwards.iter().any(is_in))
    };
    let mut order: Vec<usize> = (0..component_count).filter(may_turn).collect();
    // From the outermost in, so that what is round a component has been seen.
    let size = |index: usize| components[index].volume.abs();
    order.sort_by(|&a, &b| size(b).total_cmp(&size(a)));
    let shell_next_round = |&index: &usize| {
        let component = &components[index];
        let is_round = |&other: &usize| {
            let triangles = &triangles_of[other];
            components[other].could_contain(component)
                && winding_number(positions, corners, triangles, component.origin).abs() > 0.5
        };
        let shells = (0..component_count).filter(is_round);
        shells.min_by(|&a, &b| size(a).total_cmp(&size(b)))
    };
    let shells: Vec<Option<usize>> = order.par_iter().map(shell_next_round).collect();
    let came_inwards = |index: usize| components[index].is_inside_out();
    for (&index, shell) in order.iter().zip(shells) {
        let shell = shell.map(|shell| (came_inwards(shell), turned[shell]));
        let came = came_inwards(index);
        turned[index] = is_outwards(came, shell) == came;
    }
    turned
}

/// Is a closed component to face outwards? For it and for the shell next round it, if there is one, it is known whether they face inwards
/// in the file; for the shell, whether it is turned. What is in a cavity is a solid. What is in a solid is another solid if both face alike
/// in the file, and the wall of a cavity otherwise. So a file that is inside out as a whole ends as the one that is not.
fn is_outwards(came_inwards: bool, shell: Option<(bool, bool)>) -> bool {
    match shell {
        Some((shell_came_inwards, is_turned)) if shell_came_inwards == is_turned => {
            came_inwards == shell_came_inwards
        }
        _ => true,
    }
}

/// How often some triangles wind around a point: the sum of the solid angles that they cover, over 4 pi
/// (van Oosterom and Strackee 1983).
fn winding_number(
    positions: &[Vec3],
    corners: &[[u32; 3]],
    triangles: &[usize],
    point: DVec3,
) -> f64 {
    let half_angles = triangles.iter().map(|&triangle| {
        let [a, b, c] =
            corners[triangle].map(|vertex| positions[vertex as usize].as_dvec3() - point);
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let over = a.dot(b.cross(c));
        let under = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        atan2(over, under)
    });
    half_angles.sum::<f64>() / (2.0 * std::f64::consts::PI)
}

/// Volume and box of one component.
#[derive(Clone)]
struct Component {
    /// Its first corner, which volumes are measured from.
    origin: DVec3,
    volume: f64,
    low: DVec3,
    high: DVec3,
    triangles: usize,
    open: bool,
}

impl Default for Component {
    fn default() -> Self {
        Self {
            origin: DVec3::ZERO,
            volume: 0.0,
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
            triangles: 0,
            open: false,
        }
    }
}

impl Component {
    fn add(&mut self, points: [DVec3; 3], open: bool) {
        if self.triangles == 0 {
            self.origin = points[0];
        }
        let [a, b, c] = points.map(|point| point - self.origin);
        self.volume += a.dot(b.cross(c)) / 6.0;
        for point in points {
            self.low = self.low.min(point);
            self.high = self.high.max(point);
        }
        self.triangles += 1;
        self.open |= open;
    }

    fn is_closed(&self) -> bool {
        self.triangles > 0 && !self.open
    }

    fn is_inside_out(&self) -> bool {
        self.is_closed() && self.volume < 0.0
    }

    fn could_contain(&self, other: &Self) -> bool {
        self.is_closed() && self.low.cmplt(other.low).all() && self.high.cmpgt(other.high).all()
    }
}

/// Parts that are joined into components, each remembering whether it is turned against its component (union-find with parity).
struct Components {
    parent: Vec<(u32, bool)>,
}

impl Components {
    fn new(parts: usize) -> Self {
        Self {
            parent: (0..parts as u32).map(|part| (part, false)).collect(),
        }
    }

    /// The component of a part, and whether the part is turned against it.
    fn find(&mut self, part: u32) -> (u32, bool) {
        let mut root = part;
        let mut turned = false;
        while self.parent[root as usize].0 != root {
            turned ^= self.parent[root as usize].1;
            root = self.parent[root as usize].0;
        }
        // Point everything on the way straight at the root.
        let mut at = part;
        let mut rest = turned;
        while at != root {
            let (next, step) = self.parent[at as usize];
            self.parent[at as usize] = (root, rest);
            rest ^= step;
            at = next;
        }
        (root, turned)
    }

    /// Requires that two parts are flipped relative to each other, or not; returns false if that contradicts earlier requirements.
    fn join(&mut self, one: u32, other: u32, differ: bool) -> bool {
        let (root, turned) = self.find(one);
        let (other_root, other_turned) = self.find(other);
        if root == other_root {
            return turned ^ other_turned == differ;
        }
        let (low, high) = (root.min(other_root), root.max(other_root));
        self.parent[high as usize] = (low, turned ^ other_turned ^ differ);
        true
    }
}

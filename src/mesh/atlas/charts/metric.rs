//! Lengths, angles and areas of all triangles, computed once, in double precision.

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::surface::Surface;
use crate::mesh::walk::Frame;
use crate::portable::{angle_between, atan2};

/// The shape of one triangle: corner A is the origin, B is `(ab, 0)`, C is `(cp, ch)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub ab: f64,
    pub cp: f64,
    pub ch: f64,
    /// Length of the edge that starts at each corner.
    pub lengths: [f64; 3],
    /// At each corner.
    pub angles: [f64; 3],
    /// Half the cotangent of the angle opposite the edge that starts at each corner.
    pub weights: [f64; 3],
}

impl Shape {
    pub fn new(ab: f64, cp: f64, ch: f64) -> Self {
        let (bp, double_area) = (cp - ab, ab * ch);
        // The dot products of the two edges at each corner; their cross product is twice the area at all three.
        let dots = [ab * cp, -ab * bp, cp * bp + ch * ch];
        let length = |p: f64| (p * p + ch * ch).sqrt();
        Self {
            ab,
            cp,
            ch,
            lengths: [ab, length(bp), length(cp)],
            angles: dots.map(|dot| atan2(double_area, dot)),
            weights: [dots[2], dots[0], dots[1]].map(|dot| 0.5 * dot / double_area),
        }
    }

    pub fn area(&self) -> f64 {
        0.5 * self.ab * self.ch
    }
}

/// Data of every triangle for cutting and flattening.
pub(super) struct Metric {
    pub shapes: Vec<Shape>,
    pub centroids: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    /// Surface area of everything.
    pub total: f64,
    /// Does a triangle belong to a connected part of few triangles? [`super::flat_charts`] sets this; all are false before.
    pub is_coarse: Vec<bool>,
}

impl Metric {
    pub fn new(surface: &Surface) -> Self {
        let of = |t: usize| {
            let frame = Frame::of(surface, t as u32);
            let corners = surface.corners[t].map(|v| surface.positions[v as usize].as_dvec3());
            (
                Shape::new(frame.ab, frame.cp, frame.ch),
                (corners[0] + corners[1] + corners[2]) / 3.0,
                frame.p.cross(frame.h),
            )
        };
        let all: Vec<_> = (0..surface.corners.len()).into_par_iter().map(of).collect();
        Self {
            shapes: all.iter().map(|all| all.0).collect(),
            centroids: all.iter().map(|all| all.1).collect(),
            normals: all.iter().map(|all| all.2).collect(),
            total: all.iter().map(|all| all.0.area()).sum(),
            is_coarse: vec![false; all.len()],
        }
    }

    /// Surface area of some triangles.
    pub fn area(&self, triangles: &[u32]) -> f64 {
        triangles
            .iter()
            .map(|&t| self.shapes[t as usize].area())
            .sum()
    }

    /// Length of a half-edge.
    pub fn length(&self, halfedge: u32) -> f64 {
        self.shapes[halfedge as usize / 3].lengths[halfedge as usize % 3]
    }

    /// The distance from a triangle's centroid to that of a neighbour, where an angle of one radian between the normals counts like the
    /// length `turn`.
    pub fn step(&self, from: u32, to: u32, turn: f64) -> f64 {
        let (from, to) = (from as usize, to as usize);
        let angle = angle_between(self.normals[from], self.normals[to]);
        let angle = if angle.is_finite() { angle } else { 0.0 };
        self.centroids[from].distance(self.centroids[to]) + turn * angle
    }
}

//! The layout of a flat torus: a square whose opposite sides are glued, alone in the texture.
//!
//! It is one chart, with its sides along those of the texture and a whole number of texels along each: the size that was asked for. The
//! gutter lies round it, so the texture is larger. All owned texels have one area, and across the glued sides each has the neighbours that
//! it would have inside: the trail spreads by the plain stencil everywhere.

use glam::{DVec2, DVec3, IVec2};

use super::super::surface::{NONE, Surface};
use super::fixed::Fixed;
use super::{
    AtlasError, AtlasMethod, AtlasOptions, Control, Layout, MAX_SIZE, owners, surface_area,
};
use crate::mesh::edges::ends;

/// What counts as zero, in sides of the square, for areas and for what sticks out of the plane.
const FLAT: f64 = 1e-6;

/// How far apart the two ends of a glued side may be, in texels: nearer than what a bilinear read would see.
const APART: f64 = 1.0 / 512.0;

/// A square whose opposite sides are glued.
pub(super) struct Torus {
    /// Per vertex, its place in the square: from 0 to 1 along both sides, triangles counter-clockwise.
    places: Vec<DVec2>,
}

impl Torus {
    /// Finds out whether the only object of a surface is such a square, and is to be laid out as one.
    pub(super) fn of(surface: &Surface, options: &AtlasOptions) -> Option<Self> {
        let is_asked_for = options.method == AtlasMethod::Charts && options.turn == 0;
        if !is_asked_for || surface.objects.len() != 1 || surface.glued.is_empty() {
            return None;
        }
        let [low, high] = surface.bounds(0).map(|corner| corner.as_dvec3());
        let size = high - low;
        let side = size.max_element();
        let flat = (0..3).find(|&axis| size[axis] <= FLAT * side)?;
        let mut others = (0..3).filter(|&axis| axis != flat);
        let (along, up) = (others.next()?, others.next()?);
        if (size[along] - size[up]).abs() > FLAT * side {
            return None;
        }
        let in_square = |position: DVec3| {
            let place = (position - low) / side;
            DVec2::new(place[along], place[up])
        };
        let places = surface.positions.iter().map(|p| in_square(p.as_dvec3()));
        let mut torus = Self {
            places: places.collect(),
        };
        let areas = surface.corners.iter().map(|corners| torus.area(corners));
        let (least, most, all) = areas.fold((0.0_f64, 0.0_f64, 0.0), |(least, most, all), area| {
            (least.min(area), most.max(area), all + area)
        });
        if least < 0.0 {
            // Seen from the other side.
            for place in &mut torus.places {
                place.y = 1.0 - place.y;
            }
        }
        let is_covered_once = least.max(-most) >= 0.0 && (f64::abs(all) - 1.0).abs() <= FLAT;
        (is_covered_once && torus.is_glued_side_to_side(surface, options.size)).then_some(torus)
    }

    /// The area of a triangle in the square; negative if it is clockwise.
    fn area(&self, corners: &[u32; 3]) -> f64 {
        let [a, b, c] = corners.map(|vertex| self.places[vertex as usize]);
        0.5 * (b - a).perp_dot(c - a)
    }

    /// Is every border glued to what lies one side away?
    fn is_glued_side_to_side(&self, surface: &Surface, size: u32) -> bool {
        let nearly = APART / f64::from(size);
        let is_one_side = |way: DVec2| {
            let way = way.abs();
            (way - DVec2::X).abs().max_element() <= nearly
                || (way - DVec2::Y).abs().max_element() <= nearly
        };
        let place = |vertex: u32| self.places[vertex as usize];
        let is_border_glued = surface.halfedges.iter().all(|h| h.twin != NONE);
        is_border_glued
            && surface.glued.iter().all(|&h| {
                let (start, end) = ends(&surface.corners, h);
                let (from, to) = ends(&surface.corners, surface.halfedges[h as usize].twin);
                is_one_side(place(start) - place(to)) && is_one_side(place(end) - place(from))
            })
    }

    /// The side of the texture: the texels that were asked for, and the gutter on both sides.
    pub(super) fn side(options: &AtlasOptions) -> Result<u32, AtlasError> {
        let (size, gutter) = (options.size, options.gutter);
        let gutters = gutter.saturating_mul(2);
        match size.checked_add(gutters) {
            Some(side) if side <= MAX_SIZE => Ok(side),
            _ => Err(AtlasError::NoRoomForGutter {
                size,
                gutter,
                most: MAX_SIZE.saturating_sub(gutters),
            }),
        }
    }

    /// Lays it out in a texture of which `options.size` is the [side](Self::side).
    pub(super) fn layout(
        &self,
        surface: &Surface,
        options: &AtlasOptions,
        control: &Control<'_>,
    ) -> Result<Layout, AtlasError> {
        let fixed = Fixed::new(options.size, options.gutter);
        let gutter = options.gutter as i32;
        let texels = options.size as i32 - 2 * gutter;
        let corner = |vertex: u32| {
            let place = self.places[vertex as usize] * f64::from(texels * fixed.texel);
            place.round().as_ivec2() + IVec2::splat(gutter * fixed.texel)
        };
        let maps = surface
            .corners
            .iter()
            .map(|corners| fixed.map_of(corners.map(corner)))
            .collect();
        let chart = vec![0; surface.corners.len()];
        let mut layout = owners::derive(surface, maps, chart, 1, options, control)?;
        // Summed up from parts of triangles, areas differ by rounding.
        let owned = f64::from(texels) * f64::from(texels);
        let area = (surface_area(surface) / owned) as f32;
        for (of_texel, &owner) in layout.area.iter_mut().zip(&layout.owner) {
            *of_texel = if owner == NONE { 0.0 } else { area };
        }
        Ok(layout)
    }
}

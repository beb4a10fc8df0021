//! Toothed wheels, as built-in meshes: involute teeth, which roll on each other and touch on both flanks.
//!
//! Two wheels mesh when their pitch circles touch and `radius / teeth` is the same for both. Tooth 0 points along +X; the
//! axis is Y.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::Mesh;
use super::primitive::Builder;
use crate::portable::{acos, cos, direction, tan};

/// Columns of quads across a tooth, and across the gap between two.
const TOOTH_COLUMNS: usize = 4;
const GAP_COLUMNS: usize = 3;
/// Columns across a tooth and a gap together.
const COLUMNS: usize = TOOTH_COLUMNS + GAP_COLUMNS;
/// Quads from a tooth's foot to its tip.
const LEVELS: usize = 5;

/// The shape of a toothed wheel; lengths are in the mesh's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gear {
    /// How many there are.
    pub teeth: u32,
    /// Radius of the pitch circle, on which wheels roll.
    pub radius: f64,
    /// Along the axis.
    pub thickness: f64,
    /// Radius of the hole; for a ring, how far its rim reaches beyond the feet of its teeth.
    pub bore: f64,
    /// How much thinner teeth are than the gaps that they go into, as a share of the pitch.
    pub play: f64,
    /// Do the teeth point inwards?
    pub is_ring: bool,
}

/// Width of the chamfers, in modules.
const CHAMFER: f64 = 0.14;
/// The pressure angle, between the line of contact and the tangent of the pitch circles.
const PRESSURE_ANGLE: f64 = 22.5 * PI / 180.0;

impl Gear {
    /// A tooth's height above the pitch circle, and a little less than its depth below.
    fn module(&self) -> f64 {
        2.0 * self.radius / f64::from(self.teeth)
    }

    fn pitch(&self) -> f64 {
        TAU / f64::from(self.teeth)
    }

    /// Half the angle that a tooth that points outwards takes at a distance from the axis.
    fn half_angle_outwards(&self, distance: f64) -> f64 {
        let involute = |angle: f64| tan(angle) - angle;
        let base = self.radius * cos(PRESSURE_ANGLE);
        let at = acos(base / distance.max(base));
        0.25 * self.pitch() + involute(PRESSURE_ANGLE) - involute(at)
    }

    fn half_angle(&self, distance: f64) -> f64 {
        let outwards = self.half_angle_outwards(distance);
        let exact = if self.is_ring {
            0.5 * self.pitch() - outwards
        } else {
            outwards
        };
        exact - 0.5 * self.play * self.pitch()
    }

    /// Can it be built?
    ///
    /// # Errors
    /// The conflicting parameters, and what to change.
    pub fn check(&self) -> Result<(), String> {
        let foot = self.radius - 1.25 * self.module();
        if !self.is_ring && self.bore > 0.98 * foot {
            let Self { bore, .. } = self;
            return Err(format!(
                "`bore={bore}` leaves nothing between its hole and its teeth: take less than {:.3}",
                0.98 * foot
            ));
        }
        let least = 4.0 * CHAMFER * self.module();
        if self.thickness < least {
            let Self { thickness, .. } = self;
            return Err(format!(
                "`thickness={thickness}` is thinner than its teeth's rounded edges: take {least:.3} at least, or more teeth"
            ));
        }
        Ok(())
    }

    /// From a tooth's foot to its tip: distance from the axis and half the angle.
    fn levels(&self) -> Vec<[f64; 2]> {
        let module = self.module();
        let (foot, tip) = if self.is_ring {
            // Inside the base circle there is no involute to touch.
            let base = self.radius * cos(PRESSURE_ANGLE);
            (
                self.radius + 1.25 * module,
                (self.radius - module).max(1.002 * base),
            )
        } else {
            (self.radius - 1.25 * module, self.radius + module)
        };
        let levels = (0..=LEVELS).map(|level| {
            let share = level as f64 / LEVELS as f64;
            let distance = foot + share * (tip - foot);
            let square = (1.0 - share) * (1.0 - share);
            // The foot spreads, so that no crease is sharper than it must be.
            let spread = 0.06 * self.pitch() * square * square;
            [
                distance,
                (self.half_angle(distance) + spread).max(0.02 * self.pitch()),
            ]
        });
        levels.collect()
    }

    /// How many points a ring of the body has.
    fn points_around(&self) -> usize {
        self.teeth as usize * COLUMNS
    }

    /// The index of point `i` of a ring of the body.
    fn body_point(&self, ring: usize, i: usize) -> usize {
        let around = self.points_around();
        ring * around + i % around
    }
}

/// The mesh of a toothed wheel.
#[must_use]
pub fn gear(gear: &Gear) -> Mesh {
    let levels = gear.levels();
    let foot = levels[0][0];
    let body_end = if gear.is_ring {
        foot + gear.bore
    } else {
        gear.bore
    };
    let column_width = gear.pitch() * 0.5 * (foot + body_end) / COLUMNS as f64;
    let rings = ((foot - body_end).abs() / column_width)
        .round()
        .clamp(1.0, 64.0) as usize;

    let mut flat = Flat::default();
    flat.add_body(gear, levels[0], body_end, rings);
    for tooth in 0..gear.teeth as usize {
        flat.add_tooth(gear, &levels, rings, tooth);
    }
    // The body's first ring.
    let end: Vec<usize> = (0..gear.points_around()).collect();
    let chamfer = CHAMFER * gear.module();
    let layers = (gear.thickness / (1.2 * column_width))
        .round()
        .clamp(1.0, 64.0) as usize;
    let mut solid = Solid {
        builder: Builder::default(),
        points: flat.points.clone(),
        half: 0.5 * gear.thickness,
        chamfer,
        layers,
        is_flipped: gear.is_ring,
    };
    // The flat sides end where the chamfer begins.
    for (line, inwards) in [(&flat.outline, 1.0), (&end, -1.0)] {
        let inwards = if gear.is_ring { -inwards } else { inwards };
        for (&point, moved) in line
            .iter()
            .zip(inset(&flat.points, line, inwards * chamfer))
        {
            solid.points[point] = moved;
        }
    }
    solid.flats(&flat.quads);
    solid.wall(&flat.points, &flat.outline, false);
    solid.wall(&flat.points, &end, true);
    solid
        .builder
        .finish(if gear.is_ring { "ring_gear" } else { "gear" })
}

/// The flat side, as points in the plane: the body's rings from its end to the foot circle, then the teeth.
#[derive(Default)]
struct Flat {
    points: Vec<DVec2>,
    quads: Vec<[usize; 4]>,
    /// The points along the teeth and the gaps between them, counterclockwise.
    outline: Vec<usize>,
}

impl Flat {
    /// Adds the rings of the body from `end`, a distance from the axis, to the foot circle, where a tooth takes twice the angle `half`.
    fn add_body(&mut self, gear: &Gear, [foot, half]: [f64; 2], end: f64, rings: usize) {
        for ring in 0..=rings {
            let share = ring as f64 / rings as f64;
            let distance = end + share * (foot - end);
            for tooth in 0..gear.teeth as usize {
                for column in 0..COLUMNS {
                    // Even at the body's end, as the teeth have it at the foot circle.
                    let even = (column as f64 - 0.5 * TOOTH_COLUMNS as f64) / COLUMNS as f64
                        * gear.pitch();
                    let wanted = if column <= TOOTH_COLUMNS {
                        half * (2.0 * column as f64 / TOOTH_COLUMNS as f64 - 1.0)
                    } else {
                        half + (gear.pitch() - 2.0 * half) * (column - TOOTH_COLUMNS) as f64
                            / GAP_COLUMNS as f64
                    };
                    let angle =
                        gear.pitch() * tooth as f64 + even + share * share * (wanted - even);
                    self.points.push(distance * direction(angle));
                }
            }
        }
        for ring in 0..rings {
            for i in 0..gear.points_around() {
                self.quads.push([
                    gear.body_point(ring, i),
                    gear.body_point(ring + 1, i),
                    gear.body_point(ring + 1, i + 1),
                    gear.body_point(ring, i + 1),
                ]);
            }
        }
    }

    /// Adds a tooth on the body's last ring, and continues the outline along it and the gap behind it.
    fn add_tooth(&mut self, gear: &Gear, levels: &[[f64; 2]], rings: usize, tooth: usize) {
        let first = self.points.len();
        for [distance, half] in &levels[1..] {
            for column in 0..=TOOTH_COLUMNS {
                let aside = half * (2.0 * column as f64 / TOOTH_COLUMNS as f64 - 1.0);
                let angle = gear.pitch() * tooth as f64 + aside;
                self.points.push(*distance * direction(angle));
            }
        }
        let foot = |column: usize| gear.body_point(rings, tooth * COLUMNS + column);
        let at = |level: usize, column: usize| match level {
            0 => foot(column),
            _ => first + (level - 1) * (TOOTH_COLUMNS + 1) + column,
        };
        for level in 0..LEVELS {
            for column in 0..TOOTH_COLUMNS {
                self.quads.push([
                    at(level, column),
                    at(level + 1, column),
                    at(level + 1, column + 1),
                    at(level, column + 1),
                ]);
            }
        }
        let outline = &mut self.outline;
        outline.extend((0..LEVELS).map(|level| at(level, 0)));
        outline.extend((0..TOOTH_COLUMNS).map(|column| at(LEVELS, column)));
        outline.extend((1..=LEVELS).rev().map(|level| at(level, TOOTH_COLUMNS)));
        outline.extend((TOOTH_COLUMNS..COLUMNS).map(foot));
    }
}

/// The points of a closed line that runs counterclockwise, moved to its left.
fn inset(points: &[DVec2], line: &[usize], by: f64) -> Vec<DVec2> {
    let n = line.len();
    (0..n)
        .map(|i| {
            let [before, here, after] = [n - 1, 0, 1].map(|k| points[line[(i + k) % n]]);
            let normals = [here - before, after - here].map(|edge| edge.perp().normalize_or_zero());
            let middle = (normals[0] + normals[1]).normalize_or_zero();
            here + by * middle
        })
        .collect()
}

/// The solid: two flat sides and the walls between them.
struct Solid {
    builder: Builder,
    /// Points of the flat sides.
    points: Vec<DVec2>,
    half: f64,
    chamfer: f64,
    layers: usize,
    is_flipped: bool,
}

impl Solid {
    fn vertex(&mut self, point: DVec2, height: f64) -> u32 {
        // Angles run from +X towards -Z, as turns about Y do.
        self.builder.vertex(DVec3::new(point.x, height, -point.y))
    }

    fn quad(&mut self, [a, b, c, d]: [u32; 4], flipped: bool) {
        let quad = if flipped == self.is_flipped {
            [a, b, c, d]
        } else {
            [d, c, b, a]
        };
        self.builder.quad(quad);
    }

    /// The upper side's vertices come first, then the lower side's, in the order of the points.
    fn flats(&mut self, quads: &[[usize; 4]]) {
        for height in [self.half, -self.half] {
            for point in self.points.clone() {
                self.vertex(point, height);
            }
        }
        let count = self.points.len() as u32;
        for quad in quads {
            let quad = quad.map(|i| i as u32);
            self.quad(quad, false);
            self.quad(quad.map(|i| i + count), true);
        }
    }

    /// Between the two sides along a closed line that runs counterclockwise.
    fn wall(&mut self, points: &[DVec2], line: &[usize], is_end: bool) {
        let count = self.points.len();
        let n = line.len();
        let mut rows: Vec<Vec<u32>> = vec![line.iter().map(|&i| i as u32).collect()];
        for layer in 0..=self.layers {
            let share = layer as f64 / self.layers as f64;
            let height = (self.half - self.chamfer) * (1.0 - 2.0 * share);
            let row = line.iter().map(|&i| self.vertex(points[i], height));
            rows.push(row.collect());
        }
        rows.push(line.iter().map(|&i| (count + i) as u32).collect());
        for pair in rows.windows(2) {
            for i in 0..n {
                let j = (i + 1) % n;
                self.quad([pair[0][i], pair[1][i], pair[1][j], pair[0][j]], is_end);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wheel(teeth: u32, is_ring: bool) -> Gear {
        Gear {
            teeth,
            radius: f64::from(teeth) / 20.0,
            thickness: 0.3,
            bore: 0.2,
            play: 0.0,
            is_ring,
        }
    }

    /// Is a point of the plane inside the wheel's outline?
    fn is_inside(gear: &Gear, point: DVec2) -> bool {
        let distance = point.length();
        let levels = gear.levels();
        let (foot, tip) = (levels[0][0], levels[LEVELS][0]);
        let in_body = if gear.is_ring {
            distance > foot
        } else {
            distance < foot
        };
        let beyond_tips = if gear.is_ring {
            distance < tip
        } else {
            distance > tip
        };
        if in_body || beyond_tips {
            return in_body;
        }
        let angle = point.to_angle().rem_euclid(gear.pitch());
        let aside = angle.min(gear.pitch() - angle);
        aside < gear.half_angle(distance)
    }

    /// Wheels that mesh roll: at every turn flanks touch, and teeth do not cut into one another.
    #[test]
    fn teeth_touch_and_do_not_cut() {
        let pairs = [
            (
                wheel(24, false),
                wheel(18, false),
                2.1,
                -24.0 / 18.0,
                PI + PI / 18.0,
            ),
            (
                wheel(60, true),
                wheel(18, false),
                2.1,
                60.0 / 18.0,
                PI / 18.0,
            ),
        ];
        for (first, second, apart, ratio, phase) in pairs {
            for step in 0..16 {
                let turn = first.pitch() * f64::from(step) / 16.0;
                let mut deepest = 0.0_f64;
                let mut nearest = f64::INFINITY;
                // Points on the flanks of the second wheel, in the first one's frame.
                for tooth in 0..second.teeth {
                    for level in 0..=200 {
                        let module = second.module();
                        let distance =
                            second.radius - 0.9 * module + 1.9 * module * f64::from(level) / 200.0;
                        for side in [-1.0, 1.0] {
                            let own = second.pitch() * f64::from(tooth)
                                + side * second.half_angle(distance);
                            let angle = own + phase + ratio * turn;
                            let place =
                                DVec2::new(apart, 0.0) + distance * DVec2::from_angle(angle);
                            let place = DVec2::from_angle(-turn).rotate(place);
                            let off = place.length();
                            let levels = first.levels();
                            let (foot, tip) = (levels[0][0], levels[LEVELS][0]);
                            if (off - foot) * (off - tip) > 0.0 {
                                assert_eq!(
                                    is_inside(&first, place),
                                    first.is_ring && off > foot,
                                    "in the body"
                                );
                                continue;
                            }
                            let aside = place.to_angle().rem_euclid(first.pitch());
                            let aside = aside.min(first.pitch() - aside);
                            let gap = (aside - first.half_angle(off)) * off / module;
                            deepest = deepest.min(gap);
                            nearest = nearest.min(gap.abs());
                        }
                    }
                }
                assert!(
                    deepest > -0.02,
                    "turn {step}: they cut {deepest} modules deep"
                );
                assert!(
                    nearest < 0.01,
                    "turn {step}: they are {nearest} modules apart"
                );
            }
        }
    }
}

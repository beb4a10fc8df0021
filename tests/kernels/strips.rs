//! Theorems about the walks of particles and sensors, which lay triangles out flat: against the double-precision reference.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use myxo::mesh::strip::StripTriangle;
use myxo::mesh::surface::Surface;
use myxo::mesh::walk::{BorderRule, Frame, SurfacePoint, WalkEnd, walk};
use myxo::mesh::{Mesh, primitive, suite};
use myxo::rng::{Purpose, random};
use myxo::sim::strip_walk::StripWalk;
use myxo::sim::walker::{WALK_BORDER, WALK_DONE, WALK_OUT_OF_ATTEMPTS};

struct Ground {
    surface: Surface,
    strips: Vec<StripTriangle>,
}

impl Ground {
    fn of(mesh: &Mesh) -> Self {
        let surface = Surface::build(&[(mesh, 1.0)]);
        let maps = vec![bytemuck::Zeroable::zeroed(); surface.triangles.len()];
        let strips = surface.strips(&maps);
        Self { surface, strips }
    }

    /// A random point and heading, as float32 has them.
    fn start(&self, id: u32) -> StripWalk {
        let words = random(77, id, 0, Purpose::Start).map(|w| f64::from(w) / 4_294_967_296.0);
        let (mut u, mut v) = (words[1], words[2]);
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let heading = DVec2::from_angle(TAU * words[3]);
        StripWalk {
            triangle: (words[0] * self.surface.triangles.len() as f64) as u32,
            u: (0.02 + 0.94 * u) as f32,
            v: (0.02 + 0.94 * v) as f32,
            heading: heading.as_vec2().to_array(),
            remaining: 0.0,
            status: WALK_DONE,
        }
    }

    fn walked(&self, start: StripWalk, length: f32, attempts: u32, reflects: bool) -> StripWalk {
        let mut w = StripWalk {
            remaining: length,
            ..start
        };
        w.walk(&self.strips, attempts, reflects);
        assert!(w.u >= 0.0 && w.v >= 0.0 && w.u + w.v <= 1.0);
        let [p, h] = w.heading;
        assert!((p.hypot(h) - 1.0).abs() < 1e-6, "{p} {h}");
        w
    }

    fn reference(&self, start: StripWalk, length: f64, rule: BorderRule) -> WalkEnd {
        let [p, h] = start.heading.map(f64::from);
        let heading = DVec2::new(p, h).normalize();
        walk(&self.surface, point_of(&start), heading, length, None, rule)
    }

    fn place(&self, point: SurfacePoint) -> DVec3 {
        let corners = self.surface.corners[point.triangle as usize];
        let [a, b, c] = corners.map(|i| self.surface.positions[i as usize].as_dvec3());
        a + point.u * (b - a) + point.v * (c - a)
    }

    fn direction(&self, triangle: u32, heading: DVec2) -> DVec3 {
        let frame = Frame::of(&self.surface, triangle);
        heading.x * frame.p + heading.y * frame.h
    }
}

fn point_of(w: &StripWalk) -> SurfacePoint {
    SurfacePoint {
        triangle: w.triangle,
        u: w.u.into(),
        v: w.v.into(),
    }
}

/// On every mesh a walk ends where the reference does, and looks there where it looks. A walk near a vertex passes on the
/// other side of it by rounding: there it may end elsewhere.
#[test]
fn strips_end_where_walks_end() {
    for mesh in suite::all() {
        let name = mesh.name.clone();
        let ground = Ground::of(&mesh);
        for (length, most) in [(0.05, 2e-5), (0.4, 1e-4)] {
            let mut gaps: Vec<f64> = Vec::new();
            let mut turns: Vec<f64> = Vec::new();
            for id in 0..400 {
                let start = ground.start(id);
                let w = ground.walked(start, length, u32::MAX, true);
                assert_eq!((w.status, w.remaining), (WALK_DONE, 0.0), "{name}");
                let end = ground.reference(start, length.into(), BorderRule::Reflect);
                gaps.push(ground.place(point_of(&w)).distance(ground.place(end.point)));
                if end.point.triangle == w.triangle {
                    let [p, h] = w.heading.map(f64::from);
                    let heading = ground.direction(w.triangle, DVec2::new(p, h));
                    let expected = ground.direction(w.triangle, end.heading);
                    turns.push((heading - expected).length());
                }
            }
            gaps.sort_by(f64::total_cmp);
            turns.sort_by(f64::total_cmp);
            let [gap, turn] = [&gaps, &turns].map(|all| all[all.len() * 98 / 100]);
            assert!(
                gap < most && turn < 20.0 * most,
                "{name}, {length}: 98 % of the walks end within {gap} and turn within {turn}"
            );
            println!("{name}, {length}: {gap:.1e} {turn:.1e} {:.1e}", gaps[200]);
            assert!(gaps[200] < most / 4.0, "{name}, {length}: {}", gaps[200]);
        }
    }
}

/// Thousands of steps are one straight way: what a step rounds does not add up to a bend.
#[test]
fn many_steps_are_one_straight_way() {
    for mesh in [primitive::torus(144, 96, 0.4), primitive::cube(1)] {
        let name = mesh.name.clone();
        let ground = Ground::of(&mesh);
        let mut gaps: Vec<f64> = (0..60)
            .map(|id| {
                let start = ground.start(id);
                let mut w = start;
                for _ in 0..2000 {
                    w = ground.walked(w, 0.004, u32::MAX, true);
                }
                let end =
                    ground.reference(start, 2000.0 * f64::from(0.004f32), BorderRule::Reflect);
                ground.place(point_of(&w)).distance(ground.place(end.point))
            })
            .collect();
        gaps.sort_by(f64::total_cmp);
        println!(
            "{name}: 8 radii in 2,000 steps: off by {:.1e} (median), {:.1e} (90 %)",
            gaps[30], gaps[54]
        );
        assert!(gaps[30] < 1e-3, "{name}: {}", gaps[30]);
    }
}

/// An open border throws a walk back, or ends it there; both at the same place.
#[test]
fn borders_throw_back_or_stop() {
    let ground = Ground::of(&primitive::plane(7, 5));
    for id in 0..300 {
        let start = ground.start(id);
        let stopped = ground.walked(start, 100.0, u32::MAX, false);
        assert_eq!(stopped.status, WALK_BORDER);
        let end = ground.reference(start, 100.0, BorderRule::Stop);
        let gap = ground
            .place(point_of(&stopped))
            .distance(ground.place(end.point));
        assert!(gap < 1e-5, "stops {gap} away");
        assert!((f64::from(stopped.remaining) - (100.0 - end.travelled)).abs() < 1e-4);
        // Twice thrown back.
        let length = 3.1;
        let thrown = ground.walked(start, length, u32::MAX, true);
        let end = ground.reference(start, length.into(), BorderRule::Reflect);
        let gap = ground
            .place(point_of(&thrown))
            .distance(ground.place(end.point));
        assert!(gap < 2e-5, "thrown back {gap} away");
        let [p, h] = thrown.heading.map(f64::from);
        let turn = ground.direction(thrown.triangle, DVec2::new(p, h))
            - ground.direction(end.point.triangle, end.heading);
        assert!(turn.length() < 1e-4, "looks {turn} elsewhere");
    }
}

/// What a walk cannot cross now it crosses later: the pieces make the whole.
#[test]
fn capped_walks_go_on_where_they_stopped() {
    for mesh in suite::all() {
        let name = mesh.name.clone();
        let ground = Ground::of(&mesh);
        let mut gaps: Vec<f64> = (0..100)
            .map(|id| {
                let start = ground.start(id);
                let whole = ground.walked(start, 0.3, u32::MAX, true);
                let mut w = ground.walked(start, 0.3, 2, true);
                let mut pieces = 1;
                while w.status == WALK_OUT_OF_ATTEMPTS {
                    assert!(
                        w.remaining > 0.0 && pieces < 100_000,
                        "{name}, start {id}: no end"
                    );
                    w = ground.walked(w, w.remaining, 2, true);
                    pieces += 1;
                }
                ground
                    .place(point_of(&w))
                    .distance(ground.place(point_of(&whole)))
            })
            .collect();
        gaps.sort_by(f64::total_cmp);
        assert!(gaps[97] < 1e-4, "{name}: {}", gaps[97]);
    }
}

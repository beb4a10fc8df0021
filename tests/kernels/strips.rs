//! Theorems about the walks of particles and sensors, which lay triangles out flat: against the double-precision reference.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3};
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

/// Half-edge coordinates: a place is its half-edge's start, `a` of the way along it, and `b` of the way from its start to the apex. Seen from
/// the next half-edge of the triangle; for corner 0, they are uv.
fn seen_from_the_next([a, b]: [f64; 2]) -> [f64; 2] {
    [b, 1.0 - a - b]
}

/// The change of half-edge coordinates along a way, seen from the next half-edge.
fn way_seen_from_the_next([da, db]: [f64; 2]) -> [f64; 2] {
    [db, -da - db]
}

impl Ground {
    /// The ends of a half-edge and the apex of its triangle.
    fn corners_from(&self, halfedge: u32) -> [DVec3; 3] {
        let corners = self.surface.corners[halfedge as usize / 3];
        [0, 1, 2].map(|k| {
            let vertex = corners[(halfedge as usize + k) % 3];
            self.surface.positions[vertex as usize].as_dvec3()
        })
    }

    /// The projection of the apex on a half-edge, from its start, its height over it, and the half-edge's length.
    fn projection_and_height(&self, halfedge: u32) -> [f64; 3] {
        let [start, end, apex] = self.corners_from(halfedge);
        let (edge, way) = (end - start, apex - start);
        let length = edge.length();
        [
            edge.dot(way) / length,
            edge.cross(way).length() / length,
            length,
        ]
    }

    /// k1 and k2 of the matrix by which a way crosses a half-edge, which is `[-1, k2; 0, k1]` in half-edge coordinates of both sides.
    fn matrix(&self, halfedge: u32, measure: fn(f64) -> f64) -> [f64; 2] {
        let twin = self.surface.halfedges[halfedge as usize].twin;
        let [here, there] = [halfedge, twin].map(|side| self.projection_and_height(side));
        let k1 = -here[1] / there[1];
        [k1, -(measure(here[0]) + k1 * measure(there[0])) / here[2]]
    }

    /// A walk by these matrices, in double precision, on a closed mesh.
    fn by_matrices(
        &self,
        start: &StripWalk,
        length: f64,
        measure: fn(f64) -> f64,
    ) -> (SurfacePoint, DVec2) {
        let frame = Frame::of(&self.surface, start.triangle);
        let [p, h] = start.heading.map(f64::from);
        let mut way = frame.uv_rate(DVec2::new(p, h).normalize()).to_array();
        let mut at = [start.u, start.v].map(f64::from);
        let mut halfedge = 3 * start.triangle;
        let mut remaining = length;
        for _ in 0..10_000 {
            // The edge ahead is the one of the three whose b is 0 first.
            let mut nearest: Option<(f64, u32, [f64; 2], [f64; 2])> = None;
            let (mut place, mut heading) = (at, way);
            for turns in 0..3 {
                let distance = place[1] / -heading[1];
                if heading[1] < 0.0 && nearest.is_none_or(|(least, ..)| distance < least) {
                    nearest = Some((distance, turns, place, heading));
                }
                place = seen_from_the_next(place);
                heading = way_seen_from_the_next(heading);
            }
            let (distance, turns, place, heading) = nearest.expect("one weight falls");
            if distance >= remaining {
                break;
            }
            remaining -= distance;
            let (triangle, corner) = (halfedge / 3, (halfedge + turns) % 3);
            let crossed = 3 * triangle + corner;
            let [k1, k2] = self.matrix(crossed, measure);
            at = [1.0 - (place[0] + distance * heading[0]), 0.0];
            way = [k2 * heading[1] - heading[0], k1 * heading[1]];
            halfedge = self.surface.halfedges[crossed as usize].twin;
        }
        at = [0, 1].map(|k| at[k] + remaining * way[k]);
        let triangle = halfedge / 3;
        // As corner 0 sees it.
        for _ in 0..(3 - halfedge % 3) % 3 {
            at = seen_from_the_next(at);
            way = way_seen_from_the_next(way);
        }
        let frame = Frame::of(&self.surface, triangle);
        let point = SurfacePoint {
            triangle,
            u: at[0],
            v: at[1],
        };
        (point, frame.position(way[0], way[1]))
    }

    /// How far such walks end from the reference and from the walks of particles: the most of the first, and 98 % of the second.
    fn gaps_of_matrices(&self, measure: fn(f64) -> f64) -> [f64; 2] {
        let length = 1.5;
        let (mut most, mut of_particles) = (0.0f64, Vec::new());
        for id in 0..300 {
            let start = self.start(id);
            let (point, heading) = self.by_matrices(&start, length, measure);
            let end = self.reference(start, length, BorderRule::Reflect);
            let turn = self.direction(point.triangle, heading)
                - self.direction(end.point.triangle, end.heading);
            most = most
                .max(self.place(point).distance(self.place(end.point)))
                .max(turn.length());
            let w = self.walked(start, length as f32, u32::MAX, true);
            of_particles.push(self.place(point).distance(self.place(point_of(&w))));
        }
        of_particles.sort_by(f64::total_cmp);
        [most, of_particles[300 * 98 / 100]]
    }
}

/// The sphere, three times as long: many of its triangles are obtuse.
fn long_sphere() -> Mesh {
    let round = primitive::icosphere(2);
    let long = round
        .positions
        .iter()
        .map(|p| *p * Vec3::new(1.0, 3.0, 1.0));
    suite::mesh("long sphere", &long.collect::<Vec<_>>(), &round.corners)
}

/// Walks are those by the thesis's matrices, which take the projections of apexes without their signs, on triangles that are not obtuse: there
/// no projection is negative. Would catch: a heading that is turned by another angle than the two planes of an edge are, and a place that
/// changes where it crosses. On obtuse triangles the matrices are right with signs, and wrong without.
#[test]
fn walks_are_those_by_matrices_in_half_edge_coordinates() {
    for mesh in [
        primitive::icosphere(2),
        primitive::cube(1),
        primitive::cube(5),
    ] {
        let ground = Ground::of(&mesh);
        let halfedges = 0..ground.surface.halfedges.len() as u32;
        let least = halfedges
            .map(|halfedge| ground.projection_and_height(halfedge)[0])
            .fold(f64::INFINITY, f64::min);
        assert!(least > -1e-12, "{} is obtuse: {least}", mesh.name);
        let [most, of_particles] = ground.gaps_of_matrices(f64::abs);
        assert!(
            most < 1e-9 && of_particles < 1e-4,
            "{}: {most}, {of_particles}",
            mesh.name
        );
    }
    let ground = Ground::of(&long_sphere());
    let [most, of_particles] = ground.gaps_of_matrices(|projection| projection);
    assert!(
        most < 1e-9 && of_particles < 1e-4,
        "obtuse: {most}, {of_particles}"
    );
    let [most, of_particles] = ground.gaps_of_matrices(f64::abs);
    assert!(
        most > 0.1 && of_particles > 0.1,
        "without signs: {most}, {of_particles}"
    );
}

/// Would catch: coordinates of one half-edge taken for those of another one. Once round a triangle they are what they were, and on the way
/// they mean the same place.
#[test]
fn three_rotations_of_uv_are_the_identity() {
    let ground = Ground::of(&suite::potato());
    for id in 0..300 {
        let start = ground.start(id);
        let uv = [start.u, start.v].map(f64::from);
        let [p, h] = start.heading.map(f64::from);
        let frame = Frame::of(&ground.surface, start.triangle);
        let rate = frame.uv_rate(DVec2::new(p, h)).to_array();
        let (mut at, mut way) = (uv, rate);
        for turns in 0..3 {
            let [from, to, apex] = ground.corners_from(3 * start.triangle + turns);
            let along = |[a, b]: [f64; 2]| a * (to - from) + b * (apex - from);
            let gap = (from + along(at)).distance(ground.place(point_of(&start)));
            let turn = along(way) - ground.direction(start.triangle, DVec2::new(p, h));
            assert!(gap < 1e-6 && turn.length() < 1e-4, "{gap}, {turn}");
            (at, way) = (seen_from_the_next(at), way_seen_from_the_next(way));
        }
        let is_near = |a: [f64; 2], b: [f64; 2], most: f64| {
            (0..2).all(|k| (a[k] - b[k]).abs() <= most * (1.0 + b[k].abs()))
        };
        assert!(is_near(at, uv, 1e-14) && is_near(way, rate, 1e-14));
    }
}

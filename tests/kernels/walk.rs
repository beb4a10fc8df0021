//! Theorems about straight walks, for the double-precision reference and for the float32 twin of the kernels' walk.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DMat3, DVec2, DVec3};
use myxo::mesh::surface::Surface;
use myxo::mesh::walk::{BorderRule, Frame, SurfacePoint, WalkEnd, WalkQuery, WalkStatus, walk};
use myxo::mesh::{Mesh, primitive, suite};
use myxo::rng::{Purpose, random};
use myxo::sim::queries::{self, walker_of};
use myxo::sim::types::Walker;
use myxo::sim::walker as twin;

fn surface(mesh: &Mesh) -> Surface {
    Surface::build(&[(mesh, 1.0)])
}

/// A random point, and a random unit heading in its triangle.
fn random_start(surface: &Surface, id: u32) -> (SurfacePoint, DVec2) {
    let words = random(99, id, 0, Purpose::Start).map(|w| f64::from(w) / 4_294_967_296.0);
    let triangle = (words[0] * surface.triangles.len() as f64) as u32;
    let (mut u, mut v) = (words[1], words[2]);
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    // Away from the edges, so that a start is not a vertex.
    let (u, v) = (0.02 + 0.94 * u, 0.02 + 0.94 * v);
    (
        SurfacePoint { triangle, u, v },
        DVec2::from_angle(TAU * words[3]),
    )
}

fn position(surface: &Surface, point: SurfacePoint) -> DVec3 {
    let [a, b, c] =
        surface.corners[point.triangle as usize].map(|i| surface.positions[i as usize].as_dvec3());
    a + point.u * (b - a) + point.v * (c - a)
}

fn direction(surface: &Surface, triangle: u32, heading: DVec2) -> DVec3 {
    let frame = Frame::of(surface, triangle);
    heading.x * frame.p + heading.y * frame.h
}

fn full_walk(surface: &Surface, start: SurfacePoint, heading: DVec2, length: f64) -> WalkEnd {
    walk(surface, start, heading, length, None, BorderRule::Reflect)
}

/// A walk by the twin, without a limit on crossings.
fn twin_walk(surface: &Surface, start: SurfacePoint, heading: DVec2, length: f64) -> Walker {
    let heading = heading.as_vec2().to_array();
    let mut w = Walker::at(
        start.triangle,
        start.u as f32,
        start.v as f32,
        heading,
        length as f32,
    );
    twin::walk::<false>(
        &surface.triangles,
        &surface.halfedges,
        &mut w,
        u32::MAX,
        true,
    );
    w
}

fn end_of(w: &Walker) -> SurfacePoint {
    let [u, v] = w.uv();
    SurfacePoint {
        triangle: w.triangle,
        u: f64::from(u),
        v: f64::from(v),
    }
}

#[test]
fn there_and_back_returns() {
    for mesh in suite::all() {
        let name = mesh.name.clone();
        let surface = surface(&mesh);
        for id in 0..200 {
            let (start, heading) = random_start(&surface, id);
            let there = full_walk(&surface, start, heading, 1.7);
            let back = full_walk(&surface, there.point, -there.heading, 1.7);
            let miss = position(&surface, back.point).distance(position(&surface, start));
            assert!(
                miss < 1e-9,
                "{name}, start {id}: misses its start by {miss}"
            );
            let turned = direction(&surface, back.point.triangle, back.heading)
                + direction(&surface, start.triangle, heading);
            assert!(
                back.point.triangle != start.triangle || turned.length() < 1e-9,
                "{name}, start {id}: comes back at an angle of {}",
                turned.length()
            );
        }
    }
}

#[test]
fn lengths_add() {
    for mesh in suite::all() {
        let name = mesh.name.clone();
        let surface = surface(&mesh);
        for id in 0..100 {
            let (start, heading) = random_start(&surface, id);
            let whole = full_walk(&surface, start, heading, 1.3);
            let first = full_walk(&surface, start, heading, 0.4);
            let second = full_walk(&surface, first.point, first.heading, 0.9);
            let gap = position(&surface, whole.point).distance(position(&surface, second.point));
            assert!(
                gap < 1e-9,
                "{name}, start {id}: 0.4 + 0.9 ends {gap} from 1.3"
            );
            assert!((first.travelled + second.travelled - whole.travelled).abs() < 1e-12);
        }
    }
}

/// A straight walk on a cube is the trace of rolling the cube over a plane along a straight line.
#[test]
fn walking_on_a_cube_is_rolling_it() {
    let surface = surface(&primitive::cube(1));
    // The cube spans [-1, 1]^3 and stands on z = -1, seen from outside: the plane's y is mirrored there, so the walk
    // is done on the face z = 1, with the plane on top of the cube.
    let bottom = (0..12)
        .find(|&t| {
            surface.corners[t as usize]
                .iter()
                .all(|&i| surface.positions[i as usize].z > 0.5)
        })
        .expect("a cube has a face z = 1");
    for id in 0..400 {
        let angle = TAU * f64::from(id) / 400.0 + 0.001;
        let length = 0.3 + 0.05 * f64::from(id);
        let frame = Frame::of(&surface, bottom);
        let corner = surface.positions[surface.corners[bottom as usize][0] as usize].as_dvec3();
        let inside = DVec3::new(0.11, 0.23, 1.0);
        // Whichever of the two triangles holds the point.
        let (start, frame) = [bottom, partner(&surface, bottom)]
            .into_iter()
            .map(|t| {
                let frame = Frame::of(&surface, t);
                let a = surface.positions[surface.corners[t as usize][0] as usize].as_dvec3();
                let uv = frame.uv_rate(DVec2::new(
                    (inside - a).dot(frame.p),
                    (inside - a).dot(frame.h),
                ));
                (
                    SurfacePoint {
                        triangle: t,
                        u: uv.x,
                        v: uv.y,
                    },
                    frame,
                )
            })
            .find(|(p, _)| p.u >= 0.0 && p.v >= 0.0 && p.u + p.v <= 1.0)
            .unwrap_or_else(|| panic!("the point lies on the face of {corner} and {frame:?}"));
        let world = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let heading = DVec2::new(world.dot(frame.p), world.dot(frame.h));
        let end = full_walk(&surface, start, heading, length);

        // Roll: cross the lines x = odd, y = odd in the order in which the straight line meets them.
        let mut body_from_plane = DMat3::IDENTITY;
        let target = inside.truncate() + length * world.truncate();
        let mut centre = DVec2::ZERO;
        loop {
            let exits = [
                (1.0, DVec2::X),
                (1.0, -DVec2::X),
                (1.0, DVec2::Y),
                (1.0, -DVec2::Y),
            ]
            .map(|(half, side)| {
                let speed = world.truncate().dot(side);
                let t = (half - (inside.truncate() - centre).dot(side)) / speed;
                (if speed > 0.0 { t } else { f64::INFINITY }, side)
            });
            let (t, side) = exits
                .into_iter()
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap();
            if t >= length {
                break;
            }
            // The plane lies on the cube: going to one side brings that side's face up.
            let axis = DVec3::new(side.y, -side.x, 0.0);
            body_from_plane *= DMat3::from_axis_angle(axis, -FRAC_PI_2);
            centre += 2.0 * side;
        }
        let expected = body_from_plane * (target - centre).extend(1.0);
        let miss = position(&surface, end.point).distance(expected);
        assert!(
            miss < 1e-9,
            "angle {angle}, length {length}: {miss} from where the cube rolls to"
        );
        let expected_direction = body_from_plane * world;
        let turned =
            direction(&surface, end.point.triangle, end.heading).distance(expected_direction);
        assert!(
            turned < 1e-9,
            "angle {angle}, length {length}: direction off by {turned}"
        );

        let w = twin_walk(&surface, start, heading, length);
        let miss = position(&surface, end_of(&w)).distance(expected);
        assert!(
            miss < 2e-5,
            "angle {angle}, length {length}: the twin is {miss} off"
        );
    }
}

/// The other triangle of a cube's face.
fn partner(surface: &Surface, triangle: u32) -> u32 {
    let normal = |t| {
        let frame = Frame::of(surface, t);
        frame.p.cross(frame.h)
    };
    (0..12)
        .find(|&t| t != triangle && normal(t).dot(normal(triangle)) > 0.5)
        .expect("two triangles a face")
}

#[test]
fn meridian_of_a_torus_closes() {
    let (major, minor) = (36, 24);
    let surface = surface(&primitive::torus(major, minor, 0.4));
    // The middle line of a ring of trapezoids crosses its edges at right angles, so it is straight; it comes back
    // after the sum of their heights.
    let start = SurfacePoint {
        triangle: 0,
        u: 0.0,
        v: 0.0,
    };
    let triangle = surface.corners[0].map(|i| surface.positions[i as usize].as_dvec3());
    // The edge that runs round the major circle keeps its height.
    let along = (0..3)
        .map(|k| (triangle[k], triangle[(k + 1) % 3]))
        .min_by(|a, b| {
            let round = |(p, q): (DVec3, DVec3)| {
                (p.y - q.y).abs() + (p.x.hypot(p.z) - q.x.hypot(q.z)).abs()
            };
            round(*a).total_cmp(&round(*b))
        })
        .unwrap();
    let middle = 0.5 * (along.0 + along.1);
    let frame = Frame::of(&surface, 0);
    let a = triangle[0];
    let uv = frame.uv_rate(DVec2::new(
        (middle - a).dot(frame.p),
        (middle - a).dot(frame.h),
    ));
    let start = SurfacePoint {
        u: uv.x,
        v: uv.y,
        ..start
    };
    let edge = (along.1 - along.0).normalize();
    let inward = edge.cross(frame.p.cross(frame.h));
    let centroid = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
    let inward = if inward.dot(centroid - middle) > 0.0 {
        inward
    } else {
        -inward
    };
    let heading = DVec2::new(inward.dot(frame.p), inward.dot(frame.h));
    let ring = |i: u32| {
        let angle = TAU * f64::from(i) / f64::from(minor);
        (1.0 + 0.4 * angle.cos(), 0.4 * angle.sin())
    };
    let half_step = std::f64::consts::PI / f64::from(major);
    let length: f64 = (0..minor)
        .map(|i| {
            let ((r0, y0), (r1, y1)) = (ring(i), ring(i + 1));
            ((r1 - r0) * half_step.cos()).hypot(y1 - y0)
        })
        .sum();
    let end = full_walk(&surface, start, heading, length);
    let miss = position(&surface, end.point).distance(middle);
    assert!(
        miss < 1e-6,
        "the meridian of length {length} misses its start by {miss}"
    );
    let came_back = direction(&surface, end.point.triangle, end.heading);
    assert!(
        came_back.dot(edge).abs() < 1e-6,
        "it comes back at right angles to the edge"
    );
    let w = twin_walk(&surface, start, heading, length);
    let miss = position(&surface, end_of(&w)).distance(middle);
    assert!(miss < 1e-5, "the twin misses by {miss}");
}

/// On a plane with mirrors at its sides a straight walk is a zigzag with a closed form.
#[test]
fn open_borders_reflect() {
    let mesh = primitive::plane(7, 5);
    let surface = surface(&mesh);
    let low = mesh
        .positions
        .iter()
        .fold(glam::Vec3::INFINITY, |a, &b| a.min(b))
        .as_dvec3();
    let high = mesh
        .positions
        .iter()
        .fold(glam::Vec3::NEG_INFINITY, |a, &b| a.max(b))
        .as_dvec3();
    let mirrored = |x: f64, low: f64, high: f64| {
        let t = (x - low).rem_euclid(2.0 * (high - low));
        low + if t > high - low {
            2.0 * (high - low) - t
        } else {
            t
        }
    };
    for id in 0..200 {
        let (start, heading) = random_start(&surface, id);
        let length = 0.2 * f64::from(id);
        let from = position(&surface, start);
        let world = direction(&surface, start.triangle, heading);
        let straight = from + length * world;
        let expected = DVec3::from_array(std::array::from_fn(|k| {
            if high[k] > low[k] {
                mirrored(straight[k], low[k], high[k])
            } else {
                low[k]
            }
        }));
        let end = full_walk(&surface, start, heading, length);
        let miss = position(&surface, end.point).distance(expected);
        assert!(miss < 1e-8, "start {id}: {miss} from the mirrored place");
        let miss = position(
            &surface,
            end_of(&twin_walk(&surface, start, heading, length)),
        )
        .distance(expected);
        assert!(
            miss < 1e-4,
            "start {id}: the twin is {miss} from the mirrored place"
        );
    }
}

#[test]
fn open_borders_stop_when_asked() {
    let mesh = primitive::plane(7, 5);
    let surface = surface(&mesh);
    for id in 0..100 {
        let (start, heading) = random_start(&surface, id);
        let end = walk(&surface, start, heading, 100.0, None, BorderRule::Stop);
        assert_eq!(end.status, WalkStatus::Border);
        let distance = position(&surface, end.point).distance(position(&surface, start));
        assert!(
            (distance - end.travelled).abs() < 1e-9,
            "the way to the border is straight"
        );
        let mut w = Walker::at(
            start.triangle,
            start.u as f32,
            start.v as f32,
            heading.as_vec2().to_array(),
            100.0,
        );
        twin::walk::<false>(
            &surface.triangles,
            &surface.halfedges,
            &mut w,
            u32::MAX,
            false,
        );
        assert_eq!(w.status, twin::WALK_BORDER);
        let gap = position(&surface, end_of(&w)).distance(position(&surface, end.point));
        assert!(gap < 1e-5, "the twin stops {gap} away");
        assert!((f64::from(w.remaining) - (100.0 - end.travelled)).abs() < 1e-4);
    }
}

/// What a walk cannot cross now it crosses later: the pieces make the whole.
#[test]
fn capped_walks_go_on_where_they_stopped() {
    for mesh in suite::all() {
        let name = mesh.name.clone();
        let surface = surface(&mesh);
        for id in 0..50 {
            let (start, heading) = random_start(&surface, id);
            let whole = twin_walk(&surface, start, heading, 1.1);
            let mut w = Walker::at(
                start.triangle,
                start.u as f32,
                start.v as f32,
                heading.as_vec2().to_array(),
                1.1,
            );
            let mut pieces = 0;
            loop {
                twin::walk::<false>(&surface.triangles, &surface.halfedges, &mut w, 2, true);
                if w.status != twin::WALK_OUT_OF_ATTEMPTS {
                    break;
                }
                pieces += 1;
                assert!(pieces < 100_000, "{name}, start {id}: no end");
            }
            let gap = position(&surface, end_of(&w)).distance(position(&surface, end_of(&whole)));
            assert!(
                gap < 1e-6,
                "{name}, start {id}: {pieces} pieces end {gap} from the whole walk"
            );
        }
    }
}

/// The 500 errors of walks of three lengths against double precision, sorted.
fn errors(surface: &Surface, walked: impl Fn(&WalkQuery) -> SurfacePoint) -> Vec<f64> {
    let error = |id| {
        let (start, heading) = random_start(surface, id);
        let start = SurfacePoint {
            u: f64::from(start.u as f32),
            v: f64::from(start.v as f32),
            ..start
        };
        let query = WalkQuery {
            start,
            heading,
            length: 3.0,
        };
        let end = full_walk(surface, start, heading, 3.0);
        position(surface, walked(&query)).distance(position(surface, end.point))
    };
    let mut errors: Vec<f64> = (0..500).map(error).collect();
    errors.sort_by(f64::total_cmp);
    errors
}

/// The suite, and needles that a walk crosses by the thousand.
fn meshes_and_needles() -> Vec<Mesh> {
    let mut meshes = suite::all();
    for name in [
        "torus?major=3&minor=2000",
        "torus?major=4000&minor=3&tube=0.1",
    ] {
        meshes.push(Mesh::builtin(name).unwrap());
    }
    meshes
}

/// Float32 against double precision. Each crossing rounds, so errors grow with the root of their number: about 300 on
/// a torus of 27,648 triangles, 6,000 over needles. The paths may part at a vertex, where no straight continuation
/// exists, so a fiftieth of the walks is left out of the bound.
#[test]
fn twin_stays_near_the_reference() {
    for mesh in meshes_and_needles() {
        let surface = surface(&mesh);
        let errors = errors(&surface, |q| {
            end_of(&twin_walk(&surface, q.start, q.heading, q.length))
        });
        let needles = mesh.name == "torus" && mesh.report.triangles < 30_000;
        let (median, most) = if needles { (1e-5, 4e-5) } else { (2e-6, 6e-6) };
        assert!(
            errors[250] < median && errors[490] < most,
            "{}: median error {:e}, 98 % below {:e}",
            mesh.name,
            errors[250],
            errors[490]
        );
    }
}

/// What carrying along the roundings is for: no error grows, over however many edges and however thin triangles.
#[test]
fn twin_that_carries_its_roundings_stays_much_nearer() {
    for mesh in meshes_and_needles() {
        let surface = surface(&mesh);
        let errors = errors(&surface, |q| {
            let mut w = walker_of(q);
            twin::walk::<true>(
                &surface.triangles,
                &surface.halfedges,
                &mut w,
                u32::MAX,
                true,
            );
            queries::end_of(&w, q).point
        });
        assert!(
            errors[250] < 2e-7 && errors[490] < 6e-7,
            "{}: median error {:e}, 98 % below {:e}",
            mesh.name,
            errors[250],
            errors[490]
        );
    }
}

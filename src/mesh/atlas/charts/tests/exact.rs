//! Surfaces with a known exact flattening.

use glam::Vec3;

use super::*;
use crate::mesh::atlas::tests::crooked_plane;
use crate::mesh::suite;

/// The largest relative deviation of a flattened edge from its length, and of a triangle's area.
fn deviation(surface: &Surface, charts: &[FlatChart]) -> f64 {
    let metric = Metric::new(surface);
    let mut most = 0.0_f64;
    for chart in charts {
        for (&t, corners) in chart.triangles.iter().zip(&chart.corners) {
            for k in 0..3 {
                let length = corners[k].distance(corners[(k + 1) % 3]);
                most = most.max((length / metric.length(3 * t + k as u32) - 1.0).abs());
            }
        }
    }
    most
}

/// Developable surfaces are unrolled to a dozen digits: planes, the faces of a cube, cones beside their tip, tubes.
#[test]
fn developable_surfaces_are_unrolled() {
    let whole = suite::fan(60);
    // Without one triangle the tip is on the border, and the cone can be rolled out.
    let cone = suite::mesh("cone", &whole.positions, &whole.corners[..59]);
    let tube = suite::tube(12, 5);
    for (name, surface) in [
        ("plane", builtin("plane?columns=13&rows=7")),
        ("crooked plane", crooked_plane()),
        ("cube", builtin("cube?divisions=5")),
        ("cone", Surface::build(&[(&cone, 1.0)])),
        ("tube", Surface::build(&[(&tube, 1.0)])),
    ] {
        let charts = charts(&surface);
        let most = deviation(&surface, &charts);
        let exact = if name == "plane" { 1e-12 } else { 1e-11 };
        assert!(most < exact, "{name}: {most:e} in {} charts", charts.len());
    }
}

/// The cap of a sphere becomes a disc by stereographic projection, the conformal map that keeps circles: from the pole
/// the plane's radius is proportional to the tangent of half the angle.
#[test]
fn a_cap_is_projected_stereographically() {
    let rings = 24_u32;
    let segments = 72_u32;
    let reach = 0.9_f64;
    let mut positions = vec![Vec3::Y];
    for ring in 1..=rings {
        let polar = reach * f64::from(ring) / f64::from(rings);
        for k in 0..segments {
            let around = std::f64::consts::TAU * (f64::from(k) + 0.5 * f64::from(ring % 2))
                / f64::from(segments);
            let (sin, cos) = polar.sin_cos();
            positions.push(glam::DVec3::new(sin * around.cos(), cos, sin * around.sin()).as_vec3());
        }
    }
    let at = |ring: u32, k: u32| 1 + (ring - 1) * segments + k % segments;
    let mut triangles: Vec<_> = (0..segments).map(|k| [0, at(1, k + 1), at(1, k)]).collect();
    for ring in 1..rings {
        for k in 0..segments {
            // Odd rings are turned by half a segment.
            let (a, b) = (at(ring, k), at(ring, k + 1));
            let (c, d) = (at(ring + 1, k), at(ring + 1, k + 1));
            if ring % 2 == 1 {
                triangles.extend([[a, b, d], [a, d, c]]);
            } else {
                triangles.extend([[a, b, c], [b, d, c]]);
            }
        }
    }
    let mesh = suite::mesh("cap", &positions, &triangles);
    let surface = Surface::build(&[(&mesh, 1.0)]);
    let metric = Metric::new(&surface);
    let all: Vec<u32> = (0..surface.corners.len() as u32).collect();
    let free = Bounds {
        share: 1.0,
        wild: 1.0,
        part: 1.0,
        ..STRICT
    };
    let piece = Piece::new(&surface, &metric, &all, &free, &mut Places::new()).unwrap();
    let pole = piece
        .triangles
        .iter()
        .zip(&piece.corners)
        .find_map(|(&t, corners)| {
            let k = surface.corners[t as usize].iter().position(|&v| v == 0)?;
            Some(corners[k])
        })
        .unwrap();
    let mut ratios = Vec::new();
    for (&t, corners) in piece.triangles.iter().zip(&piece.corners) {
        for (corner, &v) in corners.iter().zip(&surface.corners[t as usize]) {
            let polar = f64::from(surface.positions[v as usize].y).acos();
            if polar > 0.05 {
                ratios.push(corner.distance(pole) / (0.5 * polar).tan());
            }
        }
    }
    let (low, high) = ratios.iter().fold((f64::MAX, 0.0_f64), |(low, high), &r| {
        (low.min(r), high.max(r))
    });
    assert!(high / low < 1.01, "radius over tangent is {low} to {high}");
    // At the rim of this cap areas grow more than in the middle, by the square of the secant.
    let (areas, skews) = distortions(
        &surface,
        &[FlatChart {
            object: 0,
            triangles: piece.triangles,
            corners: piece.corners,
        }],
    );
    let spread = areas.percentile(99.0) / areas.percentile(1.0);
    let expected = (0.5 * reach).cos().powi(-4);
    assert!(
        (spread / expected - 1.0).abs() < 0.05,
        "{spread} and not {expected}"
    );
    assert!(skews.percentile(99.0) < 1.03);
}

/// Flattening keeps angles far better than a map that keeps areas or lengths can: and more so the finer a mesh is.
#[test]
fn angles_converge_to_those_on_the_surface() {
    let skew = |name: &str| {
        let surface = builtin(name);
        distortions(&surface, &charts(&surface)).1.percentile(95.0) - 1.0
    };
    let (coarse, fine) = (
        skew("icosphere?subdivisions=3"),
        skew("icosphere?subdivisions=5"),
    );
    assert!(fine < 0.45 * coarse, "{coarse} and {fine}");
    assert!(fine < 0.015, "{fine}");
}

/// A hole whose whole rim is open border needs no cut; its rim neither overlaps nor moves.
#[test]
fn holes_need_no_cut() {
    let plane = Mesh::builtin("plane?columns=20&rows=20").unwrap();
    let outside = |corners: &&[u32; 3]| {
        let middle: Vec3 = corners
            .iter()
            .map(|&v| plane.positions[v as usize])
            .sum::<Vec3>()
            / 3.0;
        let inside = |x: f32, z: f32| (middle.x - x).abs() < 0.199 && (middle.z - z).abs() < 0.149;
        !inside(0.3, 0.35) && !inside(-0.5, -0.25)
    };
    let triangles: Vec<_> = plane.corners.iter().filter(outside).copied().collect();
    assert_eq!(triangles.len(), 800 - 2 * 24);
    let mesh = suite::mesh("holes", &plane.positions, &triangles);
    let surface = Surface::build(&[(&mesh, 1.0)]);
    let all: Vec<u32> = (0..surface.corners.len() as u32).collect();
    let piece = Piece::new(
        &surface,
        &Metric::new(&surface),
        &all,
        &STRICT,
        &mut Places::new(),
    )
    .unwrap();
    let whole = FlatChart {
        object: 0,
        triangles: piece.triangles,
        corners: piece.corners,
    };
    assert!(deviation(&surface, &[whole]) < 1e-11);
    // A hole whose rim belongs to another chart does need one.
    let plane = builtin("plane?columns=20&rows=20");
    let ring: Vec<u32> = (0..800).filter(|t| t / 2 != 210).collect();
    assert!(Patch::new(&plane, &ring, &mut Places::new()).is_none());
}

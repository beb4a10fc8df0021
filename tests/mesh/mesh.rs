//! Theorems about meshes and surfaces, on suites of meshes.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use myxo::mesh::surface::{NONE, Seam, Surface, Triangle};
use myxo::mesh::trees::self_crossings;
use myxo::mesh::walk::{BorderRule, Frame, SurfacePoint, walk};
use myxo::mesh::{Mesh, MeshReport, suite};

fn surface_of(mesh: &Mesh) -> Surface {
    Surface::build(&[(mesh, 1.0)])
}

/// The angle at each corner of a triangle, in double precision.
fn angles(surface: &Surface, triangle: u32) -> [f64; 3] {
    let [a, b, c] = Frame::of(surface, triangle).corners();
    [
        (b - a).angle_to(c - a),
        (c - b).angle_to(a - b),
        (a - c).angle_to(b - c),
    ]
}

fn volume(mesh: &Mesh) -> f64 {
    let six = mesh.corners.iter().map(|corners| {
        let [a, b, c] = corners.map(|vertex| mesh.positions[vertex as usize].as_dvec3());
        a.dot(b.cross(c))
    });
    six.sum::<f64>() / 6.0
}

#[test]
fn every_surface_of_the_suite_is_valid() {
    for mesh in suite::all() {
        let surface = surface_of(&mesh);
        surface
            .validate()
            .unwrap_or_else(|problem| panic!("{}: {problem}", mesh.name));
        assert_eq!(surface.triangles.len(), mesh.report.triangles);
    }
    let all = suite::all();
    let objects: Vec<_> = all.iter().map(|mesh| (mesh, 0.37)).collect();
    Surface::build(&objects).validate().unwrap();
}

#[test]
fn plain_meshes_have_nothing_to_report() {
    for mesh in [suite::closed(), suite::open()].concat() {
        assert_eq!(
            mesh.report.oddities(),
            Vec::<String>::new(),
            "{}",
            mesh.name
        );
        assert!((0..mesh.corners.len() as u32).all(|triangle| !mesh.is_flipped(triangle)));
    }
    assert!(suite::closed().iter().all(|mesh| mesh.report.is_closed()));
    assert!(suite::closed().iter().all(|mesh| volume(mesh) > 0.0));
    assert!(suite::open().iter().all(|mesh| !mesh.report.is_closed()));
}

#[test]
fn validate_sees_what_is_broken() {
    let mesh = Mesh::builtin("torus?major=8&minor=6").unwrap();
    type Breakage = fn(&mut Surface);
    let breakages: [(&str, Breakage); 8] = [
        ("twin", |s| s.halfedges[5].twin = s.halfedges[6].twin),
        ("does not exist", |s| s.halfedges[0].twin = 4_000_000),
        ("rotation", |s| s.halfedges[7].sin += 1e-4),
        ("rotation", |s| s.halfedges[7].fine ^= 0x4000_0000),
        ("no shape", |s| s.triangles[3].ch = 0.0),
        ("not the shape", |s| s.triangles[3].cp *= 1.001),
        ("corner outside", |s| s.corners[2][1] = 4_000_000),
        ("half-edges", |s| s.halfedges.truncate(10)),
    ];
    for (words, breakage) in breakages {
        let mut surface = surface_of(&mesh);
        breakage(&mut surface);
        let problem = surface.validate().unwrap_err();
        assert!(problem.contains(words), "{words}: {problem}");
    }
}

#[test]
fn angle_defects_add_up_to_the_euler_characteristic() {
    for mesh in [suite::closed(), suite::open()].concat() {
        let surface = surface_of(&mesh);
        let mut angle_at = vec![0.0; mesh.positions.len()];
        let mut on_border = vec![false; mesh.positions.len()];
        for (triangle, corners) in surface.corners.iter().enumerate() {
            for (corner, angle) in angles(&surface, triangle as u32).into_iter().enumerate() {
                angle_at[corners[corner] as usize] += angle;
                if surface.halfedges[3 * triangle + corner].twin == NONE {
                    on_border[corners[corner] as usize] = true;
                    on_border[corners[(corner + 1) % 3] as usize] = true;
                }
            }
        }
        let whole = |border: &bool| if *border { PI } else { TAU };
        let defects: f64 = angle_at
            .iter()
            .zip(&on_border)
            .map(|(angle, border)| whole(border) - angle)
            .sum();
        let expected = TAU * mesh.report.euler_characteristic as f64;
        assert!(
            (defects - expected).abs() < 1e-9,
            "{}: {defects} and not {expected}",
            mesh.name
        );
    }
}

#[test]
fn a_heading_carried_round_a_vertex_turns_by_its_angle_defect() {
    for mesh in [suite::closed(), suite::open()].concat() {
        let surface = surface_of(&mesh);
        for first in 0..surface.halfedges.len() as u32 {
            let mut turned = DVec2::X;
            let mut angle = 0.0;
            let mut halfedge = first;
            let mut triangles = 0.0;
            // Counter-clockwise round the start of the half-edge: leave each triangle over the edge that ends there.
            let closed = loop {
                let (triangle, corner) = (halfedge / 3, halfedge % 3);
                angle += angles(&surface, triangle)[corner as usize];
                let leave = surface.halfedges[(3 * triangle + (corner + 2) % 3) as usize];
                if leave.twin == NONE {
                    break false;
                }
                turned = DVec2::new(f64::from(leave.cos), f64::from(leave.sin)).rotate(turned);
                triangles += 1.0;
                halfedge = leave.twin;
                if halfedge == first {
                    break true;
                }
            };
            if closed {
                let expected = DVec2::from_angle(TAU - angle);
                assert!(
                    (turned - expected).length() < 2e-7 * triangles,
                    "{}, half-edge {first}: {turned} and not {expected}",
                    mesh.name
                );
            }
        }
    }
}

#[test]
fn a_heading_carried_across_an_edge_and_back_is_the_same() {
    for mesh in suite::all() {
        let surface = surface_of(&mesh);
        for halfedge in &surface.halfedges {
            if halfedge.twin == NONE {
                continue;
            }
            let back = surface.halfedges[halfedge.twin as usize];
            let there = DVec2::new(f64::from(halfedge.cos), f64::from(halfedge.sin));
            let again = DVec2::new(f64::from(back.cos), f64::from(back.sin)).rotate(there);
            assert!((again - DVec2::X).length() < 3e-7, "{}", mesh.name);
        }
    }
}

#[test]
fn welding_a_soup_gives_the_indexed_mesh() {
    let folder = tempfile::tempdir().unwrap();
    for mesh in [suite::closed(), suite::open()].concat() {
        let path = folder.path().join("soup.obj");
        std::fs::write(&path, suite::obj_text(&mesh, true)).unwrap();
        let soup = Mesh::load(&path).unwrap();
        assert_eq!(soup.report.file_vertices, 3 * mesh.report.triangles);
        assert_eq!(
            soup.report.summary(),
            mesh.report.summary(),
            "{}",
            mesh.name
        );
        // Files are checked for crossings, meshes in memory are not.
        let read = MeshReport {
            self_crossings: self_crossings(&mesh),
            ..mesh.report.clone()
        };
        assert_eq!(soup.report.oddities(), read.oddities());
        for (ours, theirs) in soup.corners.iter().zip(&mesh.corners) {
            let ours = ours.map(|vertex| soup.positions[vertex as usize]);
            let theirs = theirs.map(|vertex| mesh.positions[vertex as usize]);
            assert_eq!(ours, theirs, "{}", mesh.name);
        }
        let (json, binary) = suite::glb_parts(&mesh);
        let path = folder.path().join("indexed.glb");
        std::fs::write(&path, suite::glb(&json, &binary)).unwrap();
        for glb in [Mesh::load(&path).unwrap(), Mesh::load_raw(&path).unwrap()] {
            assert_eq!(glb.positions, mesh.positions);
            assert_eq!(glb.corners, mesh.corners);
        }
    }
}

#[test]
fn windings_are_mended() {
    let mixed = suite::mixed_cube();
    assert_eq!(mixed.report.mended_triangles, 22);
    assert_eq!(mixed.report.turned_parts, 0);
    assert!(mixed.report.is_closed());
    assert!((volume(&mixed) - 8.0).abs() < 1e-5);

    let inside_out = suite::inside_out();
    assert_eq!(inside_out.report.mended_triangles, 0);
    assert_eq!(inside_out.report.turned_parts, 1);
    assert!((0..inside_out.corners.len() as u32).all(|triangle| inside_out.is_flipped(triangle)));
    assert!(volume(&inside_out) > 3.5);

    // A hollow's wall came facing the hollow, and stays so.
    let hollow = suite::hollow();
    assert_eq!(hollow.report.turned_parts, 0);
    assert!((volume(&hollow) / volume(&inside_out) - 0.875).abs() < 1e-5);
    assert_eq!(hollow.report.oddities(), Vec::<String>::new());
}

/// Would catch: the wall of a cavity that faces outwards, because the whole file was inside out; a solid in a cavity that faces inwards.
#[test]
fn cavities_of_a_file_that_is_inside_out_stay_cavities() {
    let [out, into] = [true, false];
    // How spheres in each other come, and how they end.
    for (come, end) in [
        (&[out, into][..], &[out, into][..]),
        (&[into, out], &[out, into]),
        // Solids in solids.
        (&[out, out, out], &[out, out, out]),
        (&[into, into, into], &[out, out, out]),
        // A solid in a cavity, right and wrong.
        (&[out, into, out], &[out, into, out]),
        (&[into, out, into], &[out, into, out]),
        (&[out, into, into], &[out, into, out]),
        // A cavity in a solid in a solid.
        (&[out, out, into], &[out, out, into]),
        (&[out, into, out, into], &[out, into, out, into]),
        (&[into, out, into, out], &[out, into, out, into]),
    ] {
        let mesh = suite::nested(come);
        let volumes: f64 = (end.iter().enumerate())
            .map(|(k, &out)| if out { 1.0 } else { -1.0 } / 8.0_f64.powi(k as i32))
            .sum();
        let whole = volume(&suite::nested(&[out]));
        assert!((volume(&mesh) / whole - volumes).abs() < 1e-5, "{come:?}");
        let differ = come.iter().zip(end).filter(|(come, end)| come != end);
        assert_eq!(mesh.report.turned_parts, differ.count(), "{come:?}");
    }
}

#[test]
fn one_sided_surfaces_are_cut_once() {
    for segments in [5, 6, 30, 31] {
        let band = suite::moebius(segments);
        // The band is two quads wide, so a straight cut has two edges, and one along diagonals a few more.
        let cut = band.report.cut_edges;
        assert!((2..=4).contains(&cut), "{}: {cut}", band.name);
        assert_eq!(band.report.border_edges, 2 * (segments as usize + cut));
        assert_eq!(band.report.border_loops, 1);
        assert_eq!(band.report.euler_characteristic, 1);
        assert!(band.report.to_string().contains("one-sided"));
    }
}

#[test]
fn of_many_pages_at_an_edge_the_first_two_are_joined() {
    for pages in [3, 4, 5, 7] {
        let book = suite::book(pages);
        let surface = surface_of(&book);
        assert_eq!(book.report.non_manifold_edges, 1);
        assert_eq!(book.report.parts, pages as usize - 1);
        assert_eq!(book.report.border_edges, 4 * pages as usize - 2);
        // The spine is an edge of the first triangle of each page; pages have two triangles.
        let spine = (0..3).find(|&h| {
            surface.halfedges[h].twin != NONE && {
                let twin = surface.halfedges[h].twin / 3;
                twin >= 2
            }
        });
        assert_eq!(surface.halfedges[spine.unwrap()].twin / 3, 2);
    }
    // Pages that came wound the same way are turned until the first two can be joined.
    let page = |x: f32| glam::Vec3::new(x, 1.0, 0.0);
    let positions = [
        glam::Vec3::ZERO,
        glam::Vec3::Y,
        page(1.0),
        page(-1.0),
        page(3.0),
    ];
    let same_way = suite::mesh("same way", &positions, &[[0, 1, 2], [0, 1, 3], [0, 1, 4]]);
    assert_eq!(same_way.report.parts, 2);
    assert_eq!(same_way.report.mended_triangles, 1);
}

#[test]
fn touching_parts_count_as_separate() {
    let bow_tie = suite::bow_tie();
    assert_eq!(bow_tie.report.pinched_vertices, 1);
    assert_eq!(bow_tie.report.vertices, 7);
    assert_eq!(bow_tie.report.parts, 2);
    assert_eq!(bow_tie.report.euler_characteristic, 4);
    assert_eq!(bow_tie.report.genus(), 0);
    assert!(bow_tie.report.is_closed());
}

#[test]
fn slivers_are_as_thin_as_they_should_be() {
    let surface = surface_of(&suite::slivers());
    // The longest edge over the height above it.
    let skewness = |triangle| {
        let frame = Frame::of(&surface, triangle);
        let longest = (0..3).map(|k| frame.edge(k).length()).fold(0.0, f64::max);
        longest * longest / (frame.ab * frame.ch)
    };
    let triangles = 0..surface.triangles.len() as u32;
    let worst = triangles.map(skewness).fold(0.0, f64::max);
    assert!(worst > 3000.0, "{worst}");
}

#[test]
fn what_is_degenerate_is_dropped_and_counted() {
    let positions = [
        DVec3::ZERO,
        DVec3::X,
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::Y,
        // On the way from 0 to 1, and once more the vertex 1, for minus zero is zero.
        0.5 * DVec3::X,
        DVec3::new(1.0, -0.0, 0.0),
        DVec3::splat(f64::NAN),
        7.0 * DVec3::ONE,
    ]
    .map(|position| position.as_vec3());
    let triangles = [
        [0, 1, 2],
        [0, 0, 2], // a corner twice
        [1, 5, 2], // a corner twice, after welding
        [0, 4, 1], // no area
        [2, 0, 1], // there already
        [0, 2, 1], // there already, facing away
        [0, 2, 3],
    ];
    let mesh = suite::mesh("odd square", &positions, &triangles);
    let report = &mesh.report;
    assert_eq!(
        (
            report.repeated_corners,
            report.without_area,
            report.duplicates
        ),
        (2, 1, 2)
    );
    assert_eq!(
        (report.unreferenced_vertices, report.unreferenced_non_finite),
        (2, 1)
    );
    assert_eq!((report.triangles, report.vertices), (2, 4));
    assert_eq!(mesh.file_triangle, [0, 6]);
    assert_eq!(
        report.to_string(),
        "2 triangles, 4 vertices, 4 border edges in 1 loop, genus 0\n  \
         - 2 triangles with a corner twice, dropped\n  \
         - 1 triangle without area, dropped\n  \
         - 2 triangles that are there already, dropped\n  \
         - 2 vertices that no triangle uses, ignored\n  \
         - 1 of the unused vertices is not finite"
    );
    assert_eq!(mesh.point_from_file(3, [0.2, 0.3, 0.5]), None);
    assert_eq!(mesh.point_from_file(7, [0.2, 0.3, 0.5]), None);
}

#[test]
fn a_point_keeps_its_place_through_the_numbering_of_the_file() {
    for mesh in suite::all() {
        for triangle in 0..mesh.report.triangles as u32 {
            let point = SurfacePoint {
                triangle,
                u: 0.25,
                v: 0.125,
            };
            let (face, weights) = mesh.point_to_file(point);
            assert_eq!(mesh.point_from_file(face, weights), Some(point));
            assert_eq!(weights.iter().sum::<f64>(), 1.0);
            let [first, second, third] = mesh.file_corners[triangle as usize].map(usize::from);
            assert_eq!(
                [weights[first], weights[second], weights[third]],
                [0.625, 0.25, 0.125]
            );
        }
    }
    // By hand: the last triangle comes wound against the others, so its corners 1 and 2 change places.
    let positions = suite::mixed_cube().positions;
    let cube = Mesh::builtin("cube?divisions=3").unwrap();
    let mut triangles = cube.corners.clone();
    triangles[4].swap(1, 2);
    let mesh = suite::mesh("one flipped", &positions, &triangles);
    let weights = [0.5, 0.3, 0.2];
    let at = |corners: [u32; 3], weights: [f64; 3]| {
        let corner = |i: usize| weights[i] * positions[corners[i] as usize].as_dvec3();
        corner(0) + corner(1) + corner(2)
    };
    let point = mesh.point_from_file(4, weights).unwrap();
    let ours = at(mesh.corners[4], [1.0 - point.u - point.v, point.u, point.v]);
    assert!(mesh.is_flipped(4));
    assert!((ours - at(triangles[4], weights)).length() < 1e-12);
}

#[test]
fn reports_fit_one_line_when_all_is_well() {
    let torus = Mesh::builtin("torus").unwrap();
    let text = torus.report.to_string();
    assert_eq!(text, "27,648 triangles, 13,824 vertices, closed, genus 1");
    let parts = suite::two_parts();
    let text = parts.report.to_string();
    assert_eq!(
        text,
        "204 triangles, 104 vertices, 2 parts, closed, genus 1"
    );
}

#[test]
fn the_models_that_come_along_load_and_are_what_they_should_be() {
    let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/");
    for (name, summary) in [
        (
            "suzanne",
            "14,842 triangles, 7,503 vertices, 3 parts, 160 border edges in 4 loops, genus 0\n  \
             - 178 pairs of triangles that go through each other: the mesh intersects itself, and walks go on inside of it",
        ),
        (
            "beaded_trefoil",
            "20,210 triangles, 10,105 vertices, closed, genus 1",
        ),
        (
            "gyroid_ball",
            "39,546 triangles, 19,723 vertices, closed, genus 26",
        ),
        (
            "hand_animated",
            "2,314 triangles, 1,159 vertices, closed, genus 0",
        ),
    ] {
        let mesh = Mesh::load(format!("{assets}{name}.glb")).unwrap();
        assert_eq!(mesh.report.to_string(), summary, "{name}");
        surface_of(&mesh).validate().unwrap();
    }
}

/// Two numbers one unit in the last place apart, which times 1.1 are the same float32.
fn one_when_scaled() -> (f32, f32) {
    let near = f32::from_bits(1.9_f32.to_bits() + 1);
    let found = (0..64).find_map(|i| {
        let low = f32::from_bits(near.to_bits() + i);
        let high = f32::from_bits(low.to_bits() + 1);
        (low * 1.1 == high * 1.1).then_some((low, high))
    });
    found.unwrap()
}

#[test]
fn a_sliver_that_a_scale_rounds_away_keeps_its_shape() {
    let (low, high) = one_when_scaled();
    let positions = [
        [0.0, low, 0.0],
        [1.0, low, 0.0],
        [0.5, high, 0.0],
        [0.5, 3.0, 0.0],
    ];
    let positions = positions.map(glam::Vec3::from_array);
    let mesh = suite::mesh("sliver", &positions, &[[0, 1, 2], [0, 2, 3], [2, 1, 3]]);
    let surface = Surface::build(&[(&mesh, 1.1)]);
    assert_eq!(surface.positions[0].y, surface.positions[2].y);
    let area = 1.1 * 1.1 * (f64::from(high) - f64::from(low));
    let Triangle { ab, ch, .. } = surface.triangles[0];
    assert!((f64::from(ab) * f64::from(ch) / area - 1.0).abs() < 1e-5);
    surface.validate().unwrap();
}

#[test]
fn a_triangle_that_a_scale_rounds_to_a_line_or_a_point_has_a_frame() {
    let (low, high) = one_when_scaled();
    let middle = 0.5 * (low + 3.0);
    // A flat one, a needle, and one that is tiny both ways.
    for corners in [
        [[low, low], [3.0, low], [middle, high]],
        [[low, low], [high, low], [low, 3.0]],
        [[low, low], [high, low], [low, high]],
    ] {
        let [a, b, c] = corners.map(|[x, y]| glam::Vec3::new(x, y, 0.5));
        let outer = glam::Vec3::new(2.5, -4.0, 0.5);
        let mesh = suite::mesh("thin", &[a, b, c, outer], &[[0, 1, 2], [1, 0, 3]]);
        let surface = Surface::build(&[(&mesh, 1.1)]);
        surface.validate().unwrap();
        let [a, b, c] = surface.corners[0].map(|i| surface.positions[i as usize].as_dvec3());
        assert!(!Frame::from_corners(a, b, c).has_area());
        let frame = Frame::of(&surface, 0);
        assert!(frame.has_area(), "{frame:?}");
        assert!((frame.p.length() - 1.0).abs() < 1e-12);
        assert!((frame.h.length() - 1.0).abs() < 1e-12);
        assert!(frame.p.dot(frame.h).abs() < 1e-12, "{frame:?}");
        // Walks come through it.
        let start = SurfacePoint {
            triangle: 0,
            u: 0.3,
            v: 0.3,
        };
        for id in 0..16 {
            let heading = DVec2::from_angle(0.1 + f64::from(id));
            let end = walk(&surface, start, heading, 1e-4, None, BorderRule::Reflect);
            assert!(end.point.u.is_finite() && end.heading.is_normalized());
            assert_eq!(end.travelled, 1e-4);
        }
    }
    // Whatever the corners, no NaN.
    let (a, b) = (DVec3::new(0.1, 0.2, 0.3), DVec3::new(1.1, -0.2, 0.3));
    for [a, b, c] in [
        [a, a, a],
        [a, a, b],
        [a, b, a],
        [a, b, b],
        [a, b, 0.5 * (a + b)],
    ] {
        let frame = Frame::from_corners(a, b, c);
        assert!(frame.p.is_normalized() && frame.h.is_normalized() && frame.cp.is_finite());
    }
}

/// Would catch: cells, food and networks of which some take the first of equally heavy texels and others the last.
#[test]
fn a_gutter_texel_stands_for_the_first_of_its_heaviest_sources() {
    let main = |units| Seam::new(9, [5, 6, 7, 8], units).main_source();
    assert_eq!(main([16_384, 16_384, 0, 0]), 5);
    assert_eq!(main([0, 16_384, 0, 16_384]), 6);
    assert_eq!(main([8192; 4]), 5);
    assert_eq!(main([8192, 8192, 8191, 8193]), 8);
}

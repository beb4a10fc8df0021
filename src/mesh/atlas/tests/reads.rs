//! Bilinear reads next to seams.

use std::collections::HashSet;

use glam::{Vec2, Vec3};

use super::*;

fn point_at(surface: &Surface, triangle: u32, u: f32, v: f32) -> Vec3 {
    let [a, b, c] = surface.corners[triangle as usize].map(|i| surface.positions[i as usize]);
    a + u * (b - a) + v * (c - a)
}

/// A trail that has the value of `field` at the centre of every owned texel, with filled gutters.
fn filled(atlas: &Atlas, surface: &Surface, field: impl Fn(Vec3) -> f32) -> Vec<f32> {
    let mut trail = vec![f32::NAN; atlas.texel_count()];
    for texel in 0..atlas.texel_count() as u32 {
        if let Some((t, u, v)) = atlas.surface_point_of(texel) {
            trail[texel as usize] = field(point_at(surface, t, u, v));
        }
    }
    for seam in &atlas.seams {
        trail[seam.texel as usize] = (0..4)
            .map(|k| seam.weights()[k] * trail[seam.source[k] as usize])
            .sum();
    }
    trail
}

/// The bilinear read of the kernels.
fn read(atlas: &Atlas, trail: &[f32], position: Vec2) -> f32 {
    let corner = position - 0.5;
    let low = corner.floor();
    let far = corner - low;
    let texel = low.y as usize * atlas.pitch as usize + low.x as usize;
    let row = |texel: usize| trail[texel] + far.x * (trail[texel + 1] - trail[texel]);
    row(texel) + far.y * (row(texel + atlas.pitch as usize) - row(texel))
}

/// The mean and the largest error of reads all over the triangles, in the longest world length of a texel there; for
/// fields that change by 1 a world unit at the most.
fn read_errors(
    atlas: &Atlas,
    surface: &Surface,
    field: impl Fn(Vec3) -> f32,
    chosen: impl Fn(u32) -> bool,
) -> (f32, f32) {
    let trail = filled(atlas, surface, &field);
    let (mut sum, mut count, mut worst) = (0.0, 0.0, 0.0f32);
    for t in (0..surface.corners.len() as u32).filter(|&t| chosen(t)) {
        let map = atlas.maps[t as usize];
        let shape = surface.triangles[t as usize];
        let texel = (shape.ab / map.du.length())
            .max(shape.cp.hypot(shape.ch) / map.dv.length())
            .max((shape.cp - shape.ab).hypot(shape.ch) / (map.dv - map.du).length());
        for (u, v) in points_of(t) {
            let value = read(atlas, &trail, atlas.position_of(t, u, v));
            let error = (value - field(point_at(surface, t, u, v))).abs() / texel;
            assert!(
                error.is_finite(),
                "triangle {t} at ({u}, {v}) reads {value}"
            );
            worst = worst.max(error);
            sum += error;
            count += 1.0;
        }
    }
    (sum / count, worst)
}

fn linear(p: Vec3) -> f32 {
    p.dot(Vec3::new(0.8, 0.36, -0.48))
}

/// Is a triangle away from all open borders?
fn inner(surface: &Surface) -> impl Fn(u32) -> bool {
    let corners = &surface.corners;
    let border: HashSet<u32> = (0..surface.halfedges.len())
        .filter(|&h| surface.halfedges[h].twin == NONE)
        .flat_map(|h| [corners[h / 3][h % 3], corners[h / 3][(h + 1) % 3]])
        .collect();
    move |t| corners[t as usize].iter().all(|c| !border.contains(c))
}

#[test]
fn constants_stay_constant() {
    for names in [
        ["torus?major=24&minor=16"],
        ["icosphere?subdivisions=3"],
        ["cube"],
    ] {
        let surface = surface(&names);
        let atlas = build(&surface, 500, 2);
        let trail = filled(&atlas, &surface, |_| 1.0);
        for t in 0..surface.corners.len() as u32 {
            for (u, v) in points_of(t) {
                assert_eq!(read(&atlas, &trail, atlas.position_of(t, u, v)), 1.0);
            }
        }
    }
}

#[test]
fn reads_of_a_linear_field_see_no_seam() {
    // On a flat mesh of equal quads nothing but rounding and the maps' margins is lost.
    let plane = surface(&["plane?columns=16&rows=7"]);
    let atlas = build(&plane, 256, 2);
    let (_, worst) = read_errors(&atlas, &plane, linear, inner(&plane));
    assert!(worst < 1e-3, "inside the plane: {worst}");
    // A border mirrors the field: half a texel at the most, along both axes in a corner.
    let (_, worst) = read_errors(&atlas, &plane, linear, |_| true);
    assert!((0.1..0.71).contains(&worst), "at the border: {worst}");
    // Elsewhere the error is that of interpolation at kinks of the field in texels.
    let torus = surface(&["torus?major=48&minor=32"]);
    let icosphere = surface(&["icosphere?subdivisions=3"]);
    let cube = surface(&["cube"]);
    let cases = [
        ("crooked plane", crooked_plane(), 512, 1, 0.015, 0.27),
        ("torus", torus.clone(), 512, 1, 0.010, 0.065),
        ("torus", torus, 512, 3, 0.012, 0.065),
        ("icosphere", icosphere, 512, 2, 0.010, 0.11),
        ("cube", cube, 1000, 1, 0.12, 0.6),
    ];
    for (name, surface, size, gutter, mean_bound, worst_bound) in cases {
        let atlas = build(&surface, size, gutter);
        let (mean, worst) = read_errors(&atlas, &surface, linear, inner(&surface));
        println!("{name} at {size}, gutter {gutter}: mean {mean}, worst {worst} texels");
        assert!(
            mean < mean_bound && worst < worst_bound,
            "{name}: {mean}, {worst}"
        );
    }
}

#[test]
fn open_borders_mirror() {
    let plane = surface(&["plane?columns=1&rows=1"]);
    let atlas = build(&plane, 32, 2);
    for (x, mirrored) in [(0, 3), (1, 2), (30, 29), (31, 28)] {
        for y in [5, 10, 20] {
            for [from, to] in [[[x, y], [mirrored, y]], [[y, x], [y, mirrored]]] {
                let texel = from[1] * atlas.pitch + from[0];
                let seam = atlas.seams.iter().find(|seam| seam.texel == texel);
                let seam = seam.expect("a gutter texel");
                assert_eq!(seam.source[0], to[1] * atlas.pitch + to[0], "{from:?}");
                assert!(seam.weights()[0] > 0.99);
            }
        }
    }
}

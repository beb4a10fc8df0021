//! Layouts by the models' own texture coordinates, good ones and bad ones.

use glam::DVec3;

use super::*;
use crate::mesh::soup::Soup;

fn own(size: u32, gutter: u32) -> AtlasOptions {
    AtlasOptions {
        method: AtlasMethod::Mesh,
        ..options(size, gutter)
    }
}

/// Quads in a row, not connected, each with a rectangle of the unit square: `[left, bottom, right, top]`.
fn quads(rectangles: &[[f32; 4]], flipped: bool) -> Mesh {
    let mut soup = Soup::default();
    let mut uvs = Vec::new();
    for (k, &[left, bottom, right, top]) in rectangles.iter().enumerate() {
        let first = soup.positions.len() as u32;
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            soup.positions.push(DVec3::new(x + 2.0 * k as f64, y, 0.0));
        }
        for corners in [[0, 1, 2], [0, 2, 3]] {
            soup.triangles.push(corners.map(|corner| first + corner));
            uvs.push(corners.map(|corner| {
                let x = if [0, 3].contains(&corner) {
                    left
                } else {
                    right
                };
                let y = if corner < 2 { bottom } else { top };
                Vec2::new(x, if flipped { 1.0 - y } else { y })
            }));
        }
    }
    soup.uvs = Some(uvs);
    Mesh::from_soup("quads", soup).unwrap()
}

fn sound(mesh: &Mesh, options: &AtlasOptions) -> Atlas {
    let surface = Surface::build(&[(mesh, 1.0)]);
    let atlas = Atlas::build(&surface, options).unwrap();
    if let Err(problem) = atlas.validate(&surface) {
        panic!("{atlas}: {problem}");
    }
    atlas
}

#[test]
fn islands_lie_where_the_model_says() {
    for flipped in [false, true] {
        let mesh = quads(&[[0.0, 0.0, 0.4, 0.4], [0.5, 0.5, 1.0, 1.0]], flipped);
        let atlas = sound(&mesh, &own(102, 1));
        assert_eq!(atlas.chart_count, 2);
        assert_eq!(atlas.chart, [0, 0, 1, 1]);
        // The unit square is a gutter inside the texture; triangles run counter-clockwise.
        let place = |x: f32, y: f32| Vec2::new(1.0 + 100.0 * x, 1.0 + 100.0 * y);
        for (t, low, high) in [(0, 0.0, 0.4), (1, 0.0, 0.4), (2, 0.5, 1.0), (3, 0.5, 1.0)] {
            let map = atlas.maps[t];
            assert!(map.du.perp_dot(map.dv) > 0.0);
            for corner in [map.origin, map.origin + map.du, map.origin + map.dv] {
                let (low, high) = (place(low, low), place(high, high));
                let slack = Vec2::splat(0.001);
                assert!(corner.cmpge(low - slack).all() && corner.cmple(high + slack).all());
            }
        }
        // Texels of the smaller island stand for more of the surface.
        let density = |x: u32| atlas.density[(x * atlas.pitch + x) as usize];
        assert!((density(80) / density(20) - 25.0 / 16.0).abs() < 1e-4);
    }
}

#[test]
fn objects_share_the_texture_by_their_areas() {
    let mesh = quads(&[[0.0, 0.0, 1.0, 1.0]], false);
    let surface = Surface::build(&[(&mesh, 1.0), (&mesh, 2.0), (&mesh, 1.0)]);
    let options = AtlasOptions {
        weights: vec![1.0, 1.0, 4.0],
        ..own(500, 2)
    };
    let atlas = Atlas::build(&surface, &options).unwrap();
    atlas.validate(&surface).unwrap();
    assert_eq!(atlas.chart_count, 3);
    let side = |t: usize| atlas.maps[t].du.length();
    assert!(
        (side(2) / side(0) - 2.0).abs() < 0.1,
        "{} {}",
        side(2),
        side(0)
    );
    assert!(
        (side(4) / side(0) - 2.0).abs() < 0.1,
        "{} {}",
        side(4),
        side(0)
    );
    assert!(side(2) > 200.0);
}

#[test]
fn coordinates_that_cannot_be_an_atlas_are_explained() {
    const GOOD: [f32; 4] = [0.0, 0.0, 0.4, 0.4];
    /// The problem, the quads' rectangles, and words that the error must contain.
    type Case = (&'static str, &'static [[f32; 4]], &'static [&'static str]);
    let cases: [Case; 6] = [
        (
            "outside",
            &[GOOD, [0.5, 0.5, 1.2, 0.9]],
            &["triangle 2", "(1.2000, 0.5000)", "outside"],
        ),
        (
            "flat",
            &[GOOD, [0.5, 0.5, 0.5, 0.9]],
            &["triangle 2", "no area"],
        ),
        ("same", &[GOOD, GOOD], &["triangles 0 and 2", "overlap"]),
        ("mirrored", &[GOOD, [0.4, 0.0, 0.0, 0.4]], &["overlap"]),
        ("inside", &[GOOD, [0.1, 0.1, 0.2, 0.2]], &["overlap"]),
        (
            "touching",
            &[GOOD, [0.4, 0.0, 0.8, 0.4]],
            &["too near", "any atlas.size"],
        ),
    ];
    for (name, rectangles, words) in cases {
        let surface = Surface::build(&[(&quads(rectangles, false), 1.0)]);
        let error = Atlas::build(&surface, &own(256, 1))
            .unwrap_err()
            .to_string();
        for word in words.iter().chain(&["object 1", "charts or grid"]) {
            assert!(error.contains(word), "{name}: {error}");
        }
    }
    let cube = surface(&["cube"]);
    let error = Atlas::build(&cube, &own(256, 1)).unwrap_err().to_string();
    assert!(
        error.contains("it has none") && error.contains("charts or grid"),
        "{error}"
    );
}

#[test]
fn sizes_that_were_not_tried_are_about_right() {
    let mesh = quads(&[[0.0, 0.0, 0.4999, 1.0], [0.5001, 0.0, 1.0, 1.0]], false);
    let surface = Surface::build(&[(&mesh, 1.0)]);
    let error = Atlas::build(&surface, &own(100, 1)).unwrap_err();
    let text = error.to_string();
    let AtlasError::OwnUvsTooDense { needed, tried, .. } = error else {
        panic!("{text}");
    };
    assert!((10_000..12_000).contains(&needed) && !tried, "{text}");
    assert!(
        text.ends_with(&format!("raise atlas.size to about {needed}")),
        "{text}"
    );
}

#[test]
fn the_object_that_has_no_square_is_named() {
    let mesh = quads(&[[0.0, 0.0, 1.0, 1.0]], false);
    let surface = Surface::build(&[(&mesh, 1.0), (&mesh, 0.001), (&mesh, 1.0)]);
    let error = Atlas::build(&surface, &own(60, 2)).unwrap_err().to_string();
    assert!(
        error.contains("coordinates of object 2 leave too little room")
            && error.contains("its square has no texel inside the gutter"),
        "{error}"
    );
}

#[test]
fn islands_without_room_name_a_size_that_works() {
    let mesh = quads(&[[0.0, 0.0, 0.495, 1.0], [0.505, 0.0, 1.0, 1.0]], false);
    let surface = Surface::build(&[(&mesh, 1.0)]);
    for gutter in [1, 2, 4] {
        for size in [3, 20, 100] {
            let error = Atlas::build(&surface, &own(size, gutter)).unwrap_err();
            let AtlasError::OwnUvsTooDense { needed, .. } = error else {
                panic!("{error}");
            };
            assert!(error.to_string().contains(&needed.to_string()));
            sound(&mesh, &own(needed, gutter));
            // Two gutters need this; a little more for rounding.
            let bound = 2 * gutter * 100;
            assert!(
                (bound..bound + bound / 10 + 10).contains(&needed),
                "{gutter} at {size}: {needed}"
            );
        }
    }
}

//! The layout of planes whose opposite sides are glued.

use super::exchange::conductances;
use super::*;

/// By `charts`.
fn laid_out(surface: &Surface, size: u32, gutter: u32) -> Atlas {
    let options = AtlasOptions {
        size,
        gutter,
        ..AtlasOptions::default()
    };
    let atlas = Atlas::build(surface, &options).unwrap();
    if let Err(problem) = atlas.validate(surface) {
        panic!("{atlas}: {problem}");
    }
    atlas
}

/// Catches sides that are cut or turned, texels of unequal area or out of line, and a neighbour over a side or a corner that is another one
/// than on a torus, or weaker than inside.
#[test]
fn a_periodic_plane_has_so_many_equal_texels_each_with_eight_neighbours() {
    for (name, size, gutter, scale) in [
        ("plane?periodic=true", 200, 1, 1.0),
        // Vertices between texels, and triangles smaller than texels.
        ("plane?periodic=true&columns=7&rows=3", 50, 1, 0.3),
        ("plane?periodic=true&columns=90&rows=1", 33, 3, 1.0),
        ("plane?periodic=true&columns=1&rows=1", 16, 2, 5.0),
    ] {
        let mesh = Mesh::builtin(name).unwrap();
        let surface = Surface::build(&[(&mesh, scale)]);
        let atlas = laid_out(&surface, size, gutter);
        assert_eq!(atlas.owned_count, size * size, "{name}");
        assert_eq!(atlas.size, size + 2 * gutter, "{name}");
        assert_eq!(atlas.chart_count, 1);
        let texel = |x: u32, y: u32| {
            let [x, y] = [x, y].map(|k| k % size + gutter);
            y * atlas.pitch + x
        };
        let place = |x: u32, y: u32| {
            let (t, u, v) = atlas.surface_point_of(texel(x, y)).expect("it is owned");
            let [a, b, c] = surface.corners[t as usize].map(|i| surface.positions[i as usize]);
            a + u * (b - a) + v * (c - a)
        };
        let first = texel(0, 0) as usize;
        let side = 2.0 * scale / size as f32;
        let origin = place(0, 0);
        let (right, down) = (place(1, 0) - origin, place(0, 1) - origin);
        for way in [right, down] {
            let along = way.abs().max_element();
            assert!((along / side - 1.0).abs() < 1e-3, "{name}: {way}");
            assert!((way.length() / side - 1.0).abs() < 1e-3, "{name}: {way}");
        }
        for y in 0..size {
            for x in 0..size {
                let at = texel(x, y) as usize;
                assert_eq!(atlas.area[at], atlas.area[first], "{name}: {x}, {y}");
                assert_eq!(atlas.density[at], atlas.density[first]);
                let expected = origin + x as f32 * right + y as f32 * down;
                let off = place(x, y).distance(expected) / side;
                // Steps add up what a single one is rounded by.
                assert!(off < 0.05, "{name}: {x}, {y} is {off} texels off");
            }
        }
        assert!((atlas.density[first] - 1.0).abs() < 1e-6);
        let all = conductances(&atlas);
        assert_eq!(all.len() as u32, 8 * size * size, "{name}");
        for y in 0..size {
            for x in 0..size {
                for (i, j) in (0..9).map(|k| (k % 3, k / 3)).filter(|&at| at != (1, 1)) {
                    let taps = |k: u32, way: u32| k + size + way * gutter - gutter;
                    let other = texel(taps(x, i), taps(y, j));
                    assert_eq!(
                        all.get(&(texel(x, y), other)),
                        Some(&(1.0 / 9.0)),
                        "{name}: {x}, {y} to {i}, {j}"
                    );
                }
            }
        }
    }
}

/// Catches a torus that is seen where there is none, and one that is not seen: only a square with glued opposite sides, alone and by
/// `charts`, is laid out so. All others have seams that exchange.
#[test]
fn other_glued_surfaces_have_seams() {
    let plane = Mesh::builtin("plane?columns=6&rows=6&periodic=true").unwrap();
    let cube = Mesh::builtin("cube").unwrap();
    let bordered = Mesh::builtin("plane?columns=6&rows=6").unwrap();
    // Two opposite sides only: a band, whose two others are open.
    let pairs: Vec<[u32; 4]> = (0..6).map(|j| [12 * j, 0, 12 * j + 11, 1]).collect();
    let band = bordered.clone().glued(&pairs).unwrap();
    // Neighbouring sides: low X with low Z.
    let pairs: Vec<[u32; 4]> = (0..6).map(|k| [12 * k, 0, 2 * k + 1, 2]).collect();
    let folded = bordered.glued(&pairs).unwrap();
    let of = |meshes: &[&Mesh]| {
        let scaled: Vec<(&Mesh, f32)> = meshes.iter().map(|mesh| (*mesh, 1.0)).collect();
        Surface::build(&scaled)
    };
    for (what, surface) in [
        ("two objects", of(&[&plane, &cube])),
        ("a band", of(&[&band])),
        ("a fold", of(&[&folded])),
    ] {
        let atlas = laid_out(&surface, 128, 1);
        assert_eq!(atlas.size, 128, "{what}");
        let seams = atlas.statistics(&surface).seam_edges;
        assert!(seams >= 6, "{what}: {seams}");
        super::exchange::check(what, &atlas);
        assert_eq!(build(&surface, 300, 1).size, 300, "{what}");
    }
    let alone = of(&[&plane]);
    let turned = AtlasOptions {
        size: 128,
        turn: 3,
        ..AtlasOptions::default()
    };
    assert_eq!(Atlas::build(&alone, &turned).unwrap().size, 128);
    let flat = laid_out(&alone, 128, 1);
    assert_eq!((flat.size, flat.owned_count), (130, 128 * 128));
    // By `grid`, each quad has a cell.
    let cells = build(&alone, 128, 1);
    assert_eq!((cells.size, cells.chart_count), (128, 36));
    super::exchange::check("cells of a periodic plane", &cells);
}

#[test]
fn a_gutter_beyond_the_largest_texture_is_refused() {
    let plane = Mesh::builtin("plane?columns=1&rows=1&periodic=true").unwrap();
    let surface = Surface::build(&[(&plane, 1.0)]);
    let options = AtlasOptions {
        size: MAX_SIZE,
        gutter: 2,
        ..AtlasOptions::default()
    };
    let message = Atlas::build(&surface, &options).unwrap_err().to_string();
    assert!(message.contains("choose 32764 at most"), "{message}");
}

//! Exchanges of texels when the trail spreads.

use std::collections::{HashMap, HashSet};

use glam::{DVec2, DVec3, Mat2, Vec2};

use super::super::conductances::Layers;
use super::super::gutter::Way;
use super::*;

/// Conductance of each pair of texels, as both sides see it.
pub(super) fn conductances(atlas: &Atlas) -> HashMap<(u32, u32), f32> {
    let offsets = ExchangeRow::neighbours(atlas.pitch, atlas.taps);
    let mut found = HashMap::new();
    let mut add =
        |from: u32, to: u32, weight: f32| *found.entry((from, to)).or_insert(0.0) += weight;
    let mut rows = atlas.exchange.rows.iter().peekable();
    for texel in (0..atlas.texel_count() as u32).filter(|&t| atlas.owner[t as usize] != NONE) {
        let Some(row) = rows.next_if(|row| row.texel == texel) else {
            let limit = (GREATEST_DENSITY / atlas.density[texel as usize]).min(1.0);
            for offset in offsets {
                add(texel, (i64::from(texel) + offset) as u32, limit / 9.0);
            }
            continue;
        };
        for (bit, offset) in offsets.iter().enumerate() {
            if row.mask() >> bit & 1 == 1 {
                add(texel, (i64::from(texel) + offset) as u32, row.conductance);
            }
        }
        for pair in atlas.exchange.pairs(row) {
            add(texel, pair.texel, pair.weight);
        }
    }
    assert!(rows.next().is_none(), "rows are in order");
    found
}

pub(super) fn check(what: &str, atlas: &Atlas) {
    let all = conductances(atlas);
    let mut given = vec![0.0f32; atlas.texel_count()];
    for (&(from, to), &weight) in &all {
        assert!(weight > 0.0 && from != to, "{what}: {from} to {to}");
        let back = all.get(&(to, from)).copied().unwrap_or(0.0);
        // Texels without a row are limited on the device: up to its rounding.
        assert!(
            (weight - back).abs() <= 2e-7 * weight,
            "{what}: {from} to {to} {weight}, back {back}"
        );
        given[from as usize] += weight * atlas.density[from as usize];
    }
    for (texel, &given) in given.iter().enumerate() {
        let share = GREATEST_DIFFUSION * given;
        assert!(
            share <= 0.950_01,
            "{what}: texel {texel} gives away {share}"
        );
        // No owned texel is isolated.
        assert_eq!(
            given > 0.0,
            atlas.owner[texel] != NONE,
            "{what}: texel {texel}"
        );
    }
}

#[test]
fn pairs_exchange_symmetrically_and_no_texel_gives_more_than_it_has() {
    let crooked = build(&crooked_plane(), 300, 1);
    check("crooked plane", &crooked);
    for (name, size, distance) in [
        ("cube", 64, 1),
        ("cube", 101, 3),
        ("torus?major=24&minor=16", 300, 1),
        ("torus?major=24&minor=16", 256, 2),
        ("icosphere?subdivisions=3", 301, 1),
        // Cells with very few texels.
        ("icosphere?subdivisions=3", 110, 1),
        ("capsule?segments=9&rings=3", 200, 4),
    ] {
        check(name, &build(&surface(&[name]), size, distance));
    }
    // Texels of very different areas.
    let cube = Mesh::builtin("cube").unwrap();
    let small = Mesh::builtin("torus?major=12&minor=8").unwrap();
    let surface = Surface::build(&[(&cube, 1.0), (&small, 0.02)]);
    check("cube and small torus", &build(&surface, 200, 1));
}

/// Two charts on a strip of texels, `ABBB` beside `CCCC`, whose gutters read two texels each.
#[test]
fn a_seam_exchanges_what_both_sides_would_read() {
    let (pitch, rows) = (16u32, 5u32);
    let texel = |x: u32, y: u32| y * pitch + x;
    let mut owner = vec![NONE; (pitch * rows) as usize];
    let mut seams = Vec::new();
    for y in 1..4 {
        for x in 1..5 {
            owner[texel(x, y) as usize] = 0;
            owner[texel(x + 6, y) as usize] = 1;
        }
        // Three quarters of the way to the next texel.
        let read = |at, near, next| {
            let (a, b) = (texel(near, y), texel(next, y));
            Seam::new(texel(at, y), [a, b, a, a], [8192, 24_576, 0, 0])
        };
        seams.push(read(5, 7, 8));
        seams.push(read(6, 4, 3));
    }
    let density: Vec<f32> = owner
        .iter()
        .map(|&t| if t == NONE { 0.0 } else { 1.0 })
        .collect();
    let deposited = vec![true; seams.len()];
    // The relative position of the charts is unknown, so conductances stay as they were read.
    let unknown = Way {
        position: Vec2::ZERO,
        chart: NONE,
        back: Mat2::ZERO,
        border: Vec2::ZERO,
    };
    let ways = vec![unknown; seams.len()];
    let layers = Layers {
        owner: &owner,
        chart: &[0, 1],
        density: &density,
        whole: &[1.0, 1.0],
        seams: &seams,
        ways: &ways,
        deposited: &deposited,
        is_plain: false,
        pitch,
        distance: 1,
        offsets: ExchangeRow::neighbours(pitch, 1),
    };
    let exchange = layers
        .conductances(&Control::default())
        .unwrap()
        .tables(&layers);
    let row = |x, y| {
        let found = exchange.rows.iter().find(|row| row.texel == texel(x, y));
        found.expect("it has a row")
    };
    // In the middle of its side: three gutter texels, a quarter of each from the nearest.
    let beside = row(4, 2);
    assert_eq!(beside.mask(), 0b0110_1011);
    let pairs: HashMap<u32, f32> = exchange
        .pairs(beside)
        .iter()
        .map(|pair| (pair.texel, 9.0 * pair.weight))
        .collect();
    // (x, y) reads a quarter of each of the nearest texels and three quarters of the next, and they read as much of it;
    // the next column does not read it, for that has no gutter texel beside it.
    for y in 1..4 {
        assert!((pairs[&texel(7, y)] - 0.25).abs() < 1e-6, "{pairs:?}");
        assert!((pairs[&texel(8, y)] - 0.375).abs() < 1e-6, "{pairs:?}");
    }
    assert_eq!(pairs.len(), 6);
    // Inside its chart, yet read from across the seam: all neighbours and the pairs on top.
    let behind = row(8, 2);
    assert_eq!((behind.mask(), behind.pair_count), (0xff, 3));
    // Deposits on gutter texels.
    assert_eq!(
        exchange.deposits(beside),
        [ExchangeEntry {
            texel: texel(6, 2),
            weight: 0.25
        }]
    );
    assert_eq!(
        exchange.deposits(behind),
        [ExchangeEntry {
            texel: texel(5, 2),
            weight: 0.75
        }]
    );
}

/// How far the pairs beside a cube's edges are from keeping linear fields, and from the right rate of spreading: root mean squares over
/// texels beside seams of the first moments, and of the errors of second ones, in texels.
fn errors_of_moments(size: u32, turn: u64) -> (f64, f64) {
    let surface = surface(&["cube"]);
    let options = AtlasOptions {
        size,
        turn,
        ..AtlasOptions::default()
    };
    let atlas = Atlas::build(&surface, &options).unwrap();
    let edge = atlas.mean_texel_area.sqrt();
    let place = |texel: u32| {
        let (t, u, v) = atlas.surface_point_of(texel).unwrap();
        let corners = surface.corners[t as usize].map(|i| surface.positions[i as usize].as_dvec3());
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize().round();
        (a + f64::from(u) * (b - a) + f64::from(v) * (c - a), normal)
    };
    // In the plane of the first: the face of the second is turned about the edge between them.
    let way = |from: (DVec3, DVec3), to: (DVec3, DVec3)| {
        let (x, y) = from.1.any_orthonormal_pair();
        let mut step = to.0 - from.0;
        if from.1 != to.1 {
            step += (from.0 - to.0).dot(from.1) * to.1;
        }
        DVec2::new(step.dot(x), step.dot(y)) / edge
    };
    let mut sums: HashMap<u32, (DVec2, [f64; 3])> = HashMap::new();
    for ((from, to), weight) in conductances(&atlas) {
        let d = way(place(from), place(to));
        let weight = f64::from(weight);
        let sum = sums.entry(from).or_default();
        sum.0 += weight * d;
        for (sum, part) in sum.1.iter_mut().zip([d.x * d.x, d.y * d.y, d.x * d.y]) {
            *sum += weight * part;
        }
    }
    let (mut first, mut second, mut count) = (0.0, 0.0, 0.0);
    for row in atlas.exchange.rows.iter().filter(|row| row.mask() != 0xff) {
        // Around a corner of the cube the way to a texel is not unique.
        let (at, _) = place(row.texel);
        if at.abs().min_element() > 1.0 - 6.0 * edge {
            continue;
        }
        let (one, two) = sums[&row.texel];
        let wanted = 2.0 / 3.0 / f64::from(atlas.density[row.texel as usize]);
        first += one.length_squared();
        second += (two[0] - wanted).powi(2) + (two[1] - wanted).powi(2) + 2.0 * two[2].powi(2);
        count += 1.0;
    }
    assert!(count > 500.0);
    ((first / count).sqrt(), (second / count).sqrt())
}

/// Would catch: taps as far apart as the gutter is wide, with which blocks leave out rows of texels, and texels exchange with others than
/// their neighbours.
#[test]
fn taps_may_be_nearer_than_the_gutter_is_wide() {
    let surface = surface(&["torus?major=24&minor=16"]);
    let cases = [
        (AtlasMethod::Grid, 1),
        (AtlasMethod::Grid, 3),
        (AtlasMethod::Charts, 1),
        (AtlasMethod::Charts, 2),
    ];
    for (method, taps) in cases {
        let what = format!("{method:?}, taps {taps} apart");
        let options = AtlasOptions {
            method,
            taps,
            ..options(400, 4)
        };
        let atlas = Atlas::build(&surface, &options).unwrap();
        atlas.validate(&surface).unwrap();
        assert_eq!((atlas.gutter, atlas.taps), (4, taps), "{what}");
        check(&what, &atlas);
        let reach = taps * atlas.pitch / 4;
        let quads = atlas.blocks.iter().flat_map(|&block| {
            let rows = (0..BLOCK_ROWS).map(move |row| block + row * reach);
            rows.flat_map(|first| first..first + BLOCK_QUADS)
        });
        let quads: HashSet<u32> = quads.collect();
        let owned = (0..atlas.texel_count() as u32).filter(|&t| atlas.owner[t as usize] != NONE);
        for texel in owned.chain(atlas.seams.iter().map(|seam| seam.texel)) {
            assert!(quads.contains(&(texel / 4)), "{what}: texel {texel}");
        }
    }
    let checked = |taps| {
        let options = AtlasOptions {
            taps,
            ..options(64, 2)
        };
        options.checked(&surface).unwrap().taps
    };
    assert_eq!([0, 1, 2, 3].map(checked), [2, 1, 2, 2]);
}

#[test]
fn linear_fields_are_nearly_steady_beside_seams() {
    for turn in [0, 1, 3] {
        let (first, second) = errors_of_moments(256, turn);
        println!("turn {turn}: {first}, {second}");
        assert!(first < 0.02, "turn {turn}: {first}");
        assert!(second < 0.06, "turn {turn}: {second}");
    }
}

#[test]
fn texels_inside_charts_need_no_row() {
    let atlas = build(&surface(&["cube"]), 512, 1);
    let side = atlas.cell_size as usize - 2;
    // Two rings of texels along each side of six squares take part; all others are plain.
    let most = 6 * (side * side - (side - 6) * (side - 6));
    assert!(
        atlas.exchange.rows.len() <= most,
        "{} of {most}",
        atlas.exchange.rows.len()
    );
    assert!(atlas.exchange.rows.len() >= 6 * 4 * (side - 1));
    let used: Vec<u32> = (0..atlas.texel_count() as u32)
        .filter(|&t| {
            atlas.owner[t as usize] != NONE || atlas.seams.iter().any(|seam| seam.texel == t)
        })
        .map(|t| {
            let (row, column) = (t / atlas.pitch, t % atlas.pitch);
            let across = column / 4 / BLOCK_QUADS * BLOCK_QUADS;
            row / BLOCK_ROWS * BLOCK_ROWS * (atlas.pitch / 4) + across
        })
        .collect();
    let mut expected = used.clone();
    expected.sort_unstable();
    expected.dedup();
    assert_eq!(atlas.pitch % (4 * BLOCK_QUADS), 0);
    assert_eq!(atlas.blocks, expected);
}

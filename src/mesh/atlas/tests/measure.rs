//! Results of packing the built-in meshes: a table and pictures. Run by hand.

use std::time::Instant;

use super::*;
use crate::mesh::atlas::{cache, charts, gutter, owners, place};

/// `cargo test --release --lib atlas::tests::measure -- --ignored --nocapture`, with `SIZE`, `GUTTER`, `MESHES` and
/// `PICTURES` in the environment.
#[test]
#[ignore = "measures"]
fn packing_of_the_built_in_meshes() {
    let number = |name: &str, default: u32| {
        std::env::var(name).map_or(default, |text| text.parse().unwrap())
    };
    let (size, gutter) = (number("SIZE", 1024), number("GUTTER", 1));
    let names = std::env::var("MESHES")
        .unwrap_or_else(|_| "cube;torus;icosphere;plane;capsule;suzanne;trefoil;gyroid".to_owned());
    println!("mesh, triangles, charts, utilisation, s cutting, s packing, s deriving, s gutter");
    for name in names.split(';') {
        let surface = surface(&name.split('+').collect::<Vec<_>>());
        let options = AtlasOptions {
            method: AtlasMethod::Charts,
            ..options(size, gutter)
        };
        let control = Control::default();
        let start = Instant::now();
        let flat = charts::flat_charts(&surface, &control).unwrap();
        let cutting = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let (maps, chart, chart_count): cache::Places =
            place::place(&surface, flat, &options, &control).unwrap();
        let packing = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let layout =
            owners::derive(&surface, maps, chart, chart_count, &options, &control).unwrap();
        let deriving = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let (seams, ways) = gutter::seams(&surface, &layout, pitch_of(size), &control).unwrap();
        let filling = start.elapsed().as_secs_f64();
        let atlas =
            Atlas::assemble(&surface, &options, layout, seams, (&ways, false), &control).unwrap();
        let area: f64 = atlas
            .maps
            .iter()
            .map(|map| 0.5 * f64::from(map.du.perp_dot(map.dv).abs()))
            .sum();
        println!(
            "{name}, {}, {chart_count}, {:.4}, {cutting:.3}, {packing:.3}, {deriving:.3}, {filling:.3}",
            surface.corners.len(),
            area / f64::from(size).powi(2),
        );
        if let Ok(folder) = std::env::var("PICTURES") {
            picture(&atlas)
                .save(format!("{folder}/pack-{name}.png"))
                .unwrap();
        }
        atlas.validate(&surface).unwrap();
    }
}

/// Charts coloured, gutter grey, what is empty black.
fn picture(atlas: &Atlas) -> image::RgbImage {
    image::RgbImage::from_fn(atlas.size, atlas.size, |x, y| {
        let texel = y * atlas.pitch + x;
        let owner = atlas.owner[texel as usize];
        if owner != NONE {
            let words = random(1, atlas.chart[owner as usize], 0, Purpose::Start);
            image::Rgb([words[0], words[1], words[2]].map(|word| 60 + (word % 190) as u8))
        } else if atlas
            .gutter_texels
            .binary_search_by_key(&texel, |g| g.texel)
            .is_ok()
        {
            image::Rgb([90; 3])
        } else {
            image::Rgb([0; 3])
        }
    })
}

//! Tests of straight lines in the texture that end in the chart in which they begin.

use super::*;

/// The largest distance of a line from the nearest texel centre of its chart, texels; up to 4.
fn beside(atlas: &Atlas, chart: u32, from: Vec2, to: Vec2) -> f32 {
    let pitch = atlas.pitch as i32;
    let pieces = (4.0 * from.distance(to)).ceil();
    let points = (0..=pieces as u32).map(|i| from + (to - from) * (i as f32 / pieces.max(1.0)));
    let far = points.map(|point| {
        let at = point.as_ivec2();
        let around = (-4..=4).flat_map(|y| (-4..=4).map(move |x| at + glam::IVec2::new(x, y)));
        let inside = around.filter(|p| p.min_element() >= 0 && p.max_element() < atlas.size as i32);
        let texels = inside.map(|p| (p.y * pitch + p.x) as u32);
        let owned = texels.filter(|&texel| atlas.owner[texel as usize] != NONE);
        let own = owned.filter(|&texel| atlas.chart[atlas.owner[texel as usize] as usize] == chart);
        let distances = own.map(|texel| atlas.centre_of(texel).distance(point));
        distances.fold(4.0, f32::min)
    });
    far.fold(0.0, f32::max)
}

/// Tests lines from anywhere in a texel to anywhere in texels within its outlook; and the outlook contains most of the texels that a
/// straight line reaches.
#[test]
fn texels_in_the_outlook_are_reached_by_straight_lines() {
    for (names, method, size) in [
        (
            &["torus?major=24&minor=16", "cube"][..],
            AtlasMethod::Charts,
            160,
        ),
        (&["icosphere?subdivisions=2"], AtlasMethod::Charts, 97),
        (&["suzanne"], AtlasMethod::Charts, 256),
        (&["plane?columns=3&rows=2", "cube"], AtlasMethod::Grid, 128),
        // Cells of two texels.
        (&["torus?major=24&minor=16"], AtlasMethod::Charts, 1540),
    ] {
        let surface = surface(names);
        let options = AtlasOptions {
            method,
            ..options(size, 1)
        };
        let atlas = Atlas::build(&surface, &options).unwrap();
        let clearances = atlas.clearances(&surface);
        let Outlooks { hues, distances } = atlas.outlooks(&surface, &clearances);
        let cell = size.div_ceil(1536) as f32;
        assert_eq!(atlas.outlook_unit(), 0.5 * cell);
        assert_eq!(hues.len(), atlas.texel_count());
        let chart_of = |texel: usize| {
            (atlas.owner[texel] != NONE).then(|| atlas.chart[atlas.owner[texel] as usize])
        };
        let (pitch, side) = (atlas.pitch as i32, size as i32);
        let (mut reached, mut in_outlook) = (0_u32, 0_u32);
        for (texel, (&hue, &distance)) in hues.iter().zip(&distances).enumerate() {
            let Some(chart) = chart_of(texel) else {
                assert_eq!((hue, distance), (0, 0));
                continue;
            };
            assert!((1..=31).contains(&hue), "{hue}");
            let outlook = atlas.outlook_unit() * f32::from(distance);
            assert!(outlook + atlas.outlook_unit() > CLEARANCE_UNIT * f32::from(clearances[texel]));
            let stride = (hues.len() / 300).max(1) | 1;
            if texel % stride != 0 {
                continue;
            }
            let centre = atlas.centre_of(texel as u32);
            let at = [texel as i32 % pitch, texel as i32 / pitch];
            let reach = (outlook.min(24.0 * cell) as i32).max(8);
            let step = if cell > 1.0 { 7 } else { 2 };
            for y in ((at[1] - reach).max(0)..=(at[1] + reach).min(side - 1)).step_by(step) {
                for x in ((at[0] - reach).max(0)..=(at[0] + reach).min(side - 1)).step_by(step) {
                    let other = (y * pitch + x) as usize;
                    let there = atlas.centre_of(other as u32);
                    let way = there.distance(centre);
                    if hues[other] != hue || way > reach as f32 {
                        continue;
                    }
                    let is_same = chart_of(other) == Some(chart);
                    let far = if is_same {
                        beside(&atlas, chart, centre, there)
                    } else {
                        f32::INFINITY
                    };
                    // From anywhere in the one texel to anywhere in the other.
                    if (way - 1.4).max(0.0) <= outlook {
                        assert!(
                            far < 3.0 * cell,
                            "{names:?}: {far} beside the chart from {centre} to {there}, {way} of {outlook}"
                        );
                    }
                    if is_same && way <= 8.0 && far < 0.8 {
                        reached += 1;
                        in_outlook += u32::from(
                            way <= outlook.max(atlas.outlook_unit() * f32::from(distances[other])),
                        );
                    }
                }
            }
        }
        let share = f64::from(in_outlook) / f64::from(reached);
        println!("{names:?} {size}: {share:.3} of what lines of 8 texels get to is in an outlook");
        assert!(share > 0.85, "{names:?}: {share}");
    }
}

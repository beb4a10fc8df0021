//! Texels of dabs, on shapes whose areas are known.

use super::*;
use crate::scene::Scene;
use crate::scene::settings::{AtlasMethod, ObjectSettings};

fn setup(meshes: &[(&str, [f32; 3])]) -> Setup {
    setup_by(AtlasMethod::Charts, meshes)
}

fn setup_by(method: AtlasMethod, meshes: &[(&str, [f32; 3])]) -> Setup {
    let mut settings = Settings::default();
    settings.particles.count = 100;
    settings.atlas.method = method;
    settings.atlas.size = 512;
    settings.objects = (meshes.iter())
        .map(|(mesh, position)| ObjectSettings {
            mesh: format!("builtin:{mesh}"),
            position: position.map(f64::from),
            ..ObjectSettings::default()
        })
        .collect();
    let scene = Scene::from_settings("brush".to_owned(), settings, ".".into()).unwrap();
    Setup::new(&scene).unwrap()
}

fn dab(brush: Brush, center: Vec3, radius: f32) -> Dab {
    Dab {
        brush,
        center,
        radius,
        eye: None,
        ring: None,
        number: 3,
    }
}

/// The sum of weights times areas is that of a disc, wherever it lies on the surface.
fn area_under(setup: &Setup, dab: &Dab) -> f64 {
    let texels = dab.texels(setup, &setup.poses).unwrap();
    let area = |texel: &DabTexel| {
        f64::from(texel.weight) * setup.atlas.mean_texel_area
            / f64::from(setup.atlas.density[texel.texel as usize])
    };
    texels.iter().map(area).sum()
}

/// Would catch: a ball whose middle is scaled and whose radius is not.
#[test]
fn a_dab_on_a_scaled_object_is_one_of_another_size_on_the_object() {
    let setup = setup(&[("icosphere", [0.5, 0.0, 0.0]), ("cube", [-2.0, 0.0, 0.0])]);
    let brush = Brush::Trail { amount: 1.0 };
    let ring = |center: Vec3, radius: f32, eye: Vec3| Dab {
        eye: Some(eye),
        ring: Some(Ring {
            eye,
            normal: Vec3::Z,
            balls: [Some(Ball {
                center: center - 2.0 * radius * Vec3::Z,
                radius,
                looks: u32::MAX,
            }); MOST_DEPTHS],
        }),
        ..dab(brush, center, radius)
    };
    let origin = DAffine3::from(&setup.poses[0]).translation.as_vec3();
    let [center, eye] = [0.9, 4.0].map(|z| origin + z * Vec3::Z);
    let as_it_is = ring(center, 0.25, eye);
    let twice = |place: Vec3| origin + 2.0 * (place - origin);
    let as_shown = ring(twice(center), 0.5, twice(eye));
    let shown = as_shown.texels_on_scaled(&setup, &setup.poses, &[2.0]);
    let texels = as_it_is.texels(&setup, &setup.poses).unwrap();
    assert!(texels.len() > 50, "{}", texels.len());
    let named = |texels: &[DabTexel]| texels.iter().map(|texel| texel.texel).collect::<Vec<_>>();
    let shown = shown.unwrap();
    assert_eq!(named(&shown), named(&texels));
    for (shown, as_it_is) in shown.iter().zip(&texels) {
        assert!((shown.weight - as_it_is.weight).abs() < 1e-4);
    }
    // The other one is as large as it is.
    let beside = dab(brush, Vec3::new(-2.0, 0.0, 0.0), 1.5);
    let texels = beside.texels(&setup, &setup.poses).unwrap();
    let shown = beside
        .texels_on_scaled(&setup, &setup.poses, &[0.5])
        .unwrap();
    assert_eq!(shown, texels);
    for factor in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let error = as_shown.texels_on_scaled(&setup, &setup.poses, &[factor]);
        let message = error.expect_err("it is no size").to_string();
        assert!(
            message.contains("choose a factor greater than 0"),
            "{message}"
        );
    }
}

#[test]
fn a_dab_has_the_area_of_its_disc_also_over_seams_and_edges() {
    let setup = setup(&[("cube?divisions=6", [0.0; 3])]);
    let corner = setup
        .surface
        .positions
        .iter()
        .map(|p| p.x)
        .fold(0.0, f32::max);
    let radius = 0.3 * corner;
    let r = f64::from(radius);
    let disc = std::f64::consts::PI * r * r / 3.0;
    let middle = dab(
        Brush::Trail { amount: 1.0 },
        Vec3::new(corner, 0.0, 0.0),
        radius,
    );
    let area = area_under(&setup, &middle);
    assert!((area / disc - 1.0).abs() < 0.02, "{area}, not {disc}");
    // Half a disc on either side of an edge.
    let edge = Dab {
        center: Vec3::new(corner, corner, 0.1),
        ..middle
    };
    let area = area_under(&setup, &edge);
    assert!((area / disc - 1.0).abs() < 0.04, "{area}, not {disc}");
    // Above the surface the ball cuts out less.
    let above = Dab {
        center: Vec3::new(corner + 0.9 * radius, 0.0, 0.0),
        ..middle
    };
    assert!(area_under(&setup, &above) < 0.1 * disc);
    let hard = Dab {
        brush: Brush::NoGo,
        ..middle
    };
    let area = area_under(&setup, &hard);
    assert!((area / (3.0 * disc) - 1.0).abs() < 0.03, "to its edge");
}

#[test]
fn what_turns_away_from_the_eye_is_left_out() {
    let setup = setup(&[("cube?divisions=6", [0.0; 3])]);
    let corner = setup
        .surface
        .positions
        .iter()
        .map(|p| p.x)
        .fold(0.0, f32::max);
    let all = dab(Brush::Trail { amount: 1.0 }, Vec3::ZERO, 3.0 * corner);
    let all_texels = all.texels(&setup, &setup.poses).unwrap();
    assert_eq!(all_texels.len(), setup.atlas.owned_count as usize);
    let seen = Dab {
        eye: Some(Vec3::new(10.0 * corner, 0.0, 0.0)),
        ..all
    };
    let seen = seen.texels(&setup, &setup.poses).unwrap();
    let share = seen.len() as f64 / all_texels.len() as f64;
    assert!(
        (share - 1.0 / 6.0).abs() < 0.01,
        "one face of six, not {share}"
    );
    let mut texels: Vec<u32> = all_texels.iter().map(|texel| texel.texel).collect();
    texels.sort_unstable();
    texels.dedup();
    assert_eq!(texels.len(), all_texels.len(), "each texel once");
}

/// Would alone catch: a plane with glued sides that is painted from its front only, as if it had an inside. By `grid`, both planes have the
/// same texels.
#[test]
fn a_periodic_plane_is_painted_from_below_as_one_with_borders() {
    let [periodic, bordered] = ["&periodic=true", ""].map(|end| {
        let mesh = format!("plane?columns=2&rows=2{end}");
        let setup = setup_by(AtlasMethod::Grid, &[(mesh.as_str(), [0.0; 3])]);
        [-4.0, 4.0].map(|height| {
            let seen = Dab {
                eye: Some(Vec3::new(0.0, height, 0.0)),
                ..dab(Brush::Trail { amount: 1.0 }, Vec3::ZERO, 0.3)
            };
            seen.texels(&setup, &setup.poses).unwrap().len()
        })
    });
    assert!(periodic[1] > 1000, "{periodic:?}");
    assert_eq!(periodic[0], periodic[1], "from below and from above");
    assert_eq!(periodic, bordered);
}

#[test]
fn places_lie_on_the_objects_that_the_dab_touches() {
    let setup = setup(&[
        ("cube", [0.0; 3]),
        ("icosphere?subdivisions=3", [9.0, 0.0, 0.0]),
    ]);
    let corner = setup.surface.positions[0].abs().max_element();
    let brush = Brush::Particles { share: 0.5 };
    let dab = dab(brush, Vec3::new(0.0, corner, 0.0), 0.4 * corner);
    let texels = dab.texels(&setup, &setup.poses).unwrap();
    let painted = Painted::of(&texels, 2);
    assert!(
        painted.texels[0] > 100 && painted.texels[1] == 0,
        "{painted:?}"
    );
    let Places { places, ranges } = dab.places(&setup, &texels, 7);
    assert_eq!(ranges, [UVec2::new(0, PLACES), UVec2::new(PLACES, 0)]);
    for place in &places {
        let corners = setup.surface.corners[place.triangle as usize];
        let [a, b, c] = corners.map(|vertex| setup.surface.positions[vertex as usize]);
        let at = a + place.u * (b - a) + place.v * (c - a);
        // A place lies in a texel whose centre is in the ball.
        let slack = setup.atlas.mean_texel_area.sqrt() as f32;
        assert!(at.distance(dab.center) < dab.radius + slack, "{at}");
        assert!(place.u >= 0.0 && place.v >= 0.0 && place.u + place.v <= 1.0);
    }
}

#[test]
fn numbers_out_of_range_are_refused_with_their_range() {
    let good = dab(Brush::Trail { amount: 1.0 }, Vec3::ZERO, 1.0);
    assert!(good.check().is_ok());
    let message = |dab: Dab| dab.check().unwrap_err().to_string();
    let brush = |brush| Dab { brush, ..good };
    assert!(message(brush(Brush::Trail { amount: -1.0 })).contains("choose 0 to 1000000"));
    assert!(message(brush(Brush::Attract { amount: f32::NAN })).contains("an attraction = NaN"));
    assert!(message(brush(Brush::Erase { share: 1.5 })).contains("a share = 1.5: choose 0 to 1"));
    assert!(message(brush(Brush::Particles { share: -0.1 })).contains("share of particles"));
    assert!(
        message(Dab {
            radius: 0.0,
            ..good
        })
        .contains("a radius = 0")
    );
    assert!(
        message(Dab {
            center: Vec3::NAN,
            ..good
        })
        .contains("finite place")
    );
}

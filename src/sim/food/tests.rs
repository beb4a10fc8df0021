//! Food on the host: meals, plates, places, and amounts that are kept.

use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use super::*;
use crate::scene::Scene;
use crate::scene::settings::{FoodSettings, ObjectSettings, Settings};
use crate::sim::carry::carried;
use crate::sim::setup::Setup;
use crate::sim::twin;

fn place(amount: u32) -> FoodPlace {
    FoodPlace {
        object: 0,
        point: SurfacePoint {
            triangle: 0,
            u: 0.3,
            v: 0.3,
        },
        radius: 2.0,
        strength: 8.0,
        size: 0.1,
        amount,
        projection: 0.0,
    }
}

#[test]
fn smells_fall_with_the_way_and_with_what_is_left() {
    let whole = place(1000);
    assert_eq!(
        [0.0, 1.0, 2.0, 3.0].map(|d| whole.falloff(d)),
        [1.0, 0.25, 0.0, 0.0]
    );
    let scent = |left| whole.meal(Some(left)).scent;
    assert_eq!(
        [1000, 500, 1, 0].map(scent),
        [8.0, 4.0, 8.0 / LEVELS as f32, 0.0]
    );
    assert_eq!(whole.meal(Some(5000)).remaining, 1000, "no more than all");
    let endless = place(0).meal(Some(0));
    assert_eq!((endless.remaining, endless.scent), (1, 8.0));
    let most = place(MOST_AMOUNT).meal(None);
    assert_eq!((most.remaining, most.level), (MOST_AMOUNT, LEVELS));
}

fn settings(objects: &[&str], foods: &[(&str, [f32; 3], u32)]) -> Settings {
    let mut settings = Settings::default();
    settings.particles.count = 500;
    settings.atlas.size = 128;
    settings.radius = 1.0;
    settings.objects = (objects.iter().enumerate())
        .map(|(i, name)| ObjectSettings {
            name: (*name).to_owned(),
            mesh: "builtin:icosphere?subdivisions=2".to_owned(),
            position: [2.5 * i as f64, 0.0, 0.0],
            scale: 1.0,
            ..ObjectSettings::default()
        })
        .collect();
    settings.foods = (foods.iter())
        .map(|(object, at, amount)| FoodSettings {
            object: (*object).to_owned(),
            at: at.map(f64::from),
            amount: *amount,
            size: 0.3,
            ..FoodSettings::default()
        })
        .collect();
    settings
}

fn setup(settings: &Settings) -> Result<Setup> {
    let scene = Scene::from_settings("food".to_owned(), settings.clone(), ".".into());
    Setup::new(&scene.unwrap())
}

const X: [f32; 3] = [1.0, 0.0, 0.0];
const Y: [f32; 3] = [0.0, 1.0, 0.0];

#[test]
fn food_lies_where_its_object_is_nearest() {
    let far = settings(&["ball"], &[("ball", [0.0, 9.0, 0.0], 5)]);
    let problem = setup(&far).map(|_| ()).unwrap_err().to_string();
    assert!(problem.contains("food.0.at is 8.0"), "{problem}");
    assert!(problem.contains("away from ball"), "{problem}");
    assert!(
        problem.contains("the nearest place on it is ["),
        "{problem}"
    );
    // Coordinates are those of the mesh, so a scale moves the food, too.
    let mut scaled = settings(&["ball", "moon"], &[("moon", Y, 5)]);
    scaled.objects[1].scale = 0.5;
    scaled.objects[1].rotation = [90.0, 0.0, 0.0];
    let setup = setup(&scaled).unwrap();
    let mark = setup.food_set.marks[0];
    assert_eq!(mark.object, 1);
    assert!(mark.position.distance(glam::Vec3::new(0.0, 0.5, 0.0)) < 0.02);
    assert!(mark.normal.y > 0.9 && mark.is_food == 1);
}

/// If discs overlap, the nearer food is eaten; gutters equal the texels behind them.
#[test]
fn plates_are_of_the_nearest_food() {
    let near = [0.98, 0.2, 0.0];
    let setup = setup(&settings(&["ball"], &[("ball", X, 0), ("ball", near, 0)])).unwrap();
    let FoodSet { plates, places, .. } = &setup.food_set;
    let distances = places
        .iter()
        .map(|place| SurfaceDistance::new(&setup.surface, &[place.point], 1.0));
    let distances: Vec<_> = distances.collect();
    let mut counts = [0; 3];
    for (texel, plate) in plates.iter().enumerate() {
        let Some((triangle, u, v)) = setup.atlas.surface_point_of(texel as u32) else {
            continue;
        };
        let [a, b] = [0, 1].map(|i: usize| distances[i].at(triangle, u.into(), v.into()));
        if (a - b).abs() < 1e-5 || (a.min(b) - 0.3).abs() < 1e-5 {
            continue;
        }
        let expected = match (a.min(b) < 0.3, a < b) {
            (false, _) => 0,
            (true, true) => 1,
            (true, false) => 2,
        };
        assert_eq!(*plate, expected, "{a}, {b}");
        counts[expected as usize] += 1;
    }
    assert!(counts[1] > 50 && counts[2] > 50, "{counts:?}");
    for seam in &setup.atlas.seams {
        let behind = seam.source.map(|texel| plates[texel as usize]);
        assert!(behind.contains(&plates[seam.texel as usize]));
    }
}

/// Would catch: food that is projected at texels of gutters, twice at a texel, or at none because it is smaller than a texel or a marker;
/// and food without a projection that takes texels from food with one.
#[test]
fn food_is_projected_at_owned_texels_of_the_nearest() {
    let near = [0.98, 0.2, 0.0];
    let foods = [("ball", X, 0), ("ball", near, 0), ("ball", Y, 0)];
    let mut settings = settings(&["ball"], &foods);
    settings.foods[0].projection = 1.0;
    settings.foods[1].projection = 2.0;
    settings.foods[2].projection = 3.0;
    settings.foods[2].size = 0.0;
    let of = |settings: &Settings| {
        let setup = setup(settings).unwrap();
        let FoodSet {
            projected, plates, ..
        } = &setup.food_set;
        let mut counts = [0; 3];
        for (i, entry) in projected.iter().enumerate() {
            assert!(i == 0 || projected[i - 1].x < entry.x, "each texel once");
            assert!(setup.atlas.density[entry.x as usize] > 0.0);
            counts[entry.y as usize] += 1;
        }
        let owned = plates.iter().zip(&setup.atlas.density);
        let owned = owned.filter(|(plate, density)| **plate > 0 && **density > 0.0);
        let mut eaten = [0; 3];
        for (plate, _) in owned {
            eaten[*plate as usize - 1] += 1;
        }
        (counts, eaten)
    };
    let (counts, eaten) = of(&settings);
    assert_eq!((counts[2], eaten[2]), (1, 0), "a marker has one");
    assert_eq!(counts[..2], eaten[..2], "as they are eaten");
    settings.foods[1].projection = 0.0;
    let (alone, _) = of(&settings);
    assert_eq!((alone[1], alone[2]), (0, 1));
    assert!(alone[0] > counts[0], "{alone:?}, {counts:?}");
    settings.foods[0].projection = 0.0;
    settings.foods[2].projection = 0.0;
    assert_eq!(of(&settings).0, [0; 3]);
}

/// Would alone catch: food beside a glued side that is not smelled, eaten or projected beyond it. Distances are those of a flat torus; with
/// borders they are those of the plane, and nothing is beyond.
#[test]
fn food_reaches_over_glued_sides() {
    for is_periodic in [true, false] {
        let mut settings = settings(&["plane"], &[("plane", [0.95, 0.0, 0.1], 0)]);
        settings.objects[0].mesh = format!("builtin:plane?columns=8&rows=8&periodic={is_periodic}");
        settings.foods[0].radius = 0.5;
        settings.foods[0].projection = 1.0;
        let setup = setup(&settings).unwrap();
        let (surface, food_set) = (&setup.surface, &setup.food_set);
        let FoodPlace { radius, size, .. } = food_set.places[0];
        let is_in = |list: &[UVec2], texel: u32| list.binary_search_by_key(&texel, |entry| entry.x);
        let smelled = &food_set.scented[..food_set.scented_count() as usize];
        let mut beyond = [0; 3];
        for texel in 0..setup.atlas.owner.len() as u32 {
            let Some((triangle, u, v)) = setup.atlas.surface_point_of(texel) else {
                continue;
            };
            let [a, b, c] = surface.corners[triangle as usize]
                .map(|vertex| surface.positions[vertex as usize].as_dvec3());
            let at = a + f64::from(u) * (b - a) + f64::from(v) * (c - a);
            let mut way = at - DVec3::new(0.95, 0.0, 0.1);
            if is_periodic {
                way -= 2.0 * (0.5 * way).round();
            }
            let distance = way.length();
            if (distance - size).abs() < 1e-4 || (distance - radius).abs() < 1e-4 {
                continue;
            }
            let found = [
                is_in(smelled, texel).is_ok(),
                food_set.plates[texel as usize] == 1,
                is_in(&food_set.projected, texel).is_ok(),
            ];
            let expected = [distance < radius, distance < size, distance < size];
            assert_eq!(found, expected, "{at}: {distance}");
            if at.x < 0.0 {
                for (count, is_found) in beyond.iter_mut().zip(found) {
                    *count += u32::from(is_found);
                }
            }
        }
        assert!(
            beyond
                .iter()
                .all(|count| (*count > 300) == is_periodic && (*count > 0) == is_periodic),
            "{beyond:?}"
        );
    }
}

#[test]
fn food_that_moves_keeps_what_is_left() {
    let foods = [("ball", X, 50), ("ball", Y, 60)];
    let before = setup(&settings(&["ball"], &foods)).unwrap();
    let z = [0.0, 0.0, 1.0];
    let kept = |foods: &[(&str, [f32; 3], u32)]| {
        let (surface, atlas) = (&before.surface, &before.atlas);
        let places = places(
            &settings(&["ball"], foods),
            surface,
            &before.origins,
            before.radius,
        )
        .unwrap();
        let control = Control::default();
        let food_set = FoodSet::new(surface, atlas, places, None, &control).unwrap();
        food_set.kept(&before.food_set, &[10, 20])
    };
    assert_eq!(kept(&[("ball", z, 50), foods[1]]), [10, 20]);
    assert_eq!(kept(&[foods[0], ("ball", z, 60)]), [10, 20]);
    // Other food was added, or several were removed: it is unknown which one moved.
    assert_eq!(kept(&[("ball", z, 51), foods[1]]), [51, 20]);
    assert_eq!(
        kept(&[("ball", z, 50), ("ball", [0.0, 0.0, -1.0], 60)]),
        [50, 60]
    );
    assert_eq!(kept(&[foods[1], ("ball", z, 50)]), [20, 50]);
    assert_eq!(kept(&[foods[0], foods[1], ("ball", z, 50)]), [10, 20, 50]);
    assert_eq!(kept(&[foods[1]]), [20]);
}

#[test]
fn what_stays_is_not_measured_again_and_keeps_what_is_left() {
    let before = setup(&settings(&["ball"], &[("ball", X, 50), ("ball", Y, 60)])).unwrap();
    let after = settings(
        &["ball"],
        &[
            ("ball", Y, 60),
            ("ball", [0.0, 0.0, 1.0], 7),
            ("ball", X, 51),
        ],
    );
    let places = places(&after, &before.surface, &before.origins, before.radius).unwrap();
    let control = Control::default();
    let (surface, atlas) = (&before.surface, &before.atlas);
    let food_set = FoodSet::new(surface, atlas, places, Some(&before.food_set), &control).unwrap();
    assert!(Arc::ptr_eq(
        &food_set.reached[0],
        &before.food_set.reached[1]
    ));
    assert!(Arc::ptr_eq(
        &food_set.reached[2],
        &before.food_set.reached[0]
    ));
    // A food with another amount is another food.
    assert_eq!(food_set.kept(&before.food_set, &[10, 20]), [20, 7, 51]);
    // The result equals that of measuring all of them.
    let again = FoodSet::new(surface, atlas, food_set.places.clone(), None, &control).unwrap();
    assert!(again.scented == food_set.scented && again.falloffs == food_set.falloffs);
    assert!(again.plates == food_set.plates);
}

/// When objects are added and removed, the food of the others keeps its remaining amount.
#[test]
fn food_is_carried_over_with_its_object() {
    let both = settings(&["ball", "moon"], &[("ball", X, 50), ("moon", Y, 60)]);
    let mut twin = twin::Simulation::new(setup(&both).unwrap(), both.clone());
    for _ in 0..30 {
        twin.step();
    }
    let state = twin.snapshot();
    let left = state.food.remaining.clone();
    assert!(left[0] < 50 && left[1] < 60, "{left:?}");
    let mut alone = settings(&["moon"], &[("moon", Y, 60), ("moon", X, 9)]);
    alone.objects[0].position = both.objects[1].position;
    let new = setup(&alone).unwrap();
    let moved = carried(&state, twin.setup(), &new, &[Some(1)]).unwrap();
    assert_eq!(moved.food.remaining, [left[1], 9]);
    moved.validate(&new).unwrap();
    let mut goes_on = twin::Simulation::new(new, alone);
    goes_on.restore(&moved);
    goes_on.step();
    goes_on.snapshot().validate(goes_on.setup()).unwrap();
}

/// Measuring distances to food reports its progress, and ends when it is cancelled.
#[test]
fn measuring_reports_progress_and_can_be_cancelled() {
    let scene = settings(
        &["ball"],
        &[("ball", X, 0), ("ball", Y, 0), ("ball", [0.0, 0.0, 1.0], 0)],
    );
    let setup = setup(&scene).unwrap();
    let (surface, atlas, food_set) = (&setup.surface, &setup.atlas, &setup.food_set);
    let run = |stop_at: f32| {
        let shares = Mutex::new(Vec::new());
        let stop = AtomicBool::new(false);
        let progress = |doing: &'static str, share: f32| {
            assert_eq!(doing, MEASURING);
            shares.lock().unwrap().push(share);
            if share >= stop_at {
                stop.store(true, Ordering::Relaxed);
            }
        };
        let control = Control {
            progress: Some(&progress),
            cancelled: Some(&stop),
            cache: None,
        };
        let found = FoodSet::new(surface, atlas, food_set.places.clone(), None, &control);
        (found, shares.into_inner().unwrap())
    };
    let (found, shares) = run(2.0);
    assert!(found.unwrap().plates == food_set.plates);
    assert!(
        shares.iter().all(|share| (0.0..=1.001).contains(share)),
        "{shares:?}"
    );
    assert!(shares.iter().any(|share| *share > 0.999), "{shares:?}");
    for stop_at in [0.0, 0.3, 0.9] {
        let (found, _) = run(stop_at);
        let error = found.map(|_| ()).unwrap_err();
        assert!(
            matches!(error, Error::Atlas(AtlasError::Cancelled)),
            "{error}"
        );
    }
}

//! The places of a scene's foods and markers, both named and scattered ones.

use glam::{DVec3, Vec3};

use super::FoodPlace;
use crate::error::{Error, Result};
use crate::mesh::surface::Surface;
use crate::mesh::walk::SurfacePoint;
use crate::rng::{Purpose, random, seed_word};
use crate::scene::motion::Origins;
use crate::scene::settings::{FoodSettings, Settings};
use crate::sim::start::{AreaTable, nearest_point, share, uniform_in_triangle};

/// The number of places that scattered food is chosen from. It is constant, so that the first foods keep their places when there are more.
const CANDIDATES: u32 = 4096;

/// Every food and marker of a scene: first the named ones, then the scattered ones.
///
/// # Errors
/// When a named one is farther from its object than it reaches.
pub fn places(
    settings: &Settings,
    surface: &Surface,
    origins: &[Origins],
    radius: f32,
) -> Result<Vec<FoodPlace>> {
    let named = settings.foods.iter().enumerate();
    let mut places: Vec<FoodPlace> = named
        .map(|(i, food)| named_place(i, food, settings, surface, origins, radius))
        .collect::<Result<_>>()?;
    places.extend(scattered(settings, surface, radius));
    Ok(places)
}

fn named_place(
    i: usize,
    food: &FoodSettings,
    settings: &Settings,
    surface: &Surface,
    origins: &[Origins],
    radius: f32,
) -> Result<FoodPlace> {
    let object = settings.object_of(food).ok_or_else(|| {
        Error::Invalid(format!(
            "food.{i}.object: there is no object \"{}\"",
            food.object
        ))
    })?;
    let scale = settings.objects[object].scale;
    let at = origins[object].from_file(food.at, scale);
    let (point, nearest) = nearest_on_object(surface, at, object as u32);
    let off = nearest.distance(at.as_dvec3());
    let length = |share: f32| f64::from(share * radius);
    let place = FoodPlace {
        object: object as u32,
        point,
        radius: length(food.radius),
        strength: food.strength,
        size: length(food.size),
        amount: food.amount,
        projection: food.projection,
    };
    if off > place.reach() {
        let [x, y, z] = origins[object].to_file(nearest, scale).to_array();
        return Err(Error::Invalid(format!(
            "food.{i}.at is {:.3} scene radii away from {}, farther than the food reaches: \
             the nearest place on it is [{x:.4}, {y:.4}, {z:.4}]",
            off / f64::from(radius),
            settings.objects[object].name
        )));
    }
    Ok(place)
}

/// The surface point of an object that is nearest to a place in its space, scaled; and where that is.
#[must_use]
pub fn nearest_on_object(surface: &Surface, at: Vec3, object: u32) -> (SurfacePoint, DVec3) {
    let all = vec![at; surface.objects.len()];
    let point = nearest_point(surface, &all, Some(object));
    let [a, b, c] = surface.corners[point.triangle as usize]
        .map(|vertex| surface.positions[vertex as usize].as_dvec3());
    (point, a + point.u * (b - a) + point.v * (c - a))
}

/// Foods scattered over all objects, each as far as possible from earlier ones on its object, independent of the objects' poses.
fn scattered(settings: &Settings, surface: &Surface, radius: f32) -> Vec<FoodPlace> {
    let feeding = &settings.feeding;
    if feeding.scattered == 0 {
        return Vec::new();
    }
    let areas = AreaTable::new(surface, None);
    let candidates: Vec<(SurfacePoint, Vec3)> = (0..CANDIDATES)
        .map(|i| {
            let words = random(seed_word(settings.seed), i, 0, Purpose::Food);
            let triangle = areas.triangle_at(share(words));
            let (u, v) = uniform_in_triangle(words);
            let [a, b, c] =
                surface.corners[triangle as usize].map(|vertex| surface.positions[vertex as usize]);
            let place = a + u * (b - a) + v * (c - a);
            let (u, v) = (u.into(), v.into());
            (SurfacePoint { triangle, u, v }, place)
        })
        .collect();
    let object_of = |point: &SurfacePoint| surface.triangles[point.triangle as usize].object;
    let mut apart = vec![f32::INFINITY; candidates.len()];
    let length = |share: f32| f64::from(share * radius);
    (0..feeding.scattered)
        .map(|_| {
            let farthest = (0..candidates.len()).max_by(|&a, &b| apart[a].total_cmp(&apart[b]));
            let (point, place) = candidates[farthest.unwrap_or(0)];
            let object = object_of(&point);
            for (apart, (other, there)) in apart.iter_mut().zip(&candidates) {
                if object_of(other) == object {
                    *apart = apart.min(place.distance_squared(*there));
                }
            }
            FoodPlace {
                object,
                point,
                radius: length(feeding.radius),
                strength: feeding.strength,
                size: length(feeding.size),
                amount: feeding.amount,
                projection: feeding.projection,
            }
        })
        .collect()
}

//! Objects and foods that come, go or are copied, in settings, and where they stand.

use crate::lab::stage::Stage;
use crate::lab::tools::handles::shift;
use glam::Vec3;
use myxo::render::Camera;
use myxo::scene::settings::{ObjectSettings, Settings, Start};
use std::path::Path;

/// A new object's radius, as a share of the scene's.
pub const NEW_OBJECT: f32 = 0.4;
/// From the others to its middle, as a share of its radius.
const APART: f32 = 1.1;
/// Between an object and its copy, as a share of the radius of a ball round it.
const GAP: f32 = 0.25;

/// The settings with one object more.
pub fn with_object(settings: &Settings, mesh: &str, scale: f32, position: [f64; 3]) -> Settings {
    let mut settings = settings.clone();
    settings.objects.push(ObjectSettings {
        mesh: mesh.to_owned(),
        position,
        scale,
        ..Default::default()
    });
    settings
}

/// The settings without an object; others no longer ask for their distance to it, and particles do not begin on it.
pub fn without_object(settings: &Settings, object: usize) -> Settings {
    let mut settings = settings.clone();
    let gone = settings.objects.remove(object);
    for other in &mut settings.objects {
        // An empty list means distances to all other objects.
        other.distance_to.retain(|name| *name != gone.name);
    }
    if settings.particles.start_object == gone.name {
        settings.particles.start_object.clear();
    }
    for food in (0..settings.foods.len()).rev() {
        if settings.foods[food].object == gone.name {
            remove_food(&mut settings, food);
        }
    }
    settings
}

/// The settings with a copy of an object, which stands a way off at this time, and moves as the original does.
pub fn with_copy(settings: &Settings, object: usize, way: Vec3, time: f64) -> Settings {
    let mut settings = settings.clone();
    let mut copy = settings.objects[object].clone();
    copy.name = name_of_copy(&settings.objects, &copy.name);
    shift(&mut copy, time, way.as_dvec3(), settings.radius);
    settings.objects.push(copy);
    settings
}

/// `ball 2` of `ball`, and of `ball 2` the next number that no object has.
pub fn name_of_copy(objects: &[ObjectSettings], name: &str) -> String {
    let is_number = |word: &str| !word.is_empty() && word.bytes().all(|c| c.is_ascii_digit());
    let stem = match name.rsplit_once(' ') {
        Some((stem, number)) if is_number(number) => stem,
        _ => name,
    };
    let is_free = |name: &String| objects.iter().all(|object| object.name != *name);
    let mut names = (2..).map(|number| format!("{stem} {number}"));
    names
        .find(is_free)
        .expect("there are more numbers than objects")
}

/// The middle of a ball of this radius that stands at the right side of these places, as the camera sees them.
pub fn beside(camera: &Camera, points: impl IntoIterator<Item = Vec3>, radius: f32) -> Vec3 {
    let (least, most) = seen_from(camera, points);
    let middle = 0.5 * (least + most);
    in_world(
        camera,
        Vec3::new(most.x + APART * radius, middle.y, middle.z),
    )
}

/// The way that takes an object of these to a place beside it, as the camera sees them: at a side where no other stands, or if
/// there is none, at the right of all. An object that `moves` gets room to turn.
pub fn way_beside(camera: &Camera, objects: &[Vec<Vec3>], object: usize, moves: bool) -> Vec3 {
    let own = &objects[object];
    let (least, most) = seen_from(camera, own.iter().copied());
    let center = 0.5 * (least + most);
    let middle = in_world(camera, center);
    let radius = own.iter().map(|place| place.distance(middle));
    let radius = radius.fold(0.0, f32::max);
    let size = most - least;
    let others = objects.iter().enumerate();
    let others = others.filter(|(other, places)| *other != object && !places.is_empty());
    let boxes: Vec<(Vec3, Vec3)> = others
        .map(|(_, places)| seen_from(camera, places.iter().copied()))
        .collect();
    let is_free = |there: &Vec3| {
        let mut boxes = boxes.iter();
        boxes.all(|(least, most)| there.distance(there.clamp(*least, *most)) > radius)
    };
    let sides = [(Vec3::X, size.x), (Vec3::Y, size.y)];
    let mut places = sides.into_iter().flat_map(|(axis, size)| {
        let far = if moves { 2.0 * radius } else { size } + GAP * radius;
        [1.0, -1.0].map(|side| center + side * far * axis)
    });
    let free = places.find(is_free).map(|there| in_world(camera, there));
    let all = || objects.iter().flatten().copied();
    free.unwrap_or_else(|| beside(camera, all(), radius)) - middle
}

/// The corners of a box round these places whose axes are right, up and towards the camera.
pub fn seen_from(camera: &Camera, places: impl IntoIterator<Item = Vec3>) -> (Vec3, Vec3) {
    let axes = [camera.right(), camera.up(), camera.backward()];
    let mut least = Vec3::MAX;
    let mut most = Vec3::MIN;
    for place in places {
        let seen = Vec3::from(axes.map(|axis| axis.dot(place)));
        (least, most) = (least.min(seen), most.max(seen));
    }
    (least, most)
}

/// The place with these coordinates along the camera's axes, in the world.
pub fn in_world(camera: &Camera, seen: Vec3) -> Vec3 {
    seen.x * camera.right() + seen.y * camera.up() + seen.z * camera.backward()
}

/// The vertices of every object, in the world.
pub fn places_of(stage: &Stage) -> Vec<Vec<Vec3>> {
    let surface = &stage.scene.surface;
    let poses = stage.simulation.world_from_object();
    let objects = surface.objects.iter().zip(&poses);
    objects
        .map(|(range, pose)| {
            let own = range.vertices.0 as usize..range.vertices.1 as usize;
            let own = surface.positions[own].iter();
            own.map(|place| pose.transform_point3(*place)).collect()
        })
        .collect()
}

/// The name of a mesh in messages.
pub fn short_name(mesh: &str) -> &str {
    let builtin = mesh.strip_prefix("builtin:");
    let file = || Path::new(mesh).file_name().and_then(|name| name.to_str());
    builtin.or_else(file).unwrap_or(mesh)
}

/// Lets particles that begin on a food begin on an existing one; without food they begin as by default.
pub fn begin_on_food_that_is(settings: &mut Settings) {
    let count = settings.food_count() as u32;
    let particles = &mut settings.particles;
    if particles.start != Start::Food {
        return;
    }
    if count == 0 {
        particles.start = Start::default();
    }
    particles.start_food = particles.start_food.min(count.saturating_sub(1));
}

/// Removes a food. Particles that begin on a later food still do; if they begin on this one, they begin on the food that takes
/// its index.
pub fn remove_food(settings: &mut Settings, food: usize) {
    settings.foods.remove(food);
    let start = &mut settings.particles.start_food;
    if settings.particles.start == Start::Food && *start as usize > food {
        *start -= 1;
    }
    begin_on_food_that_is(settings);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_meshes_by_short_names() {
        for (mesh, name) in [
            ("builtin:cube", "cube"),
            ("/home/me/top.obj", "top.obj"),
            ("top.obj", "top.obj"),
        ] {
            assert_eq!(short_name(mesh), name);
        }
    }

    #[test]
    fn a_new_object_stands_beside_the_others() {
        let camera = Camera::default();
        let radius = 0.4;
        let others = [Vec3::splat(-1.0), Vec3::new(0.5, 1.0, 2.0), 2.0 * Vec3::X];
        let place = beside(&camera, others, radius);
        for other in others {
            let apart = (place - other).dot(camera.right());
            assert!(apart > radius, "{place} covers {other}");
        }
        let up = |place: Vec3| place.dot(camera.up());
        let highest = others.map(up).into_iter().fold(f32::MIN, f32::max);
        let lowest = others.map(up).into_iter().fold(f32::MAX, f32::min);
        assert!((up(place) - 0.5 * (highest + lowest)).abs() < 1e-4);
    }

    #[test]
    fn a_copy_stands_beside_its_original_and_in_no_other_object() {
        let camera = Camera::default();
        let right = camera.right();
        let corners = |middle: Vec3| -> Vec<Vec3> {
            let corners = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32 - 0.5));
            corners.map(|corner| middle + Vec3::from(corner)).collect()
        };
        let cube = corners(Vec3::ZERO);
        let alone = [cube.clone()];
        for moves in [false, true] {
            let way = way_beside(&camera, &alone, 0, moves);
            assert!(way.dot(right) > 0.99 * way.length(), "{way}");
            let own = cube.iter().map(|place| (*place + way).dot(right));
            let most = cube.iter().map(|place| place.dot(right));
            let (least, most) = (own.fold(f32::MAX, f32::min), most.fold(f32::MIN, f32::max));
            assert!(least > most, "{least} is beyond {most}");
            // However it turns.
            let diagonal = 3_f32.sqrt();
            assert!(!moves || way.length() > diagonal, "{way}");
        }
        // Others stand at its sides, one after the other.
        let mut objects = vec![cube.clone()];
        let mut taken: Vec<Vec3> = Vec::new();
        for count in 1..=5 {
            let way = way_beside(&camera, &objects, 0, false);
            for other in &taken {
                assert!(way.distance(*other) > 1.0, "{count}: {way} is in {other}");
            }
            taken.push(way);
            objects.push(corners(way));
        }
        // It does not stand in the middle of a large object either, far from all of its corners.
        let hall = corners(Vec3::ZERO).into_iter();
        let hall = hall.map(|corner| in_world(&camera, 6.0 * corner + 4.3 * Vec3::X));
        let way = way_beside(&camera, &[cube.clone(), hall.collect()], 0, false);
        assert!(way.dot(right) < -0.5, "{way}");
        // A flat object seen from its edge has its copy elsewhere, too.
        let flat: Vec<Vec3> = (cube.iter())
            .map(|place| *place - place.dot(right) * right)
            .collect();
        assert!(way_beside(&camera, &[flat], 0, false).length() > 0.1);
    }
}

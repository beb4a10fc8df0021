//! The view of a picture: camera, drawn things, colours and brightness.

use glam::{Vec2, Vec3};

use super::camera::{Camera, MAX_PITCH};
use super::colormap::linear_from_srgb;
use super::exposure::Exposure;
use crate::scene::Scene;
use crate::scene::settings::{
    CameraSettings, ColorMap, Drawn, PictureSettings, Show, USUAL_BACKGROUND,
};

/// A level ground under a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// World units, along the scene's up axis.
    pub height: f32,
    /// The middle of the scene.
    pub middle: Vec3,
    /// About half of the scene's width, world units.
    pub radius: f32,
}

impl Ground {
    /// The ground that touches the lowest of some points from below; none without points.
    #[must_use]
    pub fn under(points: impl Iterator<Item = Vec3>, middle: Vec3, radius: f32) -> Option<Self> {
        let height = points.map(|point| point.y).fold(f32::INFINITY, f32::min);
        height.is_finite().then_some(Self {
            height,
            middle,
            radius,
        })
    }
}

/// Everything that a picture depends on besides the simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// What is drawn.
    pub show: Show,
    /// Colours of the trail.
    pub color_map: ColorMap,
    /// Colours of the trail where there is a second look; none take those of the first.
    pub second_colors: Option<ColorMap>,
    /// The exposure of the trail.
    pub exposure: Exposure,
    /// Share of the brightest trail up to which everything has the darkest colour, 0 to below 1.
    pub darkest: f32,
    /// Diameter of a drawn particle, pixels.
    pub particle_size: f32,
    /// The most particles that are drawn; of more, every second is, or every third, and so on.
    pub most_particles: u32,
    /// Behind the objects, in sRGB, 0 to 1.
    pub background: Vec3,
    /// Is there nothing behind the objects? Pictures have premultiplied alpha then. The unwrapped atlas always fills its picture.
    pub is_transparent: bool,
    /// The strength of the atlas's charts, in their own colours: 0 hides them, 0.5 shows them under the trail, 1 shows only them.
    pub charts: f32,
    /// Is it drawn without bloom, and are jagged edges left, so that it takes less time?
    pub is_plain: bool,
    /// The part of the atlas that is shown.
    pub atlas: AtlasWindow,
    /// The direction of the light.
    pub light: Light,
    /// The strength of ambient occlusion, 0 to 1.
    pub occlusion: f32,
    /// How strongly bright trail shines beyond its edges, 0 to 4.
    pub bloom: f32,
    /// How wet the surface is, 0 to 1: its reflections, and the height of the trail.
    pub wetness: f32,
    /// The ground, if the scene has objects.
    pub ground: Option<Ground>,
    /// Is the ground drawn?
    pub shows_ground: bool,
    /// Are food and markers drawn?
    pub shows_food: bool,
    /// Are painted areas drawn?
    pub shows_areas: bool,
}

/// The direction of the key light relative to the camera, with which it moves, so that visible surfaces are lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Degrees to the right; 0 is on the camera's side of the scene, 180 behind the scene.
    pub azimuth: f32,
    /// Degrees above.
    pub elevation: f32,
}

impl Light {
    /// Unit vector towards the light, in world space.
    #[must_use]
    pub fn direction(self, camera: &Camera) -> Vec3 {
        let Vec3 { x, y, z } = self.from_eye();
        (x * camera.right() + y * camera.up() + z * camera.backward()).normalize()
    }

    /// The direction in camera space: right and up in the picture, and towards the eye.
    #[must_use]
    pub fn from_eye(self) -> Vec3 {
        let (sin, cos) = self.azimuth.to_radians().sin_cos();
        let (up, level) = self.elevation.to_radians().sin_cos();
        Vec3::new(level * sin, up, level * cos)
    }

    /// Moves the light by a drag, in pixels, like rotating a large ball; a picture's height is half a turn.
    pub fn drag(&mut self, drag: Vec2, size: Vec2) {
        let degrees = 180.0 / size.y.max(1.0);
        self.azimuth = (self.azimuth + drag.x * degrees + 180.0).rem_euclid(360.0) - 180.0;
        self.elevation = (self.elevation - drag.y * degrees).clamp(-90.0, 90.0);
    }
}

/// Which part of the atlas a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtlasWindow {
    /// The place in the middle of the picture, as a share of the atlas's side: `(0, 0)` is its first texel.
    pub middle: Vec2,
    /// 1 fits the whole atlas into the picture, more magnifies.
    pub zoom: f32,
}

/// The allowed zooms of the atlas.
const ATLAS_ZOOM_RANGE: (f32, f32) = (0.5, 64.0);
/// The number of times in a minute at which positions of moving objects are sampled, so that all of them fit the picture.
const MOVING_TIMES: u32 = 48;
/// The number of vertices of each that are sampled.
const MOVING_VERTICES: usize = 64;
/// The largest distance that scene files take, scene radii.
const FARTHEST: f32 = 50.0;
/// The largest coordinate of what the camera looks at that scene files take, scene radii.
const FARTHEST_TARGET: f32 = 1000.0;
/// The margin around the whole atlas.
const ATLAS_MARGIN: f32 = 1.04;

impl View {
    /// The view of a scene's file, in a picture of `size` pixels.
    #[must_use]
    pub fn of(scene: &Scene, size: Vec2) -> Self {
        let picture = &scene.settings.picture;
        let mut camera =
            Camera::from_settings(&scene.settings.camera, scene.center, scene.radius, size);
        if scene.settings.camera.distance <= 0.0 {
            match scene.settings.camera.target == [0.0; 3] {
                true => camera.fit_centered(points(scene), size, margins(size)),
                false => camera.fit_points(points(scene), size),
            }
        }
        let mut view = Self {
            camera,
            show: Show::default(),
            color_map: ColorMap::default(),
            second_colors: (scene.settings.second_look.look()).map(|look| look.color_map),
            exposure: Exposure::default(),
            darkest: 0.0,
            particle_size: 1.0,
            most_particles: u32::MAX,
            background: Vec3::ZERO,
            is_transparent: false,
            charts: 0.0,
            is_plain: false,
            atlas: AtlasWindow::default(),
            light: Light {
                azimuth: 0.0,
                elevation: 0.0,
            },
            occlusion: 0.0,
            bloom: 0.0,
            wetness: 0.0,
            ground: Ground::under(points(scene), scene.center, scene.radius),
            shows_ground: true,
            shows_food: true,
            shows_areas: true,
        };
        view.take(picture);
        view
    }

    /// Applies the settings of a scene's file, except the camera.
    pub fn take(&mut self, picture: &PictureSettings) {
        self.show = picture.show;
        self.color_map = picture.color_map;
        self.exposure = match picture.brightest {
            brightest if brightest > 0.0 => Exposure::Fixed(brightest),
            _ => Exposure::default(),
        };
        self.darkest = picture.darkest;
        self.particle_size = picture.particle_size;
        self.background = Vec3::from_array(picture.background);
        self.charts = picture.charts;
        self.light = Light {
            azimuth: picture.light_azimuth,
            elevation: picture.light_elevation,
        };
        self.occlusion = picture.occlusion;
        self.bloom = picture.bloom;
        self.wetness = picture.wetness;
        self.shows_ground = picture.ground == Drawn::Shown;
        self.shows_food = picture.food == Drawn::Shown;
        self.shows_areas = picture.areas == Drawn::Shown;
    }

    /// The ground, if pictures show it.
    pub(super) fn ground_seen(&self) -> Option<Ground> {
        let is_shown = self.shows_ground && !self.is_transparent && !self.show.is_flat();
        self.ground.filter(|_| is_shown)
    }

    /// The share of the charts' colours below the trail.
    pub(super) fn charts_under_trail(&self) -> f32 {
        (2.0 * self.charts).min(1.0)
    }

    /// The share of the trail over them.
    pub(super) fn trail_over_charts(&self) -> f32 {
        (2.0 - 2.0 * self.charts).min(1.0)
    }

    /// Writes these settings into a scene file's `[picture]`, except the camera.
    pub fn write_to(&self, picture: &mut PictureSettings) {
        picture.show = self.show;
        picture.color_map = self.color_map;
        picture.darkest = self.darkest;
        picture.charts = self.charts;
        picture.particle_size = self.particle_size;
        picture.light_azimuth = self.light.azimuth;
        picture.light_elevation = self.light.elevation;
        picture.occlusion = self.occlusion;
        picture.bloom = self.bloom;
        picture.wetness = self.wetness;
        picture.background = self.background.to_array();
        let drawn = |is_shown| match is_shown {
            true => Drawn::Shown,
            false => Drawn::Hidden,
        };
        picture.ground = drawn(self.shows_ground);
        picture.food = drawn(self.shows_food);
        picture.areas = drawn(self.shows_areas);
        picture.brightest = match self.exposure {
            Exposure::Fixed(brightest) => brightest,
            Exposure::Auto { .. } => 0.0,
        };
    }

    /// The background as light. The usual one stands for the one that goes with the colour map.
    #[must_use]
    pub fn background_light(&self) -> Vec3 {
        if self.background.to_array() == USUAL_BACKGROUND {
            return self.color_map.background();
        }
        Vec3::from_array(self.background.to_array().map(linear_from_srgb))
    }
}

/// What a picture leaves free round a scene, pixels: on the left, above, on the right, and below, where its shadow is.
#[must_use]
pub fn margins(size: Vec2) -> [f32; 4] {
    [0.0, 0.02 * size.y, 0.0, 0.07 * size.y]
}

/// Every vertex of a scene at its start, in world space, and the places of some vertices of moving objects in the minute that follows.
pub fn points(scene: &Scene) -> impl Iterator<Item = Vec3> {
    let moving = scene.settings.objects.iter().enumerate();
    let moving: Vec<usize> = moving
        .filter(|(_, object)| !object.motion.is_still())
        .map(|(i, _)| i)
        .collect();
    let all: Vec<usize> = (0..scene.surface.objects.len()).collect();
    let start = scene.settings.time.start;
    let first = std::iter::once((start, usize::MAX, all));
    let later = (1..=MOVING_TIMES).map(move |i| {
        let time = start + 60.0 * f64::from(i) / f64::from(MOVING_TIMES);
        (time, MOVING_VERTICES, moving.clone())
    });
    first.chain(later).flat_map(move |(time, most, objects)| {
        let poses = scene.world_from_object_at(time);
        objects.into_iter().flat_map(move |object| {
            let (first, end) = scene.surface.objects[object].vertices;
            let positions = &scene.surface.positions[first as usize..end as usize];
            let world_from_object = poses[object];
            let stride = positions.len().div_ceil(most).max(1);
            positions
                .iter()
                .step_by(stride)
                .map(move |&position| world_from_object.transform_point3(position))
        })
    })
}

impl Camera {
    /// The camera that a scene's file describes; `center` and `radius` are the scene's. A distance of 0 fits the scene into a picture of
    /// `size` pixels.
    #[must_use]
    pub fn from_settings(settings: &CameraSettings, center: Vec3, radius: f32, size: Vec2) -> Self {
        let target = center + radius * Vec3::from_array(settings.target);
        let mut camera = Self {
            target,
            distance: radius * settings.distance,
            yaw: settings.azimuth.to_radians(),
            pitch: settings.elevation.to_radians().clamp(-MAX_PITCH, MAX_PITCH),
            vertical_fov: settings.field_of_view.to_radians(),
            scene_radius: radius,
            shift: Vec2::ZERO,
        };
        if settings.distance <= 0.0 {
            camera.fit(target, radius, size);
        }
        camera
    }

    /// The settings of this camera for a scene's file: angles to 0.0001 degrees and lengths to 0.00001 scene radii, far less than a pixel,
    /// so that numbers are short.
    #[must_use]
    pub fn to_settings(&self, center: Vec3) -> CameraSettings {
        let degrees = |angle: f32| ((f64::from(angle).to_degrees() * 1e4).round() / 1e4) as f32;
        let length = |radii: f32| ((f64::from(radii) * 1e5).round() / 1e5) as f32;
        CameraSettings {
            azimuth: degrees(self.yaw),
            elevation: degrees(self.pitch),
            distance: length(self.distance / self.scene_radius).min(FARTHEST),
            target: ((self.target - center) / self.scene_radius)
                .to_array()
                .map(|radii| length(radii).clamp(-FARTHEST_TARGET, FARTHEST_TARGET)),
            field_of_view: degrees(self.vertical_fov),
        }
    }
}

impl Default for AtlasWindow {
    fn default() -> Self {
        Self {
            middle: Vec2::splat(0.5),
            zoom: 1.0,
        }
    }
}

impl AtlasWindow {
    /// Texels of an atlas of `atlas_size` that one pixel of a picture of `size` pixels covers.
    #[must_use]
    pub fn texels_per_pixel(&self, atlas_size: u32, size: Vec2) -> f32 {
        ATLAS_MARGIN * atlas_size as f32 / (self.zoom * size.min_element().max(1.0))
    }

    /// The texel position at the picture's top left corner.
    #[must_use]
    pub fn origin(&self, atlas_size: u32, size: Vec2) -> Vec2 {
        self.middle * atlas_size as f32 - 0.5 * size * self.texels_per_pixel(atlas_size, size)
    }

    /// Pans the atlas by a drag, in pixels.
    pub fn pan(&mut self, drag: Vec2, size: Vec2) {
        self.middle -= drag * self.texels_per_pixel(1, size);
        self.middle = self.middle.clamp(Vec2::ZERO, Vec2::ONE);
    }

    /// Multiplies the zoom by `factor`; the texel under the pointer stays under it.
    pub fn zoom(&mut self, factor: f32, pixel: Vec2, size: Vec2) {
        let from_middle = pixel - 0.5 * size;
        let under_pointer = self.middle + from_middle * self.texels_per_pixel(1, size);
        let (least, most) = ATLAS_ZOOM_RANGE;
        self.zoom = (self.zoom * factor).clamp(least, most);
        self.middle = under_pointer - from_middle * self.texels_per_pixel(1, size);
        self.middle = self.middle.clamp(Vec2::ZERO, Vec2::ONE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parameters::{Kind, PARAMETERS};
    use crate::scene::settings::Settings;

    #[test]
    fn settings_become_a_camera_and_return() {
        let settings = CameraSettings {
            azimuth: 120.0,
            elevation: -20.0,
            distance: 4.0,
            target: [0.5, 0.0, -0.25],
            field_of_view: 30.0,
        };
        let center = Vec3::new(1.0, 2.0, 3.0);
        let camera = Camera::from_settings(&settings, center, 10.0, Vec2::ONE);
        assert_eq!(camera.target, Vec3::new(6.0, 2.0, 0.5));
        assert_eq!(camera.distance, 40.0);
        assert!(camera.eye().x > camera.target.x && camera.eye().y < camera.target.y);
        let returned = camera.to_settings(center);
        for (a, b) in [
            (returned.azimuth, 120.0),
            (returned.elevation, -20.0),
            (returned.distance, 4.0),
            (returned.target[2], -0.25),
            (returned.field_of_view, 30.0),
        ] {
            assert_eq!(a, b, "{returned:?}");
        }
    }

    /// Would catch: a scene that was saved while the camera was far away, and that cannot be opened again.
    #[test]
    fn a_camera_that_is_far_away_is_written_as_files_can_have_it() {
        let camera = Camera {
            target: Vec3::new(1e7, -1e7, 5.0),
            distance: 1e7,
            scene_radius: 10.0,
            ..Camera::default()
        };
        let settings = camera.to_settings(Vec3::ZERO);
        let range = |key: &str| {
            let row = PARAMETERS.iter().find(|row| row.key == key);
            match row.map(|row| &row.kind) {
                Some(Kind::Number(number)) => number.range,
                Some(Kind::Vector { range, .. }) => *range,
                _ => panic!("{key} is no number"),
            }
        };
        let (low, high) = range("camera.target");
        assert_eq!(settings.target.map(f64::from), [high, low, 0.5]);
        assert_eq!(f64::from(settings.distance), range("camera.distance").1);
    }

    #[test]
    fn the_light_goes_with_the_camera_and_with_the_hand() {
        let size = Vec2::splat(100.0);
        let mut camera = Camera::default();
        let mut light = Light {
            azimuth: 0.0,
            elevation: 0.0,
        };
        assert!(light.direction(&camera).dot(camera.backward()) > 0.999);
        light.drag(Vec2::new(50.0, 0.0), size);
        assert_eq!(light.azimuth, 90.0);
        for yaw in [0.0, 1.0, 4.0] {
            camera.yaw = yaw;
            assert!(light.direction(&camera).dot(camera.right()) > 0.999);
        }
        light.drag(Vec2::new(100.0, -80.0), size);
        assert_eq!((light.azimuth, light.elevation), (-90.0, 90.0));
        assert!(light.direction(&camera).dot(camera.up()) > 0.999);
    }

    #[test]
    fn without_a_distance_the_scene_fills_the_picture() {
        let settings = Settings::default().camera;
        let size = Vec2::new(300.0, 200.0);
        let camera = Camera::from_settings(&settings, Vec3::X, 2.0, size);
        assert_eq!(camera, {
            let mut fitted = camera;
            fitted.fit(Vec3::X, 2.0, size);
            fitted
        });
        assert!(camera.distance > 4.0 && camera.distance < 10.0);
    }

    #[test]
    fn a_scene_without_a_distance_is_whole_and_large_in_its_picture() {
        let mut settings = Settings::default();
        settings.objects[0].position = [3.0, 0.0, 0.0];
        let scene = Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap();
        let size = Vec2::new(320.0, 200.0);
        let camera = View::of(&scene, size).camera;
        let (low, high) = points(&scene)
            .map(|point| camera.pixel(point, size).unwrap())
            .fold(
                (Vec2::INFINITY, Vec2::NEG_INFINITY),
                |(low, high), pixel| (low.min(pixel), high.max(pixel)),
            );
        assert!(
            low.min_element() > 0.0 && high.cmplt(size).all(),
            "{low} to {high}"
        );
        let filled = (high - low) / size;
        assert!(filled.max_element() > 0.7, "{filled}");
    }

    /// Would catch: a camera and a ground for where objects are at the time 0, in a scene that starts later.
    #[test]
    fn a_scene_that_starts_late_is_whole_in_its_picture() {
        let mut settings = Settings::default();
        settings.time.start = 1000.0;
        // At the start it is at the end of its way, and hardly moves.
        settings.objects[0].motion.slide = [20.0, -10.0, 0.0];
        settings.objects[0].motion.slide_period = 4000.0;
        let scene = Scene::from_settings("late".to_owned(), settings, ".".into()).unwrap();
        let size = Vec2::new(320.0, 200.0);
        let view = View::of(&scene, size);
        let pose = scene.world_from_object()[0];
        for &position in &scene.surface.positions {
            let pixel = view.camera.pixel(pose.transform_point3(position), size);
            let pixel = pixel.unwrap();
            assert!(
                pixel.min_element() > 0.0 && pixel.cmplt(size).all(),
                "{pixel}"
            );
        }
        let ground = view.ground.unwrap().height;
        assert!((-11.0..-10.0).contains(&ground), "{ground}");
    }

    #[test]
    fn a_camera_straight_above_keeps_an_upright() {
        let settings = CameraSettings {
            elevation: 90.0,
            ..Settings::default().camera
        };
        let camera = Camera::from_settings(&settings, Vec3::ZERO, 1.0, Vec2::splat(100.0));
        assert!(camera.clip_from_world(Vec2::splat(100.0)).is_finite());
        assert!(camera.up().is_normalized());
    }

    #[test]
    fn the_whole_atlas_is_in_the_picture_and_zooms_about_the_pointer() {
        let size = Vec2::new(800.0, 500.0);
        let mut window = AtlasWindow::default();
        let texel_at = |window: &AtlasWindow, pixel: Vec2| {
            window.origin(1024, size) + pixel * window.texels_per_pixel(1024, size)
        };
        assert!(texel_at(&window, Vec2::ZERO).max_element() < 0.0);
        assert!(texel_at(&window, size).min_element() > 1024.0);
        assert!(texel_at(&window, 0.5 * size).distance(Vec2::splat(512.0)) < 1e-3);
        let pointer = Vec2::new(300.0, 100.0);
        let texel = texel_at(&window, pointer);
        window.zoom(5.0, pointer, size);
        assert!(texel_at(&window, pointer).distance(texel) < 0.01);
        window.pan(Vec2::new(-40.0, 30.0), size);
        assert!(texel_at(&window, pointer + Vec2::new(-40.0, 30.0)).distance(texel) < 0.01);
    }
}

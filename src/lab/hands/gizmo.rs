//! Handles on the picked object: arrows move it along the world's axes, rings turn it, the box in the middle moves it in
//! the plane of the picture, and the one beside it scales it.

use egui::{Color32, Pos2, Rect, Response, Stroke, Ui, vec2};
use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec2, Vec3};
use myxo::render::Camera;
use myxo::scene::motion::pose_at;
use myxo::scene::settings::{ModelAnimation, ObjectSettings};

use super::super::interface::{Command, Facts, Interface};
use super::super::places::Marked as _;
use super::super::theme;
use super::{Held, Work};

/// Points from the middle to the end of an arrow.
const ARROW: f32 = 84.0;
/// Radius of the rings, points.
const RING: f32 = 60.0;
/// From the middle to the box that scales.
const SCALE_AT: egui::Vec2 = vec2(30.0, -30.0);
/// As near as this a handle is meant, points.
const NEAR: f32 = 8.0;
const AXES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];
const COLORS: [Color32; 3] = [
    Color32::from_rgb(0xf0, 0x5a, 0x4e),
    Color32::from_rgb(0x7e, 0xc8, 0x4a),
    Color32::from_rgb(0x5a, 0x9c, 0xf4),
];
const PARTS: usize = 48;

/// What a handle does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Handle {
    /// Moves along an axis.
    Move(usize),
    /// Moves in the plane of the picture.
    Plane,
    /// Turns about an axis.
    Turn(usize),
    /// Scales.
    Scale,
}

/// A handle that is held.
#[derive(Clone, Debug, PartialEq)]
pub struct Grab {
    handle: Handle,
    /// The object as it was.
    object: ObjectSettings,
    /// Where its middle was, world space.
    middle: Vec3,
    /// Where the pointer was, pixels of the picture.
    from: Vec2,
    /// Radius of the rings, world length.
    ring: f32,
    /// How much larger the object shall become.
    pub scaled: f32,
}

/// Where everything of the gizmo lies.
struct Shape {
    /// Points of the window.
    middle: Pos2,
    /// Ends of the arrows.
    ends: [Option<Pos2>; 3],
    /// The rings.
    rings: [Vec<Pos2>; 3],
    scale: Pos2,
}

/// From pixels of the picture to points of the window, and back.
#[derive(Clone, Copy)]
pub(super) struct Screen {
    pub(super) rect: Rect,
    pub(super) pixels_per_point: f32,
}

impl Screen {
    pub(super) fn of(ui: &Ui, rect: Rect) -> Self {
        Self {
            rect,
            pixels_per_point: ui.ctx().pixels_per_point(),
        }
    }

    /// Of the picture, pixels.
    pub(super) fn size(self) -> Vec2 {
        Vec2::new(self.rect.width(), self.rect.height()) * self.pixels_per_point
    }

    /// Where a place in the world is seen.
    pub(super) fn point(self, camera: &Camera, place: Vec3) -> Option<Pos2> {
        let pixel = camera.pixel(place, self.size())?;
        let at = pixel / self.pixels_per_point;
        Some(self.rect.min + vec2(at.x, at.y))
    }

    /// The world length at a place that one point of the window covers.
    fn length_of_point(self, camera: &Camera, place: Vec3) -> f32 {
        let points = Vec2::new(self.rect.width(), self.rect.height());
        length_of_pixel(camera, points, place)
    }
}

impl Shape {
    fn of(screen: Screen, camera: &Camera, middle: Vec3) -> Option<Self> {
        let unit = screen.length_of_point(camera, middle);
        let at = screen.point(camera, middle)?;
        let ends = AXES.map(|axis| screen.point(camera, middle + ARROW * unit * axis));
        let rings = AXES.map(|axis| {
            let side = axis.any_orthonormal_vector();
            let other = axis.cross(side);
            let along = (0..=PARTS).filter_map(|i| {
                let angle = i as f32 / PARTS as f32 * std::f32::consts::TAU;
                let (sin, cos) = angle.sin_cos();
                screen.point(camera, middle + RING * unit * (cos * side + sin * other))
            });
            along.collect()
        });
        Some(Self {
            middle: at,
            ends,
            rings,
            scale: at + SCALE_AT,
        })
    }

    /// The handle that the pointer is on. Boxes lie on arrows, arrows on rings.
    fn handle_at(&self, at: Pos2) -> Option<Handle> {
        if at.distance(self.scale) < NEAR {
            return Some(Handle::Scale);
        }
        if at.distance(self.middle) < NEAR {
            return Some(Handle::Plane);
        }
        let arrows = self.ends.iter().enumerate().filter_map(|(axis, end)| {
            let end = (*end)?;
            // An arrow that points at the eye has no length to be held by.
            (end.distance(self.middle) > 2.0 * NEAR)
                .then(|| (to_segment(at, self.middle, end), Handle::Move(axis)))
        });
        let rings = self.rings.iter().enumerate().map(|(axis, ring)| {
            let near = ring.windows(2).map(|ends| to_segment(at, ends[0], ends[1]));
            // A little farther, so that arrows come first.
            (near.fold(f32::MAX, f32::min) + 2.0, Handle::Turn(axis))
        });
        let nearest = arrows.chain(rings).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest
            .filter(|(away, _)| *away < NEAR)
            .map(|(_, handle)| handle)
    }
}

fn to_segment(at: Pos2, from: Pos2, to: Pos2) -> f32 {
    let way = to - from;
    let share = ((at - from).dot(way) / way.length_sq().max(1e-9)).clamp(0.0, 1.0);
    at.distance(from + share * way)
}

impl Interface {
    /// The hand on the gizmo, which is drawn. Does it hold a handle?
    pub(super) fn use_gizmo(
        &mut self,
        ui: &Ui,
        response: &Response,
        facts: &Facts,
        held: &Held,
        commands: &mut Vec<Command>,
    ) -> bool {
        let Some(object) = self.hands.selected else {
            self.hands.grab = None;
            return false;
        };
        // While objects come or go, those that are seen are not those that are edited.
        let settings = (self.edited.objects.get(object)).filter(|_| !self.is_renewed());
        let (Some(pose), Some(settings)) = (facts.hand.poses.get(object), settings) else {
            self.hands.grab = None;
            return false;
        };
        let screen = Screen::of(ui, response.rect);
        let camera = self.view.camera;
        let middle = Vec3::from(pose.translation);
        let Some(shape) = Shape::of(screen, &camera, middle) else {
            return false;
        };
        let pointer = ui.input(|i| i.pointer.latest_pos());
        let hovered = pointer.filter(|_| response.hovered() || self.hands.grab.is_some());
        let to_pixel = |at: Pos2| {
            let at = (at - response.rect.min) * screen.pixels_per_point;
            Vec2::new(at.x, at.y)
        };
        let over = hovered.and_then(|at| shape.handle_at(at));
        // Where it was pressed: in a slow frame the pointer has gone on since.
        let pressed = held.press.filter(|_| self.hands.grab.is_none());
        if let Some((at, handle)) = pressed.and_then(|at| Some((at, shape.handle_at(at)?))) {
            self.hands.grab = Some(Grab {
                handle,
                object: settings.clone(),
                middle,
                from: to_pixel(at),
                ring: RING * screen.length_of_point(&camera, middle),
                scaled: 1.0,
            });
        }
        let to = held.release.or(pointer);
        if let (Some(grab), Some(at)) = (&mut self.hands.grab, to) {
            let to = to_pixel(at);
            if grab.handle == Handle::Scale {
                let grown = (to.x - grab.from.x - (to.y - grab.from.y)) / screen.pixels_per_point;
                grab.scaled = (0.01 * grown).exp().clamp(0.05, 20.0);
            } else {
                let moved = grab.moved(&camera, screen.size(), facts.hand.time, to);
                if self.edited.objects[object] != moved {
                    self.edited.objects[object] = moved;
                    commands.push(Command::Apply);
                }
            }
        }
        if !self.hands.hold.is_down()
            && let Some(grab) = self.hands.grab.take()
        {
            if grab.scaled != 1.0 {
                commands.push(Command::Hand(Work::Scale(object, grab.scaled)));
            }
            // The release is not a click.
            self.draw_gizmo(ui, &shape, None, screen);
            return true;
        }
        let active = self.hands.grab.as_ref().map(|grab| grab.handle);
        self.draw_gizmo(ui, &shape, active.or(over), screen);
        active.is_some()
    }

    fn draw_gizmo(&self, ui: &Ui, shape: &Shape, active: Option<Handle>, screen: Screen) {
        let painter = ui.painter_at(screen.rect);
        let stroke = |handle: Handle, color: Color32| {
            let is_active = active == Some(handle);
            Stroke::new(
                if is_active { 3.5 } else { 2.0 },
                if is_active { theme::accent(ui) } else { color },
            )
        };
        // Seen on light and on dark.
        let under =
            |stroke: Stroke| Stroke::new(stroke.width + 3.0, Color32::from_black_alpha(150));
        for (axis, ring) in shape.rings.iter().enumerate() {
            let stroke = stroke(Handle::Turn(axis), COLORS[axis]);
            painter.line(ring.clone(), under(stroke));
            painter.line(ring.clone(), stroke);
        }
        for (axis, end) in shape.ends.iter().enumerate() {
            if let Some(end) = end {
                let stroke = stroke(Handle::Move(axis), COLORS[axis]);
                painter.arrow(shape.middle, *end - shape.middle, under(stroke));
                painter.arrow(shape.middle, *end - shape.middle, stroke);
            }
        }
        let boxes = [(Handle::Plane, shape.middle), (Handle::Scale, shape.scale)];
        for (handle, at) in boxes {
            let rect = Rect::from_center_size(at, vec2(10.0, 10.0));
            let color = stroke(handle, ui.visuals().strong_text_color()).color;
            painter.rect_filled(rect.expand(1.5), 2.0, Color32::from_black_alpha(150));
            painter.rect_filled(rect, 2.0, color);
        }
        let names = ["x", "y", "z"];
        for (name, end) in names.into_iter().zip(shape.ends) {
            if let Some(end) = end {
                mark(ui, &format!("gizmo={name}"), end);
            }
        }
        mark(ui, "gizmo=plane", shape.middle);
        mark(ui, "gizmo=scale", shape.scale);
        // Where nothing else is near.
        let away = |at: &Pos2| {
            let ends = shape.ends.iter().flatten();
            let arrows = ends.map(|end| to_segment(*at, shape.middle, *end));
            let others = shape.rings[..2]
                .iter()
                .flatten()
                .map(|other| at.distance(*other));
            arrows
                .chain(others)
                .fold(at.distance(shape.scale), f32::min)
        };
        let free = shape.rings[2].iter().copied();
        if let Some(at) = free.max_by(|a, b| away(a).total_cmp(&away(b))) {
            mark(ui, "gizmo=turn", at);
        }
    }
}

/// Tells tests where a handle is.
fn mark(ui: &Ui, name: &str, at: Pos2) {
    let rect = Rect::from_center_size(at, vec2(4.0, 4.0));
    let id = ui.id().with(name);
    let _ = ui.interact(rect, id, egui::Sense::hover()).marked(name);
}

impl Grab {
    /// The object as the pointer has it, at a time of the objects' motion.
    fn moved(&self, camera: &Camera, size: Vec2, time: f64, to: Vec2) -> ObjectSettings {
        let mut object = self.object.clone();
        match self.handle {
            Handle::Move(axis) => {
                let [from, to] = [self.from, to]
                    .map(|pixel| along_axis(camera, size, pixel, self.middle, AXES[axis]));
                shift(&mut object, time, (to - from) * AXES[axis]);
            }
            Handle::Plane => {
                let [from, to] =
                    [self.from, to].map(|pixel| on_plane(camera, size, pixel, self.middle));
                shift(&mut object, time, to - from);
            }
            Handle::Turn(axis) => {
                let pixels = [self.from, to];
                let angle = angle_round(camera, size, pixels, self.middle, AXES[axis], self.ring);
                turn(&mut object, time, AXES[axis].as_dvec3(), f64::from(angle));
            }
            Handle::Scale => {}
        }
        object
    }
}

/// How far along an axis through `middle` the place is that lies nearest to what a pixel shows.
fn along_axis(camera: &Camera, size: Vec2, pixel: Vec2, middle: Vec3, axis: Vec3) -> f32 {
    let ray = camera.ray(pixel, size);
    // The point of the axis nearest to the ray; nearly parallel ones have none.
    let across = ray.direction - ray.direction.dot(axis) * axis;
    let slope = across.length_squared().max(1e-3);
    let from_eye = middle - ray.origin;
    let along_ray = from_eye.dot(across) / slope;
    (ray.origin + along_ray * ray.direction - middle).dot(axis)
}

/// By how much the ring about an axis has turned that a pointer holds and takes from one pixel to another, so that it stays
/// under the pointer. `radius` is the ring's, world length.
fn angle_round(
    camera: &Camera,
    size: Vec2,
    pixels: [Vec2; 2],
    middle: Vec3,
    axis: Vec3,
    radius: f32,
) -> f32 {
    let eye = camera.eye() - middle;
    if eye.normalize().dot(axis).abs() < EDGE_ON {
        // Seen from its edge it is a line: along it, the side that is seen goes round by as much as the pointer goes.
        let near = (eye - eye.dot(axis) * axis).normalize_or(camera.backward());
        let along = axis.cross(near);
        let [from, to] = pixels.map(|pixel| on_plane(camera, size, pixel, middle).dot(along));
        return (to - from) / radius;
    }
    let [from, to] = pixels.map(|pixel| {
        let ray = camera.ray(pixel, size);
        let slope = ray.direction.dot(axis);
        let slope = slope.abs().max(1e-6).copysign(slope);
        let along = (middle - ray.origin).dot(axis) / slope;
        let way = ray.origin + along * ray.direction - middle;
        // Where the ray passes the horizon of the ring's plane, the place at the other side of the eye is seen through it.
        if along < 0.0 { -way } else { way }
    });
    from.cross(to).dot(axis).atan2(from.dot(to))
}

/// The cosine of the angle between an axis and the way to the eye up to which its ring is a line.
const EDGE_ON: f32 = 0.17;

/// The world length at a place that a pixel covers.
fn length_of_pixel(camera: &Camera, size: Vec2, place: Vec3) -> f32 {
    let depth = (camera.eye() - place).dot(camera.backward()).max(1e-6);
    2.0 * depth * (0.5 * camera.vertical_fov).tan() / size.y.max(1.0)
}

/// Where a pixel's ray meets the plane of the picture through `middle`.
fn on_plane(camera: &Camera, size: Vec2, pixel: Vec2, middle: Vec3) -> Vec3 {
    let ray = camera.ray(pixel, size);
    let normal = camera.backward();
    let along = (middle - ray.origin).dot(normal) / ray.direction.dot(normal).min(-1e-6);
    ray.origin + along * ray.direction
}

/// Moves an object by a way in the world, whatever its motion makes of its position: that is affine, so three places tell.
pub(super) fn shift(object: &mut ObjectSettings, time: f64, way: Vec3) {
    let place = |position: [f32; 3]| {
        let mut other = object.clone();
        other.position = position;
        still_model(&mut other);
        pose_at(&other, None, time).translation
    };
    let origin = place([0.0; 3]);
    let [x, y, z] =
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| place(axis) - origin);
    let way = way.as_dvec3();
    // A rotation, so its transpose takes back.
    let back = DVec3::new(x.dot(way), y.dot(way), z.dot(way)).as_vec3();
    let position = Vec3::from_array(object.position) + back;
    object.position = position.to_array();
}

/// Turns an object about an axis of the world, whatever stands round its rotation.
fn turn(object: &mut ObjectSettings, time: f64, axis: DVec3, angle: f64) {
    let rotation_of = |object: &ObjectSettings| {
        let pose: DAffine3 = pose_at(object, None, time);
        DQuat::from_mat3(&pose.matrix3).normalize()
    };
    let mut round = object.clone();
    still_model(&mut round);
    round.rotation = [0.0; 3];
    (round.motion.spin, round.motion.swing) = ([0.0; 3], [0.0; 3]);
    let round = rotation_of(&round);
    let mut own = object.clone();
    still_model(&mut own);
    own.motion = Default::default();
    let own = rotation_of(&own);
    let turned = round.inverse() * DQuat::from_axis_angle(axis, angle) * round * own;
    let (z, y, x) = turned.to_euler(EulerRot::ZYX);
    object.rotation = [x, y, z].map(|angle| angle.to_degrees() as f32);
}

/// A model's own animation is applied to where the object stands, and changes nothing about that.
fn still_model(object: &mut ObjectSettings) {
    object.motion.model = ModelAnimation::Still;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mover() -> ObjectSettings {
        let mut object = ObjectSettings {
            position: [0.5, 0.1, -0.3],
            rotation: [10.0, 20.0, 30.0],
            ..ObjectSettings::default()
        };
        object.motion.spin = [0.0, 40.0, 0.0];
        object.motion.orbit = [5.0, 20.0, 0.0];
        object.motion.slide = [0.1, 0.0, 0.0];
        object
    }

    #[test]
    fn an_object_that_moves_goes_where_the_hand_puts_it() {
        let before = mover();
        let time = 3.7;
        let mut after = before.clone();
        let way = Vec3::new(0.2, -0.4, 0.7);
        shift(&mut after, time, way);
        let moved =
            pose_at(&after, None, time).translation - pose_at(&before, None, time).translation;
        assert!(moved.as_vec3().distance(way) < 1e-5, "{moved}");
        assert_eq!(after.motion, before.motion, "and goes on moving");
    }

    #[test]
    fn an_object_that_moves_turns_about_the_axis_of_the_world() {
        let before = mover();
        let (time, angle) = (3.7, 0.4);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let mut after = before.clone();
            turn(&mut after, time, axis, angle);
            let rotation = |object| DQuat::from_mat3(&pose_at(object, None, time).matrix3);
            let expected = DQuat::from_axis_angle(axis, angle) * rotation(&before);
            let off = rotation(&after).angle_between(expected);
            assert!(off < 1e-5, "{off}");
            assert_eq!(after.position, before.position);
        }
    }

    #[test]
    fn rings_follow_the_pointer() {
        let size = Vec2::new(640.0, 480.0);
        let middle = Vec3::new(0.1, 0.2, -0.1);
        for (yaw, pitch) in [(20.0_f32, 25.0_f32), (-130.0, 70.0), (65.0, -40.0)] {
            let camera = Camera {
                distance: 5.0,
                yaw: yaw.to_radians(),
                pitch: pitch.to_radians(),
                ..Camera::default()
            };
            for axis in AXES {
                let side = axis.any_orthonormal_vector();
                let place = |angle: f32| {
                    let (sin, cos) = angle.sin_cos();
                    middle + 0.4 * (cos * side + sin * axis.cross(side))
                };
                for begin in [0.3_f32, 1.9, 4.4] {
                    for turned in [-1.2_f32, 0.01, 0.8] {
                        let pixels = [begin, begin + turned]
                            .map(|angle| camera.pixel(place(angle), size).unwrap());
                        let angle = angle_round(&camera, size, pixels, middle, axis, 0.4);
                        assert!(
                            (angle - turned).abs() < 2e-3,
                            "{axis} from {yaw}, {pitch}: {angle} instead of {turned}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_ring_that_is_a_line_is_drawn_along_it() {
        let size = Vec2::new(640.0, 480.0);
        let camera = Camera {
            distance: 5.0,
            yaw: 0.0,
            pitch: 0.0,
            ..Camera::default()
        };
        let middle = camera.target;
        let at = camera.pixel(middle, size).unwrap();
        // The ring about Y is seen from in front: to the right is the way that its near side goes round.
        for begin in [-40.0, 0.0, 40.0] {
            for way in [-30.0, 6.0, 60.0] {
                let pixels = [begin, begin + way].map(|x| at + Vec2::new(x, 0.0));
                let radius = 60.0 * length_of_pixel(&camera, size, middle);
                let angle = angle_round(&camera, size, pixels, middle, Vec3::Y, radius);
                assert!((angle - way / 60.0).abs() < 1e-3, "{begin}, {way}: {angle}");
            }
        }
    }

    #[test]
    fn arrows_follow_the_pointer() {
        let camera = Camera {
            distance: 5.0,
            ..Camera::default()
        };
        let size = Vec2::new(640.0, 480.0);
        let middle = Vec3::new(0.1, 0.2, -0.1);
        for axis in AXES {
            let place = middle + 0.35 * axis;
            let pixel = camera.pixel(place, size).unwrap();
            let along = along_axis(&camera, size, pixel, middle, axis);
            assert!((along - 0.35).abs() < 1e-3, "{axis}: {along}");
        }
        let place = middle + 0.3 * camera.right() - 0.2 * camera.up();
        let pixel = camera.pixel(place, size).unwrap();
        assert!(on_plane(&camera, size, pixel, middle).distance(place) < 1e-4);
    }
}

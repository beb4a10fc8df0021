//! How a particle leaves one object in world space and lands on another: tangent frames, places and headings. Twin of
//! `shaders/include/frame.glsl`, `spaces.glsl` and `transfer.glsl`.

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

use super::direction::{flat_direction, perpendicular};
use super::setup::Setup;
use super::types::{Motion, Particle, Pose, Transfer, Vertex};
use crate::mesh::surface::Triangle;
use crate::strict::{
    cross3, direction3_or, dot2, dot3, quotient, settled, settled3, share, within,
};

/// The surface and the poses of its objects.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// Tangent-frame shapes.
    pub triangles: &'a [Triangle],
    /// Three vertex indices per triangle.
    pub corners: &'a [u32],
    /// Object-space vertices.
    pub vertices: &'a [Vertex],
    /// World from object.
    pub poses: &'a [Pose],
}

/// Maps a place from one object's space to another's, for these poses.
pub(super) fn place_in(target: &Pose, source: &Pose, position: Vec3) -> Vec3 {
    place_in_object(target, place_in_world(source, position))
}

/// Place and heading of a particle in world space.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// The place.
    pub position: Vec3,
    /// Unit vector.
    pub heading: Vec3,
    /// Unit normal of the plane that the heading lies in.
    pub normal: Vec3,
}

impl Flight {
    /// As transfers store it.
    pub(super) fn settled(self) -> Self {
        Self {
            position: settled3(self.position),
            heading: settled3(self.heading),
            normal: settled3(self.normal),
        }
    }
}

/// A triangle's corner A, the axes of its tangent frame and its unit normal, object space.
pub(super) struct Frame {
    pub(super) origin: Vec3,
    pub(super) p: Vec3,
    pub(super) h: Vec3,
    pub(super) normal: Vec3,
}

impl Frame {
    /// The frame of a triangle with these corners.
    pub(super) fn of([a, b, c]: [Vec3; 3]) -> Self {
        let p = direction3_or(b - a, Vec3::X);
        let normal = direction3_or(cross3(b - a, c - a), perpendicular(p));
        Self {
            origin: a,
            p,
            h: cross3(normal, p),
            normal,
        }
    }

    /// The place with given weights of B and C on the triangle, which has that shape; object space.
    pub(super) fn position(&self, shape: &Triangle, [u, v]: [f32; 2]) -> Vec3 {
        let along = u * shape.ab + v * shape.cp;
        let across = v * shape.ch;
        (self.origin + along * self.p) + across * self.h
    }
}

fn turned_to_world(pose: &Pose, direction: Vec3) -> Vec3 {
    let row = |row: Vec4| dot3(row.xyz(), direction);
    Vec3::new(row(pose.x), row(pose.y), row(pose.z))
}

fn turned_to_object(pose: &Pose, direction: Vec3) -> Vec3 {
    let [x, y, z] = [pose.x, pose.y, pose.z].map(Vec4::xyz);
    (direction.x * x + direction.y * y) + direction.z * z
}

fn translation_of(pose: &Pose) -> Vec3 {
    Vec3::new(pose.x.w, pose.y.w, pose.z.w)
}

fn place_in_world(pose: &Pose, position: Vec3) -> Vec3 {
    turned_to_world(pose, position) + translation_of(pose)
}

pub(super) fn place_in_object(pose: &Pose, position: Vec3) -> Vec3 {
    turned_to_object(pose, position - translation_of(pose))
}

/// The heading, turned about the line in which the two planes meet by the angle between their normals (Rodrigues).
#[must_use]
pub fn folded(heading: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    let axis = cross3(from, to);
    let cosine = dot3(from, to);
    if cosine < -0.99999 {
        return heading;
    }
    (cosine * heading + cross3(axis, heading)) + quotient(dot3(axis, heading), 1.0 + cosine) * axis
}

/// The weights of B and C at the point of a triangle that is nearest to `(x, y)` of its tangent frame.
#[must_use]
pub fn nearest_weights(shape: &Triangle, x: f32, y: f32) -> [f32; 2] {
    let &Triangle { ab, cp, ch, .. } = shape;
    let v = quotient(y, ch);
    let u = quotient(x - v * cp, ab);
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
        return [u, v];
    }
    let (from_a, from_b) = (Vec2::new(x, y), Vec2::new(x - ab, y));
    let (bc, ac) = (Vec2::new(cp - ab, ch), Vec2::new(cp, ch));
    let on_ab = share(x, ab);
    let on_bc = share(dot2(from_b, bc), dot2(bc, bc));
    let on_ac = share(dot2(from_a, ac), dot2(ac, ac));
    let square = |way: Vec2| dot2(way, way);
    let ab_square = square(Vec2::new(x - on_ab * ab, y));
    let bc_square = square(from_b - on_bc * bc);
    let ac_square = square(from_a - on_ac * ac);
    if ab_square <= bc_square && ab_square <= ac_square {
        [on_ab, 0.0]
    } else if bc_square <= ac_square {
        [1.0 - on_bc, on_bc]
    } else {
        [0.0, on_ac]
    }
}

impl<'a> Ground<'a> {
    /// The surface of a scene with these poses.
    #[must_use]
    pub fn of(setup: &'a Setup, poses: &'a [Pose]) -> Self {
        Self {
            triangles: &setup.surface.triangles,
            corners: &setup.corners,
            vertices: &setup.vertices,
            poses,
        }
    }
}

impl Ground<'_> {
    fn pose(&self, triangle: u32) -> &Pose {
        &self.poses[self.triangles[triangle as usize].object as usize]
    }

    pub(super) fn frame(&self, triangle: u32) -> Frame {
        Frame::of([0, 1, 2].map(|corner| {
            self.vertices[self.corners[(3 * triangle + corner) as usize] as usize].position
        }))
    }

    /// The place with given weights of B and C on a triangle with that frame, object space.
    pub(super) fn position(&self, triangle: u32, frame: &Frame, [u, v]: [f32; 2]) -> Vec3 {
        frame.position(&self.triangles[triangle as usize], [u, v])
    }

    /// A place of the world in an object's space.
    pub(super) fn place_in(&self, object: u32, position: Vec3) -> Vec3 {
        place_in_object(&self.poses[object as usize], position)
    }

    /// A direction of the world in an object's space.
    pub(super) fn direction_in(&self, object: u32, direction: Vec3) -> Vec3 {
        turned_to_object(&self.poses[object as usize], direction)
    }

    /// A particle's place and heading in world space.
    #[must_use]
    pub fn flight(&self, particle: &Particle, motion: &Motion) -> Flight {
        let pose = self.pose(particle.triangle);
        let frame = self.frame(particle.triangle);
        let position = self.position(particle.triangle, &frame, [particle.u, particle.v]);
        let heading = motion.heading_p * frame.p + motion.heading_h * frame.h;
        Flight {
            position: place_in_world(pose, position),
            heading: turned_to_world(pose, heading),
            normal: turned_to_world(pose, frame.normal),
        }
    }

    /// The landing of a particle on a triangle: `u` and `v`, and the heading.
    #[must_use]
    pub fn landing(&self, triangle: u32, flight: &Flight) -> ([f32; 2], [f32; 2]) {
        let shape = &self.triangles[triangle as usize];
        let pose = self.pose(triangle);
        let frame = self.frame(triangle);
        let place = place_in_object(pose, flight.position) - frame.origin;
        let weights = nearest_weights(shape, dot3(place, frame.p), dot3(place, frame.h));
        let from = turned_to_object(pose, flight.normal);
        let heading = folded(turned_to_object(pose, flight.heading), from, frame.normal);
        let heading = Vec2::new(dot3(heading, frame.p), dot3(heading, frame.h));
        let heading = flat_direction(heading).to_array();
        let u = within(weights[0], 0.0, 1.0);
        let v = within(weights[1], 0.0, 1.0 - u);
        ([settled(u), settled(v)], heading)
    }

    /// Lets the particle of a transfer land.
    pub fn land(&self, transfer: &Transfer, particle: &mut Particle, motion: &mut Motion) {
        let flight = Flight {
            position: transfer.position,
            heading: transfer.heading,
            normal: transfer.normal,
        };
        let ([u, v], [heading_p, heading_h]) = self.landing(transfer.triangle, &flight);
        *particle = Particle {
            triangle: transfer.triangle,
            u,
            v,
            id: particle.id,
        };
        *motion = Motion {
            heading_p,
            heading_h,
            pending: settled(motion.pending + transfer.rest),
            flags: motion.flags & !Motion::SELECTED,
        };
    }
}

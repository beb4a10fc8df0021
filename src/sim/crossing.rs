//! Meetings of a walk on one object with the surface of another, and its continuation there. Twin of
//! `shaders/include/crossing.glsl`.

use glam::{Vec2, Vec3};

use super::direction::flat_direction;
use super::ground::{Flight, Ground, folded, place_in};
use super::setup::Setup;
use super::types::{Motion, Particle, Pose, Walker};
use super::walker::{WALK_OUT_OF_ATTEMPTS, walk};
use crate::mesh::surface::{HalfEdge, NONE};
use crate::mesh::trees::nearest::nearest_on_face;
use crate::mesh::trees::search::{UNLIMITED, first_crossing, nearest_on, slack_of};
use crate::mesh::trees::sides::{Sides, is_outside};
use crate::strict::{cross3, dot3, inverse_root, root, share};

/// Planes count as parallel if the squared cross product of their unit normals is less than this.
const PARALLEL_SQUARE: f32 = 1e-6;

/// The surface, the poses of its objects, and the data for crossings and inside tests.
#[derive(Clone, Copy)]
pub struct Terrain<'a> {
    /// The surface and the poses of its objects.
    pub ground: Ground<'a>,
    /// Crossings from triangle to triangle.
    pub halfedges: &'a [HalfEdge],
    /// Trees of triangles.
    pub sides: Sides<'a>,
    /// The first node of each object's tree.
    pub roots: &'a [u32],
    /// The rule that decides whether a place is inside.
    pub sign_rule: u32,
    /// Are walks reflected at open borders?
    pub reflects: bool,
}

/// A crossing: the place where a walk meets another object, in that object's space.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// The face.
    pub slot: u32,
    /// Weight of corner B.
    pub u: f32,
    /// Weight of corner C.
    pub v: f32,
    /// The share of the segment before it.
    pub t: f32,
    /// Heading of the walk.
    pub heading: Vec3,
    /// Normal of the plane of the walk.
    pub normal: Vec3,
}

impl<'a> Terrain<'a> {
    /// The terrain of a scene with these poses; `roots` are those of [`DistanceSetup::roots`](crate::sim::distance::DistanceSetup::roots).
    #[must_use]
    pub fn of(
        setup: &'a Setup,
        poses: &'a [Pose],
        roots: &'a [u32],
        sign_rule: u32,
        reflects: bool,
    ) -> Self {
        let trees = &setup.distance.trees;
        Self {
            ground: Ground::of(setup, poses),
            halfedges: &setup.surface.halfedges,
            sides: Sides {
                faces: &trees.faces,
                nodes: &trees.nodes,
                dipoles: &trees.dipoles,
                pseudonormals: &trees.pseudonormals,
                corners: &setup.corners,
                first_vertex_normal: setup.surface.halfedges.len() as u32,
            },
            roots,
            sign_rule,
            reflects,
        }
    }
}

impl Terrain<'_> {
    /// Walks what remains, over at most `attempts` edges.
    pub fn walk<const CARRIES: bool>(&self, w: &mut Walker, attempts: u32) {
        let triangles = self.ground.triangles;
        walk::<CARRIES>(triangles, self.halfedges, w, attempts, self.reflects);
    }

    /// A walker's place and heading in world space.
    #[must_use]
    pub fn flight_of_walker(&self, w: &Walker) -> Flight {
        let ([u, v], [heading_p, heading_h]) = (w.uv(), w.heading());
        let particle = Particle {
            triangle: w.triangle,
            u,
            v,
            id: 0,
        };
        let motion = Motion {
            heading_p,
            heading_h,
            pending: 0.0,
            flags: 0,
        };
        self.ground.flight(&particle, &motion)
    }

    /// The first crossing of the segment between two places in the target's space; `on` is at one end of it, and
    /// `side` is -1 if the segment goes backwards.
    #[must_use]
    pub fn meeting_between(
        &self,
        target: u32,
        [from, to]: [Vec3; 2],
        on: &Flight,
        side: f32,
    ) -> Option<Meeting> {
        let root = self.roots[target as usize];
        let crossing = first_crossing(self.sides.nodes, self.sides.faces, root, from, to);
        (crossing.slot != NONE).then(|| Meeting {
            slot: crossing.slot,
            u: crossing.u,
            v: crossing.v,
            t: crossing.t,
            heading: side * self.ground.direction_in(target, on.heading),
            normal: self.ground.direction_in(target, on.normal),
        })
    }

    /// The walk that continues from a meeting: outwards if `side` is 1, inwards if it is -1.
    #[must_use]
    pub fn walker_from(&self, meeting: &Meeting, side: f32, rest: f32) -> Walker {
        let triangle = self.sides.faces[meeting.slot as usize].triangle;
        let frame = self.ground.frame(triangle);
        let crossed = cross3(meeting.normal, frame.normal);
        let square = dot3(crossed, crossed);
        let heading = if square < PARALLEL_SQUARE {
            folded(meeting.heading, meeting.normal, frame.normal)
        } else {
            let axis = crossed * inverse_root(square);
            let across = cross3(axis, frame.normal);
            let outwards = if dot3(across, meeting.normal) < 0.0 {
                -side
            } else {
                side
            };
            let along = dot3(meeting.heading, axis);
            along * axis + (outwards * root(1.0 - along * along)) * across
        };
        let heading = Vec2::new(dot3(heading, frame.p), dot3(heading, frame.h));
        let heading = flat_direction(heading);
        Walker::at(triangle, meeting.u, meeting.v, heading.to_array(), rest)
    }

    /// The signed distance of a walker to an object that it has come from.
    fn distance_to_object(&self, object: u32, w: &Walker) -> f32 {
        let tree = self.roots[object as usize];
        let Sides { nodes, faces, .. } = self.sides;
        let place = self
            .ground
            .place_in(object, self.flight_of_walker(w).position);
        let slot = nearest_on(nodes, faces, tree, place, UNLIMITED);
        // As in the kernel for a search that has not ended.
        if slot == NONE {
            return 0.0;
        }
        let point = nearest_on_face(&faces[slot as usize], place);
        let distance = root(point.square);
        if is_outside(&self.sides, self.sign_rule, tree, slot, place, &point) {
            distance
        } else {
            -distance
        }
    }

    /// Is the inner one of two ends less covered by the object that the walk comes from?
    #[must_use]
    pub fn inner_is_better(&self, source: u32, outer: &Walker, inner: &Walker) -> bool {
        let [outer, inner] = [outer, inner].map(|w| self.distance_to_object(source, w));
        inner > outer + 4.0 * slack_of(&self.sides.nodes[self.roots[source as usize] as usize])
    }

    /// The place of a walker in the target's space, at a time of the last step: 0 is its beginning, with the poses
    /// `before`, and 1 its end.
    fn place_at(&self, before: &[Pose], time: f32, w: &Walker, [source, target]: [u32; 2]) -> Vec3 {
        let frame = self.ground.frame(w.triangle);
        let position = self.ground.position(w.triangle, &frame, w.uv());
        let [before, now] = [before, self.ground.poses]
            .map(|poses| place_in(&poses[target as usize], &poses[source as usize], position));
        now + (1.0 - time) * (before - now)
    }

    /// The first crossing of a particle's last step, of length `way`, from a source with a target, and the length walked
    /// since then; `before` are the poses in the step before.
    #[must_use]
    pub fn meeting_behind(
        &self,
        before: &[Pose],
        particle: &Particle,
        motion: &Motion,
        [source, target]: [u32; 2],
        way: f32,
        attempts: u32,
    ) -> Option<(Meeting, f32)> {
        let place_at = |time, w: &Walker| self.place_at(before, time, w, [source, target]);
        let back = [-motion.heading_p, -motion.heading_h];
        let mut w = Walker::at(particle.triangle, particle.u, particle.v, back, way);
        let mut newer = place_at(1.0, &w);
        let mut first = None;
        let mut walked = 0.0;
        for i in 0..=attempts {
            let remaining = w.remaining;
            self.walk::<false>(&mut w, i.min(1));
            let segment = remaining - w.remaining;
            let older_way = walked + segment;
            let goes_on = w.status == WALK_OUT_OF_ATTEMPTS && i < attempts;
            let time = if goes_on {
                1.0 - share(older_way, way)
            } else {
                0.0
            };
            let older = place_at(time, &w);
            let back = self.flight_of_walker(&w);
            if let Some(meeting) = self.meeting_between(target, [older, newer], &back, -1.0) {
                first = Some((meeting, walked + (1.0 - meeting.t) * segment));
            }
            if !goes_on {
                break;
            }
            walked = older_way;
            newer = older;
        }
        first
    }

    /// The walker on the target, with which a walk continues behind a crossing.
    #[must_use]
    pub fn walker_on_target(
        &self,
        meeting: &Meeting,
        source: u32,
        rest: f32,
        attempts: u32,
    ) -> Walker {
        let [outer, inner] = [1.0, -1.0].map(|side| {
            let mut w = self.walker_from(meeting, side, rest);
            self.walk::<false>(&mut w, attempts);
            w
        });
        if self.inner_is_better(source, &outer, &inner) {
            inner
        } else {
            outer
        }
    }
}

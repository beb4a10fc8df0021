//! The network's graph, drawn over a picture of the scene: its edges as lines where they are seen, its nodes as discs.
//!
//! [`NetworkLines`] has a graph in the coordinates of the objects, so that it moves with them. [`Sight`] finds what objects hide of it.
//! What is left comes out as [`Strokes`], in pixels, which [`draw_network`] draws into an image, and the window over its picture.

use std::fmt;
use std::ops::Range;

use glam::{Affine3A, DVec3, Vec2, Vec3, Vec3A};
use image::RgbaImage;

use super::camera::Camera;
use super::rays::Rays;
use crate::sim::Setup;
use crate::sim::graph::{Edge, Graph, NodeKind};

/// The encoded values of pixels behind the lines are multiplied by this.
pub const DIMMED: f32 = 0.55;
/// In small pictures lines are not finer than in one that is this high.
const SMALL: f32 = 540.0;
/// Half the width of a line, and the radii of nodes, in pixels of a picture that is 720 high.
const LINE: f32 = 1.1;
const JUNCTION: f32 = 3.0;
const END: f32 = 2.2;
const FOOD: f32 = 6.5;
/// The dark edge round each of them.
const OUTLINE: f32 = 1.1;
/// What is so much behind the surface is seen, as a share of the scene radius: points lie in the middles of texels.
const BEHIND: f32 = 0.012;

/// The colour of the dark edge round lines and discs, sRGB.
pub const DARK: [u8; 3] = [8, 14, 22];
/// The colour of lines.
pub const LINES: [u8; 3] = [120, 226, 255];
/// The colour of the places where lines meet or end.
pub const NODES: [u8; 3] = [255, 255, 255];
/// The colour of the places where the network reaches food.
pub const AT_FOOD: [u8; 3] = [255, 196, 60];

/// A point of an object, in its coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Anchor {
    object: u32,
    place: Vec3,
}

/// A graph in the coordinates of the objects that it lies on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NetworkLines {
    /// The points of all lines, one line after the other, and then the nodes.
    points: Vec<Anchor>,
    /// Which of them each line has.
    lines: Vec<Range<usize>>,
    /// The nodes that are drawn, with their radii and colours.
    nodes: Vec<(usize, f32, [u8; 3])>,
}

impl NetworkLines {
    /// The lines of a graph that was found on objects with these poses, which count from the origin of the set-up. Of the points of a line
    /// every `stride`th is kept, and the last.
    ///
    /// # Panics
    /// If there are fewer poses than objects.
    #[must_use]
    pub fn new(
        graph: &Graph,
        setup: &Setup,
        world_from_object: &[Affine3A],
        stride: usize,
    ) -> Self {
        let poses = world_from_object.iter();
        let object_from_world: Vec<Affine3A> = poses.map(Affine3A::inverse).collect();
        let (radius, origin) = (f64::from(setup.radius), setup.origin());
        let anchor = |object: u32, place: [f64; 3]| {
            let in_world = (radius * DVec3::from_array(place) - origin).as_vec3();
            let place = object_from_world[object as usize].transform_point3(in_world);
            Anchor { object, place }
        };
        let mut found = Self::default();
        for (object, piece) in graph.edges.iter().flat_map(Edge::pieces_by_object) {
            let first = found.points.len();
            let last = piece.len().saturating_sub(1);
            for (i, place) in piece.iter().enumerate() {
                if i == last || i.is_multiple_of(stride.max(1)) {
                    found.points.push(anchor(object, *place));
                }
            }
            found.lines.push(first..found.points.len());
        }
        for node in &graph.nodes {
            let (radius, color) = match (node.foods.is_empty(), node.kind) {
                (false, _) => (FOOD, AT_FOOD),
                (true, NodeKind::Junction) => (JUNCTION, NODES),
                (true, NodeKind::End | NodeKind::Spot) => (END, NODES),
                (true, NodeKind::Loop | NodeKind::Through) => continue,
            };
            found.nodes.push((found.points.len(), radius, color));
            found.points.push(anchor(node.object, node.place));
        }
        found
    }

    /// How many points there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.points.len()
    }

    /// Finds which points of a range are visible: no object hides them.
    ///
    /// # Panics
    /// If `visible` has no room for one of them, or there is no such point.
    pub fn find_visible(
        &self,
        sight: &Sight,
        from: &Viewpoint,
        range: Range<usize>,
        visible: &mut [bool],
    ) {
        let hiding = sight.hiding(from);
        for i in range {
            let place = from.place(&self.points[i]);
            visible[i] = place.is_some_and(|place| sight.is_free(&hiding, from.eye, place));
        }
    }

    /// What is drawn in a picture of this size: of the points that are `visible`, those in the picture. `camera` is at the eye of `from`.
    #[must_use]
    pub fn strokes(
        &self,
        visible: &[bool],
        from: &Viewpoint,
        camera: &Camera,
        size: Vec2,
    ) -> Strokes {
        let unit = size.y.max(SMALL) / 720.0;
        let (half_width, outline) = (unit * LINE, unit * OUTLINE);
        let pixel = |i: usize| -> Option<Vec2> {
            let is_visible = visible.get(i).copied().unwrap_or_default();
            let place = from.place(&self.points[i]).filter(|_| is_visible)?;
            camera.pixel(place, size)
        };
        let mut lines: Vec<Vec<Vec2>> = Vec::new();
        for line in &self.lines {
            let mut stretch: Vec<Vec2> = Vec::new();
            let mut last = None;
            for i in line.clone() {
                let now = pixel(i);
                match last.zip(now) {
                    Some((from, to)) if meets([from, to], half_width + outline, size) => {
                        if stretch.is_empty() {
                            stretch.push(from);
                        }
                        stretch.push(to);
                    }
                    _ if stretch.is_empty() => {}
                    _ => lines.push(std::mem::take(&mut stretch)),
                }
                last = now;
            }
            if !stretch.is_empty() {
                lines.push(stretch);
            }
        }
        let discs = self.nodes.iter().filter_map(|(i, radius, color)| {
            let (middle, radius) = (pixel(*i)?, unit * radius);
            meets([middle; 2], radius + outline, size).then_some(Disc {
                middle,
                radius,
                color: *color,
            })
        });
        Strokes {
            discs: discs.collect(),
            lines,
            half_width,
            outline,
        }
    }
}

/// May a line of so many pixels to each side meet a picture of this size? False if its box does not. Edges of pixels are blurred.
fn meets([from, to]: [Vec2; 2], half: f32, size: Vec2) -> bool {
    let edge = Vec2::splat(half + 1.0);
    (from.max(to) + edge).cmpge(Vec2::ZERO).all() && (from.min(to) - edge).cmple(size).all()
}

/// From where a scene is seen, and how its objects lie then.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Viewpoint {
    /// The eye. It counts from the origin of the set-up, as poses do.
    pub eye: Vec3,
    /// World from object, one an object. They may scale.
    pub poses: Vec<Affine3A>,
    /// Which objects are not drawn; those beyond the end are.
    pub hidden: Vec<bool>,
}

impl Viewpoint {
    /// Where a point is. None if its object is not drawn.
    fn place(&self, anchor: &Anchor) -> Option<Vec3> {
        let object = anchor.object as usize;
        let pose = self.poses.get(object).filter(|_| self.draws(object))?;
        Some(pose.transform_point3(anchor.place))
    }

    fn draws(&self, object: usize) -> bool {
        !self.hidden.get(object).copied().unwrap_or_default()
    }
}

/// Finds what the surfaces of a scene hide.
pub struct Sight {
    /// Rays through each object, in its coordinates; none if it has no size.
    objects: Vec<Option<Rays>>,
    /// Points so far behind a surface are seen.
    behind: f32,
}

impl fmt::Debug for Sight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Sight").finish_non_exhaustive()
    }
}

/// An object that may hide something.
struct Hiding<'a> {
    rays: &'a Rays,
    object_from_world: Affine3A,
    /// In the object's coordinates.
    eye: Vec3A,
}

impl Sight {
    /// Takes a moment for many triangles. Poses do not matter, so that once is enough for a scene.
    #[must_use]
    pub fn new(setup: &Setup) -> Self {
        let surface = &setup.surface;
        let objects = surface.objects.iter().map(|range| {
            let (first, end) = range.triangles;
            let corners = &surface.corners[first as usize..end as usize];
            Rays::new(&surface.positions, corners)
        });
        Self {
            objects: objects.collect(),
            behind: BEHIND * setup.radius,
        }
    }

    /// The objects that may hide something from there.
    fn hiding(&self, from: &Viewpoint) -> Vec<Hiding<'_>> {
        let objects = self.objects.iter().zip(&from.poses).enumerate();
        let drawn = objects.filter(|(object, _)| from.draws(*object));
        drawn
            .filter_map(|(_, (rays, pose))| {
                let object_from_world = pose.inverse();
                Some(Hiding {
                    rays: rays.as_ref()?,
                    object_from_world,
                    eye: object_from_world.transform_point3a(Vec3A::from(from.eye)),
                })
            })
            .collect()
    }

    /// Does none of the objects hide a place?
    fn is_free(&self, hiding: &[Hiding<'_>], eye: Vec3, place: Vec3) -> bool {
        let distance = place.distance(eye);
        let end = distance - self.behind;
        // What is too near the eye to be drawn hides nothing.
        if end <= 0.0 {
            return true;
        }
        let stop = Vec3A::from(eye.lerp(place, end / distance));
        hiding.iter().all(|object| {
            let way = object.object_from_world.transform_point3a(stop) - object.eye;
            let length = way.length();
            length <= 0.0 || object.rays.is_free(object.eye, way / length, 0.0, length)
        })
    }
}

/// What is drawn of a network, in pixels of the picture. The dark edges of all lines come first, so that none cuts another line; discs come
/// last, each with its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strokes {
    /// Stretches of lines that are seen, each of two points or more.
    pub lines: Vec<Vec<Vec2>>,
    /// Nodes that are seen.
    pub discs: Vec<Disc>,
    /// Half the width of lines.
    pub half_width: f32,
    /// The width of the dark edge round lines and discs.
    pub outline: f32,
}

impl Strokes {
    /// All that is drawn, in order: what comes later covers what came before.
    pub fn marks(&self) -> impl Iterator<Item = Mark<'_>> {
        let wide = self.half_width + self.outline;
        let layers = [(wide, DARK), (self.half_width, LINES)];
        let lines = layers.into_iter().flat_map(move |(half_width, color)| {
            self.lines.iter().map(move |points| Mark::Line {
                points: points.as_slice(),
                half_width,
                color,
            })
        });
        let discs = self.discs.iter().flat_map(move |disc| {
            let wide = disc.radius + self.outline;
            let layers = [(wide, DARK), (disc.radius, disc.color)];
            layers.map(|(radius, color)| Mark::Disc {
                middle: disc.middle,
                radius,
                color,
            })
        });
        lines.chain(discs)
    }
}

/// A shape of one colour, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mark<'a> {
    /// A line through points.
    Line {
        /// Two or more.
        points: &'a [Vec2],
        /// Half its width.
        half_width: f32,
        /// Its colour, sRGB.
        color: [u8; 3],
    },
    /// A disc.
    Disc {
        /// Its middle.
        middle: Vec2,
        /// Its radius.
        radius: f32,
        /// Its colour, sRGB.
        color: [u8; 3],
    },
}

/// A node as it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its middle.
    pub middle: Vec2,
    /// Its radius, without the dark edge.
    pub radius: f32,
    /// Its colour, sRGB.
    pub color: [u8; 3],
}

/// Draws a graph over a picture that `camera` has taken of objects in these poses. What an object hides is left out. Camera and poses count
/// from the origin of the set-up.
pub fn draw_network(
    picture: &mut RgbaImage,
    graph: &Graph,
    setup: &Setup,
    world_from_object: &[Affine3A],
    camera: &Camera,
) {
    for pixel in picture.pixels_mut() {
        for light in &mut pixel.0[..3] {
            *light = (f32::from(*light) * DIMMED).round() as u8;
        }
    }
    let size = Vec2::new(picture.width() as f32, picture.height() as f32);
    let from = Viewpoint {
        eye: camera.eye(),
        poses: world_from_object.to_vec(),
        hidden: Vec::new(),
    };
    let lines = NetworkLines::new(graph, setup, world_from_object, 1);
    let mut visible = vec![false; lines.count()];
    lines.find_visible(&Sight::new(setup), &from, 0..lines.count(), &mut visible);
    for mark in lines.strokes(&visible, &from, camera, size).marks() {
        match mark {
            Mark::Line {
                points,
                half_width,
                color,
            } => {
                for pair in points.windows(2) {
                    draw_line(
                        picture,
                        [pair[0], pair[1]],
                        half_width,
                        color.map(f32::from),
                    );
                }
            }
            Mark::Disc {
                middle,
                radius,
                color,
            } => draw_line(picture, [middle; 2], radius, color.map(f32::from)),
        }
    }
}

/// A line with round ends; a disc if they are one point. Pixels at its edge get a share.
fn draw_line(picture: &mut RgbaImage, [from, to]: [Vec2; 2], half: f32, color: [f32; 3]) {
    let reach = Vec2::splat(half + 1.0);
    let size = Vec2::new(picture.width() as f32, picture.height() as f32);
    let low = (from.min(to) - reach).clamp(Vec2::ZERO, size).as_uvec2();
    let high = (from.max(to) + reach).clamp(Vec2::ZERO, size).as_uvec2();
    let along = to - from;
    let squared = along.length_squared();
    for y in low.y..high.y.min(picture.height()) {
        for x in low.x..high.x.min(picture.width()) {
            let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - from;
            let share = match squared > 0.0 {
                true => (at.dot(along) / squared).clamp(0.0, 1.0),
                false => 0.0,
            };
            let covered = (half + 0.5 - at.distance(share * along)).clamp(0.0, 1.0);
            let pixel = picture.get_pixel_mut(x, y);
            for (light, color) in pixel.0.iter_mut().zip(color) {
                let before = f32::from(*light);
                *light = (before + covered * (color - before)).round() as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::pick::pick;
    use crate::scene::settings::{ObjectSettings, Settings};
    use crate::scene::{Overrides, Scene};
    use crate::sim::graph::Node;
    use glam::DAffine3;
    use image::Rgba;
    use std::path::Path;

    fn node(kind: NodeKind, place: [f64; 3]) -> Node {
        Node {
            kind,
            object: 0,
            place,
            degree: 1,
            width: 0.1,
            foods: Vec::new(),
        }
    }

    /// Would catch: lines and nodes on the far side that show through, lines beside their places, also far from the world's origin, and
    /// a picture that is dimmed where it is empty only.
    #[test]
    fn lines_are_drawn_where_they_are_seen() {
        for x in ["0", "300000"] {
            let set = [
                format!("object.0.position=[{x}, 0, 0]"),
                "atlas.size=128".to_owned(),
                "particles.count=10".to_owned(),
            ];
            let overrides = Overrides {
                set: set.to_vec(),
                ..Overrides::default()
            };
            let scene = Scene::load(Path::new("sphere"), &overrides).unwrap();
            let setup = Setup::new(&scene).unwrap();
            check(&setup, &poses_of(&setup));
        }
    }

    fn poses_of(setup: &Setup) -> Vec<Affine3A> {
        let poses = setup.poses.iter().map(|pose| {
            let pose = DAffine3::from(pose);
            let matrix = pose.matrix3.as_mat3();
            Affine3A::from_mat3_translation(matrix, pose.translation.as_vec3())
        });
        poses.collect()
    }

    fn check(setup: &Setup, poses: &[Affine3A]) {
        let camera = Camera::fitted(Vec3::ZERO, setup.radius, Vec2::new(200.0, 200.0));
        let middle = setup.origin() / f64::from(setup.radius);
        let towards = (camera.eye() / camera.eye().length()).as_dvec3();
        let right = camera.right().as_dvec3();
        let [front, back] = [1.0, -1.0].map(|side| {
            let place =
                |turn: f64| (middle + side * towards * turn.cos() + right * turn.sin()).to_array();
            (-8..=8)
                .map(|i| place(0.05 * f64::from(i)))
                .collect::<Vec<_>>()
        });
        let drawn = |points: &Vec<[f64; 3]>| {
            let mut picture = RgbaImage::from_pixel(200, 200, Rgba([100, 100, 100, 255]));
            let graph = Graph {
                nodes: vec![
                    node(NodeKind::End, points[0]),
                    node(NodeKind::Junction, points[16]),
                ],
                edges: vec![Edge {
                    from: 0,
                    to: 1,
                    length: 0.8,
                    way: 0.8,
                    beyond: [0.0; 2],
                    width: 0.1,
                    trail: 1.0,
                    points: points.clone(),
                    objects: vec![0; points.len()],
                    half_widths: Vec::new(),
                    breaks: Vec::new(),
                }],
            };
            draw_network(&mut picture, &graph, setup, poses, &camera);
            picture
        };
        let plain = Rgba([55, 55, 55, 255]);
        assert!(drawn(&back).pixels().all(|pixel| *pixel == plain));
        let picture = drawn(&front);
        let middle = picture.get_pixel(100, 100).0;
        assert!(middle[2] > 100 && middle[2] > middle[0] + 40, "{middle:?}");
        let changed: Vec<(u32, u32)> = (picture.enumerate_pixels())
            .filter(|(.., pixel)| **pixel != plain)
            .map(|(x, y, _)| (x, y))
            .collect();
        assert!(
            changed.iter().all(|(_, y)| (96..=103).contains(y)),
            "a level line"
        );
        assert!(changed.len() > 100 && picture.pixels().all(|pixel| pixel.0[3] == 255));
    }

    /// A line on the first of two balls beside each other.
    fn line_on_a_ball(setup: &Setup, poses: &[Affine3A], camera: &Camera, size: Vec2) -> Graph {
        let points = (0..=20).map(|i| {
            let pixel = Vec2::new(300.0 + 2.0 * i as f32, 240.0);
            let hit = pick(&setup.surface, poses, &camera.ray(pixel, size));
            let place = hit.expect("the ball is there").position.as_dvec3() + setup.origin();
            (place / f64::from(setup.radius)).to_array()
        });
        let points: Vec<[f64; 3]> = points.collect();
        Graph {
            nodes: vec![
                node(NodeKind::End, points[0]),
                node(NodeKind::End, points[20]),
            ],
            edges: vec![Edge {
                from: 0,
                to: 1,
                length: 0.1,
                way: 0.1,
                beyond: [0.0; 2],
                width: 0.1,
                trail: 1.0,
                objects: vec![0; points.len()],
                half_widths: Vec::new(),
                points,
                breaks: Vec::new(),
            }],
        }
    }

    /// Would catch: lines that stay where their object was, that lie within an object which is drawn larger, that show through an object in
    /// front, and lines on an object that is not drawn or behind one; and what is drawn beside the picture, or missing at its edge.
    #[test]
    fn lines_move_and_hide_with_objects() {
        let ball = |x: f64| ObjectSettings {
            mesh: "builtin:icosphere?subdivisions=4".to_owned(),
            position: [x, 0.0, 0.0],
            ..ObjectSettings::default()
        };
        let mut settings = Settings::default();
        settings.particles.count = 10;
        settings.atlas.size = 128;
        settings.objects = vec![ball(0.0), ball(3.0)];
        let scene = Scene::from_settings("balls".to_owned(), settings, ".".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let poses = poses_of(&setup);
        let size = Vec2::new(640.0, 480.0);
        let camera = Camera {
            distance: 9.0,
            yaw: 0.0,
            pitch: 0.0,
            ..Camera::default()
        };
        let graph = line_on_a_ball(&setup, &poses, &camera, size);
        let sight = Sight::new(&setup);
        let drawn = |lines: &NetworkLines, poses: &[Affine3A], hidden: &[bool]| {
            let from = Viewpoint {
                eye: camera.eye(),
                poses: poses.to_vec(),
                hidden: hidden.to_vec(),
            };
            let mut visible = vec![false; lines.count()];
            lines.find_visible(&sight, &from, 0..lines.count(), &mut visible);
            lines.strokes(&visible, &from, &camera, size)
        };
        let lines = NetworkLines::new(&graph, &setup, &poses, 1);
        let at_first = drawn(&lines, &poses, &[]);
        assert_eq!((at_first.lines.len(), at_first.discs.len()), (1, 2));
        assert_eq!(at_first.lines[0].len(), 21);
        for (i, at) in at_first.lines[0].iter().enumerate() {
            let pixel = Vec2::new(300.0 + 2.0 * i as f32, 240.0);
            assert!(at.distance(pixel) < 0.05, "{at}, not {pixel}");
        }
        // Where the left edge of the picture cuts the line, what is beyond is left out, but for what reaches over the edge.
        let from = Viewpoint {
            eye: camera.eye(),
            poses: poses.clone(),
            hidden: Vec::new(),
        };
        let all = vec![true; lines.count()];
        for (pixels, kept) in [(0.0, [21, 2]), (320.0, [13, 1]), (400.0, [0, 0])] {
            let shifted = Camera {
                shift: Vec2::new(-pixels / (0.5 * size.x), 0.0),
                ..camera
            };
            let strokes = lines.strokes(&all, &from, &shifted, size);
            let points: usize = strokes.lines.iter().map(Vec::len).sum();
            assert_eq!(
                [points, strokes.discs.len()],
                kept,
                "by {pixels}: {strokes:?}"
            );
        }
        // Of every fourth point, the first and the last are still there.
        let fewer = NetworkLines::new(&graph, &setup, &poses, 4);
        let few = drawn(&fewer, &poses, &[]);
        let [first, .., last] = few.lines[0][..] else {
            panic!("{few:?}")
        };
        assert_eq!(few.lines[0].len(), 6);
        assert_eq!([first, last], [at_first.lines[0][0], at_first.lines[0][20]]);

        // The other ball in front of it, and the same with that ball hidden; then the first one hidden.
        let in_front = [poses[0], Affine3A::from_translation(3.0 * Vec3::Z)];
        let nothing = drawn(&lines, &in_front, &[]);
        assert!(nothing.lines.is_empty() && nothing.discs.is_empty());
        assert_eq!(drawn(&lines, &in_front, &[false, true]), at_first);
        let nothing = drawn(&lines, &poses, &[true, false]);
        assert!(nothing.lines.is_empty() && nothing.discs.is_empty());
        // An object that there is no more.
        assert!(drawn(&lines, &[], &[]).lines.is_empty());

        // Moved to the right, and larger: the line is on its surface, farther from the middle of the picture.
        let moved = [
            Affine3A::from_translation(0.5 * Vec3::X) * poses[0],
            poses[1],
        ];
        let right = drawn(&lines, &moved, &[]);
        let larger = [poses[0] * Affine3A::from_scale(Vec3::splat(1.3)), poses[1]];
        let larger = drawn(&lines, &larger, &[]);
        for other in [&right, &larger] {
            assert_eq!((other.lines.len(), other.lines[0].len()), (1, 21));
        }
        assert!(right.lines[0][0].x > at_first.lines[0][0].x + 20.0);
        let length = |strokes: &Strokes| strokes.lines[0][0].distance(strokes.lines[0][20]);
        assert!(length(&larger) > 1.2 * length(&at_first));
    }

    /// Would catch: a panic without anything to draw.
    #[test]
    fn nothing_is_drawn_of_an_empty_graph() {
        let set = ["atlas.size=128", "particles.count=10"];
        let overrides = Overrides {
            set: set.map(str::to_owned).to_vec(),
            ..Overrides::default()
        };
        let scene = Scene::load(Path::new("sphere"), &overrides).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let poses = poses_of(&setup);
        let lines = NetworkLines::new(&Graph::default(), &setup, &poses, 3);
        assert_eq!(lines.count(), 0);
        let from = Viewpoint {
            poses,
            ..Viewpoint::default()
        };
        lines.find_visible(&Sight::new(&setup), &from, 0..0, &mut []);
        let strokes = lines.strokes(&[], &from, &Camera::default(), Vec2::ZERO);
        assert!(strokes.lines.is_empty() && strokes.discs.is_empty());
    }
}

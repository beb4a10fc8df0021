//! The draws of the distance method `raster`: the triangles of every object at their places in the atlas, a
//! little enlarged, and their targets.
//!
//! A triangle is drawn once for each triangle of the other object, to which its fragments take the distance. Distances
//! become depths, and the depth test keeps the smallest one of each texel. A texel counts for the triangle that owns it,
//! as everywhere; outlines need only hold all of a triangle's texels, since fragments of other texels are dropped.
//!
//! Within one object the smallest distance wins, whatever its sign; between objects the smallest signed distance does. Therefore a pass has
//! one other object for each object, the r-th of its pairs in round r, and `distance_merge` follows: it computes the signed distance to the
//! triangle that was drawn, exactly as the other methods do, and keeps the smaller one. The rounding of a mapping affects only which
//! triangle is nearest, never its distance.
//!
//! Triangles beyond reach matter only for the sign of places inside of closed objects, and no place is deeper inside
//! than half of the shortest side of the box. Triangles farther than that are neither drawn nor counted, and a texel on which nothing was
//! drawn is outside. The mappings use that length, or reach if that is more, as their reach.
//!
//! # Precision
//!
//! How many of 65,536 ascending distances remain different as depths, for a reach of 1 (`tests/kernels/distances/depths.rs`):
//!
//! | distances | ordered | clip | logistic | arctangent | linear |
//! | --- | --- | --- | --- | --- | --- |
//! | neighbouring floats round 0 | 16,384 | 1 | 1 | 1 | 1 |
//! | neighbouring floats round 1 | 16,384 | 81 | 3,588 | 6,538 | 16,384 |
//! | evenly from -0.001 to 0.001 | 65,536 | 330 | 33,388 | 54,130 | 25,167 |
//! | evenly from 0.999 to 1.001 (25,167 floats) | 6,293 | 41 | 1,231 | 2,235 | 8,388 |
//! | evenly from -1 to 1 | 65,536 | 65,535 | 65,536 | 65,536 | 65,536 |
//! | 1,048,576 of them evenly from -1 to 1 | 1,048,576 | 504,386 | 1,048,576 | 1,048,576 | 1,048,576 |
//!
//! `clip` is `far / (far - near) (1 - near / z)`, where z, the way from the eye, grows from near at a distance of -reach to far at reach.
//! Near is 0.01 in the table; with 1 it is 3,643 and 7,563 in the second and third row, with 0.0001 2 and 4.
//! All keep the order. Where they end, for a scale of 1: all distances beyond have one depth.
//!
//! | | ordered | clip | logistic | arctangent | linear |
//! | --- | --- | --- | --- | --- | --- |
//! | the smallest distance, from | -3.4e38 | -1 | -80 | -1.7e7 | -1 |
//! | the largest, up to | 3.4e38 | 0.99996 | 16.6 | 5.6e6 | 0.9999999 |
//!
//! How many texels within reach have another nearest triangle than with `bvh`, and the largest difference of distances, in scene
//! radii; over eight scenes with reaches of 0.1 to 0.4, and three of them with one of 20 (`tests/kernels/distances/raster.rs`):
//!
//! | mapping | others | difference | others, far | difference, far |
//! | --- | --- | --- | --- | --- |
//! | ordered | 3.9 % | 1.0e-7 | 5.5 % | 1.5e-7 |
//! | linear | 3.7 % | 5.7e-8 | 7.2 % | 2.2e-6 |
//! | clip | | below 2e-4 | | below 0.05 |
//! | logistic | 4.3 % | 3.0e-7 | 7.0 % | 1.1e-6 |
//! | arctangent | 4.3 % | 3.0e-7 | 6.9 % | 8.6e-7 |
//!
//! All of these others, but for `clip`, share a corner with the nearest triangle: mostly the nearest point lies on both, and the last
//! bits decide. All their signs are those of `bvh`. Distances that are drawn are not negative, so `clip` has them in the farther half,
//! where those that differ by up to `z^2 / near / 2^23` may have one depth: by 1e-5 at z = 1, by 0.005 at 20. The triangle that is taken
//! then may be a stranger, and give the other sign: to at most 0.1 % of the texels with the smaller reaches.
//!
//! # Time
//!
//! Two touching tori of 768 triangles in an atlas of 256 x 256, one of them moving; milliseconds an update on lavapipe with two
//! cores that had other work (medians; only the ratios are meaningful):
//!
//! | method | reach 0.2 | reach 1 |
//! | --- | --- | --- |
//! | bvh | 10 | 36 |
//! | brute | 160 | 235 |
//! | raster | 112 + 2 for the merge | 1,340 + 2 |
//!
//! A pair of objects has three corners for each triangle of one and each of the other. Draws are split so that none has
//! more than [`MOST_IN_A_DRAW`], and scenes with a pair of more than [`MOST_CORNERS`] are refused.
//!
//! The mappings take the same time. With a short reach most of it goes into corners of triangles that turn out to be too
//! far apart, 3.5 million of them; with a long one into fragments, which come in groups of few texels. Therefore the method is for
//! comparisons, and for small meshes.

mod images;

use glam::{DVec2, Vec2, Vec3, Vec4};

use super::distance::{DepthLengths, DistanceUpdate};
use super::draws::DistanceRasterParams;
use super::setup::{Setup, others};
use super::types::SurfaceSample;
use crate::mesh::surface::Surface;
use crate::scene::parameters::grouped;
use crate::scene::settings::Settings;
use bytemuck::{Pod, Zeroable};

pub use images::{Raster, raster_options};

/// Most corners of a draw, unless one triangle of the other object has more: half a second on lavapipe. Devices show
/// pictures of other programs between draws, and count corners in 32 bits.
pub const MOST_IN_A_DRAW: u32 = 1 << 24;

/// Most corners of a pair of objects: a minute on lavapipe.
pub const MOST_CORNERS: u64 = (1 << 31) - 1;

/// How far outlines extend beyond triangles, in texels: more than rounding moves what is drawn.
const MARGIN: f64 = 1.0 / 16.0;

/// A triangle of the picture that holds the centres of all texels that a triangle owns.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Outline {
    /// In texels.
    pub corners: [Vec2; 3],
    /// The triangle.
    pub triangle: u32,
    /// Nothing.
    pub pad0: u32,
}

/// The data of the draws, on the host.
#[derive(Clone, Debug)]
pub struct RasterLayout {
    /// Outlines of the triangles that own texels, object by object.
    pub outlines: Vec<Outline>,
    /// For each outline: where its triangle's texels begin in `texels`, and one past the last.
    pub owned: Vec<(u32, u32)>,
    /// Owned texels, triangle by triangle.
    pub texels: Vec<u32>,
    /// One per triangle: a ball round it, centre and radius, object space.
    pub bounds: Vec<Vec4>,
    /// One per triangle: its place among the faces.
    pub slots: Vec<u32>,
    /// One per texel: the surface point under its centre, and the triangle that owns it in place of the texel.
    pub places: Vec<SurfaceSample>,
    /// The outlines of each object.
    pub ranges: RasterRanges,
}

/// The range of each object's outlines.
#[derive(Clone, Debug)]
pub struct RasterRanges {
    /// First outline of each object, and one past the last.
    objects: Vec<(u32, u32)>,
    /// Width and height of the target, texels.
    pub(super) size: [u32; 2],
}

/// One draw: an object and another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RasterDraw {
    /// Three for each outline.
    pub vertices: u32,
    /// One for each triangle of the other object.
    pub instances: u32,
    /// Parameters of the shaders.
    pub params: DistanceRasterParams,
}

impl RasterRanges {
    /// The draws in a round of an update.
    #[must_use]
    pub fn draws(
        &self,
        update: &DistanceUpdate,
        round: u32,
        reach: f32,
        depths: DepthLengths,
    ) -> Vec<RasterDraw> {
        let jobs = update.jobs.iter().zip(&update.objects);
        jobs.filter(|(job, _)| round < job.pair_count)
            .flat_map(|(job, &object)| {
                let index = (job.first_pair + round) as usize;
                let pair = &update.pairs[index];
                let (first, end) = self.objects[object as usize];
                let [width, height] = self.size;
                let farthest = update.farthest[index];
                let draw = RasterDraw {
                    vertices: 3 * (end - first),
                    instances: pair.face_count,
                    params: DistanceRasterParams {
                        x: pair.x,
                        y: pair.y,
                        z: pair.z,
                        pixel: Vec2::new(2.0 / width as f32, 2.0 / height as f32),
                        first_outline: first,
                        first_face: pair.first_face,
                        first_node: pair.first_node,
                        pitch: width,
                        reach,
                        farthest,
                        near_plane: depths.near,
                        scale: depths.scale_within(farthest),
                    },
                };
                draw.in_pieces(MOST_IN_A_DRAW)
            })
            .collect()
    }
}

impl RasterDraw {
    /// Divides the draw into several, each of some triangles of the other object and of at most `most` corners, but of one
    /// triangle at least.
    fn in_pieces(self, most: u32) -> impl Iterator<Item = Self> {
        let in_one = (most / self.vertices.max(1)).max(1);
        (0..self.instances)
            .step_by(in_one as usize)
            .map(move |first| Self {
                instances: in_one.min(self.instances - first),
                params: DistanceRasterParams {
                    first_face: self.params.first_face + first,
                    ..self.params
                },
                ..self
            })
    }
}

/// With the method `raster`, makes sure that no pair of objects has too many triangles to be drawn.
///
/// # Errors
/// Names the objects of the first such pair, their sizes, and what helps.
pub fn check(surface: &Surface, settings: &Settings) -> Result<(), String> {
    if !settings.uses_raster() {
        return Ok(());
    }
    let triangles = |object: usize| {
        let (first, end) = surface.objects[object].triangles;
        u64::from(end - first)
    };
    let name = |object: usize| &settings.objects[object].name;
    let number = |count: u64| grouped(count as f64);
    for (object, others) in others(settings).into_iter().enumerate() {
        for other in others.into_iter().map(|other| other as usize) {
            let corners = 3 * triangles(object) * triangles(other);
            if corners > MOST_CORNERS {
                return Err(format!(
                    "distance.method = \"raster\" draws the {} triangles of `{}` once for each of the {} of `{}`, \
                     which makes {} corners, and at most {} are drawn: use distance.method = \"bvh\", or smaller meshes",
                    number(triangles(object)),
                    name(object),
                    number(triangles(other)),
                    name(other),
                    number(corners),
                    number(MOST_CORNERS),
                ));
            }
        }
    }
    Ok(())
}

impl RasterLayout {
    /// The layout of a setup with several objects.
    #[must_use]
    pub fn new(setup: &Setup) -> Self {
        let (surface, atlas) = (&setup.surface, &setup.atlas);
        let nothing = SurfaceSample {
            position: Vec3::ZERO,
            texel: crate::mesh::surface::NONE,
        };
        let mut places = vec![nothing; atlas.texel_count()];
        let mut texels = Vec::with_capacity(setup.distance.samples.len());
        for sample in &setup.distance.samples {
            places[sample.texel as usize] = SurfaceSample {
                position: sample.position,
                texel: atlas.owner[sample.texel as usize],
            };
            texels.push(sample.texel);
        }
        // Triangles are numbered object by object.
        texels.sort_unstable_by_key(|&texel| (atlas.owner[texel as usize], texel));
        let mut outlines = Vec::new();
        let mut owned = Vec::new();
        let mut first = 0;
        for of_one in texels.chunk_by(|a, b| atlas.owner[*a as usize] == atlas.owner[*b as usize]) {
            let triangle = atlas.owner[of_one[0] as usize];
            let map = &atlas.maps[triangle as usize];
            let corners = [map.origin, map.origin + map.du, map.origin + map.dv];
            let centres = of_one.iter().map(|&t| atlas.centre_of(t).as_dvec2());
            outlines.push(Outline {
                corners: outline(corners.map(Vec2::as_dvec2), &centres.collect::<Vec<_>>())
                    .map(DVec2::as_vec2),
                triangle,
                pad0: 0,
            });
            owned.push((first, first + of_one.len() as u32));
            first += of_one.len() as u32;
        }
        let objects = surface.objects.iter().map(|object| {
            let (first, end) = object.triangles;
            let before = |triangle| outlines.partition_point(|o| o.triangle < triangle) as u32;
            (before(first), before(end))
        });
        let mut slots = vec![0; surface.corners.len()];
        for (slot, face) in setup.distance.trees.faces.iter().enumerate() {
            slots[face.triangle as usize] = slot as u32;
        }
        let bounds = surface.corners.iter().map(|corners| {
            let corners = corners.map(|vertex| surface.positions[vertex as usize].as_dvec3());
            let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
            let centre = centre.as_vec3();
            let radius = corners.map(|corner| centre.as_dvec3().distance(corner));
            centre.extend(radius.into_iter().fold(0.0, f64::max) as f32)
        });
        Self {
            bounds: bounds.collect(),
            ranges: RasterRanges {
                objects: objects.collect(),
                size: [atlas.pitch, atlas.size],
            },
            outlines,
            owned,
            texels,
            slots,
            places,
        }
    }
}

/// A triangle with these corners, moved outwards by the margin, if that contains all centres; otherwise one round the box of the centres,
/// for triangles that own a texel beside them and for needle-shaped ones.
fn outline(corners: [DVec2; 3], centres: &[DVec2]) -> [DVec2; 3] {
    let [a, b, c] = corners;
    let side = (b - a).perp_dot(c - a).signum();
    let outward = |from: DVec2, to: DVec2| side * (to - from).normalize_or_zero().perp();
    let normals = [outward(a, b), outward(b, c), outward(c, a)].map(|n| -n);
    // The intersection of the lines beside two edges.
    let moved = |corner: DVec2, n: DVec2, m: DVec2| corner + (n + m) * (MARGIN / (1.0 + n.dot(m)));
    let enlarged = [
        moved(a, normals[2], normals[0]),
        moved(b, normals[0], normals[1]),
        moved(c, normals[1], normals[2]),
    ];
    let holds = |centre: &DVec2| {
        let mut edges = corners.iter().zip(&normals);
        edges.all(|(corner, normal)| (*centre - *corner).dot(*normal) < 0.5 * MARGIN)
    };
    let is_sound = normals.iter().all(|n| n.length_squared() > 0.5)
        && enlarged
            .iter()
            .zip(corners)
            .all(|(moved, corner)| moved.distance(corner) < 64.0 * MARGIN);
    if is_sound && centres.iter().all(holds) {
        return enlarged;
    }
    let low = centres.iter().fold(DVec2::INFINITY, |low, c| low.min(*c)) - 0.25;
    let high = centres
        .iter()
        .fold(DVec2::NEG_INFINITY, |high, c| high.max(*c))
        + 0.25;
    let way = high - low;
    // The box's far corner lies within the long side, not on it.
    let long = 2.0 * way + 0.5;
    [
        low,
        low + DVec2::new(long.x, 0.0),
        low + DVec2::new(0.0, long.y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::scene::settings::{DistanceMethod, ObjectSettings};

    fn draw(vertices: u32, instances: u32) -> RasterDraw {
        RasterDraw {
            vertices,
            instances,
            params: DistanceRasterParams {
                first_face: 100,
                ..DistanceRasterParams::default()
            },
        }
    }

    #[test]
    fn pieces_of_a_draw_have_every_face_once() {
        // The reference torus against itself, a mesh that is too large for a draw alone, and small ones.
        for (vertices, instances, most, expected) in [
            (82_944, 27_648, MOST_IN_A_DRAW, 137),
            (30_000_000, 3, MOST_IN_A_DRAW, 3),
            (36, 12, MOST_IN_A_DRAW, 1),
            (6, 7, 18, 3),
            (6, 6, 18, 2),
            (0, 5, 18, 1),
            (6, 0, 18, 0),
        ] {
            let whole = draw(vertices, instances);
            let pieces: Vec<RasterDraw> = whole.in_pieces(most).collect();
            assert_eq!(pieces.len(), expected, "{vertices} x {instances}");
            let faces = pieces
                .iter()
                .flat_map(|p| p.params.first_face..p.params.first_face + p.instances);
            assert!(faces.eq(100..100 + instances), "{vertices} x {instances}");
            for piece in &pieces {
                assert_eq!(piece.vertices, vertices);
                let corners = u64::from(piece.vertices) * u64::from(piece.instances);
                assert!(corners <= u64::from(most) || piece.instances == 1);
            }
        }
    }

    #[test]
    fn pairs_that_are_too_large_are_refused_with_what_does_them() {
        let mut settings = Settings::default();
        settings.distance.method = DistanceMethod::Raster;
        settings.objects = ["left", "middle", "right"]
            .map(|name| ObjectSettings {
                name: name.to_owned(),
                ..ObjectSettings::default()
            })
            .to_vec();
        let mesh = Mesh::builtin("cube").expect("it is there");
        let mut surface = Surface::build(&[(&mesh, 1.0), (&mesh, 1.0), (&mesh, 1.0)]);
        assert_eq!(check(&surface, &settings), Ok(()));
        // The largest two of a size that are drawn have 26,754 triangles each.
        surface.objects[0].triangles = (0, 26_755);
        surface.objects[2].triangles = (26_767, 26_767 + 26_754);
        assert_eq!(check(&surface, &settings), Ok(()));
        surface.objects[2].triangles.1 += 1;
        let problem = check(&surface, &settings).unwrap_err();
        for words in [
            "26,755 triangles of `left`",
            "26,755 of `right`",
            "2,147,490,075 corners",
            "at most 2,147,483,647",
            "distance.method = \"bvh\"",
        ] {
            assert!(problem.contains(words), "{words}: {problem}");
        }
        // Objects that do not count are not drawn, and other methods draw nothing.
        settings.objects[0].distance_to = vec!["middle".to_owned()];
        settings.objects[2].distance_to = vec!["middle".to_owned()];
        assert_eq!(check(&surface, &settings), Ok(()));
        settings.objects[0].distance_to.clear();
        assert!(check(&surface, &settings).is_err());
        settings.distance.method = DistanceMethod::Bvh;
        assert_eq!(check(&surface, &settings), Ok(()));
    }
}

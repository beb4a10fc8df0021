//! Nearest points in double precision: from afar, where in single precision all faces are equally near.

use glam::DVec3;

use super::{Face, Node, Trees};

/// A point of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacePoint {
    /// Of the face in [`Trees::faces`].
    pub slot: u32,
    /// Weight of corner B.
    pub u: f64,
    /// Weight of corner C.
    pub v: f64,
    /// Object space.
    pub position: DVec3,
}

impl Trees {
    /// The point with these weights of a face.
    ///
    /// # Panics
    /// When there is no such face.
    #[must_use]
    pub fn point(&self, slot: u32, u: f64, v: f64) -> FacePoint {
        let Face { a, ab, ac, .. } = self.faces[slot as usize];
        FacePoint {
            slot,
            u,
            v,
            position: a.as_dvec3() + u * ab.as_dvec3() + v * ac.as_dvec3(),
        }
    }

    /// The point of an object that is nearest to a place in its space. Of equally near faces it is any.
    ///
    /// # Panics
    /// When there is no such object, or the place is not finite.
    #[must_use]
    pub fn nearest_in_double(&self, object: usize, place: DVec3) -> FacePoint {
        // The square of the distance, less the place's own, which is the same for all: in a square from afar their difference
        // would be lost.
        let square = |p: DVec3| p.dot(p - 2.0 * place);
        let in_box = |node: &Node| square(place.clamp(node.low.as_dvec3(), node.high.as_dvec3()));
        let root = &self.nodes[self.objects[object].first_node as usize];
        let mut stack = vec![(in_box(root), root.link)];
        let mut best: Option<(f64, FacePoint)> = None;
        while let Some((least, link)) = stack.pop() {
            if best.is_some_and(|(nearest, _)| least >= nearest) {
                continue;
            }
            if link < Node::LEAF {
                let sides = &self.nodes[link as usize..link as usize + 2];
                let mut sides = [&sides[0], &sides[1]].map(|node| (in_box(node), node.link));
                sides.sort_by(|a, b| b.0.total_cmp(&a.0));
                stack.extend(sides);
                continue;
            }
            let first = link % Node::LEAF;
            for slot in first..first + link / Node::LEAF {
                let (u, v) = nearest_weights(&self.faces[slot as usize], place);
                let point = self.point(slot, u, v);
                let square = square(point.position);
                if best.is_none_or(|(nearest, _)| square < nearest) {
                    best = Some((square, point));
                }
            }
        }
        best.expect("an object has a face, and the place is finite")
            .1
    }
}

/// Weights of B and C of the nearest point of a triangle: below its inside, or else the nearest of its sides'. It may have no
/// area, and sides no length: models far from the origin have lost some to single precision.
fn nearest_weights(face: &Face, place: DVec3) -> (f64, f64) {
    let (ab, ac) = (face.ab.as_dvec3(), face.ac.as_dvec3());
    let way = place - face.a.as_dvec3();
    let normal = ab.cross(ac);
    let area = normal.length_squared();
    let u = way.cross(ac).dot(normal) / area;
    let v = ab.cross(way).dot(normal) / area;
    if area > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
        return (u, v);
    }
    let share = |from: DVec3, side: DVec3| {
        let length_squared = side.length_squared();
        if length_squared > 0.0 {
            ((way - from).dot(side) / length_squared).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    let on_bc = share(ab, ac - ab);
    let sides = [
        (share(DVec3::ZERO, ab), 0.0),
        (1.0 - on_bc, on_bc),
        (0.0, share(DVec3::ZERO, ac)),
    ];
    let square = |&(u, v): &(f64, f64)| {
        let point = u * ab + v * ac;
        point.dot(point - 2.0 * way)
    };
    let nearer = |a: &(f64, f64), b: &(f64, f64)| square(a).total_cmp(&square(b));
    sides.into_iter().min_by(nearer).expect("there are three")
}

//! The `mesh` layout: by the models' own texture coordinates.
//!
//! The unit square of a single object is the whole texture. With several objects each has a square in it, with sizes such that all have
//! equally many texels per surface area, times their weights. If a model's coordinates run clockwise (glTF has `v` downwards) they are
//! flipped vertically. An *island* is a set of triangles connected by edges whose coordinates agree on both sides; each is a chart.

use glam::{DVec2, IVec2, Vec2};

use super::super::surface::{AtlasMap, NONE, Surface};
use super::bitmap::{Bitmap, Shape};
use super::fixed::Fixed;
use super::outline::Mask;
use super::owners::{self, Conflict};
use super::{AtlasError, AtlasOptions, Control, MAX_SIZE, overlap};

/// Squares of objects consist of whole cells; the texture has at most this many a side.
const SQUARE_CELLS: u32 = 256;

/// How far outside the unit square coordinates may be, because exporters round them.
const OUTSIDE: f32 = 1e-5;

/// Sizes up to this are tested before an error advises them.
const LARGEST_TRIED: u32 = 8192;

/// Per triangle its map and chart, and the number of charts.
pub(super) fn place(
    surface: &Surface,
    options: &AtlasOptions,
    control: &Control<'_>,
) -> Result<(Vec<AtlasMap>, Vec<u32>, u32), AtlasError> {
    control.step("checking texture coordinates", 0.1)?;
    let models: Vec<Model> = (0..surface.objects.len() as u32)
        .filter(|&object| {
            let (first, end) = surface.objects[object as usize].triangles;
            first < end
        })
        .map(|object| Model::new(surface, object, options))
        .collect::<Result<_, _>>()?;
    let layout = Islands::at(surface, options, &models);
    control.check()?;
    if let Some((a, b)) = overlap::first(&layout.corners, layout.fixed, control)? {
        return Err(overlap_error(surface, a, b));
    }
    control.step("checking texture coordinates", 0.5)?;
    match layout.trouble(surface, options) {
        None => Ok((layout.maps, layout.chart, layout.count)),
        Some(trouble) => Err(room_error(surface, options, &models, trouble, control)?),
    }
}

/// Why there is no room at one size.
#[derive(Clone, Copy, Debug)]
enum Trouble {
    /// An object's square is nothing but gutter.
    NoSquare {
        /// Counted from 0.
        object: u32,
        /// An estimate of the factor by which the texture would have to be larger.
        larger: f64,
    },
    /// Two islands want the same texel.
    TooNear(Conflict),
}

impl Trouble {
    fn larger(self) -> f64 {
        match self {
            Self::NoSquare { larger, .. } | Self::TooNear(Conflict { larger, .. }) => larger,
        }
    }

    /// The object, counted from 1, and the problem.
    fn explained(self, surface: &Surface) -> (u32, String) {
        match self {
            Self::NoSquare { object, .. } => (
                object + 1,
                "its square has no texel inside the gutter".to_owned(),
            ),
            Self::TooNear(Conflict {
                triangles: [a, b], ..
            }) => {
                let (object, t) = in_object(surface, a);
                let (other_object, other) = in_object(surface, b);
                let of = if other_object == object {
                    String::new()
                } else {
                    format!(" of object {other_object}")
                };
                let problem = format!(
                    "triangle {t} at {} and triangle {other}{of} at {} are of two islands that are too near to each \
                     other",
                    uv_of(surface, a),
                    uv_of(surface, b)
                );
                (object, problem)
            }
        }
    }
}

/// The layout at one size.
struct Islands {
    fixed: Fixed,
    corners: Vec<[IVec2; 3]>,
    maps: Vec<AtlasMap>,
    chart: Vec<u32>,
    count: u32,
    /// The object with the smallest square, counted from 0, and how many texels it lacks to be more than gutter; `None` if it lacks none.
    missing: Option<(u32, u32)>,
}

impl Islands {
    fn at(surface: &Surface, options: &AtlasOptions, models: &[Model]) -> Self {
        let fixed = Fixed::new(options.size, options.gutter);
        let mut squares = squares(models, options);
        let least = models.iter().zip(&squares);
        let least = least.min_by_key(|(_, square)| square.side);
        let missing = least
            .filter(|(_, square)| square.side < 1)
            .map(|(model, square)| (model.object, square.side.abs_diff(1)));
        for square in &mut squares {
            square.side = square.side.max(0);
        }
        let corners: Vec<[IVec2; 3]> = models
            .iter()
            .zip(&squares)
            .flat_map(|(model, &square)| model.corners(fixed, square))
            .collect();
        let (chart, count) = islands(surface, &corners);
        Self {
            fixed,
            maps: corners
                .iter()
                .map(|&corners| fixed.map_of(corners))
                .collect(),
            corners,
            chart,
            count,
            missing,
        }
    }

    fn trouble(&self, surface: &Surface, options: &AtlasOptions) -> Option<Trouble> {
        if let Some((object, missing)) = self.missing {
            let gutters = 2.0 * f64::from(options.gutter);
            return Some(Trouble::NoSquare {
                object,
                larger: 2.0 + gutters + f64::from(missing),
            });
        }
        owners::conflict(surface, &self.maps, &self.chart, options).map(Trouble::TooNear)
    }
}

/// One object's coordinates.
struct Model<'a> {
    /// Counted from 0.
    object: u32,
    uvs: &'a [[Vec2; 3]],
    upside_down: bool,
    /// The side of its square, relative to the others.
    side: f64,
}

impl<'a> Model<'a> {
    fn new(surface: &'a Surface, object: u32, options: &AtlasOptions) -> Result<Self, AtlasError> {
        let problem = |problem: String| AtlasError::OwnUvs {
            object: object + 1,
            problem,
        };
        let uvs = surface.uvs[object as usize].as_deref();
        let uvs =
            uvs.ok_or_else(|| problem("it has none, or not for every triangle".to_owned()))?;
        let mut signed = 0.0;
        let mut area = 0.0;
        for (t, corners) in uvs.iter().enumerate() {
            let outside = |uv: &Vec2| {
                uv.min_element() < -OUTSIDE || uv.max_element() > 1.0 + OUTSIDE || !uv.is_finite()
            };
            if let Some(uv) = corners.iter().find(|uv| outside(uv)) {
                let at = format!("triangle {t} reaches {}, outside the unit square", at(uv));
                return Err(problem(at));
            }
            let [a, b, c] = corners.map(|uv| uv.as_dvec2());
            let twice = (b - a).perp_dot(c - a);
            if twice == 0.0 {
                return Err(problem(format!(
                    "triangle {t} has no area at {}",
                    at(&corners[0])
                )));
            }
            signed += twice;
            area += 0.5 * twice.abs();
        }
        let (first, end) = surface.objects[object as usize].triangles;
        let on_surface: f64 = (first..end).map(|t| surface.area(t)).sum();
        let weight = match options.weights.get(object as usize) {
            Some(&weight) if weight > 0.0 && weight.is_finite() => f64::from(weight),
            _ => 1.0,
        };
        Ok(Self {
            object,
            uvs,
            upside_down: signed < 0.0,
            side: (weight * on_surface / area).sqrt(),
        })
    }

    fn corners(&self, fixed: Fixed, square: Square) -> impl Iterator<Item = [IVec2; 3]> + '_ {
        let place = move |uv: Vec2| {
            let mut uv = uv.as_dvec2().clamp(DVec2::ZERO, DVec2::ONE);
            if self.upside_down {
                uv.y = 1.0 - uv.y;
            }
            let origin = square.origin.as_dvec2();
            ((origin + f64::from(square.side) * uv) * f64::from(fixed.texel))
                .round()
                .as_ivec2()
        };
        self.uvs.iter().map(move |corners| corners.map(place))
    }
}

fn at(uv: &Vec2) -> String {
    format!("uv ({:.4}, {:.4})", uv.x, uv.y)
}

/// The place of an object's unit square, in texels: its part of the texture without a gutter on each side.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Square {
    origin: IVec2,
    side: i32,
}

impl Square {
    fn inside(origin: IVec2, side: i32, gutter: u32) -> Self {
        let gutter = gutter.min(1 << 15) as i32;
        Self {
            origin: origin + gutter.min(side / 2),
            side: side - 2 * gutter,
        }
    }
}

/// The largest squares that fit, each in the lowest place that is free, large ones first.
fn squares(models: &[Model], options: &AtlasOptions) -> Vec<Square> {
    let (size, gutter) = (options.size, options.gutter);
    if models.len() == 1 {
        return vec![Square::inside(IVec2::ZERO, size as i32, gutter)];
    }
    let columns = (models.len() as f64).sqrt().ceil() as u32;
    let cell = size.div_ceil(SQUARE_CELLS.max(4 * columns));
    let (cells, cell) = (size / cell, cell as i32);
    let mut order: Vec<usize> = (0..models.len()).collect();
    order.sort_by(|&a, &b| models[b].side.total_cmp(&models[a].side).then(a.cmp(&b)));
    let pack = |scale: f64| {
        let mut bitmap = Bitmap::new(cells as usize, cells as usize);
        let mut squares = vec![None; models.len()];
        for &index in &order {
            let side = ((models[index].side * scale) as usize).max(1);
            if side > cells as usize {
                return None;
            }
            let mut mask = Mask::new(side, side);
            for y in 0..side {
                mask.take(y, 0, side);
            }
            let shape = Shape::new(mask);
            let [x, y] = bitmap.lowest(&shape, 0, cells as usize)?;
            bitmap.take(&shape, [x, y]);
            let origin = IVec2::new(x as i32, y as i32) * cell;
            squares[index] = Some(Square::inside(origin, side as i32 * cell, gutter));
        }
        squares.into_iter().collect::<Option<Vec<Square>>>()
    };
    let largest = models[order[0]].side;
    let (mut low, mut high) = (0.0, f64::from(cells + 1) / largest);
    let mut best = None;
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        match pack(middle) {
            Some(squares) => {
                best = Some(squares);
                low = middle;
            }
            None => high = middle,
        }
    }
    // More objects than cells: no room for any.
    best.unwrap_or_else(|| vec![Square::inside(IVec2::ZERO, 0, gutter); models.len()])
}

/// The island of each triangle, and the number of islands, which are numbered by their first triangles.
fn islands(surface: &Surface, corners: &[[IVec2; 3]]) -> (Vec<u32>, u32) {
    let mut parent: Vec<u32> = (0..corners.len() as u32).collect();
    fn root(parent: &mut [u32], mut t: u32) -> u32 {
        while parent[t as usize] != t {
            parent[t as usize] = parent[parent[t as usize] as usize];
            t = parent[t as usize];
        }
        t
    }
    for h in 0..surface.halfedges.len() as u32 {
        let twin = surface.halfedges[h as usize].twin;
        if twin == NONE || twin < h {
            continue;
        }
        let ends = |h: u32| {
            let corners = &corners[h as usize / 3];
            [corners[h as usize % 3], corners[(h as usize + 1) % 3]]
        };
        let [a, b] = ends(h);
        if ends(twin) == [b, a] {
            let [p, q] = [h / 3, twin / 3].map(|t| root(&mut parent, t));
            parent[p.max(q) as usize] = p.min(q);
        }
    }
    let mut chart = vec![NONE; corners.len()];
    let mut count = 0;
    for t in 0..corners.len() as u32 {
        let root = root(&mut parent, t);
        if root == t {
            chart[t as usize] = count;
            count += 1;
        } else {
            chart[t as usize] = chart[root as usize];
        }
    }
    (chart, count)
}

/// The object of a triangle, counted from 1, and the triangle's number in it.
fn in_object(surface: &Surface, t: u32) -> (u32, u32) {
    let object = surface.triangles[t as usize].object;
    (object + 1, t - surface.objects[object as usize].triangles.0)
}

fn uv_of(surface: &Surface, t: u32) -> String {
    let (object, t) = in_object(surface, t);
    let uvs = surface.uvs[object as usize - 1].as_ref();
    uvs.map_or_else(String::new, |uvs| {
        let corners = uvs[t as usize];
        at(&((corners[0] + corners[1] + corners[2]) / 3.0))
    })
}

fn overlap_error(surface: &Surface, a: u32, b: u32) -> AtlasError {
    let (object, first) = in_object(surface, a);
    let (_, second) = in_object(surface, b);
    AtlasError::OwnUvs {
        object,
        problem: format!(
            "triangles {first} and {second} overlap at {}",
            uv_of(surface, a)
        ),
    }
}

/// The error with a size that works, or for large textures an estimated one, from the factor by which the gap is too small.
fn room_error(
    surface: &Surface,
    options: &AtlasOptions,
    models: &[Model],
    first: Trouble,
    control: &Control<'_>,
) -> Result<AtlasError, AtlasError> {
    let (object, problem) = first.explained(surface);
    let mut larger = options.clone();
    let mut trouble = Some(first);
    while let Some(found) = trouble {
        control.check()?;
        let gutters = 2.0 * f64::from(options.gutter);
        let inside = (f64::from(larger.size) - gutters).max(1.0);
        let size = (gutters + inside * found.larger().max(1.01)).ceil();
        if !size.is_finite() || size > f64::from(MAX_SIZE) {
            return Ok(AtlasError::OwnUvs {
                object,
                problem: format!("{problem} for any atlas.size up to {MAX_SIZE}"),
            });
        }
        larger.size = size as u32;
        trouble = if larger.size <= LARGEST_TRIED {
            Islands::at(surface, &larger, models).trouble(surface, &larger)
        } else {
            None
        };
    }
    Ok(AtlasError::OwnUvsTooDense {
        object,
        gutter: options.gutter,
        size: options.size,
        problem,
        needed: larger.size,
        tried: larger.size <= LARGEST_TRIED,
    })
}

//! The table of buffers: name, type and number of elements of each. The buffers are made from it, and the memory that a scene needs is
//! computed from it beforehand.

use std::marker::PhantomData;
use std::ops::Deref;
use std::sync::Arc;

use bytemuck::Pod;
use glam::{UVec2, UVec4, Vec4};

use super::distance::{TILE_CANDIDATES, TILE_SAMPLES};
use super::pulse::MOST_PULSES;
use super::raster::Outline;
use super::sorting::{most_parts, stretches};
use super::spread::Pass;
use super::types::{
    Border, DistanceJob, Flow, HalfEdge, ListedTile, Mark, Meal, Motion, ObjectPair, Particle,
    Physarum, Population, Pose, SampleTile, Seam, Shell, SurfaceSample, TrailRates, Transfer,
    Triangle, Vertex, Window,
};
use crate::gpu::{
    AnyBuffer, Buffer, BufferCore, Context, DispatchGroups, Domain, GpuError, TexelScalar, Texels,
};
use crate::mesh::atlas::{PackedEntries, PackedRow};
use crate::mesh::strip::StripTriangle;
use crate::mesh::trees::{Dipole, Face, Node};

/// The numbers from which the lengths of buffers follow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Particles.
    pub particles: u64,
    /// Objects.
    pub objects: u64,
    /// Texels of the texture.
    pub texels: u64,
    /// Blocks of texels with at least one texel in use.
    pub blocks: u64,
    /// Gutter texels that are read.
    pub seams: u64,
    /// Texels that exchange across seams.
    pub rows: u64,
    /// Packs of their exchange entries.
    pub entries: u64,
    /// Triangles of all objects.
    pub triangles: u64,
    /// Vertices of all objects.
    pub vertices: u64,
    /// Particles that are reordered at once.
    pub segment: u64,
    /// Bins that particles are sorted into.
    pub bins: u64,
    /// Windows of the particles; 1 where the strategy has none.
    pub windows: u64,
    /// Transfers that the lists hold; 1 where particles do not change objects.
    pub transfers: u64,
    /// Entries of the tables for particles that restart: triangles and objects, or 1 and 1.
    pub respawn: (u64, u64),
    /// Entries of the tables of places that they restart at; 2 and 1 if they restart anywhere.
    pub restarts: (u64, u64),
    /// Texels that have a bias; 0 while nothing is painted.
    pub painted: u64,
    /// Texels that have a weight of a second look; 0 while nothing is painted.
    pub looks: u64,
    /// Texels of which the cell is known; 0 if no rule asks for it.
    pub homes: u64,
    /// Texels of which the object is known; 0 where objects do not differ in what happens to their trails.
    pub trail_objects: u64,
    /// With one particle a cell: particles, and texels; otherwise 0 and 0.
    pub crowd: (u64, u64),
    /// With a population that grows and shrinks: particles, dead ones among them, and texels; otherwise 0 and 0.
    pub population: (u64, u64),
    /// Foods and markers.
    pub foods: u64,
    /// Texels that any of them reaches, plus one; and the number of pairs of such a texel and a food.
    pub scents: (u64, u64),
    /// Texels at which food is projected into the trail.
    pub projected: u64,
    /// Do scents cross from object to object?
    pub crosses: bool,
    /// Owned texels, if there are distances between objects.
    pub samples: u64,
    /// Tiles of them.
    pub tiles: u64,
    /// Tiles of jobs: whole groups of an object.
    pub job_tiles: u64,
    /// Hints per tile.
    pub hints: u64,
    /// Nodes of trees.
    pub nodes: u64,
    /// Triangles that own texels, if distances are drawn.
    pub outlines: u64,
    /// Are distances drawn?
    pub is_drawn: bool,
}

impl Counts {
    /// Texels of fields that only several objects have; buffers have at least one element.
    pub(super) fn field(&self) -> u64 {
        if self.objects > 1 { self.texels } else { 1 }
    }

    /// Ordered pairs of objects.
    fn pairs(&self) -> u64 {
        self.objects * self.objects.saturating_sub(1)
    }

    /// Texels of the fields of food.
    fn food(&self) -> u64 {
        if self.foods > 0 { self.texels } else { 0 }
    }

    /// Words with two bits for each particle's id, if there are any.
    pub(super) fn id_words(&self) -> u64 {
        2 * self.population.0.div_ceil(u32::BITS.into())
    }

    /// `count` with the method `raster`, otherwise 0.
    fn drawn(&self, count: u64) -> u64 {
        if self.is_drawn { count } else { 0 }
    }

    /// Faces of trees.
    fn faces(&self) -> u64 {
        if self.objects > 1 { self.triangles } else { 0 }
    }
}

/// One buffer of the table.
pub struct Row<T> {
    /// In messages and capture tools.
    pub name: &'static str,
    domain: Domain,
    /// Components per texel; 0 if kernels access it as a block only, or by the paths of a [texture](super::texture::Texture).
    components: usize,
    count: fn(&Counts) -> u64,
    element: PhantomData<fn() -> T>,
}

impl<T> Row<T> {
    /// Elements of the buffer.
    pub(super) fn len(&self, counts: &Counts) -> u64 {
        (self.count)(counts)
    }
}

impl<T: Pod> Row<T> {
    /// The buffer, with zeros.
    ///
    /// # Errors
    /// No memory.
    pub(super) fn zeroed(
        &self,
        ctx: &Arc<Context>,
        counts: &Counts,
    ) -> Result<Buffer<T>, GpuError> {
        let len = self.len(counts) as usize;
        Buffer::zeroed_in(ctx, self.name, len, self.domain)
    }

    /// The buffer, with these elements.
    ///
    /// # Errors
    /// No memory.
    ///
    /// # Panics
    /// When their number is not that of the table.
    pub(super) fn of(
        &self,
        ctx: &Arc<Context>,
        counts: &Counts,
        elements: &[T],
    ) -> Result<Buffer<T>, GpuError> {
        let count = self.len(counts);
        assert_eq!(elements.len() as u64, count, "elements of `{}`", self.name);
        Buffer::from_slice_in(ctx, self.name, elements, self.domain)
    }

    /// The buffer as a table of texels for kernels.
    ///
    /// # Errors
    /// When it has more texels than one view of the device holds.
    pub(super) fn texels<S: TexelScalar>(&self, buffer: &Buffer<T>) -> Result<Texels<S>, GpuError> {
        Texels::new(buffer, self.components)
    }

    /// The buffer, both as a block and as texels.
    ///
    /// # Errors
    /// As [`texels`](Self::texels).
    pub(super) fn store<S: TexelScalar>(&self, buffer: Buffer<T>) -> Result<Store<T, S>, GpuError> {
        let texels = self.texels(&buffer)?;
        Ok(Store { buffer, texels })
    }
}

impl<T> Row<T> {
    const fn new(
        name: &'static str,
        domain: Domain,
        components: usize,
        count: fn(&Counts) -> u64,
    ) -> Self {
        let element = PhantomData;
        Self {
            name,
            domain,
            components,
            count,
            element,
        }
    }
}

/// A row, whatever its elements are.
pub trait AnyRow: Sync {
    /// In messages and capture tools.
    fn name(&self) -> &'static str;
    /// Bytes that the buffer takes.
    fn bytes(&self, counts: &Counts) -> u64;
}

impl<T> AnyRow for Row<T> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn bytes(&self, counts: &Counts) -> u64 {
        self.len(counts) * size_of::<T>() as u64
    }
}

/// A buffer, and its view as texels for kernels.
pub struct Store<T, S = u32> {
    buffer: Buffer<T>,
    /// Its texels.
    pub texels: Texels<S>,
}

impl<T, S> Deref for Store<T, S> {
    type Target = Buffer<T>;

    fn deref(&self) -> &Buffer<T> {
        &self.buffer
    }
}

impl<T: Pod, S> AnyBuffer for Store<T, S> {
    fn core(&self) -> &BufferCore {
        self.buffer.core()
    }
}

macro_rules! table {
    ($($row:ident: $element:ty = $name:literal, $domain:ident $components:literal, $count:expr;)*) => {
        $(pub(super) const $row: Row<$element> =
            Row::new($name, $domain, $components, $count);)*

        /// Every buffer of a simulation.
        pub const TABLE: &[&dyn AnyRow] = &[$(&$row),*];
    };
}

/// Bins for one half of the keys that decide which particles leave.
pub const LIMIT_BINS_COUNT: u32 = 1 << 16;

/// No larger than a storage block.
const BLOCK: Domain = Domain::Device;
/// It may be larger than a storage block.
const LARGE: Domain = Domain::Texels;
/// It may be larger than any buffer of the device.
const PAGED: Domain = Domain::Pages;

// Name, limit of size, components of its texels, and number of elements. The fields of `State`, `Transfers`, `FoodBuffers` and `Raster` say
// what each is for.
table! {
    PARTICLES: Particle = "particles", PAGED 4, |n| n.particles;
    MOTIONS: Motion = "motions", PAGED 4, |n| n.particles;
    SEGMENT_PARTICLES: Particle = "segment_particles", PAGED 4, |n| n.segment;
    SEGMENT_MOTIONS: Motion = "segment_motions", PAGED 4, |n| n.segment;
    BINS: u32 = "bins", BLOCK 0, |n| most_parts(n.bins as u32).into();
    BIN_SUMS: u32 = "bin_sums", BLOCK 0, |n| stretches(most_parts(n.bins as u32)).into();
    BIN_PLACES: u32 = "bin_places", BLOCK 0, |n| most_parts(n.bins as u32).into();
    WALKERS: u32 = "walkers", LARGE 1, |n| n.particles;
    WALKERS_NEAR: u32 = "walkers_near", LARGE 1, |n| if n.objects > 1 { n.particles } else { 1 };
    WALKER_COUNT: u32 = "walker_count", BLOCK 0, |_| 3;
    WALKER_GROUPS: DispatchGroups = "walker_groups", BLOCK 0, |_| 3;

    TRAIL_FRONT: f32 = "trail.front", LARGE 0, |n| n.texels;
    TRAIL_BACK: f32 = "trail.back", LARGE 0, |n| n.texels;
    DEPOSITS_FRONT: u32 = "deposits.front", LARGE 0, |n| n.texels;
    DEPOSITS_BACK: u32 = "deposits.back", LARGE 0, |n| n.texels;
    DENSITY: f32 = "density", LARGE 0, |n| n.texels;
    BLOCKS: u32 = "blocks", LARGE 1, |n| n.blocks;
    EXCHANGE_ROWS: PackedRow = "exchange_rows", LARGE 4, |n| n.rows;
    EXCHANGE_ENTRIES: PackedEntries = "exchange_entries", LARGE 4, |n| n.entries;
    SEAMS: Seam = "seams", LARGE 4, |n| n.seams;
    CLEARANCE: u32 = "clearance", LARGE 1, |n| n.texels.div_ceil(4);
    SURROUNDINGS: u32 = "surroundings", LARGE 2, |n| n.texels.div_ceil(2);
    BIAS: f32 = "bias", LARGE 0, |n| n.painted;
    LOOKS: f32 = "looks", LARGE 0, |n| n.looks;
    TRAIL_OBJECTS: u32 = "trail_objects", LARGE 0, |n| n.trail_objects;
    HOMES: u32 = "homes", LARGE 0, |n| n.homes;
    GOALS: u32 = "goals", LARGE 0, |n| n.crowd.1;
    BIDS: u32 = "bids", LARGE 0, |n| n.crowd.1;
    WISHES: Particle = "wishes", PAGED 4, |n| n.crowd.0;
    CLAIMS: UVec4 = "claims", PAGED 4, |n| n.crowd.0;
    OCCUPANTS: u32 = "occupants", LARGE 0, |n| n.population.1;
    NURSERY: u32 = "nursery", LARGE 0, |n| n.population.1;
    NESTS: u32 = "nests", LARGE 0, |n| n.population.1;
    BIRTHS: u32 = "births", LARGE 1, |n| n.population.0;
    PARENTS: u32 = "parents", LARGE 1, |n| n.population.0;
    ID_MARKS: u32 = "id_marks", BLOCK 0, Counts::id_words;
    IDS_BEFORE: u32 = "ids_before", BLOCK 0, Counts::id_words;
    POPULATION: Population = "population", BLOCK 0, |n| u64::from(n.population.0 > 0);

    TRIANGLES: Triangle = "triangles", LARGE 4, |n| n.triangles;
    HALFEDGES: HalfEdge = "halfedges", LARGE 4, |n| 3 * n.triangles;
    STRIPS: StripTriangle = "strips", LARGE 4, |n| n.triangles;
    CORNERS: u32 = "corners", BLOCK 1, |n| 3 * n.triangles;
    VERTICES: Vertex = "vertices", BLOCK 4, |n| n.vertices;
    POSES: Pose = "poses", BLOCK 4, |n| n.objects;
    POSES_BEFORE: Pose = "poses_before", BLOCK 4, |n| n.objects;
    PHYSARUMS: Physarum = "physarums", BLOCK 0, |n| n.objects + 1;
    TRAIL_RATES: TrailRates = "trail_rates", BLOCK 0, |n| Pass::ALL.len() as u64 * n.objects;
    SHELLS: Shell = "shells", BLOCK 0, |_| MOST_PULSES as u64;

    DISTANCES: f32 = "distances", BLOCK 0, |n| n.field().next_multiple_of(4);
    NEAREST: u32 = "nearest", BLOCK 0, |n| n.field().next_multiple_of(4);
    ACROSS: u32 = "across", BLOCK 1, Counts::field;
    ACROSS_TRIANGLES: u32 = "across_triangles", BLOCK 1, Counts::field;
    SAMPLES: SurfaceSample = "samples", LARGE 4, |n| n.samples;
    OWNERS: u32 = "owners", BLOCK 0, |n| n.samples;
    TILES: SampleTile = "tiles", BLOCK 0, |n| n.tiles;
    TILE_STATES: u32 = "tile_states", BLOCK 0, |n| n.tiles;
    MARGINS: f32 = "margins", BLOCK 0, |n| n.tiles * n.hints;
    HINTS: u32 = "hints", BLOCK 1, |n| n.job_tiles * n.hints;
    CANDIDATES: u32 = "candidates", BLOCK 4, |n| n.job_tiles * u64::from(TILE_CANDIDATES);
    LISTED_TILES: ListedTile = "listed_tiles", BLOCK 4, |n| n.job_tiles;
    COVERED: u32 = "covered", BLOCK 1, |n| n.job_tiles * u64::from(TILE_SAMPLES);
    TILE_GROUPS: DispatchGroups = "tile_groups", BLOCK 0, |_| 2;
    COVERED_GROUPS: DispatchGroups = "covered_groups", BLOCK 0, |_| 2;
    FACES: Face = "faces", LARGE 4, Counts::faces;
    NODES: Node = "nodes", LARGE 4, |n| n.nodes;
    DIPOLES: Dipole = "dipoles", LARGE 4, |n| n.nodes;
    PSEUDONORMALS: Vec4 = "pseudonormals", LARGE 4, |n| if n.objects > 1 { 3 * n.triangles + n.vertices } else { 0 };
    ROOTS: u32 = "roots", BLOCK 0, |n| if n.objects > 1 { n.objects } else { 0 };
    DISTANCE_JOBS: DistanceJob = "distance_jobs", BLOCK 0, |n| n.objects;
    DISTANCE_PAIRS: ObjectPair = "distance_pairs", BLOCK 4, Counts::pairs;
    DISTANCE_MOVES: f32 = "distance_moves", BLOCK 0, Counts::pairs;

    WINDOWS: Window = "windows", BLOCK 0, |n| n.windows;
    BORDERS: Border = "borders", BLOCK 0, |n| n.windows;
    FLOW: Flow = "flow", BLOCK 0, |_| 1;
    GROUPS: DispatchGroups = "transfers.groups", BLOCK 0, |_| 5;
    PARTICLE_INDICES: u32 = "particle_indices", BLOCK 0, |n| n.transfers;
    TRANSFERS: Transfer = "transfers", BLOCK 0, |n| n.transfers;
    LIMIT_BINS: u32 = "limit_bins", BLOCK 0, |n| if n.objects > 1 { LIMIT_BINS_COUNT.into() } else { 1 };
    FLUX: u32 = "flux", BLOCK 0, |n| if n.objects > 1 { n.objects * n.objects } else { 1 };
    AREA_SHARES: u32 = "area_shares", BLOCK 0, |n| n.respawn.0;
    OBJECT_TRIANGLES: UVec2 = "object_triangles", BLOCK 0, |n| n.respawn.1;
    RESTARTS: UVec4 = "restarts", BLOCK 0, |n| n.restarts.0;
    RESTART_RANGES: UVec2 = "restart_ranges", BLOCK 0, |n| n.restarts.1;

    MEALS: Meal = "meals", BLOCK 0, |n| n.foods;
    MARKS: Mark = "marks", BLOCK 0, |n| n.foods;
    SCENT: f32 = "scent", LARGE 0, Counts::food;
    SCENT_AROUND: f32 = "scent.around", LARGE 0, |n| if n.crosses { n.food() } else { 0 };
    PLATES: u32 = "plates", LARGE 0, Counts::food;
    SCENTED: UVec2 = "scented", BLOCK 0, |n| if n.foods > 0 { n.scents.0 } else { 0 };
    FALLOFFS: UVec2 = "falloffs", BLOCK 0, |n| if n.foods > 0 { n.scents.1.max(1) } else { 0 };
    PROJECTED: UVec2 = "projected", BLOCK 0, |n| if n.foods > 0 { n.projected.max(1) } else { 0 };
    SCENT_GROUPS: DispatchGroups = "scent_groups", BLOCK 0, |n| u64::from(n.foods > 0);

    OUTLINES: Outline = "outlines", LARGE 4, |n| n.drawn(n.outlines);
    BOUNDS: Vec4 = "bounds", LARGE 4, |n| n.drawn(n.triangles);
    SLOTS: u32 = "slots", BLOCK 0, |n| n.drawn(n.triangles);
    PLACES: SurfaceSample = "places", LARGE 4, |n| n.drawn(n.texels);
    RASTER_TARGET: u32 = "raster.target", BLOCK 0, |n| n.drawn(n.texels);
    RASTER_DEPTH: f32 = "raster.depth", BLOCK 0, |n| n.drawn(n.texels);
    WINNERS: u32 = "winners", BLOCK 0, |n| n.drawn(n.texels);
}

/// Bytes that all buffers take.
#[must_use]
pub fn bytes(counts: &Counts) -> u64 {
    TABLE.iter().map(|row| row.bytes(counts)).sum()
}

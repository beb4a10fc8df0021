//! Every buffer of the simulation, grouped as kernels use them. Names, element types and lengths are in the
//! [table](super::buffers::TABLE).

use std::sync::Arc;

use bytemuck::Pod;
use bytemuck::allocation::pod_collect_to_vec;
use glam::UVec4;

use super::arranged::arranged;
use super::behaviour::physarums;
use super::buffers::{self, Counts, Row, Store};
use super::food::buffers::FoodBuffers;
use super::raster::Raster;
use super::roles::Pair;
use super::setup::Setup;
use super::snapshot::Snapshot;
use super::sorting::{Segments, part_bits};
use super::spread::{texel_objects, trail_rates};
use super::texture::{PingPong, SpreadTables, Texture};
use super::transfers::Transfers;
use super::types::{
    DistanceJob, ListedTile, Motion, ObjectPair, Particle, Physarum, Population, Pose, SampleTile,
    Shell, SurfaceSample, TrailRates,
};
use crate::gpu::{Buffer, Context, DeviceKind, DispatchGroups, GpuError, TexelScalar, Texels};
use crate::mesh::surface::NONE;
use crate::scene::settings::Settings;

/// A bias on `texels` texels with nothing painted.
///
/// # Errors
/// No memory.
pub fn unpainted(ctx: &Arc<Context>, texels: usize) -> Result<Texture<f32>, GpuError> {
    let counts = Counts {
        painted: texels as u64,
        ..Counts::default()
    };
    Texture::new(ctx, buffers::BIAS.zeroed(ctx, &counts)?)
}

/// A bias with these values, one per texel; `None` without values.
///
/// # Errors
/// When the device is lost or its memory is full.
pub fn bias_of(ctx: &Arc<Context>, values: &[f32]) -> Result<Option<Texture<f32>>, GpuError> {
    if values.is_empty() {
        return Ok(None);
    }
    let bias = unpainted(ctx, values.len())?;
    ctx.upload(&bias, values)?;
    Ok(Some(bias))
}

/// Weights of a second look, all of them zero.
///
/// # Errors
/// No memory.
pub fn unlooked(ctx: &Arc<Context>, texels: usize) -> Result<Texture<f32>, GpuError> {
    let counts = Counts {
        looks: texels as u64,
        ..Counts::default()
    };
    Texture::new(ctx, buffers::LOOKS.zeroed(ctx, &counts)?)
}

/// These weights, one per texel; `None` without any.
///
/// # Errors
/// When the device is lost or its memory is full.
pub fn looks_of(ctx: &Arc<Context>, values: &[f32]) -> Result<Option<Texture<f32>>, GpuError> {
    if values.is_empty() {
        return Ok(None);
    }
    let looks = unlooked(ctx, values.len())?;
    ctx.upload(&looks, values)?;
    Ok(Some(looks))
}

/// The object of each texel, if objects differ in what happens to their trails.
///
/// # Errors
/// No memory.
pub fn trail_objects(
    ctx: &Arc<Context>,
    settings: &Settings,
    setup: &Setup,
) -> Result<Option<Texture<u32>>, GpuError> {
    if !settings.has_own_rates() {
        return Ok(None);
    }
    let counts = Counts::of(setup, settings);
    let objects = buffers::TRAIL_OBJECTS.of(ctx, &counts, &texel_objects(setup))?;
    Texture::new(ctx, objects).map(Some)
}

/// Which buffer of each pair has the front role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Roles {
    trail: bool,
    deposits: bool,
}

/// Scratch memory of reordering: for the particles of a segment, or those outside of their objects' windows.
pub struct Sorting {
    /// The copied particles.
    pub particles: Store<Particle>,
    /// Their motions.
    pub motions: Store<Motion>,
    /// Number of the segment's particles in each part of a bin; zeros between steps.
    pub bins: Buffer<u32>,
    /// The sum of each stretch of these.
    pub sums: Buffer<u32>,
    /// The place behind the last particle that was put into each part.
    pub places: Buffer<u32>,
    /// How particles are divided into segments.
    pub segments: Segments,
    /// log2 of how many parts a bin has along each side.
    pub part_bits: u32,
}

/// Memory for particles and their motions.
type Room = (Store<Particle>, Store<Motion>);

impl Sorting {
    fn new(ctx: &Arc<Context>, counts: &Counts) -> Result<Self, GpuError> {
        let make = &Maker {
            ctx,
            counts: *counts,
        };
        let on_cpu = ctx.info().kind == DeviceKind::Cpu;
        Ok(Self {
            particles: make.store_of_zeros(&buffers::SEGMENT_PARTICLES)?,
            motions: make.store_of_zeros(&buffers::SEGMENT_MOTIONS)?,
            bins: make.zeros(&buffers::BINS)?,
            sums: make.zeros(&buffers::BIN_SUMS)?,
            places: make.zeros(&buffers::BIN_PLACES)?,
            segments: Segments::of(counts.particles as u32, on_cpu),
            part_bits: part_bits(counts.bins as u32, on_cpu),
        })
    }

    /// New memory for particles and motions, if their number has changed.
    ///
    /// # Errors
    /// No memory.
    pub(super) fn other_room(
        &self,
        ctx: &Arc<Context>,
        counts: &Counts,
    ) -> Result<Option<Room>, GpuError> {
        if self.particles.len() as u64 == buffers::SEGMENT_PARTICLES.len(counts) {
            return Ok(None);
        }
        let make = &Maker {
            ctx,
            counts: *counts,
        };
        let particles = make.store_of_zeros(&buffers::SEGMENT_PARTICLES)?;
        let motions = make.store_of_zeros(&buffers::SEGMENT_MOTIONS)?;
        Ok(Some((particles, motions)))
    }
}

/// Lists of the particles that `advance` leaves to its other forms.
pub struct Walkers {
    /// The slots of particles whose sensors must walk, from the front, and of those that are near other objects, from the
    /// back.
    pub slots: Store<u32>,
    /// The slots of particles that are near and must walk.
    pub near: Store<u32>,
    /// Three: the lengths of the lists.
    pub count: Buffer<u32>,
    /// The groups of their dispatches.
    pub groups: Buffer<DispatchGroups>,
}

/// Constant tables of the atlas.
pub struct AtlasTables {
    /// Tables of the diffusion kernels.
    pub spread: SpreadTables,
    /// Two texels for each gutter texel that is read.
    pub seams: Texels<u32>,
    /// One per texel, four to a word: radius in texels within which straight lines stay on the surface around the texel.
    pub clearance: Texels<u32>,
}

/// The surface of all objects.
pub struct SurfaceTables {
    /// One per triangle: its shape.
    pub triangles: Texels<u32>,
    /// Three per triangle: the crossing of each edge.
    pub halfedges: Texels<u32>,
    /// All data of a triangle that walks read, in one row, with its map to the atlas.
    pub strips: Texels<u32>,
    /// Three vertex indices per triangle, one by one.
    pub corners: Texels<u32>,
    /// Positions in object space, one per texel.
    pub vertices: Texels<u32>,
}

/// Trees of triangles, in scenes with several objects.
pub struct TreeTables {
    /// One per triangle: its corners, object by object.
    pub faces: Texels<u32>,
    /// Boxes round faces, object by object.
    pub nodes: Texels<u32>,
    /// The far field of each node, for winding numbers.
    pub dipoles: Texels<u32>,
    /// One per half-edge, then one per vertex.
    pub pseudonormals: Texels<u32>,
    /// One per object: the first node of its tree.
    pub roots: Buffer<u32>,
}

/// Poses of objects, and parameters of the particles on them.
pub struct Objects {
    /// World from object; three texels each.
    pub poses: Store<Pose, f32>,
    /// The poses after all commands recorded so far.
    pub recorded: Vec<Pose>,
    /// World from object in the step before.
    pub poses_before: Store<Pose, f32>,
    /// Parameters of particles, one per object, and those of the second look.
    pub physarums: Buffer<Physarum>,
    /// What passes do to the trail on each object, in each kind of pass a row per object; read where objects differ.
    pub rates: Buffer<TrailRates>,
    /// The shells of live pulses, at the front.
    pub shells: Buffer<Shell>,
}

/// Distances to other objects, and the data for computing them. In scenes with one object, texel fields have one element.
pub struct Nearness {
    /// One per texel, gutters filled: signed distance to the nearest other object, world units, within reach either way.
    pub distances: Texture<f32>,
    /// One per texel, set for owned ones: the nearest triangle of another object, `NONE` beyond reach.
    pub nearest: Texture<u32>,
    /// The reach of the present distances, world units; 0 before the first update.
    pub reach: f32,
    /// One per owned texel, object by object: the surface point under its centre.
    pub samples: Store<SurfaceSample>,
    /// One per owned texel, as `samples`: the triangle that owns it.
    pub owners: Buffer<u32>,
    /// One per tile, which is a few samples side by side: the ball round them.
    pub tiles: Buffer<SampleTile>,
    /// One per tile: the state of all its texels, if it is uniform.
    pub tile_states: Buffer<u32>,
    /// One per tile and hint: how far the tile is from being within reach of the other object.
    pub margins: Buffer<f32>,
    /// One per tile of the jobs and other object: a hint, such as a near face of that object.
    pub hints: Store<u32>,
    /// One per tile and candidate: a face.
    pub candidates: Store<u32>,
    /// The tiles whose texels are searched; two texels each.
    pub listed: Store<ListedTile>,
    /// Their samples that other objects cover.
    pub covered: Store<u32>,
    /// Groups of the kernel that searches tiles, then the number of tiles.
    pub tile_groups: Buffer<DispatchGroups>,
    /// Groups of the kernel for covered texels, then their number.
    pub covered_groups: Buffer<DispatchGroups>,
    /// The objects whose distances are updated.
    pub jobs: Buffer<DistanceJob>,
    /// The other objects within their reach; four texels each.
    pub pairs: Store<ObjectPair>,
    /// How far each pair has moved since the last update.
    pub moves: Buffer<f32>,
}

/// Places on other objects, for texels that they cover.
pub struct Across {
    /// One per texel: for covered ones, the place on the other object where walks continue, as a packed atlas position.
    pub places: Store<u32>,
    /// One per texel: the triangle of that place.
    pub triangles: Store<u32>,
    /// One per texel, two to a word: outlook and hue, and marks for places near other objects and covered by them.
    pub surroundings: Store<u32>,
}

/// What particles claim, with one particle a cell.
pub struct Crowd {
    /// One per texel, for owned ones: the cell that the particle in it would come to, as [`goal_word`](super::claims::goal_word) has it.
    pub goals: Texture<u32>,
    /// One per texel, for owned ones: the lowest claim to the cell.
    pub bids: Texture<u32>,
    /// One per particle: itself where it would come to.
    pub wishes: Store<Particle>,
    /// One per particle: the cell that it would come to; the cell that it is in; the texel that it would come to; whether it is alive.
    pub claims: Store<UVec4>,
}

/// A population that grows and shrinks.
pub struct Growth {
    /// One per texel, for owned ones: the particles in the cell.
    pub occupants: Texture<u32>,
    /// One per texel, for owned ones: the lowest rank of particles that claim the cell to divide into.
    pub nursery: Texture<u32>,
    /// One per texel: the triangle on which particles are born in it, or `NONE`.
    pub nests: Texture<u32>,
    /// One per particle: the cell that it claims to divide into, or `NONE`.
    pub births: Store<u32>,
    /// One per particle that is born: the slot of the one that divides.
    pub parents: Store<u32>,
    /// A bit for the id of each particle that divides; then one for that of each dead particle.
    pub id_marks: Buffer<u32>,
    /// One per word of these: the marked ids before it.
    pub ids_before: Buffer<u32>,
    /// One: how many particles are alive, and counters.
    pub population: Buffer<Population>,
}

/// Every buffer of the simulation.
pub struct State {
    /// One per particle: place and id.
    pub particles: Store<Particle>,
    /// One per particle: heading, pending length and flags.
    pub motions: Store<Motion>,
    /// Scratch memory of reordering.
    pub sorting: Sorting,
    /// Lists of particles for the other forms of `advance`.
    pub walkers: Walkers,
    /// Transfers, and the objects' windows.
    pub transfers: Transfers,
    /// One per texel. The front has filled gutters.
    pub trail: PingPong<f32>,
    /// One per texel. Front: counted in this step, zero before it; back: last step's counts.
    pub deposits: PingPong<u32>,
    /// Constant tables of the atlas.
    pub atlas: AtlasTables,
    /// The surface.
    pub surface: SurfaceTables,
    /// Trees of its triangles.
    pub trees: TreeTables,
    /// Poses of objects, and parameters of particles.
    pub objects: Objects,
    /// Distances between objects.
    pub near: Nearness,
    /// Places on other objects.
    pub across: Across,
    /// Inputs and targets of `distance_raster`, if that is the method.
    pub raster: Option<Raster>,
    /// One per texel, gutters filled: trail units that are added to sensor readings, once any are painted.
    pub bias: Option<Texture<f32>>,
    /// One per texel, gutters filled: weights of the second look, once any are painted.
    pub looks: Option<Texture<f32>>,
    /// One per texel: its object, once objects differ in what happens to their trails.
    pub trail_objects: Option<Texture<u32>>,
    /// One per texel: its cell, if a rule asks for it.
    pub homes: Option<Texture<u32>>,
    /// Claims of particles, if there is one a cell.
    pub crowd: Option<Crowd>,
    /// What births and deaths take, if there are any.
    pub growth: Option<Growth>,
    /// Food and markers, if there are any.
    pub food: Option<FoodBuffers>,
}

/// Makes the buffers of a scene.
struct Maker<'a> {
    ctx: &'a Arc<Context>,
    counts: Counts,
}

impl Maker<'_> {
    fn of<T: Pod>(&self, row: &Row<T>, elements: &[T]) -> Result<Buffer<T>, GpuError> {
        row.of(self.ctx, &self.counts, elements)
    }

    fn zeros<T: Pod>(&self, row: &Row<T>) -> Result<Buffer<T>, GpuError> {
        row.zeroed(self.ctx, &self.counts)
    }

    /// A table that kernels read as texels only.
    fn table<T: Pod>(&self, row: &Row<T>, elements: &[T]) -> Result<Texels<u32>, GpuError> {
        row.texels(&self.of(row, elements)?)
    }

    /// A buffer that kernels also access as texels.
    fn store<T: Pod, S: TexelScalar>(
        &self,
        row: &Row<T>,
        elements: &[T],
    ) -> Result<Store<T, S>, GpuError> {
        row.store(self.of(row, elements)?)
    }

    fn store_of_zeros<T: Pod, S: TexelScalar>(
        &self,
        row: &Row<T>,
    ) -> Result<Store<T, S>, GpuError> {
        row.store(self.zeros(row)?)
    }
}

impl State {
    /// Takes the memory and uploads the setup: particles at their start, an empty trail.
    ///
    /// # Errors
    /// No memory.
    pub fn new(ctx: &Arc<Context>, settings: &Settings, setup: &Setup) -> Result<Self, GpuError> {
        let counts = Counts::of(setup, settings);
        let make = &Maker { ctx, counts };
        let start = Snapshot::start(setup);
        let start = arranged(start, setup, &setup.poses, settings.strategy());
        let motions = make.store(&buffers::MOTIONS, &start.motions)?;
        let particles = make.store(&buffers::PARTICLES, &start.particles)?;
        let transfers = Transfers::new(ctx, &counts, settings, setup, &start.transfers)?;
        // Frees large arrays before the rest is allocated.
        drop(start);
        Ok(Self {
            particles,
            motions,
            sorting: Sorting::new(ctx, &counts)?,
            walkers: Walkers {
                slots: make.store_of_zeros(&buffers::WALKERS)?,
                near: make.store_of_zeros(&buffers::WALKERS_NEAR)?,
                count: make.zeros(&buffers::WALKER_COUNT)?,
                groups: make.zeros(&buffers::WALKER_GROUPS)?,
            },
            transfers,
            trail: PingPong::of(
                ctx,
                make.zeros(&buffers::TRAIL_FRONT)?,
                make.zeros(&buffers::TRAIL_BACK)?,
            )?,
            deposits: PingPong::of(
                ctx,
                make.zeros(&buffers::DEPOSITS_FRONT)?,
                make.zeros(&buffers::DEPOSITS_BACK)?,
            )?,
            atlas: atlas_tables(make, setup)?,
            surface: SurfaceTables {
                triangles: make.table(&buffers::TRIANGLES, &setup.surface.triangles)?,
                halfedges: make.table(&buffers::HALFEDGES, &setup.surface.halfedges)?,
                strips: make.table(&buffers::STRIPS, &setup.strips)?,
                corners: make.table(&buffers::CORNERS, &setup.corners)?,
                vertices: make.table(&buffers::VERTICES, &setup.vertices)?,
            },
            trees: tree_tables(make, setup)?,
            objects: Objects {
                poses: make.store(&buffers::POSES, &setup.poses)?,
                recorded: setup.poses.clone(),
                poses_before: make.store(&buffers::POSES_BEFORE, &setup.poses)?,
                physarums: make.of(&buffers::PHYSARUMS, &physarums(settings, setup))?,
                rates: make.of(&buffers::TRAIL_RATES, &trail_rates(settings, setup))?,
                shells: make.zeros(&buffers::SHELLS)?,
            },
            near: nearness(make, setup)?,
            across: across(make, setup)?,
            raster: (settings.uses_raster())
                .then(|| Raster::new(ctx, &counts, setup))
                .transpose()?,
            bias: bias_of(ctx, &setup.bias)?,
            looks: looks_of(ctx, &setup.looks)?,
            trail_objects: trail_objects(ctx, settings, setup)?,
            homes: (counts.homes > 0)
                .then(|| Texture::new(ctx, make.of(&buffers::HOMES, &setup.homes)?))
                .transpose()?,
            crowd: (counts.crowd.0 > 0).then(|| crowd(make)).transpose()?,
            growth: (setup.population)
                .map(|start| growth(make, setup, start))
                .transpose()?,
            food: (!setup.food_set.is_empty())
                .then(|| FoodBuffers::new(ctx, &setup.food_set, &setup.food_set.meals(None)))
                .transpose()?,
        })
    }

    /// The claims of particles.
    ///
    /// # Panics
    /// Unless there is one particle a cell.
    #[must_use]
    pub fn crowd(&self) -> &Crowd {
        self.crowd.as_ref().expect("there is one particle a cell")
    }

    /// What births and deaths take.
    ///
    /// # Panics
    /// If the number of particles is constant.
    #[must_use]
    pub fn growth(&self) -> &Growth {
        self.growth.as_ref().expect("the population changes")
    }

    /// How many particles are alive, and counters, if their number changes.
    pub(super) fn kept_population(&self) -> Option<&Buffer<Population>> {
        Some(&self.growth.as_ref()?.population)
    }

    /// The cell of each texel.
    ///
    /// # Panics
    /// When no rule of the scene asks for it.
    #[must_use]
    pub fn homes(&self) -> &Texture<u32> {
        self.homes.as_ref().expect("a rule asks for cells")
    }

    /// Food and markers.
    ///
    /// # Panics
    /// Without food and markers.
    #[must_use]
    pub fn food(&self) -> &FoodBuffers {
        self.food.as_ref().expect("there is food")
    }

    /// The targets of drawn distances.
    ///
    /// # Panics
    /// With another distance method.
    #[must_use]
    pub fn raster(&self) -> &Raster {
        self.raster.as_ref().expect("the method draws")
    }

    /// Notes the poses of objects after everything recorded so far.
    pub(super) fn follow(&mut self, poses: &[Pose]) {
        if self.objects.recorded != poses {
            self.objects.recorded = poses.to_vec();
        }
    }

    /// Lets two buffers change roles.
    pub fn swap(&mut self, pair: Pair) {
        match pair {
            Pair::Trail => self.trail.swap(),
            Pair::Deposits => self.deposits.swap(),
        }
    }

    /// The present roles of buffers.
    #[must_use]
    pub fn roles(&self) -> Roles {
        Roles {
            trail: self.trail.is_swapped,
            deposits: self.deposits.is_swapped,
        }
    }

    /// Restores earlier roles of the buffers, without changing their contents.
    pub fn return_to(&mut self, roles: Roles) {
        let now = self.roles();
        for (pair, differs) in [
            (Pair::Trail, now.trail != roles.trail),
            (Pair::Deposits, now.deposits != roles.deposits),
        ] {
            if differs {
                self.swap(pair);
            }
        }
    }
}

fn atlas_tables(make: &Maker<'_>, setup: &Setup) -> Result<AtlasTables, GpuError> {
    let atlas = &setup.atlas;
    let clearance = pod_collect_to_vec::<u8, u32>(&setup.clearance);
    Ok(AtlasTables {
        spread: SpreadTables::new(make.ctx, atlas)?,
        seams: make.table(&buffers::SEAMS, &atlas.seams)?,
        clearance: make.table(&buffers::CLEARANCE, &clearance)?,
    })
}

fn crowd(make: &Maker<'_>) -> Result<Crowd, GpuError> {
    Ok(Crowd {
        goals: Texture::new(make.ctx, make.zeros(&buffers::GOALS)?)?,
        bids: Texture::new(make.ctx, make.zeros(&buffers::BIDS)?)?,
        wishes: make.store_of_zeros(&buffers::WISHES)?,
        claims: make.store_of_zeros(&buffers::CLAIMS)?,
    })
}

fn growth(make: &Maker<'_>, setup: &Setup, start: Population) -> Result<Growth, GpuError> {
    let texture = |row: &Row<u32>| Texture::new(make.ctx, make.zeros(row)?);
    Ok(Growth {
        occupants: texture(&buffers::OCCUPANTS)?,
        nursery: texture(&buffers::NURSERY)?,
        nests: Texture::new(make.ctx, make.of(&buffers::NESTS, &setup.nests)?)?,
        births: make.store_of_zeros(&buffers::BIRTHS)?,
        parents: make.store_of_zeros(&buffers::PARENTS)?,
        id_marks: make.zeros(&buffers::ID_MARKS)?,
        ids_before: make.zeros(&buffers::IDS_BEFORE)?,
        population: make.of(&buffers::POPULATION, &[start])?,
    })
}

fn tree_tables(make: &Maker<'_>, setup: &Setup) -> Result<TreeTables, GpuError> {
    let trees = &setup.distance.trees;
    Ok(TreeTables {
        faces: make.table(&buffers::FACES, &trees.faces)?,
        nodes: make.table(&buffers::NODES, &trees.nodes)?,
        dipoles: make.table(&buffers::DIPOLES, &trees.dipoles)?,
        pseudonormals: make.table(&buffers::PSEUDONORMALS, &trees.pseudonormals)?,
        roots: make.of(&buffers::ROOTS, &setup.distance.roots())?,
    })
}

fn nearness(make: &Maker<'_>, setup: &Setup) -> Result<Nearness, GpuError> {
    let distance = &setup.distance;
    let nowhere = vec![NONE; buffers::NEAREST.len(&make.counts) as usize];
    Ok(Nearness {
        distances: Texture::new(make.ctx, make.zeros(&buffers::DISTANCES)?)?,
        nearest: Texture::new(make.ctx, make.of(&buffers::NEAREST, &nowhere)?)?,
        reach: 0.0,
        samples: make.store(&buffers::SAMPLES, &distance.samples)?,
        owners: make.of(&buffers::OWNERS, &distance.owners)?,
        tiles: make.of(&buffers::TILES, &distance.tiles)?,
        tile_states: make.zeros(&buffers::TILE_STATES)?,
        margins: make.zeros(&buffers::MARGINS)?,
        hints: make.store_of_zeros(&buffers::HINTS)?,
        candidates: make.store_of_zeros(&buffers::CANDIDATES)?,
        listed: make.store_of_zeros(&buffers::LISTED_TILES)?,
        covered: make.store_of_zeros(&buffers::COVERED)?,
        tile_groups: make.zeros(&buffers::TILE_GROUPS)?,
        covered_groups: make.zeros(&buffers::COVERED_GROUPS)?,
        jobs: make.zeros(&buffers::DISTANCE_JOBS)?,
        pairs: make.store_of_zeros(&buffers::DISTANCE_PAIRS)?,
        moves: make.zeros(&buffers::DISTANCE_MOVES)?,
    })
}

fn across(make: &Maker<'_>, setup: &Setup) -> Result<Across, GpuError> {
    let nowhere = vec![NONE; make.counts.field() as usize];
    let surroundings = pod_collect_to_vec::<u16, u32>(&setup.surroundings);
    Ok(Across {
        places: make.store(&buffers::ACROSS, &nowhere)?,
        triangles: make.store(&buffers::ACROSS_TRIANGLES, &nowhere)?,
        surroundings: make.store(&buffers::SURROUNDINGS, &surroundings)?,
    })
}

//! Every buffer of the simulation.

use std::sync::Arc;

use bytemuck::allocation::pod_collect_to_vec;

use super::arranged::arranged;
use super::behaviour::physarums;
use super::distance::TILE_CANDIDATES;
use super::food::buffers::FoodBuffers;
use super::raster::Raster;
use super::roles::Pair;
use super::setup::Setup;
use super::snapshot::Snapshot;
use super::sorting::Sorting;
use super::texture::{Counted, PingPong, Spread, Unused, Views};
use super::transfers::Transfers;
use super::types::{
    DistanceJob, ListedTile, Meal, Motion, ObjectPair, Particle, Physarum, Pose, SampleTile,
    SurfaceSample,
};
use crate::gpu::{Buffer, Context, DispatchGroups, Domain, GpuError, Texels};
use crate::mesh::surface::NONE;
use crate::scene::settings::Settings;

/// What was painted for sensors to read.
pub struct Bias {
    /// One a texel, gutters filled: trail units that sensors read more.
    pub field: Buffer<f32>,
    /// The same, as kernels read and write it.
    pub views: Views<f32>,
}

impl Bias {
    /// Nothing is painted on so many texels.
    ///
    /// # Errors
    /// No memory.
    pub fn new(ctx: &Arc<Context>, texels: usize) -> Result<Self, GpuError> {
        let field = Buffer::zeroed_in(ctx, "bias", texels, Domain::Texels)?;
        let views = Views::new(ctx, &field)?;
        Ok(Self { field, views })
    }

    /// These values, one a texel; none where there are none.
    ///
    /// # Errors
    /// When the device is lost or its memory is full.
    pub fn of(ctx: &Arc<Context>, values: &[f32]) -> Result<Option<Self>, GpuError> {
        if values.is_empty() {
            return Ok(None);
        }
        let bias = Self::new(ctx, values.len())?;
        ctx.upload(&bias.field, values)?;
        Ok(Some(bias))
    }
}

/// Which of two buffers each have which role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Roles {
    trail: bool,
    deposits: bool,
    transfers: bool,
    particles: bool,
}

/// Buffers of the kernels that take distances, and of pictures, seen through texel buffers.
pub struct DistanceViews {
    /// One by one.
    pub distances: Texels<f32>,
    /// One by one.
    pub nearest: Texels<u32>,
    /// One a texel.
    pub samples: Texels<u32>,
    /// One by one.
    pub hints: Texels<u32>,
    /// Four at once.
    pub candidates: Texels<u32>,
    /// Two texels each.
    pub listed: Texels<u32>,
    /// One by one.
    pub covered: Texels<u32>,
    /// Four texels each.
    pub pairs: Texels<u32>,
}

/// What lies across, seen through texel buffers.
pub struct AcrossViews {
    /// Places, one by one.
    pub places: Texels<u32>,
    /// Triangles, one by one.
    pub triangles: Texels<u32>,
    /// Surroundings, word by word.
    pub surroundings: Texels<u32>,
}

/// Every buffer of the simulation.
pub struct State {
    /// One a particle: where it is.
    pub particles: Buffer<Particle>,
    /// The same, as kernels read and write it.
    pub particles_view: Texels<u32>,
    /// One a particle: where it is going.
    pub motions: Buffer<Motion>,
    /// The same, as kernels read and write it.
    pub motions_view: Texels<u32>,
    /// Room for both in another order.
    pub sorting: Sorting,
    /// Particles under way between objects, and the objects' windows.
    pub transfers: Transfers,
    /// One a texel. The front has filled gutters.
    pub trail: PingPong<f32>,
    /// One a texel. Front: counted in this step, zero before it; back: last step's counts.
    pub deposits: PingPong<u32>,
    /// One a texel: mean texel area by this texel's area, 0 where no triangle owns it.
    pub density: Buffer<f32>,
    /// The same, as diffusion reads it.
    pub density_views: Views<f32>,
    /// One a block of texels of which any is in use: its first quad.
    pub blocks: Texels<u32>,
    /// Two texels of four words for each texel that exchanges across a seam.
    pub exchange_rows: Texels<u32>,
    /// What it exchanges with; two entries of two words each.
    pub exchange_entries: Texels<u32>,
    /// Two texels for each gutter texel that is read.
    pub seams: Texels<u32>,
    /// One a triangle: its shape.
    pub triangles: Texels<u32>,
    /// Three a triangle: its crossings.
    pub halfedges: Texels<u32>,
    /// What walks ask for, triangle by triangle; its place in the atlas, too.
    pub strips: Texels<u32>,
    /// One a texel, four of them a word: how many texels far straight lines stay on the surface around.
    pub clearance: Texels<u32>,
    /// The slots of particles whose sensors must walk, from the front, and of those that are near other objects, from the
    /// back; where there are several objects, behind them those of particles that are near and must walk.
    pub walkers: Buffer<u32>,
    /// The same, as `advance` lists and reads them.
    pub walkers_view: Texels<u32>,
    /// Three: how many they are.
    pub walker_count: Buffer<u32>,
    /// The groups of the dispatches for them.
    pub walker_groups: Buffer<DispatchGroups>,
    /// What is bound in their place where nobody is listed: no dispatch may write its own groups.
    pub no_groups: Buffer<DispatchGroups>,
    /// What is bound in the place of textures that are written another way.
    pub unused: Unused,
    /// Three vertex indices a triangle, one by one.
    pub corners: Texels<u32>,
    /// Object space, one a texel.
    pub vertices: Texels<u32>,
    /// One an object: world from object.
    pub poses: Buffer<Pose>,
    /// The same as texels, three a pose.
    pub poses_view: Texels<f32>,
    /// What the commands recorded so far leave there.
    pub poses_recorded: Vec<Pose>,
    /// The same in the step before.
    pub poses_before: Buffer<Pose>,
    /// The same as texels, three a pose.
    pub poses_before_view: Texels<f32>,
    /// One an object: what particles do there.
    pub physarums: Buffer<Physarum>,
    /// One a texel, gutters filled: signed distance to the nearest other object, world units, within reach either way.
    /// Like all that follows of length 1 where there is one object.
    pub distances: Buffer<f32>,
    /// One a texel, of owned ones: the triangle of another object that is nearest, `NONE` beyond reach.
    pub nearest: Buffer<u32>,
    /// One an owned texel, object by object: the surface point under its centre.
    pub samples: Buffer<SurfaceSample>,
    /// One a few samples side by side: the ball round them.
    pub tiles: Buffer<SampleTile>,
    /// For each tile of the jobs, as many as objects have others: a face of theirs that is near.
    pub hints: Buffer<u32>,
    /// As many a tile: faces that its hints name.
    pub candidates: Buffer<u32>,
    /// One a tile of `tiles`: what all its texels are, if anything.
    pub tile_states: Buffer<u32>,
    /// As many a tile as it has hints: how far it is from being within reach of the other object.
    pub margins: Buffer<f32>,
    /// The tiles whose texels are looked at.
    pub listed_tiles: Buffer<ListedTile>,
    /// Which of their samples other objects cover.
    pub covered: Buffer<u32>,
    /// What the kernels that look at texels read.
    pub distance_views: DistanceViews,
    /// Groups of the kernel that does that; then how many tiles they are.
    pub tile_groups: Buffer<DispatchGroups>,
    /// Groups of the kernel that looks at what is covered; then how many texels they are.
    pub covered_groups: Buffer<DispatchGroups>,
    /// One a triangle: its corners, object by object.
    pub faces: Texels<u32>,
    /// Boxes round faces, object by object.
    pub nodes: Texels<u32>,
    /// What each node is from afar.
    pub dipoles: Texels<u32>,
    /// One a half-edge, then one a vertex.
    pub pseudonormals: Texels<u32>,
    /// One an owned texel, as `samples`: the triangle that owns it.
    pub owners: Buffer<u32>,
    /// One a texel: for places that are marked as covered, where on the other object walks go on, as packed atlas position.
    pub across: Buffer<u32>,
    /// One a texel: on which triangle that is.
    pub across_triangles: Buffer<u32>,
    /// One a texel, two of them a word: outlook and hue, and marks for places near other objects and covered by them.
    pub surroundings: Buffer<u32>,
    /// All three, as sensors read them.
    pub across_views: AcrossViews,
    /// One an object: the first node of its tree.
    pub roots: Buffer<u32>,
    /// The objects whose distances are being taken.
    pub distance_jobs: Buffer<DistanceJob>,
    /// Which others they have within reach.
    pub distance_pairs: Buffer<ObjectPair>,
    /// How far each pair has moved since the last time.
    pub distance_moves: Buffer<f32>,
    /// How far the distances that have been taken are told, world units; 0 while none have been.
    pub reach: f32,
    /// What `distance_raster` draws, and what it draws into, where that is the method.
    pub raster: Option<Raster>,
    /// What attracts, repels or may not be entered, once somebody has painted that.
    pub bias: Option<Bias>,
    /// Food and markers, where there are any.
    pub food: Option<FoodBuffers>,
    /// What is bound where there are none.
    pub no_meals: Buffer<Meal>,
}

/// How many lists of walkers there is room for: one that two share, and with several objects a third.
pub(super) fn walker_lists(objects: usize) -> usize {
    if objects > 1 { 2 } else { 1 }
}

impl State {
    /// What was painted; where nobody has, what is there instead is read by nothing.
    #[must_use]
    pub fn bias_texels(&self) -> &Texels<f32> {
        let bias = self.bias.as_ref();
        bias.map_or(&self.trail.front_views.texels, |bias| &bias.views.texels)
    }

    /// Food and markers.
    ///
    /// # Panics
    /// Where there are none.
    #[must_use]
    pub fn food(&self) -> &FoodBuffers {
        self.food.as_ref().expect("there is food")
    }

    /// What distances are drawn into.
    ///
    /// # Panics
    /// Where they are taken another way.
    #[must_use]
    pub fn raster(&self) -> &Raster {
        self.raster.as_ref().expect("the method draws")
    }

    /// Where diffusion writes to.
    #[must_use]
    pub fn spread(&self, outgrows_block: bool) -> Spread<'_> {
        (self.unused).spread(outgrows_block, &self.trail, &self.deposits)
    }

    /// Where deposits are counted.
    #[must_use]
    pub fn counted(&self, outgrows_block: bool) -> Counted<'_> {
        self.unused.counted(outgrows_block, &self.deposits)
    }

    /// Takes the memory and uploads the setup: particles at their start, an empty trail.
    pub fn new(ctx: &Arc<Context>, settings: &Settings, setup: &Setup) -> Result<Self, GpuError> {
        let large = Domain::Texels;
        let start = Snapshot::start(setup);
        let start = arranged(start, setup, &setup.poses, settings.strategy());
        let motions = Buffer::from_slice_in(ctx, "motions", &start.motions, large)?;
        let particles = Buffer::from_slice_in(ctx, "particles", &start.particles, large)?;
        let transfers = Transfers::new(ctx, settings, setup, &start.transfers)?;
        // Large ones need not be there twice while the rest is made.
        drop(start);
        let texels = setup.atlas.density.len();
        let objects = setup.poses.len();
        let field = if objects > 1 { texels } else { 1 };
        let exchange = setup.atlas.exchange.packed(&setup.atlas.density);
        let density = Buffer::from_slice_in(ctx, "density", &setup.atlas.density, large)?;
        let distances: Buffer<f32> = Buffer::zeroed(ctx, "distances", field)?;
        let nearest = Buffer::from_slice(ctx, "nearest", &vec![NONE; field])?;
        let samples = Buffer::from_slice_in(ctx, "samples", &setup.distance.samples, large)?;
        let hints: Buffer<u32> = Buffer::zeroed(ctx, "hints", setup.distance.hints_len())?;
        let candidates: Buffer<u32> = Buffer::zeroed(
            ctx,
            "candidates",
            setup.distance.tiles_len() * TILE_CANDIDATES as usize,
        )?;
        let listed_tiles: Buffer<ListedTile> =
            Buffer::zeroed(ctx, "listed_tiles", setup.distance.tiles_len())?;
        let covered: Buffer<u32> =
            Buffer::zeroed(ctx, "covered", setup.distance.samples_in_tiles())?;
        let distance_pairs: Buffer<ObjectPair> =
            Buffer::zeroed(ctx, "distance_pairs", objects * (objects - 1))?;
        let across = Buffer::from_slice(ctx, "across", &vec![NONE; field])?;
        let surroundings = pod_collect_to_vec::<u16, u32>(&setup.surroundings);
        let surroundings = Buffer::from_slice_in(ctx, "surroundings", &surroundings, large)?;
        let across_triangles = Buffer::from_slice(ctx, "across_triangles", &vec![NONE; field])?;
        let clearance = pod_collect_to_vec::<u8, u32>(&setup.clearance);
        let clearance = Buffer::from_slice_in(ctx, "clearance", &clearance, large)?;
        let corners = Buffer::from_slice(ctx, "corners", &setup.corners)?;
        let vertices = Buffer::from_slice(ctx, "vertices", &setup.vertices)?;
        let walkers = Buffer::zeroed_in(
            ctx,
            "walkers",
            setup.particles.len() * walker_lists(objects),
            large,
        )?;
        let poses = Buffer::from_slice(ctx, "poses", &setup.poses)?;
        let poses_before = Buffer::from_slice(ctx, "poses_before", &setup.poses)?;
        Ok(Self {
            particles_view: Texels::new(&particles, 4)?,
            particles,
            motions_view: Texels::new(&motions, 4)?,
            motions,
            sorting: Sorting::new(ctx, setup)?,
            distance_views: DistanceViews {
                distances: Texels::new(&distances, 1)?,
                nearest: Texels::new(&nearest, 1)?,
                samples: Texels::new(&samples, 4)?,
                hints: Texels::new(&hints, 1)?,
                candidates: Texels::new(&candidates, 4)?,
                listed: Texels::new(&listed_tiles, 4)?,
                covered: Texels::new(&covered, 1)?,
                pairs: Texels::new(&distance_pairs, 4)?,
            },
            transfers,
            trail: PingPong::new(ctx, "trail", texels)?,
            deposits: PingPong::new(ctx, "deposits", texels)?,
            density_views: Views::new(ctx, &density)?,
            density,
            blocks: Texels::new(
                &Buffer::from_slice_in(ctx, "blocks", &setup.atlas.blocks, large)?,
                1,
            )?,
            exchange_rows: Texels::new(
                &Buffer::from_slice_in(ctx, "exchange_rows", &exchange.rows, large)?,
                4,
            )?,
            exchange_entries: Texels::new(
                &Buffer::from_slice_in(ctx, "exchange_entries", &exchange.entries, large)?,
                4,
            )?,
            seams: Texels::new(
                &Buffer::from_slice_in(ctx, "seams", &setup.atlas.seams, large)?,
                4,
            )?,
            triangles: Texels::new(
                &Buffer::from_slice_in(ctx, "triangles", &setup.surface.triangles, large)?,
                4,
            )?,
            halfedges: Texels::new(
                &Buffer::from_slice_in(ctx, "halfedges", &setup.surface.halfedges, large)?,
                4,
            )?,
            strips: Texels::new(
                &Buffer::from_slice_in(ctx, "strips", &setup.strips, large)?,
                4,
            )?,
            clearance: Texels::new(&clearance, 1)?,
            walkers_view: Texels::new(&walkers, 1)?,
            walkers,
            walker_count: Buffer::zeroed(ctx, "walker_count", 3)?,
            unused: Unused::new(ctx)?,
            walker_groups: Buffer::zeroed(ctx, "walker_groups", 3)?,
            no_groups: Buffer::zeroed(ctx, "no_groups", 3)?,
            corners: Texels::new(&corners, 1)?,
            vertices: Texels::new(&vertices, 4)?,
            poses_view: Texels::new(&poses, 4)?,
            poses_recorded: setup.poses.clone(),
            poses,
            poses_before_view: Texels::new(&poses_before, 4)?,
            poses_before,
            physarums: Buffer::from_slice(ctx, "physarums", &physarums(settings, setup))?,
            distances,
            nearest,
            samples,
            tiles: Buffer::from_slice(ctx, "tiles", &setup.distance.tiles)?,
            hints,
            candidates,
            tile_states: Buffer::zeroed(ctx, "tile_states", setup.distance.tiles.len())?,
            margins: Buffer::zeroed(ctx, "margins", setup.distance.margins_len())?,
            distance_moves: Buffer::zeroed(ctx, "distance_moves", objects * (objects - 1))?,
            listed_tiles,
            covered,
            tile_groups: Buffer::zeroed(ctx, "tile_groups", 2)?,
            covered_groups: Buffer::zeroed(ctx, "covered_groups", 2)?,
            faces: Texels::new(
                &Buffer::from_slice_in(ctx, "faces", &setup.distance.trees.faces, large)?,
                4,
            )?,
            nodes: Texels::new(
                &Buffer::from_slice_in(ctx, "nodes", &setup.distance.trees.nodes, large)?,
                4,
            )?,
            dipoles: Texels::new(
                &Buffer::from_slice_in(ctx, "dipoles", &setup.distance.trees.dipoles, large)?,
                4,
            )?,
            pseudonormals: Texels::new(
                &Buffer::from_slice_in(
                    ctx,
                    "pseudonormals",
                    &setup.distance.trees.pseudonormals,
                    large,
                )?,
                4,
            )?,
            owners: Buffer::from_slice(ctx, "owners", &setup.distance.owners)?,
            across_views: AcrossViews {
                places: Texels::new(&across, 1)?,
                triangles: Texels::new(&across_triangles, 1)?,
                surroundings: Texels::new(&surroundings, 2)?,
            },
            across,
            surroundings,
            across_triangles,
            roots: Buffer::from_slice(ctx, "roots", &setup.distance.roots())?,
            distance_jobs: Buffer::zeroed(ctx, "distance_jobs", objects)?,
            distance_pairs,
            reach: 0.0,
            raster: (settings.uses_raster())
                .then(|| Raster::new(ctx, setup))
                .transpose()?,
            bias: None,
            food: (!setup.pantry.is_empty())
                .then(|| FoodBuffers::new(ctx, &setup.pantry, &setup.pantry.meals(None)))
                .transpose()?,
            no_meals: Buffer::zeroed(ctx, "no_meals", 1)?,
        })
    }

    /// From now on the objects are here, once everything recorded has taken place.
    pub(super) fn follow(&mut self, poses: &[Pose]) {
        if self.poses_recorded != poses {
            self.poses_recorded = poses.to_vec();
        }
    }

    /// Lets two buffers change roles.
    pub fn swap(&mut self, pair: Pair) {
        match pair {
            Pair::Trail => self.trail.swap(),
            Pair::Deposits => self.deposits.swap(),
            Pair::Transfers => self.transfers.swap(),
            Pair::Particles => self.swap_particles(),
        }
    }

    /// Which buffers have which roles now.
    #[must_use]
    pub fn roles(&self) -> Roles {
        Roles {
            trail: self.trail.is_swapped,
            deposits: self.deposits.is_swapped,
            transfers: self.transfers.is_swapped(),
            particles: self.sorting.is_swapped,
        }
    }

    /// Gives the buffers roles that they had before; what they hold stays.
    pub fn return_to(&mut self, roles: Roles) {
        if self.trail.is_swapped != roles.trail {
            self.trail.swap();
        }
        if self.deposits.is_swapped != roles.deposits {
            self.deposits.swap();
        }
        if self.transfers.is_swapped() != roles.transfers {
            self.transfers.swap();
        }
        if self.sorting.is_swapped != roles.particles {
            self.swap_particles();
        }
    }

    /// What has been sorted takes the place of what has not.
    fn swap_particles(&mut self) {
        let sorting = &mut self.sorting;
        std::mem::swap(&mut self.particles, &mut sorting.particles);
        std::mem::swap(&mut self.particles_view, &mut sorting.particles_view);
        std::mem::swap(&mut self.motions, &mut sorting.motions);
        std::mem::swap(&mut self.motions_view, &mut sorting.motions_view);
        sorting.is_swapped = !sorting.is_swapped;
    }
}

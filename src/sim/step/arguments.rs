//! What each kernel of a step reads and writes.

use super::super::draws::DistanceRasterArgs;
use super::super::food::buffers::FoodBuffers;
use super::super::kernels::{
    AdvanceArgs, DefragmentScanArgs, DefragmentSequentialArgs, DefragmentSwapArgs, DiffuseArgs,
    DiffuseSeamsArgs, DigestArgs, DistanceArgs, DistanceBruteArgs, DistanceMergeArgs,
    DistanceTilesArgs, ExchangeSeamsArgs, MoveBorderArgs, RespawnArgs, ScentArgs, SortCountArgs,
    SortScanArgs, SortScatterArgs, TransferInArgs, TransferOutArgs, UnfoldArgs,
};
use super::super::pipelines::Kernels;
use super::super::raster::Raster;
use super::super::state::State;
use super::super::texel_paths::Spread;
use crate::gpu::{Buffer, DispatchGroups};

/// `listed` gets the groups of those that this dispatch lists.
pub(super) fn advance<'s>(
    k: &Kernels,
    s: &'s State,
    listed: &'s Buffer<DispatchGroups>,
) -> AdvanceArgs<'s> {
    let deposits = s.unused.counted(k.outgrows_block, &s.deposits);
    let food = s.food.as_ref();
    let meals = food.map_or(&s.no_meals, |food| &food.meals);
    AdvanceArgs {
        particles: &s.particles_view,
        motions: &s.motions_view,
        strips: &s.strips,
        trail: &s.trail.front_views.texels,
        previous_deposits: &s.deposits.back_views.texels,
        deposits: deposits.block,
        low_deposits: deposits.low,
        high_deposits: deposits.high,
        corners: &s.corners,
        vertices: &s.vertices,
        poses: &s.poses_view,
        distances: &s.distance_views.distances,
        physarums: &s.physarums,
        across: &s.across_views.places,
        across_triangles: &s.across_views.triangles,
        surroundings: &s.across_views.surroundings,
        windows: &s.transfers.window_texels,
        flow: &s.transfers.flow,
        particle_indices: &s.transfers.particle_indices,
        particles_before: &s.particles_view,
        motions_before: &s.motions_view,
        walkers: &s.walkers_view,
        walker_count: &s.walker_count,
        walker_groups: listed,
        bias: s.bias_texels(),
        scent: food.map_or(&s.trail.front_views.texels, |food| &food.scent_views.texels),
        plates: food.map_or(&s.deposits.back_views.texels, |food| {
            &food.plate_views.texels
        }),
        meals,
    }
}

pub(super) fn transfer_in(s: &State) -> TransferInArgs<'_> {
    TransferInArgs {
        arriving: &s.transfers.arriving,
        departing: &s.transfers.departing,
        flow: &s.transfers.flow,
        particles: &s.particles_view,
        motions: &s.motions_view,
        triangles: &s.triangles,
        corners: &s.corners,
        vertices: &s.vertices,
        poses: &s.poses_view,
    }
}

pub(super) fn move_border(s: &State) -> MoveBorderArgs<'_> {
    MoveBorderArgs {
        flow: &s.transfers.flow,
        windows: &s.transfers.windows,
        groups: &s.transfers.groups,
    }
}

pub(super) fn transfer_out(s: &State) -> TransferOutArgs<'_> {
    TransferOutArgs {
        flow: &s.transfers.flow,
        particle_indices: &s.transfers.particle_indices,
        particles: &s.particles_view,
        motions: &s.motions_view,
        nearest: &s.distance_views.nearest,
        strips: &s.strips,
        departing: &s.transfers.departing,
        flux: &s.transfers.flux,
        triangles: &s.triangles,
        halfedges: &s.halfedges,
        corners: &s.corners,
        vertices: &s.vertices,
        poses: &s.poses_view,
        physarums: &s.physarums,
        roots: &s.roots,
        nodes: &s.nodes,
        faces: &s.faces,
        pseudonormals: &s.pseudonormals,
        dipoles: &s.dipoles,
        poses_before: &s.poses_before_view,
        bias: s.bias_texels(),
    }
}

pub(super) fn defragment_scan(s: &State) -> DefragmentScanArgs<'_> {
    DefragmentScanArgs {
        departing: &s.transfers.departing,
        motions: &s.motions_view,
        windows: &s.transfers.windows,
        flow: &s.transfers.flow,
        particle_indices: &s.transfers.particle_indices,
        transfer_indices: &s.transfers.transfer_indices,
    }
}

pub(super) fn defragment_swap(s: &State) -> DefragmentSwapArgs<'_> {
    DefragmentSwapArgs {
        flow: &s.transfers.flow,
        particle_indices: &s.transfers.particle_indices,
        transfer_indices: &s.transfers.transfer_indices,
        departing: &s.transfers.departing,
        particles: &s.particles_view,
        motions: &s.motions_view,
    }
}

pub(super) fn defragment_sequential(s: &State) -> DefragmentSequentialArgs<'_> {
    DefragmentSequentialArgs {
        flow: &s.transfers.flow,
        windows: &s.transfers.windows,
        departing: &s.transfers.departing,
        particles: &s.particles_view,
        motions: &s.motions_view,
        particle_indices: &s.transfers.particle_indices,
        transfer_indices: &s.transfers.transfer_indices,
    }
}

pub(super) fn respawn(s: &State) -> RespawnArgs<'_> {
    RespawnArgs {
        flow: &s.transfers.flow,
        particle_indices: &s.transfers.particle_indices,
        particles: &s.particles_view,
        motions: &s.motions_view,
        triangles: &s.triangles,
        area_shares: &s.transfers.area_shares,
        object_triangles: &s.transfers.object_triangles,
    }
}

pub(super) fn diffuse_seams(s: &State) -> DiffuseSeamsArgs<'_> {
    DiffuseSeamsArgs {
        rows: &s.exchange_rows,
        entries: &s.exchange_entries,
        trail: &s.trail.front_views.texels,
        deposits: &s.deposits.front_views.texels,
        low_next_trail: &s.trail.back_views.low,
        high_next_trail: &s.trail.back_views.high,
    }
}

/// Writes where the ways of the texture lead.
pub(super) fn diffuse<'s>(s: &'s State, spread: &'s Spread<'_>) -> DiffuseArgs<'s> {
    DiffuseArgs {
        blocks: &s.blocks,
        trail: &s.trail.front_views.quads,
        deposits: &s.deposits.front_views.quads,
        density: &s.density_views.quads,
        next_trail: &spread.next_trail,
        next_trail_quads: spread.next_trail_quads,
        previous_deposits: &spread.previous_deposits,
        previous_deposits_quads: spread.previous_deposits_quads,
    }
}

/// Of the trail.
pub(super) fn exchange_seams(s: &State) -> ExchangeSeamsArgs<'_> {
    ExchangeSeamsArgs {
        seams: &s.seams,
        trail: &s.trail.back_views.texels,
        low_trail: &s.trail.back_views.low,
        high_trail: &s.trail.back_views.high,
    }
}

pub(super) fn distance_tiles(s: &State) -> DistanceTilesArgs<'_> {
    DistanceTilesArgs {
        jobs: &s.distance_jobs,
        pairs: &s.distance_views.pairs,
        tiles: &s.tiles,
        faces: &s.faces,
        pseudonormals: &s.pseudonormals,
        corners: &s.corners,
        hints: &s.hints,
        nodes: &s.nodes,
        dipoles: &s.dipoles,
        candidates: &s.candidates,
        tile_states: &s.tile_states,
        listed: &s.listed_tiles,
        groups: &s.tile_groups,
        moves: &s.distance_moves,
        margins: &s.margins,
    }
}

pub(super) fn distance(s: &State) -> DistanceArgs<'_> {
    DistanceArgs {
        pairs: &s.distance_views.pairs,
        samples: &s.distance_views.samples,
        faces: &s.faces,
        pseudonormals: &s.pseudonormals,
        corners: &s.corners,
        distances: &s.distances,
        nearest: &s.nearest,
        nodes: &s.nodes,
        dipoles: &s.dipoles,
        hints: &s.distance_views.hints,
        candidates: &s.distance_views.candidates,
        listed: &s.distance_views.listed,
        listed_groups: &s.tile_groups,
        groups: &s.covered_groups,
        covered: &s.covered,
        surroundings: &s.surroundings,
    }
}

pub(super) fn distance_brute(s: &State) -> DistanceBruteArgs<'_> {
    DistanceBruteArgs {
        jobs: &s.distance_jobs,
        pairs: &s.distance_pairs,
        samples: &s.samples,
        faces: &s.faces,
        pseudonormals: &s.pseudonormals,
        corners: &s.corners,
        distances: &s.distances,
        nearest: &s.nearest,
        nodes: &s.nodes,
        dipoles: &s.dipoles,
    }
}

pub(super) fn unfold(s: &State) -> UnfoldArgs<'_> {
    UnfoldArgs {
        jobs: &s.distance_jobs,
        pairs: &s.distance_views.pairs,
        samples: &s.distance_views.samples,
        owners: &s.owners,
        distances: &s.distance_views.distances,
        nearest: &s.distance_views.nearest,
        triangles: &s.triangles,
        halfedges: &s.halfedges,
        corners: &s.corners,
        vertices: &s.vertices,
        strips: &s.strips,
        across: &s.across,
        surroundings: &s.surroundings,
        across_triangles: &s.across_triangles,
        listed: &s.distance_views.listed,
        groups: &s.covered_groups,
        covered: &s.distance_views.covered,
    }
}

pub(super) fn distance_merge<'s>(s: &'s State, raster: &'s Raster) -> DistanceMergeArgs<'s> {
    DistanceMergeArgs {
        jobs: &s.distance_jobs,
        pairs: &s.distance_pairs,
        samples: &s.samples,
        faces: &s.faces,
        pseudonormals: &s.pseudonormals,
        corners: &s.corners,
        distances: &s.distances,
        nearest: &s.nearest,
        nodes: &s.nodes,
        dipoles: &s.dipoles,
        winners: &raster.winners,
    }
}

pub(super) fn distance_raster<'s>(s: &'s State, raster: &'s Raster) -> DistanceRasterArgs<'s> {
    DistanceRasterArgs {
        outlines: &raster.outlines,
        bounds: &raster.bounds,
        slots: &raster.slots,
        nodes: &s.nodes,
        places: &raster.places,
        faces: &s.faces,
    }
}

/// Of the distances.
pub(super) fn exchange_distances(s: &State) -> ExchangeSeamsArgs<'_> {
    ExchangeSeamsArgs {
        seams: &s.seams,
        trail: &s.distance_views.distances,
        low_trail: &s.distance_views.distances,
        high_trail: &s.distance_views.distances,
    }
}

pub(super) fn digest(food: &FoodBuffers) -> DigestArgs<'_> {
    DigestArgs {
        meals: &food.meals,
        groups: &food.groups,
    }
}

pub(super) fn scent(food: &FoodBuffers) -> ScentArgs<'_> {
    ScentArgs {
        scented: &food.scented,
        whiffs: &food.whiffs,
        meals: &food.meals,
        low_field: &food.scent_views.low,
        high_field: &food.scent_views.high,
    }
}

pub(super) fn sort_count(s: &State) -> SortCountArgs<'_> {
    SortCountArgs {
        particles: &s.particles_view,
        motions: &s.motions_view,
        strips: &s.strips,
        bins: &s.sorting.bins,
    }
}

pub(super) fn sort_scan(s: &State) -> SortScanArgs<'_> {
    SortScanArgs {
        bins: &s.sorting.bins,
    }
}

pub(super) fn sort_scatter(s: &State) -> SortScatterArgs<'_> {
    SortScatterArgs {
        particles: &s.particles_view,
        motions: &s.motions_view,
        strips: &s.strips,
        bins: &s.sorting.bins,
        sorted_particles: &s.sorting.particles_view,
        sorted_motions: &s.sorting.motions_view,
        windows: &s.transfers.windows,
        flow: &s.transfers.flow,
    }
}

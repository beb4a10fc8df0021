//! What the kernels of an object's turn take besides buffers. Without turns there is one for all objects.

use super::kernels::{
    Advance, AdvanceParams, DefragmentScanParams, DefragmentSequentialParams, DefragmentSwapParams,
    MoveBorderConstants, MoveBorderParams, RespawnParams, TransferIn, TransferInParams,
    TransferOutConstants, TransferOutParams,
};
use super::setup::Setup;
use crate::gpu::Kernel;
use crate::mesh::surface::NONE;
use crate::scene::settings::{Border, Settings, Strategy};

/// The parameters of one turn.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// What takes effect.
    pub strategy: Strategy,
    /// How many turns a step has: objects, or one.
    pub count: u32,
    /// For `advance`.
    pub advance: AdvanceParams,
    /// For `transfer_in`.
    pub transfer_in: TransferInParams,
    /// For `move_border`.
    pub move_border: MoveBorderParams,
    /// For `transfer_out`.
    pub transfer_out: TransferOutParams,
    /// For `defragment_scan`.
    pub defragment_scan: DefragmentScanParams,
    /// For `defragment_swap`.
    pub defragment_swap: DefragmentSwapParams,
    /// For `defragment_sequential`.
    pub defragment_sequential: DefragmentSequentialParams,
    /// For `respawn`.
    pub respawn: RespawnParams,
}

impl Turn {
    /// Invocations in a group of the kernels that work on transfers.
    pub const TRANSFER_GROUP: u32 = TransferIn::GROUP_SIZE;
    /// Invocations in a group of the kernel that works on windows.
    pub const PARTICLE_GROUP: u32 = Advance::GROUP_SIZE;

    /// Of a part of `defragment_sequential`: half of what lavapipe's loops may have.
    const SEQUENTIAL_ROUNDS: u32 = 32_768;

    /// The parameters of the parts of `defragment_sequential`: enough for full lists, each entry of which takes two rounds.
    pub fn sequential_parts(&self) -> impl Iterator<Item = DefragmentSequentialParams> + use<> {
        let first = self.defragment_sequential;
        let rounds = 2 * u64::from(self.move_border.capacity);
        let parts = rounds.div_ceil(u64::from(first.rounds)) as u32;
        (0..parts).map(move |part| DefragmentSequentialParams { part, ..first })
    }

    /// The first turn of a step. All settings but these are in `advance` already; `capacity` is that of the lists.
    #[must_use]
    pub fn new(settings: &Settings, setup: &Setup, advance: AdvanceParams, capacity: u32) -> Self {
        let object_count = setup.poses.len() as u32;
        let particle_count = setup.particles.len() as u32;
        let strategy = settings.strategy();
        // Where nothing is told of distances, nothing is covered.
        let threshold = settings.transfer.threshold.min(settings.distance.reach);
        let turn = Self {
            strategy,
            count: if strategy.has_turns() {
                object_count
            } else {
                1
            },
            advance: AdvanceParams {
                transfer_capacity: capacity,
                transfer_threshold: threshold * setup.radius,
                ..advance
            },
            transfer_in: TransferInParams {
                object: NONE,
                capacity,
            },
            move_border: MoveBorderParams {
                object: 0,
                object_count,
                particle_count,
                capacity,
                transfer_group: Self::TRANSFER_GROUP,
                particle_group: Self::PARTICLE_GROUP,
            },
            transfer_out: TransferOutParams {
                capacity,
                pitch: setup.atlas.pitch,
                object_count,
                attempts: advance.attempts,
                speed: advance.speed,
                first_vertex_normal: setup.surface.halfedges.len() as u32,
            },
            defragment_scan: DefragmentScanParams {
                next_object: 0,
                particle_count,
                capacity,
            },
            defragment_swap: DefragmentSwapParams { capacity },
            defragment_sequential: DefragmentSequentialParams {
                next_object: 0,
                object_count,
                particle_count,
                part: 0,
                rounds: Self::SEQUENTIAL_ROUNDS,
            },
            respawn: RespawnParams {
                capacity,
                seed: advance.seed,
                time_step: advance.time_step,
            },
        };
        if strategy.has_turns() {
            turn.of(0)
        } else {
            turn
        }
    }

    /// The turn of an object in the same step.
    #[must_use]
    pub fn of(&self, object: u32) -> Self {
        let mut turn = *self;
        let next = (object + 1) % self.move_border.object_count;
        turn.advance.object = object;
        turn.transfer_in.object = object;
        turn.move_border.object = object;
        turn.defragment_scan.next_object = next;
        turn.defragment_sequential.next_object = next;
        turn
    }
}

/// What is compiled into `transfer_out`.
#[must_use]
pub fn departure_constants(settings: &Settings, texels_in_quads: bool) -> TransferOutConstants {
    TransferOutConstants {
        border_reflects: settings.physarum.border == Border::Reflect,
        sign_rule: settings.distance.sign as u32,
        own_physarum: settings.objects.iter().any(|o| !o.physarum.is_empty()),
        painted: false,
        texels_in_quads,
    }
}

/// What is compiled into `move_border`.
#[must_use]
pub fn border_constants(settings: &Settings) -> MoveBorderConstants {
    MoveBorderConstants {
        windows: settings.strategy().has_windows(),
    }
}

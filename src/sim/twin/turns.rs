//! An object's turn by the twins.

use super::advance::{self, AdvanceInputs, advance};
use super::respawn::respawn;
use super::ring::{defragment_scan, defragment_sequential, defragment_swap, move_border};
use super::transfer::{transfer_in, transfer_out};
use super::{Simulation, StepConstants};
use crate::gpu::DispatchGroups;
use crate::scene::settings::{Settings, Strategy};
use crate::sim::Setup;
use crate::sim::crossing::Terrain;
use crate::sim::ground::Ground;
use crate::sim::params::physarums;
use crate::sim::transfers::{TransferState, area_shares, capacity, object_triangles};
use crate::sim::turns::Turn;
use crate::sim::types::{Flow, Transfer, Window};

/// What the simulation holds of transfers, as [`crate::sim::transfers::Transfers`] does on the device.
#[derive(Clone, Debug)]
pub(super) struct TwinTransfers {
    windows: Vec<Window>,
    flow: Flow,
    groups: [DispatchGroups; 2],
    particle_indices: Vec<u32>,
    transfer_indices: Vec<u32>,
    arriving: Vec<Transfer>,
    departing: Vec<Transfer>,
    flux: Vec<u32>,
}

impl TwinTransfers {
    pub(super) fn new(settings: &Settings, setup: &Setup, state: &TransferState) -> Self {
        let lists = capacity(settings, setup, state.in_flight.len()) as usize;
        let mut arriving = vec![Transfer::default(); lists];
        arriving[..state.in_flight.len()].copy_from_slice(&state.in_flight);
        Self {
            windows: state.windows.clone(),
            flow: Flow {
                leaving: state.in_flight.len() as u32,
                ..state.flow
            },
            groups: [DispatchGroups::of(0, 1); 2],
            particle_indices: vec![0; lists],
            transfer_indices: vec![0; lists],
            arriving,
            departing: vec![Transfer::default(); lists],
            flux: state.flux.clone(),
        }
    }

    pub(super) fn capacity(&self) -> u32 {
        self.particle_indices.len() as u32
    }

    pub(super) fn swap(&mut self) {
        std::mem::swap(&mut self.arriving, &mut self.departing);
    }

    pub(super) fn state(&self, strategy: Strategy) -> TransferState {
        let in_flight = if strategy.has_turns() {
            self.flow.leaving
        } else {
            0
        };
        TransferState {
            windows: self.windows.clone(),
            in_flight: self.arriving[..in_flight as usize].to_vec(),
            flow: self.flow,
            flux: self.flux.clone(),
        }
    }
}

impl Simulation {
    pub(super) fn advance(&mut self, constants: &StepConstants, turn: &Turn) -> Vec<f32> {
        advance(
            &constants.advance,
            &turn.advance,
            &AdvanceInputs {
                strips: &self.setup.strips,
                trail: &self.trail,
                previous_deposits: &self.previous_deposits,
                corners: &self.setup.corners,
                vertices: &self.setup.vertices,
                poses: &self.poses,
                physarums: &physarums(&self.settings, &self.setup),
                distances: &self.distances,
                surroundings: &self.surroundings,
                across: &self.across,
                across_triangles: &self.across_triangles,
                bias: &self.bias,
                scent: &self.scent,
                plates: &self.setup.pantry.plates,
            },
            advance::Turn {
                windows: &self.transfers.windows,
                flow: &mut self.transfers.flow,
                particle_indices: &mut self.transfers.particle_indices,
                meals: &mut self.meals,
                forms: &mut self.forms,
            },
            &mut self.particles,
            &mut self.motions,
            &mut self.deposits,
        )
    }

    pub(super) fn transfer_in(&mut self, turn: &Turn) {
        transfer_in(
            &turn.transfer_in,
            &Ground::of(&self.setup, &self.poses),
            &self.transfers.arriving,
            &mut self.transfers.departing,
            &mut self.transfers.flow,
            &mut self.particles,
            &mut self.motions,
        );
    }

    pub(super) fn move_border(&mut self, constants: &StepConstants, turn: &Turn) {
        move_border(
            &constants.move_border,
            &turn.move_border,
            &mut self.transfers.flow,
            &mut self.transfers.windows,
            &mut self.transfers.groups,
        );
    }

    pub(super) fn transfer_out(&mut self, constants: &StepConstants, turn: &Turn) {
        let constants = &constants.transfer_out;
        let roots = self.setup.distance.roots();
        transfer_out(
            constants,
            &turn.transfer_out,
            &Terrain::of(
                &self.setup,
                &self.poses,
                &roots,
                constants.sign_rule,
                constants.border_reflects,
            ),
            &self.poses_before,
            &mut self.transfers.flow,
            &self.transfers.particle_indices,
            &self.particles,
            &self.motions,
            &physarums(&self.settings, &self.setup),
            &self.nearest,
            &self.setup.atlas.maps,
            &self.bias,
            &mut self.transfers.departing,
            &mut self.transfers.flux,
        );
    }

    pub(super) fn defragment(&mut self, turn: &Turn) {
        defragment_scan(
            &turn.defragment_scan,
            &self.transfers.departing,
            &self.motions,
            &self.transfers.windows,
            &mut self.transfers.flow,
            &mut self.transfers.particle_indices,
            &mut self.transfers.transfer_indices,
        );
        defragment_swap(
            &turn.defragment_swap,
            &self.transfers.flow,
            &self.transfers.particle_indices,
            &self.transfers.transfer_indices,
            &mut self.transfers.departing,
            &mut self.particles,
            &mut self.motions,
        );
    }

    pub(super) fn defragment_sequential(&mut self, turn: &Turn) {
        defragment_sequential(
            &turn.defragment_sequential,
            &mut self.transfers.flow,
            &self.transfers.windows,
            &mut self.transfers.departing,
            &mut self.particles,
            &mut self.motions,
        );
    }

    pub(super) fn respawn(&mut self, turn: &Turn) {
        respawn(
            &turn.respawn,
            &mut self.transfers.flow,
            &self.transfers.particle_indices,
            &mut self.particles,
            &mut self.motions,
            &self.setup.surface.triangles,
            &area_shares(&self.setup.surface),
            &object_triangles(&self.setup.surface),
        );
    }
}

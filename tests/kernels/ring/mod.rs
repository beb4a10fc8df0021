//! The ring of windows under random selections: invariants after every turn, the same outcome by every strategy, and
//! the kernels against their twins.

mod kernels;
mod model;

use model::{Case, Order, Ring};
use myxo::gpu::DispatchGroups;
use myxo::sim::kernels::{MoveBorderConstants, MoveBorderParams};
use myxo::sim::twin::ring::move_border;
use myxo::sim::types::Flow;

/// Awkward ones: nothing to spare, nobody leaves, everybody leaves, empty windows, more objects than particles.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (k, particles) in [1, 2, 3, 63, 64, 65, 199].into_iter().enumerate() {
        for objects in [2, 3, 7] {
            for share in [0.0, 0.2, 1.0] {
                for all_on in [None, Some(objects - 1)] {
                    cases.push(Case {
                        particles,
                        objects,
                        capacity: particles,
                        share,
                        all_on,
                        seed: 17 * k as u32 + 5,
                    });
                }
            }
        }
    }
    cases
}

#[test]
fn every_order_leads_to_the_same_and_keeps_the_ring() {
    for case in cases() {
        let orders = [Order::Scattered, Order::Sequential, Order::Parallel];
        let mut rings = orders.map(|order| Ring::new(case, order));
        for _ in 0..12 {
            rings.iter_mut().for_each(Ring::step);
            let [scattered, sequential, parallel] = rings.each_ref().map(Ring::by_id);
            assert_eq!(scattered, sequential, "{case:?}");
            assert_eq!(scattered, parallel, "{case:?}");
        }
        let [scattered, sequential, parallel] = rings.each_ref().map(|ring| ring.flow.arrived);
        assert_eq!([scattered, sequential], [parallel; 2]);
        if case.share == 0.0 || case.share == 1.0 {
            assert_eq!(parallel > 0, case.share == 1.0, "{case:?}");
        }
        assert_eq!(rings[0].flow.refused, 0);
    }
}

#[test]
fn full_lists_refuse_and_lose_nobody() {
    let mut refusals = 0;
    for case in cases() {
        for capacity in [1, 2, 16] {
            let case = Case { capacity, ..case };
            for order in [Order::Scattered, Order::Sequential, Order::Parallel] {
                let mut ring = Ring::new(case, order);
                (0..12).for_each(|_| ring.step());
                let flow = ring.flow;
                assert_eq!(
                    flow.refused > 0,
                    flow.most_wanted > capacity,
                    "{case:?}: {flow:?}"
                );
                // All that were selected are refused, have arrived or are under way.
                assert_eq!(
                    flow.selected,
                    flow.refused + flow.arrived + flow.leaving,
                    "{case:?}: {flow:?}"
                );
                if flow.refused > 0 {
                    refusals += 1;
                    // A list for everybody is never full.
                    let enough = Case {
                        capacity: case.particles,
                        ..case
                    };
                    let mut ring = Ring::new(enough, order);
                    (0..12).for_each(|_| ring.step());
                    assert_eq!(ring.flow.refused, 0, "{case:?}");
                }
            }
        }
    }
    assert!(refusals > 100, "{refusals}");
}

/// Of three objects the last one sends many to the second one, and in the next step the first one does, too: with room for
/// all of them, both would have been under way at once.
#[test]
fn the_size_that_would_have_done_counts_those_of_two_steps() {
    let constants = MoveBorderConstants { windows: false };
    let mut groups = vec![DispatchGroups::of(0, 64); 2];
    let mut end_turn = |flow: &mut Flow, object: u32, capacity: u32, passing: u32, asking: u32| {
        (flow.passing, flow.wanted) = (passing, passing + asking);
        let params = MoveBorderParams {
            object,
            object_count: 3,
            particle_count: 100,
            capacity,
            transfer_group: 64,
            particle_group: 64,
        };
        move_border(&constants, &params, flow, &mut [], &mut groups);
        flow.leaving
    };
    // Who has found no room asks no more.
    let mut needed = |capacity: u32| {
        let mut flow = Flow::default();
        let from_last = end_turn(&mut flow, 2, capacity, 0, 10);
        end_turn(&mut flow, 0, capacity, from_last, 10);
        end_turn(&mut flow, 1, capacity, 0, 0);
        flow
    };
    assert_eq!(needed(100).most_wanted, 20);
    for capacity in [1, 3, 9, 19] {
        let flow = needed(capacity);
        assert_eq!(
            (flow.refused > 0, flow.most_wanted),
            (true, 20),
            "{capacity}"
        );
    }
    // So it is: nobody is refused.
    assert_eq!(needed(20).refused, 0);
}

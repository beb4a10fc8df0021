//! Which of the selected particles leave where more are selected than the lists hold: the kernels against their twins, exactly as
//! many as there is room for, and the same ones whatever the order.

use myxo::gpu::{Buffer, DispatchGroups, Pipeline, Texels, Threads};
use myxo::rng::{Purpose, random};
use myxo::sim::kernels::{
    CloseList, CloseListArgs, CloseListParams, LimitCount, LimitCountArgs, LimitCountParams,
    LimitList, LimitListArgs, LimitListParams, LimitPick, LimitPickArgs, LimitPickParams,
};
use myxo::sim::twin::limit::{close_list, limit_count, limit_list, limit_pick};
use myxo::sim::types::{Flow, Motion, Particle};

use crate::common::gpu;

/// Every third particle is selected, some with a word of food in their flags.
fn particles(count: u32) -> (Vec<Particle>, Vec<Motion>) {
    let one = |slot: u32| {
        let particle = Particle {
            triangle: 0,
            u: 0.0,
            v: 0.0,
            id: count - 1 - slot,
        };
        let motion = Motion {
            heading_p: 1.0,
            heading_h: 0.0,
            pending: 0.0,
            flags: (slot % 5) << Motion::FED_SHIFT | u32::from(slot.is_multiple_of(3)),
        };
        (particle, motion)
    };
    (0..count).map(one).unzip()
}

fn by_twins(
    (particles, motions): (&[Particle], &mut [Motion]),
    flow: &mut Flow,
    (capacity, salt): (u32, u32),
) -> Vec<u32> {
    let mut bins = vec![0; 1 << 16];
    for is_low in [0, 1] {
        let count = LimitCountParams {
            particle_count: particles.len() as u32,
            salt,
            is_low,
        };
        limit_count(&count, particles, motions, flow, &mut bins);
        let pick = LimitPickParams { capacity, is_low };
        limit_pick(&pick, flow, &mut bins);
        assert!(bins.iter().all(|&bin| bin == 0));
    }
    let list = LimitListParams {
        particle_count: particles.len() as u32,
        capacity,
        salt,
    };
    let mut indices = vec![u32::MAX; capacity as usize];
    limit_list(&list, particles, motions, flow, &mut indices);
    indices.sort_unstable();
    indices
}

/// Catches a limit that lets one too many leave, or one too few; and an order of ids that always wins.
#[test]
fn as_many_leave_as_there_is_room_for_by_no_order() {
    let count = 3000;
    let mut times = vec![0_u32; count as usize];
    for step in 0..300 {
        let (particles, mut motions) = particles(count);
        let [salt, ..] = random(5, 0, step, Purpose::Limit);
        let capacity = 1 + step * 3;
        let mut flow = Flow::default();
        let list = by_twins((&particles, &mut motions), &mut flow, (capacity, salt));
        assert_eq!(flow.listed, capacity);
        let selected: Vec<u32> = (0..count)
            .filter(|&slot| motions[slot as usize].is_selected())
            .collect();
        assert_eq!(list, selected);
        for slot in list {
            times[particles[slot as usize].id as usize] += 1;
        }
    }
    // Each of 1,000 is among those that leave in 135 steps, in the mean, with a deviation of 7.
    let times: Vec<u32> = times.into_iter().filter(|&times| times > 0).collect();
    assert_eq!(times.len(), 1000);
    let [least, most] = [times.iter().min(), times.iter().max()].map(|x| *x.unwrap());
    assert!(least > 95 && most < 175, "{least} to {most} of 300 steps");
}

#[test]
fn the_kernels_of_the_limit_agree_with_their_twins() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let count_pipeline = Pipeline::<LimitCount>::new(ctx, &()).unwrap();
    let pick_pipeline = Pipeline::<LimitPick>::new(ctx, &()).unwrap();
    let list_pipeline = Pipeline::<LimitList>::new(ctx, &()).unwrap();
    for (count, capacity) in [(4, 1), (65, 1), (65, 21), (1021, 16), (100_001, 33_000)] {
        let (particles, mut motions) = particles(count);
        let [salt, ..] = random(7, 0, count, Purpose::Limit);
        let particle_buffer = Buffer::from_slice(ctx, "particles", &particles).unwrap();
        let motion_buffer = Buffer::from_slice(ctx, "motions", &motions).unwrap();
        let mut flow = Flow {
            leaving: capacity,
            ..Flow::default()
        };
        let flow_buffer = Buffer::from_slice(ctx, "flow", &[flow]).unwrap();
        let bins = Buffer::<u32>::zeroed(ctx, "bins", 1 << 16).unwrap();
        let indices = Buffer::<u32>::zeroed(ctx, "indices", capacity as usize).unwrap();
        let texels = |buffer| Texels::<u32>::new(buffer, 4).unwrap();
        let motion_texels = Texels::<u32>::new(&motion_buffer, 4).unwrap();
        gpu.run(|rec| {
            for is_low in [0, 1] {
                let args = LimitCountArgs {
                    particles: &texels(&particle_buffer),
                    motions: &motion_texels,
                    flow: &flow_buffer,
                    bins: &bins,
                };
                let params = LimitCountParams {
                    particle_count: count,
                    salt,
                    is_low,
                };
                rec.dispatch(&count_pipeline, Threads(count), args, params);
                let args = LimitPickArgs {
                    flow: &flow_buffer,
                    bins: &bins,
                };
                let params = LimitPickParams { capacity, is_low };
                rec.dispatch(&pick_pipeline, Threads(1), args, params);
            }
            let args = LimitListArgs {
                particles: &texels(&particle_buffer),
                motions: &motion_texels,
                flow: &flow_buffer,
                particle_indices: &indices,
            };
            let params = LimitListParams {
                particle_count: count,
                capacity,
                salt,
            };
            rec.dispatch(&list_pipeline, Threads(count), args, params);
        });
        let expected = by_twins((&particles, &mut motions), &mut flow, (capacity, salt));
        let mut list = ctx.download(&indices).unwrap();
        list.sort_unstable();
        assert_eq!(list, expected, "{count}, {capacity}");
        assert_eq!(ctx.download(&flow_buffer).unwrap(), [flow]);
        assert_eq!(ctx.download(&motion_buffer).unwrap(), motions);
        assert!(ctx.download(&bins).unwrap().iter().all(|&bin| bin == 0));
    }
    gpu.finish();
}

/// Catches counters that restart behind the largest number, and groups of kernels that have nothing to do.
#[test]
fn close_list_agrees_with_its_twin_and_counts_to_the_end() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let pipeline = Pipeline::<CloseList>::new(ctx, &()).unwrap();
    let params = CloseListParams {
        particle_count: 70_000,
        capacity: 16,
        transfer_group: 64,
        limit_group: 64,
    };
    for before in [0, u32::MAX - 100, u32::MAX - 3, u32::MAX] {
        for wanted in [0, 15, 16, 17, 70_000] {
            let mut flow = Flow {
                wanted,
                selected: before,
                refused: before,
                most_wanted: 20,
                ..Flow::default()
            };
            let flow_buffer = Buffer::from_slice(ctx, "flow", &[flow]).unwrap();
            let mut groups = [DispatchGroups::of(7, 1); 5];
            let groups_buffer = Buffer::from_slice(ctx, "groups", &groups).unwrap();
            gpu.run(|rec| {
                let args = CloseListArgs {
                    flow: &flow_buffer,
                    groups: &groups_buffer,
                };
                rec.dispatch(&pipeline, Threads(1), args, params);
            });
            close_list(&params, &mut flow, &mut groups);
            assert_eq!(ctx.download(&flow_buffer).unwrap(), [flow]);
            assert_eq!(ctx.download(&groups_buffer).unwrap(), groups);
            assert_eq!(flow.leaving, wanted.min(16));
            assert_eq!(flow.most_wanted, wanted.max(20));
            let more = [wanted, wanted - wanted.min(16)];
            let expected = more.map(|more| before.saturating_add(more));
            assert_eq!([flow.selected, flow.refused], expected);
            assert_eq!(groups[1].x > 0, wanted > 16, "limit_count and limit_list");
            assert_eq!(groups[2].x > 0, wanted > 16, "limit_pick");
        }
    }
    gpu.finish();
}

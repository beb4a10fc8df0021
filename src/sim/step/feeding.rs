//! Food in a step: what was eaten is taken away, and where that changes a smell, sensors read another one.

use super::arguments;
use super::{Kernels, Recorder, State};
use crate::gpu::{DispatchGroups, Kernel as _, Threads};
use crate::sim::kernels::{DigestParams, Scent, ScentParams};

/// Nothing where there is no food.
pub(super) fn feed(rec: &mut Recorder, k: &Kernels, s: &State) {
    let (Some(food), Some(digest), Some(scent)) = (&s.food, &k.digest, &k.scent) else {
        return;
    };
    let none = DispatchGroups { x: 0, y: 0, z: 1 };
    rec.update(&food.groups, 0, &[none]);
    rec.dispatch(
        digest,
        Threads(food.food_count),
        arguments::digest(food),
        DigestParams {
            food_count: food.food_count,
            scented_count: food.scented_count,
            scent_group: Scent::GROUP_SIZE,
        },
    );
    rec.dispatch_indirect(
        scent,
        (&food.groups, 0),
        arguments::scent(food),
        ScentParams {
            scented_count: food.scented_count,
        },
    );
}

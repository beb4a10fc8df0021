//! Strict arithmetic on the device is that of the host, bit by bit, in both forms.

use crate::common::{gpu, gpu_by_card_forms};
use myxo::sim::arithmetic::broken;

#[test]
fn arithmetic_is_that_of_the_host() {
    for gpu in [gpu(), gpu_by_card_forms()].into_iter().flatten() {
        assert_eq!(broken(&gpu.ctx).unwrap(), []);
        gpu.finish();
    }
}

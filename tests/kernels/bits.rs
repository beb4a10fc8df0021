//! What is equal to the bit: signs of zeros count, and NaN is equal to itself.

use std::fmt::Debug;

use bytemuck::Pod;

/// Fails at the first element that the kernel and its twin do not have the same bits of.
pub fn assert_same_bits<T: Pod + Debug>(what: &str, kernel: &[T], twin: &[T]) {
    assert_eq!(kernel.len(), twin.len(), "{what}");
    for (i, (a, b)) in kernel.iter().zip(twin).enumerate() {
        assert!(
            bytemuck::bytes_of(a) == bytemuck::bytes_of(b),
            "{what}, element {i}: {a:?} by the kernel, {b:?}"
        );
    }
}

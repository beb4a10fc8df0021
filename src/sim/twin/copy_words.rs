//! Twin of `shaders/copy_words.comp`.

use glam::UVec4;

use crate::sim::kernels::CopyWordsParams;

/// Copies a buffer.
pub fn copy_words(params: &CopyWordsParams, source: &[UVec4], target: &mut [UVec4]) {
    let count = params.quad_count as usize;
    target[..count].copy_from_slice(&source[..count]);
}

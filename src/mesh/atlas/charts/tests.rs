//! Tests of cutting and flattening.

mod measure;

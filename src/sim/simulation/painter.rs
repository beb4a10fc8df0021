//! The kernels of brushes.

use std::sync::Arc;

use crate::gpu::{Context, GpuError, Interface, Pipeline, Tables};
use crate::sim::kernels::{ExchangeSeams, ExchangeSeamsConstants, Paint, PaintConstants, Teleport};
use crate::sim::texel_paths::TexelPaths;

/// The pipelines of brushes, made when something is painted.
pub(super) struct Painter {
    pub(super) paint: Pipeline<Paint>,
    pub(super) teleport: Pipeline<Teleport>,
    pub(super) exchange_seams: Pipeline<ExchangeSeams>,
}

impl Painter {
    pub(super) fn new(
        ctx: &Arc<Context>,
        paths: TexelPaths,
        tables: Tables,
    ) -> Result<Self, GpuError> {
        let constants = PaintConstants { paths };
        let seams = ExchangeSeamsConstants { paths };
        Ok(Self {
            paint: Pipeline::new(ctx, &constants)?,
            teleport: Pipeline::over(ctx, &(), Teleport::NAME, tables)?,
            exchange_seams: Pipeline::new(ctx, &seams)?,
        })
    }
}

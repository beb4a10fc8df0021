//! The pipelines of the kernels that a step runs. They own no buffers.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use crate::gpu::{
    Context, Draw, GpuError, Kernel, Pipeline, RasterOptions, RasterPipeline, Tables,
};

/// Plain values that can be compared and shown.
pub trait Value: Copy + PartialEq + Debug + Send + Sync + 'static {}

impl<T: Copy + PartialEq + Debug + Send + Sync + 'static> Value for T {}

/// One per kernel and set of constants, by the kernel's name in times and messages.
pub struct Pipelines {
    ctx: Arc<Context>,
    /// How tables of particles are stored.
    tables: Tables,
    made: Vec<Made>,
}

/// A pipeline of any kernel, with the constants that are compiled into it.
struct Made {
    name: &'static str,
    pipeline: Box<dyn Any + Send + Sync>,
}

impl Pipelines {
    /// No pipelines yet, for this layout of particle tables.
    #[must_use]
    pub fn new(ctx: &Arc<Context>, tables: Tables) -> Self {
        let ctx = Arc::clone(ctx);
        let made = Vec::new();
        Self { ctx, tables, made }
    }

    /// Makes the pipeline of a kernel with these constants, unless it exists.
    ///
    /// # Errors
    /// When the device cannot run the kernel.
    pub fn make<K: Kernel<Constants: Value> + 'static>(
        &mut self,
        name: &'static str,
        constants: &K::Constants,
    ) -> Result<(), GpuError> {
        if !self.has::<K>(name, constants) {
            let pipeline = Pipeline::<K>::over(&self.ctx, constants, name, self.tables)?;
            self.add(name, (*constants, pipeline));
        }
        Ok(())
    }

    /// As [`make`](Self::make), for draws.
    ///
    /// # Errors
    /// When the device does not support it.
    pub fn make_draw<D: Draw<Constants: Value> + 'static>(
        &mut self,
        constants: &D::Constants,
        options: RasterOptions,
    ) -> Result<(), GpuError> {
        if !self.has_draw::<D>(constants) {
            let pipeline = RasterPipeline::<D>::new(&self.ctx, constants, options)?;
            self.add(D::NAME, (*constants, pipeline));
        }
        Ok(())
    }

    /// Does the pipeline of a kernel with these constants exist?
    #[must_use]
    pub fn has<K: Kernel<Constants: Value> + 'static>(
        &self,
        name: &str,
        constants: &K::Constants,
    ) -> bool {
        let mut made = self.all::<(K::Constants, Pipeline<K>)>(name);
        made.any(|(made, _)| made == constants)
    }

    /// Does the pipeline of a draw with these constants exist? It is made with its constants once.
    #[must_use]
    pub fn has_draw<D: Draw<Constants: Value> + 'static>(&self, constants: &D::Constants) -> bool {
        let made = self.find::<(D::Constants, RasterPipeline<D>)>(D::NAME);
        made.is_some_and(|(made, _)| made == constants)
    }

    /// The pipeline of a kernel.
    ///
    /// # Panics
    /// When it was not made, or with other constants.
    #[must_use]
    pub fn of<K: Kernel<Constants: Value> + 'static>(
        &self,
        name: &str,
        constants: &K::Constants,
    ) -> &Pipeline<K> {
        let mut made = self.all::<(K::Constants, Pipeline<K>)>(name);
        match made.find(|(made, _)| made == constants) {
            Some((_, pipeline)) => pipeline,
            None => panic!("`{name}` was not made with {constants:?}"),
        }
    }

    /// The pipeline of a draw.
    ///
    /// # Panics
    /// When it was not made.
    #[must_use]
    pub fn of_draw<D: Draw<Constants: Value> + 'static>(&self) -> &RasterPipeline<D> {
        match self.find::<(D::Constants, RasterPipeline<D>)>(D::NAME) {
            Some((_, pipeline)) => pipeline,
            None => panic!("`{}` was not made", D::NAME),
        }
    }

    fn add(&mut self, name: &'static str, pipeline: impl Any + Send + Sync) {
        let pipeline = Box::new(pipeline);
        self.made.push(Made { name, pipeline });
    }

    fn find<T: 'static>(&self, name: &str) -> Option<&T> {
        self.all(name).next()
    }

    fn all<'s, T: 'static>(&'s self, name: &str) -> impl Iterator<Item = &'s T> {
        let of_name = self.made.iter().filter(move |made| made.name == name);
        of_name.filter_map(|made| made.pipeline.downcast_ref())
    }
}

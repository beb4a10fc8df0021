//! A step as a value: an ordered list of works, each kernel with its constants, parameters and arguments. Two engines execute it:
//! [`on_device`](Step::on_device) records it, with the barriers that follow from it, and [`on_host`](Step::on_host) runs the
//! twins on plain arrays.

use std::fmt::{self, Debug};

use bytemuck::Pod;

use super::arrays::Arrays;
use super::pipelines::{Pipelines, Value};
use super::roles::Pair;
use super::state::State;
use crate::gpu::{AnyBuffer, Buffer, DispatchGroups, GpuError, Kernel, Recorder, Threads};

/// A kernel of steps. Its file has its parameters, its bindings and its twin.
pub trait StepKernel: Kernel<Constants: Value, Params: Value> + Sized + Debug + 'static {
    /// Selects the data, if a step runs the kernel on several; else `()`.
    type On: Value;

    /// Its name in times and messages.
    fn name(_on: Self::On) -> &'static str {
        Self::NAME
    }

    /// Its bindings on the device.
    fn args<'s>(call: &Call<Self>, s: &'s State) -> Self::Args<'s>;

    /// Runs the twin on the host.
    fn twin(call: &Call<Self>, a: &mut Arrays);
}

/// A call of a kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Call<K: StepKernel> {
    /// The data that it works on.
    pub on: K::On,
    /// Specialization constants.
    pub constants: K::Constants,
    /// Push constants.
    pub params: K::Params,
}

/// The number of invocations of a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Groups {
    /// This number, rounded up to whole groups.
    Threads(Threads),
    /// The number that an earlier kernel has counted on the device.
    Counted(Counter),
    /// The counted number, with an upper bound from the host.
    AtMost(Threads, Counter),
}

/// Groups that kernels count for later kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counter {
    /// One invocation per transfer.
    Transfers,
    /// One per particle, if more are selected than the lists hold.
    Excess,
    /// One group, if more are selected than the lists hold.
    Limit,
    /// One per slot that may hold a particle of another object than its window's.
    Candidates,
    /// One per entry of the lists of such slots.
    Strays,
    /// One per particle whose sensors must walk.
    Walking,
    /// One per particle that may be near other objects.
    Nearby,
    /// One per particle for which both hold.
    WalkingNearby,
    /// One per texel of the tiles that must be searched.
    Tiles,
    /// One per texel that other objects cover.
    Covered,
    /// One per texel whose scent has changed.
    Scented,
}

impl Counter {
    fn of(self, s: &State) -> (&Buffer<DispatchGroups>, usize) {
        match self {
            Self::Transfers => (&s.transfers.groups, 0),
            Self::Excess => (&s.transfers.groups, 1),
            Self::Limit => (&s.transfers.groups, 2),
            Self::Candidates => (&s.transfers.groups, 3),
            Self::Strays => (&s.transfers.groups, 4),
            Self::Walking => (&s.walkers.groups, 0),
            Self::Nearby => (&s.walkers.groups, 1),
            Self::WalkingNearby => (&s.walkers.groups, 2),
            Self::Tiles => (&s.near.tile_groups, 0),
            Self::Covered => (&s.near.covered_groups, 0),
            Self::Scented => (&s.food().groups, 0),
        }
    }
}

impl Counter {
    /// Is the count above 0? Twins accept empty lists, but the lists of transfers may be absent.
    fn has_any(self, a: &Arrays) -> bool {
        let groups = &a.transfers.groups;
        match self {
            Self::Transfers => groups[0].x > 0,
            Self::Excess => groups[1].x > 0,
            Self::Limit => groups[2].x > 0,
            Self::Candidates => groups[3].x > 0,
            Self::Strays => groups[4].x > 0,
            _ => true,
        }
    }
}

impl From<Threads> for Groups {
    fn from(threads: Threads) -> Self {
        Self::Threads(threads)
    }
}

impl From<Counter> for Groups {
    fn from(counter: Counter) -> Self {
        Self::Counted(counter)
    }
}

/// One work of a step.
pub trait Work: Debug + Send + Sync {
    /// The kernels that it runs; none if it only uploads values, or swaps buffers.
    fn kernels(&self) -> Vec<&'static str> {
        Vec::new()
    }

    /// Makes its pipeline.
    fn prepare(&self, _made: &mut Pipelines) -> Result<(), GpuError> {
        Ok(())
    }

    /// Does its pipeline exist?
    fn is_prepared(&self, _made: &Pipelines) -> bool {
        true
    }

    /// Records it for the device.
    fn on_device(&self, rec: &mut Recorder, made: &Pipelines, s: &mut State);

    /// Executes it on the host.
    fn on_host(&self, a: &mut Arrays);
}

/// The works of a step, in order.
#[derive(Debug, Default)]
pub struct Step {
    works: Vec<Box<dyn Work>>,
}

impl Step {
    /// Runs a kernel.
    pub fn run<K: StepKernel>(&mut self, groups: impl Into<Groups>, call: Call<K>) {
        let groups = groups.into();
        self.add(Dispatch { groups, call });
    }

    /// Runs a kernel with a counted number of invocations, which is at most `most`.
    pub fn run_at_most<K: StepKernel>(&mut self, most: Threads, counter: Counter, call: Call<K>) {
        let groups = Groups::AtMost(most, counter);
        self.add(Dispatch { groups, call });
    }

    /// Uploads values from the host. They are part of the commands, so queued steps keep theirs.
    pub fn write<T: Pod + Debug + Send + Sync>(
        &mut self,
        values: &[T],
        on_device: fn(&State) -> &Buffer<T>,
        on_host: fn(&mut Arrays) -> &mut Vec<T>,
    ) {
        let values = values.to_vec();
        self.add(Write {
            values,
            on_device,
            on_host,
        });
    }

    /// Resets counters of the device; the twins need none.
    pub fn reset<T: Pod + Debug + Send + Sync, const N: usize>(
        &mut self,
        values: [T; N],
        on_device: fn(&State) -> &Buffer<T>,
    ) {
        self.add(Reset { values, on_device });
    }

    /// Fills a buffer with one number.
    pub fn fill(
        &mut self,
        value: u32,
        on_device: fn(&State) -> &dyn AnyBuffer,
        on_host: fn(&mut Arrays) -> &mut Vec<u32>,
    ) {
        self.add(Fill {
            value,
            on_device,
            on_host,
        });
    }

    /// Runs kernels that may overlap, although they write to the same buffers; `reason` says why no order matters.
    pub fn unordered(
        &mut self,
        reason: &'static str,
        shared: fn(&State) -> Vec<&dyn AnyBuffer>,
        kernels: impl FnOnce(&mut Self),
    ) {
        let mut group = Self::default();
        kernels(&mut group);
        if group.works.len() < 2 {
            return self.works.extend(group.works);
        }
        self.add(Unordered {
            reason,
            shared,
            kernels: group,
        });
    }

    /// Interleaves two independent lists of works: neither uses buffers that the other writes or swaps. Each barrier serves both, and
    /// the device can run kernels of both at once.
    pub fn side_by_side(&mut self, one: impl FnOnce(&mut Self), other: impl FnOnce(&mut Self)) {
        let (mut first, mut second) = (Self::default(), Self::default());
        one(&mut first);
        other(&mut second);
        let mut rest = second.works.into_iter();
        for work in first.works {
            self.works.push(work);
            self.works.extend(rest.next());
        }
        self.works.extend(rest);
    }

    /// Lets two buffers change roles.
    pub fn swap(&mut self, pair: Pair) {
        self.add(Swap(pair));
    }

    /// Adds another kind of work.
    pub fn add(&mut self, work: impl Work + 'static) {
        self.works.push(Box::new(work));
    }

    /// The works, in order.
    #[must_use]
    pub fn works(&self) -> &[Box<dyn Work>] {
        &self.works
    }

    /// Makes all pipelines of the step.
    ///
    /// # Errors
    /// When the device cannot run a kernel.
    pub fn prepare(&self, made: &mut Pipelines) -> Result<(), GpuError> {
        self.works.iter().try_for_each(|work| work.prepare(made))
    }

    /// Do all pipelines of the step exist?
    #[must_use]
    pub fn is_prepared(&self, made: &Pipelines) -> bool {
        self.works.iter().all(|work| work.is_prepared(made))
    }

    /// Records the step for the device.
    ///
    /// # Panics
    /// When one of its pipelines was not made.
    pub fn on_device(&self, rec: &mut Recorder, made: &Pipelines, s: &mut State) {
        for work in &self.works {
            work.on_device(rec, made, s);
        }
    }

    /// Executes the step on the host.
    pub fn on_host(&self, a: &mut Arrays) {
        for work in &self.works {
            work.on_host(a);
        }
    }
}

#[derive(Debug)]
struct Dispatch<K: StepKernel> {
    groups: Groups,
    call: Call<K>,
}

impl<K: StepKernel> Work for Dispatch<K> {
    fn kernels(&self) -> Vec<&'static str> {
        vec![K::name(self.call.on)]
    }

    fn prepare(&self, made: &mut Pipelines) -> Result<(), GpuError> {
        made.make::<K>(K::name(self.call.on), &self.call.constants)
    }

    fn is_prepared(&self, made: &Pipelines) -> bool {
        made.has::<K>(K::name(self.call.on), &self.call.constants)
    }

    fn on_device(&self, rec: &mut Recorder, made: &Pipelines, s: &mut State) {
        let call = &self.call;
        let pipeline = made.of::<K>(K::name(call.on), &call.constants);
        let args = K::args(call, s);
        match self.groups {
            Groups::Threads(threads) => rec.dispatch(pipeline, threads, args, call.params),
            Groups::Counted(counter) => {
                rec.dispatch_indirect(pipeline, counter.of(s), args, call.params);
            }
            Groups::AtMost(threads, counter) => {
                rec.dispatch_at_most(pipeline, threads, counter.of(s), args, call.params);
            }
        }
    }

    fn on_host(&self, a: &mut Arrays) {
        let runs = match self.groups {
            Groups::Counted(counter) => counter.has_any(a),
            Groups::Threads(_) | Groups::AtMost(..) => true,
        };
        if runs {
            K::twin(&self.call, a);
        }
    }
}

struct Unordered {
    reason: &'static str,
    shared: fn(&State) -> Vec<&dyn AnyBuffer>,
    kernels: Step,
}

impl Debug for Unordered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut fields = f.debug_tuple("Unordered");
        fields.field(&self.reason).field(&self.kernels).finish()
    }
}

impl Work for Unordered {
    fn kernels(&self) -> Vec<&'static str> {
        let works = self.kernels.works.iter();
        works.flat_map(|work| work.kernels()).collect()
    }

    fn prepare(&self, made: &mut Pipelines) -> Result<(), GpuError> {
        self.kernels.prepare(made)
    }

    fn is_prepared(&self, made: &Pipelines) -> bool {
        self.kernels.is_prepared(made)
    }

    fn on_device(&self, rec: &mut Recorder, made: &Pipelines, s: &mut State) {
        rec.begin_unordered(self.reason, &(self.shared)(s));
        self.kernels.on_device(rec, made, s);
        rec.end_unordered();
    }

    fn on_host(&self, a: &mut Arrays) {
        self.kernels.on_host(a);
    }
}

struct Write<T> {
    values: Vec<T>,
    on_device: fn(&State) -> &Buffer<T>,
    on_host: fn(&mut Arrays) -> &mut Vec<T>,
}

impl<T: Debug> Debug for Write<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Write").field(&self.values).finish()
    }
}

impl<T: Pod + Debug + Send + Sync> Work for Write<T> {
    fn on_device(&self, rec: &mut Recorder, _made: &Pipelines, s: &mut State) {
        rec.update_long((self.on_device)(s), &self.values);
    }

    fn on_host(&self, a: &mut Arrays) {
        (self.on_host)(a).clone_from(&self.values);
    }
}

struct Fill {
    value: u32,
    on_device: fn(&State) -> &dyn AnyBuffer,
    on_host: fn(&mut Arrays) -> &mut Vec<u32>,
}

impl Debug for Fill {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Fill").field(&self.value).finish()
    }
}

impl Work for Fill {
    fn on_device(&self, rec: &mut Recorder, _made: &Pipelines, s: &mut State) {
        rec.fill((self.on_device)(s), self.value);
    }

    fn on_host(&self, a: &mut Arrays) {
        (self.on_host)(a).fill(self.value);
    }
}

struct Reset<T, const N: usize> {
    values: [T; N],
    on_device: fn(&State) -> &Buffer<T>,
}

impl<T: Debug, const N: usize> Debug for Reset<T, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Reset").field(&self.values).finish()
    }
}

impl<T: Pod + Debug + Send + Sync, const N: usize> Work for Reset<T, N> {
    fn on_device(&self, rec: &mut Recorder, _made: &Pipelines, s: &mut State) {
        rec.update_long((self.on_device)(s), &self.values);
    }

    fn on_host(&self, _a: &mut Arrays) {}
}

#[derive(Debug)]
struct Swap(Pair);

impl Work for Swap {
    fn on_device(&self, _rec: &mut Recorder, _made: &Pipelines, s: &mut State) {
        s.swap(self.0);
    }

    fn on_host(&self, a: &mut Arrays) {
        a.swap(self.0);
    }
}

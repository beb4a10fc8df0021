//! The parts of a simulation's state that checkpoints keep: one [list](KEPT), each part with its field in [`Snapshot`] and, if it is
//! on the device, its [row](super::buffers::TABLE) and its buffer in [`State`].
//!
//! From the list come the copies to the host, with waiting and without, those that stay on the device, the sections of a checkpoint, the
//! check of their lengths, and what is uploaded when a simulation is resumed. One more part takes a field in [`Snapshot`], a line here and
//! a new version of checkpoints.

use std::collections::VecDeque;

use bytemuck::Pod;
use serde::{Deserialize, Serialize};

use super::buffers::{self, Counts, Row};
use super::setup::Setup;
use super::snapshot::Snapshot;
use super::state::State;
use super::types::Flow;
use crate::gpu::{AnyBuffer, Buffer, Context, GpuError, Readback, Recorder};

macro_rules! kept {
    ($($($field:ident).+ [$(= $like:ident)? $($length:ident)?] $device:expr $(, $elements:literal)?;)*) => {
        /// How many elements the sections of a checkpoint have, in the order of its header.
        #[derive(Default, Serialize, Deserialize)]
        #[serde(default)]
        pub struct Lengths {
            $($($length: u64,)?)*
        }

        /// The kept parts, in the order of a checkpoint's sections.
        pub const KEPT: &[&dyn Part] = &[$(
            &Section {
                get: |snapshot| Field::elements(&snapshot.$($field).+),
                set: |snapshot, elements| Field::set(&mut snapshot.$($field).+, elements),
                length: kept!(@length $($like)? $($length)?),
                elements: kept!(@elements $($elements)?),
                device: $device,
            }
        ),*];
    };
    (@length) => { |_| None };
    (@length $length:ident) => { |lengths| Some(&mut lengths.$length) };
    (@elements) => { None };
    (@elements $elements:literal) => { Some($elements) };
}

// Columns: the field of `Snapshot`; the name of its length in a checkpoint's header, with `=` if an earlier part has that length,
// too, and none if there is always one element; the buffer; and what error messages call the elements if their number is wrong,
// where only this list checks it.
kept! {
    particles [particles]           permanent(&buffers::PARTICLES, |state| Some(&state.particles)), "particles";
    motions [= particles]           permanent(&buffers::MOTIONS, |state| Some(&state.motions)), "motions";
    trail [texels]                  permanent(&buffers::TRAIL_FRONT, |state| Some(&state.trail.front)), "texels of trail";
    // The counts of the last step are at the back, for decrowding.
    deposits [= texels]             permanent(&buffers::DEPOSITS_BACK, |state| Some(&state.deposits.back)), "texels of deposits";
    transfers.windows [windows]     remade(&buffers::WINDOWS, |state| state.transfers.kept_windows());
    // Checkpoints of earlier versions have particles in flight.
    transfers.in_flight [in_flight] on_host();
    transfers.flow []               converted(&buffers::FLOW, |state| Some(&state.transfers.flow), |flows| {
                                        flows.iter().map(Flow::between_steps).collect()
                                    });
    transfers.flux [flux]           remade(&buffers::FLUX, |state| state.transfers.kept_flux()), "counts of flux";
    last_poses [last_poses]         on_host();
    distance_poses [distance_poses] on_host();
    kept_pairs [kept_pairs]         on_host();
    bias [bias]                     remade(&buffers::BIAS, |state| state.bias.as_deref()), "texels of bias";
    food.remaining [foods]          converted(&buffers::MEALS, |state| Some(&state.food.as_ref()?.meals), |meals| {
                                        meals.iter().map(|meal| meal.remaining).collect()
                                    });
    // Checkpoints of version 6 lack the parts from here on.
    pulses [pulses]                 on_host();
    looks [looks]                   remade(&buffers::LOOKS, |state| state.looks.as_deref()), "texels of a second look";
    // Those of version 7 lack the parts from here on.
    population [population]         permanent(&buffers::POPULATION, |state| state.kept_population()), "counts of a population";
    // Their number is checked with what they are.
    transfers.restarts.places [restart_places]
                                    remade(&buffers::RESTARTS, |state| Some(state.transfers.kept_restarts()?.0));
    transfers.restarts.ranges [restart_ranges]
                                    remade(&buffers::RESTART_RANGES, |state| Some(state.transfers.kept_restarts()?.1));
}

/// A part, whatever its elements are.
pub trait Part: Sync {
    /// Enters its length.
    fn count(&self, snapshot: &Snapshot, lengths: &mut Lengths);

    /// Its bytes in memory, and in a checkpoint.
    fn bytes<'a>(&self, snapshot: &'a Snapshot) -> &'a [u8];

    /// Reads it from the beginning of the rest of a checkpoint; none if that is too short.
    fn read(&self, snapshot: &mut Snapshot, rest: &mut &[u8], lengths: &mut Lengths) -> Option<()>;

    /// Compares its length with that of its buffer by the table.
    ///
    /// # Errors
    /// When they differ.
    fn check_length(&self, snapshot: &Snapshot, counts: &Counts) -> Result<(), String>;

    /// Copies it to the host, if it is on the device; waits for all work submitted so far.
    ///
    /// # Errors
    /// When the device is lost or its memory is full.
    fn download(
        &self,
        ctx: &Context,
        state: &State,
        snapshot: &mut Snapshot,
    ) -> Result<(), GpuError>;

    /// Records the same copy, if it is on the device.
    ///
    /// # Errors
    /// No memory.
    fn record(
        &'static self,
        rec: &mut Recorder,
        state: &State,
    ) -> Result<Option<Box<dyn PartCopy>>, GpuError>;

    /// Records a copy that stays on the device, if it is there.
    ///
    /// # Errors
    /// No memory.
    fn record_on_device(
        &'static self,
        rec: &mut Recorder,
        state: &State,
    ) -> Result<Option<Box<dyn PartOnDevice>>, GpuError>;

    /// How many bytes that copy takes; 0 without one.
    fn bytes_on_device(&self, state: &State) -> u64;

    /// Uploads it, if its buffer is [permanent].
    ///
    /// # Errors
    /// When the device is lost or its memory is full.
    fn upload(&self, ctx: &Context, state: &State, snapshot: &Snapshot) -> Result<(), GpuError>;
}

/// A part being copied to the host.
pub trait PartCopy: Send {
    /// Has its frame finished? Does not wait.
    fn is_there(&mut self) -> bool;

    /// Puts it into a snapshot, once it is there.
    fn take(self: Box<Self>, snapshot: &mut Snapshot);
}

/// A part whose copy stays on the device.
pub trait PartOnDevice: Send {
    /// Has its buffer the length that it had?
    fn fits(&self, state: &State) -> bool;

    /// Records the way back into its buffer, which [`fits`](Self::fits).
    fn record_back(&self, rec: &mut Recorder, state: &State);
}

impl Lengths {
    /// The parts of a snapshot.
    #[must_use]
    pub fn of(snapshot: &Snapshot) -> Self {
        let mut lengths = Self::default();
        for part in KEPT {
            part.count(snapshot, &mut lengths);
        }
        lengths
    }
}

/// Compares the lengths of a state with those of the buffers that the scene has. The counts are those that the rows of parts use
/// whose elements have a name in the list.
///
/// # Errors
/// Names the first part that is longer or shorter than its buffer.
pub fn check_lengths(snapshot: &Snapshot, setup: &Setup) -> Result<(), String> {
    let texels = setup.atlas.texel_count() as u64;
    let counts = Counts {
        particles: setup.particles.len() as u64,
        objects: setup.poses.len() as u64,
        texels,
        painted: texels,
        looks: texels,
        // The counts are there if the population changes.
        population: (u64::from(setup.population.is_some()), 0),
        ..Counts::default()
    };
    let mut parts = KEPT.iter();
    parts.try_for_each(|part| part.check_length(snapshot, &counts))
}

/// Copies all parts on the device into a snapshot; waits for all work submitted so far.
///
/// # Errors
/// When the device is lost or its memory is full.
pub fn download(ctx: &Context, state: &State, snapshot: &mut Snapshot) -> Result<(), GpuError> {
    let mut parts = KEPT.iter();
    parts.try_for_each(|part| part.download(ctx, state, snapshot))
}

/// Uploads all parts whose buffers are permanent.
///
/// # Errors
/// When the device is lost or its memory is full.
pub fn upload(ctx: &Context, state: &State, snapshot: &Snapshot) -> Result<(), GpuError> {
    let mut parts = KEPT.iter();
    parts.try_for_each(|part| part.upload(ctx, state, snapshot))
}

/// All parts on the device, on their way to the host.
pub struct Copies(Vec<Box<dyn PartCopy>>);

impl Copies {
    /// Records copies of the state after everything recorded so far.
    ///
    /// # Errors
    /// No memory.
    pub fn record(rec: &mut Recorder, state: &State) -> Result<Self, GpuError> {
        let parts = KEPT.iter();
        let copies = parts.filter_map(|part| part.record(rec, state).transpose());
        Ok(Self(copies.collect::<Result<_, _>>()?))
    }

    /// Has the frame finished? Does not wait. Copied parts are kept.
    pub fn are_there(&mut self) -> bool {
        self.0.iter_mut().all(|copy| copy.is_there())
    }

    /// Puts them into a snapshot, once they are there.
    pub fn take(self, snapshot: &mut Snapshot) {
        for copy in self.0 {
            copy.take(snapshot);
        }
    }
}

/// Copies of all parts on the device, which stay there.
pub struct DeviceCopies(Vec<Box<dyn PartOnDevice>>);

impl DeviceCopies {
    /// Records copies of the state after everything recorded so far.
    ///
    /// # Errors
    /// No memory.
    pub fn record(rec: &mut Recorder, state: &State) -> Result<Self, GpuError> {
        let parts = KEPT.iter();
        let copies = parts.filter_map(|part| part.record_on_device(rec, state).transpose());
        Ok(Self(copies.collect::<Result<_, _>>()?))
    }

    /// How many bytes copies of a state take.
    #[must_use]
    pub fn bytes_of(state: &State) -> u64 {
        KEPT.iter().map(|part| part.bytes_on_device(state)).sum()
    }

    /// Has the state the buffers that it had?
    #[must_use]
    pub fn fits(&self, state: &State) -> bool {
        self.0.iter().all(|copy| copy.fits(state))
    }

    /// Records the way back of all, into buffers that [fit](Self::fits).
    pub fn record_back(&self, rec: &mut Recorder, state: &State) {
        for copy in &self.0 {
            copy.record_back(rec, state);
        }
    }
}

/// Records a copy of a buffer that stays on the device.
///
/// # Errors
/// No memory.
pub fn copy_on_device<T: Pod>(
    rec: &mut Recorder,
    source: &Buffer<T>,
) -> Result<Buffer<T>, GpuError> {
    let name = format!("{}.kept", source.name());
    let domain = source.core().domain();
    let copy = Buffer::new(rec.ctx(), &name, source.len(), domain)?;
    rec.copy(source, &copy);
    Ok(copy)
}

/// A buffer being copied to the host.
pub struct BufferCopy<T> {
    /// One for each part of the size that the device allocates at once.
    readbacks: VecDeque<Readback<T>>,
    elements: Vec<T>,
}

impl<T: Pod> BufferCopy<T> {
    /// Records it.
    ///
    /// # Errors
    /// No memory.
    pub fn record(rec: &mut Recorder, row: &Row<T>, source: &Buffer<T>) -> Result<Self, GpuError> {
        let name = format!("{}.copy", row.name);
        let most = rec.ctx().info().max_memory_allocation_size / size_of::<T>() as u64;
        let most = usize::try_from(most).unwrap_or(usize::MAX);
        let mut readbacks = VecDeque::new();
        let mut start = 0;
        while start < source.len() || readbacks.is_empty() {
            let end = source.len().min(start.saturating_add(most));
            let mut readback = Readback::new(rec.ctx(), &name, end - start, 1)?;
            readback.record_range(rec, source, start..end, 0);
            readbacks.push_back(readback);
            start = end;
        }
        Ok(Self {
            readbacks,
            elements: Vec::new(),
        })
    }

    /// Has its frame finished? Does not wait.
    pub fn is_there(&mut self) -> bool {
        while let Some(next) = self.readbacks.front_mut() {
            let Some((_, mut elements)) = next.poll() else {
                return false;
            };
            if self.elements.is_empty() {
                self.elements = elements;
            } else {
                self.elements.append(&mut elements);
            }
            // Its memory is needed no longer.
            self.readbacks.pop_front();
        }
        true
    }

    /// Its elements, once they are there.
    #[must_use]
    pub fn take(self) -> Vec<T> {
        self.elements
    }
}

/// How a field of a snapshot holds elements.
trait Field {
    type Element: Pod;
    fn elements(&self) -> &[Self::Element];
    fn set(&mut self, elements: Vec<Self::Element>);
}

impl<T: Pod> Field for Vec<T> {
    type Element = T;

    fn elements(&self) -> &[T] {
        self
    }

    fn set(&mut self, elements: Vec<T>) {
        *self = elements;
    }
}

impl Field for Flow {
    type Element = Self;

    fn elements(&self) -> &[Self] {
        std::slice::from_ref(self)
    }

    fn set(&mut self, elements: Vec<Self>) {
        *self = elements.first().copied().unwrap_or_default();
    }
}

/// A line of the list: its elements are `T` on the host and in checkpoints, and `D` on the device.
struct Section<T: 'static, D: 'static> {
    get: fn(&Snapshot) -> &[T],
    set: fn(&mut Snapshot, Vec<T>),
    /// None if there is always one element.
    length: fn(&mut Lengths) -> Option<&mut u64>,
    /// The name of the elements in messages about their number; `None` if the number is checked elsewhere.
    elements: Option<&'static str>,
    device: Device<T, D>,
}

/// The device's side of a part.
struct Device<T: 'static, D: 'static> {
    /// None if it is on the host only.
    row: Option<&'static Row<D>>,
    /// None if the scene or its strategy does not use it.
    buffer: fn(&State) -> Option<&Buffer<D>>,
    to_host: fn(Vec<D>) -> Vec<T>,
    /// None if resuming makes a new buffer.
    to_device: Option<ToDevice<T, D>>,
}

/// Elements of the host, as the device has them.
type ToDevice<T, D> = fn(&[T]) -> &[D];

/// A part of the host only.
const fn on_host<T: 'static>() -> Device<T, T> {
    Device {
        row: None,
        buffer: |_| None,
        to_host: |elements| elements,
        to_device: None,
    }
}

/// A part in a permanent buffer: resuming uploads it from here.
const fn permanent<T>(
    row: &'static Row<T>,
    buffer: fn(&State) -> Option<&Buffer<T>>,
) -> Device<T, T> {
    Device {
        to_device: Some(|elements| elements),
        ..remade(row, buffer)
    }
}

/// A part in a buffer that resuming replaces by a new one with its contents, because its size depends on them or it is not always present.
const fn remade<T>(row: &'static Row<T>, buffer: fn(&State) -> Option<&Buffer<T>>) -> Device<T, T> {
    converted(row, buffer, |elements| elements)
}

/// As [`remade`]; the host keeps other elements than the device has.
const fn converted<T, D>(
    row: &'static Row<D>,
    buffer: fn(&State) -> Option<&Buffer<D>>,
    to_host: fn(Vec<D>) -> Vec<T>,
) -> Device<T, D> {
    Device {
        row: Some(row),
        buffer,
        to_host,
        to_device: None,
    }
}

impl<T: Pod, D: Pod + Send> Part for Section<T, D> {
    fn count(&self, snapshot: &Snapshot, lengths: &mut Lengths) {
        if let Some(length) = (self.length)(lengths) {
            *length = (self.get)(snapshot).len() as u64;
        }
    }

    fn bytes<'a>(&self, snapshot: &'a Snapshot) -> &'a [u8] {
        bytemuck::cast_slice((self.get)(snapshot))
    }

    fn read(&self, snapshot: &mut Snapshot, rest: &mut &[u8], lengths: &mut Lengths) -> Option<()> {
        let length = (self.length)(lengths).map_or(1, |length| *length);
        let size = usize::try_from(length).ok()?.checked_mul(size_of::<T>())?;
        let (bytes, tail) = rest.split_at_checked(size)?;
        *rest = tail;
        (self.set)(snapshot, bytemuck::pod_collect_to_vec(bytes));
        Some(())
    }

    fn check_length(&self, snapshot: &Snapshot, counts: &Counts) -> Result<(), String> {
        let (Some(elements), Some(row)) = (self.elements, self.device.row) else {
            return Ok(());
        };
        let there = (self.get)(snapshot).len() as u64;
        let expected = row.len(counts);
        // Buffers that are not permanent may be absent.
        let may_be_none = self.device.to_device.is_none();
        if there == expected || (there == 0 && may_be_none) {
            return Ok(());
        }
        Err(format!("there are {there} {elements}, not {expected}"))
    }

    fn download(
        &self,
        ctx: &Context,
        state: &State,
        snapshot: &mut Snapshot,
    ) -> Result<(), GpuError> {
        if let Some(buffer) = (self.device.buffer)(state) {
            (self.set)(snapshot, (self.device.to_host)(ctx.download(buffer)?));
        }
        Ok(())
    }

    fn record(
        &'static self,
        rec: &mut Recorder,
        state: &State,
    ) -> Result<Option<Box<dyn PartCopy>>, GpuError> {
        let (Some(row), Some(buffer)) = (self.device.row, (self.device.buffer)(state)) else {
            return Ok(None);
        };
        let copy = BufferCopy::record(rec, row, buffer)?;
        Ok(Some(Box::new(SectionCopy {
            section: self,
            copy,
        })))
    }

    fn record_on_device(
        &'static self,
        rec: &mut Recorder,
        state: &State,
    ) -> Result<Option<Box<dyn PartOnDevice>>, GpuError> {
        let Some(buffer) = (self.device.buffer)(state) else {
            return Ok(None);
        };
        let copy = copy_on_device(rec, buffer)?;
        Ok(Some(Box::new(SectionOnDevice {
            section: self,
            copy,
        })))
    }

    fn bytes_on_device(&self, state: &State) -> u64 {
        (self.device.buffer)(state).map_or(0, Buffer::size_in_bytes)
    }

    fn upload(&self, ctx: &Context, state: &State, snapshot: &Snapshot) -> Result<(), GpuError> {
        match ((self.device.buffer)(state), self.device.to_device) {
            (Some(buffer), Some(to_device)) => ctx.upload(buffer, to_device((self.get)(snapshot))),
            _ => Ok(()),
        }
    }
}

/// A line of the list being copied to the host.
struct SectionCopy<T: 'static, D: 'static> {
    section: &'static Section<T, D>,
    copy: BufferCopy<D>,
}

impl<T: Pod, D: Pod + Send> PartCopy for SectionCopy<T, D> {
    fn is_there(&mut self) -> bool {
        self.copy.is_there()
    }

    fn take(self: Box<Self>, snapshot: &mut Snapshot) {
        (self.section.set)(snapshot, (self.section.device.to_host)(self.copy.take()));
    }
}

/// A line of the list whose copy stays on the device.
struct SectionOnDevice<T: 'static, D: 'static> {
    section: &'static Section<T, D>,
    copy: Buffer<D>,
}

impl<T: Pod, D: Pod + Send> PartOnDevice for SectionOnDevice<T, D> {
    fn fits(&self, state: &State) -> bool {
        let buffer = (self.section.device.buffer)(state);
        buffer.is_some_and(|buffer| buffer.len() == self.copy.len())
    }

    fn record_back(&self, rec: &mut Recorder, state: &State) {
        if let Some(buffer) = (self.section.device.buffer)(state) {
            rec.copy(&self.copy, buffer);
        }
    }
}

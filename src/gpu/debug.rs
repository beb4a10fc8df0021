//! Values that kernels report by `debug_value(tag, value)` of `shaders/include/debug.glsl`.

use std::fmt;

/// Entries that the host keeps until they are taken.
const REMEMBERED: usize = 1 << 20;

/// A value of the type that the kernel passed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DebugValue {
    /// `uint`
    Uint(u32),
    /// `int`
    Int(i32),
    /// `float`
    Float(f32),
}

/// One call of `debug_value`.
#[derive(Clone, Debug, PartialEq)]
pub struct DebugEntry {
    /// The kernel that called.
    pub kernel: String,
    /// The number of the invocation; of the vertex; or row (upper half) and column of the fragment.
    pub invocation: u32,
    /// First argument.
    pub tag: u32,
    /// Second argument.
    pub value: DebugValue,
}

/// Values that kernels wrote since the last call of [`Context::debug_entries`](super::Context::debug_entries).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DebugEntries {
    /// By frame, dispatch and invocation; the calls of one invocation in their order.
    pub entries: Vec<DebugEntry>,
    /// Calls that found the list full.
    pub overflow: u64,
}

impl fmt::Display for DebugValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DebugValue::Uint(value) => write!(f, "{value}"),
            DebugValue::Int(value) => write!(f, "{value:+}"),
            DebugValue::Float(value) => write!(f, "{value:?}"),
        }
    }
}

/// One line a value, and one for those that did not fit.
impl fmt::Display for DebugEntries {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for DebugEntry {
            kernel,
            invocation,
            tag,
            value,
        } in &self.entries
        {
            writeln!(f, "{kernel}[{invocation}] {tag}: {value}")?;
        }
        if self.overflow > 0 {
            writeln!(
                f,
                "{} more values did not fit: write fewer, or raise debug_capacity",
                self.overflow
            )?;
        }
        Ok(())
    }
}

impl DebugEntries {
    /// Adds a frame's entries, as many as the host remembers.
    pub(crate) fn append(&mut self, mut more: DebugEntries) {
        let room = REMEMBERED.saturating_sub(self.entries.len());
        let lost = more.entries.len().saturating_sub(room);
        more.entries.truncate(room);
        self.entries.append(&mut more.entries);
        self.overflow += more.overflow + lost as u64;
    }
}

//! What runs have measured, as files and as text: the report, the trace, and what they are made of. Both the command line and the
//! window write these.

pub mod counters;
pub mod host;
pub mod measures;
pub mod recent;
pub mod report;
pub mod settings;
pub mod table;
pub mod times;
pub mod tracing;
pub mod work;

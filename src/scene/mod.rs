//! Scenes: objects, parameters and the files that hold them.

pub mod file;
pub mod parameters;
pub mod settings;

pub use settings::Settings;

//! Tests of scenes: files, overrides, messages.

mod feeding;
mod loading;
mod moving;
mod reading;

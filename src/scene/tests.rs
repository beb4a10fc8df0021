//! Tests of scenes as their users meet them: files, overrides, messages.

mod feeding;
mod loading;
mod moving;
mod reading;

//! The simulation as a whole: what must hold over many steps, whatever a scene has.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/places.rs"]
mod places;
#[path = "../program/mod.rs"]
mod program;

mod altered;
mod areas;
mod diffusion;
mod food;
mod host_work;
mod invariants;
mod long;
mod memory;
mod moving;
mod moving_together;
mod networks;
mod paint;
mod scale;
mod sensing;
mod starts;
mod step;
mod transfers;

//! Physarum growing on the surfaces of several moving 3D objects, in real time, on explicit Vulkan.
//!
//! Particles walk on triangle meshes along straight lines that are unfolded across each edge, read the trail that
//! other particles left with three sensors, turn towards more of it, and leave a trail of their own, which spreads over the
//! surface and decays (the agent model of Jones, "Characteristics of Pattern Formation and Evolution in
//! Approximations of Physarum Transport Networks", Artificial Life 16(2), 2010; by default particles may share a place and no
//! turn is random, and `docs/guide.md` has the other differences and the keys that lift them).
//! The `myxo` executable is a thin user of this library.
//!
//! What each parameter does to the picture is shown in `docs/guide.md`; `docs/code.md` goes through a step kernel by kernel.
//!
//! ```
//! use myxo::{gpu, scene, sim};
//!
//! # fn main() -> myxo::Result<()> {
//! let ctx = gpu::Context::new(&gpu::ContextOptions::default())?;
//! let scene = scene::Scene::load("cube".as_ref(), &scene::Overrides::default())?;
//! let mut simulation = sim::Simulation::new(&ctx, &scene)?;
//! let mut frames = gpu::Frames::new(&ctx, 2)?;
//! for _ in 0..3 {
//!     let mut rec = frames.begin()?;
//!     simulation.record_step(&mut rec);
//!     frames.submit(rec)?;
//! }
//! frames.wait_idle()?;
//! let state = simulation.snapshot()?;
//! assert_eq!(state.step, 3);
//! state.validate(simulation.setup()).expect("no particle is lost");
//! # Ok(())
//! # }
//! ```
//!
//! # Layers
//!
//! ```text
//! bin        arguments, window, panel, reports           src/main.rs, src/cli/, src/lab/
//! python     the package's extension module, if built    src/python/, python/
//! sweep      many runs, and a table of them              src/sweep/
//! export     models, data and scene files of a state     src/export/
//! render     draws what sim owns; swapchain, interface   src/render/
//! sim        particles, trail, step                      src/sim/   (step/: its kernels)
//! scene      objects = mesh + pose; scene files          src/scene/
//! mesh       triangle-mesh geometry, no Vulkan           src/mesh/
//! gpu        Vulkan, no meshes                           src/gpu/
//! ```
//!
//! **Invariant:** a layer uses only those below it; [`mesh`] and [`gpu`] don't use each other. `tests/project/tidy.rs`
//! keeps it so.
//!
//! # One step
//!
//! [`sim::step`] is the whole simulation, as a script of dispatches, and the only place that lists them all in
//! their order; `docs/code.md` goes through it kernel by kernel. Its parts:
//!
//! 1. If objects have moved, each texel's signed distance to the other objects is computed, and the places where sensors continue.
//! 2. If the population changes, in some steps particles divide or die. Every particle walks its pending length, senses, turns, walks,
//!    deposits, and is selected if it has gone into another object. Selected particles land on the other object, and the particle buffer is
//!    put in order again. In each step one part of the particles is sorted by place in the texture, so that after a fixed number of steps
//!    all have been sorted.
//! 3. If there is food, the amounts eaten are subtracted, and the scent that sensors read is summed up again. Projected food adds to the
//!    trail.
//! 4. The trail spreads, takes up the deposits and decays: inside charts, then over seams; then the gutters are filled, so that
//!    reads never see a seam.
//!
//! Transfers after the walk, and parts 3 and 4, do not depend on each other, so their kernels are recorded side by side.
//!
//! Kernels that a scene does not need are not recorded: with one object there are no distances and no transfers. Which of the
//! kernels for transfers run is the strategy ([`scene::settings::Strategy`]); all counts stay on the GPU, and dispatches over
//! them are indirect.
//!
//! Everything of all objects is pooled: one vertex array, one triangle array, one half-edge array
//! ([`mesh::surface::Surface`]), and one texture, the world atlas ([`mesh::atlas::Atlas`]), in which every triangle
//! has its place. A triangle id is global and says which object it belongs to, so a particle needs no object id.
//!
//! A kernel is its `.comp` file in `shaders/`: the build compiles and reflects it and writes the typed handle
//! ([`sim::kernels`]), so binding numbers, group sizes and element types are in one place. To add a kernel is to
//! write the shader, its file in `src/sim/step/` with its twin, and its line in the step script. Only tests and `myxo selftest` use a twin.
//! Alternatives that are not used are in `shaders/choices/`; only the example `choices` runs them.
//!
//! # Words
//!
//! - **half-edge** `h = 3 * triangle + corner`: a directed edge of a triangle; its **twin** is the same edge seen
//!   from the neighbour.
//! - **glued** edges: two border edges that are one, although they lie apart ([`mesh::Mesh::glued`]). They are twins; what works by
//!   place takes them for borders.
//! - **uv**: the barycentric weights of corners B and C; `P = A + u (B - A) + v (C - A)`.
//! - **tangent frame**: of a triangle, `p` along `B - A` and `h` perpendicular to it; lengths in it are world lengths.
//! - **heading**: the unit vector of a particle in its triangle's tangent frame.
//! - **walk**: the straightest path; the triangles that it crosses are laid out flat, edge by edge, as seen from its start.
//! - **cell**: an owned texel. Every texel of the surface has one. By some rules there is one particle a cell, and sensors read cells.
//! - **claim**, **rank**: particles claim the cells that they would come to, by the ranks that the cells have in a step; the lowest claim wins.
//! - **dead**: a particle that is a free slot with an id, which a particle that is born will get ([`sim::step::population`]). It counts for
//!   the object on which it died.
//! - **edge-crossing attempts**: how many edges one walk may cross; the rest of the walk is **pending** and comes first in the next step.
//! - **trail**, **deposit**: the field that particles read; the integer count of particles per texel in a step.
//! - **dab**: one touch of a brush, between steps: a ball in world space, and the part of the surface that lies in it
//!   ([`sim::Simulation::paint`]). **Bias**: trail units that sensors read on top of the trail, or the mark of a no-go area, which
//!   particles may not enter. It is painted, or comes from a map of **areas** ([`sim::areas`]).
//! - **food**, **marker**: a place on an object with a **scent** ([`sim::food`]), which sensors read on top of the trail, the
//!   stronger the nearer they are along the surface. Particles eat food where its **plate** is, a **meal** at a time; markers
//!   are never eaten. A particle that has eaten is **fed** for some steps, otherwise **hungry**.
//! - **owned** texel: its centre lies in a triangle. **Gutter** texel: beside an owned one, filled from across the
//!   seam.
//! - **object**: a mesh with a pose; its particles, its texels. **Signed distance**: to the nearest other object,
//!   negative inside of it; clamped beyond the **reach**.
//! - **covered**: at a place whose signed distance is below the **threshold**. A particle whose step goes into covered
//!   places is **selected**: it leaves its object and lands on the other one, which is a **transfer**.
//! - **crossing**: where a walk meets another object. The walk is **folded** about the line in which the two surfaces meet.
//! - **window**: the part of the particle buffer that holds one object's particles; windows follow each other in a **ring**.
//! - **scene radius**: the unit of lengths in scene files.
//!
//! # Promises
//!
//! **Invariant:** the same scene and seed give the same bits on every device ([`strict`]); `docs/code.md` has the exceptions. Random
//! streams are keyed by (seed, particle id, step, purpose), never by a slot ([`rng`]); deposits are integer counts; the state hash
//! ([`sim::Snapshot::hash`]) does not depend on the order of particles. If the transfer buffer is full, keys decide which particles stay,
//! and not the order of atomic additions.
//!
//! **Invariant:** births minus deaths is the change of the population; by default there are none.
//!
//! **Invariant:** no particle is lost or doubled, and every living one counts once a step on an owned or a gutter texel
//! ([`sim::Snapshot::validate`]).
//!
//! **Invariant:** every kernel has a twin in plain Rust: integers equal, floats within a stated bound
//! (`tests/kernels/`), and a test that turns red when a constant of it is wrong (`make mutants`).
//!
//! **Invariant:** arrays that do not fit into a storage block or a texel buffer of the device are accessed by other paths
//! ([`sim::texel_paths`]), with equal bits as the result.
//!
//! **Invariant:** sizes made on the GPU stay there; no step waits for the host. `unsafe` stays in [`gpu`], in the one file
//! that passes Vulkan handles to egui's painter (`render::gui`), and in `signals`.

mod choice;
mod commit;
pub mod error;
mod kept_files;
#[doc(hidden)]
pub mod plain_text;
#[doc(hidden)]
pub mod portable;
#[doc(hidden)]
pub mod regular_file;
pub mod rng;
#[doc(hidden)]
pub mod signals;
#[doc(hidden)]
pub mod strict;
pub mod whole_file;

pub mod gpu;
pub mod mesh;

pub mod scene;

pub mod sim;

pub mod render;

pub mod export;

#[cfg(feature = "sweep")]
pub mod sweep;

#[cfg(feature = "python")]
mod python;

pub use commit::commit;
pub use error::{Error, Result};

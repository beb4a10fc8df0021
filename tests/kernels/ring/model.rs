//! A ring of windows that random selections drive: particles without any surface worth the name, one triangle an
//! object, and the twins of the kernels that keep the ring in order.

use glam::{Affine3A, Quat, Vec3};
use myxo::gpu::DispatchGroups;
use myxo::mesh::surface::{Surface, Triangle};
use myxo::mesh::{Mesh, suite};
use myxo::rng::{Purpose, random, unit};
use myxo::sim::ground::Ground;
use myxo::sim::kernels::{
    DefragmentScanParams, DefragmentSequentialParams, DefragmentSwapParams, MoveBorderConstants,
    MoveBorderParams, TransferInParams,
};
use myxo::sim::twin::ring::{defragment_scan, defragment_sequential, defragment_swap, move_border};
use myxo::sim::twin::transfer::transfer_in;
use myxo::sim::types::{Flow, Motion, Particle, Pose, Transfer, Vertex, Window};

/// How the windows are kept in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// There are none.
    Scattered,
    /// By one pass.
    Sequential,
    /// By two lists.
    Parallel,
}

/// What an experiment begins with.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub particles: u32,
    pub objects: u32,
    pub capacity: u32,
    /// How many of the particles that advance are selected.
    pub share: f32,
    /// All begin on this object; else everywhere.
    pub all_on: Option<u32>,
    pub seed: u32,
}

/// Objects of one triangle each.
pub struct Objects {
    pub triangles: Vec<Triangle>,
    pub corners: Vec<u32>,
    pub vertices: Vec<Vertex>,
    pub poses: Vec<Pose>,
}

impl Objects {
    pub fn new(count: u32) -> Self {
        let meshes: Vec<Mesh> = (0..count).map(|_| suite::slivers()).collect();
        let pooled: Vec<(&Mesh, f32)> = meshes.iter().map(|mesh| (mesh, 1.0)).collect();
        let surface = Surface::build(&pooled);
        let first = |object: usize| surface.objects[object].triangles.0 as usize;
        let triangles = (0..count as usize).map(|object| surface.triangles[first(object)]);
        let corners = (0..count as usize).flat_map(|object| surface.corners[first(object)]);
        let object_of = |vertex: usize| {
            let inside = |range: &(u32, u32)| (range.0..range.1).contains(&(vertex as u32));
            let found = surface.objects.iter().position(|o| inside(&o.vertices));
            found.expect("every vertex has an object") as u32
        };
        let vertex = |(i, &position): (usize, &Vec3)| Vertex {
            position,
            object: object_of(i),
        };
        let pose = |object: u32| {
            let turn = Quat::from_rotation_y(object as f32) * Quat::from_rotation_x(0.5);
            let place = Vec3::new(0.3 * object as f32, 0.1, -0.2);
            Pose::from(Affine3A::from_rotation_translation(turn, place))
        };
        Self {
            triangles: triangles.collect(),
            corners: corners.collect(),
            vertices: surface.positions.iter().enumerate().map(vertex).collect(),
            poses: (0..count).map(pose).collect(),
        }
    }

    pub fn ground(&self) -> Ground<'_> {
        Ground {
            triangles: &self.triangles,
            corners: &self.corners,
            vertices: &self.vertices,
            poses: &self.poses,
        }
    }
}

/// Everything that the kernels work on.
pub struct Ring {
    pub case: Case,
    pub order: Order,
    pub objects: Objects,
    pub particles: Vec<Particle>,
    pub motions: Vec<Motion>,
    pub windows: Vec<Window>,
    pub flow: Flow,
    pub groups: Vec<DispatchGroups>,
    pub arriving: Vec<Transfer>,
    pub departing: Vec<Transfer>,
    pub particle_indices: Vec<u32>,
    pub transfer_indices: Vec<u32>,
    pub step: u32,
    /// How often each particle advanced, by id.
    pub advanced: Vec<u32>,
    /// Where the selected ones want to go, by id.
    wishes: Vec<u32>,
}

impl Ring {
    pub fn new(case: Case, order: Order) -> Self {
        let objects = Objects::new(case.objects);
        let object_of = |id: u32| {
            let [word, ..] = random(case.seed, id, 0, Purpose::Start);
            case.all_on.unwrap_or(word % case.objects)
        };
        let mut ids: Vec<u32> = (0..case.particles).collect();
        ids.sort_by_key(|&id| object_of(id));
        let particle = |&id: &u32| Particle {
            triangle: object_of(id),
            u: 0.25,
            v: 0.5,
            id,
        };
        let particles: Vec<Particle> = ids.iter().map(particle).collect();
        // The ring begins somewhere, so that windows wrap.
        let mut start = case.seed % case.particles;
        let turn = (case.particles - start) as usize;
        let particles: Vec<Particle> = [&particles[turn..], &particles[..turn]].concat();
        let mut windows = Vec::new();
        for object in 0..case.objects {
            let count = ids.iter().filter(|&&id| object_of(id) == object).count() as u32;
            windows.push(Window { start, count });
            start = (start + count) % case.particles;
        }
        let motion = Motion {
            heading_p: 1.0,
            heading_h: 0.0,
            pending: 0.0,
            flags: 0,
        };
        let lists = case.capacity as usize;
        Self {
            case,
            order,
            objects,
            motions: vec![motion; particles.len()],
            windows,
            flow: Flow::default(),
            groups: vec![DispatchGroups::of(0, 64); 2],
            arriving: vec![Transfer::default(); lists],
            departing: vec![Transfer::default(); lists],
            particle_indices: vec![0; lists],
            transfer_indices: vec![0; lists],
            step: 0,
            advanced: vec![0; particles.len()],
            wishes: vec![0; particles.len()],
            particles,
        }
    }

    pub fn border_params(&self, object: u32) -> (MoveBorderConstants, MoveBorderParams) {
        let constants = MoveBorderConstants {
            windows: self.order != Order::Scattered,
        };
        let params = MoveBorderParams {
            object,
            object_count: self.case.objects,
            particle_count: self.case.particles,
            capacity: self.case.capacity,
            transfer_group: 64,
            particle_group: 64,
        };
        (constants, params)
    }

    pub fn scan_params(&self, object: u32) -> DefragmentScanParams {
        DefragmentScanParams {
            next_object: (object + 1) % self.case.objects,
            particle_count: self.case.particles,
            capacity: self.case.capacity,
        }
    }

    pub fn swap_params(&self) -> DefragmentSwapParams {
        DefragmentSwapParams {
            capacity: self.case.capacity,
        }
    }

    pub fn sequential_params(&self, object: u32) -> DefragmentSequentialParams {
        DefragmentSequentialParams {
            next_object: (object + 1) % self.case.objects,
            object_count: self.case.objects,
            particle_count: self.case.particles,
            part: 0,
        }
    }

    pub fn in_params(&self, object: u32) -> TransferInParams {
        TransferInParams {
            object,
            capacity: self.case.capacity,
        }
    }

    /// Arrivals land, and particles advance and are selected at random: all of a turn before `move_border`.
    pub fn begin_turn(&mut self, object: u32) {
        transfer_in(
            &self.in_params(object),
            &self.objects.ground(),
            &self.arriving,
            &mut self.departing,
            &mut self.flow,
            &mut self.particles,
            &mut self.motions,
        );
        let Case {
            particles, objects, ..
        } = self.case;
        let window = match self.order {
            Order::Scattered => Window {
                start: 0,
                count: particles,
            },
            _ => self.windows[object as usize],
        };
        let stamp = (self.step + 1) << 1;
        for i in 0..window.count {
            let slot = Window::slot(window.start, i, particles) as usize;
            let (particle, motion) = (self.particles[slot], &mut self.motions[slot]);
            if particle.triangle != object || motion.in_flight() || motion.flags == stamp {
                continue;
            }
            motion.flags = stamp;
            self.advanced[particle.id as usize] += 1;
            let purpose = Purpose::SensorNoise;
            let [a, b, ..] = random(self.case.seed, particle.id, self.step, purpose);
            if unit(a) >= self.case.share {
                continue;
            }
            if self.flow.wanted < self.case.capacity {
                self.particle_indices[self.flow.wanted as usize] = slot as u32;
                motion.flags |= Motion::IN_FLIGHT;
                self.wishes[particle.id as usize] = (object + 1 + b % (objects - 1)) % objects;
            }
            self.flow.wanted += 1;
        }
    }

    pub fn move_border(&mut self, object: u32) {
        let (constants, params) = self.border_params(object);
        let Self {
            flow,
            windows,
            groups,
            ..
        } = self;
        move_border(&constants, &params, flow, windows, groups);
    }

    /// What `transfer_out` does, but for where to.
    pub fn depart(&mut self, object: u32) {
        for i in self.flow.carried..self.flow.leaving {
            let slot = self.particle_indices[i as usize];
            let particle = self.particles[slot as usize];
            let flight = self
                .objects
                .ground()
                .flight(&particle, &self.motions[slot as usize]);
            let target = self.wishes[particle.id as usize];
            self.departing[i as usize] = Transfer {
                position: flight.position,
                particle: slot,
                heading: flight.heading,
                source: object,
                normal: flight.normal,
                target,
                triangle: target,
                ..Transfer::default()
            };
        }
    }

    pub fn scan(&mut self, object: u32) {
        defragment_scan(
            &self.scan_params(object),
            &self.departing,
            &self.motions,
            &self.windows,
            &mut self.flow,
            &mut self.particle_indices,
            &mut self.transfer_indices,
        );
        assert_eq!(self.flow.stayers, self.flow.outside, "{:?}", self.case);
    }

    /// Puts the lists of the scan into another order, as atomic counters would.
    pub fn shuffle(&mut self) {
        let count = self.flow.stayers as usize;
        for i in (1..count).rev() {
            let [a, b, ..] = random(self.case.seed, i as u32, self.step, Purpose::Start);
            self.particle_indices.swap(i, a as usize % (i + 1));
            self.transfer_indices.swap(i, b as usize % (i + 1));
        }
    }

    pub fn swap(&mut self) {
        defragment_swap(
            &self.swap_params(),
            &self.flow,
            &self.particle_indices,
            &self.transfer_indices,
            &mut self.departing,
            &mut self.particles,
            &mut self.motions,
        );
    }

    pub fn sequential(&mut self, object: u32) {
        defragment_sequential(
            &self.sequential_params(object),
            &mut self.flow,
            &self.windows,
            &mut self.departing,
            &mut self.particles,
            &mut self.motions,
        );
    }

    /// The next object's arrivals are what has departed here.
    pub fn end_turn(&mut self) {
        std::mem::swap(&mut self.arriving, &mut self.departing);
    }

    /// A whole step by the twins, checked after every turn.
    pub fn step(&mut self) {
        for object in 0..self.case.objects {
            self.begin_turn(object);
            self.move_border(object);
            self.depart(object);
            match self.order {
                Order::Scattered => {}
                Order::Sequential => self.sequential(object),
                Order::Parallel => {
                    self.scan(object);
                    self.shuffle();
                    self.swap();
                }
            }
            self.end_turn();
            self.check(object);
        }
        self.step += 1;
        let once = self.advanced.iter().all(|&times| times == self.step);
        assert!(once, "every particle advances once a step: {:?}", self.case);
    }

    /// What must hold after the turn of `object`.
    pub fn check(&self, object: u32) {
        let Self { case, flow, .. } = self;
        let what = format!("{case:?}, {:?}, step {}", self.order, self.step);
        let mut seen = vec![false; self.particles.len()];
        for particle in &self.particles {
            let id = particle.id as usize;
            assert!(!std::mem::replace(&mut seen[id], true), "{what}: {id}");
        }
        let in_flight = self.motions.iter().filter(|m| m.in_flight()).count();
        assert_eq!(in_flight, flow.leaving as usize, "{what}");
        assert!(flow.leaving <= case.capacity, "{what}");
        assert_eq!(flow.mismatches, 0, "{what}");
        let flying = &self.arriving[..flow.leaving as usize];
        let mut slots: Vec<u32> = flying.iter().map(|t| t.particle).collect();
        slots.sort_unstable();
        slots.dedup();
        assert_eq!(
            slots.len(),
            in_flight,
            "{what}: a transfer for each particle"
        );
        for transfer in flying {
            let slot = transfer.particle as usize;
            assert!(self.motions[slot].in_flight(), "{what}");
            assert_eq!(self.particles[slot].triangle, transfer.source, "{what}");
        }
        if self.order == Order::Scattered {
            return;
        }
        let next = (object + 1) % case.objects;
        let mut owner = vec![None; self.particles.len()];
        let mut start = self.windows[0].start;
        for (k, window) in self.windows.iter().enumerate() {
            assert_eq!(
                window.start % case.particles,
                start,
                "{what}: windows follow"
            );
            for i in 0..window.count {
                let slot = Window::slot(window.start, i, case.particles) as usize;
                assert!(
                    owner[slot].replace(k as u32).is_none(),
                    "{what}: slot {slot}"
                );
                if !self.motions[slot].in_flight() {
                    assert_eq!(self.particles[slot].triangle, k as u32, "{what}");
                } else {
                    assert_eq!(k as u32, next, "{what}: those in flight wait in front");
                    assert!(i < flow.leaving, "{what}");
                }
            }
            start = (start + window.count) % case.particles;
        }
        assert!(
            owner.iter().all(Option::is_some),
            "{what}: every slot has one"
        );
    }

    /// What particles are and carry, by id, wherever they lie.
    pub fn by_id(&self) -> Vec<(Particle, Motion, Option<Transfer>)> {
        let mut all: Vec<_> = (0..self.particles.len())
            .map(|slot| (self.particles[slot], self.motions[slot], None))
            .collect();
        for transfer in &self.arriving[..self.flow.leaving as usize] {
            let carried = Transfer {
                particle: 0,
                ..*transfer
            };
            all[transfer.particle as usize].2 = Some(carried);
        }
        all.sort_by_key(|(particle, ..)| particle.id);
        all
    }
}

//! Both engines side by side: the first difference between a device and the twins, found kernel by kernel. There is none on a device whose
//! [arithmetic](super::arithmetic) is the host's.

use std::fmt;
use std::sync::Arc;

use bytemuck::Pod;
use glam::UVec4;

use super::arrays::Arrays;
use super::paint::{Brush, Dab};
use super::setup::Setup;
use super::simulation::Simulation;
use super::state::State;
use super::step::advance::FORMS_OF_ADVANCE;
use super::surroundings::COVERED;
use super::twin;
use super::types::{Flow, Motion, Particle, Population, Transfer};
use super::work::Work;
use crate::error::Result;
use crate::gpu::{Context, Frames, GpuError};
use crate::scene::Scene;

/// The first difference.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The step, counted from 1.
    pub step: u32,
    /// The kernel after which it appeared.
    pub kernel: String,
    /// The array that differs: `trail`, `particles`, ...
    pub field: &'static str,
    /// The first element: a texel, or a particle's id.
    pub element: usize,
    /// The column that differs; `length` if one engine has fewer elements, equal to the first ones of the other.
    pub column: &'static str,
    /// The device's value.
    pub device: String,
    /// The twins' value.
    pub host: String,
    /// The number of elements that differ.
    pub count: usize,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            step,
            kernel,
            field,
            element,
            column,
            device,
            host,
            count,
        } = self;
        write!(
            f,
            "step {step}, {kernel}: {field} differ in {count} elements, first {element}, {column}: {device} on the device, {host} on the CPU"
        )
    }
}

/// The format of a word.
#[derive(Clone, Copy)]
enum As {
    Number,
    Float,
}

/// A table of data that a step changes: rows of words.
struct Field {
    name: &'static str,
    columns: &'static [(&'static str, As)],
    words: Vec<u32>,
}

impl Field {
    fn new(name: &'static str, columns: &'static [(&'static str, As)], words: Vec<u32>) -> Self {
        Self {
            name,
            columns,
            words,
        }
    }
}

const FLOATS: &[(&str, As)] = &[("value", As::Float)];
const COUNTS: &[(&str, As)] = &[("count", As::Number)];
const CELLS: &[(&str, As)] = &[("cell", As::Number)];
const WORDS: &[(&str, As)] = &[("word", As::Number)];
const CLAIMS: &[(&str, As)] = &[
    ("cell", As::Number),
    ("own cell", As::Number),
    ("texel", As::Number),
    ("alive", As::Number),
];
const TRIANGLES: &[(&str, As)] = &[("triangle", As::Number)];
const PARTICLES: &[(&str, As)] = &[
    ("triangle", As::Number),
    ("u", As::Float),
    ("v", As::Float),
    ("id", As::Number),
    ("heading_p", As::Float),
    ("heading_h", As::Float),
    ("pending", As::Float),
    ("flags", As::Number),
];
// Particles without their motions.
const WISHES: &[(&str, As)] = PARTICLES.split_at(4).0;
const MEALS: &[(&str, As)] = &[
    ("remaining", As::Number),
    ("eaten", As::Number),
    ("amount", As::Number),
    ("level", As::Number),
    ("strength", As::Float),
    ("scent", As::Float),
    ("projection", As::Float),
    ("pad0", As::Number),
];
const POPULATION: &[(&str, As)] = &[
    ("living", As::Number),
    ("births", As::Number),
    ("deaths", As::Number),
    ("refused", As::Number),
    ("born", As::Number),
    ("died", As::Number),
];
const FLOW: &[(&str, As)] = &[
    ("wanted", As::Number),
    ("leaving", As::Number),
    ("left over", As::Number),
    ("most wanted", As::Number),
    ("refused", As::Number),
    ("selected", As::Number),
    ("arrived", As::Number),
    ("crossed", As::Number),
];
const TRANSFERS: &[(&str, As)] = &[
    ("x", As::Float),
    ("y", As::Float),
    ("z", As::Float),
    ("id", As::Number),
    ("heading x", As::Float),
    ("heading y", As::Float),
    ("heading z", As::Float),
    ("source", As::Number),
    ("normal x", As::Float),
    ("normal y", As::Float),
    ("normal z", As::Float),
    ("target", As::Number),
    ("triangle", As::Number),
    ("rest", As::Float),
    ("stays", As::Number),
    ("cell", As::Number),
];

/// The state of one engine that is compared. Buffers that change roles have the names of their reading roles.
struct Everything {
    particles: Vec<Particle>,
    motions: Vec<Motion>,
    trail: Vec<f32>,
    next_trail: Vec<f32>,
    deposits: Vec<u32>,
    previous_deposits: Vec<u32>,
    meals: Vec<u32>,
    scent: Vec<f32>,
    /// Empty if no scents cross contacts.
    around: Vec<f32>,
    /// Empty before any bias is painted.
    bias: Vec<f32>,
    /// Empty before any second look is painted.
    looks: Vec<f32>,
    /// Present with several objects.
    near: Option<Near>,
    leaving: Vec<Transfer>,
    flow: Flow,
    crowd: Crowd,
    growth: Growth,
}

struct Near {
    distances: Vec<f32>,
    nearest: Vec<u32>,
    surroundings: Vec<u16>,
    across: Vec<u32>,
    across_triangles: Vec<u32>,
}

/// Empty unless there is one particle a cell.
#[derive(Default)]
struct Crowd {
    goals: Vec<u32>,
    bids: Vec<u32>,
    wishes: Vec<Particle>,
    claims: Vec<UVec4>,
}

/// Empty if the number of particles is constant.
#[derive(Default)]
struct Growth {
    population: Vec<Population>,
    occupants: Vec<u32>,
    nursery: Vec<u32>,
    births: Vec<u32>,
    parents: Vec<u32>,
    id_marks: Vec<u32>,
    ids_before: Vec<u32>,
}

impl Everything {
    fn of_device(ctx: &Context, s: &State, objects: usize) -> Result<Self, GpuError> {
        let near = || {
            Ok::<_, GpuError>(Near {
                distances: ctx.download(&s.near.distances)?,
                nearest: ctx.download(&s.near.nearest)?,
                surroundings: bytemuck::allocation::pod_collect_to_vec(
                    &ctx.download(&s.across.surroundings)?,
                ),
                across: ctx.download(&s.across.places)?,
                across_triangles: ctx.download(&s.across.triangles)?,
            })
        };
        let (meals, scent) = match &s.food {
            None => (Vec::new(), Vec::new()),
            Some(food) => (
                bytemuck::allocation::pod_collect_to_vec(&ctx.download(&food.meals)?),
                ctx.download(&food.scent)?,
            ),
        };
        let around = s.food.as_ref().and_then(|food| food.around.as_ref());
        let around = around.map(|around| ctx.download(around));
        let crowd = match &s.crowd {
            None => Crowd::default(),
            Some(crowd) => Crowd {
                goals: ctx.download(&crowd.goals)?,
                bids: ctx.download(&crowd.bids)?,
                wishes: ctx.download(&crowd.wishes)?,
                claims: ctx.download(&crowd.claims)?,
            },
        };
        let growth = match &s.growth {
            None => Growth::default(),
            Some(growth) => Growth {
                population: ctx.download(&growth.population)?,
                occupants: ctx.download(&growth.occupants)?,
                nursery: ctx.download(&growth.nursery)?,
                births: ctx.download(&growth.births)?,
                parents: ctx.download(&growth.parents)?,
                id_marks: ctx.download(&growth.id_marks)?,
                ids_before: ctx.download(&growth.ids_before)?,
            },
        };
        let bias = s.bias.as_ref().map(|bias| ctx.download(bias));
        let looks = s.looks.as_ref().map(|looks| ctx.download(looks));
        let flow = ctx.download(&s.transfers.flow)?[0];
        let leaving = (flow.leaving as usize).min(s.transfers.transfers.len());
        Ok(Self {
            particles: ctx.download(&s.particles)?,
            motions: ctx.download(&s.motions)?,
            trail: ctx.download(&s.trail.front)?,
            next_trail: ctx.download(&s.trail.back)?,
            deposits: ctx.download(&s.deposits.front)?,
            previous_deposits: ctx.download(&s.deposits.back)?,
            meals,
            scent,
            around: around.transpose()?.unwrap_or_default(),
            bias: bias.transpose()?.unwrap_or_default(),
            looks: looks.transpose()?.unwrap_or_default(),
            near: (objects > 1).then(near).transpose()?,
            leaving: ctx.download_range(&s.transfers.transfers, 0..leaving)?,
            flow,
            crowd,
            growth,
        })
    }

    fn of_host(a: &Arrays) -> Self {
        let transfers = &a.transfers;
        let leaving = (transfers.flow[0].leaving as usize).min(transfers.transfers.len());
        let several = a.poses.len() > 1;
        Self {
            particles: a.particles.clone(),
            motions: a.motions.clone(),
            trail: a.trail.clone(),
            next_trail: a.next_trail.clone(),
            deposits: a.deposits.clone(),
            previous_deposits: a.previous_deposits.clone(),
            meals: bytemuck::allocation::pod_collect_to_vec(&a.meals),
            scent: a.scent.clone(),
            around: a.around.clone(),
            bias: a.bias.clone(),
            looks: a.weights.clone(),
            near: several.then(|| Near {
                distances: a.distances.clone(),
                nearest: a.nearest.clone(),
                surroundings: a.surroundings.clone(),
                across: a.across.clone(),
                across_triangles: a.across_triangles.clone(),
            }),
            leaving: transfers.transfers[..leaving].to_vec(),
            flow: transfers.flow[0],
            crowd: Crowd {
                goals: a.goals.clone(),
                bids: a.bids.clone(),
                wishes: a.wishes.clone(),
                claims: a.claims.clone(),
            },
            growth: Growth {
                population: a.population.clone(),
                occupants: a.occupants.clone(),
                nursery: a.nursery.clone(),
                births: a.births.clone(),
                parents: a.parents.clone(),
                id_marks: a.id_marks.clone(),
                ids_before: a.ids_before.clone(),
            },
        }
    }

    /// As tables, in an order that does not depend on lists: particles by their ids. Places on other objects, for covered texels, are
    /// included only if `is_unfolded`.
    fn fields(self, kernels: &[&str], is_unfolded: bool) -> Vec<Field> {
        let mut slots: Vec<usize> = (0..self.particles.len()).collect();
        slots.sort_by_key(|&slot| self.particles[slot].id);
        let mut particles = Vec::with_capacity(8 * slots.len());
        for &slot in &slots {
            particles.extend(words(&[self.particles[slot]]));
            particles.extend(words(&[self.motions[slot]]));
        }
        let mut fields = match self.near {
            Some(near) => near.fields(is_unfolded),
            None => Vec::new(),
        };
        // Later the slots of transfers hold other particles.
        if runs(kernels, &["transfer_out", "land_claim", "land_settle"]) {
            let transfers = transfers_by_id(self.leaving, &self.particles);
            fields.push(Field::new("transfers", TRANSFERS, words(&transfers)));
        }
        fields.extend([
            Field::new("flow", FLOW, flow_words(&self.flow)),
            Field::new("particles", PARTICLES, particles),
            Field::new("deposits", COUNTS, self.deposits),
            Field::new("previous deposits", COUNTS, self.previous_deposits),
            Field::new("trail", FLOATS, words(&self.trail)),
            Field::new("next trail", FLOATS, words(&self.next_trail)),
            Field::new("meals", MEALS, self.meals),
            Field::new("scent", FLOATS, words(&self.scent)),
            Field::new("scent around", FLOATS, words(&self.around)),
            Field::new("bias", FLOATS, words(&self.bias)),
            Field::new("looks", FLOATS, words(&self.looks)),
        ]);
        fields.extend(self.crowd.fields(kernels, &slots, &self.motions));
        fields.extend(self.growth.fields(kernels, &slots, &self.particles));
        fields
    }
}

impl Near {
    fn fields(self, is_unfolded: bool) -> Vec<Field> {
        let mut fields = vec![
            Field::new("distances", FLOATS, words(&self.distances)),
            Field::new("nearest", TRIANGLES, self.nearest),
        ];
        if is_unfolded {
            // Places across are defined for covered texels only.
            let covered = |values: &[u32]| -> Vec<u32> {
                let both = values.iter().zip(&self.surroundings);
                both.map(|(&value, around)| if around & COVERED == 0 { 0 } else { value })
                    .collect()
            };
            let (across, triangles) = (covered(&self.across), covered(&self.across_triangles));
            let marks = self.surroundings.iter().map(|&word| u32::from(word));
            fields.push(Field::new("surroundings", COUNTS, marks.collect()));
            fields.push(Field::new("places across", COUNTS, across));
            fields.push(Field::new("triangles across", TRIANGLES, triangles));
        }
        fields
    }
}

impl Crowd {
    fn fields(self, kernels: &[&str], slots: &[usize], motions: &[Motion]) -> Vec<Field> {
        let mut fields = vec![
            Field::new("goals", WORDS, self.goals),
            Field::new("bids", WORDS, self.bids),
        ];
        // Only `wish` writes these, one a slot; later the slots hold other particles.
        let has_wished = runs(kernels, &["wish"]) || runs(kernels, &FORMS_OF_ADVANCE[1..]);
        if has_wished && !self.claims.is_empty() {
            // Dead particles wish nothing: what is there was another one's.
            let living = slots.iter().filter(|&&slot| !motions[slot].is_dead());
            let wishes: Vec<Particle> = living.map(|&slot| self.wishes[slot]).collect();
            fields.push(Field::new("wishes", WISHES, words(&wishes)));
            let claims: Vec<UVec4> = slots.iter().map(|&slot| self.claims[slot]).collect();
            fields.push(Field::new("claims", CLAIMS, words(&claims)));
        }
        fields
    }
}

impl Growth {
    fn fields(self, kernels: &[&str], slots: &[usize], particles: &[Particle]) -> Vec<Field> {
        let mut fields = Vec::new();
        // Each birth has its place in this list by an id. What lies behind the last one is of earlier steps.
        if runs(kernels, &["divide_list", "divide_begin"]) {
            let born = self.population[0].born as usize;
            let born = born.min(self.parents.len());
            // They are slots, whose order differs from engine to engine.
            let ids = self.parents[..born]
                .iter()
                .map(|&slot| particles[slot as usize].id);
            fields.push(Field::new("parents", CELLS, ids.collect()));
        }
        // `divide` writes one a slot; later the slots hold other particles.
        let divides = ["divide", "divide_settle", "divide_list", "divide_begin"];
        if runs(kernels, &divides) {
            let births = slots.iter().map(|&slot| self.births[slot]).collect();
            fields.push(Field::new("births", CELLS, births));
        }
        fields.extend([
            Field::new("population", POPULATION, words(&self.population)),
            Field::new("occupants", COUNTS, self.occupants),
            Field::new("nursery", WORDS, self.nursery),
            Field::new("id marks", WORDS, self.id_marks),
            Field::new("ids before", COUNTS, self.ids_before),
        ]);
        fields
    }
}

/// Is one of these kernels among those that ran?
fn runs(kernels: &[&str], some: &[&str]) -> bool {
    kernels.iter().any(|kernel| some.contains(kernel))
}

/// Transfers with the ids of their particles in place of their slots, in the order of these ids.
fn transfers_by_id(mut transfers: Vec<Transfer>, particles: &[Particle]) -> Vec<Transfer> {
    for transfer in &mut transfers {
        transfer.particle = particles[transfer.particle as usize].id;
    }
    transfers.sort_by_key(|transfer| transfer.particle);
    transfers
}

/// The counters that both engines have.
fn flow_words(f: &Flow) -> Vec<u32> {
    let in_step = [f.wanted, f.leaving];
    let so_far = [
        f.left_over,
        f.most_wanted,
        f.refused,
        f.selected,
        f.arrived,
        f.crossed,
    ];
    [&in_step[..], &so_far].concat()
}

fn words<T: Pod>(elements: &[T]) -> Vec<u32> {
    bytemuck::allocation::pod_collect_to_vec(elements)
}

/// The first field in which two engines differ: in an element, or in their number.
fn compare(device: Vec<Field>, host: &[Field], step: u32, kernel: &str) -> Option<Difference> {
    assert_eq!(device.len(), host.len(), "both have all fields");
    device.iter().zip(host).find_map(|(device, host)| {
        let row = device.columns.len();
        let [ours, theirs] = [device, host].map(|field| field.words.len() / row);
        let rows = device.words.chunks(row).zip(host.words.chunks(row));
        let mut differing = rows.enumerate().filter(|(_, (a, b))| a != b);
        let first = differing.next();
        let more = ours.abs_diff(theirs);
        if first.is_none() && more == 0 {
            return None;
        }
        let count = usize::from(first.is_some()) + differing.count() + more;
        let (element, column, values) = match first {
            Some((element, (a, b))) => {
                let column = a.iter().zip(b).position(|(a, b)| a != b)?;
                let (name, shown_as) = device.columns[column];
                let shown = |word: u32| match shown_as {
                    As::Number => word.to_string(),
                    As::Float => format!("{:e} ({word:08x})", f32::from_bits(word)),
                };
                (element, name, [a, b].map(|row| shown(row[column])))
            }
            None => (
                ours.min(theirs),
                "length",
                [ours, theirs].map(|rows| rows.to_string()),
            ),
        };
        let [on_device, on_host] = values;
        Some(Difference {
            step,
            kernel: kernel.to_owned(),
            field: device.name,
            element,
            column,
            device: on_device,
            host: on_host,
            count,
        })
    })
}

/// The kernel that a brush runs.
fn kernel_of(brush: Brush) -> &'static str {
    match brush {
        Brush::Particles { .. } => "teleport",
        _ => "paint",
    }
}

/// Runs a scene on both engines, kernel by kernel, up to the first difference. This is slow, because everything is compared after each
/// kernel. `dabs` are painted in their order before step `painted_in`, which is 2 or later.
///
/// # Errors
/// When the device fails or has too little memory, or a dab is out of range.
pub fn first_difference(
    ctx: &Arc<Context>,
    scene: &Scene,
    setup: &Setup,
    steps: u32,
    painted_in: u32,
    dabs: &[Dab],
) -> Result<Option<Difference>> {
    let objects = setup.poses.len();
    let mut device = Simulation::from_setup(ctx, scene, setup.clone())?;
    let mut host = twin::Simulation::new(setup.clone(), scene.settings.clone());
    let mut frames = Frames::new(ctx, 1)?;
    // `distance` marks places on the device, and the twins mark all of them in `unfold`.
    let mut is_unfolded = true;
    for step in 1..=steps {
        for dab in dabs.iter().filter(|_| step == painted_in) {
            frames.run(|rec| device.paint(rec, dab))??;
            host.paint(dab)?;
            let found =
                Everything::of_device(ctx, device.state(), objects)?.fields(&[], is_unfolded);
            let expected = Everything::of_host(host.arrays()).fields(&[], is_unfolded);
            let difference = compare(found, &expected, step, kernel_of(dab.brush));
            if difference.is_some() {
                return Ok(difference);
            }
        }
        let (own, other) = (device.next_step(), host.next_step());
        let works = own.works().iter().zip(other.works()).enumerate();
        for (k, (own_work, other_work)) in works {
            frames.run(|rec| device.record_work(rec, &**own_work))?;
            host.run_work(&**other_work);
            let kernels = own_work.kernels();
            is_unfolded &= !kernels.iter().any(|kernel| kernel.starts_with("distance"));
            is_unfolded |= kernels.contains(&"unfold");
            let next = own.works().get(k + 1);
            if kernels.is_empty() || next.is_some_and(|next| goes_on(&**next)) {
                continue;
            }
            let found =
                Everything::of_device(ctx, device.state(), objects)?.fields(&kernels, is_unfolded);
            let expected = Everything::of_host(host.arrays()).fields(&kernels, is_unfolded);
            let difference = compare(found, &expected, step, &kernels.join(", "));
            if difference.is_some() {
                return Ok(difference);
            }
        }
        device.end_step();
    }
    Ok(None)
}

/// Does a work belong to the kernel before it? Particles that `advance` lists advance in its other forms, and the twin of the first form
/// advances all.
fn goes_on(work: &dyn Work) -> bool {
    let kernels = work.kernels();
    kernels
        .iter()
        .any(|kernel| FORMS_OF_ADVANCE[1..].contains(kernel))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::scene::settings::{Model, Settings};

    /// Would catch: a kernel of cells or populations whose results are compared nowhere, so that both engines could differ in them.
    #[test]
    fn what_kernels_of_cells_and_populations_write_is_compared() {
        let mut settings = Settings::default();
        settings.objects[0].mesh = "builtin:torus?major=24&minor=16".to_owned();
        settings.atlas.size = 128;
        settings.physarum.model = Model::Jones;
        settings.physarum.speed = 0.02;
        settings.physarum.sensor_offset = 0.15;
        settings.particles.count = 2500;
        settings.population.frequency = 1;
        settings.population.division_most = 81;
        settings.population.capacity = 4000;
        let scene = Scene::from_settings("test".to_owned(), settings, "".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let mut host = twin::Simulation::new(setup, scene.settings.clone());
        let mut changed = BTreeSet::new();
        for _ in 0..4 {
            for work in host.next_step().works() {
                let kernels = work.kernels();
                let fields = |host: &twin::Simulation| {
                    Everything::of_host(host.arrays()).fields(&kernels, true)
                };
                let before = fields(&host);
                host.run_work(&**work);
                let after = fields(&host);
                let both = before.iter().zip(&after);
                let differing = both.filter(|(before, after)| before.words != after.words);
                changed.extend(differing.map(|(field, _)| (kernels.join(", "), field.name)));
            }
        }
        for (kernel, field) in [
            ("count_cells", "occupants"),
            ("divide", "births"),
            ("divide", "nursery"),
            ("divide_settle", "births"),
            ("divide_settle", "id marks"),
            ("divide_number", "ids before"),
            ("divide_number", "population"),
            ("divide_list", "parents"),
            ("divide_begin", "particles"),
            ("wish", "wishes"),
            ("wish", "claims"),
            ("wish", "goals"),
            ("wish", "bids"),
            ("arrive", "flow"),
            ("arrive", "particles"),
        ] {
            let pair = (kernel.to_owned(), field);
            assert!(changed.contains(&pair), "{pair:?} of {changed:?}");
        }
    }

    /// Would catch: elements that only one engine has, and that are compared with nothing.
    #[test]
    fn lists_of_other_lengths_differ() {
        let field = |words: &[u32]| Field {
            name: "births",
            columns: CELLS,
            words: words.to_vec(),
        };
        let compared = |device, host| compare(vec![field(device)], &[field(host)], 3, "divide");
        assert_eq!(compared(&[1, 2, 3], &[1, 2, 3]), None);
        let shorter = compared(&[1, 2], &[1, 2, 3]).unwrap();
        assert_eq!((shorter.element, shorter.column), (2, "length"));
        assert_eq!((shorter.count, shorter.device.as_str()), (1, "2"));
        let other = compared(&[1, 5, 3], &[1, 2]).unwrap();
        assert_eq!((other.element, other.column), (1, "cell"));
        assert_eq!((other.count, other.host.as_str()), (2, "2"));
    }
}

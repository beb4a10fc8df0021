//! Uniform places, headings in the surface, and rules of objects.

use super::*;
use crate::mesh::Mesh;

fn surface(meshes: &[(&str, f32)]) -> Surface {
    let meshes: Vec<(Mesh, f32)> = meshes
        .iter()
        .map(|&(name, scale)| (Mesh::builtin(name).unwrap(), scale))
        .collect();
    let objects: Vec<(&Mesh, f32)> = meshes.iter().map(|(mesh, scale)| (mesh, *scale)).collect();
    Surface::build(&objects)
}

/// All particles by one rule, with its default headings.
fn begin(
    surface: &Surface,
    place: StartPlace,
    count: u32,
    seed: u32,
) -> (Vec<Particle>, Vec<Motion>) {
    start(surface, &starts(place, StartHeading::Auto), count, seed)
}

fn starts(place: StartPlace, heading: StartHeading) -> Starts {
    Starts {
        scene: StartRule {
            place,
            object: None,
            heading,
        },
        own: Vec::new(),
        shares: Vec::new(),
    }
}

fn position(surface: &Surface, particle: &Particle) -> Vec3 {
    let corners = surface.corners[particle.triangle as usize];
    let [a, b, c] = corners.map(|i| surface.positions[i as usize]);
    a + particle.u * (b - a) + particle.v * (c - a)
}

/// Pearson's statistic, which must lie within four standard deviations of its mean: a fair draw fails once in some
/// ten thousand seeds, and the seeds here are fixed.
fn assert_fair(what: &str, observed: &[u32], expected: &[f64]) {
    let statistic: f64 = observed
        .iter()
        .zip(expected)
        .map(|(&o, &e)| (f64::from(o) - e).powi(2) / e)
        .sum();
    let freedom = (observed.len() - 1) as f64;
    let off = (statistic - freedom) / (2.0 * freedom).sqrt();
    assert!(
        off.abs() < 4.0,
        "{what}: chi-square {statistic} for {freedom}, off by {off}"
    );
}

#[test]
fn particles_are_uniform_by_area() {
    // Triangles of a torus differ by their place, those of the second object by a factor of 100 more.
    let surface = surface(&[("torus?major=24&minor=16", 1.0), ("cube", 0.1)]);
    let count = 400_000;
    for seed in [1, 2, 3] {
        let (particles, _) = begin(&surface, StartPlace::Everywhere, count, seed);
        let whole: f64 = AreaTable::new(&surface, None).up_to[surface.corners.len() - 1];
        let expected: Vec<f64> = surface
            .triangles
            .iter()
            .map(|t| 0.5 * f64::from(t.ab * t.ch) / whole * f64::from(count))
            .collect();
        let mut by_triangle = vec![0; expected.len()];
        // The four triangles that the middles of the edges cut a triangle into.
        let mut by_part = [0; 4];
        for (id, p) in particles.iter().enumerate() {
            assert!(p.u >= 0.0 && p.v >= 0.0 && p.u + p.v <= 1.0 && p.id == id as u32);
            by_triangle[p.triangle as usize] += 1;
            let part = [p.u + p.v < 0.5, p.u > 0.5, p.v > 0.5];
            by_part[part.iter().position(|&inside| inside).unwrap_or(3)] += 1;
        }
        assert_fair("triangles", &by_triangle, &expected);
        assert_fair("parts", &by_part, &[f64::from(count) / 4.0; 4]);
    }
}

#[test]
fn headings_are_uniform_wherever_a_particle_begins() {
    let surface = surface(&[("icosphere?subdivisions=1", 1.0)]);
    let count = 200_000;
    let (particles, motions) = begin(&surface, StartPlace::Everywhere, count, 4);
    let mut sectors = [0; 64];
    let mut sector_and_part = [0; 32];
    for (p, m) in particles.iter().zip(&motions) {
        assert!((m.heading_p.hypot(m.heading_h) - 1.0).abs() < 2e-7);
        assert_eq!((m.pending, m.flags), (0.0, 0));
        let turn = f64::from(m.heading_h).atan2(f64::from(m.heading_p)) / TAU + 0.5;
        sectors[(64.0 * turn) as usize % 64] += 1;
        let part = [p.u + p.v < 0.5, p.u > 0.5, p.v > 0.5];
        let part = part.iter().position(|&inside| inside).unwrap_or(3);
        sector_and_part[4 * ((8.0 * turn) as usize % 8) + part] += 1;
    }
    assert_fair("sectors", &sectors, &[f64::from(count) / 64.0; 64]);
    assert_fair(
        "sectors by part",
        &sector_and_part,
        &[f64::from(count) / 32.0; 32],
    );
}

#[test]
fn a_seed_and_an_id_decide_alone() {
    let surface = surface(&[("torus?major=24&minor=16", 1.0)]);
    let centre = SurfacePoint {
        triangle: 5,
        u: 0.2,
        v: 0.3,
    };
    let ring = StartPlace::Ring {
        centre,
        radius: 0.7,
    };
    for place in [
        StartPlace::Everywhere,
        StartPlace::Point(centre),
        ring.clone(),
    ] {
        let with = |threads, count, seed| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap()
                .install(|| begin(&surface, place.clone(), count, seed))
        };
        let (particles, motions) = with(1, 5000, 9);
        let (more_particles, more_motions) = with(3, 7001, 9);
        assert_eq!(particles, more_particles[..5000]);
        assert_eq!(motions, more_motions[..5000]);
        let (_, others) = with(2, 5000, 10);
        let same = motions.iter().zip(&others).filter(|(a, b)| a == b).count();
        assert!(same < 5, "{same} of 5000 are the same with another seed");
    }
    assert_eq!(begin(&surface, ring, 0, 9).0.len(), 0);
}

#[test]
fn a_ring_lies_round_its_centre_and_looks_at_it() {
    let surface = surface(&[("plane?columns=9&rows=7", 1.0)]);
    let middle = Vec3::new(0.05, 0.0, -0.1);
    let centre = nearest_point(&surface, &[middle], None);
    let (particles, motions) = begin(
        &surface,
        StartPlace::Ring {
            centre,
            radius: 0.6,
        },
        3000,
        2,
    );
    let mut sum = Vec3::ZERO;
    for (p, m) in particles.iter().zip(&motions) {
        let out = position(&surface, p) - middle;
        assert!((out.length() - 0.6).abs() < 1e-5, "{}", out.length());
        let frame = crate::mesh::walk::Frame::of(&surface, p.triangle);
        let heading = f64::from(m.heading_p) * frame.p + f64::from(m.heading_h) * frame.h;
        assert!(heading.dot(out.as_dvec3()) < -0.6 + 1e-4);
        sum += out;
    }
    assert!(sum.length() < 0.05 * 3000.0 * 0.6, "lopsided: {sum}");
    let (particles, _) = begin(&surface, StartPlace::Point(centre), 10, 2);
    assert!(
        particles
            .iter()
            .all(|p| position(&surface, p).distance(middle) < 1e-6)
    );
}

#[test]
fn the_nearest_point_is_nearest() {
    let surface = surface(&[("icosphere?subdivisions=2", 1.0), ("cube", 0.5)]);
    let (samples, _) = begin(&surface, StartPlace::Everywhere, 20_000, 3);
    for k in 0..50 {
        let place = |object| {
            let words = random(6, k, object, Purpose::Start);
            Vec3::from_array([0, 1, 2].map(|axis| 4.0 * unit(words[axis]) - 2.0))
        };
        let places = [place(0), place(1)];
        let distance = |p: &Particle| {
            let object = surface.triangles[p.triangle as usize].object;
            position(&surface, p).distance(places[object as usize])
        };
        let found = distance(&particle(0, nearest_point(&surface, &places, None)));
        let sampled = samples.iter().map(distance).fold(f32::INFINITY, f32::min);
        assert!(
            found <= sampled + 1e-6 && found > sampled - 0.1,
            "{found}, {sampled}"
        );
    }
}

#[test]
fn every_share_of_the_area_has_a_triangle() {
    let surface = surface(&[("cube", 1.0)]);
    let table = AreaTable::new(&surface, None);
    assert_eq!(table.triangle_at(0.0), 0);
    assert_eq!(table.triangle_at(1.001 / 12.0), 1);
    assert_eq!(table.triangle_at(share([u32::MAX; 4])), 11);
    assert_eq!(share([0; 4]), 0.0);
    assert_eq!(share([1 << 31, 0, 0, 0]), 0.5);
    assert!(share([0, 8, 0, 0]) > 0.0 && share([u32::MAX; 4]) < 1.0);
}

/// The heading in the object's space.
fn heading(surface: &Surface, particle: &Particle, motion: &Motion) -> DVec3 {
    let frame = Frame::of(surface, particle.triangle);
    let (p, h) = (f64::from(motion.heading_p), f64::from(motion.heading_h));
    assert!((p.hypot(h) - 1.0).abs() < 3e-7, "{p}, {h}");
    let heading = p * frame.p + h * frame.h;
    assert!(
        heading.dot(frame.p.cross(frame.h)).abs() < 1e-6,
        "tangential"
    );
    heading
}

#[test]
fn a_disc_is_filled_evenly_and_no_farther_than_its_radius() {
    let surface = surface(&[("plane?columns=9&rows=7", 1.0)]);
    let middle = Vec3::new(0.05, 0.0, -0.1);
    let centre = nearest_point(&surface, &[middle], None);
    let radius = 0.6;
    let disc = StartPlace::Disc { centre, radius };
    let count = 40_000;
    let (particles, motions) = start(
        &surface,
        &starts(disc, StartHeading::Radial(vec![])),
        count,
        3,
    );
    // Rings of equal area, in eight sectors each.
    let mut parts = [0; 64];
    for (p, m) in particles.iter().zip(&motions) {
        let out = (position(&surface, p) - middle).as_dvec3();
        let share = (out.length() / radius).powi(2);
        assert!(share < 1.0 + 1e-5, "{share}");
        let turn = (out.z.atan2(out.x) / TAU + 0.5).min(0.999_999);
        parts[8 * ((8.0 * share) as usize).min(7) + (8.0 * turn) as usize] += 1;
        if out.length() > 1e-3 {
            assert!(heading(&surface, p, m).dot(out.normalize()) > 0.999);
        }
    }
    assert_fair("disc", &parts, &[f64::from(count) / 64.0; 64]);
}

#[test]
fn headings_are_laid_onto_the_surface() {
    let surface = surface(&[("icosphere?subdivisions=3", 1.0), ("cube", 0.5)]);
    let up = DVec3::new(0.3, 1.0, -0.2);
    let everywhere = |heading| start(&surface, &starts(StartPlace::Everywhere, heading), 3000, 8);
    let (particles, motions) = everywhere(StartHeading::Aligned(vec![up, -up]));
    for (p, m) in particles.iter().zip(&motions) {
        let object = surface.triangles[p.triangle as usize].object;
        let up = if object == 0 { up } else { -up };
        let frame = Frame::of(&surface, p.triangle);
        let normal = frame.p.cross(frame.h);
        let laid = (up - up.dot(normal) * normal).normalize();
        assert!(heading(&surface, p, m).dot(laid) > 1.0 - 1e-5);
    }
    let centres = vec![DVec3::new(0.0, 2.0, 0.0); 2];
    let radial = everywhere(StartHeading::Radial(centres.clone()));
    let inward = everywhere(StartHeading::Inward(centres.clone()));
    assert_eq!(radial.0, inward.0);
    for (i, p) in radial.0.iter().enumerate() {
        let out = heading(&surface, p, &radial.1[i]);
        assert!(out.dot(heading(&surface, p, &inward.1[i])) < -1.0 + 1e-5);
        assert!(out.dot(position(&surface, p).as_dvec3() - centres[0]) > -1e-6);
    }
    // On the cube's top the direction is upright: headings are random.
    let cube = self::surface(&[("cube", 1.0)]);
    let upright = starts(
        StartPlace::Everywhere,
        StartHeading::Aligned(vec![DVec3::Y]),
    );
    let (particles, motions) = start(&cube, &upright, 3000, 8);
    let on_top = particles.iter().zip(&motions);
    let on_top = on_top.filter(|(p, _)| {
        Frame::of(&cube, p.triangle)
            .p
            .cross(Frame::of(&cube, p.triangle).h)
            .y
            > 0.9
    });
    let mean: DVec3 = on_top.map(|(p, m)| heading(&cube, p, m)).sum();
    assert!(mean.length() < 80.0, "{mean}");
}

#[test]
fn an_object_can_begin_otherwise_than_the_others() {
    let surface = surface(&[
        ("icosphere?subdivisions=2", 1.0),
        ("cube", 0.8),
        ("cube", 0.6),
    ]);
    let places = vec![Vec3::new(0.0, 0.0, 5.0); 3];
    let centre = nearest_point(&surface, &places, Some(1));
    assert_eq!(surface.triangles[centre.triangle as usize].object, 1);
    let everywhere = starts(StartPlace::Everywhere, StartHeading::Auto);
    let mut some = everywhere.clone();
    let disc = StartRule {
        place: StartPlace::Disc {
            centre,
            radius: 0.2,
        },
        object: Some(1),
        heading: StartHeading::Auto,
    };
    some.own = vec![None, Some(disc), None];
    let count = 20_000;
    let (before, _) = start(&surface, &everywhere, count, 5);
    let (after, _) = start(&surface, &some, count, 5);
    let object = |p: &Particle| surface.triangles[p.triangle as usize].object;
    let middle = position(&surface, &particle(0, centre));
    let mut sum = Vec3::ZERO;
    let mut moved = 0;
    for (a, b) in before.iter().zip(&after) {
        assert_eq!(object(a), object(b), "each object keeps its share");
        if object(a) == 1 {
            let out = position(&surface, b) - middle;
            assert!(out.length() < 0.2 + 1e-5);
            (sum, moved) = (sum + out, moved + 1);
        } else {
            assert_eq!(a, b, "the others stay");
        }
    }
    assert!(
        moved > 1000 && sum.length() < 0.01 * moved as f32,
        "{moved} {sum}"
    );
    // All on one object, uniformly.
    let mut only = everywhere;
    only.scene.object = Some(2);
    let (particles, _) = start(&surface, &only, 60_000, 5);
    let (first, end) = surface.objects[2].triangles;
    let mut by_triangle = vec![0; (end - first) as usize];
    for p in &particles {
        by_triangle[(p.triangle - first) as usize] += 1;
    }
    assert_fair("one object", &by_triangle, &[5000.0; 12]);
}

/// Would catch: a share that changes where particles begin on an object, that an own start lacks, or that lets some begin where it is 0.
#[test]
fn objects_have_their_shares_of_the_particles() {
    let surface = surface(&[("cube", 1.0), ("cube", 1.0), ("cube", 2.0), ("cube", 1.0)]);
    let mut starts = starts(StartPlace::Everywhere, StartHeading::Auto);
    starts.shares = vec![3.0, 1.0, 0.5, 0.0];
    let whole = 3.0 + 1.0 + 4.0 * 0.5;
    let count = 120_000;
    let by_triangle = |starts: &Starts| {
        let (particles, _) = start(&surface, starts, count, 11);
        let mut by_triangle = [0; 4 * 12];
        for particle in particles {
            by_triangle[particle.triangle as usize] += 1;
        }
        by_triangle
    };
    let found = by_triangle(&starts);
    let of_triangle = |share: f64| f64::from(count) * share / whole / 12.0;
    let expected = [
        [of_triangle(3.0); 12],
        [of_triangle(1.0); 12],
        [of_triangle(2.0); 12],
    ];
    assert_fair("shares", &found[..36], expected.as_flattened());
    assert_eq!(found[36..], [0; 12]);
    // With a start of its own an object keeps its share.
    let places = vec![Vec3::new(0.3, 5.0, 0.2); 4];
    let centre = nearest_point(&surface, &places, Some(0));
    let point = StartRule {
        place: StartPlace::Point(centre),
        object: Some(0),
        heading: StartHeading::Auto,
    };
    starts.own = vec![Some(point), None, None, None];
    let with_own = by_triangle(&starts);
    let of_first: u32 = found[..12].iter().sum();
    assert_eq!(with_own[centre.triangle as usize], of_first);
    assert_eq!(with_own[12..], found[12..]);
}

/// Would catch: walks between the long sides of a needle that take hours for all particles, and a start that does not stop when asked to.
#[test]
fn a_start_on_a_needle_ends_and_stops_when_asked_to() {
    let corners = vec![DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1e-6, 0.0)];
    let mesh = Mesh::from_triangles("needle", corners, vec![[0, 1, 2]]).unwrap();
    let surface = Surface::build(&[(&mesh, 1.0)]);
    let centre = nearest_point(&surface, &[Vec3::new(0.5, 0.0, 0.0)], None);
    let radius = 0.4;
    let (particles, _) = begin(&surface, StartPlace::Ring { centre, radius }, 200, 2);
    assert!(particles.iter().all(|p| p.u + p.v <= 1.0));
    let starts = starts(StartPlace::Ring { centre, radius }, StartHeading::Auto);
    let cancelled = std::sync::atomic::AtomicBool::new(true);
    let control = Control {
        cancelled: Some(&cancelled),
        ..Control::default()
    };
    let all = Lots::new(&surface, &starts, 2).all(1_000_000, &control);
    assert!(matches!(all, Err(AtlasError::Cancelled)));
}

//! Alterations of one kind each, and their results.

use serde_json::json;

use super::parts::{
    BIAS, DEPOSITS, DISTANCE_POSES, FLOW, FOODS, KEPT_PAIRS, LAST_POSES, LOOKS, MOTIONS, PARTICLES,
    PULSES, Parts, TRAIL, WINDOWS,
};

/// What is altered, and words of the reason for which it is refused; none where steps continue.
pub type Alteration = (&'static str, fn(&mut Parts), Option<&'static str>);

pub const ALTERATIONS: &[Alteration] = &[
    ("nothing", |_| (), None),
    // The header.
    (
        "a negative step",
        |p| p.header["step"] = json!(-1),
        Some("its header is damaged"),
    ),
    (
        "the last step of all",
        |p| p.header["step"] = json!(u64::MAX),
        Some("is the last"),
    ),
    ("another step", |p| p.header["step"] = json!(17), None),
    (
        "more particles than bytes",
        |p| p.header["particles"] = json!(u64::MAX / 16 + 2),
        Some("cut short"),
    ),
    (
        "fewer kept pairs than there are",
        |p| p.header["kept_pairs"] = json!(0),
        Some("bytes too many"),
    ),
    (
        "a fed particle counts as none",
        |p| p.header["fed_deposit"] = json!(0),
        Some("deposits on owned and gutter texels"),
    ),
    (
        "a fed particle counts as all",
        |p| p.header["fed_deposit"] = json!(u32::MAX),
        Some("deposits on owned and gutter texels"),
    ),
    (
        "another layout",
        |p| p.header["layout"] = json!(1),
        Some("other meshes or scales"),
    ),
    (
        "a scene that is none",
        |p| p.header["scene"] = json!("[particles"),
        Some("a scene that this version cannot read"),
    ),
    // The movement.
    (
        "the largest time step",
        |p| p.movement("dt", f64::MAX),
        Some("or they are damaged"),
    ),
    (
        "a time step that reaches the end of time in these steps",
        |p| p.movement("dt", 1e14),
        Some("or they are damaged"),
    ),
    (
        "time backwards",
        |p| p.movement("dt", -1.0),
        Some("or they are damaged"),
    ),
    ("a late time", |p| p.movement("time", 9e13), None),
    (
        "no time",
        |p| p.movement("time", f64::NAN),
        Some("or they are damaged"),
    ),
    (
        "a movement that begins after the last step",
        |p| p.header["movement"]["step"] = json!(u64::MAX),
        Some("or they are damaged"),
    ),
    (
        "a pose from outside that is not rigid",
        |p| p.header["movement"]["outside"][1] = json!(vec![0_u64; 12]),
        Some("or they are damaged"),
    ),
    (
        "poses from outside for more objects",
        |p| p.header["movement"]["outside"] = json!([null, null, null, null]),
        Some("the poses of 4 objects"),
    ),
    // Particles.
    (
        "a triangle that does not exist",
        |p| p.set(PARTICLES, 7, 0, u32::MAX),
        Some("does not exist"),
    ),
    (
        "infinite weights",
        |p| p.set(PARTICLES, 7, 1, f32::INFINITY.to_bits()),
        Some("outside its triangle"),
    ),
    (
        "an id twice",
        |p| p.set(PARTICLES, 7, 3, u32::MAX),
        Some("are lost and 1 doubled"),
    ),
    (
        "no heading",
        |p| p.fill(MOTIONS, 0..2, 0),
        Some("the heading of particle"),
    ),
    (
        "a heading of two",
        |p| p.fill(MOTIONS, 0..2, 2.0_f32.to_bits()),
        Some("the heading of particle"),
    ),
    (
        "a walk without an end",
        |p| p.set(MOTIONS, 3, 2, f32::INFINITY.to_bits()),
        Some("has inf pending"),
    ),
    (
        "the longest walk",
        |p| p.set(MOTIONS, 3, 2, 3e38_f32.to_bits()),
        Some("at most 3000000000 is possible"),
    ),
    (
        "a very long walk",
        |p| {
            for i in 0..900 {
                p.set(MOTIONS, i, 2, 2e9_f32.to_bits());
            }
        },
        None,
    ),
    (
        "all are fed for long",
        |p| {
            for i in 0..900 {
                p.lists[MOTIONS][4 * i + 3] |= 0xffff_0000;
            }
        },
        Some("deposits on owned and gutter texels"),
    ),
    // Fields.
    (
        "the densest trail",
        |p| p.fill_all(TRAIL, 3e38),
        Some("the trail is"),
    ),
    (
        "a trail that grows too dense by rounding",
        |p| p.fill_all(TRAIL, 1e30),
        Some("a run can continue from at most"),
    ),
    ("a very dense trail", |p| p.fill_all(TRAIL, 9e28), None),
    (
        "a trail of denormal numbers",
        |p| p.fill_all(TRAIL, 1e-44),
        None,
    ),
    (
        "a negative trail",
        |p| p.set(TRAIL, 50, 0, (-1e-3_f32).to_bits()),
        Some("the trail is -0.001"),
    ),
    (
        "more deposits than particles",
        |p| *p.lists[DEPOSITS].iter_mut().find(|n| **n > 0).unwrap() = u32::MAX,
        Some("deposits on owned and gutter texels"),
    ),
    (
        "deposits where no triangle lies",
        |p| *p.lists[DEPOSITS].last_mut().unwrap() = u32::MAX,
        None,
    ),
    (
        "the strongest areas",
        |p| p.fill_all(BIAS, 3e38),
        Some("the bias is 3"),
    ),
    (
        "infinite areas",
        |p| p.fill_all(BIAS, f32::NEG_INFINITY),
        Some("the bias is -inf"),
    ),
    ("all is a wall", |p| p.fill_all(BIAS, -1e9), None),
    ("strong areas", |p| p.fill_all(BIAS, 1e6), None),
    (
        "more food than there was",
        |p| p.lists[FOODS].fill(u32::MAX),
        None,
    ),
    (
        "another number of foods",
        |p| {
            p.lists[FOODS].push(1);
            p.count();
        },
        Some("has 3 foods and markers"),
    ),
    (
        "a short trail, and deposits as short",
        |p| {
            p.lists[TRAIL].pop();
            p.lists[DEPOSITS].pop();
            p.count();
        },
        Some("texels of trail, not"),
    ),
    // Transfers.
    (
        "what earlier versions counted within a step",
        |p| {
            p.fill(FLOW, 0..6, 600);
            p.fill(FLOW, 7..9, u32::MAX);
        },
        None,
    ),
    (
        "all counters full",
        |p| p.fill(FLOW, 0..14, u32::MAX),
        Some("were not equally many"),
    ),
    (
        "counters that count no further",
        |p| p.fill(FLOW, 9..14, u32::MAX),
        None,
    ),
    (
        "windows of no particles",
        |p| p.lists[WINDOWS].fill(0),
        Some("the windows have 0 slots"),
    ),
    // Earlier versions had particles in flight.
    ("a transfer", |p| p.fly(0..3, 0.5), None),
    (
        "a transfer from far away",
        |p| p.fly(0..3, 3e38),
        Some("is in flight at"),
    ),
    (
        "a transfer from a long way off",
        |p| p.fly(0..3, 9e14),
        None,
    ),
    (
        "a transfer that walks on and on",
        |p| p.fly(13..14, 3e38),
        Some("to walk"),
    ),
    (
        "a transfer that walks back",
        |p| p.fly(13..14, -1.0),
        Some("to walk"),
    ),
    (
        "a transfer without a plane",
        |p| p.fly(8..11, 0.0),
        Some("from a plane with normal"),
    ),
    // Poses.
    (
        "a last pose far away",
        |p| p.set(LAST_POSES, 1, 3, 1e30_f32.to_bits()),
        Some("or they are damaged"),
    ),
    (
        "a last pose a long way off",
        |p| p.set(LAST_POSES, 1, 3, 9e14_f32.to_bits()),
        None,
    ),
    (
        "distances taken with a pose that is none",
        |p| p.fill(DISTANCE_POSES, 0..12, 0),
        Some("or these are damaged"),
    ),
    (
        "distances taken a long way off",
        |p| p.set(DISTANCE_POSES, 1, 3, 9e14_f32.to_bits()),
        None,
    ),
    (
        "a kept pair that is not rigid",
        |p| p.fill(KEPT_PAIRS, 0..12, 1e30_f32.to_bits()),
        Some("or these are damaged"),
    ),
    (
        "a kept pair of an object that there is not",
        |p| p.set(KEPT_PAIRS, 0, 13, 3),
        Some("or these are damaged"),
    ),
    // Pulses: place, speed, width, reach, strength, nothing, first step.
    (
        "a pulse far away",
        |p| p.set(PULSES, 0, 1, 3e38_f32.to_bits()),
        Some("its pulse 0 is damaged"),
    ),
    (
        "a pulse a long way off",
        |p| p.set(PULSES, 0, 1, 9e14_f32.to_bits()),
        None,
    ),
    (
        "a pulse without an end",
        |p| p.set(PULSES, 0, 3, f32::INFINITY.to_bits()),
        Some("its pulse 0 is damaged"),
    ),
    (
        "a very fast pulse",
        |p| p.fill(PULSES, 3..6, 1e6_f32.to_bits()),
        None,
    ),
    (
        "a pulse that drives too hard",
        |p| p.set(PULSES, 0, 6, 1.5_f32.to_bits()),
        Some("its pulse 0 is damaged"),
    ),
    (
        "a pulse that begins later",
        |p| p.set(PULSES, 0, 8, 16),
        Some("its pulse 0 is damaged"),
    ),
    (
        "a look that is more than the second",
        |p| p.set(LOOKS, 50, 0, 1.5_f32.to_bits()),
        Some("the weight of the second look is 1.5"),
    ),
    (
        "the second look everywhere",
        |p| p.fill_all(LOOKS, 1.0),
        None,
    ),
    (
        "nine pulses",
        |p| {
            p.lists[PULSES] = p.lists[PULSES].repeat(9);
            p.count();
        },
        Some("it has 9 pulses, and 8 are possible"),
    ),
];

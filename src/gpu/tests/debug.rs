//! `debug_value` in kernels and draws.

use super::selftest::*;
use super::*;

fn debug_values(ctx: &Arc<Context>, counts: &[u32]) -> DebugEntries {
    let kernel = Pipeline::<DebugValues>::new(ctx, &()).unwrap();
    let mut frames = Frames::new(ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    for &count in counts {
        rec.dispatch(&kernel, Threads(count), (), DebugValuesParams { count });
    }
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
    ctx.debug_entries()
}

#[test]
fn values_come_with_kernel_invocation_and_tag() {
    let Some(ctx) = context() else { return };
    let read = debug_values(&ctx, &[2, 1]);
    let entry = |invocation, tag, value| DebugEntry {
        kernel: "debug_values".to_owned(),
        invocation,
        tag,
        value,
    };
    let first = |i: u32| {
        [
            entry(i, 7, DebugValue::Uint(i * 2)),
            entry(i, 8, DebugValue::Int(-(i as i32))),
            entry(i, 9, DebugValue::Float(i as f32 + 0.5)),
        ]
    };
    assert_eq!(read.entries, [first(0), first(1), first(0)].concat());
    assert_eq!(read.overflow, 0);
    assert!(
        read.to_string().starts_with(
            "debug_values[0] 7: 0\ndebug_values[0] 8: +0\ndebug_values[0] 9: 0.5\ndebug_values[1] 7: 2\ndebug_values[1] 8: -1\n"
        )
    );
    assert_eq!(
        ctx.debug_entries(),
        DebugEntries::default(),
        "each value is returned once"
    );
    assert_silent(&ctx);
}

#[test]
fn a_full_list_drops_and_counts() {
    let options = ContextOptions {
        validation: true,
        debug_capacity: 100,
        ..ContextOptions::default()
    };
    let Some(ctx) = context_with(options) else {
        return;
    };
    let read = debug_values(&ctx, &[1000]);
    assert_eq!((read.entries.len(), read.overflow), (100, 2900));
    assert!(read.to_string().contains("2900 more values did not fit"));
    assert!(
        read.entries
            .iter()
            .all(|e| e.invocation < 1000 && (7..=9).contains(&e.tag))
    );
    assert_silent(&ctx);
}

#[test]
fn debug_values_of_draws_carry_the_name_of_their_pass() {
    let Some(ctx) = context() else { return };
    let options = RasterOptions {
        depth: false,
        topology: Topology::Points,
        ..RasterOptions::default()
    };
    let mark = match RasterPipeline::<MarkDraw>::new(&ctx, &(), options) {
        Err(GpuError::Unsupported { .. }) => return,
        other => other.unwrap(),
    };
    let color = Image::new(&ctx, "color", [8, 8], Format::Rgba8Srgb, 1).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    let targets = Targets {
        color: &color,
        resolve: None,
        depth: None,
        depth_test: DepthTest::Greatest,
        clear: Some([0.0; 4]),
    };
    rec.pass("marks", &targets, |pass| pass.draw(&mark, 1, 1, (), ()));
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
    let read = ctx.debug_entries().entries;
    assert!(read.iter().all(|e| e.kernel == "marks"));
    let vertex = read
        .iter()
        .find(|e| e.tag == 1)
        .expect("the vertex shader writes a value");
    assert_eq!((vertex.invocation, vertex.value), (0, DebugValue::Uint(10)));
    let fragment = read
        .iter()
        .find(|e| e.tag == 2)
        .expect("the fragment shader writes a value");
    let DebugValue::Float(x) = fragment.value else {
        panic!("{fragment:?}")
    };
    assert_eq!(fragment.invocation & 0xffff, x as u32);
    assert_silent(&ctx);
}

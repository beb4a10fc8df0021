//! The build's own work on shaders: errors with file and line, and handles that do not compile where host and shader
//! disagree.

use std::path::Path;
use std::process::Command;

/// Runs the build script on a folder of shaders, given as name and text. Returns what it generates, or its errors.
fn build(files: &[(&str, &str)]) -> Result<String, String> {
    let folder = tempfile::tempdir().unwrap();
    let (shaders, out) = (folder.path().join("shaders"), folder.path().join("out"));
    std::fs::create_dir_all(shaders.join("include")).unwrap();
    std::fs::create_dir_all(&out).unwrap();
    for (name, text) in files {
        std::fs::write(shaders.join(name), text).unwrap();
    }
    let output = Command::new(env!("MYXO_BUILD_SCRIPT"))
        .current_dir(folder.path())
        .env("OUT_DIR", &out)
        .output()
        .unwrap();
    if output.status.success() {
        let read = |name| std::fs::read_to_string(out.join(name)).unwrap();
        return Ok(read("kernels.rs") + &read("draws.rs"));
    }
    let stdout = String::from_utf8(output.stdout).unwrap();
    let errors = stdout
        .lines()
        .filter_map(|line| line.strip_prefix("cargo::error="));
    Err(errors.collect::<Vec<_>>().join("\n"))
}

/// A kernel of one group size with these lines before `main` and in it.
fn kernel(declarations: &str, body: &str) -> String {
    format!(
        "#version 460\nlayout(local_size_x = 64) in;\n{declarations}\nvoid main() {{ {body} }}\n"
    )
}

#[track_caller]
fn error_of(declarations: &str, body: &str) -> String {
    build(&[("bad.comp", &kernel(declarations, body))]).expect_err("this does not build")
}

#[test]
fn a_shader_error_has_file_and_line() {
    let text = build(&[
        ("good.comp", &kernel("", "")),
        ("bad.comp", "#version 460\n\nvoid main() {\n    x = 1;\n}\n"),
    ]);
    let text = text.unwrap_err();
    assert!(
        text.contains("shaders/bad.comp:4: error:") && text.contains("'x'"),
        "{text}"
    );
}

#[test]
fn an_error_in_an_include_has_its_own_file_and_line() {
    let include = (
        "include/helper.glsl",
        "float one() {\n    return nothing;\n}\n",
    );
    let text = build(&[
        include,
        ("bad.comp", &kernel("#include \"helper.glsl\"", "")),
    ])
    .unwrap_err();
    assert!(text.contains("include/helper.glsl:2: error:"), "{text}");
    let text = error_of("#include \"absent.glsl\"", "");
    assert!(
        text.contains("absent.glsl") && text.contains("bad.comp"),
        "{text}"
    );
}

#[test]
fn every_problem_of_every_file_is_reported() {
    let text = build(&[
        ("a.comp", "#version 460\nx\n"),
        ("b.comp", "#version 460\ny\n"),
    ])
    .unwrap_err();
    assert!(
        text.contains("a.comp:") && text.contains("b.comp:"),
        "{text}"
    );
}

#[test]
fn handles_say_what_the_shader_says() {
    let source = "#version 460
// sum_up: adds.
// Reads   values.
layout(local_size_x = 32) in;
layout(constant_id = 4) const float LIMIT = 0.5; // Largest sum.
layout(std430, binding = 2) readonly buffer Values { vec4 values[]; }; // What is added.
layout(std430, binding = 5) buffer Total { uint count; } total;
layout(push_constant) uniform Params { uint first; vec2 weight; float table[3]; } params;
void main() { precise float sum = values[params.first].x * params.weight.x + LIMIT; total.count = uint(sum); }
";
    let text = build(&[("sum_up.comp", source)]).unwrap();
    for part in [
        "pub struct SumUp;",
        "/// sum_up: adds.",
        "/// Read: What is added.\n    pub values: &'a crate::gpu::Buffer<glam::Vec4>,",
        "/// Read and written.\n    pub total: &'a crate::gpu::Buffer<u32>,",
        "number: 2, name: \"values\", argument: \"values\", access: crate::gpu::BindingAccess::Read,",
        "number: 5, name: \"total\", argument: \"total\", access: crate::gpu::BindingAccess::ReadWrite,",
        "bytes[8..8 + size_of::<glam::Vec2>()]",
        "bytes[16..16 + size_of::<[f32; 3]>()]",
        "const SIZE: usize = 28;",
        "/// Largest sum.\n    pub limit: f32,",
        "limit: f32::from_bits(1056964608)",
        "(4, self.limit.to_ne_bytes())",
        "const GROUP_SIZE: u32 = 32;",
    ] {
        assert!(text.contains(part), "{part:?} is not in:\n{text}");
    }
}

#[test]
fn mistakes_are_refused_with_what_to_do() {
    let cases = [
        (
            "",
            "uint i = gl_GlobalInvocationID.x; if (i > 3) return;",
            "invocation_index()",
        ),
        (
            "layout(binding = 0) buffer A { vec3 a[]; };",
            "a[0] = vec3(1);",
            "use vec4 or a struct",
        ),
        (
            "layout(set = 1, binding = 0) buffer A { uint a[]; };",
            "a[0] = 1;",
            "set 0",
        ),
        (
            "layout(binding = 0) buffer A { uint a; uint b; };",
            "a = b;",
            "needs an instance name",
        ),
        (
            "layout(push_constant) uniform P { mat4 a; mat4 b; float c; } p;",
            "if (p.c > 0) return;",
            "132 bytes",
        ),
        (
            "layout(binding = 0) buffer A { double a[]; };",
            "a[0] = 1;",
            "32 bits",
        ),
        (
            "layout(binding = 0, rgba8) uniform image2D a;",
            "imageStore(a, ivec2(0), vec4(0));",
            "storage blocks",
        ),
    ];
    for (declarations, body, expected) in cases {
        let text = error_of(declarations, body);
        assert!(
            text.contains("bad.comp: ") && text.contains(expected),
            "{expected:?} is not in: {text}"
        );
    }
    let flat = "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\nvoid main() {}\n";
    let text = build(&[("flat.comp", flat)]).unwrap_err();
    assert!(text.contains("one-dimensional"), "{text}");
}

#[test]
fn ways_into_a_texture_are_one_argument() {
    let declarations = "layout(binding = 3) uniform samplerBuffer trail_texels;
layout(binding = 1, r32f) uniform writeonly imageBuffer trail_low;
layout(binding = 2, r32f) uniform writeonly imageBuffer trail_high;
layout(binding = 4, rgba32ui) uniform writeonly uimageBuffer counts_quads;
layout(binding = 5) writeonly buffer Counts { uvec4 counts_block[]; };
layout(binding = 6) uniform samplerBuffer bias_texels;  // may be absent
layout(binding = 7) readonly buffer Meals { uint meals[]; };  // may be absent";
    let body = "imageStore(trail_low, 0, texelFetch(trail_texels, 0));";
    let text = build(&[("spread.comp", &kernel(declarations, body))]).unwrap();
    let expected = [
        "    /// Read and written.\n    pub trail: &'a crate::sim::texture::Texture<f32>,\n",
        "    /// Written.\n    pub counts: &'a crate::sim::texture::Texture<u32>,\n",
        "    pub bias: Option<&'a crate::sim::texture::Texture<f32>>,\n",
        "    pub meals: Option<&'a crate::gpu::Buffer<u32>>,\n",
        "number: 2, name: \"trail_high\", argument: \"trail\",",
        "Texels(args.trail.low.as_dyn())",
        "FirstPart(args.counts)",
        "args.meals.map_or(crate::gpu::Resource::Absent(crate::gpu::Absent::Block)",
    ];
    for part in expected {
        assert!(text.contains(part), "{part:?} is not in:\n{text}");
    }
    assert_eq!(text.matches("    pub trail: ").count(), 1, "{text}");
}

#[test]
fn names_of_ways_need_their_types() {
    let cases = [
        (
            "layout(binding = 0) uniform samplerBuffer trail_low;",
            "trail_low: what ends in _low is a way into a texture",
        ),
        (
            "layout(binding = 0) buffer A { uvec2 trail_block[]; };",
            "trail_block: what ends in _block is a way into a texture",
        ),
        (
            "layout(binding = 0) uniform samplerBuffer trail_texels;
layout(binding = 1, r32ui) uniform uimageBuffer trail_low;",
            "trail_low: what begins with trail is a crate::sim::texture::Texture<f32> elsewhere",
        ),
        (
            "layout(binding = 0, r32ui) uniform uimageBuffer list;  // may be absent",
            "list: storage blocks and texel buffers of floats or uints that are read may be absent",
        ),
    ];
    for (declarations, expected) in cases {
        let text = error_of(declarations, "");
        assert!(text.contains(expected), "{expected:?} is not in: {text}");
    }
}

#[test]
fn a_vertex_and_a_fragment_shader_agree_or_do_not_build() {
    let vertex = |binding| {
        format!(
            "#version 460\nlayout(binding = {binding}) readonly buffer A {{ vec4 a[]; }};\nvoid main() {{ gl_Position = a[gl_VertexIndex]; }}\n"
        )
    };
    let fragment = "#version 460\nlayout(binding = 1) readonly buffer A { vec4 a[]; };\nlayout(location = 0) out vec4 c;\nvoid main() { c = a[0]; }\n";
    let text = build(&[("x.vert", &vertex(1)), ("x.frag", fragment)]).unwrap();
    assert!(
        text.contains("pub struct XDraw;") && text.matches("pub a: ").count() == 1,
        "{text}"
    );
    let text = build(&[("x.vert", &vertex(0)), ("x.frag", fragment)]).unwrap_err();
    assert!(
        text.contains("x: .vert has a at binding 0, .frag has a at binding 1"),
        "{text}"
    );
    let text = build(&[("x.frag", fragment)]).unwrap_err();
    assert!(text.contains("x.frag has no x.vert"), "{text}");
}

/// Compiles the generated assertions against a Rust struct; the compiler's messages if it refuses.
fn compile_against(rust_struct: &str) -> Result<(), String> {
    let types = "struct Probe { uint id; vec2 place; float weight[2]; };\n";
    let folder = tempfile::tempdir().unwrap();
    let shader = kernel(
        "#include \"types.glsl\"\nlayout(std430, binding = 0) buffer Probes { Probe probes[]; };",
        "probes[0].id = 1;",
    );
    let generated = build(&[("include/types.glsl", types), ("touch.comp", &shader)])?;
    let assertions: String = generated
        .lines()
        .filter(|l| l.starts_with("const _:"))
        .map(|l| format!("{l}\n"))
        .collect();
    assert_eq!(
        assertions
            .matches("size_of::<crate::sim::types::Probe>() == 24")
            .count(),
        1,
        "{assertions}"
    );
    // A stand-in for glam, so that the compiler needs nothing but this file.
    let source = format!(
        "#![allow(dead_code)]\n\
         mod glam {{ #[repr(C)] pub struct Vec2 {{ pub x: f32, pub y: f32 }} }}\n\
         pub mod sim {{ pub mod types {{ use crate::glam; {rust_struct} }} }}\n{assertions}"
    );
    let file = folder.path().join("probe.rs");
    std::fs::write(&file, source).unwrap();
    check(&file)
}

fn check(file: &Path) -> Result<(), String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc)
        .args([
            "--edition",
            "2024",
            "--crate-type",
            "lib",
            "--emit",
            "metadata",
            "--out-dir",
        ])
        .arg(file.parent().unwrap())
        .arg(file)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() {
        Ok(())
    } else {
        Err(text)
    }
}

#[test]
fn a_struct_that_differs_from_the_shaders_does_not_compile() {
    let probe =
        |fields: &str| compile_against(&format!("#[repr(C)] pub struct Probe {{ {fields} }}"));
    // vec2 is aligned to 8 bytes in the shader.
    probe("pub id: u32, pub pad0: u32, pub place: glam::Vec2, pub weight: [f32; 2]").unwrap();
    let text = probe("pub id: u32, pub place: glam::Vec2, pub weight: [f32; 2]").unwrap_err();
    assert!(
        text.contains("Probe: the shaders' struct has 24 bytes"),
        "{text}"
    );
    let text = probe("pub id: u32, pub pad0: u32, pub weight: [f32; 2], pub place: glam::Vec2")
        .unwrap_err();
    assert!(
        text.contains("Probe.place: at byte 8 in the shaders"),
        "{text}"
    );
    let text = probe("pub id: i32, pub pad0: u32, pub place: glam::Vec2, pub weight: [f32; 2]")
        .unwrap_err();
    assert!(text.contains("mismatched types"), "{text}");
    let text = probe("pub number: u32, pub pad0: u32, pub place: glam::Vec2, pub weight: [f32; 2]")
        .unwrap_err();
    assert!(text.contains("no field `id`"), "{text}");
}

/// Graphics cards round what Vulkan lets them round, and contract what they may.
#[test]
fn a_kernel_of_state_whose_bits_devices_may_choose_does_not_build() {
    let declarations =
        "layout(binding = 0) buffer A { float a[]; };\nlayout(binding = 1) buffer B { vec4 b[]; };";
    let cases = [
        ("a[0] = a[1] / a[2];", "OpFDiv: write quotient()"),
        ("a[0] = sqrt(a[1]);", "Sqrt: write root()"),
        ("a[0] = dot(b[1], b[2]);", "OpDot: write dot_of()"),
        (
            "b[0].xyz = normalize(b[1].xyz);",
            "Normalize: write direction_or()",
        ),
        (
            "precise float x = fma(a[0], a[1], a[2]); a[0] = x;",
            "Fma: ",
        ),
        // The optimiser contracts these two; where they stand, the other module says.
        ("a[0] = a[1] * a[2] + a[3];", "OpFMul may be contracted"),
        ("a[0] = a[1] - a[2];", "OpFSub may be contracted"),
        (
            "b[0] = b[1] * a[0];",
            "OpVectorTimesScalar may be contracted",
        ),
        ("a[0] = mix(a[1], a[2], a[3]);", "FMix: write the sum"),
        (
            "mat2 m = mat2(b[0].xy, b[1].xy); b[2].xy = m * b[3].xy;",
            "OpMatrixTimesVector: write the sums",
        ),
    ];
    for (body, expected) in cases {
        let text = error_of(declarations, body);
        let place = "bad.comp:5: error: not the same on every device: ";
        assert!(
            text.contains(place) && text.contains(expected),
            "{expected:?} is not in: {text}"
        );
    }
    // An instruction that no list names is refused for its result: OpImageGather.
    let text = error_of(
        &format!("layout(binding = 2) uniform sampler2D t; {declarations}"),
        "b[0] = textureGather(t, b[1].xy);",
    );
    assert!(
        text.contains("bad.comp:5: error: not the same on every device: instruction 96 of SPIR-V"),
        "{text}"
    );
    // One of integers is not.
    let integers = "layout(binding = 2) buffer C { uint c[]; }; shared uint total;";
    let sum = "atomicAdd(total, c[0]); c[1] = total + (c[2] << 3);";
    build(&[("sum.comp", &kernel(integers, sum))]).unwrap();
    let fine = "precise float x = a[1] * a[2] + a[3]; a[0] = max(floor(x), abs(a[4]));";
    build(&[("good.comp", &kernel(declarations, fine))]).unwrap();
    // What is of pictures may round as it likes.
    build(&[("expose.comp", &kernel(declarations, "a[0] = a[1] / a[2];"))]).unwrap();
}

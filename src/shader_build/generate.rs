//! Writes the reflected shaders as Rust: a handle, its arguments, its parameters and its constants.
//!
//! Generated code names `crate::gpu` for what it implements and `crate::sim::types` for shared structs, and states
//! every shared struct's layout as constant assertions: a struct that differs from the shader's does not compile.

use super::interface::{Interface, camel_case, put, rust_type, struct_path};
use super::model::{Access, Binding, Constant, Field, Shader, Stage, Struct};

/// Code for every compute shader, and the assertions for `shared` and for the structs that the shaders declare.
pub fn kernels(shaders: &[Shader], shared: &[Struct]) -> Result<String, String> {
    let mut out = String::new();
    let compute: Vec<&Shader> = shaders
        .iter()
        .filter(|s| s.stage == Stage::Compute)
        .collect();
    for shader in &compute {
        let kernel = camel_case(&shader.stem);
        let interface = Interface {
            stem: &shader.stem,
            handle: &kernel,
            bindings: &shader.bindings,
            debug_binding: shader.debug_binding,
            params: shader.params.as_ref(),
            constants: &shader.constants,
            sources: vec![shader],
        };
        interface.write(&mut out, "comp")?;
        put!(
            &mut out,
            "impl crate::gpu::Kernel for {kernel} {{\n    \
                 const SPIRV: crate::gpu::Module = {};\n    \
                 const GROUP_SIZE: u32 = {};\n}}\n\n",
            module(shader),
            shader.group_size
        );
    }
    let mut structs: Vec<&Struct> = shared.iter().collect();
    structs.extend(compute.iter().flat_map(|s| &s.structs));
    out += &assertions(structs);
    Ok(out)
}

/// Code for every pair of a vertex and a fragment shader of the same stem.
pub fn draws(shaders: &[Shader]) -> Result<String, String> {
    let mut out = String::new();
    for vertex in shaders.iter().filter(|s| s.stage == Stage::Vertex) {
        let stem = &vertex.stem;
        let fragment = shaders
            .iter()
            .find(|s| s.stage == Stage::Fragment && &s.stem == stem)
            .ok_or_else(|| format!("shaders/{stem}.vert has no {stem}.frag beside it"))?;
        let handle = format!("{}Draw", camel_case(stem));
        let bindings = merged_bindings(vertex, fragment)?;
        let constants = merged_constants(vertex, fragment)?;
        if let (Some(a), Some(b)) = (&vertex.params, &fragment.params)
            && a.fields != b.fields
        {
            return Err(format!(
                "{stem}: the push constants of .vert and .frag differ; declare the same block in both"
            ));
        }
        let interface = Interface {
            stem,
            handle: &handle,
            bindings: &bindings,
            debug_binding: vertex.debug_binding.or(fragment.debug_binding),
            params: vertex.params.as_ref().or(fragment.params.as_ref()),
            constants: &constants,
            sources: vec![vertex, fragment],
        };
        interface.write(&mut out, "vert")?;
        put!(
            &mut out,
            "impl crate::gpu::Draw for {handle} {{\n    \
                 const VERTEX: crate::gpu::Module = {};\n    \
                 const FRAGMENT: crate::gpu::Module = {};\n}}\n\n",
            module(vertex),
            module(fragment)
        );
        out += &assertions(vertex.structs.iter().chain(&fragment.structs).collect());
    }
    if let Some(lonely) = shaders.iter().find(|s| {
        s.stage == Stage::Fragment
            && !shaders
                .iter()
                .any(|v| v.stage == Stage::Vertex && v.stem == s.stem)
    }) {
        return Err(format!(
            "shaders/{0}.frag has no {0}.vert beside it",
            lonely.stem
        ));
    }
    Ok(out)
}

/// A shader's module with the name of its file.
fn module(shader: &Shader) -> String {
    let other = |words: &Option<Vec<u32>>, file: String| match words {
        None => "None".to_owned(),
        Some(_) => format!("Some(&{})", module_of(&file, ["None"; 3])),
    };
    let for_cards = other(&shader.for_cards, shader.card_file());
    let for_pages = other(&shader.for_pages, shader.pages_file());
    let for_large = other(&shader.for_large, shader.large_file());
    module_of(&shader.spirv_file(), [&for_cards, &for_pages, &for_large])
}

fn module_of(file: &str, [for_cards, for_pages, for_large]: [&str; 3]) -> String {
    format!(
        "crate::gpu::Module {{ file: \"{file}\", spirv: include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{file}\")), for_cards: {for_cards}, for_pages: {for_pages}, for_large: {for_large} }}"
    )
}

fn merged_bindings(vertex: &Shader, fragment: &Shader) -> Result<Vec<Binding>, String> {
    let mut bindings = vertex.bindings.clone();
    for other in &fragment.bindings {
        match bindings
            .iter_mut()
            .find(|b| b.number == other.number || b.name == other.name)
        {
            None => bindings.push(other.clone()),
            Some(same)
                if same.number == other.number
                    && same.name == other.name
                    && same.resource == other.resource =>
            {
                if same.access != other.access {
                    same.access = Access::ReadWrite;
                }
            }
            Some(same) => {
                return Err(format!(
                    "{}: .vert has {} at binding {}, .frag has {} at binding {}; give one buffer one name, number and type",
                    vertex.stem, same.name, same.number, other.name, other.number
                ));
            }
        }
    }
    bindings.sort_by_key(|b| b.number);
    Ok(bindings)
}

fn merged_constants(vertex: &Shader, fragment: &Shader) -> Result<Vec<Constant>, String> {
    let mut constants = vertex.constants.clone();
    for other in &fragment.constants {
        match constants
            .iter()
            .find(|c| c.id == other.id || c.name == other.name)
        {
            None => constants.push(other.clone()),
            Some(same) if same == other => {}
            Some(same) => {
                return Err(format!(
                    "{}: .vert and .frag disagree about constant {}",
                    vertex.stem, same.name
                ));
            }
        }
    }
    constants.sort_by_key(|c| c.id);
    Ok(constants)
}

/// Constant assertions for every struct: size, and each field's offset and type.
pub fn assertions(mut structs: Vec<&Struct>) -> String {
    structs.sort_by(|a, b| a.name.cmp(&b.name));
    structs.dedup_by(|a, b| a == b);
    let mut out = String::new();
    for layout in structs {
        let ty = struct_path(&layout.name);
        put!(
            &mut out,
            "const _: () = assert!(size_of::<{ty}>() == {}, \"{}: the shaders' struct has {} bytes, the Rust struct has not\");\n",
            layout.size,
            layout.name,
            layout.size
        );
        for Field {
            name,
            offset,
            ty: field,
        } in &layout.fields
        {
            put!(
                &mut out,
                "const _: () = assert!(core::mem::offset_of!({ty}, {name}) == {offset}, \"{}.{name}: at byte {offset} in the shaders, elsewhere in the Rust struct\");\n",
                layout.name
            );
            if let Ok(field) = rust_type(field) {
                put!(
                    &mut out,
                    "const _: fn(&{ty}) -> &{field} = |s| &s.{name};\n"
                );
            }
        }
    }
    out
}

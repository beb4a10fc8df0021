//! Writes the reflected shaders as Rust: a handle, its arguments, its parameters and its constants.
//!
//! Generated code names `crate::gpu` for what it implements and `crate::sim::types` for shared structs, and states
//! every shared struct's layout as constant assertions: a struct that differs from the shader's does not compile.

use std::fmt::Write;

use super::reflect::{Access, Binding, Constant, Field, Resource, Shader, Stage, Struct, Ty};

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
        put(
            &mut out,
            format_args!(
                "impl crate::gpu::Kernel for {kernel} {{\n    \
                 const SPIRV: &'static [u8] = include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{}\"));\n    \
                 const GROUP_SIZE: u32 = {};\n}}\n\n",
                shader.spirv_file(),
                shader.group_size,
            ),
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
        put(
            &mut out,
            format_args!(
                "impl crate::gpu::Draw for {handle} {{\n    \
                 const VERTEX: &'static [u8] = include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{}\"));\n    \
                 const FRAGMENT: &'static [u8] = include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{}\"));\n}}\n\n",
                vertex.spirv_file(),
                fragment.spirv_file(),
            ),
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

/// What a kernel and a draw have in common.
struct Interface<'a> {
    stem: &'a str,
    handle: &'a str,
    bindings: &'a [Binding],
    debug_binding: Option<u32>,
    params: Option<&'a Struct>,
    constants: &'a [Constant],
    sources: Vec<&'a Shader>,
}

impl Interface<'_> {
    fn write(&self, out: &mut String, ending: &str) -> Result<(), String> {
        let base = camel_case(self.stem);
        put(
            out,
            format_args!(
                "/// The handle of `{}.{ending}`:\n///\n/// ```text\n",
                self.stem
            ),
        );
        for line in &self.sources[0].header {
            put(out, format_args!("/// {line}\n"));
        }
        put(
            out,
            format_args!(
                "/// ```\n#[derive(Clone, Copy, Debug)]\npub struct {};\n\n",
                self.handle
            ),
        );
        let args = self.write_args(out, &base)?;
        let params = self.write_params(out, &base)?;
        let constants = self.write_constants(out, &base)?;
        put(
            out,
            format_args!(
                "impl crate::gpu::Interface for {} {{\n    const NAME: &'static str = \"{}\";\n",
                self.handle, self.stem
            ),
        );
        put(
            out,
            format_args!("    const BINDINGS: &'static [crate::gpu::Binding] = &[\n"),
        );
        for binding in self.bindings {
            let kind = match binding.resource {
                Resource::Storage(_) => "Storage",
                Resource::Texels(_) => "Texels",
            };
            put(
                out,
                format_args!(
                    "        crate::gpu::Binding {{ number: {}, name: \"{}\", access: crate::gpu::BindingAccess::{:?}, kind: crate::gpu::BindingKind::{kind} }},\n",
                    binding.number, binding.name, binding.access
                ),
            );
        }
        let debug = self.debug_binding;
        put(
            out,
            format_args!("    ];\n    const DEBUG_BINDING: Option<u32> = {debug:?};\n"),
        );
        put(
            out,
            format_args!(
                "    type Args<'a> = {args};\n    type Params = {params};\n    type Constants = {constants};\n"
            ),
        );
        put(
            out,
            format_args!(
                "    fn resources<'a>(args: &Self::Args<'a>) -> Vec<crate::gpu::Resource<'a>> {{\n"
            ),
        );
        if self.bindings.is_empty() {
            put(out, format_args!("        let () = args;\n"));
        }
        let list: Vec<String> = self
            .bindings
            .iter()
            .map(|b| match b.resource {
                Resource::Storage(_) => format!("crate::gpu::Resource::Buffer(args.{})", b.name),
                Resource::Texels(_) => {
                    format!("crate::gpu::Resource::Texels(args.{}.as_dyn())", b.name)
                }
            })
            .collect();
        put(
            out,
            format_args!("        vec![{}]\n    }}\n}}\n\n", list.join(", ")),
        );
        Ok(())
    }

    fn remark(&self, name: &str) -> Option<String> {
        self.sources
            .iter()
            .find_map(|s| s.remarks.get(name))
            .cloned()
    }

    fn write_args(&self, out: &mut String, base: &str) -> Result<String, String> {
        if self.bindings.is_empty() {
            return Ok("()".to_owned());
        }
        put(
            out,
            format_args!(
                "/// What `{}` reads and writes.\n#[derive(Clone, Copy)]\npub struct {base}Args<'a> {{\n",
                self.stem
            ),
        );
        for binding in self.bindings {
            let what = match binding.access {
                Access::Read => "Read",
                Access::Write => "Written",
                Access::ReadWrite => "Read and written",
            };
            let remark = self
                .remark(&binding.name)
                .map_or(String::new(), |r| format!(": {r}"));
            let ty = match &binding.resource {
                Resource::Storage(element) => {
                    format!("crate::gpu::Buffer<{}>", rust_type(element)?)
                }
                Resource::Texels(scalar) => format!("crate::gpu::Texels<{}>", rust_type(scalar)?),
            };
            put(
                out,
                format_args!(
                    "    /// {what}{remark}.\n    pub {}: &'a {ty},\n",
                    binding.name
                ),
            );
        }
        put(out, format_args!("}}\n\n"));
        Ok(format!("{base}Args<'a>"))
    }

    fn write_params(&self, out: &mut String, base: &str) -> Result<String, String> {
        let Some(params) = self.params else {
            return Ok("()".to_owned());
        };
        put(
            out,
            format_args!(
                "/// The push constants of `{}`.\n#[derive(Clone, Copy, Debug, Default, PartialEq)]\npub struct {base}Params {{\n",
                self.stem
            ),
        );
        for Field { name, ty, .. } in &params.fields {
            let remark = self
                .remark(name)
                .unwrap_or_else(|| format!("`{name}` in the shader."));
            put(
                out,
                format_args!("    /// {remark}\n    pub {name}: {},\n", rust_type(ty)?),
            );
        }
        put(
            out,
            format_args!(
                "}}\n\nimpl crate::gpu::Params for {base}Params {{\n    const SIZE: usize = {};\n",
                params.size
            ),
        );
        put(
            out,
            format_args!("    fn write(&self, bytes: &mut [u8]) {{\n"),
        );
        for Field { name, offset, ty } in &params.fields {
            let rust = rust_type(ty)?;
            put(
                out,
                format_args!(
                    "        bytes[{offset}..{offset} + size_of::<{rust}>()].copy_from_slice(bytemuck::bytes_of(&self.{name}));\n"
                ),
            );
        }
        put(out, format_args!("    }}\n}}\n\n"));
        Ok(format!("{base}Params"))
    }

    fn write_constants(&self, out: &mut String, base: &str) -> Result<String, String> {
        if self.constants.is_empty() {
            return Ok("()".to_owned());
        }
        put(
            out,
            format_args!(
                "/// The specialization constants of `{}`.\n#[derive(Clone, Copy, Debug, PartialEq)]\npub struct {base}Constants {{\n",
                self.stem
            ),
        );
        for constant in self.constants {
            let name = snake_case(&constant.name);
            let remark = self
                .remark(&constant.name)
                .unwrap_or_else(|| format!("`{}` in the shader.", constant.name));
            put(
                out,
                format_args!(
                    "    /// {remark}\n    pub {name}: {},\n",
                    rust_type(&constant.ty)?
                ),
            );
        }
        put(
            out,
            format_args!(
                "}}\n\nimpl Default for {base}Constants {{\n    fn default() -> Self {{\n        Self {{\n"
            ),
        );
        for constant in self.constants {
            let value = match constant.ty {
                Ty::Bool => format!("{}", constant.default != 0),
                Ty::I32 => format!("{}", constant.default as i32),
                Ty::F32 => format!("f32::from_bits({})", constant.default),
                _ => format!("{}", constant.default),
            };
            put(
                out,
                format_args!("            {}: {value},\n", snake_case(&constant.name)),
            );
        }
        put(
            out,
            format_args!(
                "        }}\n    }}\n}}\n\nimpl crate::gpu::Constants for {base}Constants {{\n"
            ),
        );
        put(
            out,
            format_args!("    fn values(&self) -> Vec<(u32, [u8; 4])> {{\n        vec![\n"),
        );
        for constant in self.constants {
            let name = snake_case(&constant.name);
            let bytes = match constant.ty {
                Ty::Bool => format!("u32::from(self.{name}).to_ne_bytes()"),
                _ => format!("self.{name}.to_ne_bytes()"),
            };
            put(
                out,
                format_args!("            ({}, {bytes}),\n", constant.id),
            );
        }
        put(out, format_args!("        ]\n    }}\n}}\n\n"));
        Ok(format!("{base}Constants"))
    }
}

/// Constant assertions for every struct: size, and each field's offset and type.
pub fn assertions(mut structs: Vec<&Struct>) -> String {
    structs.sort_by(|a, b| a.name.cmp(&b.name));
    structs.dedup_by(|a, b| a == b);
    let mut out = String::new();
    for layout in structs {
        let ty = struct_path(&layout.name);
        put(
            &mut out,
            format_args!(
                "const _: () = assert!(size_of::<{ty}>() == {}, \"{}: the shaders' struct has {} bytes, the Rust struct has not\");\n",
                layout.size, layout.name, layout.size
            ),
        );
        for Field {
            name,
            offset,
            ty: field,
        } in &layout.fields
        {
            put(
                &mut out,
                format_args!(
                    "const _: () = assert!(core::mem::offset_of!({ty}, {name}) == {offset}, \"{}.{name}: at byte {offset} in the shaders, elsewhere in the Rust struct\");\n",
                    layout.name
                ),
            );
            if let Ok(field) = rust_type(field) {
                put(
                    &mut out,
                    format_args!("const _: fn(&{ty}) -> &{field} = |s| &s.{name};\n"),
                );
            }
        }
    }
    out
}

fn rust_type(ty: &Ty) -> Result<String, String> {
    Ok(match ty {
        Ty::U32 => "u32".to_owned(),
        Ty::I32 => "i32".to_owned(),
        Ty::F32 => "f32".to_owned(),
        Ty::Bool => "bool".to_owned(),
        Ty::Mat4 => "glam::Mat4".to_owned(),
        Ty::Vector(scalar, n) => match **scalar {
            Ty::F32 => format!("glam::Vec{n}"),
            Ty::U32 => format!("glam::UVec{n}"),
            Ty::I32 => format!("glam::IVec{n}"),
            _ => return Err(format!("a vector of {scalar:?} has no host type")),
        },
        Ty::Array(element, n) => format!("[{}; {n}]", rust_type(element)?),
        Ty::Struct(name) => struct_path(name),
    })
}

/// One struct belongs to `gpu`, which reads it; the others are the simulation's.
fn struct_path(name: &str) -> String {
    let module = if name == "DispatchGroups" {
        "gpu"
    } else {
        "sim::types"
    };
    format!("crate::{module}::{name}")
}

fn camel_case(stem: &str) -> String {
    stem.split('_')
        .filter(|part| !part.is_empty())
        .map(|part| part[..1].to_uppercase() + &part[1..])
        .collect()
}

/// Constants are written in capitals in shaders; fields are not.
fn snake_case(name: &str) -> String {
    name.to_lowercase()
}

fn put(out: &mut String, text: std::fmt::Arguments<'_>) {
    out.write_fmt(text).expect("a String takes everything");
}

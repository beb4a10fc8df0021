//! Writes the common parts of kernels and draws: the handle, and the structs of its arguments, parameters and constants.

use super::arguments::{Argument, argument_of, arguments, resource};
use super::model::{Access, Binding, Constant, Field, Resource, Shader, Struct, Ty};

/// Appends formatted text to a `String`.
macro_rules! put {
    ($out:expr, $($text:tt)+) => {
        std::fmt::Write::write_fmt($out, format_args!($($text)+)).expect("a String takes everything")
    };
}
pub(super) use put;

/// The common parts of a kernel and a draw.
pub struct Interface<'a> {
    pub stem: &'a str,
    pub handle: &'a str,
    pub bindings: &'a [Binding],
    pub debug_binding: Option<u32>,
    pub params: Option<&'a Struct>,
    pub constants: &'a [Constant],
    pub sources: Vec<&'a Shader>,
}

impl Interface<'_> {
    /// The handle with its arguments, parameters and constants.
    pub fn write(&self, out: &mut String, ending: &str) -> Result<(), String> {
        let base = camel_case(self.stem);
        put!(
            out,
            "/// The handle of `{}.{ending}`:\n///\n/// ```text\n",
            self.stem
        );
        for line in &self.sources[0].header {
            put!(out, "/// {line}\n");
        }
        put!(
            out,
            "/// ```\n#[derive(Clone, Copy, Debug)]\npub struct {};\n\n",
            self.handle
        );
        let arguments =
            arguments(self.bindings, &self.sources).map_err(|e| format!("{}: {e}", self.stem))?;
        let args = self.write_args(out, &base, &arguments);
        let params = self.write_params(out, &base)?;
        let constants = self.write_constants(out, &base)?;
        put!(
            out,
            "impl crate::gpu::Interface for {} {{\n    const NAME: &'static str = \"{}\";\n",
            self.handle,
            self.stem
        );
        put!(
            out,
            "    const BINDINGS: &'static [crate::gpu::Binding] = &[\n"
        );
        for binding in self.bindings {
            let kind = match binding.resource {
                Resource::Storage(_) => "Storage".to_owned(),
                Resource::Texels(_) => "Texels".to_owned(),
                Resource::StorageTexels(_, n) => format!("StorageTexels {{ components: {n} }}"),
                Resource::Sampled => "Sampled".to_owned(),
            };
            put!(
                out,
                "        crate::gpu::Binding {{ number: {}, name: \"{}\", argument: \"{}\", access: crate::gpu::BindingAccess::{:?}, kind: crate::gpu::BindingKind::{kind}, is_paged: {}, each: {}, element: {} }},\n",
                binding.number,
                binding.name,
                argument_of(binding),
                binding.access,
                binding.is_paged,
                self.each(binding)?,
                element_size(binding)?
            );
        }
        let debug = self.debug_binding;
        put!(
            out,
            "    ];\n    const DEBUG_BINDING: Option<u32> = {debug:?};\n"
        );
        put!(
            out,
            "    type Args<'a> = {args};\n    type Params = {params};\n    type Constants = {constants};\n"
        );
        put!(
            out,
            "    fn resources<'a>(args: &Self::Args<'a>) -> Vec<crate::gpu::Resource<'a>> {{\n"
        );
        if self.bindings.is_empty() {
            put!(out, "        let () = args;\n");
        }
        let list: Result<Vec<String>, String> = self
            .bindings
            .iter()
            .enumerate()
            .map(|(i, binding)| {
                let of = arguments.iter().find(|one| one.bindings.contains(&i));
                resource(binding, of.is_some_and(|one| one.may_be_absent))
            })
            .collect();
        put!(out, "        vec![{}]\n    }}\n}}\n\n", list?.join(", "));
        Ok(())
    }

    /// The number of elements that an invocation needs of a binding, from a remark `// one an invocation` behind its declaration.
    fn each(&self, binding: &Binding) -> Result<u32, String> {
        let remark = self.remark(&binding.name).unwrap_or_default();
        match remark.split_once(" an invocation") {
            None => Ok(0),
            Some(("one", _)) => Ok(1),
            Some(("two", _)) => Ok(2),
            Some(("three", _)) => Ok(3),
            Some(("four", _)) => Ok(4),
            Some((word, _)) => Err(format!(
                "{}: `{word} an invocation` behind {}: one, two, three or four are possible",
                self.stem, binding.name
            )),
        }
    }

    fn remark(&self, name: &str) -> Option<String> {
        self.sources
            .iter()
            .find_map(|s| s.remarks.get(name))
            .cloned()
    }

    fn write_args(&self, out: &mut String, base: &str, arguments: &[Argument]) -> String {
        if arguments.is_empty() {
            return "()".to_owned();
        }
        put!(
            out,
            "/// What `{}` reads and writes.\n#[derive(Clone, Copy)]\npub struct {base}Args<'a> {{\n",
            self.stem
        );
        for argument in arguments {
            let what = match argument.access {
                Access::Read => "Read",
                Access::Write => "Written",
                Access::ReadWrite => "Read and written",
            };
            let remark = (argument.remark.as_ref())
                .map_or(String::new(), |r| format!(": {}", r.trim_end_matches('.')));
            let ty = if argument.may_be_absent {
                format!("Option<&'a {}>", argument.ty)
            } else {
                format!("&'a {}", argument.ty)
            };
            put!(
                out,
                "    /// {what}{remark}.\n    pub {}: {ty},\n",
                argument.name
            );
        }
        put!(out, "}}\n\n");
        format!("{base}Args<'a>")
    }

    fn write_params(&self, out: &mut String, base: &str) -> Result<String, String> {
        let Some(params) = self.params else {
            return Ok("()".to_owned());
        };
        put!(
            out,
            "/// The push constants of `{}`.\n#[derive(Clone, Copy, Debug, Default, PartialEq)]\npub struct {base}Params {{\n",
            self.stem
        );
        for Field { name, ty, .. } in &params.fields {
            let remark = self
                .remark(name)
                .unwrap_or_else(|| format!("`{name}` in the shader."));
            put!(
                out,
                "    /// {remark}\n    pub {name}: {},\n",
                rust_type(ty)?
            );
        }
        put!(
            out,
            "}}\n\nimpl crate::gpu::Params for {base}Params {{\n    const SIZE: usize = {};\n",
            params.size
        );
        put!(out, "    fn write(&self, bytes: &mut [u8]) {{\n");
        for Field { name, offset, ty } in &params.fields {
            let rust = rust_type(ty)?;
            put!(
                out,
                "        bytes[{offset}..{offset} + size_of::<{rust}>()].copy_from_slice(bytemuck::bytes_of(&self.{name}));\n"
            );
        }
        put!(out, "    }}\n}}\n\n");
        Ok(format!("{base}Params"))
    }

    fn write_constants(&self, out: &mut String, base: &str) -> Result<String, String> {
        if self.constants.is_empty() {
            return Ok("()".to_owned());
        }
        put!(
            out,
            "/// The specialization constants of `{}`.\n#[derive(Clone, Copy, Debug, PartialEq)]\npub struct {base}Constants {{\n",
            self.stem
        );
        let (paths, own): (Vec<_>, Vec<_>) = self
            .constants
            .iter()
            .partition(|c| path_of(&c.name).is_some());
        if !paths.is_empty() {
            put!(
                out,
                "    /// How it gets at single texels.\n    pub paths: {PATHS},\n"
            );
        }
        for constant in &own {
            let name = snake_case(&constant.name);
            let remark = self
                .remark(&constant.name)
                .unwrap_or_else(|| format!("`{}` in the shader.", constant.name));
            put!(
                out,
                "    /// {remark}\n    pub {name}: {},\n",
                rust_type(&constant.ty)?
            );
        }
        put!(
            out,
            "}}\n\nimpl Default for {base}Constants {{\n    fn default() -> Self {{\n        Self {{\n"
        );
        if !paths.is_empty() {
            put!(out, "            paths: {PATHS}::default(),\n");
        }
        for constant in &own {
            let value = match constant.ty {
                Ty::Bool => format!("{}", constant.default != 0),
                Ty::I32 => format!("{}", constant.default as i32),
                Ty::F32 => format!("f32::from_bits({})", constant.default),
                _ => format!("{}", constant.default),
            };
            put!(
                out,
                "            {}: {value},\n",
                snake_case(&constant.name)
            );
        }
        put!(
            out,
            "        }}\n    }}\n}}\n\nimpl crate::gpu::Constants for {base}Constants {{\n"
        );
        put!(
            out,
            "    fn values(&self) -> Vec<(u32, [u8; 4])> {{\n        vec![\n"
        );
        for constant in self.constants {
            let name = path_of(&constant.name).map_or_else(
                || snake_case(&constant.name),
                |path| format!("paths.{path}"),
            );
            let bytes = match constant.ty {
                Ty::Bool => format!("u32::from(self.{name}).to_ne_bytes()"),
                _ => format!("self.{name}.to_ne_bytes()"),
            };
            put!(out, "            ({}, {bytes}),\n", constant.id);
        }
        put!(out, "        ]\n    }}\n}}\n\n");
        Ok(format!("{base}Constants"))
    }
}

pub fn rust_type(ty: &Ty) -> Result<String, String> {
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
pub fn struct_path(name: &str) -> String {
    let module = if name == "DispatchGroups" {
        "gpu"
    } else {
        "sim::types"
    };
    format!("crate::{module}::{name}")
}

pub fn camel_case(stem: &str) -> String {
    stem.split('_')
        .filter(|part| !part.is_empty())
        .map(|part| part[..1].to_uppercase() + &part[1..])
        .collect()
}

/// Bytes of an element, as an expression; 0 unless it is a storage block.
fn element_size(binding: &Binding) -> Result<String, String> {
    Ok(match &binding.resource {
        Resource::Storage(element) => format!("size_of::<{}>()", rust_type(element)?),
        _ => "0".to_owned(),
    })
}

/// The source of the constants of `include/texels.glsl`, for every shader that includes it.
const PATHS: &str = "crate::sim::texel_paths::TexelPaths";

/// The field of it for such a constant.
fn path_of(constant: &str) -> Option<&'static str> {
    match constant {
        "TEXELS_IN_QUADS" => Some("in_quads"),
        "BAND" => Some("band"),
        "OUTGROWS_BLOCK" => Some("outgrows_block"),
        _ => None,
    }
}

/// Constants are written in capitals in shaders; fields are not.
fn snake_case(name: &str) -> String {
    name.to_lowercase()
}

//! Which bindings form an argument of the host: one each, except that the access paths of a texture form one argument by their names
//! (`shaders/include/texels.glsl`); and which arguments may be absent.

use super::interface::rust_type;
use super::model::{Access, Binding, Resource, Shader, Ty};

/// Endings of the names of access paths; the host's texture has a field of each name.
const WAYS: [&str; 5] = ["texels", "quads", "low", "high", "block"];

/// A field of the arguments.
pub struct Argument {
    pub name: String,
    /// Indices of its bindings.
    pub bindings: Vec<usize>,
    /// The type of the host's field, without the reference.
    pub ty: String,
    pub access: Access,
    /// The shader's remark.
    pub remark: Option<String>,
    pub may_be_absent: bool,
}

/// The arguments that bindings come from, in the order of each one's first binding.
pub fn arguments(bindings: &[Binding], sources: &[&Shader]) -> Result<Vec<Argument>, String> {
    let mut all: Vec<Argument> = Vec::new();
    for (index, binding) in bindings.iter().enumerate() {
        let remark = sources.iter().find_map(|s| s.remarks.get(&binding.name));
        let next = Argument {
            name: argument_of(binding).to_owned(),
            bindings: vec![index],
            ty: host_type(binding)?,
            access: binding.access,
            remark: remark.cloned(),
            may_be_absent: remark.is_some_and(|r| r.contains("may be absent")),
        };
        match all.iter_mut().find(|one| one.name == next.name) {
            None => all.push(next),
            Some(one) => one.add(next, binding)?,
        }
    }
    for one in all.iter().filter(|one| one.may_be_absent) {
        for &index in &one.bindings {
            absent(&bindings[index])?;
        }
    }
    Ok(all)
}

impl Argument {
    /// Adds another access path of the same texture.
    fn add(&mut self, way: Self, binding: &Binding) -> Result<(), String> {
        if self.ty != way.ty {
            return Err(format!(
                "{}: what begins with {} is a {} elsewhere, and a {} here",
                binding.name, self.name, self.ty, way.ty
            ));
        }
        self.bindings.extend(way.bindings);
        if self.access != way.access {
            self.access = Access::ReadWrite;
        }
        self.may_be_absent |= way.may_be_absent;
        self.remark = self.remark.take().or(way.remark);
        Ok(())
    }
}

/// The name of the argument that a binding comes from.
pub fn argument_of(binding: &Binding) -> &str {
    split(binding).map_or(&binding.name, |(name, _)| name)
}

/// The texture's name and the access path, if the binding is one.
fn split(binding: &Binding) -> Option<(&str, &str)> {
    let (name, way) = binding.name.rsplit_once('_')?;
    (!name.is_empty() && WAYS.contains(&way)).then_some((name, way))
}

fn host_type(binding: &Binding) -> Result<String, String> {
    if let Some((_, way)) = split(binding) {
        let scalar = match (way, &binding.resource) {
            ("texels" | "quads", Resource::Texels(scalar))
            | ("quads", Resource::StorageTexels(scalar, 4))
            | ("low" | "high", Resource::StorageTexels(scalar, 1))
            | ("block", Resource::Storage(scalar @ (Ty::F32 | Ty::U32))) => scalar,
            ("block", Resource::Storage(Ty::Vector(scalar, 4))) => scalar,
            _ => {
                return Err(format!(
                    "{}: what ends in _{way} is a way into a texture, as include/texels.glsl says; give it another name or that type",
                    binding.name
                ));
            }
        };
        return Ok(format!(
            "crate::sim::texture::Texture<{}>",
            rust_type(scalar)?
        ));
    }
    Ok(match &binding.resource {
        Resource::Storage(element) => format!("crate::gpu::Buffer<{}>", rust_type(element)?),
        Resource::Texels(scalar) | Resource::StorageTexels(scalar, _) => {
            format!("crate::gpu::Texels<{}>", rust_type(scalar)?)
        }
        Resource::Sampled => "crate::gpu::Sampled".to_owned(),
    })
}

/// The expression of `resources` for a binding.
pub fn resource(binding: &Binding, may_be_absent: bool) -> Result<String, String> {
    let name = argument_of(binding);
    let one = if may_be_absent {
        name.to_owned()
    } else {
        format!("args.{name}")
    };
    let bound = match (split(binding), &binding.resource) {
        (Some(_), Resource::Storage(_)) => format!("FirstPart({one})"),
        (Some((_, way)), _) => format!("Texels({one}.{way}.as_dyn())"),
        (None, Resource::Storage(_)) => format!("Buffer({one})"),
        (None, Resource::Texels(_) | Resource::StorageTexels(..)) => {
            format!("Texels({one}.as_dyn())")
        }
        (None, Resource::Sampled) => format!("Sampled({one})"),
    };
    let bound = format!("crate::gpu::Resource::{bound}");
    if !may_be_absent {
        return Ok(bound);
    }
    let absent = absent(binding)?;
    Ok(format!(
        "args.{name}.map_or(crate::gpu::Resource::Absent(crate::gpu::Absent::{absent}), |{name}| {bound})"
    ))
}

/// The resource that is bound in place of an absent argument.
fn absent(binding: &Binding) -> Result<&'static str, String> {
    match binding.resource {
        Resource::Storage(_) => Ok("Block"),
        Resource::Texels(Ty::F32) => Ok("Floats"),
        Resource::Texels(Ty::U32) => Ok("Words"),
        _ => Err(format!(
            "{}: storage blocks and texel buffers of floats or uints that are read may be absent, nothing else",
            binding.name
        )),
    }
}

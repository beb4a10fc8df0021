//! Reads a SPIR-V module into the few facts that the handles need: bindings, push constants, specialization
//! constants, the group size and the layout of every struct.

use spirq::ReflectConfig;
use spirq::ty::{
    AccessType, DescriptorType, ScalarType, SpirvType, StorageImageType, StructType, Type,
};
use spirq::var::Variable;

use super::model::{
    Access, Binding, Constant, DEBUG_BLOCK, Field, Resource, Shader, Stage, Struct, Ty,
};
use super::source::{self, RawModule};

/// Reflects an unoptimised module.
pub fn reflect(stem: &str, stage: Stage, words: &[u32], text: &str) -> Result<Shader, String> {
    let entries = ReflectConfig::new()
        .spv(words.to_vec())
        .ref_all_rscs(true)
        .reflect()
        .map_err(|e| format!("the compiled module cannot be reflected: {e}"))?;
    let entry = entries.first().ok_or("no entry point")?;
    let raw = RawModule::scan(words);
    let mut shader = Shader {
        stem: stem.to_owned(),
        stage,
        group_size: raw.group_size[0],
        bindings: Vec::new(),
        debug_binding: None,
        params: None,
        constants: Vec::new(),
        structs: Vec::new(),
        header: source::header(text),
        remarks: source::remarks(text),
        optimized: Vec::new(),
        for_cards: None,
        for_pages: None,
        for_large: None,
        warnings: Vec::new(),
    };
    if stage == Stage::Compute {
        check_compute(&raw)?;
    }
    for var in &entry.vars {
        add(&mut shader, var, &raw, text)?;
    }
    shader.bindings.sort_by_key(|b| b.number);
    shader.constants.sort_by_key(|c| c.id);
    check_distinct(&shader.bindings)?;
    Ok(shader)
}

/// Refuses groups and indices that are wrong in dispatches.
fn check_compute(raw: &RawModule) -> Result<(), String> {
    if raw.group_size[1] != 1 || raw.group_size[2] != 1 {
        return Err(
            "groups are one-dimensional: leave out local_size_y and local_size_z".to_owned(),
        );
    }
    if raw.uses_global_invocation_id {
        return Err("gl_GlobalInvocationID.x is wrong past 65,535 groups: include index.glsl and use invocation_index()".to_owned());
    }
    Ok(())
}

/// Adds a variable of the module to what is known of its shader.
fn add(shader: &mut Shader, var: &Variable, raw: &RawModule, text: &str) -> Result<(), String> {
    match var {
        Variable::Descriptor {
            name,
            desc_bind,
            desc_ty,
            ty,
            nbind,
        } => {
            if desc_bind.set() != 0 {
                return Err(format!("binding {desc_bind}: every descriptor is in set 0"));
            }
            if *nbind != 1 {
                return Err(format!(
                    "binding {desc_bind}: arrays of descriptors are not on every device"
                ));
            }
            let number = desc_bind.bind();
            if block_name(ty).is_some_and(|n| n == DEBUG_BLOCK) {
                shader.debug_binding = Some(number);
            } else {
                let mut binding =
                    binding(number, name.as_deref(), desc_ty, ty, &mut shader.structs)
                        .map_err(|e| format!("binding {number}: {e}"))?;
                binding.is_paged = source::is_paged(text, &binding.name);
                if binding.resource == Resource::Sampled && shader.stage != Stage::Compute {
                    return Err(format!("binding {number}: only kernels sample images"));
                }
                shader.bindings.push(binding);
            }
        }
        Variable::PushConstant { ty, .. } => {
            let Type::Struct(block) = ty else {
                return Err("push constants are a block".to_owned());
            };
            shader.params = Some(params(block, &mut shader.structs)?);
        }
        Variable::SpecConstant { name, spec_id, ty } => {
            let constant = constant(*spec_id, name.as_deref(), ty, raw, &mut shader.structs)?;
            shader.constants.push(constant);
        }
        Variable::Input { .. } | Variable::Output { .. } => {}
    }
    Ok(())
}

/// Refuses two bindings of one number or of one name. They are sorted by number.
fn check_distinct(bindings: &[Binding]) -> Result<(), String> {
    if let Some(pair) = bindings
        .windows(2)
        .find(|pair| pair[0].number == pair[1].number)
    {
        return Err(format!(
            "binding {} is declared twice, as {} and {}",
            pair[0].number, pair[0].name, pair[1].name
        ));
    }
    let mut names: Vec<&str> = bindings.iter().map(|b| b.name.as_str()).collect();
    names.sort_unstable();
    if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(format!("two bindings are called {}", pair[0]));
    }
    Ok(())
}

fn block_name(ty: &Type) -> Option<&str> {
    ty.as_struct().and_then(|s| s.name.as_deref())
}

fn binding(
    number: u32,
    instance: Option<&str>,
    descriptor: &DescriptorType,
    ty: &Type,
    structs: &mut Vec<Struct>,
) -> Result<Binding, String> {
    let instance = instance.filter(|n| !n.is_empty());
    let (name, access, resource) = match (descriptor, ty) {
        (DescriptorType::StorageBuffer(access), Type::Struct(block)) => {
            let (name, element) = storage_block(instance, ty, block, structs)?;
            (name, access_of(*access), Resource::Storage(element))
        }
        (DescriptorType::UniformTexelBuffer(), _) => {
            let scalar = match ty {
                Type::CombinedImageSampler(t) => &t.sampled_image_ty.scalar_ty,
                Type::SampledImage(t) => &t.scalar_ty,
                other => return Err(format!("{other:?} is no texel buffer")),
            };
            let name = instance.ok_or("a texel buffer needs a name")?.to_owned();
            (name, Access::Read, Resource::Texels(scalar_type(scalar)?))
        }
        (DescriptorType::StorageTexelBuffer(access), Type::StorageImage(texels)) => {
            let (scalar, components) = texel_format(texels)?;
            let name = instance.ok_or("a texel buffer needs a name")?.to_owned();
            let resource = Resource::StorageTexels(scalar, components);
            (name, access_of(*access), resource)
        }
        (DescriptorType::CombinedImageSampler(), Type::CombinedImageSampler(t))
            if scalar_type(&t.sampled_image_ty.scalar_ty) == Ok(Ty::F32) =>
        {
            let name = instance.ok_or("an image needs a name")?.to_owned();
            (name, Access::Read, Resource::Sampled)
        }
        (other, _) => {
            return Err(format!(
                "{other:?}: bind storage blocks, texel buffers or sampler2D"
            ));
        }
    };
    Ok(Binding {
        number,
        name,
        access,
        resource,
        is_paged: false,
    })
}

/// The host's name of a storage block, whose type is `ty`, and the type of an element.
fn storage_block(
    instance: Option<&str>,
    ty: &Type,
    block: &StructType,
    structs: &mut Vec<Struct>,
) -> Result<(String, Ty), String> {
    let (name, element) = match (instance, &block.members[..]) {
        (_, [only]) => (instance.or(only.name.as_deref()), only.ty.clone()),
        (Some(instance), _) => (Some(instance), ty.clone()),
        (None, _) => {
            return Err("a block of several members needs an instance name".to_owned());
        }
    };
    let name = name
        .ok_or("the block has neither an instance name nor a named member")?
        .to_owned();
    let element = match &element {
        Type::Array(array) if array.nelement.is_none() => {
            let element = shared_type(&array.element_ty, structs)?;
            let stride = array.stride.unwrap_or(0);
            if let Type::Struct(inner) = &*array.element_ty {
                fix_size(inner, stride, structs);
            } else if element.size().is_some_and(|size| size != stride) {
                return Err(format!(
                    "{name}: its elements lie {stride} bytes apart and are smaller; use vec4 or a struct"
                ));
            }
            element
        }
        other => shared_type(other, structs)?,
    };
    Ok((name, element))
}

/// The scalar of a texel that is written, and how many of them it has.
fn texel_format(texels: &StorageImageType) -> Result<(Ty, u32), String> {
    // Numbers of SPIR-V's image formats.
    match texels.fmt as u32 {
        1 => Ok((Ty::F32, 4)),
        3 => Ok((Ty::F32, 1)),
        30 => Ok((Ty::U32, 4)),
        33 => Ok((Ty::U32, 1)),
        _ => Err(format!(
            "{:?}: texels that are written are r32f, r32ui, rgba32f or rgba32ui",
            texels.fmt
        )),
    }
}

fn access_of(access: AccessType) -> Access {
    match access {
        AccessType::ReadOnly => Access::Read,
        AccessType::WriteOnly => Access::Write,
        AccessType::ReadWrite => Access::ReadWrite,
    }
}

/// An element's size is its stride, which only the array around it has.
fn fix_size(inner: &StructType, stride: usize, structs: &mut [Struct]) {
    let name = inner.name.as_deref().unwrap_or_default();
    if let Some(found) = structs.iter_mut().find(|s| s.name == name) {
        found.size = stride;
    }
}

fn params(block: &StructType, structs: &mut Vec<Struct>) -> Result<Struct, String> {
    let fields = fields(block, structs)?;
    let size = block
        .nbyte()
        .ok_or("push constants have no size")?
        .next_multiple_of(4);
    if size > 128 {
        return Err(format!(
            "push constants take {size} bytes; every device has 128, many have no more"
        ));
    }
    Ok(Struct {
        name: block.name.clone().unwrap_or_default(),
        size,
        fields,
    })
}

fn constant(
    id: u32,
    name: Option<&str>,
    ty: &Type,
    raw: &RawModule,
    structs: &mut Vec<Struct>,
) -> Result<Constant, String> {
    let name = name
        .ok_or_else(|| format!("specialization constant {id} has no name"))?
        .to_owned();
    let ty = shared_type(ty, structs).map_err(|e| format!("constant {name}: {e}"))?;
    let default = *raw
        .defaults
        .get(&id)
        .ok_or_else(|| format!("constant {name} has no default"))?;
    Ok(Constant {
        id,
        name,
        ty,
        default,
    })
}

fn fields(block: &StructType, structs: &mut Vec<Struct>) -> Result<Vec<Field>, String> {
    block
        .members
        .iter()
        .map(|member| {
            let name = member.name.clone().ok_or("a member without a name")?;
            let ty = shared_type(&member.ty, structs).map_err(|e| format!("{name}: {e}"))?;
            if let (Type::Array(array), Ty::Array(element, _)) = (&member.ty, &ty)
                && element
                    .size()
                    .is_some_and(|size| Some(size) != array.stride)
            {
                return Err(format!(
                    "{name}: its elements lie {:?} bytes apart; use vec4 or a struct",
                    array.stride
                ));
            }
            Ok(Field {
                offset: member
                    .offset
                    .ok_or_else(|| format!("{name} has no offset"))?,
                name,
                ty,
            })
        })
        .collect()
}

fn shared_type(ty: &Type, structs: &mut Vec<Struct>) -> Result<Ty, String> {
    match ty {
        Type::Scalar(scalar) => scalar_type(scalar),
        Type::Vector(vector) => Ok(Ty::Vector(
            Box::new(scalar_type(&vector.scalar_ty)?),
            vector.nscalar,
        )),
        Type::Matrix(matrix)
            if matrix.nvector == 4
                && matrix.vector_ty.nscalar == 4
                && matrix.stride == Some(16) =>
        {
            Ok(Ty::Mat4)
        }
        Type::Array(array) => {
            let count = array
                .nelement
                .ok_or("an array without an end can only be a block's last and only member")?;
            Ok(Ty::Array(
                Box::new(shared_type(&array.element_ty, structs)?),
                count,
            ))
        }
        Type::Struct(inner) => {
            let name = inner.name.clone().ok_or("a struct without a name")?;
            let layout = Struct {
                name: name.clone(),
                size: inner.nbyte().unwrap_or(0),
                fields: fields(inner, structs)?,
            };
            if !structs.iter().any(|s| s.name == name) {
                structs.push(layout);
            }
            Ok(Ty::Struct(name))
        }
        other => Err(format!(
            "{other:?} has no host type; use 32-bit scalars, vectors, mat4, arrays and structs"
        )),
    }
}

fn scalar_type(scalar: &ScalarType) -> Result<Ty, String> {
    match scalar {
        ScalarType::Boolean => Ok(Ty::Bool),
        ScalarType::Integer {
            bits: 32,
            is_signed: false,
        } => Ok(Ty::U32),
        ScalarType::Integer {
            bits: 32,
            is_signed: true,
        } => Ok(Ty::I32),
        ScalarType::Float { bits: 32 } => Ok(Ty::F32),
        other => Err(format!("{other:?}: shared scalars have 32 bits")),
    }
}

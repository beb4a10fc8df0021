//! Reads a SPIR-V module into the few facts that the handles need: bindings, push constants, specialization
//! constants, the group size and the layout of every struct.

use std::collections::BTreeMap;

use spirq::ReflectConfig;
use spirq::ty::{AccessType, DescriptorType, ScalarType, SpirvType, StructType, Type};
use spirq::var::Variable;

/// The name of the block that `include/debug.glsl` declares; the recorder binds it by itself.
pub const DEBUG_BLOCK: &str = "myxo_debug";

/// What a shader is run by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// `.comp`
    Compute,
    /// `.vert`
    Vertex,
    /// `.frag`
    Fragment,
}

/// One reflected shader.
#[derive(Clone, Debug)]
pub struct Shader {
    /// File name without its ending.
    pub stem: String,
    /// From the file's ending.
    pub stage: Stage,
    /// Invocations in a group; 1 for draws.
    pub group_size: u32,
    /// Storage blocks and texel buffers, by binding number, without the debug block.
    pub bindings: Vec<Binding>,
    /// The binding of the debug block, where the shader includes `debug.glsl`.
    pub debug_binding: Option<u32>,
    /// Push constants.
    pub params: Option<Struct>,
    /// Specialization constants by number.
    pub constants: Vec<Constant>,
    /// Every named struct that lies in a buffer.
    pub structs: Vec<Struct>,
    /// The comment at the head of the file.
    pub header: Vec<String>,
    /// Remarks behind declarations, by the declared name.
    pub remarks: BTreeMap<String, String>,
    /// The module to ship.
    pub optimized: Vec<u32>,
    /// What the compiler warned of.
    pub warnings: Vec<String>,
}

impl Shader {
    /// The file that holds the optimised module.
    pub fn spirv_file(&self) -> String {
        let stage = match self.stage {
            Stage::Compute => "comp",
            Stage::Vertex => "vert",
            Stage::Fragment => "frag",
        };
        format!("{}.{stage}.spv", self.stem)
    }
}

/// How a block is declared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// `readonly`
    Read,
    /// `writeonly`
    Write,
    /// neither
    ReadWrite,
}

/// What is bound.
#[derive(Clone, Debug, PartialEq)]
pub enum Resource {
    /// A storage block; the type is that of one element.
    Storage(Ty),
    /// `samplerBuffer`, `usamplerBuffer` or `isamplerBuffer`: the scalar that a fetch gives four of.
    Texels(Ty),
}

/// One binding.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// Number in set 0.
    pub number: u32,
    /// Name of the host's field.
    pub name: String,
    /// From `readonly` and `writeonly`.
    pub access: Access,
    /// Element type.
    pub resource: Resource,
}

/// A type that host and shader share.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Ty {
    U32,
    I32,
    F32,
    Bool,
    /// Scalar and number of components.
    Vector(Box<Ty>, u32),
    /// Column-major 4 x 4.
    Mat4,
    Array(Box<Ty>, u32),
    Struct(String),
}

/// A member with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name in the shader.
    pub name: String,
    /// Bytes from the start of the struct.
    pub offset: usize,
    /// Type.
    pub ty: Ty,
}

/// A struct with its layout.
#[derive(Clone, Debug, PartialEq)]
pub struct Struct {
    /// Name in the shader.
    pub name: String,
    /// Bytes from one element of an array to the next; for push constants the bytes in use.
    pub size: usize,
    /// Members in order.
    pub fields: Vec<Field>,
}

/// A specialization constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// `constant_id`
    pub id: u32,
    /// Name in the shader.
    pub name: String,
    /// `Bool`, `U32`, `I32` or `F32`.
    pub ty: Ty,
    /// The default's bits.
    pub default: u32,
}

/// Reflects an unoptimised module.
pub fn reflect(stem: &str, stage: Stage, words: &[u32], source: &str) -> Result<Shader, String> {
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
        header: header(source),
        remarks: remarks(source),
        optimized: Vec::new(),
        warnings: Vec::new(),
    };
    if stage == Stage::Compute {
        if raw.group_size[1] != 1 || raw.group_size[2] != 1 {
            return Err(
                "groups are one-dimensional: leave out local_size_y and local_size_z".to_owned(),
            );
        }
        if raw.uses_global_invocation_id {
            return Err("gl_GlobalInvocationID.x is wrong past 65,535 groups: include index.glsl and use invocation_index()".to_owned());
        }
    }
    for var in &entry.vars {
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
                    let binding =
                        binding(number, name.as_deref(), desc_ty, ty, &mut shader.structs)
                            .map_err(|e| format!("binding {number}: {e}"))?;
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
                let name = name
                    .clone()
                    .ok_or_else(|| format!("specialization constant {spec_id} has no name"))?;
                let ty = shared_type(ty, &mut shader.structs)
                    .map_err(|e| format!("constant {name}: {e}"))?;
                let default = *raw
                    .defaults
                    .get(spec_id)
                    .ok_or_else(|| format!("constant {name} has no default"))?;
                shader.constants.push(Constant {
                    id: *spec_id,
                    name,
                    ty,
                    default,
                });
            }
            Variable::Input { .. } | Variable::Output { .. } => {}
        }
    }
    shader.bindings.sort_by_key(|b| b.number);
    shader.constants.sort_by_key(|c| c.id);
    if let Some(pair) = shader
        .bindings
        .windows(2)
        .find(|pair| pair[0].number == pair[1].number)
    {
        return Err(format!(
            "binding {} is declared twice, as {} and {}",
            pair[0].number, pair[0].name, pair[1].name
        ));
    }
    let mut names: Vec<&str> = shader.bindings.iter().map(|b| b.name.as_str()).collect();
    names.sort_unstable();
    if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(format!("two bindings are called {}", pair[0]));
    }
    Ok(shader)
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
    match (descriptor, ty) {
        (DescriptorType::StorageBuffer(access), Type::Struct(block)) => {
            let access = match access {
                AccessType::ReadOnly => Access::Read,
                AccessType::WriteOnly => Access::Write,
                AccessType::ReadWrite => Access::ReadWrite,
            };
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
            Ok(Binding {
                number,
                name,
                access,
                resource: Resource::Storage(element),
            })
        }
        (DescriptorType::UniformTexelBuffer(), _) => {
            let scalar = match ty {
                Type::CombinedImageSampler(t) => &t.sampled_image_ty.scalar_ty,
                Type::SampledImage(t) => &t.scalar_ty,
                other => return Err(format!("{other:?} is no texel buffer")),
            };
            let name = instance.ok_or("a texel buffer needs a name")?.to_owned();
            Ok(Binding {
                number,
                name,
                access: Access::Read,
                resource: Resource::Texels(scalar_type(scalar)?),
            })
        }
        (other, _) => Err(format!("{other:?}: bind storage blocks or texel buffers")),
    }
}

/// An element's size is its stride, which only the array around it knows.
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

impl Ty {
    /// Bytes of the host's type, where it does not depend on a struct.
    pub fn size(&self) -> Option<usize> {
        match self {
            Ty::U32 | Ty::I32 | Ty::F32 | Ty::Bool => Some(4),
            Ty::Vector(_, n) => Some(4 * *n as usize),
            Ty::Mat4 => Some(64),
            Ty::Array(element, n) => Some(element.size()? * *n as usize),
            Ty::Struct(_) => None,
        }
    }
}

/// What spirq does not say: defaults of specialization constants, the literal group size, and one built-in.
struct RawModule {
    group_size: [u32; 3],
    defaults: BTreeMap<u32, u32>,
    uses_global_invocation_id: bool,
}

impl RawModule {
    fn scan(words: &[u32]) -> Self {
        const EXECUTION_MODE: u32 = 16;
        const SPEC_CONSTANT_TRUE: u32 = 48;
        const SPEC_CONSTANT_FALSE: u32 = 49;
        const SPEC_CONSTANT: u32 = 50;
        const DECORATE: u32 = 71;
        const DECORATION_SPEC_ID: u32 = 1;
        const DECORATION_BUILT_IN: u32 = 11;
        const BUILT_IN_GLOBAL_INVOCATION_ID: u32 = 28;
        const MODE_LOCAL_SIZE: u32 = 17;
        let mut module = Self {
            group_size: [1; 3],
            defaults: BTreeMap::new(),
            uses_global_invocation_id: false,
        };
        let mut spec_ids = BTreeMap::new();
        let mut at = 5;
        while at < words.len() {
            let (count, op) = ((words[at] >> 16) as usize, words[at] & 0xffff);
            if count == 0 || at + count > words.len() {
                break;
            }
            match (op, &words[at + 1..at + count]) {
                (EXECUTION_MODE, [_, MODE_LOCAL_SIZE, x, y, z]) => module.group_size = [*x, *y, *z],
                (DECORATE, [target, DECORATION_SPEC_ID, id]) => {
                    spec_ids.insert(*target, *id);
                }
                (DECORATE, [_, DECORATION_BUILT_IN, BUILT_IN_GLOBAL_INVOCATION_ID]) => {
                    module.uses_global_invocation_id = true
                }
                (SPEC_CONSTANT_TRUE | SPEC_CONSTANT_FALSE, [_, target]) => {
                    if let Some(id) = spec_ids.get(target) {
                        module
                            .defaults
                            .insert(*id, u32::from(op == SPEC_CONSTANT_TRUE));
                    }
                }
                (SPEC_CONSTANT, [_, target, value]) => {
                    if let Some(id) = spec_ids.get(target) {
                        module.defaults.insert(*id, *value);
                    }
                }
                _ => {}
            }
            at += count;
        }
        module
    }
}

/// The comment lines that a file begins with.
fn header(source: &str) -> Vec<String> {
    source
        .lines()
        .skip_while(|line| line.trim().is_empty() || line.starts_with("#version"))
        .take_while(|line| line.starts_with("//"))
        .map(|line| line.trim_start_matches('/').trim().to_owned())
        .collect()
}

/// `uint count; // how many` gives `count` its remark.
fn remarks(source: &str) -> BTreeMap<String, String> {
    source
        .lines()
        .filter_map(|line| {
            let (code, remark) = line.split_once("//")?;
            let declared = code.trim_end().strip_suffix(';')?;
            let declared = if code.trim_start().starts_with("layout") {
                declared.split_once(')')?.1
            } else {
                declared
            };
            let declared = declared
                .split('=')
                .next()?
                .trim_end()
                .trim_end_matches([']', '['])
                .trim_end();
            let name: String = declared
                .chars()
                .rev()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect();
            let name: String = name.chars().rev().collect();
            let remark = remark.trim();
            (!name.is_empty() && !remark.is_empty()).then(|| (name, remark.to_owned()))
        })
        .collect()
}

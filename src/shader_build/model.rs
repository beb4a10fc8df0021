//! The build's model of a shader, between reflecting and generating.

use std::collections::BTreeMap;

/// The name of the block that `include/debug.glsl` declares; the recorder binds it automatically.
pub const DEBUG_BLOCK: &str = "myxo_debug";

/// The stage of a shader.
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
    /// Storage blocks, texel buffers of both kinds and images, by binding number, without the debug block.
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
    /// The module for graphics cards, if it differs.
    pub for_cards: Option<Vec<u32>>,
    /// The module for tables in pages, if there is one.
    pub for_pages: Option<Vec<u32>>,
    /// The module for large tables, if there is one.
    pub for_large: Option<Vec<u32>>,
    /// The compiler's warnings.
    pub warnings: Vec<String>,
}

impl Shader {
    /// The file that holds the optimised module.
    pub fn spirv_file(&self) -> String {
        format!("{}.{}.spv", self.stem, self.ending())
    }

    fn ending(&self) -> &'static str {
        match self.stage {
            Stage::Compute => "comp",
            Stage::Vertex => "vert",
            Stage::Fragment => "frag",
        }
    }

    /// The file that holds the module for graphics cards.
    pub fn card_file(&self) -> String {
        format!("{}.card.spv", self.stem)
    }

    /// The file that holds the module for large tables.
    pub fn large_file(&self) -> String {
        format!("{}.large.spv", self.stem)
    }

    /// The file that holds the module for tables in pages.
    pub fn pages_file(&self) -> String {
        format!("{}.{}.pages.spv", self.stem, self.ending())
    }
}

/// The declared access to a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// `readonly`
    Read,
    /// `writeonly`
    Write,
    /// neither
    ReadWrite,
}

/// The kind of a binding.
#[derive(Clone, Debug, PartialEq)]
pub enum Resource {
    /// A storage block; the type is that of one element.
    Storage(Ty),
    /// `samplerBuffer`, `usamplerBuffer` or `isamplerBuffer`: the scalar that a fetch gives four of.
    Texels(Ty),
    /// `imageBuffer`, `uimageBuffer` or `iimageBuffer`: the scalar and how many of them a texel has.
    StorageTexels(Ty, u32),
    /// `sampler2D`.
    Sampled,
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
    /// It may lie in pages.
    pub is_paged: bool,
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

/// A member with its offset.
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

impl Ty {
    /// Bytes of the host's type, if it does not depend on a struct.
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

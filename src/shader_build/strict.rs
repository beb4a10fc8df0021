//! Refuses operations that devices may round differently. Kernels that decide the state of a simulation give the same bits everywhere only
//! if they use sums, differences and products that no compiler may contract, and functions of `shaders/include/strict.glsl`.
//!
//! Optimised modules are checked, because the optimiser contracts, too. An unoptimised module with line numbers gives the place of an
//! instruction in the text.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Kernels in `shaders` that decide no state: they are for pictures, or for queries of depths.
pub const NOT_OF_STATE: &[&str] = &["depth_queries", "draw_order", "expose", "trail_histogram"];

/// Does a kernel decide the state of a simulation? Every one in `shaders` does, unless a list says otherwise; those of other folders
/// do not.
pub fn must_be(path: &Path, stem: &str) -> bool {
    let folder = path.parent().and_then(Path::file_name);
    let is_of_steps = folder.is_none_or(|name| name != "selftest" && name != "choices");
    is_of_steps && !NOT_OF_STATE.contains(&stem)
}

/// The report on a kernel that is not strict: one line per violation, with its place if that is known.
pub fn report(
    name: &str,
    optimized: &BTreeSet<Violation>,
    with_lines: &BTreeSet<Violation>,
) -> String {
    let all = if with_lines.is_empty() {
        optimized
    } else {
        with_lines
    };
    let lines = all.iter().map(|Violation { place, what }| match place {
        Some((file, line)) => format!("{file}:{line}: error: not the same on every device: {what}"),
        None => format!("{name}: error: not the same on every device: {what}"),
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// A violation of strict arithmetic, and its place in the text, if the module has it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Violation {
    /// File and line.
    pub place: Option<(String, u32)>,
    /// The instruction, and what to write instead.
    pub what: String,
}

const ADD: u32 = 129;
const SUBTRACT: u32 = 131;
const MULTIPLY: u32 = 133;
const TIMES_SCALAR: u32 = 142;

/// Arithmetic that may contract.
fn contracts(op: u32) -> Option<&'static str> {
    match op {
        ADD => Some("OpFAdd"),
        SUBTRACT => Some("OpFSub"),
        MULTIPLY => Some("OpFMul"),
        TIMES_SCALAR => Some("OpVectorTimesScalar"),
        _ => None,
    }
}

/// Instructions that give the same floats everywhere: they move numbers, choose among them, or convert integers. All other instructions
/// with a float as their result are refused, except arithmetic that does not contract and calls of functions, which are checked separately.
fn moves_floats(op: u32) -> bool {
    matches!(
        op,
        // OpUndef, constants, specialization constants.
        1 | 43 | 44 | 46 | 50 | 51
            // OpFunction, OpFunctionParameter, OpFunctionCall, OpLoad, OpCopyObject, OpCopyLogical.
            | 54 | 55 | 57 | 61 | 83 | 400
            // Vectors and composites; OpTranspose.
            | 77
            ..=82 | 84
            // OpImageFetch, OpImageRead.
            | 95 | 98
            // OpConvertSToF, OpConvertUToF, OpBitcast, OpFNegate.
            | 111 | 112 | 124 | 127
            // OpSelect, OpPhi.
            | 169 | 245
    )
}

/// Instructions that strict arithmetic does not allow, by name, and the advice.
fn refused(op: u32) -> Option<(&'static str, &'static str)> {
    Some(match op {
        136 => ("OpFDiv", "write quotient() or reciprocal()"),
        140 => ("OpFRem", "it is rounded as the device likes"),
        141 => ("OpFMod", "it is rounded as the device likes"),
        143 => ("OpMatrixTimesScalar", "write the products"),
        144 => ("OpVectorTimesMatrix", "write the sums"),
        145 => ("OpMatrixTimesVector", "write the sums"),
        146 => ("OpMatrixTimesMatrix", "write the sums"),
        147 => ("OpOuterProduct", "write the products"),
        148 => ("OpDot", "write dot_of()"),
        116 => ("OpQuantizeToF16", "it is rounded as the device likes"),
        87..=94 => ("a sampled image", "fetch texels"),
        115 => ("OpFConvert", "there are no other floats"),
        207..=215 => ("a derivative", "kernels of state have none"),
        264 | 350 | 352 | 6035 => ("a sum by many invocations", "its order is the device's"),
        _ => return None,
    })
}

/// Is a function of GLSL.std.450 exact, but for the sign of zeros?
fn is_exact(function: u32) -> bool {
    // FAbs, SAbs, SSign, Floor; minima, maxima and clamps; the lowest and highest bit.
    matches!(function, 4 | 5 | 7 | 8 | 37..=45 | 73..=75)
}

/// The name of a function of GLSL.std.450, and what to write instead.
fn function(number: u32) -> String {
    let (name, instead) = match number {
        6 => ("FSign", "compare"),
        10 => ("Fract", "subtract floor()"),
        13 => ("Sin", "write turn_of()"),
        14 => ("Cos", "write turn_of()"),
        25 => ("Atan2", "write angle_of_vector()"),
        28 => ("Log", "write logarithm()"),
        31 => ("Sqrt", "write root()"),
        32 => ("InverseSqrt", "write inverse_root()"),
        46 => ("FMix", "write the sum"),
        50 => (
            "Fma",
            "a sum of a product is not precise: give it a precise variable of its own",
        ),
        60 => ("UnpackSnorm2x16", "multiply integers"),
        66 => ("Length", "write length_of()"),
        67 => ("Distance", "write length_of()"),
        68 => ("Cross", "write cross_of()"),
        69 => ("Normalize", "write direction_or()"),
        _ => {
            return format!("function {number} of GLSL.std.450 is rounded as the device likes");
        }
    };
    format!("{name}: {instead}")
}

/// All violations in a module.
pub fn violations(words: &[u32]) -> BTreeSet<Violation> {
    const STRING: u32 = 7;
    const LINE: u32 = 8;
    const NO_LINE: u32 = 317;
    const EXT_INST_IMPORT: u32 = 11;
    const TYPE_FLOAT: u32 = 22;
    // Vectors, matrices, arrays of either kind: the second operand is the element type.
    const TYPES_OF_ONE: [u32; 4] = [23, 24, 28, 29];
    const TYPE_STRUCT: u32 = 30;
    const FUNCTION_END: u32 = 56;
    const DECORATE: u32 = 71;
    const NO_CONTRACTION: u32 = 42;
    let mut known = Known::default();
    let mut files = BTreeMap::new();
    let mut place = None;
    let mut found = BTreeSet::new();
    for (op, rest) in instructions(words) {
        match (op, rest) {
            (STRING, [id, text @ ..]) => {
                files.insert(*id, string(text));
            }
            (LINE, [file, line, ..]) => {
                place = files.get(file).map(|file| (file.clone(), *line));
            }
            (NO_LINE | FUNCTION_END, _) => place = None,
            (EXT_INST_IMPORT, [id, name @ ..]) if string(name) == "GLSL.std.450" => {
                known.math = Some(*id);
            }
            (DECORATE, [target, NO_CONTRACTION]) => {
                known.strict.insert(*target);
            }
            (TYPE_FLOAT, [id, ..]) => {
                known.floats.insert(*id);
            }
            (_, [id, of, ..]) if TYPES_OF_ONE.contains(&op) && known.floats.contains(of) => {
                known.floats.insert(*id);
            }
            (TYPE_STRUCT, [id, members @ ..])
                if members.iter().any(|member| known.floats.contains(member)) =>
            {
                known.floats.insert(*id);
            }
            (_, [of, result, operands @ ..]) => {
                let what = known.violation(op, *of, *result, operands);
                found.extend(what.map(|what| Violation {
                    place: place.clone(),
                    what,
                }));
            }
            _ => {}
        }
    }
    found
}

/// The parts of a module that decide whether an instruction is strict.
#[derive(Default)]
struct Known {
    /// Results that may not be contracted.
    strict: BTreeSet<u32>,
    /// Types that contain a float. In a module, names and decorations precede types, and everything else follows.
    floats: BTreeSet<u32>,
    /// The id of the import of GLSL.std.450.
    math: Option<u32>,
}

impl Known {
    /// The violation by an instruction, if any.
    fn violation(&self, op: u32, of: u32, result: u32, operands: &[u32]) -> Option<String> {
        const EXT_INST: u32 = 12;
        const SPEC_CONSTANT_OP: u32 = 52;
        let has_float = self.floats.contains(&of);
        if let Some(name) = contracts(op) {
            return (!self.strict.contains(&result)).then(|| {
                format!(
                    "{name} may be contracted or rearranged: give it a precise variable of its own"
                )
            });
        }
        if let Some((name, instead)) = refused(op) {
            return Some(format!("{name}: {instead}"));
        }
        match (op, operands) {
            (EXT_INST, [set, number, ..]) if Some(*set) == self.math => {
                (!is_exact(*number)).then(|| function(*number))
            }
            (SPEC_CONSTANT_OP, [inner, ..]) => {
                let is_refused = refused(*inner).is_some() || has_float && !moves_floats(*inner);
                is_refused.then(|| {
                    "arithmetic of specialization constants: let the host do it".to_owned()
                })
            }
            _ => (has_float && !moves_floats(op)).then(|| {
                format!(
                    "instruction {op} of SPIR-V: it has a float as its result and is not among those that are exact everywhere"
                )
            }),
        }
    }
}

/// Opcodes and operands.
fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut at = 5;
    std::iter::from_fn(move || {
        let first = *words.get(at)?;
        let (count, op) = ((first >> 16) as usize, first & 0xffff);
        let rest = words.get(at + 1..at + count.max(1))?;
        at += count.max(1);
        Some((op, rest))
    })
}

/// A string as SPIR-V has it.
fn string(words: &[u32]) -> String {
    let bytes = words.iter().flat_map(|word| word.to_le_bytes());
    let bytes: Vec<u8> = bytes.take_while(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

//! Numbers from glTF accessors. Sizes in a file are not trusted: every range is checked before it is read, and before memory is allocated
//! for it.

use gltf::json::accessor::{
    BYTE, ComponentType, FLOAT, SHORT, UNSIGNED_BYTE, UNSIGNED_INT, UNSIGNED_SHORT,
};

use super::json::Part;
use super::resource::{Buffers, LOOKUP};
use super::{damaged, shortened};
use crate::mesh::error::MeshProblem;

/// The most numbers of a sparse accessor without a base: its zeros take no bytes in the file.
const MOST_ZEROS: u64 = 1 << 24;

/// The whole numbers of an accessor that a part of the file names.
pub(super) fn whole_numbers<const N: usize>(
    buffers: &mut Buffers<'_>,
    reference: &Part<'_>,
) -> Result<Vec<[u32; N]>, MeshProblem> {
    let accessor = Accessor::new(buffers, reference)?;
    if matches!(
        accessor.component,
        ComponentType::F32 | ComponentType::I8 | ComponentType::I16
    ) {
        return Err(accessor.should_hold("whole numbers without a sign"));
    }
    accessor.read(buffers, little_endian)
}

/// Vectors of floats. Small integers are taken too (`KHR_mesh_quantization`), as fractions where they are normalized.
pub(super) fn vectors<const N: usize>(
    buffers: &mut Buffers<'_>,
    reference: &Part<'_>,
) -> Result<Vec<[f64; N]>, MeshProblem> {
    let accessor = Accessor::new(buffers, reference)?;
    let (component, normalized) = (accessor.component, accessor.normalized);
    let most = match component {
        ComponentType::F32 => 1.0,
        ComponentType::I8 => 127.0,
        ComponentType::U8 => 255.0,
        ComponentType::I16 => 32_767.0,
        ComponentType::U16 => 65_535.0,
        ComponentType::U32 => {
            return Err(accessor.should_hold("floats, or whole numbers of one or two bytes"));
        }
    };
    accessor.read(buffers, |bytes| {
        let word = little_endian(bytes);
        let value = match component {
            ComponentType::F32 => return f64::from(f32::from_bits(word)),
            ComponentType::I8 => f64::from((word as u8).cast_signed()),
            ComponentType::I16 => f64::from((word as u16).cast_signed()),
            _ => f64::from(word),
        };
        if normalized {
            (value / most).max(-1.0)
        } else {
            value
        }
    })
}

/// The count of elements in an accessor.
pub(super) fn count(root: &Part<'_>, reference: &Part<'_>) -> Result<u64, MeshProblem> {
    let (_, accessor) = root.named("accessors", reference)?;
    accessor.needed("count")?.as_whole()
}

/// Does an accessor have data, rather than zeros or data of an extension?
pub(super) fn has_data(root: &Part<'_>, reference: &Part<'_>) -> Result<bool, MeshProblem> {
    let (_, accessor) = root.named("accessors", reference)?;
    Ok(accessor.get("bufferView").is_some() || accessor.get("sparse").is_some())
}

struct Accessor<'a> {
    part: Part<'a>,
    /// The place of the reference to it, and its own.
    place: String,
    component: ComponentType,
    normalized: bool,
    count: u64,
}

impl<'a> Accessor<'a> {
    fn new(buffers: &Buffers<'a>, reference: &Part<'_>) -> Result<Self, MeshProblem> {
        let (_, part) = buffers.root.named("accessors", reference)?;
        Ok(Self {
            place: format!("{} ({})", reference.place, part.place),
            component: component(&part.needed("componentType")?)?,
            normalized: part.get("normalized").is_some_and(|part| part.is_true()),
            count: part.needed("count")?.as_whole()?,
            part,
        })
    }

    fn should_hold(&self, what: &str) -> MeshProblem {
        let component = self.component.as_gl_enum();
        damaged(format!(
            "{} should hold {what}, and its component type is {component}",
            self.place
        ))
    }

    /// All elements, their components read from bytes.
    fn read<T: Copy + Default, const N: usize>(
        &self,
        buffers: &mut Buffers<'_>,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<[T; N]>, MeshProblem> {
        let kind = self.part.needed("type")?.as_text()?;
        let expected = kind_of::<N>();
        if kind != expected {
            let kind = shortened(kind, 20);
            return Err(damaged(format!(
                "{} should be of the type {expected}, and is `{kind}`",
                self.place
            )));
        }
        let component = self.component.size();
        let size = N * component;
        let decode_all = |bytes: Strided<'_>| -> Vec<[T; N]> {
            let element = |bytes: &[u8]| {
                let mut values = [T::default(); N];
                for (value, bytes) in values.iter_mut().zip(bytes.chunks(component)) {
                    *value = decode(bytes);
                }
                values
            };
            bytes.iter().map(element).collect()
        };
        let mut elements = if let Some(view) = self.part.get("bufferView") {
            let span = Span {
                place: &self.place,
                offset: self.part.whole("byteOffset")?.unwrap_or(0),
                count: self.count,
                size,
            };
            decode_all(span.of(buffers, &view)?)
        } else if self.part.get("sparse").is_none() {
            return Err(damaged(format!("{} has no data", self.place)));
        } else if self.count.saturating_mul(N as u64) > MOST_ZEROS {
            return Err(damaged(format!(
                "{} claims {} elements without data",
                self.place, self.count
            )));
        } else {
            vec![[T::default(); N]; self.count as usize]
        };
        buffers.spend(2 * LOOKUP + numbers(&elements))?;
        if let Some(sparse) = self.part.get("sparse") {
            self.replace(buffers, &sparse, size, &mut elements, decode_all)?;
        }
        Ok(elements)
    }

    /// Puts the values of a sparse accessor in their places.
    fn replace<T: Copy, const N: usize>(
        &self,
        buffers: &mut Buffers<'_>,
        sparse: &Part<'_>,
        size: usize,
        elements: &mut [[T; N]],
        decode_all: impl Fn(Strided<'_>) -> Vec<[T; N]>,
    ) -> Result<(), MeshProblem> {
        let (indices, values) = (sparse.needed("indices")?, sparse.needed("values")?);
        let kind = indices.needed("componentType")?;
        let index_size = match component(&kind)? {
            ComponentType::U8 => 1,
            ComponentType::U16 => 2,
            ComponentType::U32 => 4,
            _ => return Err(kind.should_be("5121, 5123 or 5125")),
        };
        let count = sparse.needed("count")?.as_whole()?;
        let span = |part: &Part<'_>, size: usize| -> Result<Span<'_>, MeshProblem> {
            Ok(Span {
                place: &self.place,
                offset: part.whole("byteOffset")?.unwrap_or(0),
                count,
                size,
            })
        };
        let places = span(&indices, index_size)?.of(buffers, &indices.needed("bufferView")?)?;
        let places: Vec<u32> = places.iter().map(little_endian).collect();
        buffers.spend(places.len() as u64)?;
        let new = decode_all(span(&values, size)?.of(buffers, &values.needed("bufferView")?)?);
        buffers.spend(numbers(&new))?;
        let length = elements.len();
        for (at, value) in places.into_iter().zip(new) {
            let Some(element) = elements.get_mut(at as usize) else {
                return Err(damaged(format!(
                    "{} has a sparse value for element {at}, of {length}",
                    self.place
                )));
            };
            *element = value;
        }
        Ok(())
    }
}

fn numbers<T, const N: usize>(elements: &[[T; N]]) -> u64 {
    elements.as_flattened().len() as u64
}

/// An unsigned number of one, two or four bytes.
fn little_endian(bytes: &[u8]) -> u32 {
    match *bytes {
        [a] => u32::from(a),
        [a, b] => u32::from(u16::from_le_bytes([a, b])),
        [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
        _ => 0,
    }
}

fn component(part: &Part<'_>) -> Result<ComponentType, MeshProblem> {
    Ok(match u32::try_from(part.as_whole()?) {
        Ok(BYTE) => ComponentType::I8,
        Ok(UNSIGNED_BYTE) => ComponentType::U8,
        Ok(SHORT) => ComponentType::I16,
        Ok(UNSIGNED_SHORT) => ComponentType::U16,
        Ok(UNSIGNED_INT) => ComponentType::U32,
        Ok(FLOAT) => ComponentType::F32,
        _ => return Err(part.should_be("one of glTF's component types (5120 to 5126)")),
    })
}

/// The glTF name of elements with `N` components.
const fn kind_of<const N: usize>() -> &'static str {
    match N {
        1 => "SCALAR",
        2 => "VEC2",
        3 => "VEC3",
        4 => "VEC4",
        _ => "MAT4",
    }
}

/// How the elements of an accessor lie in a buffer view.
struct Span<'p> {
    place: &'p str,
    offset: u64,
    count: u64,
    size: usize,
}

impl Span<'_> {
    /// The bytes of the elements, after a check that the buffer has them all.
    fn of<'b>(
        &self,
        buffers: &'b mut Buffers<'_>,
        view: &Part<'_>,
    ) -> Result<Strided<'b>, MeshProblem> {
        let place = self.place;
        let (_, view) = buffers.root.named("bufferViews", view)?;
        let stride = match view.whole("byteStride")? {
            None | Some(0) => self.size,
            Some(stride) => usize::try_from(stride).unwrap_or(usize::MAX),
        };
        if stride < self.size {
            return Err(damaged(format!("{place} has elements that overlap")));
        }
        let view_offset = view.whole("byteOffset")?.unwrap_or(0);
        let view_length = view.needed("byteLength")?.as_whole()?;
        let buffer = buffers.of_view(&view)?;
        let in_view = |length: &u64| {
            let end = self.offset.checked_add(*length);
            end.is_some_and(|end| end <= view_length)
        };
        // The last element needs no whole stride.
        let length = match self.count {
            0 => Some(0),
            count => (count - 1)
                .checked_mul(stride as u64)
                .and_then(|length| length.checked_add(self.size as u64)),
        };
        let begin = view_offset.checked_add(self.offset);
        let range = length
            .filter(in_view)
            .zip(begin)
            .and_then(|(length, begin)| {
                let end = begin.checked_add(length)?;
                Some(usize::try_from(begin).ok()?..usize::try_from(end).ok()?)
            });
        let there = buffer.bytes.len();
        match range.and_then(|range| buffer.bytes.get(range)) {
            Some(bytes) => Ok(Strided {
                bytes,
                stride,
                size: self.size,
            }),
            None if (there as u64) < buffer.length => Err(damaged(format!(
                "{} should have {} bytes, and has {there}",
                buffer.place, buffer.length
            ))),
            None => Err(damaged(format!(
                "{place} has {} elements of {} bytes, more than {} holds ({view_length} bytes of a buffer of {there})",
                self.count, self.size, view.place
            ))),
        }
    }
}

/// Elements at equal distances; the slice ends with the last one.
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl<'a> Strided<'a> {
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let size = self.size;
        self.bytes
            .chunks(self.stride)
            .map(move |element| &element[..size])
    }
}

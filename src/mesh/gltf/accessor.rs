//! Numbers out of glTF accessors. Nothing that a file says about sizes is believed: every range is checked before it is
//! read, and before memory is taken for it.

use gltf::json::accessor::{Accessor, ComponentType};
use gltf::json::validation::Checked;

use super::resource::Buffers;
use super::{damaged, get};
use crate::mesh::error::MeshProblem;

/// A sparse accessor without a base is zeros, which a file gets for nothing; this many at most.
const MOST_ZEROS: u64 = 1 << 24;

/// The vertex numbers of an index accessor.
pub(super) fn indices(buffers: &mut Buffers<'_>, index: usize) -> Result<Vec<u32>, MeshProblem> {
    let decode = |component: ComponentType, _: bool, bytes: &[u8]| match component {
        ComponentType::U8 => Some(u32::from(bytes[0])),
        ComponentType::U16 => Some(u32::from(u16::from_le_bytes(*bytes.first_chunk()?))),
        ComponentType::U32 => Some(u32::from_le_bytes(*bytes.first_chunk()?)),
        _ => None,
    };
    let elements = read::<u32, 1>(buffers, index, "vertex numbers", decode)?;
    Ok(elements.into_iter().map(|[index]| index).collect())
}

/// Vectors of floats. Small integers are taken too (`KHR_mesh_quantization`), as fractions where they are normalized.
pub(super) fn vectors<const N: usize>(
    buffers: &mut Buffers<'_>,
    index: usize,
) -> Result<Vec<[f32; N]>, MeshProblem> {
    let decode = |component: ComponentType, normalized: bool, bytes: &[u8]| {
        let (value, most) = match component {
            ComponentType::F32 => return Some(f32::from_le_bytes(*bytes.first_chunk()?)),
            ComponentType::I8 => (f32::from(bytes[0].cast_signed()), 127.0),
            ComponentType::U8 => (f32::from(bytes[0]), 255.0),
            ComponentType::I16 => (
                f32::from(i16::from_le_bytes(*bytes.first_chunk()?)),
                32_767.0,
            ),
            ComponentType::U16 => (
                f32::from(u16::from_le_bytes(*bytes.first_chunk()?)),
                65_535.0,
            ),
            ComponentType::U32 => return None,
        };
        Some(if normalized {
            (value / most).max(-1.0)
        } else {
            value
        })
    };
    read(buffers, index, "vertex attributes", decode)
}

/// Reads one component: its type, whether it is normalized, its bytes. `None` for types that do not fit.
trait Decode<T>: Fn(ComponentType, bool, &[u8]) -> Option<T> {}
impl<T, F: Fn(ComponentType, bool, &[u8]) -> Option<T>> Decode<T> for F {}

fn read<T: Copy + Default, const N: usize>(
    buffers: &mut Buffers<'_>,
    index: usize,
    what: &str,
    decode: impl Decode<T>,
) -> Result<Vec<[T; N]>, MeshProblem> {
    let accessor = get(&buffers.root.accessors, index, "accessor")?;
    let component = component_of::<N>(accessor, index, what)?;
    let place = format!("accessor {index}");
    let decode_all = |bytes: Strided<'_>| -> Result<Vec<[T; N]>, MeshProblem> {
        let elements: Option<Vec<[T; N]>> = bytes
            .iter()
            .map(|element| {
                let mut values = [T::default(); N];
                for (value, bytes) in values.iter_mut().zip(element.chunks(component.size())) {
                    *value = decode(component, accessor.normalized, bytes)?;
                }
                Some(values)
            })
            .collect();
        elements.ok_or_else(|| damaged(format!("{place} holds no {what}, by its component type")))
    };
    let size = N * component.size();
    let mut elements = match accessor.buffer_view {
        Some(view) => {
            let offset = accessor.byte_offset.unwrap_or_default().0;
            let span = Span {
                view: view.value(),
                offset,
                count: accessor.count.0,
                size,
            };
            decode_all(span.of(buffers, &place)?)?
        }
        None if accessor.sparse.is_none() => {
            return Err(damaged(format!(
                "{place} has no data (is the model compressed?)"
            )));
        }
        None if accessor.count.0 > MOST_ZEROS => {
            let count = accessor.count.0;
            return Err(damaged(format!(
                "{place} claims {count} elements without data"
            )));
        }
        None => vec![[T::default(); N]; accessor.count.0 as usize],
    };
    if let Some(sparse) = &accessor.sparse {
        let Checked::Valid(index_component) = sparse.indices.component_type else {
            return Err(damaged(format!("{place} has unknown sparse indices")));
        };
        let places = Span {
            view: sparse.indices.buffer_view.value(),
            offset: sparse.indices.byte_offset.0,
            count: sparse.count.0,
            size: index_component.0.size(),
        };
        let places: Vec<u32> = places
            .of(buffers, &place)?
            .iter()
            .map(little_endian)
            .collect();
        let values = Span {
            view: sparse.values.buffer_view.value(),
            offset: sparse.values.byte_offset.0,
            count: sparse.count.0,
            size,
        };
        let values = decode_all(values.of(buffers, &place)?)?;
        for (at, value) in places.into_iter().zip(values) {
            let Some(element) = elements.get_mut(at as usize) else {
                return Err(damaged(format!(
                    "{place} has a sparse value for element {at}, of {}",
                    elements.len()
                )));
            };
            *element = value;
        }
    }
    Ok(elements)
}

/// An unsigned number of up to four bytes.
fn little_endian(bytes: &[u8]) -> u32 {
    bytes
        .iter()
        .rev()
        .fold(0, |value, &byte| value << 8 | u32::from(byte))
}

fn component_of<const N: usize>(
    accessor: &Accessor,
    index: usize,
    what: &str,
) -> Result<ComponentType, MeshProblem> {
    match (&accessor.type_, &accessor.component_type) {
        (Checked::Valid(kind), Checked::Valid(component)) if kind.multiplicity() == N => {
            Ok(component.0)
        }
        _ => Err(damaged(format!(
            "accessor {index} holds no {what}: they have {N} components"
        ))),
    }
}

/// Where the elements of an accessor lie.
struct Span {
    view: usize,
    offset: u64,
    count: u64,
    size: usize,
}

impl Span {
    /// The bytes of the elements, after a check that the buffer has them all.
    fn of<'b>(
        &self,
        buffers: &'b mut Buffers<'_>,
        place: &str,
    ) -> Result<Strided<'b>, MeshProblem> {
        let view = get(&buffers.root.buffer_views, self.view, "buffer view")?;
        let stride = view.byte_stride.map_or(self.size, |stride| stride.0);
        if stride < self.size {
            return Err(damaged(format!("{place} has elements that overlap")));
        }
        let view_offset = view.byte_offset.unwrap_or_default().0;
        let view_length = view.byte_length.0;
        let buffer = buffers.bytes(view.buffer.value())?;
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
        match range.and_then(|range| buffer.get(range)) {
            Some(bytes) => Ok(Strided {
                bytes,
                stride,
                size: self.size,
            }),
            None => Err(damaged(format!(
                "{place} has {} elements of {} bytes, more than buffer view {} holds ({view_length} bytes of a buffer of {})",
                self.count,
                self.size,
                self.view,
                buffer.len()
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

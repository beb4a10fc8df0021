//! The values of a PLY file, after its header.

use super::{Element, Encoding, Header, Kind};
use crate::mesh::error::MeshProblem;
use crate::mesh::text::{bad_number, beginning};

/// The values behind the header, one after the other. In text, lines have no meaning, except in [`Values::of_rows`].
pub(super) struct Values<'a> {
    pub(super) encoding: Encoding,
    bytes: &'a [u8],
    at: usize,
    line: usize,
    /// Each element has a line of its own.
    has_rows: bool,
    /// Lines that continue behind the last value of their element.
    pub(super) longer_rows: usize,
}

impl<'a> Values<'a> {
    pub(super) fn new(header: &Header, bytes: &'a [u8]) -> Self {
        Self {
            encoding: header.encoding,
            bytes,
            at: header.bytes,
            line: header.lines + 1,
            has_rows: false,
            longer_rows: 0,
        }
    }

    /// The values of text that has as many lines as elements, for files that are invalid otherwise: MeshLab once wrote
    /// faces with more values than its header named.
    pub(super) fn of_rows(header: &Header, bytes: &'a [u8]) -> Option<Self> {
        if header.encoding != Encoding::Text {
            return None;
        }
        let filled = header.elements.iter().filter(|e| !e.properties.is_empty());
        let elements: u128 = filled.map(|element| u128::from(element.count)).sum();
        let lines = bytes[header.bytes..].split(|&byte| is_line_end(byte));
        let lines = lines.filter(|line| !line.trim_ascii().is_empty()).count();
        (elements == lines as u128).then(|| Self {
            has_rows: true,
            ..Self::new(header, bytes)
        })
    }
}

fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

impl Values<'_> {
    /// The next number, `None` at the end of the file. In double precision all but the largest 64-bit integers are exact.
    fn next(&mut self, kind: Kind) -> Result<Option<f64>, MeshProblem> {
        match self.encoding {
            Encoding::Text => self.next_word(),
            Encoding::Little => Ok(self.next_bytes(kind, false)),
            Encoding::Big => Ok(self.next_bytes(kind, true)),
        }
    }

    fn next_bytes(&mut self, kind: Kind, is_big: bool) -> Option<f64> {
        let size = kind.size();
        let mut bytes = [0; 8];
        bytes[..size].copy_from_slice(self.bytes.get(self.at..)?.get(..size)?);
        self.at += size;
        if is_big {
            bytes[..size].reverse();
        }
        let [a, b, c, d, ..] = bytes;
        Some(match kind {
            Kind::I8 => i8::from_le_bytes([a]).into(),
            Kind::U8 => a.into(),
            Kind::I16 => i16::from_le_bytes([a, b]).into(),
            Kind::U16 => u16::from_le_bytes([a, b]).into(),
            Kind::I32 => i32::from_le_bytes([a, b, c, d]).into(),
            Kind::U32 => u32::from_le_bytes([a, b, c, d]).into(),
            Kind::I64 => i64::from_le_bytes(bytes) as f64,
            Kind::U64 => u64::from_le_bytes(bytes) as f64,
            Kind::F32 => f32::from_le_bytes([a, b, c, d]).into(),
            Kind::F64 => f64::from_le_bytes(bytes),
        })
    }

    /// Is there nothing left but white space?
    pub(super) fn is_at_end(&self) -> bool {
        self.bytes[self.at..].iter().all(u8::is_ascii_whitespace)
    }

    /// Goes to the next line that is not blank, and returns where it ends.
    fn row(&mut self) -> usize {
        let rest = &self.bytes[self.at..];
        let blank = rest.iter().take_while(|byte| byte.is_ascii_whitespace());
        self.at += blank.count();
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|&byte| is_line_end(byte));
        self.at + end.unwrap_or(rest.len())
    }

    fn next_word(&mut self) -> Result<Option<f64>, MeshProblem> {
        while let Some(byte) = self.bytes.get(self.at)
            && byte.is_ascii_whitespace()
        {
            // CR alone ends a line, too.
            let ends_line = match byte {
                b'\n' => true,
                b'\r' => self.bytes.get(self.at + 1) != Some(&b'\n'),
                _ => false,
            };
            self.line += usize::from(ends_line);
            self.at += 1;
        }
        let rest = &self.bytes[self.at..];
        let length = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        if length == 0 {
            return Ok(None);
        }
        let word = &rest[..length];
        let number = str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        let number = number.ok_or_else(|| {
            let word = String::from_utf8_lossy(&word[..length.min(100)]);
            bad_number(self.line, "not a number", &word)
        })?;
        self.at += length;
        Ok(Some(number))
    }

    /// One number of an element.
    fn number(&mut self, kind: Kind, element: &Element, index: u64) -> Result<f64, MeshProblem> {
        self.next(kind)?.ok_or_else(|| {
            MeshProblem::Damaged(format!(
                "the header counts {} elements `{}`, and the file ends in number {index}, at byte {}",
                element.count,
                beginning(&element.name),
                self.bytes.len()
            ))
        })
    }

    /// How many numbers a list holds.
    fn length(&mut self, kind: Kind, element: &Element, index: u64) -> Result<u64, MeshProblem> {
        let length = self.number(kind, element, index)?;
        if !(length >= 0.0 && length.fract() == 0.0) {
            return Err(MeshProblem::Damaged(format!(
                "a list of element `{}` number {index} has the length {length}",
                beginning(&element.name)
            )));
        }
        Ok(length as u64)
    }

    /// Reads one element: single numbers into `numbers`, by property, and the lists with the given places.
    pub(super) fn read(
        &mut self,
        element: &Element,
        index: u64,
        numbers: &mut Vec<f64>,
        lists: &mut [(Option<usize>, &mut Vec<f64>)],
    ) -> Result<(), MeshProblem> {
        numbers.clear();
        let row = self.has_rows.then(|| self.row());
        for (place, property) in element.properties.iter().enumerate() {
            let Some(length) = property.length else {
                numbers.push(self.number(property.kind, element, index)?);
                continue;
            };
            numbers.push(0.0);
            let length = self.length(length, element, index)?;
            let mut list = lists
                .iter_mut()
                .find(|(wanted, _)| *wanted == Some(place))
                .map(|(_, list)| &mut **list);
            if let Some(list) = &mut list {
                list.clear();
            }
            for _ in 0..length {
                let number = self.number(property.kind, element, index)?;
                if let Some(list) = &mut list {
                    list.push(number);
                }
            }
        }
        if let Some(end) = row {
            if self.at > end {
                return Err(MeshProblem::Damaged(format!(
                    "line {} has too few values",
                    self.line
                )));
            }
            let rest = self.bytes[self.at..end].trim_ascii();
            self.longer_rows += usize::from(!rest.is_empty());
            self.at = end;
        }
        Ok(())
    }

    /// Skips an element and all others of its kind.
    pub(super) fn skip_all(&mut self, element: &Element) -> Result<(), MeshProblem> {
        // Without properties there is nothing to skip, however many there are.
        if element.properties.is_empty() {
            return Ok(());
        }
        let left = self.bytes.len() - self.at;
        if let Some(size) = element.size()
            && self.encoding != Encoding::Text
            && let Ok(count) = usize::try_from(element.count)
            && let Some(bytes) = count.checked_mul(size).filter(|&bytes| bytes <= left)
        {
            self.at += bytes;
            return Ok(());
        }
        let mut numbers = Vec::new();
        for index in 0..element.count {
            self.read(element, index, &mut numbers, &mut [])?;
        }
        Ok(())
    }
}

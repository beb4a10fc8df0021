//! Reads the arrays of an `.npz`, for tests: each with its type and shape checked.

use std::collections::BTreeMap;
use std::io::{Cursor, Read as _};

use bytemuck::Pod;

/// The files of an archive, by name without ending.
pub struct Arrays(BTreeMap<String, Vec<u8>>);

impl Arrays {
    pub fn read(bytes: &[u8]) -> Self {
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).expect("it is a zip archive");
        let mut files = BTreeMap::new();
        for i in 0..archive.len() {
            let mut file = archive.by_index(i).expect("it is listed");
            let mut content = Vec::new();
            file.read_to_end(&mut content).expect("it is whole");
            let name = file.name().expect("it is text");
            let name = name.strip_suffix(".npy").expect("arrays end so");
            files.insert(name.to_owned(), content);
        }
        Self(files)
    }

    pub fn names(&self) -> Vec<String> {
        self.0.keys().cloned().collect()
    }

    /// The header and the elements.
    fn split(&self, name: &str) -> (&str, &[u8]) {
        let bytes = self
            .0
            .get(name)
            .unwrap_or_else(|| panic!("there is no {name}"));
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00", "{name}");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + length) % 64, 0, "{name}");
        let header = std::str::from_utf8(&bytes[10..10 + length]).expect("it is text");
        assert!(header.ends_with('\n'), "{name}");
        (header.trim_end(), &bytes[10 + length..])
    }

    /// All elements of an array of this type and shape.
    #[track_caller]
    pub fn all<T: Pod>(&self, name: &str, kind: &str, shape: &[usize]) -> Vec<T> {
        let (header, bytes) = self.split(name);
        let sides: String = shape.iter().map(|side| format!("{side}, ")).collect();
        let expected =
            format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({sides}), }}");
        assert_eq!(header, expected, "{name}");
        bytemuck::pod_collect_to_vec(bytes)
    }

    /// The texts of an array.
    #[track_caller]
    pub fn text(&self, name: &str) -> Vec<String> {
        let (header, bytes) = self.split(name);
        let kind = header.split('\'').nth(3).expect("it has a type");
        let length: usize = kind
            .strip_prefix("<U")
            .expect("texts")
            .parse()
            .expect("a length");
        let characters: Vec<u32> = bytemuck::pod_collect_to_vec(bytes);
        let texts = characters.chunks(length).map(|characters| {
            let characters = characters
                .iter()
                .map(|&c| char::from_u32(c).expect("Unicode"));
            characters
                .collect::<String>()
                .trim_end_matches('\0')
                .to_owned()
        });
        texts.collect()
    }
}

//! The file of a checkpoint, taken apart and put together again with the right checksum.

use std::ops::Range;

use serde_json::{Value, json};

/// Words of 32 bits in an element of each list, in the order of the file, and the header's key for the number of elements.
pub const LISTS: [(&str, usize); 15] = [
    ("particles", 4),
    ("particles", 4),
    ("texels", 1),
    ("texels", 1),
    ("windows", 2),
    ("in_flight", 16),
    ("", 14),
    ("flux", 1),
    ("last_poses", 12),
    ("distance_poses", 12),
    ("kept_pairs", 16),
    ("bias", 1),
    ("foods", 1),
    ("pulses", 10),
    ("looks", 1),
];
pub const PARTICLES: usize = 0;
pub const MOTIONS: usize = 1;
pub const TRAIL: usize = 2;
pub const DEPOSITS: usize = 3;
pub const WINDOWS: usize = 4;
const IN_FLIGHT: usize = 5;
pub const FLOW: usize = 6;
pub const LAST_POSES: usize = 8;
pub const DISTANCE_POSES: usize = 9;
pub const KEPT_PAIRS: usize = 10;
pub const BIAS: usize = 11;
pub const FOODS: usize = 12;
pub const PULSES: usize = 13;
pub const LOOKS: usize = 14;

/// The parts of a checkpoint's file.
#[derive(Clone)]
pub struct Parts {
    pub header: Value,
    pub lists: Vec<Vec<u32>>,
}

impl Parts {
    pub fn of(file: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        let end = 16 + word(12) as usize;
        let header: Value = serde_json::from_slice(&file[16..end]).unwrap();
        let mut at = end;
        let lists = LISTS.map(|(key, words)| {
            let length = header[key].as_u64().unwrap_or(1) as usize * words;
            let list = (0..length).map(|i| word(at + 4 * i)).collect();
            at += 4 * length;
            list
        });
        assert_eq!(at + 4, file.len(), "the lists are those of the file");
        Self {
            header,
            lists: lists.to_vec(),
        }
    }

    /// The file with the right checksum.
    pub fn bytes(&self) -> Vec<u8> {
        let header = serde_json::to_vec(&self.header).unwrap();
        let mut bytes = b"MYXOCKPT\x07\0\0\0".to_vec();
        bytes.extend((header.len() as u32).to_le_bytes());
        bytes.extend(header);
        let words = self.lists.iter().flatten();
        bytes.extend(words.flat_map(|word| word.to_le_bytes()));
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes
    }

    /// Makes the header count what is there.
    pub fn count(&mut self) {
        for ((key, words), list) in LISTS.iter().zip(&self.lists) {
            if !key.is_empty() {
                self.header[*key] = json!(list.len() / words);
            }
        }
    }

    pub fn fill(&mut self, list: usize, words: Range<usize>, with: u32) {
        self.lists[list][words].fill(with);
    }

    pub fn fill_all(&mut self, list: usize, with: f32) {
        self.lists[list].fill(with.to_bits());
    }

    /// Sets a word of an element.
    pub fn set(&mut self, list: usize, element: usize, word: usize, with: u32) {
        let index = element * LISTS[list].1 + word;
        self.lists[list][index] = with;
    }

    /// A particle of the first object is in flight to the second one, the first of its window. Some words of its transfer are
    /// as they are given.
    pub fn fly(&mut self, words: Range<usize>, with: f32) {
        const SELECTED: usize = 11;
        let [first, second] = [0, 2].map(|window| self.lists[WINDOWS][window]);
        let triangle = self.lists[PARTICLES][4 * second as usize];
        self.lists[MOTIONS][4 * first as usize + 3] |= 1;
        self.lists[FLOW][SELECTED] += 1;
        let [zero, one] = [0.0_f32, 1.0].map(f32::to_bits);
        // Place, its slot; heading, source; normal, target; triangle, length left to walk.
        let mut transfer = vec![
            zero, zero, zero, first, one, zero, zero, 0, zero, one, zero, 1, triangle, zero, 0, 0,
        ];
        transfer[words].fill(with.to_bits());
        self.lists[IN_FLIGHT] = transfer;
        self.count();
    }

    pub fn movement(&mut self, key: &str, value: f64) {
        self.header["movement"][key] = json!(value.to_bits());
    }
}

//! The JSON of a glTF file, read leniently: values are checked only when needed, and errors have their place in the file.

use std::borrow::Cow;
use std::fmt;

use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::{damaged, shortened};
use crate::mesh::error::MeshProblem;

/// The lists of a file that define its shapes and their places. Materials, images and the rest are skipped unread.
const READ: &[&str] = &[
    "accessors",
    "animations",
    "asset",
    "buffers",
    "bufferViews",
    "extensionsRequired",
    "meshes",
    "nodes",
    "scene",
    "scenes",
    "skins",
];

/// Members that never matter here; they may be large and contain anything.
const SKIPPED: &[&str] = &["extras", "max", "min", "name"];

/// A JSON value. Numbers are all `f64`, which is exact for every number that a sensible file has: some writers give
/// whole numbers a fraction (`5126.0`).
#[derive(Debug)]
pub(super) enum Json {
    Null,
    Bool(bool),
    Number(f64),
    Text(String),
    List(Vec<Json>),
    /// Members by their names, each name once.
    Object(Vec<(String, Json)>),
}

/// A JSON object of which only the members in [`READ`] are kept.
struct Document(Json);

/// Reads the JSON of a file. A byte order mark before it and whatever follows it are ignored.
pub(super) fn parse(bytes: &[u8]) -> Result<Json, MeshProblem> {
    let text: Cow<'_, str> = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let mut deserializer = serde_json::Deserializer::from_str(text);
    match Document::deserialize(&mut deserializer) {
        Ok(document) => Ok(document.0),
        Err(error) => {
            let error = error.to_string();
            let error = shortened(&error, 120);
            Err(damaged(format!(
                "the glTF description cannot be read: {error}"
            )))
        }
    }
}

struct JsonVisitor;

impl<'de> Visitor<'de> for JsonVisitor {
    type Value = Json;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_unit<E>(self) -> Result<Json, E> {
        Ok(Json::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Json, E> {
        Ok(Json::Bool(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Json, E> {
        Ok(Json::Number(value as f64))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Json, E> {
        Ok(Json::Number(value as f64))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Json, E> {
        Ok(Json::Number(value))
    }

    fn visit_str<E>(self, value: &str) -> Result<Json, E> {
        Ok(Json::Text(value.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Json, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = items.next_element()? {
            list.push(item);
        }
        Ok(Json::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, members: A) -> Result<Json, A::Error> {
        object(members, |key| !SKIPPED.contains(&key))
    }
}

impl<'de> Deserialize<'de> for Json {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(JsonVisitor)
    }
}

struct DocumentVisitor;

impl<'de> Visitor<'de> for DocumentVisitor {
    type Value = Document;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON object")
    }

    fn visit_map<A: MapAccess<'de>>(self, members: A) -> Result<Document, A::Error> {
        object(members, |key| READ.contains(&key)).map(Document)
    }
}

impl<'de> Deserialize<'de> for Document {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(DocumentVisitor)
    }
}

fn object<'de, A: MapAccess<'de>>(
    mut members: A,
    is_read: impl Fn(&str) -> bool,
) -> Result<Json, A::Error> {
    let mut object = Vec::new();
    while let Some(key) = members.next_key::<String>()? {
        if is_read(&key) {
            object.push((key, members.next_value()?));
        } else {
            members.next_value::<IgnoredAny>()?;
        }
    }
    // Of repeated keys the last one counts, as in most readers of JSON.
    object.reverse();
    object.sort_by(|(a, _), (b, _)| a.cmp(b));
    object.dedup_by(|(later, _), (kept, _)| later == kept);
    Ok(Json::Object(object))
}

/// A value, and its place in the file: `meshes[3].primitives[0].attributes.POSITION`.
#[derive(Clone, Debug)]
pub(super) struct Part<'a> {
    json: &'a Json,
    pub(super) place: String,
}

impl<'a> Part<'a> {
    pub(super) fn root(json: &'a Json) -> Self {
        Self {
            json,
            place: String::new(),
        }
    }

    /// A member of an object. Null counts as missing, as does every member of what is no object.
    pub(super) fn get(&self, key: &str) -> Option<Self> {
        let Json::Object(members) = self.json else {
            return None;
        };
        let index = members.binary_search_by(|(name, _)| name.as_str().cmp(key));
        let (_, json) = &members[index.ok()?];
        (!matches!(json, Json::Null)).then(|| Self {
            json,
            place: self.place_of(key),
        })
    }

    /// A member's member, and so on.
    pub(super) fn at(&self, keys: &[&str]) -> Option<Self> {
        keys.iter()
            .try_fold(self.clone(), |part, key| part.get(key))
    }

    /// The names of an object's members.
    pub(super) fn keys(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        let members = match self.json {
            Json::Object(members) => members.as_slice(),
            _ => &[],
        };
        members.iter().map(|(key, _)| key.as_str())
    }

    /// The JSON path of a member, existing or not.
    pub(super) fn place_of(&self, key: &str) -> String {
        let key = shortened(key, 60);
        if self.place.is_empty() {
            key
        } else {
            format!("{}.{key}", self.place)
        }
    }

    fn values(&self, key: &str) -> Result<&'a [Json], MeshProblem> {
        match self.get(key) {
            None => Ok(&[]),
            Some(part) => match part.json {
                Json::List(list) => Ok(list),
                _ => Err(part.should_be("a list")),
            },
        }
    }

    /// How many items a member that is a list has; none if it is missing.
    pub(super) fn count(&self, key: &str) -> Result<usize, MeshProblem> {
        Ok(self.values(key)?.len())
    }

    /// The items of a member that is a list.
    pub(super) fn items(
        &self,
        key: &str,
    ) -> Result<impl DoubleEndedIterator<Item = Self> + use<'a>, MeshProblem> {
        let place = self.place_of(key);
        let items = self.values(key)?.iter().enumerate();
        Ok(items.map(move |(index, json)| Self {
            json,
            place: format!("{place}[{index}]"),
        }))
    }

    /// One item of a member that is a list.
    pub(super) fn item(&self, key: &str, index: usize) -> Result<Option<Self>, MeshProblem> {
        Ok(self.values(key)?.get(index).map(|json| Self {
            json,
            place: format!("{}[{index}]", self.place_of(key)),
        }))
    }

    /// The target of a reference: the number of an item in one of the root's lists.
    pub(super) fn named(
        &self,
        list: &str,
        reference: &Part<'_>,
    ) -> Result<(usize, Self), MeshProblem> {
        let index = reference.as_whole()?;
        let item = match usize::try_from(index) {
            Ok(at) => self.item(list, at)?.map(|item| (at, item)),
            Err(_) => None,
        };
        match item {
            Some(item) => Ok(item),
            None => {
                let what = match list {
                    "meshes" => "mesh",
                    "bufferViews" => "buffer view",
                    other => other.trim_end_matches('s'),
                };
                let count = self.count(list)?;
                let place = &reference.place;
                Err(damaged(format!(
                    "{place} names {what} {index}, and the file has {count}"
                )))
            }
        }
    }

    pub(super) fn as_number(&self) -> Result<f64, MeshProblem> {
        match self.json {
            Json::Number(number) => Ok(*number),
            _ => Err(self.should_be("a number")),
        }
    }

    /// A whole number that is not negative.
    pub(super) fn as_whole(&self) -> Result<u64, MeshProblem> {
        match self.json {
            Json::Number(number) if *number >= 0.0 && number.fract() == 0.0 => Ok(*number as u64),
            _ => Err(self.should_be("a whole number from 0")),
        }
    }

    pub(super) fn as_text(&self) -> Result<&'a str, MeshProblem> {
        match self.json {
            Json::Text(text) => Ok(text),
            _ => Err(self.should_be("text")),
        }
    }

    pub(super) fn is_false(&self) -> bool {
        matches!(self.json, Json::Bool(false))
    }

    pub(super) fn is_true(&self) -> bool {
        matches!(self.json, Json::Bool(true))
    }

    /// A member that is a whole number.
    pub(super) fn whole(&self, key: &str) -> Result<Option<u64>, MeshProblem> {
        self.get(key).map(|part| part.as_whole()).transpose()
    }

    /// A member that must be there.
    pub(super) fn needed(&self, key: &str) -> Result<Self, MeshProblem> {
        self.get(key)
            .ok_or_else(|| damaged(format!("{} is missing", self.place_of(key))))
    }

    /// A member that is a list of numbers.
    pub(super) fn numbers(&self, key: &str) -> Result<Vec<f64>, MeshProblem> {
        let number = |(index, json): (usize, &Json)| match json {
            Json::Number(number) => Ok(*number),
            _ => {
                let place = format!("{}[{index}]", self.place_of(key));
                Part { json, place }.as_number()
            }
        };
        self.values(key)?.iter().enumerate().map(number).collect()
    }

    /// A member that is a list of so many numbers.
    pub(super) fn array<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>, MeshProblem> {
        let Some(part) = self.get(key) else {
            return Ok(None);
        };
        match self.numbers(key)?.try_into() {
            Ok(array) => Ok(Some(array)),
            Err(_) => Err(part.should_be(&format!("{N} numbers"))),
        }
    }

    /// The problem that this value is not what is expected here.
    pub(super) fn should_be(&self, expected: &str) -> MeshProblem {
        let found = match self.json {
            Json::Null => "null".to_owned(),
            Json::Bool(value) => value.to_string(),
            Json::Number(number) => number.to_string(),
            Json::Text(text) => format!("`{}`", shortened(text, 60)),
            Json::List(list) => format!("a list of {}", list.len()),
            Json::Object(_) => "an object".to_owned(),
        };
        damaged(format!("{} is {found}, not {expected}", self.place))
    }
}

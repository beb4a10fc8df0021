//! Rows as a table, in the formats of spreadsheets and of data frames.

use std::sync::Arc;

use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use serde_json::Value;

use super::row::Row;
use crate::error::{Error, Result};

/// The first and the last columns; between them are parameters and measures.
const FIRST: &[&str] = &["run", "seed"];
const LAST: &[&str] = &[
    "step",
    "state_hash",
    "seconds",
    "device",
    "commit",
    "error",
    "key",
];

/// What the values of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Truth,
    Whole,
    Number,
    Text,
}

/// Columns with a value, or null, for each row.
#[derive(Debug)]
pub struct Table {
    rows: usize,
    columns: Vec<Column>,
}

#[derive(Debug)]
struct Column {
    name: String,
    kind: Kind,
    values: Vec<Value>,
}

impl Table {
    /// The table of some rows.
    pub fn of(rows: &[Row]) -> Self {
        let mut middle: Vec<&str> = Vec::new();
        let mut seen = std::collections::HashSet::new();
        for (name, _) in rows.iter().flat_map(|row| &row.0) {
            let name = name.as_str();
            if seen.insert(name) && !FIRST.contains(&name) && !LAST.contains(&name) {
                middle.push(name);
            }
        }
        let outer =
            |names: &'static [&str]| names.iter().copied().filter(|name| seen.contains(name));
        let names = outer(FIRST)
            .chain(middle.iter().copied())
            .chain(outer(LAST));
        let column = |name: &str| {
            let values: Vec<_> = rows
                .iter()
                .map(|row| row.get(name).cloned().unwrap_or(Value::Null))
                .collect();
            Column {
                name: name.to_owned(),
                kind: kind_of(&values),
                values,
            }
        };
        Self {
            rows: rows.len(),
            columns: names.map(column).collect(),
        }
    }

    /// As comma-separated values: a null is empty, numbers are as in JSON, and so are lists.
    pub fn csv(&self) -> Result<Vec<u8>> {
        let failed = |error: &dyn std::fmt::Display| {
            Error::Invalid(format!("cannot write a table: {error}"))
        };
        let mut writer = csv::Writer::from_writer(Vec::new());
        let write = |writer: &mut csv::Writer<Vec<u8>>, record: Vec<String>| {
            writer.write_record(record).map_err(|error| failed(&error))
        };
        write(
            &mut writer,
            self.columns
                .iter()
                .map(|column| column.name.clone())
                .collect(),
        )?;
        for row in 0..self.rows {
            let record = self
                .columns
                .iter()
                .map(|column| text_of(&column.values[row]).unwrap_or_default());
            write(&mut writer, record.collect())?;
        }
        writer.into_inner().map_err(|error| failed(&error))
    }

    /// As Parquet: truth values, whole numbers of 64 bits, doubles and texts, all of which may be null.
    pub fn parquet(&self) -> Result<Vec<u8>> {
        self.parquet_file()
            .map_err(|error| Error::Invalid(format!("cannot write a table: {error}")))
    }

    fn parquet_file(&self) -> Result<Vec<u8>, ParquetError> {
        let fields = self.columns.iter().map(Column::field);
        let schema = Type::group_type_builder("table")
            .with_fields(fields.collect::<Result<_, _>>()?)
            .build()?;
        let properties = Arc::new(WriterProperties::builder().build());
        let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), properties)?;
        let mut group = writer.next_row_group()?;
        for column in &self.columns {
            let mut part = group.next_column()?.expect("there is one for each column");
            column.write(&mut part)?;
            part.close()?;
        }
        group.close()?;
        writer.into_inner()
    }
}

impl Column {
    fn field(&self) -> Result<Arc<Type>, ParquetError> {
        let (physical, converted) = match self.kind {
            Kind::Truth => (Physical::BOOLEAN, ConvertedType::NONE),
            Kind::Whole => (Physical::INT64, ConvertedType::NONE),
            Kind::Number => (Physical::DOUBLE, ConvertedType::NONE),
            Kind::Text => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
        };
        let field = Type::primitive_type_builder(&self.name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_converted_type(converted);
        Ok(Arc::new(field.build()?))
    }

    fn write(&self, part: &mut SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        match self.kind {
            Kind::Truth => self.write_as::<BoolType>(part, Value::as_bool),
            Kind::Whole => self.write_as::<Int64Type>(part, Value::as_i64),
            Kind::Number => self.write_as::<DoubleType>(part, Value::as_f64),
            Kind::Text => self.write_as::<ByteArrayType>(part, |value| {
                text_of(value).map(|text| ByteArray::from(text.as_str()))
            }),
        }
    }

    fn write_as<T: DataType>(
        &self,
        part: &mut SerializedColumnWriter<'_>,
        of: impl Fn(&Value) -> Option<T::T>,
    ) -> Result<(), ParquetError> {
        let values: Vec<Option<T::T>> = self.values.iter().map(of).collect();
        let is_there: Vec<i16> = values.iter().map(|value| value.is_some().into()).collect();
        let there: Vec<T::T> = values.into_iter().flatten().collect();
        part.typed::<T>()
            .write_batch(&there, Some(&is_there), None)?;
        Ok(())
    }
}

/// The kind that has all of these values.
fn kind_of(values: &[Value]) -> Kind {
    let there = || values.iter().filter(|value| !value.is_null());
    if there().next().is_none() {
        Kind::Text
    } else if there().all(Value::is_boolean) {
        Kind::Truth
    } else if there().all(Value::is_i64) {
        Kind::Whole
    } else if there().all(Value::is_number) {
        Kind::Number
    } else {
        Kind::Text
    }
}

/// A value as a text, if it is not null.
fn text_of(value: &Value) -> Option<String> {
    match value {
        Value::Null => None,
        Value::String(text) => Some(text.clone()),
        other => Some(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use parquet::file::reader::{FileReader as _, SerializedFileReader};
    use parquet::record::RowAccessor as _;

    use super::*;

    fn table() -> Table {
        let row = |text: &str| serde_json::from_str(text).expect("it is JSON");
        Table::of(&[
            row(
                r#"{"run":0,"seed":3,"speed":1,"on":true,"error":null,"step":5,"length":1e-7,"color":[1.0,2.0]}"#,
            ),
            row(r#"{"run":1,"seed":3,"speed":2.5,"on":false,"error":"a \"b\", c","new":7}"#),
        ])
    }

    /// Catches columns that change their order by what the first run returned, and texts that break a line.
    #[test]
    fn columns_are_in_order_and_nulls_are_empty() {
        let text = String::from_utf8(table().csv().expect("it is made")).expect("it is UTF-8");
        assert_eq!(
            text,
            "run,seed,speed,on,length,color,new,step,error\n\
             0,3,1,true,1e-7,\"[1.0,2.0]\",,5,\n\
             1,3,2.5,false,,,7,,\"a \"\"b\"\", c\"\n"
        );
    }

    #[test]
    fn parquet_has_the_same_values() {
        let read = |content: Vec<u8>| {
            let mut file = tempfile::tempfile().expect("there is room");
            file.write_all(&content).expect("there is room");
            SerializedFileReader::new(file).expect("it is Parquet")
        };
        let reader = read(table().parquet().expect("it is made"));
        let rows: Vec<_> = reader
            .get_row_iter(None)
            .expect("it has rows")
            .map(|row| row.expect("it is one"))
            .collect();
        assert_eq!(rows.len(), 2);
        assert_eq!(
            (rows[0].get_long(0).ok(), rows[1].get_long(0).ok()),
            (Some(0), Some(1))
        );
        assert_eq!(
            (rows[0].get_double(2).ok(), rows[1].get_double(2).ok()),
            (Some(1.0), Some(2.5))
        );
        assert_eq!(
            (rows[0].get_bool(3).ok(), rows[1].get_bool(3).ok()),
            (Some(true), Some(false))
        );
        assert_eq!(
            rows[0].get_string(5).ok().map(String::as_str),
            Some("[1.0,2.0]")
        );
        assert!(rows[0].get_string(8).is_err(), "it is null");
        assert_eq!(
            rows[1].get_string(8).ok().map(String::as_str),
            Some("a \"b\", c")
        );
        let empty = read(Table::of(&[]).parquet().expect("it is made"));
        assert_eq!(empty.metadata().file_metadata().num_rows(), 0);
    }
}

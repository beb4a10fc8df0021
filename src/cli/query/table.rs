//! CSV tables read by column name, with errors that name the line.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use csv::StringRecord;
use myxo::plain_text::Shown as _;
use myxo::{Error, Result, regular_file};

/// The largest file that is read, bytes.
const LARGEST: u64 = 2 << 30;

/// What `--in` and `--out` call the standard input and output.
const STANDARD: &str = "-";

/// A table whose wanted columns have been found.
#[derive(Debug)]
pub struct Table {
    place: String,
    /// The index of each wanted column.
    columns: Vec<usize>,
    names: &'static [&'static str],
    rows: Vec<StringRecord>,
}

/// One row of a table.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    table: &'a Table,
    record: &'a StringRecord,
}

impl Table {
    /// Reads a file, or the standard input for `-`.
    pub fn read(path: &Path, names: &'static [&'static str]) -> Result<Self> {
        let mut bytes = Vec::new();
        let place = if path.as_os_str() == STANDARD {
            PathBuf::from("the standard input")
        } else {
            path.to_owned()
        };
        if path.as_os_str() == STANDARD {
            std::io::stdin().lock().read_to_end(&mut bytes).map(|_| ())
        } else {
            regular_file::read(path, LARGEST).map(|content| bytes = content)
        }
        .map_err(Error::io("read", &place))?;
        Self::parse(&place.shown(), &bytes, names)
    }

    /// Finds the columns `names` in CSV text. Other columns and lines that begin with `#` are skipped.
    pub fn parse(place: &str, text: &[u8], names: &'static [&'static str]) -> Result<Self> {
        // The byte order mark of some spreadsheets would become part of the first name.
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text);
        let bad = |error: csv::Error| Error::Invalid(format!("{place}: {}", explained(&error)));
        let header = reader.headers().map_err(bad)?.clone();
        let find = |name: &&str| header.iter().position(|column| column == *name);
        let missing: Vec<&str> = names
            .iter()
            .copied()
            .filter(|name| find(name).is_none())
            .collect();
        if !missing.is_empty() {
            return Err(Error::Invalid(format!(
                "{place}: there is no column {}: the header must name {}",
                missing.join(" and no column "),
                names.join(",")
            )));
        }
        let columns = names.iter().filter_map(find).collect();
        let rows = reader
            .into_records()
            .collect::<Result<Vec<_>, _>>()
            .map_err(bad)?;
        Ok(Self {
            place: place.to_owned(),
            columns,
            names,
            rows,
        })
    }

    /// The rows, in the order of the file.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|record| Row {
            table: self,
            record,
        })
    }
}

impl<'a> Row<'a> {
    /// The text in a wanted column, by the column's place in the list of names.
    pub fn text(&self, column: usize) -> &'a str {
        &self.record[self.table.columns[column]]
    }

    /// A finite number.
    pub fn number(&self, column: usize) -> Result<f64> {
        match self.text(column).parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.wrong(column, "a finite number")),
        }
    }

    /// A whole number.
    pub fn integer(&self, column: usize) -> Result<i64> {
        self.text(column)
            .parse()
            .map_err(|_| self.wrong(column, "a whole number"))
    }

    /// `FILE: line N`, for messages.
    pub fn place(&self) -> String {
        let line = self.record.position().map_or(0, csv::Position::line);
        format!("{}: line {line}", self.table.place)
    }

    fn wrong(&self, column: usize, expected: &str) -> Error {
        let (name, text) = (self.table.names[column], self.text(column));
        Error::Invalid(format!(
            "{}: {name} is `{text}`, and {expected} is expected",
            self.place()
        ))
    }
}

fn explained(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths {
            pos,
            expected_len,
            len,
        } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            format!("line {line}: there are {len} fields, and the header has {expected_len}")
        }
        csv::ErrorKind::Utf8 { pos, .. } => {
            format!(
                "line {}: the text is not UTF-8",
                pos.as_ref().map_or(0, csv::Position::line)
            )
        }
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: &[&str] = &["id", "x"];

    fn problem(text: &str) -> String {
        let result = Table::parse("in.csv", text.as_bytes(), NAMES).and_then(|table| {
            table
                .rows()
                .map(|row| row.number(1))
                .collect::<Result<Vec<_>>>()
        });
        result.expect_err("it is wrong").to_string()
    }

    #[test]
    fn columns_are_found_by_name_and_comments_are_skipped() {
        let text = "\u{feff}# made by hand\nx , other,id\r\n0.1,7,a b\n# no row\n 1e-300 ,8,007\n";
        let table = Table::parse("in.csv", text.as_bytes(), NAMES).expect("it is right");
        let rows: Vec<_> = table
            .rows()
            .map(|row| (row.text(0), row.number(1).expect("a number")))
            .collect();
        assert_eq!(rows, [("a b", 0.1), ("007", 1e-300)]);
    }

    #[test]
    fn errors_name_the_line() {
        assert_eq!(
            problem("id,y\n1,2\n"),
            "in.csv: there is no column x: the header must name id,x"
        );
        assert_eq!(
            problem(""),
            "in.csv: there is no column id and no column x: the header must name id,x"
        );
        assert_eq!(
            problem("id,x\n#\n1,2\n2,two\n"),
            "in.csv: line 4: x is `two`, and a finite number is expected"
        );
        assert_eq!(
            problem("id,x\n1,nan\n"),
            "in.csv: line 2: x is `nan`, and a finite number is expected"
        );
        assert_eq!(
            problem("id,x\n1,2\n1\n"),
            "in.csv: line 3: there are 1 fields, and the header has 2"
        );
    }
}

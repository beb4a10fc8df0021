//! Tables of numbers as text, and numbers with prefixes.

use std::fmt::Write as _;

/// Columns two blanks apart, the first flush left, the others flush right, without empty columns; a rule below the header, and
/// one above row number `ruled`. All rows have as many columns as the first.
pub fn aligned(rows: &[impl AsRef<[String]>], ruled: Option<usize>) -> String {
    let rows: Vec<&[String]> = rows.iter().map(AsRef::as_ref).collect();
    let width = |i: usize| rows.iter().map(|row| row[i].chars().count()).max();
    let count = rows.first().map_or(0, |row| row.len());
    let widths: Vec<usize> = (0..count).map(|i| width(i).unwrap_or(0)).collect();
    let columns = widths.iter().filter(|width| **width > 0).count();
    let rule = "─".repeat(widths.iter().sum::<usize>() + 2 * columns.saturating_sub(1));
    let mut text = String::new();
    for (number, row) in rows.iter().enumerate() {
        if number == 1 || ruled == Some(number) {
            let _ = writeln!(text, "{rule}");
        }
        let mut line = format!("{:<width$}", row[0], width = widths[0]);
        for (cell, &width) in row
            .iter()
            .zip(&widths)
            .skip(1)
            .filter(|(_, width)| **width > 0)
        {
            let _ = write!(line, "  {cell:>width$}");
        }
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

/// Three digits and a prefix, to be followed by the unit: `12.3 M `.
pub fn short(value: f64) -> String {
    let (scaled, prefix) = match value {
        v if v >= 1e9 => (v * 1e-9, "G "),
        v if v >= 1e6 => (v * 1e-6, "M "),
        v if v >= 1e3 => (v * 1e-3, "k "),
        v => (v, ""),
    };
    let decimals = match scaled {
        s if s < 9.995 => 2,
        s if s < 99.95 => 1,
        _ => 0,
    };
    format!("{scaled:.decimals$} {prefix}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn throughput_is_short() {
        assert_eq!(short(9_340_000.0), "9.34 M ");
        assert_eq!(short(123_400.0), "123 k ");
        assert_eq!(short(99_960.0), "100 k ");
        assert_eq!(short(2.5e9), "2.50 G ");
        assert_eq!(short(70.0), "70.0 ");
    }

    #[test]
    fn numbers_stand_flush_right_between_two_rules() {
        let row = |a: &str, b: &str| [a.to_owned(), b.to_owned()];
        let rows = [
            row("kernel", "ms"),
            row("advance", "10.500"),
            row("sort", ""),
            row("whole", "12.000"),
        ];
        let expected = "\
kernel       ms
───────────────
advance  10.500
sort
───────────────
whole    12.000
";
        assert_eq!(aligned(&rows, Some(3)), expected);
    }
}

//! Text with a point on each line: CSV, TSV, or numbers with blanks between them.

use csv::{ReaderBuilder, StringRecord, Trim};
use glam::DVec3;

use crate::error::{FileErrorKind, shown};
use crate::scalar::{Endian, ScalarType};

use super::roles::{Roles, name_positions, positions};
use super::{Column, Found, Numbering, PointOptions, Table};

/// Names of the columns where no line names them.
const NAMELESS: [&str; 6] = ["x", "y", "z", "radius", "value", "weight"];

pub(super) fn read(bytes: &[u8], options: &PointOptions) -> Result<Found, FileErrorKind> {
    let text = str::from_utf8(bytes).map_err(|e| {
        let line = 1 + bytes[..e.valid_up_to()].iter().filter(|&&c| c == b'\n').count();
        FileErrorKind::field(format!("line {line}"), "bytes that are no text", "must be UTF-8")
    })?;
    let text = text.trim_start_matches('\u{feff}');
    // Name the columns: by the header, or by their usual order.
    let Some(first) = text.lines().find(|line| !is_comment(line) && !line.trim().is_empty()) else {
        return Err(vr_core::PointError::Empty.into());
    };
    let delimiter = Delimiter::of(first);
    let mut notes = Vec::new();
    let (names, skip) = match header(text, first, delimiter)? {
        Some(header) => header,
        None => {
            let count = words(first, delimiter)?.len();
            if !(3..=NAMELESS.len()).contains(&count) {
                let allowed = "without a line of names, columns are x y z [radius [value [weight]]]";
                return Err(FileErrorKind::field("columns", count, allowed));
            }
            let names = &NAMELESS[..count];
            notes.push(format!("no line of names: the columns are taken for {}", names.join(", ")));
            (names.iter().map(|&name| name.to_owned()).collect(), 0)
        }
    };
    let axes = positions(&names, options)?;
    let roles = Roles::choose(&names, options)?;
    let wanted = roles.list();

    // Read the wanted columns row by row.
    let mut points = Vec::new();
    let mut columns = vec![Vec::new(); wanted.len()];
    let mut lines = Vec::new();
    for row in delimiter.rows(text).skip(skip) {
        let row = Row { names: &names, ..row? };
        row.check_length()?;
        let [x, y, z] = axes;
        points.push(DVec3::new(row.number(x)?, row.number(y)?, row.number(z)?));
        for (column, &c) in columns.iter_mut().zip(&wanted) {
            column.push(row.number(c)?);
        }
        lines.push(row.line);
    }
    let mut columns = columns.into_iter();
    let column = |c: usize| {
        Ok::<_, FileErrorKind>(Column { name: names[c].clone(), numbers: columns.next().unwrap_or_default() })
    };
    let columns = roles.try_map(column)?;
    Ok(Found {
        table: Table { positions: points, columns, numbering: Numbering::Lines(lines) },
        format: delimiter.format(),
        encoding: "ascii",
        scalar: ScalarType::F64,
        endian: Endian::NATIVE,
        names,
        notes,
    })
}

fn is_comment(line: &str) -> bool {
    line.trim_start().starts_with('#')
}

/// The words of a line.
fn words(line: &str, delimiter: Delimiter) -> Result<Vec<String>, FileErrorKind> {
    let row = delimiter.rows(line).next().transpose()?;
    // Fit for a line, as all that messages may quote.
    Ok(row.map_or_else(Vec::new, |row| row.words.iter().map(shown).collect()))
}

/// The names of the columns, and how many rows they take: one where the first row is no numbers, and none where a comment before it names
/// coordinates.
fn header(text: &str, first: &str, delimiter: Delimiter) -> Result<Option<(Vec<String>, usize)>, FileErrorKind> {
    let first = words(first, delimiter)?;
    if first.iter().any(|word| word.parse::<f64>().is_err()) {
        return Ok(Some((first, 1)));
    }
    let comments = text.lines().take_while(|line| is_comment(line) || line.trim().is_empty());
    let named = comments.filter_map(|line| {
        let line = line.trim_start().trim_start_matches('#').trim();
        // Names may be set apart in another way than numbers.
        let ways = [words(line, delimiter).ok(), words(line, Delimiter::Blanks).ok()];
        ways.into_iter().flatten().find(|names| names.len() == first.len() && name_positions(names))
    });
    Ok(named.last().map(|names| (names, 0)))
}

/// Separator of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Delimiter {
    /// One of these, and blanks beside it.
    Byte(u8),
    /// Blanks.
    Blanks,
}

impl Delimiter {
    fn of(line: &str) -> Self {
        [b';', b',', b'\t'].into_iter().find(|&d| line.as_bytes().contains(&d)).map_or(Self::Blanks, Self::Byte)
    }

    fn format(self) -> &'static str {
        match self {
            Self::Byte(b'\t') => "TSV",
            Self::Byte(b';') => "CSV (semicolons)",
            Self::Byte(_) => "CSV",
            Self::Blanks => "text (blanks)",
        }
    }

    /// The lines that are neither empty nor comments.
    fn rows(self, text: &str) -> Box<dyn Iterator<Item = Result<Row<'static>, FileErrorKind>> + '_> {
        match self {
            Self::Blanks => Box::new(
                text.lines()
                    .zip(1..)
                    .filter(|(line, _)| !is_comment(line) && !line.trim().is_empty())
                    .map(|(text, line)| Ok(Row { line, words: text.split_whitespace().collect(), names: &[] })),
            ),
            Self::Byte(delimiter) => {
                let reader = ReaderBuilder::new()
                    .delimiter(delimiter)
                    .comment(Some(b'#'))
                    .has_headers(false)
                    .flexible(true)
                    .trim(Trim::All)
                    .from_reader(text.as_bytes());
                let rows = reader.into_records().map(|record| Row::new(record, text));
                // Lines of delimiters alone, and comments that do not begin with their line.
                let holds_words = |words: &StringRecord| words.iter().any(|w| !w.is_empty());
                let is_comment = |words: &StringRecord| words.get(0).is_some_and(is_comment);
                Box::new(rows.filter(move |row| {
                    row.as_ref().map_or(true, |row| holds_words(&row.words) && !is_comment(&row.words))
                }))
            }
        }
    }
}

/// A line of numbers.
struct Row<'a> {
    /// Line number, from 1.
    line: u64,
    words: StringRecord,
    names: &'a [String],
}

impl Row<'static> {
    fn new(record: csv::Result<StringRecord>, text: &str) -> Result<Self, FileErrorKind> {
        // The library tells where it began to look for the record: lines without one may come first.
        let line = |position: Option<&csv::Position>| {
            let (before, line) = position.map_or((0, 1), |p| (p.byte() as usize, p.line()));
            let rest = text.get(before..).unwrap_or_default();
            line + rest.lines().take_while(|line| line.trim().is_empty() || line.starts_with('#')).count() as u64
        };
        match record {
            Ok(words) => Ok(Self { line: line(words.position()), words, names: &[] }),
            Err(e) => Err(FileErrorKind::field(format!("line {}", line(e.position())), e, "must be a line of numbers")),
        }
    }
}

impl Row<'_> {
    /// Refuses more words than names; those that are empty at the end count as none.
    fn check_length(&self) -> Result<(), FileErrorKind> {
        let last = (0..self.words.len()).rev().find(|&c| !self.words[c].is_empty());
        let count = last.map_or(0, |last| last + 1);
        if count <= self.names.len() {
            return Ok(());
        }
        let allowed = format!("there are names for {}", self.names.len());
        Err(FileErrorKind::field(format!("line {}", self.line), format!("{count} columns"), allowed))
    }

    fn number(&self, column: usize) -> Result<f64, FileErrorKind> {
        let word = self.words.get(column).unwrap_or_default();
        let place = || format!("line {}, column '{}'", self.line, self.names[column]);
        word.parse().map_err(|_| FileErrorKind::field(place(), word, "must be a number"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Result<Found, String> {
        found_with(text, &PointOptions::default())
    }

    fn found_with(text: &str, options: &PointOptions) -> Result<Found, String> {
        read(text.as_bytes(), options).map_err(|e| e.to_string())
    }

    #[test]
    fn every_delimiter_and_header() {
        let expected = [DVec3::new(1.0, -2.0, 3e4), DVec3::new(0.5, 0.25, 0.0)];
        for (text, format) in [
            ("x,y,z,h\n1,-2,3e4,7\n0.5,0.25,0,8\n", "CSV"),
            ("\u{feff}\"x\", \"y\", \"z\", \"h\"\r\n1, -2, 3e4, 7\r\n\r\n0.5, 0.25, 0, 8,\r\n", "CSV"),
            ("# made by hand\nH;Z;Y;X\n7;3e4;-2;1\n# between\n8;0;0.25;0.5", "CSV (semicolons)"),
            ("px\tpy\tpz\thsml\n1\t-2\t3e4\t7\n0.5\t0.25\t0\t8\n", "TSV"),
            ("# x y z h\n  1 -2   3e4 7\n\n0.5 0.25 0 8\n", "text (blanks)"),
            ("# x, y, z, h\n1 -2 3e4 7\n 0.5 0.25 0 8\n", "text (blanks)"),
            ("# x y z h\n1,-2,3e4,7\n  # between\n0.5,0.25,0,8\n,,,\n", "CSV"),
        ] {
            let found = found(text).unwrap_or_else(|e| panic!("{text:?}: {e}"));
            assert_eq!((&found.table.positions[..], found.format), (&expected[..], format), "{text:?}");
            assert_eq!(found.table.columns.smoothing.unwrap().numbers, [7.0, 8.0], "{text:?}");
            assert!(found.notes.is_empty());
        }
    }

    #[test]
    fn without_names_the_order_tells() {
        let found = found("1 2 3 0.5 9 4\n").unwrap();
        let columns = found.table.columns;
        let [radius, value, weight] = [columns.radius, columns.value, columns.weight].map(|c| c.unwrap().numbers[0]);
        assert_eq!((radius, value, weight), (0.5, 9.0, 4.0));
        assert!(found.notes[0].contains("x, y, z, radius, value, weight"));
    }

    #[test]
    fn options_name_columns() {
        let mut options = PointOptions { value: Some("c".to_owned()), ..PointOptions::default() };
        options.columns.position = Some(["d", "a", "b"].map(str::to_owned));
        let found = found_with("a,b,c,d,name\n1,2,3,4,one\n", &options).unwrap();
        assert_eq!(found.table.positions, [DVec3::new(4.0, 1.0, 2.0)]);
        assert_eq!(found.table.columns.value.unwrap().numbers, [3.0]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, word) in [
            ("", "no point"),
            ("# nothing\n\n", "no point"),
            ("x,y,z\n", "no point"),
            ("x,y\n1,2\n", "column z: found x, y; positions need columns x, y and z"),
            ("1,2\n", "columns: found 2; without a line of names"),
            ("1,2,3,4,5,6,7\n", "columns: found 7"),
            ("x,y,z\n1,2,3\n1,2,three\n", "line 3, column 'z': found three; must be a number"),
            ("# one\nx;y;z\n\n1;2,5;3\n", "line 4, column 'y': found 2,5"),
            ("x y z\n1 2\n", "line 2, column 'z': found nothing"),
            ("x,y,z\n1,2,3,4\n", "line 2: found 4 columns; there are names for 3"),
        ] {
            let message = match found(text) {
                Ok(found) => {
                    let notes = &mut Vec::new();
                    let points = super::super::assemble::assemble(found.table, &PointOptions::default(), notes);
                    points.unwrap_err().to_string()
                }
                Err(message) => message,
            };
            assert!(message.contains(word), "no {word:?} in {message}");
        }
        let message = read(b"x,y,z\n\xff\n", &PointOptions::default()).err().unwrap();
        assert!(message.to_string().contains("line 2: found bytes"));
    }
}

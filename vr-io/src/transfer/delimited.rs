//! Tables of values, colours and opacities as text: commas, semicolons, tabs or blanks.

use vr_core::transfer::srgb_to_linear;

use crate::error::FieldError;

use super::color_space::ColorSpace;
use super::curves::{colors, growing, merge};
use super::opacity::opacities;
use super::polyline::Polyline;
use super::{MAX_POINTS, TransferFile};

/// Meaning of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    /// A value of the volume.
    Value,
    /// A number that only counts rows.
    Index,
    Color(usize),
    Opacity,
    Other,
}

/// Reads a table. One without values is to be spread over a range, and so is one that counts its rows, as colour tables (`is_lut`) do.
pub(super) fn parse(text: &str, is_lut: bool) -> Result<TransferFile, FieldError> {
    let mut lines = text.lines().enumerate().map(|(k, line)| (k + 1, line.trim()));
    let mut lines =
        lines.by_ref().filter(|(_, line)| !line.is_empty() && !line.starts_with(['#', '%']) && !line.starts_with("//"));
    let Some(first) = lines.next() else {
        return Err(FieldError::new("table", "no row", "must have one at least"));
    };
    // Names, or numbers at once.
    let words = split(first.1);
    let mut notes = Vec::new();
    let is_header = words.iter().all(|word| word.parse::<f64>().is_err());
    let columns = if is_header { named(&words, first.0)? } else { usual(words.len(), is_lut, first.0, &mut notes)? };
    let mut table: Vec<(usize, Vec<f64>)> = Vec::new();
    let unnamed = (!is_header).then_some(first);
    for (line, row) in unnamed.into_iter().chain(lines) {
        if table.len() == MAX_POINTS {
            return Err(FieldError::new(format!("line {line}"), "a further row", format!("{MAX_POINTS} rows at most")));
        }
        table.push((line, numbers(row, line, columns.len())?));
    }
    if table.is_empty() {
        return Err(FieldError::new("table", "no row", "must have one at least"));
    }
    let place = |column: Column| columns.iter().position(|&c| c == column);
    let [r, g, b] = [0, 1, 2].map(|c| place(Column::Color(c)));
    let absolute = place(Column::Value).is_some();
    let value = place(Column::Value).or(place(Column::Index));
    let value_of = |k: usize| value.map_or(k as f64, |c| table[k].1[c]);
    // Colours of 0 to 255, as pictures have them, or of 0 to 1.
    let scale = |places: &[usize]| {
        let largest = table.iter().flat_map(|(_, row)| places.iter().map(|&c| row[c])).fold(0.0, f64::max);
        if largest > 1.0 { 255.0 } else { 1.0 }
    };
    let field = |row: usize, what: &str| format!("line {}, {what}", table[row].0);
    let line = if let (Some(r), Some(g), Some(b)) = (r, g, b) {
        let scale = scale(&[r, g, b]);
        if scale > 1.0 {
            notes.push("colours are taken as 0 to 255".to_owned());
        }
        let rows: Vec<[f64; 4]> = table
            .iter()
            .enumerate()
            .map(|(k, (_, row))| [value_of(k), row[r] / scale, row[g] / scale, row[b] / scale])
            .collect();
        colors(&rows, ColorSpace::Rgb, |row, k| field(row, ["value", "red", "green", "blue"][k]))?
    } else {
        notes.push("there are no colours: all is white".to_owned());
        Polyline(vec![(value_of(0), [1.0f64; 3].map(srgb_to_linear))])
    };
    let opacity = if let Some(a) = place(Column::Opacity) {
        let scale = scale(&[a]);
        if scale > 1.0 {
            notes.push("opacities are taken as 0 to 255".to_owned());
        }
        let rows: Vec<[f64; 4]> =
            table.iter().enumerate().map(|(k, (_, row))| [value_of(k), row[a] / scale, 0.5, 0.0]).collect();
        opacities(&rows, |row, k| field(row, ["value", "opacity", "", ""][k]))?
    } else {
        growing(&line, &mut notes)
    };
    let format = if is_lut { "ImageJ's colour table" } else { "table" };
    Ok(TransferFile { notes, ..TransferFile::of_points(format, merge(&line, &opacity), absolute) })
}

/// Cells of a line.
fn split(line: &str) -> Vec<&str> {
    let separator = [';', '\t', ','].into_iter().find(|&c| line.contains(c));
    match separator {
        Some(separator) => line.split(separator).map(|cell| cell.trim().trim_matches('"')).collect(),
        None => line.split_whitespace().collect(),
    }
}

/// Columns by the names in the first line.
fn named(words: &[&str], line: usize) -> Result<Vec<Column>, FieldError> {
    let column = |word: &&str| match word.to_lowercase().as_str() {
        "value" | "v" | "x" | "scalar" | "intensity" | "hu" => Column::Value,
        "index" | "i" => Column::Index,
        "red" | "r" => Column::Color(0),
        "green" | "g" => Column::Color(1),
        "blue" | "b" => Column::Color(2),
        "opacity" | "alpha" | "a" | "o" => Column::Opacity,
        _ => Column::Other,
    };
    let columns: Vec<Column> = words.iter().map(column).collect();
    let has = |column| columns.contains(&column);
    let colors = (0..3).filter(|&c| has(Column::Color(c))).count();
    if colors == 1 || colors == 2 || (colors == 0 && !has(Column::Opacity)) {
        let allowed = "must be names of columns (value, red, green, blue, opacity) or numbers";
        return Err(FieldError::new(format!("line {line}"), words.join(" "), allowed));
    }
    Ok(columns)
}

/// Columns by their number, where there are no names.
fn usual(count: usize, is_lut: bool, line: usize, notes: &mut Vec<String>) -> Result<Vec<Column>, FieldError> {
    use Column::{Color, Index, Opacity, Value};
    let [r, g, b] = [0, 1, 2].map(Color);
    Ok(match count {
        5 => vec![Value, r, g, b, Opacity],
        4 if is_lut => vec![Index, r, g, b],
        4 => {
            notes.push("four columns are taken as value, red, green, blue".to_owned());
            vec![Value, r, g, b]
        }
        3 => vec![r, g, b],
        2 => {
            notes.push("two columns are taken as value, opacity".to_owned());
            vec![Value, Opacity]
        }
        _ => {
            let allowed =
                "must be value, red, green, blue, opacity; the last, the first or the colours may be left out";
            return Err(FieldError::new(format!("line {line}"), format!("{count} columns"), allowed));
        }
    })
}

/// Numbers of a line.
fn numbers(row: &str, line: usize, count: usize) -> Result<Vec<f64>, FieldError> {
    let cells = split(row);
    if cells.len() != count {
        let allowed = format!("must be {count}, as in the first row");
        return Err(FieldError::new(format!("line {line}"), format!("{} cells", cells.len()), allowed));
    }
    let number = |cell: &&str| {
        let number = cell.parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| FieldError::new(format!("line {line}"), cell, "must be a finite number"))
    };
    cells.iter().map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::transfer::linear_to_srgb;

    fn ends(file: &TransferFile) -> [f64; 4] {
        let (first, last) = (file.points[0], file.points[file.points.len() - 1]);
        [first.value, first.opacity, last.value, last.opacity]
    }

    #[test]
    fn columns_by_number_and_by_name() {
        let plain = parse("# bone\n-1000,0,0,0,0\n300;1;0.5;0.25;0.5\n".replace(';', ",").as_str(), false).unwrap();
        assert!(plain.absolute && plain.notes.is_empty());
        assert_eq!(ends(&plain), [-1000.0, 0.0, 300.0, 0.5]);
        assert!((linear_to_srgb(plain.points.last().unwrap().color[1]) - 0.5).abs() < 1e-7);
        let named = parse("Alpha\tB\tG\tR\tHU\tname\n0\t0\t0\t0\t1\t7\n255\t255\t128\t0\t9\t8\n", false).unwrap();
        assert_eq!(ends(&named), [1.0, 0.0, 9.0, 1.0]);
        assert_eq!(named.notes.len(), 2, "{:?}", named.notes);
        assert!((linear_to_srgb(named.points.last().unwrap().color[1]) - 128.0 / 255.0).abs() < 1e-7);
        let opacity = parse("0 0\n10 0.5\n", false).unwrap();
        assert_eq!((ends(&opacity), opacity.points[0].color), ([0.0, 0.0, 10.0, 0.5], [1.0; 3]));
    }

    #[test]
    fn color_tables_are_relative() {
        let counted = parse("Index\tRed\tGreen\tBlue\n0\t0\t0\t0\n1\t9\t9\t9\n2\t255\t0\t0\n", true).unwrap();
        assert!(!counted.absolute);
        assert_eq!(ends(&counted), [0.0, 0.0, 2.0, 1.0]);
        assert!(!parse("0 0 0 0\n1 255 0 0\n", true).unwrap().absolute);
        assert!(!parse("0 0 0\n0.5 0.5 1\n", false).unwrap().absolute);
    }

    #[test]
    fn names_the_line() {
        for (text, word) in [
            ("", "no row"),
            ("value,r,g,b\n", "no row"),
            ("value,name\n1,2\n", "line 1: found value name; must be names of columns"),
            ("1\n", "line 1: found 1 columns"),
            ("0,0,0,0,0\n1,1,1,1\n", "line 2: found 4 cells; must be 5"),
            ("0,0,0,0,0\n\n1,1,x,1,1\n", "line 3: found x; must be a finite number"),
            ("0,0,0,0,0\n1,1,nan,1,1\n", "line 2: found nan"),
            ("0,0,0,0,0\n-1,1,1,1,1\n", "line 2, value: found -1; values must be finite and in ascending"),
            ("0,-1,0,0,0\n", "line 1, red: found -1; colours"),
            ("0,300,0,0,0\n", "line 1, red"),
            ("0,0,0,0,-2\n", "line 1, opacity: found -2"),
        ] {
            let message = parse(text, false).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}

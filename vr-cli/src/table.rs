//! Tables in a terminal.

use std::fmt::Write;

/// Table of rows of cells, the first columns aligned left, the others right.
#[derive(Debug)]
pub struct Table {
    rows: Vec<Vec<String>>,
    /// Number of columns that are aligned left.
    left: usize,
}

impl Table {
    /// Makes a table of names and numbers with a header.
    pub fn new(header: &[&str]) -> Self {
        Self { rows: vec![header.iter().map(|&h| h.to_owned()).collect()], left: 1 }
    }

    /// Makes a table of words alone with a header.
    pub fn of_words(header: &[&str]) -> Self {
        Self { left: header.len(), ..Self::new(header) }
    }

    /// Adds a row; it may be shorter than the header.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |c: usize| self.rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for row in &self.rows {
            let mut line = String::new();
            for (c, (cell, &width)) in row.iter().zip(&widths).enumerate() {
                let gap = if c == 0 { "" } else { "  " };
                if c < self.left {
                    write!(line, "{gap}{cell:<width$}")?;
                } else {
                    write!(line, "{gap}{cell:>width$}")?;
                }
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let mut t = Table::new(&["renderer", "ms"]);
        t.row(["raycast".to_owned(), "1.5".to_owned()]);
        t.row(["π".to_owned(), "120.0".to_owned()]);
        assert_eq!(t.to_string(), "renderer     ms\nraycast     1.5\nπ         120.0\n");
        let mut words = Table::of_words(&["preset", "shows"]);
        words.row(["ct-bone".to_owned(), "bone".to_owned()]);
        assert_eq!(words.to_string(), "preset   shows\nct-bone  bone\n");
    }
}

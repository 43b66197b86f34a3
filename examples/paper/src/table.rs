//! Tables on the terminal, with one row per quantity and one column per case.

use gradient_mc::statistics::Estimate;
use std::fmt;

/// A table with a label at the head of each row.
#[derive(Debug, Clone)]
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Makes a table with these column heads; the first is that of the labels.
    pub fn new(head: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self { rows: vec![head.into_iter().map(Into::into).collect()] }
    }

    /// Adds a row; an empty one is a blank line.
    pub fn row(&mut self, label: &str, cells: impl IntoIterator<Item = String>) {
        self.rows.push(std::iter::once(label.to_owned()).chain(cells).collect());
    }
}

/// A number with its error, in per cent.
pub fn percent(estimate: Estimate) -> String {
    (100.0 * estimate).to_string()
}

impl fmt::Display for Table {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            self.rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max()
        };
        let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
        for (index, row) in self.rows.iter().enumerate() {
            let mut line = String::new();
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                let cell = if column == 0 { format!("{cell:<width$}") } else { format!("   {cell:>width$}") };
                line.push_str(&cell);
            }
            writeln!(formatter, "{}", line.trim_end())?;
            if index == 0 {
                writeln!(formatter, "{}", "-".repeat(widths.iter().sum::<usize>() + 3 * (columns - 1)))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let mut table = Table::new(["β", "n"]);
        table.row("0.05", ["1".to_owned()]);
        table.row("", []);
        assert_eq!(table.to_string(), "β      n\n--------\n0.05   1\n\n");
        assert_eq!(percent(Estimate::new(0.5, 0.01)), Estimate::new(50.0, 1.0).to_string());
    }
}

//! Tables of spectral data as this project keeps them: comma-separated text under a `#` header.
//!
//! The header's lines read `# source: ...`, `# licence: ...`, `# units: ...`, `# note: ...`; then come one
//! line of column names and the rows. A cell may be quoted, so that it can contain commas.

use std::fmt;

/// A table of spectral data with what its header says about it.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile {
    /// Where the data are from.
    pub source: String,
    /// Licence of the data.
    pub licence: String,
    /// Units of the columns.
    pub units: String,
    /// What else is said of the data.
    pub notes: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    rows: Vec<Row>,
}

#[derive(Clone, Debug, PartialEq)]
struct Row {
    line: usize,
    cells: Vec<String>,
}

/// What is wrong with such a table, at a line (from 1).
#[derive(Clone, Debug, PartialEq)]
pub enum TableError {
    /// No line of column names.
    NoColumns,
    /// A row has more or fewer cells than there are columns.
    RowLength {
        /// The line, counted from 1.
        line: usize,
        /// How many columns there are.
        expected: usize,
        /// How many values the line has.
        found: usize,
    },
    /// The table has no such column.
    NoColumn {
        /// The name that was asked for.
        name: String,
    },
    /// A cell is not a finite number.
    NotANumber {
        /// The line, counted from 1.
        line: usize,
        /// Name of the column.
        column: String,
        /// What stands there.
        found: String,
    },
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoColumns => write!(f, "expected a line of column names"),
            Self::RowLength { line, expected, found } => {
                write!(f, "line {line}: expected {expected} cells, found {found}")
            }
            Self::NoColumn { name } => write!(f, "expected a column named '{name}'"),
            Self::NotANumber { line, column, found } => {
                write!(f, "line {line}, column '{column}': expected a number, found '{found}'")
            }
        }
    }
}

impl std::error::Error for TableError {}

impl TableFile {
    /// Reads a whole table.
    ///
    /// # Errors
    /// No column names, or rows of another length than these.
    pub fn parse(text: &str) -> Result<Self, TableError> {
        let mut table = Self {
            source: String::new(),
            licence: String::new(),
            units: String::new(),
            notes: Vec::new(),
            columns: Vec::new(),
            rows: Vec::new(),
        };
        for (line, content) in text.lines().enumerate().map(|(i, content)| (i + 1, content.trim())) {
            if let Some(header) = content.strip_prefix('#') {
                table.read_header(header);
            } else if content.is_empty() {
                continue;
            } else if table.columns.is_empty() {
                table.columns = cells_of(content);
            } else {
                let cells = cells_of(content);
                let (expected, found) = (table.columns.len(), cells.len());
                if expected != found {
                    return Err(TableError::RowLength { line, expected, found });
                }
                table.rows.push(Row { line, cells });
            }
        }
        if table.columns.is_empty() { Err(TableError::NoColumns) } else { Ok(table) }
    }

    fn read_header(&mut self, header: &str) {
        let (key, value) = header.split_once(':').unwrap_or(("note", header));
        let value = value.trim().to_owned();
        match key.trim() {
            "source" => self.source = value,
            "licence" => self.licence = value,
            "units" => self.units = value,
            "note" => self.notes.push(value),
            _ => self.notes.push(header.trim().to_owned()),
        }
    }

    /// The numbers of one column.
    ///
    /// # Errors
    /// No such column, or a cell of it that is not a finite number.
    pub fn numbers(&self, column: &str) -> Result<Vec<f64>, TableError> {
        let cells = self.cells(column)?;
        cells
            .map(|(line, cell)| match cell.parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(number),
                _ => Err(TableError::NotANumber { line, column: column.to_owned(), found: cell.to_owned() }),
            })
            .collect()
    }

    /// The text of one column.
    ///
    /// # Errors
    /// No such column.
    pub fn texts(&self, column: &str) -> Result<Vec<&str>, TableError> {
        Ok(self.cells(column)?.map(|(_, cell)| cell).collect())
    }

    /// The cells of one column with their lines.
    fn cells(&self, column: &str) -> Result<impl Iterator<Item = (usize, &str)>, TableError> {
        let place = self.columns.iter().position(|name| name == column);
        let place = place.ok_or_else(|| TableError::NoColumn { name: column.to_owned() })?;
        Ok(self.rows.iter().map(move |row| (row.line, row.cells[place].as_str())))
    }
}

/// Splits at commas that are not within double quotes; the quotes are taken off.
fn cells_of(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            _ => cells.last_mut().expect("starts with one cell").push(c),
        }
    }
    cells.iter().map(|cell| cell.trim().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXAMPLE: &str = "# source: A. Author, \"Title: a study\"\n# licence: CC0 1.0\n# units: nm\n# note: one\n\
                           # note: two\nwavelength_nm,value,reference\n400,0.5,\"x, y\"\n500, -1e-3 ,z\n";

    #[test]
    fn header_and_columns_are_read() {
        let table = TableFile::parse(EXAMPLE).unwrap();
        assert_eq!(table.source, "A. Author, \"Title: a study\"");
        assert_eq!((table.licence.as_str(), table.units.as_str()), ("CC0 1.0", "nm"));
        assert_eq!(table.notes, ["one", "two"]);
        assert_eq!(table.numbers("value").unwrap(), [0.5, -1e-3]);
        assert_eq!(table.texts("reference").unwrap(), ["x, y", "z"]);
    }

    #[test]
    fn problems_say_where_they_are() {
        let table = TableFile::parse(EXAMPLE).unwrap();
        assert_eq!(table.numbers("nope"), Err(TableError::NoColumn { name: "nope".into() }));
        let error = table.numbers("reference").unwrap_err();
        assert_eq!(error.to_string(), "line 7, column 'reference': expected a number, found 'x, y'");
        assert_eq!(TableFile::parse("# source: x\n"), Err(TableError::NoColumns));
        let error = TableFile::parse("a,b\n1,2\n1,2,3").unwrap_err();
        assert_eq!(error, TableError::RowLength { line: 3, expected: 2, found: 3 });
    }
}

//! Arrays and matrices as FreeFEM writes and reads them: `file << u[]`, `file >> u[]`, `file << A`.
//!
//! Let scripts write all digits: `file.precision(17)`.
//! ```
//! use contact_fem::freefem;
//!
//! let u = freefem::array("3\t\n\t0.5\t  0\t-1e-3")?;
//! assert_eq!(u, [0.5, 0.0, -1e-3]);
//! assert_eq!(freefem::array(&freefem::array_text(&u))?, u);
//! # Ok::<(), freefem::Error>(())
//! ```

use std::fmt;
use std::path::{Path, PathBuf};

use contact_core::Bounds;
use contact_core::quadratic::{Entries, QuadraticProgram};

/// Why a file of FreeFEM cannot be used. Each contains what is wrong, its value and the remedy.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file that is missing or that the system does not read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A text that is no array or matrix.
    #[error("{}{what}", path.as_ref().map_or(String::new(), |path| format!("{}: ", path.display())))]
    Text {
        /// Which file, if it is one.
        path: Option<PathBuf>,
        /// What is wrong with it, and the remedy.
        what: String,
    },
    /// Matrices and arrays that are no problem.
    #[error("{folder}: {source}")]
    Problem {
        /// The folder of their files.
        folder: PathBuf,
        /// What is wrong with them.
        source: contact_core::Error,
    },
}

/// The `Display` message: `main` and `unwrap` print an error by `Debug`.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

fn wrong(what: impl Into<String>) -> Error {
    Error::Text {
        path: None,
        what: what.into(),
    }
}

/// The values of an array, which a script writes by `file << u[]`: their number, then the values.
///
/// # Errors
/// A number of values that is missing or not kept, or a word that is no finite number.
pub fn array(text: &str) -> Result<Vec<f64>, Error> {
    let mut words = text.split_whitespace();
    let count = words.next().unwrap_or_default();
    let count: usize = count.parse().map_err(|_| {
        wrong(format!("it begins with `{}`, and an array with its number of values: write it by `file << u[]`", shown(count)))
    })?;
    let values: Vec<f64> = words.map(number).collect::<Result<_, Error>>()?;
    match values.len() == count {
        true => Ok(values),
        false => Err(wrong(format!(
            "it announces {count} values and has {}: write the array into a file of its own",
            values.len()
        ))),
    }
}

/// The text from which a script reads an array by `file >> u[]`.
pub fn array_text(values: &[f64]) -> String {
    let mut text = format!("{}\n", values.len());
    for value in values {
        text += &format!("{value:e}\n");
    }
    text
}

/// A sparse matrix, which a script writes by `file << A` (FreeFEM 4). Of a symmetric one that is stored by half, both halves
/// are given.
///
/// # Errors
/// A text without FreeFEM's head, other numbers of entries than announced, entries outside the matrix, or a word that is no
/// finite number.
pub fn matrix(text: &str) -> Result<Entries, Error> {
    let comment = text.lines().next().unwrap_or_default();
    let is_coordinates = comment.contains("HashMatrix");
    if !is_coordinates && !comment.contains("Sparse Matrix (Morse)") {
        return Err(wrong(
            "it has not the head of a sparse matrix: write it by `file << A` in FreeFEM 4",
        ));
    }
    let lines = text
        .lines()
        .filter(|line| !line.starts_with('#') && !line.trim().is_empty());
    let mut lines = lines.map(|line| line.split_whitespace().collect::<Vec<&str>>());
    let head = lines.next().unwrap_or_default();
    let whole = |word: Option<&&str>| -> Result<usize, Error> {
        let word = word.copied().unwrap_or_default();
        word.parse()
            .map_err(|_| wrong(format!("`{}` is no whole number from 0", shown(word))))
    };
    // as entries: rows, columns, entries, half, the first number; by rows: rows, columns, half, entries
    let at = |as_entries: usize, by_rows: usize| {
        whole(head.get(if is_coordinates { as_entries } else { by_rows }))
    };
    let [rows, columns, count] = [at(0, 0)?, at(1, 1)?, at(2, 3)?];
    let is_half = at(3, 2)? != 0;
    let first = if is_coordinates { at(4, 4)? } else { 1 };
    let mut values = Vec::new();
    for line in lines {
        let [row, column, value] = line[..] else {
            return Err(wrong(format!(
                "`{}` is no entry: a row, a column and a value",
                shown(&line.join(" "))
            )));
        };
        let (row, column) = (whole(Some(&row))?, whole(Some(&column))?);
        let place = row.checked_sub(first).zip(column.checked_sub(first));
        let place = place.filter(|&(i, j)| i < rows && j < columns);
        let (i, j) = place.ok_or_else(|| {
            wrong(format!(
                "entry ({row}, {column}) is outside the {rows} × {columns} matrix"
            ))
        })?;
        let value = number(value)?;
        values.push((i, j, value));
        if is_half && i != j {
            values.push((j, i, value));
        }
    }
    let found = match is_half {
        true => {
            values.iter().filter(|(i, j, _)| i == j).count()
                + values.iter().filter(|(i, j, _)| i != j).count() / 2
        }
        false => values.len(),
    };
    match found == count {
        true => Ok(Entries {
            rows,
            columns,
            values,
        }),
        false => Err(wrong(format!(
            "it announces {count} entries and has {found}: write the matrix into a file of its own"
        ))),
    }
}

fn number(word: &str) -> Result<f64, Error> {
    let value: f64 = word
        .parse()
        .map_err(|_| wrong(format!("`{}` is no number", shown(word))))?;
    match value.is_finite() {
        true => Ok(value),
        false => Err(wrong(format!(
            "a value is {value}: the script that wrote it has failed"
        ))),
    }
}

/// The beginning of a word or a line of a damaged file.
fn shown(text: &str) -> String {
    text.chars().take(40).collect()
}

/// The array in a file, see [`array()`].
///
/// # Errors
/// A file that cannot be read, and as [`array()`].
pub fn read_array(path: impl AsRef<Path>) -> Result<Vec<f64>, Error> {
    read(path.as_ref(), array)
}

/// The matrix in a file, see [`matrix`].
///
/// # Errors
/// A file that cannot be read, and as [`matrix`].
pub fn read_matrix(path: impl AsRef<Path>) -> Result<Entries, Error> {
    read(path.as_ref(), matrix)
}

fn read<T>(path: &Path, parsed: impl Fn(&str) -> Result<T, Error>) -> Result<T, Error> {
    let text = std::fs::read_to_string(path).map_err(|source| Error::Read {
        path: path.into(),
        source,
    })?;
    parsed(&text).map_err(|why| match why {
        Error::Text { what, .. } => Error::Text {
            path: Some(path.into()),
            what,
        },
        other => other,
    })
}

/// The problem that a script gives `IPOPT([K, b], [C, c0], u, lb = low, ub = high, clb = clow)`, from the files `K.txt`, `b.txt`,
/// `C.txt`, `c0.txt`, `low.txt`, `high.txt` and `clow.txt` in a folder. Those of bounds may be missing: there are none, and rows
/// are ≥ 0. Rows with a lower bound of −1e19 or less are left out.
///
/// # Errors
/// Files that are missing or damaged, and as [`QuadraticProgram::new`].
pub fn read_problem(folder: impl AsRef<Path>) -> Result<QuadraticProgram, Error> {
    let folder = folder.as_ref();
    let file = |name: &str| folder.join(name);
    let optional = |name: &str, count: usize, value: f64| match file(name).exists() {
        true => read_array(file(name)),
        false => Ok(vec![value; count]),
    };
    let (stiffness, linear) = (read_matrix(file("K.txt"))?, read_array(file("b.txt"))?);
    let (mut rows, mut constant) = (read_matrix(file("C.txt"))?, read_array(file("c0.txt"))?);
    let bounds = Bounds {
        lower: optional("low.txt", linear.len(), f64::NEG_INFINITY)?,
        upper: optional("high.txt", linear.len(), f64::INFINITY)?,
    };
    let least = optional("clow.txt", constant.len(), 0.0)?;
    let problem = |source| Error::Problem {
        folder: folder.into(),
        source,
    };
    contact_core::Error::check_vector("clow", &least, constant.len()).map_err(problem)?;
    // C u + c₀ ≥ clow
    let is_free: Vec<bool> = least.iter().map(|least| *least <= -1e19).collect();
    rows.values
        .retain(|entry| !is_free.get(entry.0).copied().unwrap_or(false));
    for ((constant, least), is_free) in constant.iter_mut().zip(&least).zip(is_free) {
        *constant = if is_free { 0.0 } else { *constant - least };
    }
    QuadraticProgram::new(&stiffness, &linear, &rows, &constant, &bounds).map_err(problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What FreeFEM 4.9 wrote for `int[int] I = [0, 1, 2], J = [0, 1, 7]; real[int] V = [1, 2.5, -3]; matrix C = [I, J, V];`.
    const ROWS: &str = "#  HashMatrix Matrix (COO) 0x564531da9650\n\
        #    n       m        nnz     half     fortran   state  \n\
        3 8 3 0 0 0 0 \n         0         0 1\n         1         1 2.5\n         2         7 -3\n\n";

    /// ∂u∂v + ∂w∂z of one triangle, by `sym = 1`.
    const HALF: &str = "#  HashMatrix Matrix (COO) 0x564531db3110\n\
        #    n       m        nnz     half     fortran   state  \n\
        2 2 3 1 0 0 0 \n 0 0 0.5\n 1 0 -0.25\n 1 1 2\n";

    #[test]
    fn matrices_of_freefem_are_read() -> Result<(), Error> {
        let rows = matrix(ROWS)?;
        assert_eq!((rows.rows, rows.columns), (3, 8));
        assert_eq!(rows.values, [(0, 0, 1.0), (1, 1, 2.5), (2, 7, -3.0)]);
        let half = matrix(HALF)?;
        assert_eq!(
            half.values,
            [(0, 0, 0.5), (1, 0, -0.25), (0, 1, -0.25), (1, 1, 2.0)]
        );
        let fortran = ROWS
            .replace("3 8 3 0 0", "3 8 3 0 1")
            .replace(" 7 -3", " 8 -3");
        let fortran = fortran.replace(" 1         1 2.5", " 2         2 2.5");
        let fortran = fortran
            .replace(" 0         0 1", " 1         1 1")
            .replace("2         8", "3         8");
        assert_eq!(matrix(&fortran)?, rows);
        Ok(())
    }

    /// What FreeFEM 4.9 writes of a matrix that was multiplied or sorted, as those of ff-Ipopt are.
    #[test]
    fn matrices_by_rows_are_read() -> Result<(), Error> {
        let text = "# Sparse Matrix (Morse)  0x55e2db6e8380\n\
            # first line: n m (is symmetic) nnz \n\
            # after for each nonzero coefficient:   i j a_ij where (i,j) \\in  {1,...,n}x{1,...,m} \n\
            176 352 0  2\n       19        38 -0.80000000000000004441\n       176        352 0\n";
        let matrix = matrix(text)?;
        assert_eq!((matrix.rows, matrix.columns), (176, 352));
        assert_eq!(matrix.values, [(18, 37, -0.8), (175, 351, 0.0)]);
        Ok(())
    }

    #[test]
    fn damaged_texts_are_refused() {
        let damaged = [
            (
                ROWS.replace("3 8 3", "3 8 4"),
                "announces 4 entries and has 3",
            ),
            (ROWS.replace("7 -3", "8 -3"), "(2, 8) is outside"),
            (ROWS.replace("2.5", "nan"), "a value is NaN"),
            (ROWS.replace("2.5", "x"), "`x` is no number"),
            (ROWS.replace("2.5", ""), "no entry"),
            (ROWS.replace("3 8 3", "-3 8 3"), "`-3` is no whole number"),
            (ROWS.replace("HashMatrix", ""), "not the head"),
            (String::new(), "not the head"),
        ];
        for (text, told) in damaged {
            let why = matrix(&text).expect_err(told).to_string();
            assert!(why.contains(told), "{why}");
        }
        for (text, told) in [
            ("", "begins with ``"),
            ("1.5 2", "begins with `1.5`"),
            ("2 1", "announces 2 values and has 1"),
            ("1 inf", "a value is inf"),
            ("18446744073709551615 1", "and has 1"),
        ] {
            let why = array(text).expect_err(told).to_string();
            assert!(why.contains(told), "{why}");
        }
    }

    #[test]
    fn all_digits_of_an_array_return() -> Result<(), Error> {
        let values = [0.1 + 0.2, -f64::MIN_POSITIVE, 1e300, 0.0, 1.0 / 3.0];
        assert_eq!(array(&array_text(&values))?, values);
        Ok(())
    }
}

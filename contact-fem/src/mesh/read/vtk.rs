//! VTK's legacy files, `.vtk`: unstructured grids with simplices of order 1 or 2, as VTK, ParaView, meshio and Gmsh write them, in text
//! or binary, in versions up to 4.2 and since 5.0. Cells and facets with the same number in the integer cell data that are [`LABELS`]
//! form a group.
//!
//! Binary numbers are big-endian. Other data are passed over.

use super::contents::Contents;
use super::cursor::Cursor;
use super::grid::{Grid, LABELS, chosen};
use super::problem::{Fault, Problem, excerpt};

const FIRST: &[u8] = b"# vtk DataFile";

/// Whether the file begins with the words that every legacy file of VTK has.
pub(super) fn recognised(start: &[u8]) -> bool {
    start.starts_with(FIRST)
}

/// Reads the whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Contents, Fault> {
    let mut file = File::begin(bytes)?;
    let (mut points, mut cells, mut types) = (Vec::new(), Cells::default(), Vec::new());
    let mut labels = Labels::default();
    // whether data are of cells, and the number of cells or points
    let mut data = None;
    while let Some(keyword) = file.at.word() {
        match upper(keyword).as_str() {
            "POINTS" => {
                let count = file.at.text_size("the number of points")?;
                let kind = file.kind()?;
                points = file.numbers("coordinates", count.saturating_mul(3), kind)?;
                file.width = 3;
            }
            "CELLS" => cells = file.cells()?,
            "CELL_TYPES" => {
                let count = file.at.text_size("the number of cells")?;
                types = file.numbers("types of cells", count, Kind::Signed(4))?;
            }
            "CELL_DATA" => data = Some((true, file.at.text_size("the number of cells")?)),
            "POINT_DATA" => data = Some((false, file.at.text_size("the number of points")?)),
            "METADATA" => file.pass_metadata(),
            "FIELD" => file.field(&mut labels, data.is_some_and(|(cells, _)| cells))?,
            other => match data {
                Some((of_cells, count)) => file.data(other, count, of_cells, &mut labels)?,
                None => {
                    let what = "POINTS, CELLS, CELL_TYPES, CELL_DATA or POINT_DATA";
                    return Err(file.at.unexpected(what, Some(keyword)));
                }
            },
        }
    }
    let grid = Grid {
        points: &points,
        connectivity: &cells.connectivity,
        offsets: &cells.offsets,
        types: &types,
        labels: chosen(labels.0.iter().flatten().map(Vec::as_slice), types.len()),
    };
    let mut contents = Contents::default();
    grid.add_to(&mut contents)?;
    contents.check("`POINTS`", "`CELLS`")?;
    Ok(contents)
}

/// The type of an array's numbers, with its bytes in binary.
#[derive(Clone, Copy)]
enum Kind {
    Signed(usize),
    Unsigned(usize),
    Real(usize),
    /// One bit each, eight in a byte.
    Bit,
    /// Strings: in binary with their lengths before them, in text a line each.
    Text,
}

/// The nodes of all cells, one cell after the other, and the places where the nodes of each cell end.
#[derive(Default)]
struct Cells {
    connectivity: Vec<f64>,
    offsets: Vec<f64>,
}

/// The cell data that may be labels, by their place in [`LABELS`].
#[derive(Default)]
struct Labels([Option<Vec<f64>>; LABELS.len()]);

impl Labels {
    /// The place of cell data with this name, if they may be labels.
    fn place(&mut self, name: &[u8]) -> Option<&mut Option<Vec<f64>>> {
        let name = decoded(name);
        let k = LABELS.iter().position(|label| label.as_bytes() == name)?;
        self.0.get_mut(k)
    }
}

/// A name in which VTK wrote some characters as `%` and two hexadecimal digits.
fn decoded(name: &[u8]) -> Vec<u8> {
    let mut decoded = Vec::with_capacity(name.len());
    let mut left = name;
    while let Some((&first, rest)) = left.split_first() {
        let digits = rest.get(..2).filter(|_| first == b'%');
        let digits = digits.and_then(|digits| std::str::from_utf8(digits).ok());
        let byte = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        decoded.push(byte.unwrap_or(first));
        left = if byte.is_some() { &rest[2..] } else { rest };
    }
    decoded
}

/// The file, after its head.
struct File<'a> {
    at: Cursor<'a>,
    is_binary: bool,
    /// Whether cells have offsets, since version 5.
    has_offsets: bool,
    /// The number of components of the last array.
    width: u64,
}

fn upper(word: &[u8]) -> String {
    String::from_utf8_lossy(word).to_ascii_uppercase()
}

impl<'a> File<'a> {
    /// Reads the four lines of the head.
    fn begin(bytes: &'a [u8]) -> Result<Self, Fault> {
        let mut file = File {
            at: Cursor::new(bytes, None),
            is_binary: false,
            has_offsets: false,
            width: 1,
        };
        let first = file.line();
        let version = first.rsplit(|b| b.is_ascii_whitespace()).next();
        let major = version.and_then(|version| version.split(|b| *b == b'.').next());
        file.has_offsets = match major {
            Some(b"1" | b"2" | b"3" | b"4") => false,
            Some(b"5") => true,
            _ => return Err(file.at.unexpected("a version up to 5", version)),
        };
        let _title = file.line();
        let form = file.at.word();
        file.is_binary = match form.map(upper).as_deref() {
            Some("ASCII") => false,
            Some("BINARY") => true,
            _ => return Err(file.at.unexpected("`ASCII` or `BINARY`", form)),
        };
        let word = file.at.word();
        if word.map(upper).as_deref() != Some("DATASET") {
            return Err(file.at.unexpected("`DATASET`", word));
        }
        let set = file.at.word();
        match set.map(upper).as_deref() {
            Some("UNSTRUCTURED_GRID") => Ok(file),
            _ => {
                let found = format!("VTK's {}", excerpt(set.unwrap_or_default()));
                let remedy = "write an unstructured grid";
                Err(file.at.fault(Problem::Unsupported { found, remedy }))
            }
        }
    }

    /// The rest of the line, without white space at its end.
    fn line(&mut self) -> &'a [u8] {
        let rest = self.at.rest();
        let length = rest.iter().position(|&b| b == b'\n');
        let line = &rest[..length.unwrap_or(rest.len())];
        self.skip(length.map_or(rest.len(), |length| length + 1));
        line.trim_ascii_end()
    }

    /// Moves on by so many of the bytes that are left.
    fn skip(&mut self, bytes: usize) {
        let end = self.at.position() + bytes.min(self.at.rest().len());
        // at most the end of the file
        let _ = self.at.move_to(end as u64);
    }

    /// Reads the name of a type.
    fn kind(&mut self) -> Result<Kind, Fault> {
        let word = self.at.word();
        let name = word.unwrap_or_default().to_ascii_lowercase();
        Ok(match &name[..] {
            b"bit" => Kind::Bit,
            b"char" | b"signed_char" | b"vtktypeint8" => Kind::Signed(1),
            b"short" | b"vtktypeint16" => Kind::Signed(2),
            // VTK writes its indices with four bytes into legacy files
            b"int" | b"vtktypeint32" | b"vtkidtype" => Kind::Signed(4),
            b"long" | b"vtktypeint64" => Kind::Signed(8),
            b"unsigned_char" | b"vtktypeuint8" => Kind::Unsigned(1),
            b"unsigned_short" | b"vtktypeuint16" => Kind::Unsigned(2),
            b"unsigned_int" | b"vtktypeuint32" => Kind::Unsigned(4),
            b"unsigned_long" | b"vtktypeuint64" => Kind::Unsigned(8),
            b"float" => Kind::Real(4),
            b"double" => Kind::Real(8),
            b"string" | b"utf8_string" => Kind::Text,
            _ => return Err(self.at.unexpected("a type of numbers, as `double`", word)),
        })
    }

    /// Reads so many numbers.
    fn numbers(&mut self, what: &'static str, count: u64, kind: Kind) -> Result<Vec<f64>, Fault> {
        if !self.is_binary {
            let count = self.at.room(what, count, 1, 0)?;
            return (0..count).map(|_| self.at.real(what)).collect();
        }
        let bytes = self.bytes(what, count, kind)?;
        Ok(match kind {
            Kind::Real(4) => each(bytes, |b| f32::from_be_bytes(b).into()),
            Kind::Real(_) => each(bytes, f64::from_be_bytes),
            Kind::Signed(1) => each(bytes, |b| i8::from_be_bytes(b).into()),
            Kind::Signed(2) => each(bytes, |b| i16::from_be_bytes(b).into()),
            Kind::Signed(4) => each(bytes, |b| i32::from_be_bytes(b).into()),
            Kind::Signed(_) => each(bytes, |b| i64::from_be_bytes(b) as f64),
            Kind::Unsigned(1) => each(bytes, |b| u8::from_be_bytes(b).into()),
            Kind::Unsigned(2) => each(bytes, |b| u16::from_be_bytes(b).into()),
            Kind::Unsigned(4) => each(bytes, |b| u32::from_be_bytes(b).into()),
            Kind::Unsigned(_) => each(bytes, |b| u64::from_be_bytes(b) as f64),
            Kind::Bit | Kind::Text => {
                return Err(self
                    .at
                    .unexpected("a type of numbers", Some(b"bit or string")));
            }
        })
    }

    /// The bytes of so many binary numbers, from the next line on.
    fn bytes(&mut self, what: &'static str, count: u64, kind: Kind) -> Result<&'a [u8], Fault> {
        self.line();
        let rest = self.at.rest();
        let length = usize::try_from(count).ok().and_then(|count| match kind {
            Kind::Signed(size) | Kind::Unsigned(size) | Kind::Real(size) => count.checked_mul(size),
            Kind::Bit => Some(count.div_ceil(8)),
            Kind::Text => strings(rest, count),
        });
        let found = length.and_then(|length| rest.get(..length));
        let found = found.ok_or_else(|| {
            self.at.fault(Problem::Count {
                what,
                count,
                bytes: rest.len(),
            })
        })?;
        self.skip(found.len());
        Ok(found)
    }

    /// Passes over so many numbers, or strings.
    fn pass(&mut self, what: &'static str, count: u64, kind: Kind) -> Result<(), Fault> {
        if self.is_binary {
            return self.bytes(what, count, kind).map(drop);
        }
        let count = self.at.room(what, count, 1, 0)?;
        if let Kind::Text = kind {
            self.line();
            for _ in 0..count {
                self.line();
            }
            return Ok(());
        }
        for _ in 0..count {
            self.at.real(what)?;
        }
        Ok(())
    }

    /// Skips the next word, which must be this keyword in any case of its letters.
    fn keyword(&mut self, keyword: &str) -> Result<(), Fault> {
        let word = self.at.word();
        match word.map(upper).as_deref() == Some(keyword) {
            true => Ok(()),
            false => Err(self.at.unexpected(&format!("`{keyword}`"), word)),
        }
    }

    /// Reads the cells: nodes with their number before each cell, or the nodes of all cells with offsets.
    fn cells(&mut self) -> Result<Cells, Fault> {
        let what = "nodes of cells";
        let count = self.at.text_size("the number of cells")?;
        let size = self.at.text_size("the number of nodes")?;
        let mut cells = Cells::default();
        if self.has_offsets {
            self.keyword("OFFSETS")?;
            let kind = self.kind()?;
            cells.offsets = self.numbers("offsets of cells", count, kind)?;
            self.keyword("CONNECTIVITY")?;
            let kind = self.kind()?;
            cells.connectivity = self.numbers(what, size, kind)?;
            // the first one is where the first cell begins
            if let Some(&first) = cells.offsets.first() {
                if first != 0.0 {
                    return Err(self.at.wrong("the first offset, 0", first));
                }
                cells.offsets.remove(0);
            }
            return Ok(cells);
        }
        let all = self.numbers(what, size, Kind::Signed(4))?;
        let mut left = &all[..];
        for _ in 0..count {
            let nodes = left.split_first().and_then(|(&count, rest)| {
                let is_count = count >= 0.0 && count.fract() == 0.0;
                is_count.then_some(rest)?.split_at_checked(count as usize)
            });
            let Some((nodes, rest)) = nodes else {
                return Err(self.at.fault(Problem::Total {
                    what: "cells",
                    announced: count,
                    found: cells.offsets.len() as u64,
                }));
            };
            cells.connectivity.extend(nodes);
            cells.offsets.push(cells.connectivity.len() as f64);
            left = rest;
        }
        match left.is_empty() {
            true => Ok(cells),
            false => Err(self.at.fault(Problem::Total {
                what,
                announced: size,
                found: (all.len() - left.len()) as u64,
            })),
        }
    }

    /// Reads a field: arrays with names.
    fn field(&mut self, labels: &mut Labels, of_cells: bool) -> Result<(), Fault> {
        self.at.word();
        let count = self.at.text_size("the number of arrays")?;
        for _ in 0..self.at.room("arrays", count, 4, 8)? {
            let mut name = self.at.word().unwrap_or_default();
            while name == b"METADATA" {
                self.pass_metadata();
                name = self.at.word().unwrap_or_default();
            }
            // an array without values, of which VTK writes this alone
            if name == b"NULL_ARRAY" {
                continue;
            }
            let width = self.at.text_size("the number of components")?;
            let length = self.at.text_size("the length of an array")?;
            let kind = self.kind()?;
            let place = if of_cells { labels.place(name) } else { None };
            self.width = width;
            self.array(width.saturating_mul(length), kind, place)?;
        }
        Ok(())
    }

    /// Reads the data of a keyword, `count` values of points or cells.
    fn data(
        &mut self,
        keyword: &str,
        count: u64,
        of_cells: bool,
        labels: &mut Labels,
    ) -> Result<(), Fault> {
        let name = self.at.word().unwrap_or_default();
        let what = "values of the data";
        match keyword {
            "SCALARS" => {
                let kind = self.kind()?;
                let mut width = 1;
                let mut word = self.at.word();
                if let Some(number) =
                    word.and_then(|word| std::str::from_utf8(word).ok()?.parse().ok())
                {
                    width = number;
                    word = self.at.word();
                }
                if word.map(upper).as_deref() != Some("LOOKUP_TABLE") {
                    return Err(self.at.unexpected("`LOOKUP_TABLE`", word));
                }
                self.at.word();
                let place = if of_cells { labels.place(name) } else { None };
                self.width = width;
                self.array(count.saturating_mul(width), kind, place)
            }
            // red, green, blue and opacity
            "LOOKUP_TABLE" => {
                let size = self.at.text_size("the size of a table")?;
                self.pass(what, size.saturating_mul(4), Kind::Unsigned(1))
            }
            "COLOR_SCALARS" => {
                let width = self.at.text_size("the number of components")?;
                self.pass(what, count.saturating_mul(width), Kind::Unsigned(1))
            }
            "TEXTURE_COORDINATES" => {
                let width = self.at.text_size("the number of components")?;
                let kind = self.kind()?;
                self.pass(what, count.saturating_mul(width), kind)
            }
            "VECTORS" | "NORMALS" | "TENSORS" | "TENSORS6" | "GLOBAL_IDS" | "PEDIGREE_IDS"
            | "EDGE_FLAGS" => {
                let kind = self.kind()?;
                let width = match keyword {
                    "VECTORS" | "NORMALS" => 3,
                    "TENSORS" => 9,
                    "TENSORS6" => 6,
                    _ => 1,
                };
                self.width = width;
                self.pass(what, count.saturating_mul(width), kind)
            }
            _ => Err(self
                .at
                .unexpected("the keyword of data", Some(keyword.as_bytes()))),
        }
    }

    /// Reads the numbers of an array to its place, or passes over them.
    fn array(
        &mut self,
        count: u64,
        kind: Kind,
        place: Option<&mut Option<Vec<f64>>>,
    ) -> Result<(), Fault> {
        let what = "values of the data";
        match (place, kind) {
            (None, _) | (_, Kind::Text | Kind::Bit) => self.pass(what, count, kind),
            (Some(place), _) => {
                *place = Some(self.numbers(what, count, kind)?);
                Ok(())
            }
        }
    }

    /// Passes over notes about the last array, which end with an empty line. The names of its components may be empty lines, too.
    fn pass_metadata(&mut self) {
        self.line();
        while !self.at.rest().is_empty() {
            match self.line() {
                b"" => return,
                b"COMPONENT_NAMES" => {
                    for _ in 0..self.width.min(self.at.rest().len() as u64) {
                        self.line();
                    }
                }
                _ => {}
            }
        }
    }
}

/// The numbers in `bytes`.
fn each<const N: usize>(bytes: &[u8], number: impl Fn([u8; N]) -> f64) -> Vec<f64> {
    let all = bytes.chunks_exact(N);
    all.filter_map(|bytes| bytes.first_chunk().map(|bytes| number(*bytes)))
        .collect()
}

/// The bytes of so many strings. The length of each stands before it: the first two bits tell in how many bytes.
fn strings(bytes: &[u8], count: usize) -> Option<usize> {
    let mut at = 0;
    for _ in 0..count {
        let first = *bytes.get(at)?;
        let wide = [8, 4, 2, 1][usize::from(first >> 6)];
        let length = bytes.get(at..at + wide)?;
        let low = length
            .iter()
            .fold(0_u64, |sum, b| (sum << 8) | u64::from(*b));
        let mask = u64::MAX >> (64 - 8 * wide as u32 + 2);
        at = at
            .checked_add(wide)?
            .checked_add(usize::try_from(low & mask).ok()?)?;
        if at > bytes.len() {
            return None;
        }
    }
    Some(at)
}

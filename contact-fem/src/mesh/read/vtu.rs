//! VTK's `.vtu` files: unstructured grids with simplices of order 1 or 2, as FreeFEM's `savevtk` and ParaView write them, as
//! text or with inline binary data, not compressed. Cells and facets with the same number in the integer cell data `Label` form a group.
//!
//! FreeFEM 4.9 writes coordinates in single precision, and leaves out the attribute `version`.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::ElementKind;
use super::contents::Contents;
use super::problem::{Fault, Place, Problem, excerpt};

/// Reads the whole file.
pub(super) fn read(bytes: &[u8]) -> Result<Contents, Fault> {
    let mut reader = Reader::from_reader(bytes);
    let mut file = File::default();
    let mut contents = Contents::default();
    loop {
        let place = Place::Byte(usize::try_from(reader.buffer_position()).unwrap_or(0));
        let at = |problem| Fault { place, problem };
        let event = reader.read_event();
        let event = event.map_err(|why| at(expected("well-formed XML", &why.to_string())))?;
        match event {
            Event::Start(tag) => file.open(&tag).map_err(at)?,
            Event::Text(text) => file.take(&text).map_err(at)?,
            Event::End(tag) => {
                match tag.name().as_ref() {
                    b"Piece" => file.finish(&mut contents).map_err(at)?,
                    b"VTKFile" => break,
                    _ => {}
                }
                file.array = None;
            }
            Event::Eof if file.is_grid => {
                let expected = "the end of `VTKFile`".to_string();
                return Err(Problem::Truncated { expected }.into());
            }
            Event::Eof => return Err(unsupported("an XML file without `VTKFile`").into()),
            _ => {}
        }
    }
    contents.check("`Points`", "`Cells`")?;
    Ok(contents)
}

fn unsupported(found: &str) -> Problem {
    Problem::Unsupported {
        found: found.to_string(),
        remedy: "write an unstructured grid in one .vtu file of a little-endian machine, as text or with inline binary \
            data, not compressed",
    }
}

fn expected(what: &str, found: &str) -> Problem {
    Problem::Expected {
        expected: what.to_string(),
        found: found.to_string(),
    }
}

/// What is known of the file so far; arrays are those of the present piece.
#[derive(Default)]
struct File {
    is_grid: bool,
    has_long_headers: bool,
    section: Option<Section>,
    array: Option<Array>,
    points: Vec<f64>,
    connectivity: Vec<f64>,
    offsets: Vec<f64>,
    types: Vec<f64>,
    labels: Option<Vec<f64>>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Section {
    Points,
    Cells,
    CellData,
    Other,
}

/// An array that is read.
struct Array {
    what: Kept,
    number: String,
    is_binary: bool,
}

#[derive(Clone, Copy)]
enum Kept {
    Points,
    Connectivity,
    Offsets,
    Types,
    Labels,
}

/// The value of an attribute; empty if it is missing.
fn attribute(tag: &BytesStart<'_>, name: &str) -> String {
    let found = tag.try_get_attribute(name).ok().flatten();
    let value = found.map(|value| String::from_utf8_lossy(&value.value).trim().to_string());
    value.unwrap_or_default()
}

impl File {
    fn open(&mut self, tag: &BytesStart<'_>) -> Result<(), Problem> {
        match tag.name().as_ref() {
            b"VTKFile" => {
                let kind = attribute(tag, "type");
                if kind != "UnstructuredGrid" {
                    return Err(unsupported(&format!("a VTK file with `{kind}`")));
                }
                if attribute(tag, "byte_order") == "BigEndian" {
                    return Err(unsupported("a VTK file of a big-endian machine"));
                }
                if !attribute(tag, "compressor").is_empty() {
                    return Err(unsupported("a compressed VTK file"));
                }
                self.is_grid = true;
                self.has_long_headers = attribute(tag, "header_type") == "UInt64";
            }
            b"Points" => self.section = Some(Section::Points),
            b"Cells" => self.section = Some(Section::Cells),
            b"CellData" => self.section = Some(Section::CellData),
            b"PointData" | b"FieldData" => self.section = Some(Section::Other),
            b"DataArray" => self.array = self.array_of(tag)?,
            _ => {}
        }
        Ok(())
    }

    /// The array that begins here, if it is needed.
    fn array_of(&self, tag: &BytesStart<'_>) -> Result<Option<Array>, Problem> {
        let name = attribute(tag, "Name");
        let what = match (self.section, name.as_str()) {
            (Some(Section::Points), _) => Kept::Points,
            (Some(Section::Cells), "connectivity") => Kept::Connectivity,
            (Some(Section::Cells), "offsets") => Kept::Offsets,
            (Some(Section::Cells), "types") => Kept::Types,
            (Some(Section::CellData), "Label") => Kept::Labels,
            _ => return Ok(None),
        };
        let is_binary = match attribute(tag, "format").as_str() {
            "ascii" => false,
            "binary" => true,
            other => {
                return Err(unsupported(&format!(
                    "a VTK file with data in the format `{other}`"
                )));
            }
        };
        let number = attribute(tag, "type");
        Ok(Some(Array {
            what,
            number,
            is_binary,
        }))
    }

    fn take(&mut self, text: &[u8]) -> Result<(), Problem> {
        let Some(array) = &self.array else {
            return Ok(());
        };
        let values = match array.is_binary {
            true => from_binary(text, &array.number, self.has_long_headers)?,
            false => from_text(text)?,
        };
        match array.what {
            Kept::Points => self.points = values,
            Kept::Connectivity => self.connectivity = values,
            Kept::Offsets => self.offsets = values,
            Kept::Types => self.types = values,
            Kept::Labels => self.labels = Some(values),
        }
        Ok(())
    }

    /// Adds the points and elements of the piece that ends here.
    fn finish(&mut self, contents: &mut Contents) -> Result<(), Problem> {
        let piece = std::mem::take(self);
        self.is_grid = piece.is_grid;
        self.has_long_headers = piece.has_long_headers;
        let first = contents.vertices.len();
        for (number, x) in piece.points.chunks(3).enumerate() {
            let three = "three coordinates of each point";
            let x = x.try_into().map_err(|_| expected(three, "fewer"))?;
            contents.add_vertex(number as u64, x)?;
        }
        let count = contents.vertices.len() - first;
        let cells = piece.types.len();
        let has_labels = piece
            .labels
            .as_ref()
            .is_none_or(|labels| labels.len() == cells);
        if piece.offsets.len() != cells || !has_labels {
            let one = "as many offsets and labels as types of cells";
            return Err(expected(one, "other numbers of them"));
        }
        let mut begin = 0;
        for (cell, (&kind, &end)) in piece.types.iter().zip(&piece.offsets).enumerate() {
            let kind = element_kind(kind)?;
            let end = whole(end).and_then(|end| usize::try_from(end).ok());
            let nodes = end.and_then(|end| piece.connectivity.get(begin..end));
            let nodes = nodes.filter(|nodes| nodes.len() == kind.nodes());
            let nodes = nodes
                .ok_or_else(|| expected(&format!("the nodes of a {kind}"), "other offsets"))?;
            begin += nodes.len();
            let mut found = [0; 10];
            for (found, &node) in found.iter_mut().zip(nodes) {
                let index = whole(node).and_then(|node| usize::try_from(node).ok());
                let index = index.filter(|&index| index < count);
                *found = first
                    + index.ok_or_else(|| Problem::UnknownNode {
                        number: node.to_string(),
                        nodes: count,
                    })?;
            }
            let label = match piece.labels.as_ref().map(|labels| labels[cell]) {
                Some(label) => Some(
                    whole(label).ok_or_else(|| expected("an integer label", &label.to_string()))?,
                ),
                None => None,
            };
            let groups = |contents: &mut Contents| match label {
                Some(label) => vec![contents.group(kind.dimension(), label)],
                None => Vec::new(),
            };
            let all = contents.nodes_of(kind, label.unwrap_or(0), groups);
            all.extend(&found[..kind.nodes()]);
        }
        Ok(())
    }
}

/// A number without a fraction.
fn whole(value: f64) -> Option<i64> {
    (value.fract() == 0.0 && value.abs() < 9e15).then_some(value as i64)
}

fn from_text(text: &[u8]) -> Result<Vec<f64>, Problem> {
    let words = text
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty());
    let number = |word: &[u8]| {
        let number = std::str::from_utf8(word)
            .ok()
            .and_then(|word| word.parse().ok());
        number.ok_or_else(|| expected("a number", &excerpt(word)))
    };
    words.map(number).collect()
}

/// Base64 of the number of bytes and the bytes; either alone, or both together.
fn from_binary(text: &[u8], number: &str, has_long_headers: bool) -> Result<Vec<f64>, Problem> {
    let letters: Vec<u8> = text
        .iter()
        .copied()
        .filter(|byte| !byte.is_ascii_whitespace())
        .collect();
    let mut bytes = Vec::with_capacity(letters.len() / 4 * 3 + 3);
    for four in letters.chunks(4) {
        let mut three = [0; 3];
        let found = STANDARD.decode_slice(four, &mut three);
        let found = found.map_err(|_| expected("base64", &excerpt(four)))?;
        bytes.extend(&three[..found]);
    }
    let header = if has_long_headers { 8 } else { 4 };
    let missing = || Problem::Truncated {
        expected: "the data of an array".to_string(),
    };
    let (length, data) = bytes.split_at_checked(header).ok_or_else(missing)?;
    let length = length
        .iter()
        .rev()
        .fold(0_u64, |sum, &byte| sum << 8 | u64::from(byte));
    let length = usize::try_from(length)
        .ok()
        .filter(|&length| length <= data.len());
    let data = &data[..length.ok_or_else(missing)?];
    macro_rules! numbers {
        ($kind:ty) => {
            data.chunks_exact(size_of::<$kind>())
                .map(|bytes| <$kind>::from_le_bytes(bytes.try_into().unwrap_or_default()) as f64)
                .collect()
        };
    }
    Ok(match number {
        "Float32" => numbers!(f32),
        "Float64" => numbers!(f64),
        "Int8" => numbers!(i8),
        "UInt8" => numbers!(u8),
        "Int16" => numbers!(i16),
        "UInt16" => numbers!(u16),
        "Int32" => numbers!(i32),
        "UInt32" => numbers!(u32),
        "Int64" => numbers!(i64),
        "UInt64" => numbers!(u64),
        other => return Err(expected("a type of numbers such as `Float64`", other)),
    })
}

/// The kind with this number of VTK.
fn element_kind(number: f64) -> Result<ElementKind, Problem> {
    Ok(match whole(number) {
        Some(1) => ElementKind::Point,
        Some(3) => ElementKind::Segment,
        Some(5) => ElementKind::Triangle,
        Some(10) => ElementKind::Tetrahedron,
        Some(21) => ElementKind::Segment3,
        Some(22) => ElementKind::Triangle6,
        Some(24) => ElementKind::Tetrahedron10,
        _ => {
            let kind = format!("VTK's {number}");
            return Err(Problem::UnsupportedElement { kind });
        }
    })
}

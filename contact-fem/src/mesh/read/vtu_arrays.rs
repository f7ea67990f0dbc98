//! The arrays of numbers in VTK's `.vtu` files: as text or with inline binary data, not compressed.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::problem::{Fault, Place, Problem, excerpt};

/// Where an array stands in a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Section {
    Points,
    Cells,
    PointData,
    CellData,
    FieldData,
}

/// A piece of an unstructured grid.
#[derive(Default)]
pub(crate) struct Piece {
    /// The arrays that are wanted, with their sections and names.
    arrays: Vec<(Section, String, Vec<f64>)>,
    /// Where it ends.
    end: Option<Place>,
}

impl Piece {
    /// The values of an array, if the piece has it; one of points has any name.
    pub fn array(&self, section: Section, name: &str) -> Option<&[f64]> {
        let mut arrays = self.arrays.iter();
        let is_it = |(own, its_name, _): &&(Section, String, Vec<f64>)| {
            *own == section && (section == Section::Points || its_name == name)
        };
        arrays.find(is_it).map(|(_, _, values)| values.as_slice())
    }

    /// The problem, at the end of this piece.
    pub fn fault(&self, problem: Problem) -> Fault {
        let place = self.end.unwrap_or(Place::File);
        Fault { place, problem }
    }
}

/// Reads those arrays of all pieces that are wanted.
pub(crate) fn pieces(
    bytes: &[u8],
    is_wanted: impl Fn(Section, &str) -> bool,
) -> Result<Vec<Piece>, Fault> {
    let mut reader = Reader::from_reader(bytes);
    let (mut file, mut pieces) = (File::default(), Vec::new());
    loop {
        let place = Place::Byte(usize::try_from(reader.buffer_position()).unwrap_or(0));
        let at = |problem| Fault { place, problem };
        let event = reader.read_event();
        let event = event.map_err(|why| at(expected("well-formed XML", &why.to_string())))?;
        match event {
            Event::Start(tag) => file.open(&tag, &is_wanted).map_err(at)?,
            Event::Text(text) => file.take(&text),
            Event::CData(_) | Event::GeneralRef(_) if file.array.is_some() => {
                return Err(at(expected("numbers", "other text")));
            }
            Event::End(tag) => match tag.name().as_ref() {
                b"DataArray" => file.close().map_err(at)?,
                b"Piece" => {
                    let mut piece = std::mem::take(&mut file.piece);
                    piece.end = Some(place);
                    pieces.push(piece);
                }
                b"VTKFile" => return Ok(pieces),
                _ => {}
            },
            Event::Eof if file.is_grid => {
                let expected = "the end of `VTKFile`".to_string();
                return Err(Problem::Truncated { expected }.into());
            }
            Event::Eof => return Err(unsupported("an XML file without `VTKFile`").into()),
            _ => {}
        }
    }
}

fn unsupported(found: &str) -> Problem {
    Problem::Unsupported {
        found: found.to_string(),
        remedy: "write an unstructured grid in one .vtu file of a little-endian machine, as text or with inline binary \
            data, not compressed",
    }
}

pub(super) fn expected(what: &str, found: &str) -> Problem {
    Problem::Expected {
        expected: what.to_string(),
        found: found.to_string(),
    }
}

/// What is known of the file so far.
#[derive(Default)]
struct File {
    is_grid: bool,
    has_long_headers: bool,
    section: Option<Section>,
    array: Option<Array>,
    piece: Piece,
}

/// An array that is read.
struct Array {
    section: Section,
    name: String,
    number: String,
    is_binary: bool,
    text: Vec<u8>,
}

/// The value of an attribute; empty if it is missing.
fn attribute(tag: &BytesStart<'_>, name: &str) -> String {
    let found = tag.try_get_attribute(name).ok().flatten();
    let value = found.map(|value| String::from_utf8_lossy(&value.value).trim().to_string());
    value.unwrap_or_default()
}

impl File {
    fn open(
        &mut self,
        tag: &BytesStart<'_>,
        is_wanted: impl Fn(Section, &str) -> bool,
    ) -> Result<(), Problem> {
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
            b"PointData" => self.section = Some(Section::PointData),
            b"CellData" => self.section = Some(Section::CellData),
            b"FieldData" => self.section = Some(Section::FieldData),
            b"DataArray" => self.array = self.array_of(tag, is_wanted)?,
            _ => {}
        }
        Ok(())
    }

    /// The array that begins here, if it is wanted.
    fn array_of(
        &self,
        tag: &BytesStart<'_>,
        is_wanted: impl Fn(Section, &str) -> bool,
    ) -> Result<Option<Array>, Problem> {
        let name = attribute(tag, "Name");
        let section = self.section.filter(|section| is_wanted(*section, &name));
        let Some(section) = section else {
            return Ok(None);
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
        Ok(Some(Array {
            section,
            name,
            number: attribute(tag, "type"),
            is_binary,
            text: Vec::new(),
        }))
    }

    fn take(&mut self, text: &[u8]) {
        if let Some(array) = &mut self.array {
            array.text.extend(text);
        }
    }

    /// Reads the numbers of the array that ends here.
    fn close(&mut self) -> Result<(), Problem> {
        let Some(array) = self.array.take() else {
            return Ok(());
        };
        let values = match array.is_binary {
            true => from_binary(&array.text, &array.number, self.has_long_headers)?,
            false => from_text(&array.text)?,
        };
        let arrays = &mut self.piece.arrays;
        arrays.push((array.section, array.name, values));
        Ok(())
    }
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

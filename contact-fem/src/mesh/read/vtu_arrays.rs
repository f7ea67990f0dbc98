//! The arrays of numbers in VTK's `.vtu` files: as text, or binary as [`vtu_data`](super::vtu_data) reads it.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::grid::expected;
use super::problem::{Fault, Place, Problem, excerpt};
use super::vtu_data::{Appended, Codec, Coding, Source};

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
    /// The numbers of points and cells that it announces.
    pub announced: [Option<u64>; 2],
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
    let (grid, appended) = Appended::split(bytes)?;
    let mut reader = Reader::from_reader(grid);
    let (mut file, mut pieces) = (File::default(), Vec::new());
    file.coding.most = Coding::most_of(bytes);
    loop {
        let place = Place::Byte(usize::try_from(reader.buffer_position()).unwrap_or(0));
        let at = |problem| Fault { place, problem };
        let event = reader.read_event();
        let event = event.map_err(|why| at(expected("well-formed XML", &why.to_string())))?;
        match event {
            Event::Start(tag) => file.open(&tag, &is_wanted).map_err(at)?,
            Event::Empty(tag) if tag.name().as_ref() == b"DataArray" => {
                file.open(&tag, &is_wanted).map_err(at)?;
                file.close(appended.as_ref()).map_err(at)?;
            }
            Event::Text(text) => file.take(&text),
            Event::CData(_) | Event::GeneralRef(_) if file.array.is_some() => {
                return Err(at(expected("numbers", "other text")));
            }
            Event::End(tag) => match tag.name().as_ref() {
                b"DataArray" => file.close(appended.as_ref()).map_err(at)?,
                b"InformationKey" => file.is_aside = false,
                b"Piece" => {
                    let mut piece = std::mem::take(&mut file.piece);
                    piece.end = Some(place);
                    pieces.push(piece);
                }
                b"VTKFile" => return Ok(pieces),
                _ => {}
            },
            // what follows is data
            Event::Eof if file.is_grid && appended.is_some() => return Ok(pieces),
            Event::Eof if file.is_grid => {
                let expected = "the end of `VTKFile`".to_string();
                return Err(Problem::Truncated { expected }.into());
            }
            Event::Eof => return Err(unsupported("an XML file without `VTKFile`").into()),
            _ => {}
        }
    }
}

pub(super) fn unsupported(found: &str) -> Problem {
    Problem::Unsupported {
        found: found.to_string(),
        remedy: "write an unstructured grid in one .vtu file of a little-endian machine, as text or with binary data, not compressed, or \
            compressed by zlib or LZ4",
    }
}

/// What is known of the file so far.
#[derive(Default)]
struct File {
    is_grid: bool,
    coding: Coding,
    section: Option<Section>,
    array: Option<Array>,
    /// What is read tells about an array, and is not of it.
    is_aside: bool,
    piece: Piece,
}

/// An array that is read.
struct Array {
    section: Section,
    name: String,
    number: String,
    form: Form,
    text: Vec<u8>,
}

/// Where the numbers of an array are.
enum Form {
    Text,
    Binary,
    /// From this offset on in the appended data.
    Appended(usize),
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
                self.is_grid = true;
                self.coding.has_long_headers = attribute(tag, "header_type") == "UInt64";
                self.coding.codec = Codec::named(&attribute(tag, "compressor"))?;
            }
            b"Piece" => {
                let counts = ["NumberOfPoints", "NumberOfCells"];
                self.piece.announced = counts.map(|count| attribute(tag, count).parse().ok());
            }
            b"Points" => self.section = Some(Section::Points),
            b"Cells" => self.section = Some(Section::Cells),
            b"PointData" => self.section = Some(Section::PointData),
            b"CellData" => self.section = Some(Section::CellData),
            b"FieldData" => self.section = Some(Section::FieldData),
            b"DataArray" => self.array = self.array_of(tag, is_wanted)?,
            b"InformationKey" => self.is_aside = true,
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
        let form = match attribute(tag, "format").as_str() {
            "ascii" => Form::Text,
            "binary" => Form::Binary,
            "appended" => {
                let offset = attribute(tag, "offset");
                let number = offset.parse();
                Form::Appended(number.map_err(|_| expected("an offset", &offset))?)
            }
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
            form,
            text: Vec::new(),
        }))
    }

    fn take(&mut self, text: &[u8]) {
        if let (Some(array), false) = (&mut self.array, self.is_aside) {
            array.text.extend(text);
        }
    }

    /// Reads the numbers of the array that ends here.
    fn close(&mut self, appended: Option<&Appended<'_>>) -> Result<(), Problem> {
        let Some(array) = self.array.take() else {
            return Ok(());
        };
        let binary = |source: Source<'_>| source.numbers(&array.number, self.coding);
        let values = match array.form {
            Form::Text => from_text(&array.text)?,
            Form::Binary => binary(Source::base64(&array.text))?,
            Form::Appended(offset) => {
                let appended = appended.ok_or_else(|| Problem::Truncated {
                    expected: "`AppendedData`".to_string(),
                })?;
                binary(appended.from(offset)?)?
            }
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

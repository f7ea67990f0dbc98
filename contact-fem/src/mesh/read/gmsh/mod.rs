//! Gmsh's MSH files, versions 4.1 and 2.2, text and binary.
//!
//! A file consists of sections between `$Name` and `$EndName`. Sections without mesh data are
//! skipped, comments as well.

mod element_type;
mod v22;
mod v41;

use std::collections::HashMap;

use super::contents::Contents;
use super::cursor::Cursor;
use super::problem::{Fault, Problem, excerpt};
use super::{ElementKind, Format};

/// A reader of a file.
struct Reader<'a> {
    file: Cursor<'a>,
    contents: Contents,
    /// Vertices by their numbers in the file, which need not be contiguous.
    numbers: HashMap<u64, usize>,
}

/// Reads the whole file.
pub(super) fn read(bytes: &[u8]) -> Result<(Format, Contents), Fault> {
    let mut file = Cursor::new(bytes, None);
    let format = header(&mut file)?;
    let mut reader = Reader {
        file,
        contents: Contents::default(),
        numbers: HashMap::new(),
    };
    match format {
        Format::Gmsh22 => v22::sections(&mut reader)?,
        _ => v41::sections(&mut reader)?,
    }
    reader.contents.check("`$Nodes`", "`$Elements`")?;
    Ok((format, reader.contents))
}

/// Reads to the end of `$MeshFormat` and determines whether numbers are binary.
fn header(file: &mut Cursor) -> Result<Format, Fault> {
    const REMEDY: &str = "save it as version 4.1 or 2.2 (Gmsh: -format msh41)";
    let unsupported = |found: String, remedy| Problem::Unsupported { found, remedy };
    loop {
        match section(file)? {
            Some(b"MeshFormat") => break,
            Some(b"NOD" | b"NOE" | b"ELM") => {
                let found = "Gmsh's format in version 1".to_string();
                return Err(file.fault(unsupported(found, REMEDY)));
            }
            Some(name) => skip(file, name)?,
            None => {
                let section = "`$MeshFormat`";
                return Err(Problem::Missing { section }.into());
            }
        }
    }
    let version = file.real("the version")?;
    let format = if version == 4.1 {
        Format::Gmsh41
    } else if version == 2.2 {
        Format::Gmsh22
    } else {
        let found = format!("Gmsh's format in version {version}");
        return Err(file.fault(unsupported(found, REMEDY)));
    };
    let binary = match file.integer("0 for text or 1 for binary")? {
        0 => false,
        1 => true,
        other => return Err(file.wrong("0 for text or 1 for binary", other)),
    };
    let bytes = file.integer("the size of a number")?;
    if binary {
        if bytes != 8 {
            let found = format!("a binary file with numbers of {bytes} bytes");
            return Err(file.fault(unsupported(found, "save it as text")));
        }
        file.end_of_line()?;
        file.binary = true;
        match file.integer("the number 1")? {
            1 => {}
            0x0100_0000 => {
                let found = "a binary file of a big-endian machine".to_string();
                return Err(file.fault(unsupported(found, "save it as text")));
            }
            other => return Err(file.wrong("the number 1", other)),
        }
    }
    file.expect("$EndMeshFormat")?;
    Ok(format)
}

/// The name of the next section, or `None` at the end of the file.
fn section<'a>(file: &mut Cursor<'a>) -> Result<Option<&'a [u8]>, Fault> {
    match file.word() {
        None => Ok(None),
        Some(word) => match word.strip_prefix(b"$") {
            Some(name) if !name.starts_with(b"End") => Ok(Some(name)),
            _ => Err(file.unexpected("the beginning of a section, such as `$Nodes`", Some(word))),
        },
    }
}

/// Skips to the end of a section.
fn skip(file: &mut Cursor, name: &[u8]) -> Result<(), Fault> {
    match std::str::from_utf8(name) {
        Ok(name) => file.find(&format!("$End{name}")),
        Err(_) => Err(file.fault(Problem::NotUtf8 {
            name: excerpt(name),
        })),
    }
}

impl Reader<'_> {
    /// The problem, at the last word or number.
    fn fault(&self, problem: Problem) -> Fault {
        self.file.fault(problem)
    }

    /// Skips the rest of the line with the section's name if binary values follow it.
    fn begin(&mut self) -> Result<(), Fault> {
        match self.file.binary {
            true => self.file.end_of_line(),
            false => Ok(()),
        }
    }

    /// `$PhysicalNames`, which is text in binary files, too.
    fn physical_names(&mut self) -> Result<(), Fault> {
        let count = self.file.text_size("the number of names")?;
        for _ in 0..count {
            let dimension = self.file.text_integer("the dimension of a group")?;
            if !(0..=3).contains(&dimension) {
                return Err(self.file.wrong("a dimension from 0 to 3", dimension));
            }
            let number = self.file.text_integer("the number of a group")?;
            let word = self.file.word();
            let quoted = word.and_then(|w| w.strip_prefix(b"\"")?.strip_suffix(b"\""));
            let quoted = quoted.ok_or_else(|| self.file.unexpected("a name in quotes", word))?;
            let name = std::str::from_utf8(quoted).map_err(|_| {
                let name = excerpt(quoted);
                self.fault(Problem::NotUtf8 { name })
            })?;
            self.contents
                .name(dimension as usize, number.saturating_abs(), name);
        }
        self.file.expect("$EndPhysicalNames")
    }

    fn add_vertex(&mut self, number: u64, point: [f64; 3]) -> Result<(), Fault> {
        let vertex = self.contents.vertices.len();
        if self.numbers.insert(number, vertex).is_some() {
            return Err(self.fault(Problem::RepeatedNode { number }));
        }
        let added = self.contents.add_vertex(number, point);
        added.map_err(|problem| self.fault(problem))
    }

    /// Converts the node numbers of an element in the file to vertices, in VTK's order.
    fn vertices(&self, kind: ElementKind, numbers: &[u64]) -> Result<[usize; 10], Fault> {
        let mut vertices = [0; 10];
        for (vertex, number) in vertices.iter_mut().zip(numbers) {
            *vertex = *self.numbers.get(number).ok_or_else(|| {
                self.fault(Problem::UnknownNode {
                    number: number.to_string(),
                    nodes: self.contents.vertices.len(),
                })
            })?;
        }
        if kind == ElementKind::Tetrahedron10 {
            vertices.swap(8, 9);
        }
        Ok(vertices)
    }
}

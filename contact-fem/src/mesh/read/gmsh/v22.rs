//! The sections of MSH 2.2; binary files group elements by type.

use super::{Reader, element_type, section, skip};
use crate::mesh::read::ElementKind;
use crate::mesh::read::problem::{Fault, Problem};

/// Reads all sections after the header.
pub(super) fn sections(reader: &mut Reader) -> Result<(), Fault> {
    while let Some(name) = section(&mut reader.file)? {
        match name {
            b"PhysicalNames" => reader.physical_names()?,
            b"Nodes" => nodes(reader, false, "$EndNodes")?,
            b"ParametricNodes" => nodes(reader, true, "$EndParametricNodes")?,
            b"Elements" => elements(reader)?,
            other => skip(&mut reader.file, other)?,
        }
    }
    Ok(())
}

/// Reads the number and coordinates of each node; for a parametric node also its entity and its
/// parameters there.
fn nodes(reader: &mut Reader, parametric: bool, end: &str) -> Result<(), Fault> {
    let count = reader.file.text_size("the number of nodes")?;
    reader.begin()?;
    let count = reader.file.room("nodes", count, 4, 28)?;
    reader.contents.vertices.reserve(count);
    reader.numbers.reserve(count);
    for _ in 0..count {
        let number = number(reader, "the number of a node")?;
        let point = reader.file.point()?;
        reader.add_vertex(number, point)?;
        if parametric {
            let dimension = reader.file.integer("the dimension of an entity")?;
            reader.file.integer("the number of an entity")?;
            // Gmsh writes no parameters for nodes in a volume
            for _ in 0..if dimension == 3 {
                0
            } else {
                dimension.clamp(0, 2)
            } {
                reader.file.real("a parameter of a node")?;
            }
        }
    }
    reader.file.expect(end)
}

fn elements(reader: &mut Reader) -> Result<(), Fault> {
    let count = reader.file.text_size("the number of elements")?;
    reader.begin()?;
    let mut left = reader.file.room("elements", count, 4, 8)? as u64;
    while left > 0 {
        if reader.file.binary {
            let kind = element_kind(reader)?;
            let block = reader.file.integer("the number of elements of a type")?;
            let fits = |b: &u64| (1..=left).contains(b);
            let Some(block) = u64::try_from(block).ok().filter(fits) else {
                let expected = format!("1 to {left} elements of a type");
                return Err(reader.file.wrong(&expected, block));
            };
            let tags = reader.file.integer("the number of tags")?;
            for _ in 0..block {
                reader.file.integer("the number of an element")?;
                element(reader, kind, tags)?;
            }
            left -= block;
        } else {
            reader.file.integer("the number of an element")?;
            let kind = element_kind(reader)?;
            let tags = reader.file.integer("the number of tags")?;
            element(reader, kind, tags)?;
            left -= 1;
        }
    }
    reader.file.expect("$EndElements")
}

fn element_kind(reader: &mut Reader) -> Result<ElementKind, Fault> {
    let kind = element_type::kind(reader.file.integer("the type of an element")?);
    kind.map_err(|problem| reader.fault(problem))
}

/// Reads tags (the physical group or 0, the entity, partitions) and nodes.
fn element(reader: &mut Reader, kind: ElementKind, tags: i64) -> Result<(), Fault> {
    let mut group = 0;
    for tag in 0..tags {
        let value = reader.file.integer("a tag of an element")?;
        match tag {
            // a negative number reverses the element, which is irrelevant here
            0 => group = value.saturating_abs(),
            2 if value > 0 => return Err(reader.fault(Problem::Partitioned)),
            _ => {}
        }
    }
    let mut numbers = [0; 10];
    let numbers = &mut numbers[..kind.nodes()];
    for node in numbers.iter_mut() {
        *node = number(reader, "the number of a node")?;
    }
    let vertices = reader.vertices(kind, numbers)?;
    let nodes = reader
        .contents
        .nodes_of(kind, group, |contents| match group {
            0 => Vec::new(),
            _ => vec![contents.group(kind.dimension(), group)],
        });
    nodes.extend_from_slice(&vertices[..kind.nodes()]);
    Ok(())
}

/// The number of a node, which has four bytes in binary files.
fn number(reader: &mut Reader, what: &str) -> Result<u64, Fault> {
    let number = reader.file.integer(what)?;
    let positive = u64::try_from(number).ok();
    positive.ok_or_else(|| reader.file.wrong(what, number))
}

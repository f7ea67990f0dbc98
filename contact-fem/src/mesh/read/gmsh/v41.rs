//! The sections of MSH 4.1, which contain the same numbers in text and binary files.

use std::collections::{BTreeSet, HashMap};

use super::{Reader, element_type, section, skip};
use crate::mesh::read::problem::{Fault, Problem};

/// The groups of geometrical entities, by dimension and number; `None` if the file lists no
/// entities.
type Entities = Option<HashMap<(usize, i64), BTreeSet<usize>>>;

/// The largest number of groups of an entity. Each facet is stored once for each group of its
/// entity, so that a small file could otherwise exhaust the memory.
const MOST_GROUPS: usize = 64;

/// Reads all sections after the header.
pub(super) fn sections(reader: &mut Reader) -> Result<(), Fault> {
    let mut entities: Entities = None;
    while let Some(name) = section(&mut reader.file)? {
        match name {
            b"PhysicalNames" => reader.physical_names()?,
            b"Entities" => read_entities(reader, &mut entities)?,
            b"Nodes" => nodes(reader)?,
            b"Elements" => elements(reader, &entities)?,
            b"PartitionedEntities" | b"GhostElements" => {
                return Err(reader.fault(Problem::Partitioned));
            }
            other => skip(&mut reader.file, other)?,
        }
    }
    Ok(())
}

/// Reads the entities of each dimension: number, box (coordinates of a point), groups, bounding
/// entities.
fn read_entities(reader: &mut Reader, entities: &mut Entities) -> Result<(), Fault> {
    reader.begin()?;
    let entities = entities.get_or_insert_default();
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = reader.file.size("the number of entities")?;
    }
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let entity = reader.file.integer("the number of an entity")?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                reader.file.real("the box of an entity")?;
            }
            let groups = reader.file.size("the number of physical groups")?;
            let set = entities.entry((dimension, entity)).or_default();
            for _ in 0..groups {
                let number = reader.file.integer("the number of a physical group")?;
                // a negative number reverses the elements, which is irrelevant here
                let number = number.saturating_abs();
                set.insert(reader.contents.group(dimension, number));
                if set.len() > MOST_GROUPS {
                    return Err(reader.fault(Problem::Groups {
                        dimension,
                        entity,
                        most: MOST_GROUPS,
                    }));
                }
            }
            if dimension > 0 {
                for _ in 0..reader.file.size("the number of bounding entities")? {
                    reader.file.integer("the number of a bounding entity")?;
                }
            }
        }
    }
    reader.file.expect("$EndEntities")
}

/// Reads, for each entity, the numbers of its nodes and then their coordinates.
fn nodes(reader: &mut Reader) -> Result<(), Fault> {
    reader.begin()?;
    let blocks = reader.file.size("the number of blocks")?;
    let announced = reader.file.size("the number of nodes")?;
    let expected = reader.file.room("nodes", announced, 4, 32)?;
    reader.contents.vertices.reserve(expected);
    reader.numbers.reserve(expected);
    reader.file.size("the smallest number of a node")?;
    reader.file.size("the largest number of a node")?;
    let mut found = 0;
    for _ in 0..blocks {
        let dimension = reader.file.integer("the dimension of an entity")?;
        reader.file.integer("the number of an entity")?;
        let parametric = reader.file.integer("0 or 1 for parametric nodes")? != 0;
        let parameters = if parametric { dimension.clamp(0, 3) } else { 0 };
        let count = reader.file.size("the number of nodes")?;
        let count = reader.file.room("nodes", count, 4, 32)?;
        let mut numbers = Vec::with_capacity(count);
        for _ in 0..count {
            numbers.push(reader.file.size("the number of a node")?);
        }
        for number in numbers {
            let point = reader.file.point()?;
            reader.add_vertex(number, point)?;
            for _ in 0..parameters {
                reader.file.real("a parameter of a node")?;
            }
        }
        found += count as u64;
    }
    reader.file.expect("$EndNodes")?;
    total(reader, "nodes", announced, found)
}

/// Reads, for each entity and type, the numbers of its elements and of their nodes.
fn elements(reader: &mut Reader, entities: &Entities) -> Result<(), Fault> {
    reader.begin()?;
    let blocks = reader.file.size("the number of blocks")?;
    let announced = reader.file.size("the number of elements")?;
    reader.file.size("the smallest number of an element")?;
    reader.file.size("the largest number of an element")?;
    let mut found = 0;
    for _ in 0..blocks {
        let dimension = reader.file.integer("the dimension of an entity")?;
        let entity = reader.file.integer("the number of an entity")?;
        let kind = element_type::kind(reader.file.integer("the type of elements")?);
        let kind = kind.map_err(|problem| reader.fault(problem))?;
        if dimension != kind.dimension() as i64 {
            let expected = format!("elements of dimension {dimension}");
            return Err(reader.file.wrong(&expected, kind));
        }
        let groups = match entities {
            None => None,
            Some(entities) => Some(entities.get(&(kind.dimension(), entity)).ok_or_else(|| {
                let dimension = kind.dimension();
                reader.fault(Problem::UnknownEntity { dimension, entity })
            })?),
        };
        let count = reader.file.size("the number of elements")?;
        let per_element = 1 + kind.nodes();
        let count = reader
            .file
            .room("elements", count, per_element, 8 * per_element)?;
        let mut nodes = Vec::with_capacity(count * kind.nodes());
        for _ in 0..count {
            reader.file.size("the number of an element")?;
            let mut numbers = [0; 10];
            for number in &mut numbers[..kind.nodes()] {
                *number = reader.file.size("the number of a node")?;
            }
            let vertices = reader.vertices(kind, &numbers[..kind.nodes()])?;
            nodes.extend_from_slice(&vertices[..kind.nodes()]);
        }
        if count > 0 {
            let contents = &mut reader.contents;
            let groups = |_: &mut _| groups.into_iter().flatten().copied().collect();
            contents.nodes_of(kind, entity, groups).extend(nodes);
        }
        found += count as u64;
    }
    reader.file.expect("$EndElements")?;
    total(reader, "elements", announced, found)
}

/// Checks that the sizes of the blocks add up to the announced size.
fn total(reader: &Reader, what: &'static str, announced: u64, found: u64) -> Result<(), Fault> {
    match announced == found {
        true => Ok(()),
        false => Err(reader.fault(Problem::Total {
            what,
            announced,
            found,
        })),
    }
}

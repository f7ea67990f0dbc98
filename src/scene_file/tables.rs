//! The tables of a scene file and the keys that each of them has.

use std::cell::Cell;

use serde::de::value::Error as ProbeError;
use serde::de::{Deserialize, Deserializer, Error as _, Visitor};
use serde::forward_to_deserialize_any;

use super::keys::{
    Ball, BodyKeys, ContactKeys, Cuboid, CurvedKeys, Cylinder, ForceKeys, FoundationKeys,
    HalfSpace, Keys, MotionKeys, ObstacleKeys, OutputKeys, PhaseKeys, PressureKeys, ReactionKeys,
    RegionKeys, SupportKeys, TieKeys, TorqueKeys, TractionKeys,
};
use super::meshes::{
    AnnulusKeys, CuboidGradedKeys, CuboidKeys, CylinderKeys, DiscKeys, EquilateralDiscKeys,
    ExtrudeKeys, Made, RectangleKeys, SectorKeys, SphereKeys,
};

/// A table of a scene file.
pub(super) struct Table {
    /// The key that it is the value of; empty for the file as a whole.
    pub(super) name: &'static str,
    /// The table with that key.
    pub(super) within: &'static str,
    pub(super) keys: &'static [&'static str],
}

/// The header of a table of the file as a whole, if this is the name of one.
pub(super) fn header(name: &str) -> Option<&'static str> {
    Some(match name {
        "body" => "[[body]]",
        "contact" => "[[contact]]",
        "tie" => "[[tie]]",
        "obstacle" => "[[obstacle]]",
        "phase" => "[[phase]]",
        "output" => "[output]",
        "ipopt" => "[ipopt]",
        _ => return None,
    })
}

/// The file as a whole.
pub(super) fn file() -> Table {
    of::<Keys>("", "")
}

/// All tables with keys of their own, but the file as a whole. Of some that have the same keys, the first one is there.
pub(super) fn tables() -> Vec<Table> {
    vec![
        of::<BodyKeys>("body", ""),
        of::<ContactKeys>("contact", ""),
        of::<TieKeys>("tie", ""),
        of::<ObstacleKeys>("obstacle", ""),
        of::<PhaseKeys>("phase", ""),
        of::<OutputKeys>("output", ""),
        of::<ReactionKeys>("reaction", "output"),
        of::<SupportKeys>("supports", "body"),
        of::<TractionKeys>("tractions", "body"),
        of::<TorqueKeys>("torques", "body"),
        of::<PressureKeys>("pressures", "body"),
        of::<ForceKeys>("forces", "body"),
        of::<FoundationKeys>("foundations", "body"),
        of::<RegionKeys>("laws", "body"),
        of::<CurvedKeys>("curved", "body"),
        of::<Made>("mesh", "body"),
        of::<MotionKeys>("motion", "obstacle"),
        of::<HalfSpace>("half-space", "obstacle"),
        of::<Ball>("ball", "obstacle"),
        of::<Cylinder>("cylinder", "obstacle"),
        of::<Cuboid>("cuboid", "obstacle"),
        of::<RectangleKeys>("rectangle", "mesh"),
        of::<AnnulusKeys>("annulus", "mesh"),
        of::<DiscKeys>("disc", "mesh"),
        of::<EquilateralDiscKeys>("equilateral-disc", "mesh"),
        of::<SectorKeys>("half-disc", "mesh"),
        of::<CuboidKeys>("cuboid", "mesh"),
        of::<CuboidGradedKeys>("cuboid-graded", "mesh"),
        of::<CylinderKeys>("cylinder", "mesh"),
        of::<SphereKeys>("sphere", "mesh"),
        of::<ExtrudeKeys>("extrude", "mesh"),
    ]
}

fn of<'de, T: Deserialize<'de>>(name: &'static str, within: &'static str) -> Table {
    let keys = Cell::new(&[][..]);
    // it reads nothing: all that counts are the keys that it asks for
    let _ = T::deserialize(Probe(&keys));
    Table {
        name,
        within,
        keys: keys.get(),
    }
}

/// Keeps the keys that a type asks for, and gives it none.
struct Probe<'a>(&'a Cell<&'static [&'static str]>);

impl<'de> Deserializer<'de> for Probe<'_> {
    type Error = ProbeError;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, ProbeError> {
        Err(ProbeError::custom("no value"))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        keys: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ProbeError> {
        self.0.set(keys);
        self.deserialize_any(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        keys: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ProbeError> {
        self.0.set(keys);
        self.deserialize_any(visitor)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct seq tuple
        tuple_struct map identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_have_keys_and_are_in_others() {
        let all = tables();
        for table in &all {
            assert!(!table.keys.is_empty(), "{}", table.name);
            let outer = all
                .iter()
                .chain([&file()])
                .any(|own| own.name == table.within && own.keys.contains(&table.name));
            assert!(outer, "{} in {}", table.name, table.within);
        }
        assert!(file().keys.contains(&"increments"));
    }

    #[test]
    fn headers_are_those_of_the_file() {
        let headers = file().keys.iter().filter(|key| header(key).is_some());
        assert_eq!(headers.count(), 7);
    }
}

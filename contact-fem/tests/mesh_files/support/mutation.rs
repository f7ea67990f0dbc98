//! Damaging files at random, the same for the same seed.

/// A pseudo-random sequence (splitmix64).
pub struct Random(pub u64);

impl Random {
    /// The next number.
    pub fn number(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`, 0 if there is none.
    pub fn below(&mut self, end: usize) -> usize {
        match end {
            0 => 0,
            _ => (self.number() % end as u64) as usize,
        }
    }

    fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len())]
    }
}

/// What numbers are replaced by.
const NUMBERS: [&str; 20] = [
    "0",
    "1",
    "2",
    "3",
    "4",
    "11",
    "-1",
    "-0",
    "2147483647",
    "2147483648",
    "4294967295",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "99999999999999999999999",
    "1e308",
    "1e-320",
    "nan",
    "-inf",
    "0.5",
];

/// What is put in between.
const WORDS: [&str; 20] = [
    "$Nodes\n",
    "$EndNodes\n",
    "$Elements\n",
    "$EndElements\n",
    "$Entities\n",
    "$EndEntities\n",
    "$PhysicalNames\n",
    "$ParametricNodes\n",
    "$Comments\n",
    "Vertices\n",
    "Triangles\n",
    "TetrahedraP2\n",
    "Dimension 3\n",
    "End\n",
    "\"",
    "#",
    "\r\n",
    "\0",
    "\u{feff}",
    "nan",
];

/// `file` with one damage; `other` is another file that parts may come from.
pub fn damaged(file: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = file.to_vec();
    let at = random.below(bytes.len());
    let length = 1 + random.below(16).min(bytes.len().saturating_sub(at + 1));
    if bytes.is_empty() {
        return other.to_vec();
    }
    match random.below(12) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = random.number() as u8,
        2 => drop(bytes.drain(at..at + length)),
        3 => {
            let piece = bytes[at..at + length].to_vec();
            bytes.splice(at..at, piece);
        }
        4 => bytes.truncate(at),
        5 | 6 => replace_number(&mut bytes, at, random),
        7 => overwrite_binary(&mut bytes, at, random),
        8 => drop(bytes.drain(line(file, at))),
        9 => {
            let piece = file[line(file, at)].to_vec();
            let to = line(file, random.below(file.len())).start;
            bytes.splice(to..to, piece);
        }
        10 => {
            let word = random.pick(&WORDS).bytes();
            bytes.splice(at..at, word);
        }
        _ => {
            let from = random.below(other.len());
            let to = from + random.below(other.len() - from + 1);
            bytes.splice(at..at + length, other[from..to].iter().copied());
        }
    }
    bytes
}

/// The line around a byte, with its end.
fn line(bytes: &[u8], at: usize) -> std::ops::Range<usize> {
    let is_end = |&b: &u8| b == b'\n';
    let start = bytes[..at].iter().rposition(is_end).map_or(0, |k| k + 1);
    let end = bytes[at..].iter().position(is_end);
    start..end.map_or(bytes.len(), |k| at + k + 1)
}

/// Replaces the first number behind `at`.
fn replace_number(bytes: &mut Vec<u8>, at: usize, random: &mut Random) {
    let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit) else {
        return;
    };
    let start = at + start;
    let is_part = |b: &u8| b.is_ascii_digit() || b".eE+-".contains(b);
    let length = bytes[start..].iter().take_while(|b| is_part(b)).count();
    let number = random.pick(&NUMBERS).bytes();
    bytes.splice(start..start + length, number);
}

/// Writes a telling value of four or eight bytes.
fn overwrite_binary(bytes: &mut [u8], at: usize, random: &mut Random) {
    let value = match random.below(6) {
        0 => 0,
        1 => random.number() & 0xf,
        2 => u64::MAX,
        3 => 1 << random.below(64),
        4 => f64::NAN.to_bits(),
        _ => 1e300_f64.to_bits(),
    };
    let length = (4 + 4 * random.below(2)).min(bytes.len() - at);
    bytes[at..at + length].copy_from_slice(&value.to_le_bytes()[..length]);
}

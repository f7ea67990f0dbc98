//! Binary data of VTK's `.vtu` files: inline or appended, in base64 or raw, as it is or compressed by zlib or LZ4.

use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;

use super::grid::expected;
use super::problem::{Problem, excerpt};
use super::vtu_arrays::unsupported;

/// How blocks of data are compressed.
#[derive(Clone, Copy, Debug)]
pub(super) enum Codec {
    Zlib,
    Lz4,
}

impl Codec {
    /// The codec with this name of VTK; none of the empty name.
    pub fn named(name: &str) -> Result<Option<Self>, Problem> {
        Ok(match name {
            "" => None,
            "vtkZLibDataCompressor" => Some(Codec::Zlib),
            "vtkLZ4DataCompressor" => Some(Codec::Lz4),
            other => {
                return Err(unsupported(&format!("a VTK file compressed by `{other}`")));
            }
        })
    }

    /// Appends what a block of so many bytes was before.
    fn unpack(self, block: &[u8], length: usize, out: &mut Vec<u8>) -> Result<(), Problem> {
        let wrong = || {
            expected(
                &format!("a block of {length} bytes when unpacked"),
                "another length",
            )
        };
        let before = out.len();
        match self {
            Codec::Zlib => {
                // one byte more than it may have
                let most = (length as u64).saturating_add(1);
                let mut unpacked = ZlibDecoder::new(block).take(most);
                unpacked.read_to_end(out).map_err(|_| wrong())?;
            }
            Codec::Lz4 => {
                // a byte of LZ4 stands for 255 at most
                if length / 256 > block.len() {
                    return Err(wrong());
                }
                out.extend(lz4_flex::block::decompress(block, length).map_err(|_| wrong())?);
            }
        }
        match out.len() - before == length {
            true => Ok(()),
            false => Err(wrong()),
        }
    }
}

/// How the numbers of a file are written.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Coding {
    /// Lengths have eight bytes, and not four.
    pub has_long_headers: bool,
    pub codec: Option<Codec>,
    /// No array has more bytes, so that a small file does not take all memory.
    pub most: usize,
}

impl Coding {
    /// Thirty times the length of the whole file, and 64 KiB more. The longest array of a regular grid of 980 000 triangles, by zlib, has 3.4 times
    /// the length of its file.
    pub fn most_of(file: &[u8]) -> usize {
        30 * file.len() + (1 << 16)
    }
}

/// Bytes as they are, or in base64, which may end and begin again.
pub(super) enum Source<'a> {
    Raw(&'a [u8]),
    Base64 { letters: &'a [u8], ready: Vec<u8> },
}

impl<'a> Source<'a> {
    pub fn base64(letters: &'a [u8]) -> Self {
        let ready = Vec::new();
        Source::Base64 { letters, ready }
    }

    /// The next `count` bytes.
    fn take(&mut self, count: usize) -> Result<Vec<u8>, Problem> {
        let missing = || Problem::Truncated {
            expected: "the data of an array".to_string(),
        };
        match self {
            Source::Raw(bytes) => {
                let (taken, rest) = bytes.split_at_checked(count).ok_or_else(missing)?;
                *bytes = rest;
                Ok(taken.to_vec())
            }
            Source::Base64 { letters, ready } => {
                while ready.len() < count {
                    let (mut four, mut found) = ([0; 4], 0);
                    while let (Some((&letter, rest)), true) = (letters.split_first(), found < 4) {
                        *letters = rest;
                        if !letter.is_ascii_whitespace() {
                            four[found] = letter;
                            found += 1;
                        }
                    }
                    if found == 0 {
                        return Err(missing());
                    }
                    let mut three = [0; 3];
                    let decoded = STANDARD.decode_slice(&four[..found], &mut three);
                    let decoded =
                        decoded.map_err(|_| expected("base64", &excerpt(&four[..found])))?;
                    ready.extend(&three[..decoded]);
                }
                let rest = ready.split_off(count);
                Ok(std::mem::replace(ready, rest))
            }
        }
    }

    /// A length of the header.
    fn length(&mut self, coding: Coding) -> Result<usize, Problem> {
        let bytes = self.take(if coding.has_long_headers { 8 } else { 4 })?;
        let length = bytes
            .iter()
            .rev()
            .fold(0_u64, |sum, &byte| sum << 8 | u64::from(byte));
        usize::try_from(length).map_err(|_| expected("the length of an array", "a larger number"))
    }

    /// The bytes of an array.
    fn array(&mut self, coding: Coding) -> Result<Vec<u8>, Problem> {
        let Some(codec) = coding.codec else {
            let length = self.length(coding)?;
            return self.take(length);
        };
        let mut header = || self.length(coding);
        let [blocks, whole, last] = [header()?, header()?, header()?];
        let mut lengths = Vec::new();
        for _ in 0..blocks {
            lengths.push(header()?);
        }
        let mut unpacked = Vec::new();
        for (k, &length) in lengths.iter().enumerate() {
            let block = self.take(length)?;
            let of = match (k + 1 == blocks, last) {
                (true, 1..) => last,
                _ => whole,
            };
            if of > coding.most.saturating_sub(unpacked.len()) {
                let most = format!("{} bytes at most in an array of this file", coding.most);
                return Err(expected(&most, "more"));
            }
            codec.unpack(&block, of, &mut unpacked)?;
        }
        Ok(unpacked)
    }

    /// The numbers of an array, of this type of VTK.
    pub fn numbers(mut self, kind: &str, coding: Coding) -> Result<Vec<f64>, Problem> {
        let data = self.array(coding)?;
        macro_rules! numbers {
            ($kind:ty) => {
                data.chunks_exact(size_of::<$kind>())
                    .map(|bytes| {
                        <$kind>::from_le_bytes(bytes.try_into().unwrap_or_default()) as f64
                    })
                    .collect()
            };
        }
        Ok(match kind {
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
}

/// The data behind the grid, to which arrays point by their offsets.
pub(super) struct Appended<'a> {
    data: &'a [u8],
    is_raw: bool,
}

impl<'a> Appended<'a> {
    /// The file before the appended data, and these.
    pub fn split(file: &'a [u8]) -> Result<(&'a [u8], Option<Self>), Problem> {
        const TAG: &[u8] = b"<AppendedData";
        let Some(at) = file.windows(TAG.len()).position(|own| own == TAG) else {
            return Ok((file, None));
        };
        let (grid, rest) = file.split_at(at);
        let begins = rest.iter().position(|&byte| byte == b'_');
        let (tag, data) = rest.split_at(begins.ok_or_else(|| Problem::Truncated {
            expected: "`_`, at which the appended data begins".to_string(),
        })?);
        let has = |word: &[u8]| tag.windows(word.len()).any(|own| own == word);
        let is_raw = has(b"raw");
        if !is_raw && !has(b"base64") {
            return Err(expected("`raw` or `base64` data", &excerpt(tag)));
        }
        let data = &data[1..];
        Ok((grid, Some(Appended { data, is_raw })))
    }

    /// The data from this offset on.
    pub fn from(&self, offset: usize) -> Result<Source<'a>, Problem> {
        let data = self.data.get(offset..).ok_or_else(|| {
            let most = self.data.len();
            expected(&format!("an offset of {most} at most"), &offset.to_string())
        })?;
        Ok(match self.is_raw {
            true => Source::Raw(data),
            false => Source::base64(data),
        })
    }
}

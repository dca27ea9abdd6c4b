//! Named arrays of numbers, in Mitsuba's tensor files (`.bsdf`), version 1.0.
//!
//! The file begins with `tensor_file`, a zero, two bytes of the version and the number of fields (32 bits). A
//! field has the length of its name (16 bits), the name, the number of its dimensions (16 bits), a byte for
//! the type of its values, where these begin in the file (64 bits), and its size along each dimension (64
//! bits). All is little-endian.

use super::{ImageError, MOST_TEXELS};
use std::collections::BTreeMap;

/// The arrays of a file.
#[derive(Clone, Debug)]
pub struct Tensors<'a> {
    bytes: &'a [u8],
    fields: BTreeMap<String, Field>,
}

#[derive(Clone, Debug)]
struct Field {
    shape: Vec<usize>,
    kind: u8,
    offset: usize,
}

/// Numbers that fill a block.
#[derive(Clone, Debug, PartialEq)]
pub struct Tensor {
    /// Its size along each dimension; the last is that along which neighbours follow one another.
    pub shape: Vec<usize>,
    /// Finite.
    pub values: Vec<f32>,
}

const MAGIC: &[u8] = b"tensor_file\0";

/// The types of values that are read: bytes and floats of 32 bits.
const BYTES: u8 = 1;
const FLOATS: u8 = 10;

/// Takes the file apart from its beginning.
struct Header<'a>(&'a [u8]);

impl<'a> Header<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    /// An integer of up to eight bytes.
    fn integer(&mut self, bytes: usize) -> Option<usize> {
        let taken = self.take(bytes)?;
        let number = taken.iter().rev().fold(0u64, |number, &byte| number << 8 | u64::from(byte));
        usize::try_from(number).ok()
    }

    fn field(&mut self) -> Option<(String, Field)> {
        let length = self.integer(2)?;
        let name = String::from_utf8(self.take(length)?.to_vec()).ok()?;
        let (dimensions, kind, offset) = (self.integer(2)?, self.integer(1)?, self.integer(8)?);
        let shape = (0..dimensions).map(|_| self.integer(8)).collect::<Option<_>>()?;
        Some((name, Field { shape, kind: kind as u8, offset }))
    }
}

impl<'a> Tensors<'a> {
    /// # Errors
    /// Another format, or a header that ends too early.
    pub fn decode(bytes: &'a [u8]) -> Result<Self, ImageError> {
        let mut header = Header(bytes);
        if header.take(MAGIC.len()) != Some(MAGIC) || header.take(2) != Some(&[1, 0]) {
            return Err(ImageError::new(
                "The file is no table of measurements",
                "expected a tensor file, version 1.0",
            ));
        }
        let fields = header.integer(4).and_then(|count| (0..count).map(|_| header.field()).collect());
        fields.map(|fields| Self { bytes, fields }).ok_or_else(|| {
            let problem = "The file ends before all of its fields are named";
            ImageError::new(problem, "expected a whole file")
        })
    }

    /// Whether there is a field of this name.
    pub fn has(&self, name: &str) -> bool {
        self.fields.contains_key(name)
    }

    /// The values of a field of as many dimensions.
    ///
    /// # Errors
    /// There is no such field, it has another number of dimensions or another type, the file ends before its
    /// values do, or one of these is not finite.
    pub fn floats(&self, name: &str, dimensions: usize) -> Result<Tensor, ImageError> {
        let (shape, bytes) = self.content(name, dimensions, FLOATS, 4)?;
        let float = |word: &[u8]| f32::from_le_bytes([word[0], word[1], word[2], word[3]]);
        let values: Vec<f32> = bytes.chunks_exact(4).map(float).collect();
        match values.iter().all(|value| value.is_finite()) {
            true => Ok(Tensor { shape, values }),
            false => Err(ImageError::new(
                format!("The field {name} holds what is no number"),
                "expected finite values",
            )),
        }
    }

    /// The bytes of a field of one dimension.
    ///
    /// # Errors
    /// Those of [`Self::floats`].
    pub fn bytes(&self, name: &str) -> Result<&'a [u8], ImageError> {
        self.content(name, 1, BYTES, 1).map(|(_, bytes)| bytes)
    }

    fn content(
        &self,
        name: &str,
        dimensions: usize,
        kind: u8,
        size: usize,
    ) -> Result<(Vec<usize>, &'a [u8]), ImageError> {
        let named = || self.fields.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
        let Some(field) = self.fields.get(name) else {
            return Err(ImageError::new(
                format!("The file has no field {name}"),
                format!("expected that field beside those that there are ({})", named()),
            ));
        };
        if field.shape.len() != dimensions || field.kind != kind {
            let kinds = |kind| match kind {
                BYTES => "bytes".to_owned(),
                FLOATS => "floats of 32 bits".to_owned(),
                other => format!("values of type {other}"),
            };
            return Err(ImageError::new(
                format!("The field {name} has {} dimensions and {}", field.shape.len(), kinds(field.kind)),
                format!("expected {dimensions} dimensions and {}", kinds(kind)),
            ));
        }
        let count = field.shape.iter().try_fold(1usize, |count, &size| count.checked_mul(size));
        let content = count
            .filter(|&count| count <= MOST_TEXELS)
            .and_then(|count| self.bytes.get(field.offset..field.offset.checked_add(count * size)?));
        let sizes = || field.shape.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ");
        content.map(|content| (field.shape.clone(), content)).ok_or_else(|| {
            ImageError::new(
                format!(
                    "The field {name} of {} values does not fit its file of {} bytes",
                    sizes(),
                    self.bytes.len()
                ),
                format!("expected a whole file, and at most {MOST_TEXELS} values"),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of two fields: the bytes `ab`, and the floats 1.5 and −2.
    fn file() -> Vec<u8> {
        let mut file = [MAGIC, &[1, 0], &2u32.to_le_bytes()].concat();
        let header = MAGIC.len() + 6 + 2 * (2 + 1 + 2 + 1 + 8) + 8 + 16;
        for (name, kind, offset, shape) in
            [("a", BYTES, header, &[2][..]), ("b", FLOATS, header + 2, &[1, 2])]
        {
            file.extend(1u16.to_le_bytes());
            file.extend(name.bytes());
            file.extend((shape.len() as u16).to_le_bytes());
            file.push(kind);
            file.extend((offset as u64).to_le_bytes());
            file.extend(shape.iter().flat_map(|size: &u64| size.to_le_bytes()));
        }
        file.extend(b"ab");
        file.extend([1.5f32, -2.0].map(f32::to_le_bytes).as_flattened());
        file
    }

    #[test]
    fn fields_are_read() {
        let file = file();
        let tensors = Tensors::decode(&file).unwrap();
        assert!(tensors.has("a") && !tensors.has("c"));
        assert_eq!(tensors.bytes("a").unwrap(), b"ab");
        assert_eq!(tensors.floats("b", 2).unwrap(), Tensor { shape: vec![1, 2], values: vec![1.5, -2.0] });
    }

    #[test]
    fn what_is_wrong_is_named() {
        let file = file();
        let tensors = Tensors::decode(&file).unwrap();
        for (error, part) in [
            (tensors.floats("c", 1).unwrap_err(), "no field c"),
            (tensors.floats("b", 1).unwrap_err(), "b has 2 dimensions"),
            (tensors.floats("a", 1).unwrap_err(), "a has 1 dimensions and bytes"),
        ] {
            assert!(error.problem.contains(part), "{error:?}");
        }
        // However short the file is, nothing is read beyond its end.
        for length in 0..file.len() {
            let Ok(tensors) = Tensors::decode(&file[..length]) else { continue };
            let error = tensors.floats("b", 2).unwrap_err();
            assert!(error.problem.contains("does not fit its file"), "{error:?}");
        }
        let mut endless = file.clone();
        let shape = MAGIC.len() + 6 + 2 + 1 + 2 + 1 + 8;
        endless[shape..shape + 8].fill(0xff);
        assert!(Tensors::decode(&endless).unwrap().bytes("a").is_err());
    }

    #[test]
    fn a_number_that_is_none_is_refused() {
        let mut file = file();
        let last = file.len() - 4;
        file[last..].copy_from_slice(&f32::NAN.to_le_bytes());
        let error = Tensors::decode(&file).unwrap().floats("b", 2).unwrap_err();
        assert!(error.problem.contains("no number"), "{error:?}");
    }
}

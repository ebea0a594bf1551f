//! Whether all numbers of a value are finite. JSON writes those that are not as `null`, which reads as "none" or not at all.

use serde::Serialize;
use serde::ser;
use std::fmt;

/// Whether no number in `value` is NaN or infinite.
pub(super) fn is_finite(value: &impl Serialize) -> bool {
    value.serialize(Walk).is_ok()
}

/// Walks a value and writes nothing.
#[derive(Clone, Copy)]
struct Walk;

/// A number that is not finite, or a value that refuses to be written.
#[derive(Debug)]
struct Refused;

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number is not finite")
    }
}

impl std::error::Error for Refused {}

impl ser::Error for Refused {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self
    }
}

/// Methods that take a value in which no number can be wrong.
macro_rules! harmless {
    ($($name:ident: $kind:ty),* $(,)?) => {
        $(fn $name(self, _: $kind) -> Result<(), Refused> {
            Ok(())
        })*
    };
}

impl ser::Serializer for Walk {
    type Ok = ();
    type Error = Refused;
    type SerializeSeq = Self;
    type SerializeTuple = Self;
    type SerializeTupleStruct = Self;
    type SerializeTupleVariant = Self;
    type SerializeMap = Self;
    type SerializeStruct = Self;
    type SerializeStructVariant = Self;

    harmless!(
        serialize_bool: bool, serialize_char: char, serialize_str: &str, serialize_bytes: &[u8],
        serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64,
        serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64,
        serialize_unit_struct: &'static str,
    );

    fn serialize_f32(self, x: f32) -> Result<(), Refused> {
        self.serialize_f64(x.into())
    }

    fn serialize_f64(self, x: f64) -> Result<(), Refused> {
        if x.is_finite() { Ok(()) } else { Err(Refused) }
    }

    fn serialize_none(self) -> Result<(), Refused> {
        Ok(())
    }

    fn serialize_unit(self) -> Result<(), Refused> {
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Refused> {
        value.serialize(self)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Refused> {
        value.serialize(self)
    }

    fn serialize_unit_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
    ) -> Result<(), Refused> {
        Ok(())
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        value: &T,
    ) -> Result<(), Refused> {
        value.serialize(self)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_tuple(self, _: usize) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, Refused> {
        Ok(self)
    }
}

/// What holds several values: each is walked.
macro_rules! several {
    ($($kind:ident: $($name:ident($($key:ty)?)),+;)*) => {
        $(impl ser::$kind for Walk {
            type Ok = ();
            type Error = Refused;

            $(fn $name<T: Serialize + ?Sized>(&mut self, $(_: $key,)? value: &T) -> Result<(), Refused> {
                value.serialize(*self)
            })+

            fn end(self) -> Result<(), Refused> {
                Ok(())
            }
        })*
    };
}

several!(
    SerializeSeq: serialize_element();
    SerializeTuple: serialize_element();
    SerializeTupleStruct: serialize_field();
    SerializeTupleVariant: serialize_field();
    SerializeMap: serialize_key(), serialize_value();
    SerializeStruct: serialize_field(&'static str);
    SerializeStructVariant: serialize_field(&'static str);
);

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[derive(Serialize)]
    enum Kind {
        None,
        One(f64),
        Two(u8, f32),
        Named { x: Option<f64> },
    }

    #[test]
    fn a_number_that_is_not_finite_is_found_wherever_it_stands() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!is_finite(&bad));
            assert!(!is_finite(&(bad as f32)));
            assert!(!is_finite(&vec![Some(1.0), None, Some(bad)]));
            assert!(!is_finite(&("a", [1.0, bad])));
            assert!(!is_finite(&BTreeMap::from([("a", bad)])));
            assert!(!is_finite(&Kind::One(bad)));
            assert!(!is_finite(&Kind::Two(1, bad as f32)));
            assert!(!is_finite(&Kind::Named { x: Some(bad) }));
        }
        for good in [0.0, -0.0, 5e-324, f64::MAX] {
            assert!(is_finite(&(good, Kind::One(good), Kind::None, ())));
            assert!(is_finite(&Kind::Named { x: Some(good) }));
            assert!(is_finite(&Kind::Named { x: None }));
            assert!(is_finite(&BTreeMap::from([(1, vec!['a', 'b'])])));
        }
    }
}

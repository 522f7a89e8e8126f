//! What a file says of itself.

use arbitrary::{Arbitrary, Result, Unstructured};

/// A number in a header: the right one, but for one case in eight.
#[derive(Debug)]
pub(crate) struct Stated<T>(Option<T>);

impl<'a, T: Arbitrary<'a>> Arbitrary<'a> for Stated<T> {
    fn arbitrary(bytes: &mut Unstructured<'a>) -> Result<Self> {
        let is_right = u8::arbitrary(bytes)? < 224;
        Ok(Self(if is_right { None } else { Some(bytes.arbitrary()?) }))
    }
}

/// The right one.
impl<T> Default for Stated<T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<T: Copy> Stated<T> {
    /// What is stated where `right` would be.
    pub(crate) fn or(&self, right: T) -> T {
        self.0.unwrap_or(right)
    }
}

//! Numbers out of bytes that came from elsewhere, and the text before them.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// The fault in a file's bytes.
#[derive(Debug)]
pub struct Damaged(pub String);

impl std::fmt::Display for Damaged {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "a body that was made ready before cannot be read: {}", self.0)
    }
}

impl std::error::Error for Damaged {}

/// The next `count` bytes.
fn take<'a>(rest: &mut &'a [u8], count: usize) -> Result<&'a [u8], Damaged> {
    let (taken, after) =
        rest.split_at_checked(count).ok_or_else(|| Damaged(format!("it ends {count} bytes too early")))?;
    *rest = after;
    Ok(taken)
}

/// The length of `head` as JSON in four bytes, little-endian, and the JSON: numbers follow.
pub fn headed(head: &impl Serialize) -> Result<Vec<u8>, Damaged> {
    let head = serde_json::to_vec(head).map_err(|error| Damaged(error.to_string()))?;
    let mut bytes = (head.len() as u32).to_le_bytes().to_vec();
    bytes.extend(head);
    Ok(bytes)
}

/// Reads what [`headed`] wrote.
pub fn head<T: DeserializeOwned>(rest: &mut &[u8]) -> Result<T, Damaged> {
    let length = u32::from_le_bytes(take(rest, 4)?.try_into().unwrap_or_default()) as usize;
    serde_json::from_slice(take(rest, length)?).map_err(|error| Damaged(error.to_string()))
}

/// `rows` times `columns` numbers of B bytes.
pub fn numbers<const B: usize, T>(
    rest: &mut &[u8],
    rows: usize,
    columns: usize,
    number: impl Fn([u8; B]) -> T,
) -> Result<Vec<T>, Damaged> {
    let count = rows.checked_mul(columns * B).ok_or_else(|| Damaged("it is too large".into()))?;
    Ok(take(rest, count)?.as_chunks::<B>().0.iter().map(|bytes| number(*bytes)).collect())
}

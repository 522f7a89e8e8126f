//! Numbers out of bytes that came from elsewhere.

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
pub fn take<'a>(rest: &mut &'a [u8], count: usize) -> Result<&'a [u8], Damaged> {
    let (taken, after) =
        rest.split_at_checked(count).ok_or_else(|| Damaged(format!("it ends {count} bytes too early")))?;
    *rest = after;
    Ok(taken)
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

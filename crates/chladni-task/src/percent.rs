//! Names in addresses.

/// `%20` and its like as the bytes they stand for; what is no UTF-8 then is replaced.
///
/// ```
/// assert_eq!(chladni_task::percent_decoded("a%20b.mp3"), "a b.mp3");
/// ```
pub fn percent_decoded(address: &str) -> String {
    let bytes = address.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let hex = bytes.get(i + 1..i + 3).filter(|hex| hex.iter().all(u8::is_ascii_hexdigit));
        let hex = hex.and_then(|hex| std::str::from_utf8(hex).ok());
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()).filter(|_| bytes[i] == b'%') {
            Some(byte) => {
                decoded.push(byte);
                i += 3;
            }
            None => {
                decoded.push(bytes[i]);
                i += 1;
            }
        }
    }
    String::from_utf8_lossy(&decoded).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_escapes_are_decoded() {
        assert_eq!(percent_decoded("fuze%20uv.jpg%"), "fuze uv.jpg%");
        assert_eq!(percent_decoded("zw%C3%b6lf %+5 100%"), "zw\u{f6}lf %+5 100%");
    }
}

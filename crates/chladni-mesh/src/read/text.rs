//! Text files, line by line and word by word, with the line number at hand for errors.

use crate::error::Fault;

/// The nonempty lines of a text file, each with its number from 1. Text after `comment` on a line is
/// dropped; a backslash at the end joins the next line where `joins`.
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
    comment: Option<u8>,
    /// Comments that begin so are lines.
    kept: Option<&'static [u8]>,
    joins: bool,
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8], comment: Option<u8>, joins: bool) -> Self {
        let rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Self { rest, number: 0, comment, kept: None, joins }
    }

    /// With comments that begin so among the lines: some programs keep data in them.
    pub fn keeping(self, kept: &'static [u8]) -> Self {
        Self { kept: Some(kept), ..self }
    }

    /// The number of the line last returned, from 1.
    pub fn number(&self) -> usize {
        self.number
    }

    fn raw(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let (line, rest) = match self.rest.iter().position(|&b| b == b'\n') {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        Some(line)
    }

    /// The next nonempty line; a line joined from several is put into `joined`.
    pub fn next<'b>(&mut self, joined: &'b mut Vec<u8>) -> Option<&'b [u8]>
    where
        'a: 'b,
    {
        self.next_and_whole(joined).map(|[line, _]| line)
    }

    /// As [`next`](Self::next), and the same line with the comment that it may end in.
    pub fn next_and_whole<'b>(&mut self, joined: &'b mut Vec<u8>) -> Option<[&'b [u8]; 2]>
    where
        'a: 'b,
    {
        loop {
            let mut line = self.raw()?.trim_ascii();
            if self.joins && self.goes_on(line) {
                joined.clear();
                while self.goes_on(line)
                    && let Some(start) = line.strip_suffix(b"\\")
                {
                    joined.extend_from_slice(start);
                    joined.push(b' ');
                    line = self.raw().unwrap_or_default().trim_ascii();
                }
                joined.extend_from_slice(line);
                if !self.without_comment(joined).is_empty() {
                    break;
                }
                continue;
            }
            let bare = self.without_comment(line);
            if !bare.is_empty() {
                return Some([bare, line]);
            }
        }
        let whole = joined.trim_ascii();
        Some([self.without_comment(whole), whole])
    }

    /// Whether the next line belongs to this one, too: not where a comment ends in a backslash, as a Windows path does.
    fn goes_on(&self, line: &[u8]) -> bool {
        line.ends_with(b"\\") && self.without_comment(line).len() == line.len()
    }

    fn without_comment<'c>(&self, line: &'c [u8]) -> &'c [u8] {
        if self.kept.is_some_and(|kept| line.starts_with(kept)) {
            return line;
        }
        let begins = |at: usize| {
            // The sign in 1.#INF begins no comment.
            Some(line[at]) == self.comment && !(line[..at].ends_with(b"1.") && is_windows_name(&line[at..]))
        };
        let end = (0..line.len()).find(|at| begins(*at)).unwrap_or(line.len());
        line[..end].trim_ascii()
    }
}

/// The words of one line.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|b| b.is_ascii_whitespace()).filter(|word| !word.is_empty())
}

/// The text of `line` after the `keyword` that it begins with.
pub(crate) fn text_after(line: &[u8], keyword: &[u8]) -> String {
    String::from_utf8_lossy(line.get(keyword.len()..).unwrap_or_default().trim_ascii()).into_owned()
}

/// All words of a text file, across lines.
pub(crate) struct Words<'a> {
    rest: &'a [u8],
    line: usize,
    comment: Option<u8>,
}

impl<'a> Words<'a> {
    /// Words of `bytes`, whose first line has number `line`.
    pub fn new(bytes: &'a [u8], line: usize, comment: Option<u8>) -> Self {
        Self { rest: bytes, line, comment }
    }

    /// The line of the next word, or of the end of the file.
    pub fn line(&self) -> usize {
        self.line
    }

    /// An upper bound on the number of words that follow.
    pub fn at_most(&self) -> usize {
        self.rest.len() / 2 + 1
    }

    pub fn peek(&mut self) -> Option<&'a [u8]> {
        loop {
            match self.rest.first()? {
                b'\n' => self.line += 1,
                b if b.is_ascii_whitespace() => {}
                &b if Some(b) == self.comment => {
                    let end = self.rest.iter().position(|&b| b == b'\n').unwrap_or(self.rest.len());
                    self.rest = &self.rest[end..];
                    continue;
                }
                _ => break,
            }
            self.rest = &self.rest[1..];
        }
        let end = self.rest.iter().position(u8::is_ascii_whitespace).unwrap_or(self.rest.len());
        Some(&self.rest[..end])
    }

    pub fn next(&mut self) -> Option<&'a [u8]> {
        let word = self.peek()?;
        self.rest = &self.rest[word.len()..];
        Some(word)
    }

    /// Drops the rest of the line; returns whether that was a word or more.
    pub fn end_line(&mut self) -> bool {
        let ends = |b: &u8| matches!(b, b'\n' | b'\r');
        let end = self.rest.iter().position(ends).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest;
        !line.trim_ascii().is_empty()
    }

    /// The next word as a number; `what` names it in the error.
    pub fn number<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, Fault> {
        match self.next() {
            Some(word) => number(word, self.line, what),
            None => Err(Fault::line(self.line, format!("the file ends where {what} should follow"))),
        }
    }
}

/// A word as a number; `what` names it in the error.
pub(crate) fn number<T: std::str::FromStr>(word: &[u8], line: usize, what: &str) -> Result<T, Fault> {
    std::str::from_utf8(word)
        .ok()
        .and_then(|text| text.parse().ok())
        .or_else(|| not_finite(word)?.parse().ok())
        .ok_or_else(|| Fault::line(line, format!("{} is not {what}", quoted(word))))
}

/// The usual spelling of what programs write for a number that is none or without end, such as `-nan(ind)` and, on Windows,
/// `1.#QNAN`; `None` of any other word.
fn not_finite(word: &[u8]) -> Option<&'static str> {
    let (negative, plain) = match word {
        [b'-', plain @ ..] => (true, plain),
        [b'+', plain @ ..] => (false, plain),
        plain => (false, plain),
    };
    if let Some(name) = plain.strip_prefix(b"1.").filter(|name| is_windows_name(name)) {
        let infinite = name.starts_with(b"#INF");
        return Some(match (infinite, negative) {
            (false, _) => "NaN",
            (true, false) => "inf",
            (true, true) => "-inf",
        });
    }
    let (start, rest) = plain.split_at_checked(4)?;
    (start.eq_ignore_ascii_case(b"nan(") && rest.ends_with(b")")).then_some("NaN")
}

/// Whether `text` begins as the end of `1.#INF`, `1.#IND`, `1.#QNAN` or `1.#SNAN`, also of one that was rounded to fewer
/// letters as if they were digits: `1.#J` is `1.#INF` or `1.#IND`.
fn is_windows_name(text: &[u8]) -> bool {
    let whole = [&b"#INF"[..], b"#IND", b"#QNAN", b"#SNAN"];
    let rounded = [&b"#J"[..], b"#IO", b"#R", b"#QO", b"#QNB", b"#T", b"#SO", b"#SNB"];
    // Longer words that begin so are comments.
    let word = words(text).next().unwrap_or_default();
    whole.iter().any(|name| text.starts_with(name)) || rounded.contains(&word)
}

/// A word for an error message: short and printable, whatever bytes it has.
pub(crate) fn quoted(word: &[u8]) -> String {
    const LIMIT: usize = 24;
    let shown = word.get(..LIMIT).unwrap_or(word).escape_ascii();
    let more = if word.len() > LIMIT { "…" } else { "" };
    format!("'{shown}{more}'")
}

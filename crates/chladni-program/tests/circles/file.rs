//! The names in a source file: as much of the language as tells what it imports, names and holds.

use std::collections::BTreeSet;

use crate::Names;

/// What a file names. Modules within it count as the file; what is for tests only does not count.
#[derive(Default)]
pub struct File {
    /// What is imported, by the name under which it is known; `*` for all that a module holds.
    pub imports: Vec<(String, Names)>,
    /// Paths of two names or more outside of imports.
    pub paths: Vec<Names>,
    /// Items, and functions of items.
    pub items: BTreeSet<String>,
    /// Modules that only tests have.
    pub tests: Vec<String>,
}

/// How items begin that only tests have.
const TEST: [&[&str]; 2] =
    [&["#", "[", "cfg", "(", "test", ")"], &["#", "[", "cfg", "(", "all", "(", "test"]];

impl File {
    /// Adds what `text` names.
    pub fn read(&mut self, text: &str) {
        let words = words(text);
        let mut rest: &[&str] = &words;
        while let [first, after @ ..] = rest {
            rest = match (*first, after) {
                ("#", _) if TEST.iter().any(|test| rest.starts_with(test)) => self.pass_over_test(rest),
                ("use", [name, ..]) if is_name(name) => self.import(after, &[]),
                ("struct" | "enum" | "union" | "trait" | "type" | "fn" | "const" | "static", [name, ..])
                    if is_name(name) =>
                {
                    self.items.insert((*name).to_owned());
                    after
                }
                (name, ["::", ..]) if is_name(name) => {
                    let is_step =
                        |step: &&[&str]| step[0] == "::" && step[1..].iter().all(|name| is_name(name));
                    let steps = after.chunks(2).take_while(is_step).count();
                    let names = rest.iter().step_by(2).take(1 + steps);
                    self.paths.push(names.map(|name| (*name).to_owned()).collect());
                    &after[(2 * steps).min(after.len())..]
                }
                _ => after,
            };
        }
    }

    /// Passes over an item with its attributes; returns what comes after.
    fn pass_over_test<'w, 't>(&mut self, item: &'w [&'t str]) -> &'w [&'t str] {
        if let Some(at) = item.iter().position(|word| *word == "mod" || *word == "{" || *word == ";")
            && let ["mod", name, ";", ..] = item[at..]
        {
            self.tests.push(name.to_owned());
        }
        let mut depth = 0;
        for (at, word) in item.iter().enumerate() {
            match *word {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
            if depth == 0 && ["}", ";"].contains(word) {
                return &item[at + 1..];
            }
        }
        &[]
    }

    /// Adds the imports of a tree below `above`; returns what comes after.
    fn import<'w, 't>(&mut self, tree: &'w [&'t str], above: &[String]) -> &'w [&'t str] {
        let (mut path, mut rest) = (above.to_vec(), tree);
        loop {
            rest = match rest {
                ["::", after @ ..] => after,
                ["{", after @ ..] => {
                    let mut branch = after;
                    loop {
                        match self.import(branch, &path) {
                            ["}", after @ ..] => return after,
                            [_, after @ ..] => branch = after,
                            [] => return &[],
                        }
                    }
                }
                ["*", after @ ..] => {
                    self.imports.push(("*".to_owned(), path));
                    return after;
                }
                ["as", name, after @ ..] => {
                    self.imports.push(((*name).to_owned(), path));
                    return after;
                }
                ["self", after @ ..] if !path.is_empty() => after,
                [name, after @ ..] if is_name(name) => {
                    path.push((*name).to_owned());
                    after
                }
                after => {
                    self.imports.extend(path.last().cloned().map(|name| (name, path)));
                    return after;
                }
            };
        }
    }
}

fn is_name(word: &str) -> bool {
    word.starts_with(|first: char| first.is_alphabetic() || first == '_')
}

/// Names, `::` and single marks, without comments and quoted text.
fn words(text: &str) -> Vec<&str> {
    let (mut words, mut rest) = (Vec::new(), text);
    while let Some(first) = rest.chars().next() {
        let name = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let length = if let Some(length) = unread(rest) {
            length
        } else {
            let length = if rest.starts_with("::") { 2 } else { name.max(first.len_utf8()) };
            words.extend((!first.is_whitespace()).then_some(&rest[..length]));
            length
        };
        rest = &rest[length.min(rest.len())..];
    }
    words
}

/// The length of the comment or of the quoted text or character that `text` begins with.
fn unread(text: &str) -> Option<usize> {
    let to = |end: &str| text.find(end).map_or(text.len(), |at| at + end.len());
    if text.starts_with("//") {
        return Some(to("\n"));
    }
    if text.starts_with("/*") {
        return Some(to("*/"));
    }
    if let Some(raw) = text.strip_prefix("br").or(text.strip_prefix('r')) {
        let fence = raw.bytes().take_while(|byte| *byte == b'#').count();
        if raw[fence..].starts_with('"') {
            let start = text.len() - raw.len() + fence + 1;
            let end = format!("\"{}", "#".repeat(fence));
            return Some(text[start..].find(&end).map_or(text.len(), |at| start + at + end.len()));
        }
    }
    let mark = text.chars().next().filter(|mark| ['"', '\''].contains(mark))?;
    if mark == '\'' && !text[1..].starts_with('\\') && text.chars().nth(2) != Some('\'') {
        // A lifetime.
        return Some(1);
    }
    let mut is_escaped = false;
    let end = text.char_indices().skip(1).find(|(_, c)| {
        let ends = *c == mark && !is_escaped;
        is_escaped = *c == '\\' && !is_escaped;
        ends
    });
    Some(end.map_or(text.len(), |(at, _)| at + 1))
}

#[test]
fn names_are_read_past_text_comments_and_tests() {
    let mut file = File::default();
    file.read(
        r##"
        use super::{a::{self, B as C}, d}; // use crate::no;
        const E: &str = "use \"crate::no;"; const F: char = '"'; const G: &str = r#"crate::"no""#;
        #[cfg(test)] #[allow(x)] mod tests { use crate::no; fn f() { let x = [1; 2]; } }
        fn h<'a>() -> impl Sized + use<'a> { crate::i::j::<u8>() }
        #[cfg(test)] mod away;
        "##,
    );
    let path = |names: &str| names.split("::").map(str::to_owned).collect::<Names>();
    let imports = [("a", "super::a"), ("C", "super::a::B"), ("d", "super::d")];
    assert_eq!(file.imports, imports.map(|(name, names)| (name.to_owned(), path(names))));
    assert_eq!(file.paths, [path("crate::i::j")]);
    assert_eq!(file.items.iter().map(String::as_str).collect::<String>(), "EFGh");
    assert_eq!(file.tests, ["away"]);
}

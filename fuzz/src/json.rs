//! JSON as text, with whatever mistakes a target wants.

use std::fmt::Display;

/// The members of an object.
#[derive(Default)]
pub(crate) struct Members(Vec<String>);

impl Members {
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Display) -> Self {
        self.0.push(format!("\"{name}\":{value}"));
        self
    }

    #[must_use]
    pub fn with_some(self, name: &str, value: Option<impl Display>) -> Self {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }

    /// The object.
    pub fn object(self) -> String {
        format!("{{{}}}", self.0.join(","))
    }
}

/// An array.
pub(crate) fn list<T: Display>(items: impl IntoIterator<Item = T>) -> String {
    let items: Vec<String> = items.into_iter().map(|item| item.to_string()).collect();
    format!("[{}]", items.join(","))
}

pub(crate) fn quoted(text: &str) -> String {
    format!("\"{text}\"")
}

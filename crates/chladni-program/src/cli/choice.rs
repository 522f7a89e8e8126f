//! Arguments that are one of several names.

use clap::builder::{PossibleValuesParser, TypedValueParser};

/// One of `choices` by its name. Another name is refused with those that there are and the nearest of them.
pub fn one_of<T: Clone + Send + Sync + 'static>(
    choices: impl IntoIterator<Item = (&'static str, T)>,
) -> impl TypedValueParser<Value = T> {
    let choices: Vec<(&str, T)> = choices.into_iter().collect();
    let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
    PossibleValuesParser::new(names).try_map(move |name| {
        let found = choices.iter().find(|(known, _)| *known == name);
        found.map(|(_, choice)| choice.clone()).ok_or("is none of these")
    })
}

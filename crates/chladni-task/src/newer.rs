//! Files of newer programs.

/// `why` a reader of serde refused a text. Where it met an unknown name, a newer program is suggested in place of the list
/// of known names: a format that only grows keeps its number, which therefore does not show it.
///
/// ```
/// let why = "unknown variant `strobe`, expected `dim` or `bright`";
/// let newer = "unknown variant `strobe`; a newer Chladni may have written it";
/// assert_eq!(chladni_task::newer(why), newer);
/// assert_eq!(chladni_task::newer("missing field `seed`"), "missing field `seed`");
/// ```
pub fn newer(why: &str) -> String {
    if !(why.starts_with("unknown variant `") || why.starts_with("unknown field `")) {
        return why.to_owned();
    }
    let (name, _) = why.split_once("`, ").unwrap_or((why.trim_end_matches('`'), ""));
    format!("{name}`; a newer Chladni may have written it")
}

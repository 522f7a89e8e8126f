//! How long ago something was, in words.

use std::time::SystemTime;

/// When a file was changed, as a part of a sentence; `None` where the system does not know.
pub fn changed_ago(modified: Option<SystemTime>) -> Option<String> {
    let age = SystemTime::now().duration_since(modified?).ok()?;
    Some(match age.as_secs() / 60 {
        0 => "changed less than a minute ago".into(),
        1 => "changed a minute ago".into(),
        minutes @ 2..60 => format!("changed {minutes} minutes ago"),
        minutes @ 60..2880 => format!("changed {} hours ago", minutes.div_ceil(60)),
        minutes => format!("changed {} days ago", minutes / 1440),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn an_age_is_said_of_the_past_alone() {
        let now = SystemTime::now();
        let days = changed_ago(Some(now - Duration::from_secs(3 * 86_400)));
        assert_eq!(days.as_deref(), Some("changed 3 days ago"));
        assert!(changed_ago(Some(SystemTime::UNIX_EPOCH)).is_some_and(|age| age.ends_with(" days ago")));
        for unknown in [Some(now + Duration::from_secs(365 * 86_400)), None] {
            assert_eq!(changed_ago(unknown), None);
        }
    }
}

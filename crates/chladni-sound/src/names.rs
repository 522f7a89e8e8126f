//! Names that distinguish devices: ALSA gives all devices of a card the card's name, and two like microphones share theirs.

/// A name with the id that tells its device from others.
pub fn with_id(name: &str, id: &str) -> String {
    format!("{name} ({id})")
}

/// Adds the ids to names that more than one of these devices has.
pub fn tell_apart<'a>(devices: impl Iterator<Item = (&'a mut String, Option<&'a str>)>) {
    let mut devices: Vec<_> = devices.collect();
    let names: Vec<String> = devices.iter().map(|(name, _)| String::clone(name)).collect();
    for (name, id) in &mut devices {
        if let Some(id) = id
            && names.iter().filter(|other| **other == **name).count() > 1
        {
            **name = with_id(name, id);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_of_one_name_get_their_ids() {
        let ids = [Some("alsa:hw:0"), Some("alsa:hw:1"), Some("alsa:hw:2"), None];
        let mut names = ["USB Audio", "USB Audio", "Line", "Line"].map(str::to_owned);
        tell_apart(names.iter_mut().zip(ids));
        assert_eq!(names, ["USB Audio (alsa:hw:0)", "USB Audio (alsa:hw:1)", "Line (alsa:hw:2)", "Line"]);
    }
}

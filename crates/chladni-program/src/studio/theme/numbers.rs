//! Numbers that are typed or dragged, written and read in one way in both rooms.
//!
//! A typed number counts letter by letter, so that none is lost however its field ends. A text that is no number changes
//! nothing: the last one that was a number stays, as −1 does of "-1x".

use std::cell::RefCell;
use std::ops::RangeInclusive;
use std::rc::Rc;

use egui::emath::{Numeric, format_with_decimals_in_range};
use egui::{DragValue, Slider, SliderClamping};

/// The text that a field showed last. A text that was only looked at is no number to read: as it was shown, the number is
/// rounded.
type Shown = Rc<RefCell<String>>;

/// A number to drag or to type.
pub fn number<N: Numeric>(value: &mut N) -> DragValue<'_> {
    field(value, read)
}

/// The same with a unit behind it, which typed numbers may name, too.
pub fn number_in<'a, N: Numeric>(value: &'a mut N, unit: &'static str) -> DragValue<'a> {
    field(value, move |text| read_before(text, unit)).suffix(unit)
}

/// A number whose text `read` reads.
fn field<'a, N: Numeric>(value: &'a mut N, read: impl Fn(&str) -> Option<f64> + 'a) -> DragValue<'a> {
    let shown = Shown::default();
    let field = DragValue::new(value);
    let field = field.custom_formatter(writing(Rc::clone(&shown), format_with_decimals_in_range));
    field.custom_parser(reading(shown, read))
}

/// A slider that leaves its value as it is until it is moved: egui's own rounds and bounds a value that it only
/// shows, and says that it has changed.
pub fn slider<N: Numeric>(value: &mut N, range: RangeInclusive<N>) -> Slider<'_> {
    let shown = Shown::default();
    let slider = Slider::new(value, range).clamping(SliderClamping::Edits);
    let slider = slider.custom_formatter(writing(Rc::clone(&shown), format_with_decimals_in_range));
    slider.custom_parser(reading(shown, read))
}

/// A slider whose value is shown times `factor`, with a unit; typed numbers are in it, too, whether or not they name
/// it. With a suffix of egui's own the value's name would be "%", not that of its row.
pub fn in_units<'a>(slider: Slider<'a>, factor: f64, decimals: usize, unit: &'static str) -> Slider<'a> {
    let shown = Shown::default();
    let write = move |value: f64, _: RangeInclusive<usize>| format!("{:.decimals$}{unit}", value * factor);
    let read = move |text: &str| Some(read_before(text, unit)? / factor);
    slider.custom_formatter(writing(Rc::clone(&shown), write)).custom_parser(reading(shown, read))
}

/// How a field writes its number.
fn writing<'a>(
    shown: Shown,
    write: impl Fn(f64, RangeInclusive<usize>) -> String + 'a,
) -> impl Fn(f64, RangeInclusive<usize>) -> String + 'a {
    move |value, decimals| {
        let text = with_plain_zero(write(value, decimals));
        shown.borrow_mut().clone_from(&text);
        text
    }
}

/// How a field reads what was typed into it.
fn reading<'a>(shown: Shown, read: impl Fn(&str) -> Option<f64> + 'a) -> impl Fn(&str) -> Option<f64> + 'a {
    move |typed| if *shown.borrow() == typed { None } else { read(typed) }
}

/// The number in `text`, with a decimal point or a decimal comma.
fn read(text: &str) -> Option<f64> {
    let has_point = text.contains('.');
    let plain = |character| match character {
        '−' => '-',
        ',' if !has_point => '.',
        other => other,
    };
    let text: String = text.chars().filter(|character| !character.is_whitespace()).map(plain).collect();
    let number: f64 = text.parse().ok()?;
    // −0 is 0.
    number.is_finite().then_some(if number == 0.0 { 0.0 } else { number })
}

/// The number in `text`, which may end in `unit` or in its first word.
fn read_before(text: &str, unit: &str) -> Option<f64> {
    let (text, unit) = (text.trim(), unit.trim());
    let word = unit.split_whitespace().next().unwrap_or(unit);
    let number = text.strip_suffix(unit).or_else(|| text.strip_suffix(word));
    read(number.unwrap_or(text))
}

/// `text` without the sign of a number that is shown as −0.
fn with_plain_zero(text: String) -> String {
    let is_zero = !text.chars().any(|digit| ('1'..='9').contains(&digit));
    match text.strip_prefix('-') {
        Some(unsigned) if is_zero => unsigned.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_read_with_its_unit_near_or_far_or_without() {
        for text in ["5", " 5 ", "5%", "5 %", "5.0  % ", "5,0 %"] {
            assert_eq!(read_before(text, " %"), Some(5.0), "{text}");
        }
        for text in ["30", "30 %", "30%", "30 % of it"] {
            assert_eq!(read_before(text, " % of it"), Some(30.0), "{text}");
        }
        assert_eq!(read_before("-90°", "°"), Some(-90.0));
        assert_eq!(read_before("90 °", "°"), Some(90.0));
        assert_eq!((read_before("5°", " %"), read_before("%", " %")), (None, None));
    }

    #[test]
    fn a_decimal_comma_is_a_decimal_point_and_half_a_number_is_none() {
        for (text, number) in [("-0,8", -0.8), ("−1.3", -1.3), (",5", 0.5), ("1 000", 1000.0), ("2e-1", 0.2)]
        {
            assert_eq!(read(text), Some(number), "{text}");
        }
        for text in ["", "-", "-1x", "1,2,3", "1,000.5", "inf", "NaN"] {
            assert_eq!(read(text), None, "{text}");
        }
        assert!(read("-0").is_some_and(f64::is_sign_positive));
    }

    #[test]
    fn zero_has_no_sign_and_a_text_that_was_only_shown_is_not_read() {
        let shown = Shown::default();
        let write = writing(Rc::clone(&shown), format_with_decimals_in_range);
        let read = reading(shown, read);
        assert_eq!((write(-0.001, 2..=2), write(-0.0, 1..=1)), ("0.00".to_owned(), "0.0".to_owned()));
        assert_eq!(write(-0.126, 2..=2), "-0.13");
        assert_eq!((read("-0.13"), read("-0.12")), (None, Some(-0.12)));
    }
}

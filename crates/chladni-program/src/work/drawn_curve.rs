//! A curve of many values, drawn by hand in the window or on the web page.

/// Sets all values between two points to the line between them; true where one changed.
pub fn draw(values: &mut [f32], range: (f32, f32), from: [f32; 2], to: [f32; 2]) -> bool {
    let Some(last) = values.len().checked_sub(1) else { return false };
    let index = |u: f32| ((u.clamp(0.0, 1.0) * values.len() as f32) as usize).min(last);
    let (left, right) = if from[0] <= to[0] { (from, to) } else { (to, from) };
    let (first, end) = (index(left[0]), index(right[0]));
    let mut changed = false;
    for i in first..=end {
        let share = if end > first { (i - first) as f32 / (end - first) as f32 } else { 1.0 };
        // A click on one value sets it to where the pointer is now, not to where it was.
        let height = if end > first { left[1] + share * (right[1] - left[1]) } else { to[1] };
        let value = height.clamp(range.0, range.1);
        changed |= values[i] != value;
        values[i] = value;
    }
    changed
}

/// Sets the values whose middles lie in a step of `width` around `middle`, and at least the one there, to `height`; true
/// where one changed. Steps side by side leave each other's values alone.
pub fn draw_step(values: &mut [f32], range: (f32, f32), middle: f32, width: f32, height: f32) -> bool {
    // Slightly less than half a value, so that rounding leaves out none that lies between two steps.
    let half = (0.5 * width - 0.499 / values.len().max(1) as f32).max(0.0);
    draw(values, range, [middle - half, height], [middle + half, height])
}

/// The mean of each value and its neighbors, three times: what "smooth" does.
pub fn smooth(values: &mut [f32]) {
    for _ in 0..3 {
        let before = values.to_vec();
        for i in 1..before.len().saturating_sub(1) {
            values[i] = (before[i - 1] + before[i] + before[i + 1]) / 3.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stroke_sets_all_that_lies_under_it_whichever_way_it_goes() {
        for (from, to) in [([0.2, 0.0], [0.8, 1.0]), ([0.8, 1.0], [0.2, 0.0])] {
            let mut values = [0.5; 10];
            assert!(draw(&mut values, (0.0, 1.0), from, to));
            assert_eq!(values[..2], [0.5; 2]);
            assert_eq!((values[2], values[8], values[9]), (0.0, 1.0, 0.5));
            assert!(values[2..=8].windows(2).all(|pair| pair[0] < pair[1]));
        }
        let mut one = [0.5];
        assert!(draw(&mut one, (0.0, 1.0), [0.0, 0.1], [1.0, 7.0]));
        assert_eq!(one, [1.0]);
        assert!(!draw(&mut [], (0.0, 1.0), [0.0, 0.0], [1.0, 1.0]));
    }

    #[test]
    fn steps_side_by_side_set_all_values_and_leave_those_between_them_alone() {
        for count in [1, 5, 31, 32, 33, 48, 50, 64, 500] {
            let mut values = vec![0.5_f32; count];
            for middle in (0..32).map(|step| (step as f32 + 0.5) / 32.0) {
                let there = values[(middle * count as f32) as usize];
                // More values than steps: the last step has not changed what is read in this one.
                assert!(count < 32 || there == 0.5, "{middle} of {count}");
                draw_step(&mut values, (0.0, 1.0), middle, 1.0 / 32.0, 0.75);
            }
            assert!(values.iter().all(|value| *value == 0.75), "{count}: {values:?}");
        }
    }

    #[test]
    fn smoothing_keeps_constants_and_ends() {
        let mut flat = [0.25; 9];
        smooth(&mut flat);
        assert!(flat.iter().all(|v| (v - 0.25).abs() < 1e-6));
        let mut step = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
        smooth(&mut step);
        assert!(step.windows(2).all(|pair| pair[0] <= pair[1]) && step[0] == 0.0 && step[7] == 1.0);
        smooth(&mut []);
    }
}

//! How far a layer moves a shape, in words.

use std::fmt::Display;

use chladni_caricature::{EvaluatedLayer, Stack};
use chladni_task::counted;

use super::Terminal;
use crate::work::{Error, digits};

/// Prints how far `layer`, which is called `name`, moves the shape of `stack` and how many triangles it folds.
pub fn say_movement(
    name: impl Display,
    layer: &EvaluatedLayer,
    stack: &Stack,
    terminal: &Terminal,
) -> Result<(), Error> {
    let Some(displacement) = &layer.displacement else {
        return terminal.result(format_args!("{name}: off"));
    };
    let farthest = displacement.iter().map(|d| d[0].hypot(d[1]).hypot(d[2])).fold(0.0, f64::max);
    let scale = stack.body().frame.scale;
    let by = digits(farthest / scale, 1.0 / scale);
    let folded = counted(layer.folds(stack.surface()), "triangle", "triangles");
    terminal.result(format_args!("{name}: moves up to {by} units, {folded} folded"))?;
    if let Some(kept) = &layer.kept {
        // Turned aside, it may move a little farther than it would have.
        let share = 100.0 * kept.share.min(1.0);
        let crossing = counted(kept.crossing, "triangle", "triangles");
        terminal
            .result(format_args!("{name}: keeps {share:.0} % of its movement, {crossing} newly crossing"))?;
    }
    Ok(())
}

//! The same, as the window does it: from an action to the figures that are drawn as soon as its shape is there, and how long
//! the window's own thread is busy with that, drawing itself left out.

use chladni_caricature::{
    Action, Layer, LayerId, Model, PaintEdit, Project, Property, RollOff, ScaleCurve, ShapeSource, Smoothing,
    Template,
};
use chladni_task::Task;
use chladni_view::{Device, Draw};

use super::{Error, Timer, median_and_fastest, press};
use chladni_program::studio::Rehearsal;

/// Two layers against things without files, the upper one selected.
fn project(shape: &str, harmonics: usize) -> Result<(Project, [LayerId; 2]), Error> {
    let mut project = Project::new(shape.parse::<ShapeSource>()?, harmonics);
    let lower = project.push(Layer { mu: -0.3, ..Layer::new("lower", Template::Ellipsoid) })?;
    let upper = Layer { curve: ScaleCurve::mid(), mu: -0.3, ..Layer::new("upper", Template::Original) };
    let upper = project.push(upper)?;
    Ok((project, [lower, upper]))
}

/// Takes a row: median and fastest in ms.
type Note<'a> = dyn Fn(String, (f64, f64)) + 'a;

/// Times all that an action needs, and notes how much of it keeps the window's thread busy.
struct Clock<'a> {
    time: &'a mut Timer<'a>,
    note: &'a Note<'a>,
}

/// Times all actions that a user repeats often.
pub fn rehearse<'a>(
    shape: &str,
    harmonics: usize,
    time: &'a mut Timer<'a>,
    note: &'a Note<'a>,
) -> Result<(), Error> {
    let time = &mut Clock { time, note };
    let (project, [lower, upper]) = project(shape, harmonics)?;
    let device = Device::open(Draw::Auto)?;
    let mut room = Rehearsal::of(project, &device, &Task::new())?;
    strokes(&mut room, upper, time)?;
    top_layer(&mut room, upper, time)?;
    keeping(&mut room, upper, time)?;
    new_shape(&mut room, lower, upper, time)
}

fn set(layer: LayerId, to: Property) -> Action {
    Action::Set { layer, to }
}

fn act(room: &mut Rehearsal, action: Action) -> Result<(), Error> {
    room.act(vec![action]).and_then(|_| room.release())
}

/// Times `action`, which gets how often it ran before.
fn timed(
    what: &'static str,
    room: &mut Rehearsal,
    clock: &mut Clock<'_>,
    mut action: impl FnMut(usize, &Rehearsal) -> Action,
) -> Result<(), Error> {
    let mut frames_ms = Vec::new();
    (clock.time)(what, &mut |i| {
        let next = action(i, room);
        let busy_ms = room.act(vec![next])?.as_secs_f64() * 1e3;
        // The first is not counted, as with all that is timed.
        if i > 0 {
            frames_ms.push(busy_ms);
        }
        Ok(())
    })?;
    if !frames_ms.is_empty() {
        (clock.note)(what.replacen("window:", "frame:", 1), median_and_fastest(frames_ms));
    }
    room.release()
}

fn strokes(room: &mut Rehearsal, layer: LayerId, time: &mut Clock<'_>) -> Result<(), Error> {
    let mirror = room.mirror();
    for (what, roll_off, radius, smoothed) in [
        ("window: stroke mirrored, sharp, region as painted", RollOff::Sharp, 0.1, false),
        ("window: stroke mirrored, sharp, smoothed region", RollOff::Sharp, 0.1, true),
        ("window: stroke mirrored, heat, region as painted", RollOff::Heat, 0.1, false),
        ("window: stroke mirrored, heat, smoothed region", RollOff::Heat, 0.1, true),
        ("window: wide stroke mirrored, heat, smoothed region", RollOff::Heat, 0.5, true),
    ] {
        let smoothing = Smoothing { roll_off, ..Smoothing::default() };
        act(room, set(layer, Property::Smoothing(smoothing)))?;
        act(room, Action::Paint { layer, edit: PaintEdit::Clear })?;
        room.show_region(smoothed);
        timed(what, room, time, |i, room| {
            let edit = press(room.surface(), i, radius, mirror);
            Action::Paint { layer, edit }
        })?;
    }
    timed("window: invert the region, heat", room, time, |_, _| {
        let edit = PaintEdit::Invert;
        Action::Paint { layer, edit }
    })?;
    timed("window: softness of the region, heat", room, time, |i, _| {
        set(
            layer,
            Property::Smoothing(Smoothing {
                wavelength: 0.3 + 0.005 * (i % 9) as f64,
                ..Smoothing::default()
            }),
        )
    })
}

fn mu(i: usize) -> Property {
    Property::Mu(-0.2 - 0.001 * i as f64)
}

fn curve(i: usize) -> Property {
    let mut curve = ScaleCurve::mid();
    curve.set_point(0.4, 1.0 + 0.01 * i as f64);
    Property::Curve(curve)
}

fn top_layer(room: &mut Rehearsal, layer: LayerId, time: &mut Clock<'_>) -> Result<(), Error> {
    timed("window: μ", room, time, |i, _| set(layer, mu(i)))?;
    timed("window: strength", room, time, |i, _| set(layer, Property::Strength(1.0 - 0.001 * i as f64)))?;
    for (what, model) in [
        ("window: scale curve, coordinate model", Model::Coordinate),
        ("window: scale curve, normal model", Model::Normal),
        ("window: scale curve, distance model", Model::Distance),
    ] {
        act(room, set(layer, Property::Model(model)))?;
        timed(what, room, time, |i, _| set(layer, curve(i)))?;
    }
    timed("window: choice of the model", room, time, |i, _| set(layer, Property::Model(Model::ALL[i % 3])))?;
    room.show_models(true);
    timed("window: scale curve, three models side by side", room, time, |i, _| set(layer, curve(i)))?;
    timed("window: μ, three models side by side", room, time, |i, _| set(layer, mu(i)))?;
    room.show_models(false);
    Ok(())
}

/// A drag while triangles are kept: how far each place may go is known from before, and is searched anew once the hand rests.
fn keeping(room: &mut Rehearsal, layer: LayerId, time: &mut Clock<'_>) -> Result<(), Error> {
    act(room, Action::KeepTriangles(true))?;
    for (what, model) in [
        ("window: μ, triangles kept, coordinate model", Model::Coordinate),
        ("window: μ, triangles kept, normal model", Model::Normal),
        ("window: μ, triangles kept, distance model", Model::Distance),
    ] {
        act(room, set(layer, Property::Model(model)))?;
        room.settle()?;
        timed(what, room, time, |i, _| set(layer, mu(i)))?;
    }
    timed("window: scale curve, triangles kept", room, time, |i, _| set(layer, curve(i)))?;
    act(room, Action::KeepTriangles(false))
}

/// Everything below a layer gives it a new shape to start from.
fn new_shape(
    room: &mut Rehearsal,
    lower: LayerId,
    upper: LayerId,
    time: &mut Clock<'_>,
) -> Result<(), Error> {
    for (what, model) in [
        ("window: a result as the new shape, coordinate model, curved", Model::Coordinate),
        ("window: a result as the new shape, normal model, curved", Model::Normal),
        ("window: a result as the new shape, distance model, curved", Model::Distance),
    ] {
        act(room, set(upper, Property::Model(model)))?;
        timed(what, room, time, |i, _| set(lower, mu(i)))?;
    }
    timed("window: the lower layer's eye", room, time, |i, _| set(lower, Property::Enabled(i % 2 == 0)))?;
    act(room, set(lower, Property::Enabled(true)))?;
    room.show_models(true);
    timed("window: a result as the new shape, three models side by side", room, time, |i, _| {
        set(lower, mu(i))
    })?;
    room.show_models(false);
    Ok(())
}

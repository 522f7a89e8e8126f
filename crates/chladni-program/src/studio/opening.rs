//! Opening the window: its settings, and how it continues after losing its graphics device.

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use chladni_task::Task;
use chladni_view::Draw;
use chladni_view::film::RawFormat;
use winit::window::Window;

use super::Studio;
use super::caricature::PATIENCE;
use super::choose::{Chooser, SystemDialogs, is_set, is_wayland};
use super::device;
use super::error::StudioError;
use super::folders::Folders;
use super::handover::Handover;
use super::measure::{FirstPicture, Measure};
use super::processor_window::{self, Program};
use super::screen::Screen;

/// Its name, in its frame and for screen readers.
pub(super) const TITLE: &str = "Chladni";

/// Points of the window when it opens.
pub(super) const WINDOW: [f32; 2] = [1320.0, 820.0];

/// The fewest points on which everything has room.
pub(super) const SMALLEST: [f32; 2] = [900.0, 600.0];

/// If a device is lost sooner than this after its window has opened again, it fails again and again.
const SHORTEST: Duration = Duration::from_secs(10);

/// Opens the window on the start screen, or on `files` where some are given, and returns when it is closed. With a
/// measure it closes by itself when all is counted, and with a first picture as soon as that is shown; it closes,
/// too, once `ends` is cancelled. The music room begins the `set`. Where the processor draws, it paints the window, too.
/// If the graphics device is lost, another window goes on with the same rooms; if it fails again and again, the processor
/// draws them.
pub fn open(
    mut files: Vec<PathBuf>,
    mut set: SetPlan,
    measure: Option<Rc<RefCell<Measure>>>,
    first_picture: Option<Rc<FirstPicture>>,
    draw: Draw,
    ends: Task,
) -> Result<(), StudioError> {
    if cfg!(target_os = "linux") && !is_set("DISPLAY") && !is_wayland() {
        return Err(StudioError::NoDisplay);
    }
    let handover = Handover::default();
    // The system's events can be asked for in one way only, so that the first window decides which of two kinds the next
    // ones are.
    let is_graphical = draw.means_graphics();
    let open_next = |draw: Draw| {
        let opening = Opening {
            folders: Folders::of_user(),
            chooser: Box::new(SystemDialogs::drawn(draw)),
            files: std::mem::take(&mut files),
            set: std::mem::take(&mut set),
            measure: measure.clone(),
            first_picture: first_picture.clone(),
            handover: handover.clone(),
            draw,
            ends: Some(ends.clone()),
            ..Opening::default()
        };
        open_once(opening, is_graphical)
    };
    go_on(&handover, draw, open_next, Instant::now)
}

/// Opens a window by `open_next`, which takes the choice of what draws, and another whenever the last one has lost its
/// device, until one closes for another reason. The processor draws where a device is lost again as soon as its window is open;
/// if the window's own painter still loses it, that is the end.
fn go_on(
    handover: &Handover,
    mut draw: Draw,
    mut open_next: impl FnMut(Draw) -> Result<(), StudioError>,
    now: impl Fn() -> Instant,
) -> Result<(), StudioError> {
    let mut is_first = true;
    loop {
        let began = now();
        open_next(draw)?;
        let Some(why) = handover.reason() else { return Ok(()) };
        if !is_first && now() - began < SHORTEST {
            if draw == Draw::Cpu {
                return Err(StudioError::DeviceLost(why));
            }
            draw = Draw::Cpu;
            handover.fall_to_processor();
        }
        is_first = false;
    }
}

fn open_once(opening: Opening, is_graphical: bool) -> Result<(), StudioError> {
    let viewport = egui::ViewportBuilder::default()
        .with_title(TITLE)
        .with_app_id("chladni")
        .with_inner_size(WINDOW)
        .with_min_inner_size(SMALLEST);
    if !is_graphical {
        let create = |ctx: &egui::Context, window: &Arc<Window>| -> Box<dyn Program> {
            Box::new(Studio::on(ctx, Screen::processor(ctx, Some(Arc::clone(window))), opening))
        };
        return Ok(processor_window::open(viewport, create)?);
    }
    device::open("chladni", viewport, |creation| Ok(Box::new(Studio::new(creation, opening)?)))?;
    Ok(())
}

/// The set that the music room begins by itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SetPlan {
    /// The live input that is heard at once.
    pub live: Option<Live>,
    /// The autopilot takes the stage as soon as the shape is there.
    pub autopilot: bool,
    /// Where the set goes.
    pub output: Option<SetOutput>,
}

/// Where the set goes from its first picture on, besides the window.
#[derive(Clone, Debug, PartialEq)]
pub struct SetOutput {
    /// A film of it, or its frames as they come.
    pub to: SetTarget,
    /// Width and height; those of the stage where none are given.
    pub size: Option<[u32; 2]>,
}

/// A recording, or a stream.
#[derive(Clone, Debug, PartialEq)]
pub enum SetTarget {
    /// An MP4 with the sound that is heard.
    Film(PathBuf),
    /// Frames on standard output, in place of the camera that the preferences name.
    Frames(RawFormat),
}

/// The frames that the music room played, for comparison with a film.
pub type Trace = Rc<RefCell<Vec<PlayedFrame>>>;

/// One frame of the music room.
#[derive(Clone, Debug)]
pub struct PlayedFrame {
    /// Since the show began.
    pub at_secs: f64,
    /// The song is known as a whole, so that a film hears the same.
    pub is_known: bool,
    /// Something is on stage.
    pub on_stage: bool,
    /// Coefficients of the mapping's first term, of the first item.
    pub coefficients: Vec<f32>,
}

/// The live input that is heard as soon as the music room is open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Live {
    /// The one that was chosen last.
    Last,
    /// The one of this name.
    Named(String),
}

/// The contents and settings that a window opens with.
pub struct Opening {
    /// Where it keeps its persistent files; nowhere by default.
    pub folders: Folders,
    /// The file dialogs: by default the system's.
    pub chooser: Box<dyn Chooser>,
    /// Files to open at once.
    pub files: Vec<PathBuf>,
    /// Counts frames, and closes the window when it has seen enough.
    pub measure: Option<Rc<RefCell<Measure>>>,
    /// Hears of the first picture, and closes the window.
    pub first_picture: Option<Rc<FirstPicture>>,
    /// The live input that the music room listens to at once, instead of a song.
    pub input: Option<chladni_sound::Capture>,
    /// The set that the music room begins by itself, where there is one; the window opens in that room.
    pub set: SetPlan,
    /// Records the music room's items in each frame.
    pub trace: Option<Trace>,
    /// The rooms that an earlier window left to resume from, and where this one leaves its own if its device is lost.
    pub handover: Handover,
    /// The choice of the device that draws the 3D views.
    pub draw: Draw,
    /// Cancelled to end the program: the window then closes without a question.
    pub ends: Option<Task>,
    /// The clock that measures how long work takes, to reduce quality on a slow machine. Tests pass their own
    /// clock, so that they behave the same on every machine.
    pub now: fn() -> Instant,
    /// How long a frame of the caricature room waits for the shape that its edits make, before it shows the last one
    /// again. Tests wait for ever, so that each frame shows the same on every machine.
    pub patience: Duration,
}

impl Default for Opening {
    fn default() -> Self {
        Self {
            folders: Folders::default(),
            chooser: Box::new(SystemDialogs::default()),
            files: Vec::new(),
            measure: None,
            first_picture: None,
            input: None,
            set: SetPlan::default(),
            trace: None,
            handover: Handover::default(),
            draw: Draw::Auto,
            ends: None,
            now: Instant::now,
            patience: PATIENCE,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::super::caricature::CaricatureRoom;
    use super::super::handover::Left;
    use super::super::room::Room;
    use super::*;

    /// Opens windows that lose their device after this many seconds each, and then one that closes by itself. Returns what
    /// drew in each, and how it ended; the rooms must be the same throughout, and a window knows where the choice fell to the
    /// processor with it.
    fn windows_of(lasting_secs: &[u64]) -> (Vec<Draw>, Result<(), StudioError>) {
        let (handover, clock) = (Handover::default(), Cell::new(Instant::now()));
        let room = CaricatureRoom::waiting(PATIENCE);
        let mut rooms: Vec<Box<dyn Room>> = vec![Box::new(room)];
        let place = |rooms: &[Box<dyn Room>]| {
            rooms.iter().map(|room| std::ptr::from_ref(room.as_ref()).cast::<()>()).collect::<Vec<_>>()
        };
        let first = place(&rooms);
        let mut drawn = Vec::new();
        let open_next = |draw: Draw| {
            if let Some(left) = handover.take() {
                rooms = left.rooms;
                assert_eq!(left.falls_to_processor, draw == Draw::Cpu && drawn.last() != Some(&Draw::Cpu));
            }
            assert_eq!(place(&rooms), first);
            let lasted = lasting_secs.get(drawn.len());
            drawn.push(draw);
            if let Some(secs) = lasted {
                clock.set(clock.get() + Duration::from_secs(*secs));
                let left = Left {
                    rooms: std::mem::take(&mut rooms),
                    current: None,
                    why: "full".into(),
                    at_secs: 0.0,
                    falls_to_processor: false,
                };
                handover.leave(left);
            }
            Ok(())
        };
        let outcome = go_on(&handover, Draw::Auto, open_next, || clock.get());
        (drawn, outcome)
    }

    #[test]
    fn after_a_device_is_lost_twice_in_a_row_the_processor_draws_the_same_rooms() {
        let (drawn, outcome) = windows_of(&[3, 3]);
        assert!(outcome.is_ok());
        assert_eq!(drawn, [Draw::Auto, Draw::Auto, Draw::Cpu]);
        // An hour may lie between, and losses that are rare are none of a device that fails.
        assert_eq!(
            windows_of(&[3600, 3, 3600, 11]).0,
            [Draw::Auto, Draw::Auto, Draw::Cpu, Draw::Cpu, Draw::Cpu]
        );
        assert_eq!(windows_of(&[11, 3600, 11]).0, [Draw::Auto; 4]);
        let (drawn, outcome) = windows_of(&[3, 3, 3]);
        assert!(matches!(outcome, Err(StudioError::DeviceLost(why)) if why == "full"));
        assert_eq!(drawn.len(), 3);
    }
}

//! The loop: events in, frames out.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::viewport::ImmediateViewport;
use egui::{FullOutput, RawInput, ViewportBuilder, ViewportCommand, ViewportEvent, ViewportId, ViewportInfo};
use egui_winit::accesskit_winit;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::window::{Window, WindowId};

use super::ProcessorWindowError;
use super::painter::Painter;
use super::surface::Surface;
use crate::work::system_fonts;

/// The program in a window.
pub trait Program {
    /// One frame.
    fn show(&mut self, ui: &mut egui::Ui);

    /// The window closes.
    fn leave(&mut self) {}
}

/// Frames come no faster than this where the system does not say how fast its screen is.
const FRAME: Duration = Duration::from_micros(16_666);
/// Without word from a system that hides the window, frames go on at this pace, for the sound and other windows.
const HIDDEN: Duration = Duration::from_millis(250);

/// Why the loop wakes up, beside events of the system.
pub enum Wake {
    /// A frame is wanted then; `passes` had been painted when it was asked for.
    Repaint { at: Instant, viewport: ViewportId, passes: u64 },
    /// A screen reader is here.
    Reader(accesskit_winit::Event),
}

impl From<accesskit_winit::Event> for Wake {
    fn from(event: accesskit_winit::Event) -> Self {
        Self::Reader(event)
    }
}

type Create<'a> = Box<dyn FnOnce(&egui::Context, &Arc<Window>) -> Box<dyn Program> + 'a>;

/// A program and its windows.
pub struct Running<'a> {
    ctx: egui::Context,
    wake: EventLoopProxy<Wake>,
    create: Option<Create<'a>>,
    program: Option<Box<dyn Program>>,
    windows: Rc<RefCell<Windows>>,
    /// When the next frame is due.
    due: Option<Instant>,
    /// Since when the system has been asked for one.
    asked: Option<Instant>,
    last: Option<Instant>,
    trouble: Option<ProcessorWindowError>,
}

/// The windows, also for viewports that are shown within a frame.
struct Windows {
    began: Instant,
    painter: Painter,
    open: HashMap<ViewportId, Surface>,
    wanted: HashMap<ViewportId, ViewportBuilder>,
    trouble: Option<ProcessorWindowError>,
}

impl<'a> Running<'a> {
    pub fn new(
        builder: ViewportBuilder,
        wake: EventLoopProxy<Wake>,
        create: impl FnOnce(&egui::Context, &Arc<Window>) -> Box<dyn Program> + 'a,
    ) -> Self {
        let ctx = egui::Context::default();
        ctx.add_font_provider(system_fonts());
        ctx.set_embed_viewports(false);
        let windows = Windows {
            began: Instant::now(),
            painter: Painter::default(),
            open: HashMap::new(),
            wanted: HashMap::from([(ViewportId::ROOT, builder)]),
            trouble: None,
        };
        let windows = Rc::new(RefCell::new(windows));
        let own = Rc::downgrade(&windows);
        egui::Context::set_immediate_viewport_renderer(move |ctx, viewport| {
            if let Some(windows) = own.upgrade() {
                show_within(ctx, &windows, viewport);
            }
        });
        let proxy = wake.clone();
        ctx.set_request_repaint_callback(move |info| {
            let at = Instant::now() + info.delay;
            let (viewport, passes) = (info.viewport_id, info.current_cumulative_pass_nr);
            // Nobody is there any more when the window has closed.
            let _ = proxy.send_event(Wake::Repaint { at, viewport, passes });
        });
        Self {
            ctx,
            wake,
            create: Some(Box::new(create)),
            program: None,
            windows,
            due: None,
            asked: None,
            last: None,
            trouble: None,
        }
    }

    /// How it ended.
    pub fn outcome(self) -> Result<(), ProcessorWindowError> {
        self.trouble.map_or(Ok(()), Err)
    }

    fn begin(&mut self, events: &ActiveEventLoop) -> Result<(), ProcessorWindowError> {
        let mut windows = self.windows.borrow_mut();
        windows.open_wanted(&self.ctx, events)?;
        let mut window = None;
        if let Some(root) = windows.open.get_mut(&ViewportId::ROOT) {
            window = Some(Arc::clone(&root.window));
            root.input.init_accesskit(events, &root.window, self.wake.clone());
            let (info, scale) = (root.info.clone(), egui_winit::pixels_per_point(&self.ctx, &root.window));
            self.ctx.input_mut(|input| {
                input.raw.viewports.insert(ViewportId::ROOT, info);
                input.pixels_per_point = scale;
            });
        }
        drop(windows);
        self.program = self.create.take().zip(window).map(|(create, window)| create(&self.ctx, &window));
        self.due = Some(Instant::now());
        Ok(())
    }

    /// A frame of the main window, and with it of the others.
    fn frame(&mut self, events: &ActiveEventLoop) -> Result<(), ProcessorWindowError> {
        (self.due, self.asked, self.last) = (None, None, Some(Instant::now()));
        let Some(program) = &mut self.program else { return Ok(()) };
        let Some(input) = self.windows.borrow_mut().input(&self.ctx, ViewportId::ROOT) else { return Ok(()) };
        let asked_to_close = input.viewport().close_requested();
        // It may show other windows: nothing is borrowed meanwhile.
        let output = self.ctx.run_ui(input, |ui| program.show(ui));
        let mut windows = self.windows.borrow_mut();
        let commands = |id: &ViewportId| output.viewport_output.get(id).map(|output| &output.commands);
        let stays = commands(&ViewportId::ROOT)
            .is_some_and(|commands| commands.contains(&ViewportCommand::CancelClose));
        let viewports = output.viewport_output.clone();
        windows.show(&self.ctx, ViewportId::ROOT, output, Some(events))?;
        for (id, viewport) in &viewports {
            windows.patch(*id, viewport.builder.clone(), &self.ctx);
        }
        windows.open.retain(|id, _| viewports.contains_key(id));
        windows.wanted.retain(|id, _| viewports.contains_key(id));
        if windows.open_wanted(&self.ctx, events)? {
            self.due = Some(Instant::now());
        }
        // Also to windows that have just opened.
        for (id, viewport) in viewports {
            if let Some(surface) = windows.open.get_mut(&id) {
                surface.obey(&self.ctx, viewport.commands);
            }
        }
        if let Some(why) = windows.trouble.take() {
            return Err(why);
        }
        if asked_to_close && !stays {
            events.exit();
        }
        Ok(())
    }

    fn end_with(&mut self, result: Result<(), ProcessorWindowError>, events: &ActiveEventLoop) {
        if let Err(why) = result {
            self.trouble.get_or_insert(why);
            events.exit();
        }
    }

    /// The shortest time from one frame to the next: as the screen shows them.
    fn pace(&self) -> Duration {
        let windows = self.windows.borrow();
        let root = windows.open.get(&ViewportId::ROOT);
        let monitor = root.and_then(|root| root.window.current_monitor());
        let rate = monitor.and_then(|monitor| monitor.refresh_rate_millihertz()).filter(|rate| *rate > 0);
        rate.map_or(FRAME, |millihertz| Duration::from_secs_f64(1e3 / f64::from(millihertz)))
    }
}

impl ApplicationHandler<Wake> for Running<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.create.is_some() {
            let begun = self.begin(events);
            self.end_with(begun, events);
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, wake: Wake) {
        match wake {
            Wake::Repaint { at, viewport, passes } => {
                // A frame that has come since has seen to it.
                let passed = self.ctx.cumulative_pass_nr_for(viewport);
                if passed == passes || passed == passes + 1 {
                    self.due = Some(self.due.map_or(at, |due| due.min(at)));
                }
            }
            Wake::Reader(event) => {
                if let Some(root) = self.windows.borrow_mut().open.get_mut(&ViewportId::ROOT) {
                    match event.window_event {
                        accesskit_winit::WindowEvent::InitialTreeRequested => self.ctx.enable_accesskit(),
                        accesskit_winit::WindowEvent::ActionRequested(request) => {
                            root.input.on_accesskit_action_request(request);
                        }
                        accesskit_winit::WindowEvent::AccessibilityDeactivated => {
                            self.ctx.disable_accesskit();
                        }
                    }
                }
                self.due = Some(Instant::now());
            }
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, id: WindowId, event: WindowEvent) {
        if matches!(event, WindowEvent::RedrawRequested) {
            let framed = self.frame(events);
            return self.end_with(framed, events);
        }
        let mut windows = self.windows.borrow_mut();
        let Some(surface) = windows.open.values_mut().find(|surface| surface.window.id() == id) else {
            return;
        };
        match &event {
            WindowEvent::CloseRequested => surface.info.events.push(ViewportEvent::Close),
            WindowEvent::Occluded(hidden) => surface.info.occluded = Some(*hidden),
            _ => {}
        }
        let close = matches!(event, WindowEvent::CloseRequested);
        if surface.input.on_window_event(&surface.window, &event).repaint || close {
            self.due = Some(Instant::now());
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let now = Instant::now();
        if self.asked.is_some_and(|since| now - since >= HIDDEN) {
            let framed = self.frame(events);
            self.end_with(framed, events);
        }
        // Painted no faster than the screen shows it.
        let earliest = self.last.map_or(now, |last| last + self.pace());
        let due = self.due.map(|due| due.max(earliest));
        if due.is_some_and(|due| due <= now)
            && self.asked.is_none()
            && let Some(root) = self.windows.borrow().open.get(&ViewportId::ROOT)
        {
            root.window.request_redraw();
            self.asked = Some(now);
        }
        let hidden = self.asked.map(|since| since + HIDDEN);
        let next = if self.asked.is_some() { hidden } else { due };
        events.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        if let Some(mut program) = self.program.take() {
            program.leave();
        }
        // Windows go while their display is still there.
        self.windows.borrow_mut().open.clear();
    }
}

impl Windows {
    /// The events for a window since its last frame.
    fn input(&mut self, ctx: &egui::Context, id: ViewportId) -> Option<RawInput> {
        let surface = self.open.get_mut(&id)?;
        egui_winit::update_viewport_info(&mut surface.info, ctx, &surface.window, false);
        let mut input = surface.input.take_egui_input(&surface.window);
        input.time = Some(self.began.elapsed().as_secs_f64());
        input.viewports = self.open.iter().map(|(id, surface)| (*id, surface.info.clone())).collect();
        Some(input)
    }

    /// Input for a window that is not open yet: egui must run for it all the same.
    fn input_before(&self, id: ViewportId, builder: &ViewportBuilder) -> RawInput {
        let size = builder.inner_size.unwrap_or(egui::vec2(640.0, 480.0));
        let known = self.open.iter().map(|(id, surface)| (*id, surface.info.clone()));
        RawInput {
            viewport_id: id,
            viewports: known.chain([(id, ViewportInfo::default())]).collect(),
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size)),
            time: Some(self.began.elapsed().as_secs_f64()),
            ..RawInput::default()
        }
    }

    fn show(
        &mut self,
        ctx: &egui::Context,
        id: ViewportId,
        output: FullOutput,
        events: Option<&ActiveEventLoop>,
    ) -> Result<(), ProcessorWindowError> {
        let Some(surface) = self.open.get_mut(&id) else { return Ok(()) };
        // They were seen in this frame.
        surface.info.events.clear();
        surface.show(ctx, &mut self.painter, output, events)
    }

    /// A window is to be like this from now on.
    fn patch(&mut self, id: ViewportId, builder: ViewportBuilder, ctx: &egui::Context) {
        let (commands, recreate) = self.wanted.entry(id).or_default().patch(builder);
        if recreate {
            self.open.remove(&id);
        } else if let Some(surface) = self.open.get_mut(&id) {
            surface.obey(ctx, commands);
        }
    }

    /// Opens the wanted windows that are not open; true where there was any.
    fn open_wanted(
        &mut self,
        ctx: &egui::Context,
        events: &ActiveEventLoop,
    ) -> Result<bool, ProcessorWindowError> {
        let mut any = false;
        for (id, builder) in &self.wanted {
            if !self.open.contains_key(id) {
                self.open.insert(*id, Surface::open(ctx, events, *id, builder)?);
                any = true;
            }
        }
        Ok(any)
    }
}

/// A window that is shown while the main one is. One that is not there yet opens after the frame, which also takes the
/// commands to it.
fn show_within(ctx: &egui::Context, windows: &RefCell<Windows>, mut viewport: ImmediateViewport<'_>) {
    let id = viewport.ids.this;
    let input = {
        let mut windows = windows.borrow_mut();
        windows.patch(id, viewport.builder.clone(), ctx);
        windows.input(ctx, id).unwrap_or_else(|| windows.input_before(id, &viewport.builder))
    };
    let mut output = ctx.run_ui(input, |ui| (viewport.viewport_ui_cb)(ui));
    let mut windows = windows.borrow_mut();
    if !windows.open.contains_key(&id) {
        windows.painter.update(&mut output.textures_delta);
        windows.painter.forget(&mut output.textures_delta);
        return;
    }
    if let Err(why) = windows.show(ctx, id, output, None) {
        windows.trouble.get_or_insert(why);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_window_shows_runs_before_the_window_is_open() {
        let windows = Rc::new(RefCell::new(Windows {
            began: Instant::now(),
            painter: Painter::default(),
            open: HashMap::new(),
            wanted: HashMap::new(),
            trouble: None,
        }));
        let (own, id) = (Rc::clone(&windows), ViewportId::from_hash_of("second"));
        egui::Context::set_immediate_viewport_renderer(move |ctx, viewport| show_within(ctx, &own, viewport));
        let ctx = egui::Context::default();
        ctx.set_embed_viewports(false);
        let mut size = None;
        let mut output = ctx.run_ui(RawInput::default(), |ui| {
            let builder = ViewportBuilder::default().with_inner_size([300.0, 200.0]);
            size =
                Some(ui.ctx().show_viewport_immediate(id, builder, |ui, _| ui.ctx().content_rect().size()));
        });
        output.textures_delta.clear();
        assert_eq!(size, Some(egui::vec2(300.0, 200.0)));
        assert!(windows.borrow().wanted.contains_key(&id), "it opens after the frame");
    }
}

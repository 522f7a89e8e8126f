//! The room in the hands of a controller.

use chladni_music::Action;

use super::clocks::packet;
use super::*;

/// A message with one text.
fn named(address: &str, text: &str) -> Vec<u8> {
    let padded = |text: &str| {
        let mut bytes = text.as_bytes().to_vec();
        bytes.resize(4 * (text.len() / 4 + 1), 0);
        bytes
    };
    [padded(address), padded(",s"), padded(text)].concat()
}

/// A bundle of messages, to be done at once.
fn bundle(packets: &[Vec<u8>]) -> Vec<u8> {
    let mut bundle = b"#bundle\0\0\0\0\0\0\0\0\x01".to_vec();
    for packet in packets {
        bundle.extend((packet.len() as u32).to_be_bytes());
        bundle.extend(packet);
    }
    bundle
}

/// A room that hears OSC messages.
struct Desk {
    window: Window,
    socket: UdpSocket,
    port: u16,
    settings: std::path::PathBuf,
    _folder: tempfile::TempDir,
}

impl Desk {
    fn begin(chooser: &Answers) -> Self {
        Self::begin_with(chooser, "")
    }

    /// Begins with these preferences of the room.
    fn begin_with(chooser: &Answers, music: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let recordings = Some(folder.path().to_owned());
        let folders = Folders { recordings, ..folders(folder.path()) };
        let port = free_port();
        let settings = folders.settings.clone().unwrap();
        std::fs::write(&settings, format!("harmonics = 24\n[music]\nosc_port = {port}\n{music}")).unwrap();
        let opening = Opening { folders, chooser: Box::new(chooser.clone()), ..Opening::default() };
        let window = enter(opening);
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        Self { window, socket, port, settings, _folder: folder }
    }

    fn send(&mut self, packet: &[u8]) {
        self.socket.send_to(packet, (Ipv4Addr::LOCALHOST, self.port)).unwrap();
        for _ in 0..4 {
            std::thread::sleep(std::time::Duration::from_millis(20));
            self.window.run_steps(1);
        }
    }

    fn touch(&mut self, name: &str, value: f32) {
        self.send(&packet(&format!("/chladni/{name}"), value));
    }

    /// Messages come when a busy machine lets them.
    fn until(&mut self, what: &str, holds: impl Fn(&Window) -> bool) {
        wait(&mut self.window, what, holds);
    }

    fn until_settings_say(&mut self, lines: &[&str]) {
        let settings = self.settings.clone();
        let says = |text: &str| lines.iter().all(|line| text.contains(line));
        self.until(lines[0], |_| std::fs::read_to_string(&settings).is_ok_and(|text| says(&text)));
    }

    fn settings(&self) -> String {
        std::fs::read_to_string(&self.settings).unwrap()
    }

    fn until_brightness(&mut self, holds: impl Fn(f64) -> bool) {
        let began = Instant::now();
        loop {
            self.window.run_steps(10);
            let now = self.brightness();
            if holds(now) {
                return;
            }
            assert!(began.elapsed() < chladni_testdata::HANGS, "{now}");
        }
    }

    fn brightness(&mut self) -> f64 {
        let picture = self.window.render().unwrap();
        let sum: u64 = picture.pixels().map(|p| u64::from(p[0]) + u64::from(p[1]) + u64::from(p[2])).sum();
        sum as f64 / f64::from(3 * picture.width() * picture.height())
    }
}

#[test]
fn gallery_look_and_stage_obey() {
    let mut desk = Desk::begin(&Answers::default());
    for dance in [3.0, 5.0] {
        desk.touch("choose", dance);
    }
    desk.until("two are chosen", |w| is_chosen(w, "dance/3") && is_chosen(w, "dance/5"));
    desk.touch("choose", 5.0);
    desk.until("one is not", |w| !is_chosen(w, "dance/5"));
    desk.touch("choose", 5.0);
    desk.touch("breed", 1.0);
    desk.until("children", |w| shows(w, "2 / 2"));
    desk.touch("back", 1.0);
    desk.until("their parents", |w| shows(w, "1 / 2"));
    desk.send(&named("/chladni/look", "Ember"));
    desk.touch("palette", 5.0);
    desk.until_settings_say(&["look = \"ember\"", "palette = \"gold\""]);
    desk.send(&named("/chladni/preset", "no such dance"));
    desk.until("the refusal", |w| shows(w, "no such dance"));
    desk.touch("choose", 99.0);
    desk.touch("volume", 0.25);
    desk.until_settings_say(&["volume = 0.25"]);

    assert!(shows(&desk.window, "12 items"));
    desk.touch("stage", 2.0);
    desk.until("the stage", |w| !shows(w, "12 items"));
    desk.window.run_steps(30);
    let bright = desk.brightness();
    desk.touch("blackout", 1.0);
    desk.touch("blackout", 0.0);
    desk.until_brightness(|now| now < 0.1 * bright);
    desk.touch("blackout", 1.0);
    // The song goes on meanwhile: some of its moments are darker.
    desk.until_brightness(|now| now > 0.5 * bright);
    desk.touch("preset", 3.0);
    desk.touch("random", 1.0);
    desk.touch("shot", 7.0);
    desk.touch("cue", 6.0);
    desk.touch("go", 1.0);
    desk.touch("leave", 1.0);
    desk.window.run_steps(30);
    desk.until("the gallery", |w| shows(w, "12 items"));
}

#[test]
fn messages_of_one_bundle_are_done_one_after_the_other() {
    let mut desk = Desk::begin(&Answers::default());
    let touch = |name: &str, value: f32| packet(&format!("/chladni/{name}"), value);
    desk.send(&bundle(&[touch("choose", 4.0), touch("choose", 4.0), touch("choose", 5.0)]));
    desk.until("one is chosen", |w| is_chosen(w, "dance/5"));
    assert!(!is_chosen(&desk.window, "dance/4"), "it was chosen, and then no longer");
    // The stage opens black.
    desk.send(&bundle(&[touch("stage", 2.0), touch("blackout", 1.0)]));
    desk.until("the stage", |w| !shows(w, "12 items"));
    desk.until_brightness(|now| now < 1.0);
    desk.touch("blackout", 1.0);
    desk.until_brightness(|now| now > 1.0);
}

#[test]
fn machines_are_heard_until_others_are_typed() {
    let music = "osc_network = true\nosc_allowed = [\"10.0.0.1\"]\n";
    let mut desk = Desk::begin_with(&Answers::default(), music);
    click(&mut desk.window, "drawer/remote");
    click(&mut desk.window, "osc-allowed");
    desk.window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    desk.window.key_press(Key::Backspace);
    desk.window.run_steps(2);
    desk.touch("volume", 0.25);
    // An empty list would let in all.
    desk.until_settings_say(&["volume = 0.25", "\"10.0.0.1\""]);
    control(&desk.window, "osc-allowed").type_text("10.0.0.2");
    desk.window.run_steps(2);
    desk.window.key_press(Key::Enter);
    desk.until_settings_say(&["\"10.0.0.2\""]);
    assert!(!desk.settings().contains("10.0.0.1"));
}

#[test]
fn a_look_chosen_by_hand_takes_the_place_of_the_autopilots() {
    let answers = Answers::default();
    let mut desk = Desk::begin(&answers);
    desk.touch("autopilot", 1.0);
    desk.until("the stage", |w| !shows(w, "12 items"));
    // The first dance has the look of the show; the second one stays, whatever the song does.
    desk.touch("stay", 1.0);
    desk.touch("next", 1.0);
    desk.send(&named("/chladni/material", "clay"));
    desk.until_settings_say(&["material = \"clay\""]);
    desk.touch("autopilot", 1.0);
    desk.until("the gallery", |w| shows(w, "12 items"));
    let show = saved_show(&mut desk.window, &answers, &desk.settings.with_file_name("leant.toml"));
    let looks: Vec<&str> = show.actions.iter().filter_map(|line| look_of(&line.action)).collect();
    let [of_autopilot, ""] = looks[..] else { panic!("{looks:?}") };
    let seen = show.looks.unwrap();
    assert_eq!((seen.look.as_str(), seen.material.as_str()), (of_autopilot, "clay"));
}

#[test]
fn the_gallery_from_before_the_autopilot_follows_a_dance_that_ends_it() {
    let answers = Answers::default();
    let mut desk = Desk::begin(&answers);
    desk.touch("beat-steps", 1.0);
    desk.touch("autopilot", 1.0);
    desk.until("the stage", |w| !shows(w, "12 items"));
    desk.touch("stage", 2.0);
    desk.touch("leave", 1.0);
    desk.until("the gallery", |w| shows(w, "12 items"));
    let file = desk.settings.with_file_name("taken-back.toml");
    let actions = saved_show(&mut desk.window, &answers, &file).actions;
    let place = |is: fn(&Action) -> bool| actions.iter().position(|line| is(&line.action)).unwrap();
    let returns = place(|action| *action == Action::GoTo { generation: 0 });
    assert!(returns < place(|action| *action == Action::PerformGallery { first: 1 }));
}

fn look_of(action: &Action) -> Option<&str> {
    if let Action::SetLook { look } = action { Some(look) } else { None }
}

#[test]
fn songs_input_clock_and_recording_obey() {
    let mut desk = Desk::begin(&Answers::default());
    desk.touch("blur", 0.4);
    desk.touch("follow-clock", 1.0);
    desk.until_settings_say(&["blur_percent = 40", "follows_clock = true"]);
    desk.touch("follow-clock", 1.0);
    desk.until_settings_say(&["follows_clock = false"]);
    click(&mut desk.window, "drawer/songs");
    assert!(is_chosen(&desk.window, "repeat/list"));
    desk.send(&named("/chladni/repeat", "song"));
    desk.until("the song is repeated", |w| is_chosen(w, "repeat/song"));
    desk.touch("repeat", 1.0);
    desk.until("nothing is", |w| !is_chosen(w, "repeat/song") && !is_chosen(w, "repeat/list"));
    desk.touch("shuffle", 1.0);
    desk.touch("live", 1.0);
    desk.until("that no input was chosen", |w| shows(w, "No live input was chosen yet"));
    // Each dance has a µ of its own until a hand turns that of all.
    click(&mut desk.window, "drawer/knobs");
    assert!(is_chosen(&desk.window, "own-mu"));
    desk.touch("stereo-mu", 0.5);
    desk.until("the µ of all", |w| !is_chosen(w, "own-mu"));
    assert!(shows(&desk.window, "All dances have the µ of the knob now"));
    assert!(!shows(&desk.window, "A controller asked for"));
    if !chladni_view::ffmpeg_is_there() {
        desk.touch("record", 1.0);
        return desk.until("that ffmpeg is missing", |w| shows(w, "ffmpeg is not on the PATH"));
    }
    // Nobody is asked for a name, and no file is replaced.
    std::fs::write(desk.settings.with_file_name("set 1.mp4"), "an evening").unwrap();
    desk.touch("record", 1.0);
    desk.until("the recording", |w| is_there(w, "recording-end"));
    desk.until("its name", |w| shows(w, "set 2.mp4"));
    desk.touch("record", 1.0);
    desk.until("its end", |w| !is_there(w, "recording-end"));
}

#[test]
fn bindings_are_learned_with_a_number_and_go_to_another_machine() {
    let answers = Answers::default();
    let mut desk = Desk::begin(&answers);
    click(&mut desk.window, "drawer/remote");
    // It may have to be scrolled to.
    control(&desk.window, "learn/song").click_accesskit();
    desk.window.run_steps(2);
    desk.send(&packet("/pad/1", 1.0));
    desk.until("the pad", |w| shows(w, "/pad/1"));
    let file = desk.settings.with_file_name("desk.toml");
    answers.add(&file);
    click(&mut desk.window, "bindings-export");
    desk.until("the file", |_| file.exists());
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.contains("/pad/1") && text.contains("song"), "{text}");
    std::fs::write(&file, text.replace("/pad/1", "/pad/9")).unwrap();
    answers.add(&file);
    click(&mut desk.window, "bindings-import");
    desk.window.run_steps(2);
    let settings = desk.settings.clone();
    wait(&mut desk.window, "both bindings", |_| {
        let kept = std::fs::read_to_string(&settings).unwrap();
        kept.contains("/pad/1") && kept.contains("/pad/9")
    });
    std::fs::write(&file, "format_version = 99\n").unwrap();
    answers.add(&file);
    click(&mut desk.window, "bindings-import");
    desk.until("the refusal", |w| shows(w, "99"));
}

/// The window goes on while somebody floods it.
#[test]
fn a_flood_of_messages_stalls_nothing() {
    let mut desk = Desk::begin(&Answers::default());
    let port = desk.port;
    let flood = std::thread::spawn(move || {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let (knob, odd) = (packet("/chladni/gain", 0.5), packet("/strange", f32::NAN));
        for i in 0..100_000usize {
            let bytes: &[u8] = [&knob[..], &odd, b"no osc at all", &[b'/'; 1600]][i % 4];
            let _ = socket.send_to(bytes, (Ipv4Addr::LOCALHOST, port));
        }
    });
    let mut frames = 0;
    while !flood.is_finished() {
        desk.window.run_steps(1);
        frames += 1;
    }
    assert!(frames > 0);
    // Messages that arrive while the queue is full are lost, as they would be on a network.
    let began = Instant::now();
    while !desk.settings().contains("volume = 0.125") {
        assert!(began.elapsed() < chladni_testdata::HANGS);
        desk.touch("volume", 0.125);
    }
}

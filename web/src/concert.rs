//! One body that dances: the music room without a window. The page says which song plays and how large its picture
//! is, and gets the pixels.

mod beat;
mod curves;
mod doings;
mod files;
mod knobs;
mod live;
mod playing;
mod stage;
mod standing;
mod state;

use std::sync::Arc;

use chladni_mesh::Orientation;
use chladni_music::{
    Dancer, Ensemble, FileRef, Framing, GalleryShape, Instrument, Looks, Parameter, Parameters, Reaction,
    Veil, Viewpoint,
};
use chladni_program::work::{
    Error, Hearing, KnownSong, Lag, Playing, Programme, Recent, SandTable, ShowClock, Staging, along,
    chooses_shots, look_named, look_on_stage, opening_looks, opening_view, read_beats,
};
use chladni_sound::{Beats, Song};
use chladni_synth::SynthModel;
use chladni_view::{Device, Figure, Look, Mood, Rect};
use wasm_bindgen::prelude::*;

use self::beat::ShowSong;
use self::live::Live;
use self::playing::Script;
use self::stage::{Figures, Stage};
use crate::now_ms;
use crate::parcel::Parcel;

/// A shape, its dances, the sound, and the picture of it.
#[wasm_bindgen]
pub struct Concert {
    name: String,
    /// How the body was found to stand, and what was set in its place.
    found: Orientation,
    given: Option<Orientation>,
    /// This body as the show names it that was opened or played last, if that is danced on it.
    shows_body: Option<FileRef>,
    hearing: Hearing,
    /// The live input in place of a song.
    live: Option<Live>,
    clock: ShowClock,
    /// The page's clock, by which flashes are counted: that of a show begins anew with each.
    now_secs: f64,
    instrument: Instrument,
    ensemble: Ensemble,
    staging: Staging,
    sand: SandTable,
    /// The lag, which palettes read as speed.
    lag: Lag,
    programme: Option<Programme>,
    /// The rest of a show that is being played.
    script: Option<Script>,
    /// The sound of late, by which children are suggested.
    recent: Recent,
    /// The knobs as they stood before there was sand.
    before_sand: Option<Parameters>,
    looks: Looks,
    viewpoint: Viewpoint,
    /// See [`took_ms`](Self::took_ms).
    took_ms: [f64; 2],
    /// Its songs, by number.
    songs: Vec<ShowSong>,
    stage: Stage,
}

/// A file's name without its folders, whatever system wrote them.
fn base(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// Whether a path leads to the file of this name, whose accents the page has composed: a Mac may write them apart.
fn is_called(path: &str, name: &str) -> bool {
    js_sys::JsString::from(base(path)).normalize("NFC") == name
}

/// The effect of beat and sound on one picture.
struct Shot {
    at_secs: f64,
    reaction: Reaction,
    framing: Option<Framing>,
    mood: Mood,
    /// How many dances are seen.
    count: usize,
}

#[wasm_bindgen]
impl Concert {
    /// A gallery of `size` dances (6, 9, 12 or 16) for the body that [`prepare`](crate::prepare) made ready.
    ///
    /// # Errors
    /// Damaged bytes, or a size that there is not.
    #[wasm_bindgen(constructor)]
    pub fn new(body: &[u8], size: usize, seed: u32) -> Result<Self, JsError> {
        let Parcel { name, body, classes, stands, own } = Parcel::from_bytes(body)?;
        let dancer = Arc::new(Dancer::new(&body, &classes, &stands)?);
        let bands = Parameter::Bands.initial() as usize;
        let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands };
        let instrument = Instrument::new(seed.into(), size, shape)?;
        let model = SynthModel::new(&body)?;
        let rest = model.rest_positions().to_vec();
        let along = along(&body, &dancer);
        let mut staging = Staging::new(Arc::clone(&dancer), rest, &body.triangles, along, stands);
        staging.color(own);
        let mut hearing = Hearing::default();
        hearing.tune(0.0, instrument.parameters());
        Ok(Self {
            stage: Stage::new(model, body.triangles.clone(), &staging)?,
            hearing,
            live: None,
            clock: ShowClock::default(),
            now_secs: 0.0,
            instrument,
            ensemble: Ensemble::new(dancer),
            staging,
            lag: Lag::default(),
            sand: SandTable::new(body, 0.0),
            found: stands,
            given: None,
            programme: None,
            script: None,
            recent: Recent::default(),
            before_sand: None,
            looks: opening_looks(&name),
            viewpoint: opening_view(&name),
            took_ms: [0.0; 2],
            songs: Vec::new(),
            shows_body: None,
            name,
        })
    }

    /// A song is known from now on, by its number: the result of [`decode`](crate::decode), and its name.
    ///
    /// # Errors
    /// Beats that are none.
    #[allow(clippy::too_many_arguments, reason = "no struct of ours crosses from JavaScript in one piece")]
    pub fn know_song(
        &mut self,
        number: usize,
        name: String,
        rate_hz: u32,
        left: Vec<f32>,
        right: Vec<f32>,
        beats: &str,
        loud: f32,
    ) -> Result<(), JsError> {
        let mut song = KnownSong::of_loudness(Arc::new(Song { rate_hz, left, right }), loud);
        let beats: Beats = serde_json::from_str(beats)?;
        self.songs.resize_with(self.songs.len().max(number + 1), ShowSong::default);
        let known = &mut self.songs[number];
        song.beats = Some(read_beats(&beats, known.reading));
        known.call(name);
        known.beats = Some(beats);
        let is_news = self.hearing.song(number).is_none_or(|known| known.beats.is_none());
        let was_heard = self.hearing.stretches().any(|stretch| stretch.song == Some(number));
        self.hearing.know(number, song);
        // The page plays one song at a time, and decodes it again where it is wanted again.
        self.hearing.forget_samples_but(number);
        if is_news && was_heard {
            self.count_beats()?;
        }
        Ok(())
    }

    /// Draws what is heard at `now_secs` of any steady clock, while the song of a number (below 0: none) is
    /// heard at a position of it, or what comes in from a microphone, in a picture of `width` × `height` pixels.
    /// False where nothing is known of that song yet: the picture stays.
    ///
    /// # Errors
    /// A picture without pixels or too large, and bugs.
    pub fn frame(
        &mut self,
        now_secs: f64,
        song: i32,
        position_secs: f64,
        duration_secs: f64,
        width: u32,
        height: u32,
    ) -> Result<bool, JsError> {
        let Some(shot) = self.dance(now_secs, song, position_secs, duration_secs)? else { return Ok(false) };
        let began_ms = now_ms();
        self.draw(shot, width, height)?;
        self.took_ms[1] = now_ms() - began_ms;
        Ok(true)
    }

    /// The same without a picture: the sand and all that swings go on to that time.
    ///
    /// # Errors
    /// Bugs only.
    pub fn go_on(
        &mut self,
        now_secs: f64,
        song: i32,
        position_secs: f64,
        duration_secs: f64,
    ) -> Result<(), JsError> {
        self.dance(now_secs, song, position_secs, duration_secs)?;
        Ok(())
    }

    /// Milliseconds that the last picture took: to deform its bodies, and to draw them, or to tell the graphics card what
    /// to draw.
    pub fn took_ms(&self) -> Vec<f64> {
        self.took_ms.to_vec()
    }

    /// Where the pixels of the last picture begin in the module's memory: RGBA, rows from the top.
    pub fn pixels(&self) -> *const u8 {
        self.stage.figures.screen.picture().rgba.as_ptr()
    }

    /// Looks at the picture that a graphics card drew last, made small: RGBA, rows from the top. How opaque the veil is
    /// under which it may be shown, of 255: above 0 of white, below of black.
    pub fn judge(&mut self, rgba: &[u8], width: u32, height: u32) -> i32 {
        let Some(area) = self.instrument.parameters().flash_area() else { return 0 };
        self.stage.guard.set_area(area);
        match self.stage.guard.judge(self.now_secs, rgba.as_chunks().0, [width, height]) {
            Veil::Clear => 0,
            Veil::Black(opacity) => -i32::from(opacity),
            Veil::White(opacity) => opacity.into(),
        }
    }

    /// The processor draws from now on: the page has lost its graphics card.
    ///
    /// # Errors
    /// Bugs only.
    pub fn draw_by_processor(&mut self) -> Result<(), JsError> {
        Ok(self.stage.draw_by(Device::Processor, &self.staging)?)
    }

    /// x, y, width and height, in pixels, of the cell of each dance in the last picture.
    pub fn cells(&self) -> Vec<u32> {
        self.stage.cells.clone()
    }

    /// How many vertices the body has.
    pub fn vertices(&self) -> usize {
        self.staging.rest().len()
    }

    /// How many harmonics it has.
    pub fn harmonics(&self) -> usize {
        self.ensemble.dancer().harmonics()
    }
}

impl Concert {
    /// The look by its names, or that of the dance on stage.
    fn look(&self) -> Look {
        look_on_stage(&self.instrument, look_named(&self.looks).0)
    }

    /// Hears, dances and deforms; none where nothing is known of the song yet.
    fn dance(
        &mut self,
        now_secs: f64,
        song: i32,
        position_secs: f64,
        duration_secs: f64,
    ) -> Result<Option<Shot>, Error> {
        self.now_secs = self.now_secs.max(now_secs);
        let song = usize::try_from(song).ok().filter(|_| self.live.is_none());
        let (position_secs, duration_secs) = match song {
            Some(_) => (position_secs, Some(duration_secs).filter(|secs| *secs > 0.0)),
            None => (0.0, None),
        };
        // Songs whose length is known end by that.
        let playing = Playing { song, position_secs, duration_secs, crossfade_secs: 0.0, is_over: false };
        if let Some(stretch) = self.clock.follow(now_secs, playing) {
            self.hearing.begin(stretch)?;
        }
        let at_secs = self.clock.at_secs();
        self.follow_script(at_secs)?;
        self.follow_programme(at_secs)?;
        let feels_speed = self.look().feels_speed();
        let (hearing, ensemble) = (&mut self.hearing, &mut self.ensemble);
        let is_live = self.live.is_some();
        let (heard, framing) = match &mut self.live {
            Some(live) => {
                let framing = live.framing();
                (live.hear(at_secs, self.instrument.parameters())?, framing)
            }
            None => {
                self.sand.follow(hearing, ensemble, &self.instrument, None, at_secs)?;
                let framing = hearing.framing_at(at_secs, |secs| self.instrument.seed_at(secs));
                let Some(heard) = hearing.hear(at_secs)? else { return Ok(None) };
                (heard, framing)
            }
        };
        let framing = Some(framing).filter(|_| chooses_shots(&self.instrument, heard.beat));
        let (reaction, mood) = (heard.reaction(&self.instrument), heard.mood());
        self.recent.hear(at_secs, &heard.bands);
        let items = ensemble.play(&self.instrument, &heard.bands, heard.beat)?;
        let shot = Shot { at_secs, reaction, framing, mood, count: items.len() };
        while is_live && self.sand.due(at_secs).is_some() {
            self.sand.step(items, &self.instrument);
        }
        let mut items = items.to_vec();
        self.lag.follow(&mut items, at_secs, feels_speed);
        let began_ms = now_ms();
        self.stage.deform(&items, &self.instrument.parameters().frame_settings())?;
        self.took_ms[0] = now_ms() - began_ms;
        Ok(Some(shot))
    }

    fn draw(&mut self, shot: Shot, width: u32, height: u32) -> Result<(), Error> {
        let Shot { at_secs, reaction, framing, mood, count } = shot;
        let on_stage = self.look();
        let look = on_stage.answering(&mood);
        let stage = &mut self.stage;
        let Figures { topology, small, wardrobe, buffers, renderer, screen } = &mut stage.figures;
        screen.fit(width, height)?;
        let from = (&self.viewpoint, framing.as_ref());
        let area = Rect::of_size(width, height);
        let staged = self.staging.set(area, count, from, &look, reaction, &self.instrument);
        let grains = self.sand.drawn(&on_stage);
        let topology = small.as_ref().filter(|_| count > 1).unwrap_or(topology);
        let figure = |item| Figure {
            grains: grains.get(item).copied(),
            ..staged.figure(topology, buffers, item, wardrobe)
        };
        let figures: Vec<Figure<'_>> = (0..count).map(figure).collect();
        let cells = staged.cells(&figures);
        renderer.draw_finished(screen.canvas(), &cells, &staged.look.finish, at_secs)?;
        if let Some((picture, area)) = screen.show()?.zip(self.instrument.parameters().flash_area()) {
            stage.guard.set_area(area);
            stage.guard.pass(self.now_secs, picture);
        }
        let of = |cell: &Rect| [cell.x, cell.y, cell.width, cell.height];
        stage.cells = staged.viewports.iter().flat_map(of).collect();
        Ok(())
    }
}

// The music room: it shows a concert, and passes on what a person does. All that dances is in the module.
import { Concert, needs_of_text, samples } from "./chladni_web.js";
import * as listening from "./listening.js";
import * as player from "./player.js";
import { Sound } from "./sound.js";
import * as shows from "./shows.js";
import * as songs from "./songs.js";
import { ask, giveUp, obsolete, works } from "./work.js";
import * as sounding from "./sounding.js";
import { keepAwake } from "./awake.js";
import { drawCells } from "./cells.js";
import * as curves from "./curves.js";
import * as dance from "./dance.js";
import * as gallery from "./gallery.js";
import * as plate from "./front_plate.js";
import * as knobs from "./knobs.js";
import * as looks from "./looks.js";
import { attempt, base, busy, label, of, on, options, report, save, say } from "./page.js";
import * as playlist from "./playlist.js";
import { LONGEST, show as showPicture, takePicture } from "./picture.js";
import * as films from "./room_films.js";
import { sampleHarmonics } from "./harmonics.js";
import * as transport from "./transport.js";
import { Unsaved } from "./unsaved.js";

/** Harmonics of a dropped mesh: fewer where the page would have to wait for minutes. */
const harmonicsOf = (bytes) => (bytes < 4e6 ? 128 : 64);
/** The plate at night, so that words can be read over it. */
const FRONT = JSON.stringify({ material: "dark", lights: "studio", background: "night" });
/** The gallery on a screen of this width. */
const gallerySize = () => (innerWidth < 700 ? 6 : 12);

const sound = new Sound();
/** Songs that this concert has heard, by their numbers. */
const heard = [];
/** The curves of the dance on stage are shown. */
let drawing = false;
let concert;
let state;
/** What the controls show by now. */
let shown;
/** The concert of the front, and that of the room while the front shows its own, with the songs that it has heard. */
let atFront;
let parked;
/** Where the room was left: the dance's clock, and the place in the song. Both go on from there. */
let left;
/** How often something else was asked for: what comes for an older wish is not wanted any more. */
let visit = 0;
/** A show that is open on another shape than its own: its text, its needs, and what begins it on a concert. */
let lacks;
/** The room is seen. */
const isHere = () => document.body.dataset.view === "music";
Object.assign(report, { position: () => sound.position(), sound });

/** What the viewer's hands turn. */
export const viewer = () => concert;
export const view = () => JSON.parse(concert.state()).viewpoint;

// ---- bodies and songs

async function bodyOf(name) {
  // Without a connection, or where that breaks, one that was not kept is solved here.
  const fetched = async () => {
    const answer = await fetch(`bodies/${name.slice(7)}.body`);
    return answer.ok ? new Uint8Array(await answer.arrayBuffer()) : undefined;
  };
  const baked = name.startsWith("sample:") ? await fetched().catch(() => undefined) : undefined;
  if (baked) {
    say("");
    return baked;
  }
  return (await busy(label(name), (tell) => ask({ work: "prepare", name, harmonics: sampleHarmonics(label(name)) }, tell))).body;
}

/** Another shape has dances of its own, at the knobs of the concert before, and in a look that was chosen; that of the front
 * is the plate's. Gives the songs that it has heard. */
function goOnAs(next) {
  if (concert) next.go_on_from(concert, FRONT);
  return [];
}

/** Lets a body dance. `begin(concert)` gives the songs that the new concert has heard; where it throws, the one before stays. */
function show(body, begin = goOnAs) {
  const before = concert;
  const next = new Concert(body, gallerySize(), Math.floor(Math.random() * 2 ** 31));
  let songsHeard;
  try { songsHeard = begin(next); } catch (error) { next.free(); throw error; }
  concert = next;
  // A show that waits for a song went with the one before.
  shows.endWait();
  before?.free();
  atFront = undefined;
  allKept();
  // A concert that has heard nothing yet: its first song is the one that plays.
  heard.splice(0, heard.length, ...songsHeard);
  rest(false);
  hear();
  refresh();
}

/** Until a shape dances, what needs one rests. */
function rest(isSo) {
  const parts = [of("sounding"), ...of("breed").parentElement.children, ...of("drawer").children];
  for (const part of parts) part.inert = isSo && !part.matches("#open, #more") && !part.querySelector("#shape, #song-list");
}

/** Tells the concert what is heard: a microphone, or the song that plays. */
function hear() {
  if (!concert) return;
  if (listening.microphone()) concert.listen(listening.microphone().rate);
  const song = songs.current();
  if (!song) return;
  sound.number = heard.indexOf(song);
  // A show that was opened may know a song by its name alone.
  if (sound.number < 0) sound.number = heard.findIndex((other) => !other.file && other.name === song.name);
  if (sound.number < 0) sound.number = heard.length;
  heard[sound.number] = song;
  const { rate_hz, left, right, beats, loud } = song.sound;
  concert.know_song(sound.number, song.name, rate_hz, left, right, beats, loud);
  if (song.reading) concert.read_beats_as(sound.number, song.reading);
  else song.reading = concert.reading(sound.number);
}

let unsaved = new Unsaved();

function allKept() {
  unsaved = new Unsaved();
}

/** Whether dances would be lost. */
export const isUnsaved = () => (atFront ? parked?.unsaved.edits ?? 0 : unsaved.edits) > 0;

const STAYED = "The shape has stayed: Save show keeps its dances.";

/** Whether another shape may dance, or a show be opened, without what was bred here. */
function mayReplace(what = "Let another shape dance", stayed = STAYED) {
  if (!isUnsaved() || confirm(`The dances that were bred here are not saved. ${what} without them?`)) return true;
  say(stayed);
  refresh();
  return false;
}

/** The mesh that is being prepared, by its name. */
let coming;
/** Those who wait until the room is entered. */
const waiting = [];
const entered = () => (isHere() ? undefined : new Promise((done) => { waiting.push(done); }));

/** Another shape that was asked for is not wanted any more; gives the number of this wish. */
function overtake() {
  coming = undefined;
  if (works("work")) giveUp(obsolete(), ["work"]);
  return ++visit;
}

/** Gives whether it dances: not where something else was asked for meanwhile. */
async function danceOn(name, begin) {
  const mine = overtake();
  const before = unsaved.edits;
  say(`${label(name)}…`);
  const body = await bodyOf(name);
  if (mine !== visit) return false;
  // It was not asked about what was bred meanwhile.
  if (unsaved.edits !== before && !mayReplace()) return false;
  show(body, begin);
  lacks = undefined;
  return true;
}

export async function openMesh(name, bytes) {
  if (!mayReplace()) return;
  overtake();
  const before = unsaved.edits;
  const mine = coming = { name };
  const harmonics = harmonicsOf(bytes.length);
  const found = await busy(name, async (tell) => {
    const { body, secs } = await ask({ work: "prepare", name, bytes, harmonics }, tell);
    if (coming !== mine) return undefined;
    if (!isHere()) tell("said", `${name} is ready, and dances once the music room is entered.`);
    else for (const text of danceOnMesh(name, body, secs, before).toReversed()) tell("said", text);
    return { body, secs };
  });
  if (!found || coming !== mine) return;
  await entered();
  if (coming === mine) say(danceOnMesh(name, found.body, found.secs, before).join(" "), false, 20);
}

/** Lets a mesh dance that is ready, where its user may lose what was bred since there were `before` edits; gives what is said of it. */
function danceOnMesh(name, body, secs, before) {
  coming = undefined;
  if (unsaved.edits !== before && !mayReplace()) return [STAYED];
  // The show that was danced by this mesh begins anew on it.
  const opens = lacks?.needs.body === name ? lacks : undefined;
  show(body, opens?.begin);
  lacks = undefined;
  if (opens) shows.know(opens.text, opens.needs);
  refresh();
  report.solveSecs = secs;
  const news = `${name}: ${concert.vertices()} vertices, ${concert.harmonics()} harmonics in ${secs.toFixed(1)} s.`;
  return opens ? [news, isOpen(opens.name, opens.needs)] : [news];
}

// ---- songs and shows

export { openSongs } from "./player.js";

export async function openText(name, bytes) {
  // The octopus may still be on its way.
  if (!concert) await open();
  const text = new TextDecoder().decode(bytes);
  const needs = JSON.parse(needs_of_text(text));
  if (needs.preset) return takeDance(name, text, needs.caution);
  // What a page is given has no folders.
  needs.songs = needs.songs.map(base);
  needs.body &&= base(needs.body);
  if (!mayReplace("Open the show", "The show is not open: Save show keeps the dances that are here.")) return;
  const begin = (dancing) => {
    needs.others = dancing.open_show(text);
    return songs.findForShow(needs.songs).map((song, i) => song ?? { name: needs.songs[i] });
  };
  if (needs.body?.startsWith("sample:") && needs.body !== state.body) {
    if (!await danceOn(needs.body, begin)) return;
  } else {
    // Its own mesh may come.
    if (!coming || coming.name !== needs.body) overtake();
    heard.splice(0, heard.length, ...begin(concert));
    shows.endWait();
    allKept();
    hear();
  }
  shows.know(text, needs);
  refresh();
  lacks = needs.body && needs.body !== state.body ? { name, text, needs, begin } : undefined;
  say(isOpen(name, needs), false, needs.caution || needs.others ? 20 : 8);
}

/** Takes the text of a dance into the gallery. */
function takeDance(name, text, caution) {
  // The autopilot's dances go with it.
  if (state.piloted) {
    concert.autopilot(false);
    refresh();
  }
  // The place that the window takes, too.
  const free = state.dances.findLastIndex(({ chosen, locked, favorite }) => !chosen && !locked && !favorite);
  const place = free < 0 ? state.dances.findLastIndex(({ locked }) => !locked) : free;
  if (place < 0) return say(`${name}: all dances are locked. Unlock one first.`, true);
  concert.open_preset(place, text);
  refresh();
  say([`${name}: this dance is in the gallery now.`, caution].filter(Boolean).join(" "), false, caution ? 20 : 8);
}

/** The news that a show is open, and what it still lacks. */
const isOpen = (name, needs) => (
  lacks ? `${name} was danced by ${needs.body}: drop that mesh, too.` : shows.isOpen(name, needs, state.looks));

/** Plays the show that was opened, or leaves it to the user. */
async function playShow() {
  if (concert.plays_show()) return endShow();
  if (!mayReplace("Play the show", "The show is not played: Save show keeps the dances that are here.")) return;
  await listening.stop();
  const cast = shows.begin(concert);
  // What was asked for earlier does not come into it.
  overtake();
  player.passOver();
  heard.splice(0, heard.length, ...cast);
  allKept();
  // Until its first song is heard there is none.
  sound.number = -1;
  refresh();
}

/** What a show plays is the user's own from now on. */
function endShow() {
  shows.endWait();
  if (!concert?.plays_show()) return;
  concert.stop_show();
  refresh();
}

/** Lets a song be heard as a show wants it. */
async function hearSong(song, secs, playing) {
  if (!song) {
    // Not even the one that played before: the concert knows none.
    sound.number = -1;
    return sound.pause();
  }
  if (song !== songs.current() || !song.sound) {
    const mine = visit;
    const decoded = await songs.soundOf(song);
    // The room was left meanwhile, or the show has ended.
    if (mine !== visit || !concert?.plays_show()) return;
    songs.play(song, decoded);
    sound.load(decoded, false);
  }
  sound.repeats = false;
  hear();
  sound.seek(secs);
  if (playing) await playAloud(); else sound.pause();
  refresh();
}

const followShow = attempt(() => shows.follow(concert, heard, hearSong));

// ---- the picture

/** The plate of the front, which is to stand still. */
function stands(now, width, height) {
  const at = { clock: shows.clockSecs(now), position: sound.position(), isKnown: sound.duration > 0 };
  const frame = (clock, position, w, h) => concert.frame(clock, sound.number, position, sound.duration, w, h);
  const goOn = (clock, position) => concert.go_on(clock, sound.number, position, sound.duration);
  return plate.drawStill(now, at, width, height, { frame, goOn });
}

/** The plate is to stand still from now on, or to go on where it stood. */
function holdStill() {
  if (!concert || concert !== atFront) return;
  const stood = plate.letGo();
  if (plate.isStill()) return sound.pause();
  if (stood) {
    goOnFrom(stood);
    sound.seek(stood.position);
  }
  sound.playing = true;
}

/** The clock goes on from where the plate stood, which sand may have brought ahead of it. */
const goOnFrom = (stood) => shows.skip(shows.clockSecs(performance.now()) - stood.clock);

const room = {
  name: "A shape that moves with the sound.",
  frame: (now, width, height) => {
    if (!concert) return false;
    const filmed = films.moment();
    if (filmed) return concert.frame(filmed.clock, sound.number, filmed.position, sound.duration, width, height);
    if (concert === atFront && plate.isStill()) return stands(now, width, height);
    if (concert.plays_show() && isHere()) followShow();
    return !shows.isWaiting() && concert.frame(shows.clockSecs(now), sound.number, sound.position(), sound.duration, width, height);
  },
  pixels: () => concert.pixels(),
  judge: (rgba, width, height) => concert.judge(rgba, width, height),
  byProcessor: () => {
    concert?.draw_by_processor();
    parked?.concert.draw_by_processor();
    // Its picture went with the card.
    plate.again();
  },
  drawn: (width, height) => {
    sounding.show(concert);
    if ((state.played && toShow() !== shown) || isAnotherOnStage()) refresh();
    drawCells(of("cells"), state.on_stage ? [] : concert.cells(), state.dances, width, height, gallery.choices);
    films.tick();
    keepAwake(isHere() && (sound.isHeard || !!listening.microphone()));
    if (listening.microphone()) of("loudness").value = Math.sqrt(listening.microphone().loudest);
    transport.showPlace();
  },
};

// ---- controls

const act = attempt((action) => {
  concert.act(JSON.stringify(action));
  unsaved.did(action.do);
  refresh();
});
/** The dance that is saved: the one on stage, else the first that is chosen. */
const theDance = () => concert.staged() ?? Math.max(0, state.dances.findIndex((dance) => dance.chosen));
/** t and a of a dance of the gallery. */
const curvesOf = (item) => [concert.transfer(item), concert.amplification(item)];
/** The dance on stage of which controls were shown last. */
let staged;
/** Whether beats, or the autopilot, have brought another one; not while a hand is on what belongs to that. */
function isAnotherOnStage() {
  const now = concert.staged();
  if (now === staged || dance.isHeld() || curves.isHeld()) return false;
  staged = now;
  return true;
}

/** Gives all dances up for others, where their user may. */
const newGallery = attempt((size, isOther) => {
  if (unsaved.inGallery() && !confirm("The dances that were bred here are not saved. Begin anew without them?")) return refresh();
  concert.new_gallery(size, isOther);
  refresh();
  unsaved.begunAnew(state.favorites > 0);
});

/** Sand is of the stage: it goes with it. */
function settle() {
  refresh();
  if (state.sand && !state.piloted) concert.sand(false);
  refresh();
}

/** What the controls of a show that is played follow: its state, and whether its song is heard. */
const toShow = () => concert.state() + sound.isHeard;

function refresh() {
  if (!concert) return;
  const text = concert.state();
  shown = text + sound.isHeard;
  state = report.state = JSON.parse(text);
  gallery.show(state);
  knobs.show(state);
  dance.show(state.dances.length ? theDance() : undefined, state);
  of("sweep").disabled = !state.sand;
  playlist.show();
  of("back").disabled = !state.on_stage;
  const item = concert.staged();
  const isDrawn = drawing && item !== undefined;
  of("draw").disabled = item === undefined;
  of("draw").setAttribute("aria-pressed", isDrawn);
  const [transfer, amplification] = isDrawn ? curvesOf(item) : [];
  curves.show(isDrawn ? { item, transfer, amplification } : undefined);
  of("pilot").setAttribute("aria-pressed", state.piloted);
  of("sand").setAttribute("aria-pressed", state.sand);
  // The plate at the front does not end a show that the room has left.
  if (isHere() && shows.draw(state.played)) {
    say("The show is over, and yours from here on.");
    // The show had turned repeating off: what was chosen holds again.
    sound.setRepeats(player.isRepeated());
    // In place of live sound no song was known.
    if (sound.number < 0) hear();
  }
  const isLive = !!listening.microphone();
  films.show(isLive || state.played);
  of("listen").setAttribute("aria-pressed", isLive);
  of("heard").hidden = of("tap-beat").hidden = !isLive;
  transport.show(isLive);
  of("stance-up").value = state.up;
  looks.show(state.looks, state.has_own_colors, state.effects);
  of("gain").value = state.settings.knobs?.gain ?? 1;
  const option = [...of("shape").options].find((option) => option.value === state.body);
  of("shape").value = option ? state.body : "";
  of("shape").querySelector("[value='']").textContent = option ? "Other…" : state.body;
}

/** Lets the song be heard from here on. Without one the tune is fetched: it may have been cancelled, or lost with its worker. */
async function playAloud() {
  if (!(await sound.play())) say("No sound device answers: the song runs on silently.", true);
  if (songs.current() || works("song")) return;
  await know(busy("Our own tune", (tell) => songs.decode({ name: songs.TUNE }, tell)));
}

/** Goes in: what danced there goes on, or the octopus dances. */
export async function enter() {
  // It is parked once the plate is there.
  const goesOn = !!parked || (!!concert && concert !== atFront);
  goIn();
  await Promise.all([playAloud().then(refresh), goesOn || danceOn("sample:octopus")]);
}

/** Goes in with what is there, for a file that was brought; where nothing dances yet, the octopus does. */
export async function open() {
  goIn();
  if (!concert) await danceOn("sample:octopus");
}

function goIn() {
  visit++;
  showPicture(room);
  unpark();
  for (const goOn of waiting.splice(0)) goOn();
}

export function leave() {
  attempt(films.endFilm)();
  sound.pause();
  listening.stop();
  keepAwake(false);
  // The song for which it waits would be missing when the room is entered again.
  if (shows.isWaiting()) endShow();
  if (concert && concert !== atFront) left ??= { clock: shows.clockSecs(performance.now()), position: sound.position() };
  player.passOver();
  visit++;
}

/** Leaves the front's concert, if the room had one before; else that is the room's from now on, and in its middle. */
function unpark() {
  if (parked) {
    concert?.free();
    ({ concert, unsaved } = parked);
    heard.splice(0, heard.length, ...parked.heard);
    parked = undefined;
    hear();
    refresh();
  } else if (concert && concert === atFront) concert.fit();
  atFront = undefined;
  const stood = plate.letGo();
  if (left) sound.seek(left.position);
  const from = left ?? stood;
  if (from) goOnFrom(from);
  if (stood) sound.playing = true;
  left = undefined;
}

/** How far the plate of the front is shifted, in heights of the picture. */
let shifted;

/** Puts the plate beside the words, or above them. */
function placeFront() {
  const [x, y] = innerWidth > 900 ? [0.24, -0.04] : innerWidth > innerHeight ? [0.62, 0] : [0, -0.16];
  concert.shift(x - shifted[0], y - shifted[1]);
  shifted = [x, y];
}

/** The plate with sand on it, which moves as soon as the tune is there. */
export async function front() {
  const mine = ++visit;
  showPicture(room);
  plate.letGo();
  sound.playing = !plate.isStill();
  const body = await bodyOf("sample:plate");
  if (mine !== visit) return;
  if (concert && concert !== atFront) {
    // What was bred in the room is there again when it is entered.
    parked = { concert, heard: [...heard], unsaved };
    concert = undefined;
  }
  show(body, () => []);
  atFront = concert;
  concert.set_look(FRONT);
  concert.zoom(-1);
  shifted = [0, 0];
  placeFront();
  concert.sand(true);
  refresh();
}

/** The tune, which runs silently until somebody asks for sound. */
export async function know(tune) {
  const decoded = await tune;
  // A song that was brought earlier plays on.
  if (songs.current()) return;
  sound.load(songs.begin(decoded).sound, true);
  hear();
  // Sound was asked for before there was any.
  if (isHere() && sound.playing && sound.context) {
    await playAloud();
    refresh();
  }
}

export function listen() {
  rest(true);
  of("shape").append(...options(JSON.parse(samples()).map(([name]) => name), (name) => `sample:${name}`), new Option("Other…", ""));
  looks.listen((shown) => { concert.set_look(JSON.stringify(shown)); refresh(); }, () => state.looks);
  knobs.listen(act, (name) => { concert.set_timbre(name); refresh(); });
  dance.listen(act, gallery.choices);
  const shared = { sound, concert: () => concert, endShow, hear, playAloud, refresh };
  player.listen(shared);
  transport.listen({ ...shared, isHere });
  sounding.listen(shared);
  // Nothing is to be heard where the room was left, and a film has its song.
  listening.listen({ ...shared, mayListen: () => isHere() && !films.isFilmed(), passOver: player.passOver });
  gallery.listen({ act, breed: () => { concert.breed(); unsaved.did("breed"); refresh(); }, begin: newGallery, curves: curvesOf });
  plate.listen(holdStill);
  addEventListener("resize", () => { if (concert && concert === atFront) placeFront(); });
  curves.listen(act, (item, name) => { concert.begin_curve(item, name); unsaved.did("set-transfer"); refresh(); });
  films.listen({ ...shared, microphone: listening.microphone, forget: () => { overtake(); player.passOver(); } });
  on("draw", () => { drawing = !drawing; refresh(); });
  on("sweep", () => act({ do: "sweep" }));
  of("stance-up").addEventListener("change", () => { concert.stand(of("stance-up").value); refresh(); });
  on("turn-front", () => { concert.turn_front(); refresh(); });
  on("more", () => {
    const isOpen = !document.body.toggleAttribute("data-drawer");
    of("drawer").hidden = isOpen;
    of("more").setAttribute("aria-expanded", !isOpen);
  });
  on("back", () => {
    if (!state.piloted && !state.sand) return act({ do: "leave-stage" });
    if (state.piloted) concert.autopilot(false);
    return settle();
  });
  on("pilot", () => { concert.autopilot(!state.piloted); settle(); });
  on("sand", () => { concert.sand(!state.sand); refresh(); });
  on("save-show", () => { save("chladni-show.toml", concert.save_show()); allKept(); });
  on("save-preset", () => save("chladni-dance.toml", concert.save_preset(theDance())));
  on("play-show", playShow);
  on("save-picture", async () => save("chladni.png", await takePicture(LONGEST)));
  of("gain").addEventListener("input", () => act({ do: "set", parameter: "gain", value: Number(of("gain").value) }));
  of("shape").addEventListener("change", attempt(() => {
    const name = of("shape").value;
    if (name && mayReplace()) {
      const dances = danceOn(name);
      const mine = visit;
      // Where it does not come, the shape is the one that is there.
      return dances.finally(() => { if (mine === visit) refresh(); });
    }
    // Until a file has been chosen, too.
    refresh();
    return name ? undefined : of("file").click();
  }));
}

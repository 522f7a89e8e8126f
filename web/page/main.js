// The page: it shows a concert, and passes on what a person does. All that dances is in the module.
import init, { Concert, kind, looks, needs_of_show, samples } from "./chladni_web.js";
import { Sound } from "./sound.js";
import { ask, giveUp } from "./work.js";
import { drawCells } from "./cells.js";
import { hands } from "./hands.js";

const of = (id) => document.getElementById(id);
const picture = of("picture");
const brush = picture.getContext("2d", { alpha: false });

/** Harmonics of a dropped mesh: fewer where the page would have to wait for minutes. */
const harmonicsOf = (bytes) => (bytes < 4e6 ? 128 : 64);
/** The plate at night, so that words can be read over it. */
const FRONT = JSON.stringify({ material: "dark", lights: "studio", background: "night" });
/** The gallery on a screen of this width. */
const gallerySize = () => (innerWidth < 700 ? 6 : 12);
/** A picture may take so long, in milliseconds; else it gets fewer pixels. */
const [SLOWEST, FASTEST] = [40, 22];
/** Fewer pixels than this share of those of the page look like fog. */
const COARSEST = 0.55;

const sound = new Sound();
const songs = [];
let memory;
let concert;
let state;
let detail = Math.min(devicePixelRatio, 1.5);
/** What tests and benchmarks read. */
const report = (window.chladni = { frames: 0, drawMs: 0, detail, position: () => sound.position(), sound, view: () => JSON.parse(concert.state()).viewpoint });

// ---- what is said

let saying;
function say(text, bad = false, secs = 8) {
  of("status").textContent = text;
  of("status").classList.toggle("bad", bad);
  clearTimeout(saying);
  if (text) saying = setTimeout(() => say(""), 1000 * (bad ? 20 : secs));
}
const told_by = (what) => (kindOf, text) => say(kindOf === "warning" ? text : `${what}: ${text}…`, false, 600);
const attempt = (act) => async (...args) => {
  try { await act(...args); } catch (error) { say(error.message ?? String(error), true); }
};
const busy = (on) => { of("cancel").hidden = !on; };

// ---- bodies and songs

async function bodyOf(name) {
  const baked = name.startsWith("sample:") && (await fetch(`bodies/${name.slice(7)}.body`));
  if (baked?.ok) return new Uint8Array(await baked.arrayBuffer());
  return (await ask({ work: "prepare", name, harmonics: 96 }, told_by(name))).body;
}

function show(body) {
  const before = concert;
  concert = new Concert(body, gallerySize(), Math.floor(Math.random() * 2 ** 31));
  before?.free();
  // A new concert has heard nothing yet: its first song is the one that plays.
  songs.splice(0, songs.length - 1);
  if (songs.length) songs[0].number = sound.number = 0;
  hear();
  refresh();
}

/** Tells the concert of the song that plays. */
function hear() {
  const song = songs.at(-1);
  if (song) concert.know_song(song.number, song.name, song.rate, song.left, song.right, song.beats);
}

async function dance(name) {
  say(`${name.replace("sample:", "")}…`);
  show(await bodyOf(name));
  say("");
}

async function openMesh(name, bytes) {
  busy(true);
  const harmonics = harmonicsOf(bytes.length);
  try {
    const { body, secs } = await ask({ work: "prepare", name, bytes, harmonics }, told_by(name));
    show(body);
    report.solveSecs = secs;
    say(`${name}: ${concert.vertices()} vertices, ${concert.harmonics()} harmonics in ${secs.toFixed(1)} s`);
  } finally { busy(false); }
}

async function openSong(name, bytes) {
  busy(true);
  try {
    const song = await ask({ work: "decode", name, bytes }, told_by(name));
    const aloud = sound.isHeard;
    const number = songs.length;
    songs.push({ number, name, rate: song.rate_hz, left: song.left, right: song.right, beats: song.beats });
    // Samples of songs before are not heard again.
    songs.slice(0, -1).forEach((old) => { old.left = old.right = new Float32Array(); });
    sound.load(number, song.rate_hz, song.left, song.right);
    if (concert) hear();
    of("song").textContent = name;
    if (bytes || aloud) await sound.play();
    say("");
  } finally { busy(false); refresh(); }
}

async function openText(name, bytes) {
  const text = new TextDecoder().decode(bytes);
  let needs;
  try { needs = JSON.parse(needs_of_show(text)); } catch {
    concert.open_preset(Math.max(0, state.dances.findIndex((dance) => !dance.chosen)), text);
    refresh();
    return say(`${name}: this dance is in the gallery now.`);
  }
  if (needs.body?.startsWith("sample:") && needs.body !== state.body) await dance(needs.body);
  concert.open_show(text);
  refresh();
  const missing = needs.songs.filter((song) => !songs.some((known) => known.name === song));
  if (needs.body && needs.body !== state.body) say(`${name} was danced by ${needs.body}: drop that mesh, then the show again.`);
  else say(missing.length ? `${name} is open. It was danced to ${missing.join(", ")}: drop that song, too.` : needs.caution ?? `${name} is open.`);
}

const openers = { mesh: openMesh, song: openSong, text: openText };
const open = attempt(async (files) => {
  enter();
  for (const file of files) {
    const opener = openers[kind(file.name)];
    if (!opener) throw new Error(`${file.name}: the page opens meshes, songs, shows and dances.`);
    await opener(file.name, new Uint8Array(await file.arrayBuffer()));
  }
});

function save(name, content, type = "text/plain") {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  say(`${name} is among your downloads.`);
}

// ---- the picture

function draw(now) {
  requestAnimationFrame(draw);
  if (!concert) return;
  const [width, height] = [picture.clientWidth, picture.clientHeight].map((side) => Math.max(16, Math.round(side * detail)));
  const began = performance.now();
  let drawn = false;
  try {
    drawn = concert.frame(now / 1000, sound.number, sound.position(), sound.duration, width, height);
  } catch (error) { say(error.message ?? String(error), true); }
  if (!drawn) return;
  if (picture.width !== width || picture.height !== height) [picture.width, picture.height] = [width, height];
  const pixels = new Uint8ClampedArray(memory.buffer, concert.pixels(), 4 * width * height);
  brush.putImageData(new ImageData(pixels, width, height), 0, 0);
  const took = performance.now() - began;
  report.drawMs = report.drawMs ? 0.9 * report.drawMs + 0.1 * took : took;
  if (report.frames++ === 0) report.firstPictureMs = performance.now();
  suit();
  drawCells(of("cells"), concert.cells(), state, width, height, choices);
  if (!of("seek").matches(":active")) of("seek").value = sound.duration ? sound.position() / sound.duration : 0;
}

/** As many pixels as this machine draws in time. */
let sinceChange = 0;
function suit() {
  if (++sinceChange < 12) return;
  const finest = Math.min(devicePixelRatio, 1.5);
  if (report.drawMs > SLOWEST && detail > COARSEST) detail = Math.max(COARSEST, detail * 0.85);
  else if (report.drawMs < FASTEST && detail < finest) detail = Math.min(finest, detail * 1.1);
  else return;
  report.detail = detail;
  sinceChange = 0;
}

// ---- controls

const act = attempt((action) => { concert.act(JSON.stringify(action)); refresh(); });
const choices = {
  choose: (item) => act({ do: "choose", item, on: !state.dances[item].chosen }),
  perform: (item) => act({ do: "perform", item }),
};

function refresh() {
  if (!concert) return;
  state = report.state = JSON.parse(concert.state());
  const chosen = state.dances.filter((dance) => dance.chosen).length;
  of("breed").textContent = chosen > 1 ? `Breed ${chosen}` : "Breed";
  of("breed").disabled = chosen < 2 || state.on_stage;
  of("breed").title = chosen < 2 ? "Choose two dances or more that you love" : "Their children take the place of all";
  of("back").disabled = !state.on_stage;
  of("pilot").setAttribute("aria-pressed", state.piloted);
  of("sand").setAttribute("aria-pressed", state.sand);
  of("play").setAttribute("aria-pressed", sound.isHeard);
  of("play").textContent = sound.isHeard ? "Pause" : "Play";
  of("look").value = state.look;
  of("gain").value = state.settings.knobs?.gain ?? 1;
  const option = [...of("shape").options].find((option) => option.value === state.body);
  of("shape").value = option ? state.body : "";
  of("shape").querySelector("[value='']").textContent = option ? "Other…" : state.body;
}

function enter() { if (document.body.dataset.view === "front") document.body.dataset.view = "room"; }
const options = (names, value) => names.map((name) => new Option(name[0].toUpperCase() + name.slice(1), value(name)));

function listen() {
  const on = (id, act) => of(id).addEventListener("click", attempt(act));
  on("enter", async () => { enter(); await sound.play(); refresh(); await dance("sample:octopus"); });
  on("bring", () => of("file").click());
  on("open", () => of("file").click());
  on("home", async () => { document.body.dataset.view = "front"; sound.pause(); sound.playing = true; await front(); });
  on("cancel", () => giveUp());
  on("full", async () => {
    if (document.fullscreenElement) return document.exitFullscreen();
    await document.documentElement.requestFullscreen();
    document.body.dataset.view = "bare";
  });
  on("play", async () => { if (sound.isHeard) sound.pause(); else await sound.play(); refresh(); });
  on("breed", () => act({ do: "breed" }));
  on("back", () => { if (state.piloted) concert.autopilot(false); else if (state.sand) concert.sand(false); else act({ do: "leave-stage" }); refresh(); });
  on("pilot", () => { concert.autopilot(!state.piloted); refresh(); });
  on("sand", () => { concert.sand(!state.sand); refresh(); });
  on("save-show", () => save("chladni-show.toml", concert.save_show()));
  on("save-preset", () => save("chladni-dance.toml", concert.save_preset(Math.max(0, state.dances.findIndex((dance) => dance.chosen)))));
  on("save-picture", () => picture.toBlob((png) => save("chladni.png", png), "image/png"));
  of("seek").addEventListener("input", () => sound.seek(of("seek").value * sound.duration));
  of("gain").addEventListener("input", () => act({ do: "set", parameter: "gain", value: Number(of("gain").value) }));
  of("look").addEventListener("change", () => { concert.set_look(JSON.stringify({ look: of("look").value })); refresh(); });
  of("shape").addEventListener("change", attempt(() => (of("shape").value ? dance(of("shape").value) : of("file").click())));
  of("file").addEventListener("change", () => { open([...of("file").files]); of("file").value = ""; });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => { event.preventDefault(); open([...event.dataTransfer.files]); });
  document.addEventListener("fullscreenchange", () => { if (!document.fullscreenElement) document.body.dataset.view = "room"; });
  hands([picture, of("cells")], () => concert);
}

/** The plate with sand on it, which moves as soon as the tune is there. */
async function front() {
  show(await bodyOf("sample:plate"));
  concert.set_look(FRONT);
  concert.zoom(-1);
  // Beside the words, or above them.
  if (innerWidth > 900) concert.shift(0.24, -0.04);
  else concert.shift(0, -0.16);
  concert.sand(true);
  refresh();
}

const start = attempt(async () => {
  const tune = ask({ work: "decode", name: "sample:tune" });
  tune.catch(() => {});
  memory = (await init()).memory;
  of("shape").append(...options(JSON.parse(samples()).map(([name]) => name), (name) => `sample:${name}`), new Option("Other…", ""));
  of("look").append(...options(JSON.parse(looks()), (name) => name));
  listen();
  requestAnimationFrame(draw);
  await front();
  const { left, right, rate_hz, beats } = await tune;
  songs.push({ number: 0, name: "sample:tune", rate: rate_hz, left, right, beats });
  sound.load(0, rate_hz, left, right);
  hear();
});
start();

// The music room: it shows a concert, and passes on what a person does. All that dances is in the module.
import { Concert, looks, needs_of_show, samples } from "./chladni_web.js";
import { Sound } from "./sound.js";
import { ask } from "./work.js";
import { drawCells } from "./cells.js";
import { attempt, busy, label, of, on, options, report, save, say } from "./page.js";
import { nextPicture, show as showPicture } from "./picture.js";

/** Harmonics of a dropped mesh: fewer where the page would have to wait for minutes. */
const harmonicsOf = (bytes) => (bytes < 4e6 ? 128 : 64);
/** The plate at night, so that words can be read over it. */
const FRONT = JSON.stringify({ material: "dark", lights: "studio", background: "night" });
/** The gallery on a screen of this width. */
const gallerySize = () => (innerWidth < 700 ? 6 : 12);

const sound = new Sound();
const songs = [];
let concert;
let state;
Object.assign(report, { position: () => sound.position(), sound });

/** What the viewer's hands turn. */
export const viewer = () => concert;
export const view = () => JSON.parse(concert.state()).viewpoint;

// ---- bodies and songs

async function bodyOf(name) {
  const baked = name.startsWith("sample:") && (await fetch(`bodies/${name.slice(7)}.body`));
  if (baked?.ok) return new Uint8Array(await baked.arrayBuffer());
  return (await busy(label(name), (tell) => ask({ work: "prepare", name, harmonics: 96 }, tell))).body;
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
  say(`${label(name)}…`);
  show(await bodyOf(name));
  say("");
}

export async function openMesh(name, bytes) {
  const harmonics = harmonicsOf(bytes.length);
  const { body, secs } = await busy(name, (tell) => ask({ work: "prepare", name, bytes, harmonics }, tell));
  show(body);
  report.solveSecs = secs;
  say(`${name}: ${concert.vertices()} vertices, ${concert.harmonics()} harmonics in ${secs.toFixed(1)} s`);
}

export async function openSong(name, bytes) {
  try {
    const song = await busy(name, (tell) => ask({ work: "decode", name, bytes }, tell));
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
  } finally { refresh(); }
}

export async function openText(name, bytes) {
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

// ---- the picture

const room = {
  name: "A shape that moves with the sound.",
  frame: (now, width, height) => !!concert && concert.frame(now / 1000, sound.number, sound.position(), sound.duration, width, height),
  pixels: () => concert.pixels(),
  judge: (rgba, width, height) => concert.judge(rgba, width, height),
  byProcessor: () => concert?.draw_by_processor(),
  drawn: (width, height) => {
    drawCells(of("cells"), concert.cells(), state, width, height, choices);
    if (!of("seek").matches(":active")) of("seek").value = sound.duration ? sound.position() / sound.duration : 0;
  },
};

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

/** Goes in: the octopus dances. */
export async function enter() {
  showPicture(room);
  await sound.play();
  refresh();
  await dance("sample:octopus");
}

/** Goes in with what is there, for a file that was brought. */
export const open = () => showPicture(room);

export const leave = () => sound.pause();

/** The plate with sand on it, which moves as soon as the tune is there. */
export async function front() {
  showPicture(room);
  sound.playing = true;
  show(await bodyOf("sample:plate"));
  concert.set_look(FRONT);
  concert.zoom(-1);
  // Beside the words, or above them.
  if (innerWidth > 900) concert.shift(0.24, -0.04);
  else if (innerWidth > innerHeight) concert.shift(0.62, 0);
  else concert.shift(0, -0.16);
  concert.sand(true);
  refresh();
}

/** The tune, which runs silently until somebody asks for sound. */
export async function know(tune) {
  const { left, right, rate_hz, beats } = await tune;
  songs.push({ number: 0, name: "sample:tune", rate: rate_hz, left, right, beats });
  sound.load(0, rate_hz, left, right);
  hear();
}

export function listen() {
  of("shape").append(...options(JSON.parse(samples()).map(([name]) => name), (name) => `sample:${name}`), new Option("Other…", ""));
  of("look").append(...options(JSON.parse(looks()), (name) => name));
  on("play", async () => { if (sound.isHeard) sound.pause(); else await sound.play(); refresh(); });
  on("breed", () => act({ do: "breed" }));
  on("back", () => { if (state.piloted) concert.autopilot(false); else if (state.sand) concert.sand(false); else act({ do: "leave-stage" }); refresh(); });
  on("pilot", () => { concert.autopilot(!state.piloted); refresh(); });
  on("sand", () => { concert.sand(!state.sand); refresh(); });
  on("save-show", () => save("chladni-show.toml", concert.save_show()));
  on("save-preset", () => save("chladni-dance.toml", concert.save_preset(Math.max(0, state.dances.findIndex((dance) => dance.chosen)))));
  on("save-picture", async () => save("chladni.png", await nextPicture()));
  of("seek").addEventListener("input", () => sound.seek(of("seek").value * sound.duration));
  of("gain").addEventListener("input", () => act({ do: "set", parameter: "gain", value: Number(of("gain").value) }));
  of("look").addEventListener("change", () => { concert.set_look(JSON.stringify({ look: of("look").value })); refresh(); });
  of("shape").addEventListener("change", attempt(() => (of("shape").value ? dance(of("shape").value) : of("file").click())));
}

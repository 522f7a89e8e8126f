// A film of the song that waits for each picture: what is on stage, or in the gallery, dances to it as it is now. The
// clock of the dance goes on by one picture after the other, however long each takes.
import { keepAwake } from "./awake.js";
import { EncodedFilm, encodes } from "./encoder.js";
import { attempt, of, on, save, say } from "./page.js";
import { copier, drawOnce, hold } from "./picture.js";

/** Milliseconds after which the page is told how far it is. */
const TELL = 250;

let stage;
/** A film is being made: `cancelled`, or `kept` as far as it is. */
let going;

const wait = () => new Promise((done) => {
  // Timers rest in a page that is not seen.
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = () => { port1.close(); done(); };
  port2.postMessage(undefined);
});

const minutes = (secs) => (secs < 90 ? `${Math.ceil(secs)} s` : `${Math.ceil(secs / 60)} min`);

/** Where it begins in the song, and where it ends. */
function span({ position, duration }) {
  const { value } = of("film-span");
  if (value === "whole") return [0, duration];
  return [position, value === "rest" ? duration : Math.min(duration, position + Number(value))];
}

function tell(n, count, began) {
  of("film-progress").value = n / count;
  const left = ((count - n) * (performance.now() - began)) / 1000 / Math.max(1, n);
  of("film-left").textContent = n < 5 ? `Picture ${n} of ${count}` : `Picture ${n} of ${count}, ${minutes(left)} left`;
}

/** Says why only a part of a film is among the downloads. */
export const endedEarly = (error) => new Error(`The film ended early (${error.message ?? error}). Its part until then is among your downloads.`);

/** Draws and encodes one picture after the other; gives the film, or none where it was given up, whether it is silent, and
 * what `failed` behind its last picture, if anything did. */
async function shoot(mine) {
  const sound = stage.sound();
  const [width, height] = of("film-size").value.split("x").map(Number);
  const rate = Number(of("film-rate").value);
  const [from, to] = span(sound);
  const count = Math.max(1, Math.round((to - from) * rate));
  const film = await EncodedFilm.open(width, height, rate, sound.rate);
  const { canvas, take } = copier(width, height);
  const sample = (n) => Math.min(sound.left.length, Math.round((from + n / rate) * sound.rate));
  const began = performance.now();
  let told = 0;
  try {
    for (let n = 0; n < count && !mine.cancelled && !mine.kept; n++) {
      film.sound(sound.left, sound.right, sample(n), sample(n + 1));
      stage.at(n / rate, from + n / rate);
      drawOnce(width, height, take);
      await film.picture(canvas);
      of("film-keep").disabled = false;
      if (performance.now() - told > TELL) { tell(n + 1, count, began); told = performance.now(); }
      await wait();
    }
    return { film: mine.cancelled ? undefined : await film.end(), isSilent: film.isSilent };
  } catch (error) {
    const failed = film.failed ?? error;
    if (mine.cancelled) throw failed;
    // An encoder may hold pictures back until it is to end; one that has failed has no more to come.
    const part = await film.end().catch(() => (film.hasPictures ? film.file() : undefined));
    if (!part) throw failed;
    return { film: part, isSilent: film.isSilent, failed };
  } finally { film.close(); }
}

async function begin() {
  const mine = going = {};
  show();
  let release;
  try {
    stage.begin();
    release = hold();
    keepAwake(true);
    const { film, isSilent, failed } = await shoot(mine);
    if (film) save("chladni-song.mp4", film);
    else say("The film was given up.");
    if (failed) throw endedEarly(failed);
    if (film && isSilent) say("The film is silent: this browser encodes no sound that a file can hold.", true);
  } finally {
    stage.end();
    release?.();
    keepAwake(false);
    going = undefined;
    show();
    of("whole-film").close();
  }
}

/** Shows what is asked before a film, or how far it is. */
function show() {
  of("whole-film").classList.toggle("going", !!going);
  of("film-asks").hidden = of("film-begin").hidden = !!going;
  of("film-going").hidden = of("film-keep").hidden = !going;
  // It takes the place of the button that begins: the second press of a double click is not to end a film without pictures.
  of("film-keep").disabled = true;
  of("film-progress").value = 0;
  of("film-left").textContent = "";
}

/**
 * `music` has the song that plays, `sound()`, with its samples, its `position` and its `duration`; `begin()` before the
 * first picture, `at(secs, songSecs)` before each, `end()` behind the last.
 */
export function listen(music) {
  stage = music;
  of("film-song").hidden = !encodes();
  on("film-song", () => { show(); of("whole-film").showModal(); });
  on("film-begin", begin);
  on("film-keep", () => { if (going) going.kept = true; });
  on("film-cancel", () => { if (going) going.cancelled = true; else of("whole-film").close(); });
  // The escape key.
  of("whole-film").addEventListener("cancel", attempt((event) => {
    if (!going) return;
    event.preventDefault();
    going.cancelled = true;
  }));
}

// Films of the music room: a live recording of what is seen and heard, and the song for one that waits for its pictures.
import { LiveFilm } from "./film.js";
import { attempt, of, on, save, say } from "./page.js";
import { watch } from "./picture.js";
import * as shows from "./shows.js";
import * as wholeFilm from "./whole_film.js";

/** The room has its `sound`, `concert()`, `microphone()`, `playAloud()` and `refresh()`, and `forget()`: the shape and the song
 * that were asked for earlier do not come any more. */
let room;
/** The recording, and what ends it. */
let filming;
/** While a film waits for its pictures: the dance's clock when it began and now, and where in the song it is. */
let filmed;

/** Records what is seen and heard from now on. */
function beginFilm() {
  const { clientWidth, clientHeight } = of("picture");
  const by = Math.min(devicePixelRatio, 1.5);
  const overheard = room.sound.overheard();
  let film;
  try { film = new LiveFilm(by * clientWidth, by * clientHeight, overheard.tracks); } catch (error) { overheard.end(); throw error; }
  const unwatch = watch((picture, veil) => film.take(picture, veil));
  filming = { film, follow: overheard.follow, keepLate: overheard.keepLate, end: () => { unwatch(); overheard.end(); } };
  film.failed.catch(attempt(async (error) => {
    // One that is ending already gives away by itself.
    if (filming?.film !== film) return;
    filming.end();
    filming = undefined;
    room.refresh();
    await keepPart(film, error);
  }));
  say("A live recording: what this page shows is filmed, at the pace at which it is shown. Press Stop to have it.", false, 20);
  room.refresh();
}

/** Ends the film, and gives it away. */
export async function endFilm() {
  if (!filming) return;
  const { film, end } = filming;
  filming = undefined;
  room.refresh();
  try {
    const { film: file, ending } = await film.end();
    save(`chladni.${ending}`, file);
  } catch (error) { await keepPart(film, error); } finally { end(); }
}

/** Gives away as much as there is of a recording that has failed, and says why it has. */
async function keepPart(film, error) {
  const { film: part, ending } = await film.rest();
  if (!part.size) throw error;
  save(`chladni.${ending}`, part);
  throw wholeFilm.endedEarly(error);
}

/** Whether a film waits for its pictures. */
export const isFilmed = () => !!filmed;
/** Whether there is a film that would be lost. */
export const isUnfinished = () => !!filming || !!filmed;

/** The song for a film that waits for its pictures. */
const stage = {
  sound: () => ({ ...room.sound.samples, position: room.sound.position(), duration: room.sound.duration }),
  begin: () => {
    if (room.microphone()) throw new Error("A film of a song needs a song: stop listening first.");
    if (room.concert().plays_show()) throw new Error("A show is played: stop it first, or have chladni dance --show film it.");
    // Not even the tune, which may still be decoded.
    if (!room.sound.samples) throw new Error("There is no song yet: film it once one is heard.");
    room.forget();
    const clock = shows.clockSecs(performance.now());
    filmed = { from: clock, clock, position: room.sound.position(), aloud: room.sound.isHeard, playing: room.sound.playing };
    room.sound.pause();
  },
  at: (secs, position) => Object.assign(filmed, { clock: filmed.from + secs, position }),
  /** The dance goes on where the film has brought it, and the song where it was. */
  end: () => {
    if (!filmed) return;
    const { clock, aloud, playing } = filmed;
    shows.skip(shows.clockSecs(performance.now()) - clock);
    filmed = undefined;
    room.sound.seek(room.sound.from);
    room.sound.playing = playing;
    if (aloud) attempt(room.playAloud)().then(room.refresh);
    room.refresh();
  },
};

/** The time and the place in the song that a film waits for, if one does. */
export const moment = () => filmed;

/** Shows whether the room is recorded, and whether it can be; `isBusy`: what is heard is no song. */
export function show(isBusy) {
  of("film-song").disabled = !!filming || isBusy;
  of("film").classList.toggle("going", !!filming);
  if (!filming) of("film").textContent = "Film";
  // A microphone may have come or gone.
  filming?.follow(room.microphone()?.stream);
}

/** Shows how long it is recorded by now. */
export function tick() {
  if (!filming) return;
  filming.keepLate();
  of("film").textContent = `Stop, ${Math.floor(filming.film.secs)} s`;
}

export function listen(musicRoom) {
  room = musicRoom;
  wholeFilm.listen(stage);
  on("film", () => (filming ? endFilm() : beginFilm()));
}

// Plays the list of songs: one after the other, and always the one that was asked for last.
import * as listening from "./listening.js";
import { attempt, ofFile, on, say } from "./page.js";
import * as playlist from "./playlist.js";
import * as songs from "./songs.js";

/** The music room: its `sound`, `concert()`, `endShow()`, `hear()`, `playAloud()` and `refresh()`. */
let room;
/** Counts what was asked for: only the last is played. */
let turn = 0;
/** The song that was asked for last, until it plays. */
let wanted;

/** A new wish: what was asked for before is not wanted any more. Gives its number. */
function wish() {
  wanted = undefined;
  return ++turn;
}

/** A song that was asked for does not come any more. */
export function passOver() {
  wish();
  repeatAsChosen();
}

function unreadable(error) {
  say(error.message ?? String(error), true);
  room.refresh();
}

/** Plays a song of the list; one that cannot be read leaves it to the next. Unless it `begins`, it is heard only if the one
 * before it was. */
async function playSong(song, begins = true) {
  const { sound } = room;
  const mine = wish();
  const { pauses } = sound;
  room.endShow();
  let decoded;
  const stopped = new Set();
  while (song && !decoded) {
    wanted = song;
    try { decoded = await songs.soundOf(song); } catch (error) {
      if (mine !== turn) return;
      unreadable(ofFile(song.name, error));
      const stays = ["AbortError", "StoppedError"].includes(error.name);
      if (error.name === "AbortError") song = undefined;
      else if (stays) {
        stopped.add(song);
        const next = playlist.repeats() === "list" ? songs.beside(song, 1) : songs.behind(song);
        // It ends where the list has come round.
        song = stopped.has(next) ? undefined : next;
      } else song = songs.strike(song);
      // One that stays does not begin anew because the one before it has ended.
      if (stays && !song && sound.hasEnded) sound.pause();
    }
  }
  if (mine !== turn) return;
  try {
    if (decoded) await begin(song, decoded, begins, pauses);
  } finally {
    if (mine === turn) {
      wanted = undefined;
      repeatAsChosen();
    }
    goOn();
    room.refresh();
  }
}

/** Begins a song. `pauses` is how often the sound had been paused when it was asked for. */
async function begin(song, decoded, begins, pauses) {
  const { sound } = room;
  // A pause meanwhile has the last word.
  const aloud = sound.isHeard || (begins && !!song.file && pauses === sound.pauses);
  songs.play(song, decoded);
  sound.load(decoded, isRepeated());
  room.hear();
  if (begins && listening.microphone()) await listening.stop();
  if (aloud) await room.playAloud();
  songs.prepare(unreadable);
}

/** A song that has ended makes room for the next, where the one that was awaited does not come. */
function goOn() {
  if (room.sound.hasEnded && !wanted && songs.count()) ended();
}

/** Another song than before may come next. One that is asked for sees to that itself, once it plays. */
function prepareNext() {
  if (!wanted) songs.prepare(unreadable);
}

/** Songs play one after the other, behind those of the list. */
export const openSongs = (files) => playSong(songs.add(files));

/** Plays the song so many places after the one that plays, or before it. */
export const beside = attempt((steps) => playSong(songs.beside(wanted ?? songs.current(), steps)));

function ended() {
  // One that was asked for comes already.
  if (wanted || room.concert()?.plays_show()) return undefined;
  if (playlist.repeats() !== "off" || songs.behind(songs.current())) return beside(playlist.repeats() === "song" ? 0 : 1);
  room.sound.pause();
  room.sound.seek(0);
  return room.refresh();
}

/** Whether the song that plays begins anew at its end. */
export const isRepeated = () => playlist.repeats() === "song" || (playlist.repeats() === "list" && songs.count() === 1);

/** Songs of shows follow one another as they did. */
function repeatAsChosen() {
  if (!room.concert()?.plays_show()) room.sound.setRepeats(isRepeated());
}

const ofTheList = {
  plays: attempt((song) => playSong(song)),
  takesOut: attempt(async (song) => {
    if (song === wanted) passOver();
    const next = songs.takeOut(song);
    // One that was asked for comes all the same.
    if (next && !wanted) await playSong(next, false);
    else {
      repeatAsChosen();
      goOn();
      prepareNext();
    }
    room.refresh();
  }),
  reordered: prepareNext,
  louder: (volume) => room.sound.setVolume(volume),
  repeats: repeatAsChosen,
};

export function listen(musicRoom) {
  room = musicRoom;
  room.sound.onend = ended;
  playlist.listen(ofTheList);
  on("previous", () => beside(-1));
  on("next", () => beside(1));
}

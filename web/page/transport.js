// The song that plays: its name, where it is, Play and Pause, and the desktop's keys for them.
import * as films from "./room_films.js";
import * as listening from "./listening.js";
import * as player from "./player.js";
import { attempt, hasModifier, of, on } from "./page.js";
import * as songs from "./songs.js";
import * as sounding from "./sounding.js";

/** The music room: its `sound`, `isHere()`, `endShow()`, `playAloud()` and `refresh()`. */
let room;

const clock = (secs) => `${Math.floor(secs / 60)}:${String(Math.floor(secs % 60)).padStart(2, "0")}`;

/** Shows where the song is. */
export function showPlace() {
  const { sound } = room;
  const seek = of("seek");
  if (!seek.matches(":active")) seek.value = sound.duration ? sound.position() / sound.duration : 0;
  const text = `${clock(sound.position())} of ${clock(sound.duration)}`;
  if (seek.title === text) return;
  seek.title = text;
  seek.setAttribute("aria-valuetext", text);
}

function songName() {
  const { name } = songs.current() ?? { name: songs.TUNE };
  if (name === songs.TUNE) return "Our own tune";
  return songs.count() > 1 ? `${songs.place() + 1} of ${songs.count()}: ${name}` : name;
}

/** Shows the song that plays, or that a microphone is heard in its place. */
export function show(isLive) {
  of("where-in-song").hidden = isLive;
  of("song").textContent = of("song").title = songName();
  for (const id of ["previous", "next"]) of(id).hidden = songs.count() < 2 || isLive;
  of("play").textContent = room.sound.isHeard ? "Pause" : "Play";
}

async function playOrPause() {
  await listening.stop();
  room.endShow();
  if (room.sound.isHeard) room.sound.pause(); else await room.playAloud();
  room.refresh();
}

/** Keys of the desktop, where nothing else has them: in full screen there are no controls. */
const onKey = attempt((event) => {
  if (!room.isHere() || hasModifier(event)) return undefined;
  // A film goes on beneath its dialog, whose buttons may have no focus.
  if (films.isFilmed() || document.querySelector("dialog[open]")) return undefined;
  if (event.target.closest("button, input, select, textarea, summary, dialog, [role=slider]")) return undefined;
  // A key that is held is pressed once.
  const correct = (change) => () => (event.repeat ? undefined : sounding.correct(change));
  const acts = {
    " ": playOrPause, PageUp: () => player.beside(-1), PageDown: () => player.beside(1),
    "[": correct("halve_beat"), "]": correct("double_beat"), t: correct("tap_beat"), T: correct("tap_beat"),
  }[event.key];
  if (!acts) return undefined;
  event.preventDefault();
  return acts();
});

export function listen(musicRoom) {
  room = musicRoom;
  // The system may interrupt the sound.
  room.sound.onchange = attempt(room.refresh);
  on("play", playOrPause);
  addEventListener("keydown", onKey);
  of("seek").addEventListener("input", () => {
    room.endShow();
    room.sound.seek(of("seek").value * room.sound.duration);
  });
}

// A microphone that is heard in place of a song: it is opened, followed and closed here.
import { Microphone } from "./microphone.js";
import { attempt, of, on } from "./page.js";

/** The music room: its `sound`, `concert()`, `endShow()` and `refresh()`; `mayListen()`, whether something may be
 * listened to now; and `passOver()`: a song that was asked for does not come any more. */
let room;
/** The one that is heard. */
let opened;
/** Counts what was to be listened to, or no more: only the last is heard. */
let turn = 0;

export const microphone = () => opened;

/** Listens to the microphone of an id, or to the browser's own, in place of a song. */
async function listenTo(id) {
  const mine = ++turn;
  const take = (left, right) => room.concert()?.take_sound(left, right);
  const lost = attempt(async () => { await close(); throw new Error("The microphone is gone."); });
  const next = await Microphone.open(id, take, lost);
  const isWanted = () => mine === turn && room.mayListen();
  if (!isWanted()) return next.close();
  await close();
  if (!isWanted()) return next.close();
  room.sound.pause();
  opened = next;
  // A song that was asked for earlier would end it.
  room.passOver();
  room.endShow();
  room.concert()?.listen(next.rate);
  const all = await Microphone.all();
  if (opened !== next) return;
  of("microphone").replaceChildren(...all.map(([each, name]) => new Option(name, each)));
  of("microphone").value = next.id;
  room.refresh();
}

/** Back to the songs; a microphone that is being opened is not wanted any more. */
export function stop() {
  turn++;
  return close();
}

async function close() {
  const closing = opened;
  opened = undefined;
  room.concert()?.stop_listening();
  room.refresh();
  await closing?.close();
}

export function listen(musicRoom) {
  room = musicRoom;
  on("listen", () => (opened ? stop() : listenTo()));
  of("microphone").addEventListener("change", attempt(async () => {
    try {
      await listenTo(of("microphone").value);
    } finally {
      // One that cannot be opened leaves the one before.
      if (opened) of("microphone").value = opened.id;
    }
  }));
}

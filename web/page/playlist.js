// The list of songs as it is shown: what plays, what can be taken out, in which order, how loud.
import { of, on, refill } from "./page.js";
import * as songs from "./songs.js";

function row(song, { plays, takesOut }) {
  const item = document.createElement("li");
  const isHeard = song === songs.current();
  const name = song.name === songs.TUNE ? "Our own tune" : song.name;
  const play = Object.assign(document.createElement("button"), { className: "name", textContent: name, onclick: () => plays(song) });
  play.dataset.key = `${name} play`;
  if (isHeard) play.setAttribute("aria-current", "true");
  item.className = isHeard ? "chosen" : "";
  item.append(play);
  if (song.name === songs.TUNE) return item;
  const out = Object.assign(document.createElement("button"), { textContent: "✕", title: `Take ${name} out of the list`, onclick: () => takesOut(song) });
  out.dataset.key = `${name} out`;
  out.setAttribute("aria-label", out.title);
  item.append(out);
  return item;
}

let deeds;
let shown;

/** Shows the list, where it has changed. */
export function show() {
  const now = [songs.current(), ...songs.all()];
  if (shown?.length === now.length && shown.every((song, i) => song === now[i])) return;
  shown = now;
  refill(of("song-list"), songs.all().map((song) => row(song, deeds)));
  of("shuffle").disabled = songs.count() < 3;
}

/** At the end of a song: `list`, `song` or `off`. */
export const repeats = () => of("repeat").value;

/** `acts` has `plays(song)` and `takesOut(song)`, `louder(volume)`, and `repeats()` and `reordered()`, which are called where
 * that has changed. */
export function listen(acts) {
  deeds = acts;
  on("shuffle", () => { songs.shuffle(); show(); acts.reordered(); });
  of("volume").addEventListener("input", () => acts.louder(Number(of("volume").value) / 100));
  of("repeat").addEventListener("change", acts.repeats);
}

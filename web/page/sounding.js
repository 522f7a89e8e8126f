// What is heard now: its spectrum, its tempo, and corrections of its beat by hand.
import * as drawn from "./drawn.js";
import * as listening from "./listening.js";
import { of, on, setText } from "./page.js";
import { floats } from "./picture.js";
import * as songs from "./songs.js";

const [MID, SIDE, LINE, WEAK] = ["#e2a646d9", "#78bedcd9", "#ffffff24", "#a9a69f"];
const MARKS = [[100, "100 Hz"], [1000, "1 kHz"], [10_000, "10 kHz"]];
/** Pixels of the page: of the names, and of the row in which they stand. */
const [FONT, NAMES] = [10.5, 13];
/** The middle of the sound has this share of the height below the names; its sides have the rest. */
const ABOVE = 0.64;

/** The music room: its `sound`, `concert()` and `refresh()`. */
let room;

/** Bars as high as the roots of the values, from `base` up, or down where `height` is below 0. */
function bars(brush, values, width, base, height, color, gap) {
  const step = width / values.length;
  const wide = Math.max(1, step - gap);
  brush.fillStyle = color;
  brush.beginPath();
  for (let i = 0; i < values.length; i++) brush.rect(i * step, base, wide, -height * Math.sqrt(Math.min(1, Math.max(0, values[i]))));
  brush.fill();
}

/** Draws the spectrum: the middle grows up from a line, the sides down from it. */
function paint(canvas, concert) {
  const [width, height] = drawn.fit(canvas);
  const brush = canvas.getContext("2d");
  const dot = devicePixelRatio;
  const top = NAMES * dot;
  const line = top + Math.round(ABOVE * (height - top));
  brush.clearRect(0, 0, width, height);
  const count = concert.bands();
  if (count) {
    bars(brush, floats(concert.mid(), count), width, line, line - top, MID, dot);
    bars(brush, floats(concert.side(), count), width, line + dot, line + dot - height, SIDE, dot);
  }
  brush.fillStyle = LINE;
  brush.fillRect(0, line, width, dot);
  brush.font = `${FONT * dot}px system-ui, sans-serif`;
  brush.fillStyle = WEAK;
  brush.fillText("mid", 4 * dot, top - 3 * dot);
  brush.fillText("side", 4 * dot, height - 3 * dot);
  const hz = floats(concert.bands_hz(), count);
  for (const [mark, name] of MARKS) {
    let band = 0;
    while (band < count && hz[band] < mark) band++;
    const x = (width * band) / Math.max(1, count);
    // Where there is room for its name.
    if (band === count || x < 34 * dot || x > width - 42 * dot) continue;
    brush.fillText(name, x + 3 * dot, top - 3 * dot);
    brush.fillRect(x, 0, dot, height);
  }
}

/** Shows what is heard now, where there is room for it. */
export function show(concert) {
  const canvas = of("spectrum");
  if (!canvas.clientWidth) return;
  paint(canvas, concert);
  const bpm = concert.tempo_bpm();
  const text = bpm > 0 ? `${Math.round(bpm)}\u00a0BPM, ${Math.round(100 * concert.beat_confidence())}\u00a0%\u00a0sure` : "waiting for a beat";
  setText(of("tempo"), text);
}

/** Corrects the beat: `halve_beat`, `double_beat`, or `tap_beat`, which only the beat of a microphone takes. */
export function correct(change) {
  const concert = room.concert();
  // Nothing dances yet.
  if (!concert) return;
  concert[change]();
  const song = songs.current();
  // Kept with the song, so that another shape dances to the same beats.
  if (song && !listening.microphone()) song.reading = concert.reading(room.sound.number);
  room.refresh();
}

export function listen(musicRoom) {
  room = musicRoom;
  for (const change of ["halve", "double", "tap"]) on(`${change}-beat`, () => correct(`${change}_beat`));
}

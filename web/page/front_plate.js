// The plate of the front page where it stands still: for those who ask for less motion, and for all who want it so.
import { isStirred } from "./picture.js";
import { of, on, report } from "./page.js";

/** Seconds of the tune after which the sand lies in figures, and how far it goes at once, without being shown. */
const [STREWN_SECS, STEP_SECS] = [6, 0.2];
const lessMotion = matchMedia("(prefers-reduced-motion: reduce)");

let still = lessMotion.matches;
/** Its time and the place in the song where it stands, and the size of its last picture. */
let stands;

export const isStill = () => still;

/** Draws it where it stands, once, and again where a hand turns it or the page has another size; whether it did.
 * `frame(clock, position, width, height)` draws, and `goOn(clock, position)` only lets time pass: of a plate that has not
 * danced yet, sand goes where it lies after a while. */
export function drawStill(now, { clock, position, isKnown }, width, height, { frame, goOn }) {
  stands ??= { clock, position, strews: position === 0 };
  if (stands.strews && isKnown && stands.position < STREWN_SECS) {
    stands.clock += STEP_SECS;
    stands.position += STEP_SECS;
    stands.drawn = undefined;
    goOn(stands.clock, stands.position);
    return false;
  }
  const size = `${width}×${height}`;
  if (stands.drawn === size && !isStirred(now)) return false;
  const drawn = frame(stands.clock, stands.position, width, height);
  if (drawn) [stands.drawn, report.standsAtSecs] = [size, stands.position];
  return drawn;
}

/** Its picture is gone: it is drawn again where it stands. */
export function again() {
  if (stands) stands.drawn = undefined;
}

/** It moves from now on: where it stood, if it did. */
export function letGo() {
  const stood = stands;
  stands = undefined;
  return stood;
}

/** `changed()` is called where it is to stand still, or no more. */
export function listen(changed) {
  const set = (to) => {
    still = to;
    of("hold-still").textContent = still ? "Let the plate move" : "Hold the plate still";
    changed();
  };
  on("hold-still", () => set(!still));
  lessMotion.addEventListener("change", () => set(lessMotion.matches));
  set(still);
}

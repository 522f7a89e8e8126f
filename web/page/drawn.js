// A curve under a finger, the mouse or the keyboard, and the canvas that shows it. Places go from 0 to 1, to the right and
// up.
import { hasModifier } from "./page.js";

/** Arrow keys go so many steps across a curve, and so many up. */
const [ACROSS, UP] = [32, 20];
/** The width of a step across. */
export const STEP = 1 / ACROSS;
/** Pixels between a curve and its frame. */
const EDGE = 8;

const within = (value) => Math.min(1, Math.max(0, value));

/** The middle of what keys change. */
export const middle = ({ at, width }) => at + width / 2;

/** Keys change what begins at a place. */
const go = (curve, at) => { curve.at = Math.min(1 - curve.width, within(at)); };

/**
 * Keys change a part of `curve`, from `at` on, of this `width`: a `STEP`, or 0 for a point. In its middle the curve has the
 * height `height()`; `draw(from, to)` draws between two places, the same where a stroke begins, and gives from where it goes
 * on; `put(x, y)` gives the part around x a height; `done()` ends either; `paint()` shows it. While a hand draws, it is
 * `held`. `left` and `below` are pixels beside and under the curve that are not its own.
 */
export function listen(canvas, curve, { left: aside = 0, below = 0 } = {}) {
  curve.at ??= 0;
  let last;
  /** The pointer that draws. */
  let hand;
  const place = (event) => {
    const { left, top, width, height } = canvas.getBoundingClientRect();
    return [within((event.clientX - left - aside - EDGE) / (width - aside - 2 * EDGE)), within(1 - (event.clientY - top - EDGE) / (height - below - 2 * EDGE))];
  };
  const stroke = (from, to) => {
    last = curve.draw(from, to);
    go(curve, to[0] - curve.width / 2);
    curve.paint();
  };
  canvas.addEventListener("pointerdown", (event) => {
    // Another button or a second finger begins no stroke.
    if (event.button || (curve.held && event.pointerId !== hand)) return;
    hand = event.pointerId;
    canvas.setPointerCapture(hand);
    curve.held = true;
    const at = place(event);
    stroke(at, at);
  });
  canvas.addEventListener("pointermove", (event) => { if (last && event.pointerId === hand) stroke(last, place(event)); });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    canvas.addEventListener(end, (event) => {
      if (event.pointerId !== hand) return;
      curve.held = false;
      if (last) curve.done();
      last = undefined;
    });
  }
  for (const change of ["focus", "blur"]) canvas.addEventListener(change, () => curve.paint());
  canvas.addEventListener("keydown", (event) => {
    const side = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const rise = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if ((!side && !rise) || hasModifier(event)) return;
    event.preventDefault();
    if (side) go(curve, curve.at + side * STEP);
    else {
      curve.put(middle(curve), within(curve.height() + rise / UP));
      curve.done();
    }
    curve.paint();
  });
}

/** Gives a canvas as many pixels as it takes on the screen: its width and height. */
export function fit(canvas) {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * devicePixelRatio)));
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  return [width, height];
}

/** A fresh canvas: its brush, how many pixels one of the page has, and where places lie in it. */
export function plane(canvas, curve, { left = 0, below = 0 } = {}) {
  const [width, height] = fit(canvas);
  const brush = canvas.getContext("2d");
  const [edge, aside, foot] = [EDGE, left, below].map((side) => side * devicePixelRatio);
  const x = (share) => aside + edge + share * (width - aside - 2 * edge);
  const y = (share) => edge + (1 - share) * (height - foot - 2 * edge);
  brush.clearRect(0, 0, width, height);
  brush.fillStyle = "#ffffff18";
  // Where the keys are.
  if (document.activeElement === canvas) {
    const wide = Math.max(2 * devicePixelRatio, x(curve.width) - x(0));
    brush.fillRect(x(middle(curve)) - wide / 2, y(1), wide, y(0) - y(1));
  }
  return { brush, dot: devicePixelRatio, x, y };
}

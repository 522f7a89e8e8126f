// The shape as a drawing in ink, which a worker makes: lines while something moves, with shade once it rests. Until a
// drawing is there, the one before is seen.
import { ask } from "./work.js";
import { say } from "./page.js";

/** Milliseconds without a change after which the shade is drawn, too. */
const REST = 250;
const NAME = "ink";

let wanted;
let changedAt = 0;
let drawing = false;
let shown;
let isNew = false;
/** The figure that the worker has, and whose it is. */
let known = {};

/** What the worker must be told of the figure. */
function figure(sitting) {
  const pose = sitting.pose();
  if (known.sitting === sitting && known.pose === pose) return {};
  known = { sitting, pose };
  return { positions: sitting.positions(), corners: sitting.corners() };
}

/** Asks the worker for a drawing. Where that fails it may have ended, and the figure with it. */
async function asks(sitting, request) {
  try { return await ask({ ...figure(sitting), ...request }, undefined, NAME); } catch (error) {
    known = {};
    throw error;
  }
}

async function draw(sitting, scene, asked) {
  drawing = true;
  try {
    const { pixels } = await asks(sitting, { work: "ink", ...asked });
    const image = new ImageData(new Uint8ClampedArray(pixels.buffer), asked.width, asked.height);
    shown = { scene, shade: asked.shade, image };
    isNew = true;
  } catch (error) {
    // Not again before something changes.
    shown = { ...shown, scene, shade: true };
    if (error.name !== "AbortError") say(error.message ?? String(error), true);
  } finally { drawing = false; }
}

/** Whether there is a drawing that has not been shown yet. Has the next one drawn where it is to be another. */
export function inked(sitting, tones, now, width, height) {
  const viewer = sitting.viewer(width, height);
  const scene = JSON.stringify([sitting.pose(), viewer, tones, width, height]);
  if (scene !== wanted) [wanted, changedAt] = [scene, now];
  const shade = now - changedAt > REST;
  const isDone = shown?.scene === scene && (shown.shade || !shade);
  if (!drawing && !isDone) draw(sitting, scene, { viewer, tones, shade, width, height });
  return !!shown?.image && isNew;
}

/** The newest drawing, which counts as shown. */
export function newest() {
  isNew = false;
  return shown.image;
}

/** Shows it again, or, for another shape, anew. */
export function again(forget) {
  isNew = true;
  if (forget) shown = undefined;
}

/** The drawing as a file: `png` or `svg`. */
export async function inkFile(sitting, format, tones, width, height) {
  const viewer = sitting.viewer_of_export(width, height);
  const { file } = await asks(sitting, { work: "inkFile", format, viewer, tones, width, height });
  return file;
}

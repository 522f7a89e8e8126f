// The picture that both rooms draw into, in as many pixels as this machine draws in time.
import { of, report, say } from "./page.js";

const picture = of("picture");
const brush = picture.getContext("2d", { alpha: false });
/** A picture may take so long, in milliseconds; else it gets fewer pixels. */
const [SLOWEST, FASTEST] = [40, 22];
/** Fewer pixels than this share of those of the page look like fog. */
const COARSEST = 0.55;
/** Milliseconds after which a picture that changes only by hand gets all its pixels. */
const REST = 200;

const finest = () => Math.min(devicePixelRatio, 1.5);
let detail = finest();
let sinceChange = 0;
let stirredAt = 0;
let room;
let memory;

/** Pixels of the picture for each of the page, as it is now. */
export const scale = () => picture.width / Math.max(1, picture.clientWidth);

/** Shows a room from now on: its `name` is that of the picture, `frame(now, width, height)` draws, true where it did, `pixels()` says where, and `drawn`
 * is called after. A room that `rests` changes by hand alone. */
export function show(next) {
  if (room === next) return;
  room = next;
  picture.setAttribute("aria-label", `${room.name} Drag or use the arrow keys to turn it, plus and minus to come nearer.`);
  detail = finest();
  report.drawMs = 0;
}

/** A hand moves what is shown: until it rests, a picture may have fewer pixels. */
export const stir = () => { stirredAt = performance.now(); };

/** Draws for ever. */
export function start(moduleMemory) {
  memory = moduleMemory;
  requestAnimationFrame(draw);
}

function draw(now) {
  requestAnimationFrame(draw);
  if (!room) return;
  const resting = room.rests && now - stirredAt > REST;
  const pixelsFor = resting ? finest() : detail;
  const [width, height] = [picture.clientWidth, picture.clientHeight].map((side) => Math.max(16, Math.round(side * pixelsFor)));
  const began = performance.now();
  let drawn = false;
  try {
    drawn = room.frame(now, width, height);
  } catch (error) { say(error.message ?? String(error), true); }
  if (!drawn) return;
  if (picture.width !== width || picture.height !== height) [picture.width, picture.height] = [width, height];
  const pixels = new Uint8ClampedArray(memory.buffer, room.pixels(), 4 * width * height);
  brush.putImageData(new ImageData(pixels, width, height), 0, 0);
  const took = performance.now() - began;
  if (report.frames++ === 0) report.firstPictureMs = performance.now();
  if (!resting || detail === finest()) {
    report.drawMs = report.drawMs ? 0.9 * report.drawMs + 0.1 * took : took;
    suit();
  }
  room.drawn?.(width, height);
}

function suit() {
  if (++sinceChange < (room.rests ? 3 : 12)) return;
  if (report.drawMs > SLOWEST && detail > COARSEST) detail = Math.max(COARSEST, detail * 0.85);
  else if (report.drawMs < FASTEST && detail < finest()) detail = Math.min(finest(), detail * 1.1);
  else return;
  report.detail = detail;
  sinceChange = 0;
}

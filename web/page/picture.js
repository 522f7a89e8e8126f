// The picture that both rooms draw into, in as many pixels as this machine draws in time.
import { card, loseCard, smallPicture, whyGone } from "./card.js";
import { isStopped, of, report, say, stops } from "./page.js";

const picture = of("picture");
/** Of what the processor draws; where the graphics card does, the picture lets its canvas through. */
let brush;
/** It lies over that of the graphics card now: a drawing that no card makes. */
let covers = false;
/** A picture may take so long, in milliseconds; else it gets fewer pixels. */
const [SLOWEST, FASTEST] = [40, 22];
/** Fewer pixels than this share of those of the page look like fog. */
const COARSEST = 0.55;
/** Milliseconds after which a picture that changes only by hand gets all its pixels. */
const REST = 200;

/** Pixels of the longer side of a picture that is saved. */
export const LONGEST = 2000;

const finest = () => Math.min(devicePixelRatio, 1.5);
let detail = finest();
let sinceChange = 0;
let stirredAt = 0;
let room;
let memory;
/** Somebody else asks for each picture. */
let held = false;
/** All rooms that were shown. */
const rooms = new Set();
/** Those who take each. */
const watching = new Set();
let across = 1;

/** Pixels of the picture for each of the page: of the one that is shown, or of one that is `width` wide. */
export const scale = (width = across) => width / Math.max(1, picture.clientWidth);

/** Shows a room from now on: its `name` is that of the picture, `frame(now, width, height)` draws, true where it did, `pixels()` says where, and `drawn`
 * is called after. A room that `rests` changes by hand alone; one that may flash has a `judge` of the card's pictures.
 * `drawing()` may give a finished picture in place of what was drawn. `byProcessor` has the processor draw it from then on. */
export function show(next) {
  if (room === next) return;
  room = next;
  rooms.add(room);
  picture.style.background = "";
  picture.setAttribute("aria-label", `${room.name} Drag or use the arrow keys to turn it, plus and minus to come nearer.`);
  // The processor begins with few pixels and takes more where it has time: the other way the page would stand still first.
  detail = card() || room.rests ? finest() : COARSEST;
  report.drawMs = 0;
}

/** A hand moves what is shown: until it rests, a picture may have fewer pixels. */
export const stir = () => { stirredAt = performance.now(); };
/** Whether a hand moves it, or did a moment ago. */
export const isStirred = (now) => now - stirredAt <= REST;

/** `count` numbers in the module's memory, from where they begin: only until the module works again. */
export const floats = (from, count) => new Float32Array(memory.buffer, from, count);

/** Draws for ever. */
export function start(moduleMemory) {
  memory = moduleMemory;
  requestAnimationFrame(draw);
}

function draw(now) {
  requestAnimationFrame(draw);
  if (!room || held || isStopped()) return;
  const resting = room.rests && !isStirred(now);
  const pixelsFor = resting ? finest() : detail;
  const [width, height] = [picture.clientWidth, picture.clientHeight].map((side) => Math.max(16, Math.round(side * pixelsFor)));
  const began = performance.now();
  if (!drawAt(now, width, height, watching)) return;
  const took = performance.now() - began;
  if (report.frames++ === 0) report.firstPictureMs = performance.now();
  if (!resting || detail === finest()) {
    report.drawMs = report.drawMs ? 0.9 * report.drawMs + 0.1 * took : took;
    suit();
  }
  room.drawn?.(width, height);
}

/** Draws and shows a picture of this size, and has all of `takes` take it; whether there was one to draw. */
function drawAt(now, width, height, takes) {
  let drawn = false;
  try {
    if (whyGone()) throw new Error(whyGone());
    drawn = room.frame(now, width, height);
  } catch (error) {
    if (stops(error)) return false;
    const why = error.message ?? String(error);
    say(card() ? `The graphics card is gone (${why}): the processor draws.` : why, true);
    if (card()) withoutCard();
  }
  if (!drawn) return false;
  across = width;
  const own = room.drawing?.();
  if (own) lay(own);
  else if (card()) { uncover(); veil(); } else paint(width, height);
  for (const take of takes) take(own ? picture : card() ?? picture, picture.style.background);
  return true;
}

/** Draws no more by itself, until what this gives is called. Pictures are as large as they fit in meanwhile. */
export function hold() {
  held = true;
  document.body.dataset.held = "yes";
  return () => { held = false; delete document.body.dataset.held; };
}

/** Draws a picture of this size now; `take(canvas, veil)` takes it. */
export function drawOnce(width, height, take) {
  const draws = () => drawAt(performance.now(), width, height, [take]);
  // Once more where the graphics card was lost: the processor goes on.
  if (!draws() && !draws()) throw new Error("There is nothing to be seen yet.");
}

/** The size of a picture of the page's shape, `longest` pixels long. */
export function sizeOf(longest) {
  const { clientWidth, clientHeight } = picture;
  const by = longest / Math.max(clientWidth, clientHeight);
  return [clientWidth, clientHeight].map((side) => Math.max(1, Math.round(by * side)));
}

/** A canvas of its own, and what lays pictures on it as they are seen: as large as they fit in, under their veil. */
export function copier(width, height) {
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  const brush = canvas.getContext("2d", { alpha: false });
  const take = (picture, veil) => {
    const by = Math.min(width / picture.width, height / picture.height);
    const [w, h] = [by * picture.width, by * picture.height];
    brush.fillStyle = "#000";
    brush.fillRect(0, 0, width, height);
    brush.drawImage(picture, (width - w) / 2, (height - h) / 2, w, h);
    if (!veil) return;
    brush.fillStyle = veil;
    brush.fillRect(0, 0, width, height);
  };
  return { canvas, take };
}

/** The picture as it is seen now, drawn anew `longest` pixels long: a PNG. */
export async function takePicture(longest) {
  const [width, height] = sizeOf(longest);
  const { canvas, take } = copier(width, height);
  drawOnce(width, height, take);
  const png = await new Promise((done) => canvas.toBlob(done, "image/png"));
  if (!png) throw new Error("The browser has no memory for a picture of this size.");
  return png;
}

/** Shows the pixels of the processor. */
function paint(width, height) {
  const pixels = new Uint8ClampedArray(memory.buffer, room.pixels(), 4 * width * height);
  lay(new ImageData(pixels, width, height));
}

/** Shows an image. */
function lay(image) {
  const { width, height } = image;
  if (picture.width !== width || picture.height !== height) [picture.width, picture.height] = [width, height];
  brush ??= picture.getContext("2d");
  brush.putImageData(image, 0, 0);
  covers = true;
}

/** Lets the card's picture be seen. */
function uncover() {
  if (covers) brush.clearRect(0, 0, picture.width, picture.height);
  covers = false;
}

/** Veils the card's picture where it would flash. */
function veil() {
  if (!room.judge) return;
  const opacity = room.judge(...smallPicture()) / 255;
  const tone = opacity < 0 ? 0 : 255;
  picture.style.background = opacity ? `rgb(${tone} ${tone} ${tone} / ${Math.abs(opacity)})` : "";
}

/** Goes on by the processor where the graphics card has failed. */
function withoutCard() {
  loseCard();
  picture.style.background = "";
  for (const one of rooms) one.byProcessor();
}

/** Has `take(canvas, veil)` take each picture as it is seen; gives what ends that. */
export function watch(take) {
  watching.add(take);
  return () => watching.delete(take);
}

function suit() {
  if (++sinceChange < (room.rests ? 3 : 12)) return;
  if (report.drawMs > SLOWEST && detail > COARSEST) detail = Math.max(COARSEST, detail * 0.85);
  else if (report.drawMs < FASTEST && detail < finest()) detail = Math.min(finest(), detail * 1.1);
  else return;
  report.detail = detail;
  sinceChange = 0;
}

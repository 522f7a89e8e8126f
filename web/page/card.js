// Whether a graphics card draws, and its picture, which lies under that of the processor.
import { close_card, open_card } from "./chladni_web.js";
import { of, say } from "./page.js";

/** Pixels of the small picture in which flashes are looked for. */
const [WIDE, HIGH] = [320, 180];

let canvas;
const small = Object.assign(document.createElement("canvas"), { width: WIDE, height: HIGH });
// The card makes it small; else the whole picture would come back.
const glance = small.getContext("2d", { willReadFrequently: false });
glance.imageSmoothingEnabled = false;

/** What `?draw=gpu` or `?draw=cpu` says. */
const asked = new URLSearchParams(location.search).get("draw");

/** A processor that plays the graphics card draws more slowly than ours. */
function isDisguised(adapter) {
  const { isFallbackAdapter = adapter.isFallbackAdapter, architecture, description } = adapter.info ?? {};
  return isFallbackAdapter || /swiftshader|llvmpipe|basic render/i.test(`${architecture} ${description}`);
}

async function isWanted() {
  if (asked === "cpu") return false;
  const adapter = await navigator.gpu?.requestAdapter({ powerPreference: "high-performance" });
  if (asked === "gpu" && !adapter) say("This browser lends no graphics card to pages: the processor draws.", true);
  return !!adapter && (asked === "gpu" || !isDisguised(adapter));
}

function tell() {
  for (const place of document.querySelectorAll(".drawn-by")) {
    place.textContent = canvas ? "Drawn by the graphics card." : "Drawn by the processor.";
  }
}

/** Has the graphics card draw, where there is one. */
export async function openCard() {
  try {
    if (await isWanted()) {
      const page = Object.assign(document.createElement("canvas"), { id: "card" });
      page.setAttribute("aria-hidden", "true");
      await open_card(page);
      of("picture").before(page);
      canvas = page;
    }
  } catch (error) {
    say(`The graphics card cannot draw here (${error.message ?? error}): the processor draws.`, true);
  }
  tell();
}

/** The canvas that the card draws into, if it does. */
export const card = () => canvas;

/** The processor draws from now on. */
export function loseCard() {
  close_card();
  canvas.remove();
  canvas = undefined;
  tell();
}

/** The picture that was just drawn, made small: its pixels, their number across and down. Within a frame only. */
export function smallPicture() {
  glance.drawImage(canvas, 0, 0, WIDE, HIGH);
  return [glance.getImageData(0, 0, WIDE, HIGH).data, WIDE, HIGH];
}

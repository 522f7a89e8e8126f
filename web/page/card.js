// Whether a graphics card draws, and its picture, which lies under that of the processor.
import { card_lost, close_card, open_card } from "./chladni_web.js";
import { of, say } from "./page.js";

/** Pixels of the small picture in which flashes are looked for. */
const [WIDE, HIGH] = [320, 180];

let canvas;
const small = Object.assign(document.createElement("canvas"), { width: WIDE, height: HIGH });
// The card makes it small; else the whole picture would come back.
const glance = small.getContext("2d", { willReadFrequently: false });
glance.imageSmoothingEnabled = false;

/** Whether it draws through WebGL2, and why it does so no more. */
let byWebGl = false;
let gone;

/** What `?draw=gpu`, `?draw=webgl` or `?draw=cpu` says. */
const asked = new URLSearchParams(location.search).get("draw");

const SOFTWARE = /swiftshader|llvmpipe|softpipe|basic render|software/i;

/** A processor that plays the graphics card draws more slowly than ours. */
function isDisguised(adapter) {
  const { isFallbackAdapter = adapter.isFallbackAdapter, architecture, description } = adapter.info ?? {};
  return isFallbackAdapter || SOFTWARE.test(`${architecture} ${description}`);
}

async function lendsWebGpu() {
  if (asked && asked !== "gpu") return false;
  const adapter = await navigator.gpu?.requestAdapter({ powerPreference: "high-performance" });
  return !!adapter && (asked === "gpu" || !isDisguised(adapter));
}

/** Gives a canvas a context of WebGL2, where a graphics card is behind it. */
function lendsWebGl(page) {
  if (asked && asked !== "webgl") return false;
  const isAsked = asked === "webgl";
  const gl = page.getContext("webgl2", {
    alpha: false, antialias: false, powerPreference: "high-performance", failIfMajorPerformanceCaveat: !isAsked,
  });
  const name = gl?.getParameter(gl.getExtension("WEBGL_debug_renderer_info")?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER);
  return !!gl && (isAsked || !SOFTWARE.test(name));
}

function tell() {
  const text = !canvas ? "Drawn by the processor."
    : byWebGl ? "Drawn by the graphics card through WebGL2, deformed by the processor." : "Drawn by the graphics card, deformed by the processor.";
  for (const place of document.querySelectorAll(".drawn-by")) place.textContent = text;
}

/** Has the graphics card draw, where there is one: through WebGPU, or else through WebGL2. */
export async function openCard() {
  try {
    const page = Object.assign(document.createElement("canvas"), { id: "card" });
    page.setAttribute("aria-hidden", "true");
    const byWebGpu = await lendsWebGpu();
    byWebGl = !byWebGpu && lendsWebGl(page);
    if (byWebGpu || byWebGl) {
      page.addEventListener("webglcontextlost", () => { gone = "the browser has taken it back"; });
      await open_card(page, byWebGl);
      of("picture").before(page);
      canvas = page;
    } else if (["gpu", "webgl"].includes(asked)) {
      say("This browser lends no graphics card to pages: the processor draws.", true);
    }
  } catch (error) {
    say(`The graphics card cannot draw here (${error.message ?? error}): the processor draws.`, true);
  }
  tell();
}

/** Why the card that draws is to be asked no more, if so. A picture that rests asks it for nothing, and has to know, too. */
export const whyGone = () => canvas && (gone ??= card_lost());

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

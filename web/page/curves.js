// The curves of the dance on stage, which a hand draws: which harmonic each sound band drives, and how strongly each
// harmonic answers.
import { draw_curve, smooth_curve } from "./chladni_web.js";
import { of } from "./page.js";

const CURVES = [
  { id: "transfer", range: [0, 1], color: "#78bedc" },
  { id: "amplification", range: [-1, 1], color: "#e2a646" },
];
/** Arrow keys go so many steps across a curve, and so many up its range. */
const [ACROSS, UP] = [32, 20];
/** Pixels between a curve and its frame. */
const EDGE = 8;

let item;

/** What is drawn becomes a dance by `act`, once the hand rests. */
export function listen(act) {
  for (const curve of CURVES) {
    const canvas = of(curve.id);
    const [low, high] = curve.range;
    const done = () => act({ do: `set-${curve.id}`, item, [curve.id]: [...curve.values] });
    const at = (event) => {
      const { left, top, width, height } = canvas.getBoundingClientRect();
      const [x, y] = [(event.clientX - left - EDGE) / (width - 2 * EDGE), (event.clientY - top - EDGE) / (height - 2 * EDGE)];
      return [Math.min(1, Math.max(0, x)), Math.min(high, Math.max(low, high - y * (high - low)))];
    };
    const stroke = (from, to) => {
      curve.values = draw_curve(curve.values, low, high, ...from, ...to);
      curve.at = to[0];
      paint(curve);
    };
    let last;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      last = at(event);
      stroke(last, last);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      const to = at(event);
      stroke(last, to);
      last = to;
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { if (last) done(); last = undefined; });
    canvas.addEventListener("keydown", (event) => {
      const side = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      const rise = { ArrowUp: 1, ArrowDown: -1 }[event.key];
      if (!side && !rise) return;
      event.preventDefault();
      if (side) curve.at = Math.min(1 - 1 / ACROSS, Math.max(0, curve.at + side / ACROSS));
      else {
        const value = valueAt(curve) + (rise * (high - low)) / UP;
        stroke([curve.at + 1 / ACROSS, value], [curve.at, value]);
        done();
      }
      paint(curve);
    });
    of(`smooth-${curve.id}`).addEventListener("click", () => { curve.values = smooth_curve(curve.values); paint(curve); done(); });
  }
}

/** Shows the curves of the dance on stage, or none. */
export function show(curves) {
  of("curves").hidden = !curves;
  if (!curves) return;
  item = curves.item;
  for (const curve of CURVES) {
    curve.values = Float32Array.from(curves[curve.id]);
    curve.at ??= 0;
    paint(curve);
  }
}

const valueAt = ({ values, at }) => values[Math.min(values.length - 1, Math.floor(at * values.length))];

function paint(curve) {
  const { values, at, range: [low, high], color } = curve;
  const canvas = of(curve.id);
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * devicePixelRatio)));
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const brush = canvas.getContext("2d");
  const edge = EDGE * devicePixelRatio;
  const x = (share) => edge + share * (width - 2 * edge);
  const y = (value) => edge + ((high - value) / (high - low)) * (height - 2 * edge);
  brush.clearRect(0, 0, width, height);
  brush.fillStyle = "#ffffff18";
  brush.fillRect(x(0), y(0), x(1) - x(0), devicePixelRatio);
  if (document.activeElement === canvas) brush.fillRect(x(at), edge, x(1 / ACROSS) - x(0), height - 2 * edge);
  brush.strokeStyle = color;
  brush.lineWidth = 2 * devicePixelRatio;
  brush.beginPath();
  values.forEach((value, i) => brush.lineTo(x(i / Math.max(1, values.length - 1)), y(value)));
  brush.stroke();
  canvas.setAttribute("aria-valuenow", valueAt(curve).toFixed(2));
  canvas.setAttribute("aria-valuetext", `${valueAt(curve).toFixed(2)} at ${Math.round(100 * at)} %`);
}

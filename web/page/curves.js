// The curves of the dance on stage, which a hand draws: which harmonic each sound band drives, and how strongly each
// harmonic answers.
import { draw_curve, draw_step, smooth_curve } from "./chladni_web.js";
import * as drawn from "./drawn.js";
import { attempt, of } from "./page.js";

const CURVES = [
  { id: "transfer", range: [0, 1], color: "#78bedc" },
  { id: "amplification", range: [-1, 1], color: "#e2a646" },
];

let item;

/** What is drawn becomes a dance by `act`, once the hand rests; `begin(item, name)` gives it a ready-made curve. */
export function listen(act, begin) {
  for (const curve of CURVES) {
    const [low, high] = curve.range;
    const value = ([x, y]) => [x, low + y * (high - low)];
    const draw = (from, to) => {
      curve.values = draw_curve(curve.values, low, high, ...value(from), ...value(to));
      return to;
    };
    Object.assign(curve, {
      draw,
      width: drawn.STEP,
      put: (x, y) => { curve.values = draw_step(curve.values, low, high, x, drawn.STEP, low + y * (high - low)); },
      height: () => (valueAt(curve) - low) / (high - low),
      paint: () => paint(curve),
      done: () => act({ do: `set-${curve.id}`, item, [curve.id]: [...curve.values] }),
    });
    drawn.listen(of(curve.id), curve);
    of(`begin-${curve.id}`).addEventListener("change", attempt(() => {
      const { value } = of(`begin-${curve.id}`);
      of(`begin-${curve.id}`).value = "";
      return begin(item, value);
    }));
    of(`smooth-${curve.id}`).addEventListener("click", () => { curve.values = smooth_curve(curve.values); paint(curve); curve.done(); });
  }
}

/** A hand draws one of them. */
export const isHeld = () => CURVES.some(({ held }) => held);

/** Shows the curves of the dance on stage, or none. */
export function show(curves) {
  of("curves").hidden = !curves;
  // A show that is played does not take what is drawn out of the hand.
  if (!curves || isHeld()) return;
  item = curves.item;
  for (const curve of CURVES) {
    curve.values = Float32Array.from(curves[curve.id]);
    paint(curve);
  }
}

const valueAt = (curve) => {
  const { values } = curve;
  return values[Math.min(values.length - 1, Math.floor(drawn.middle(curve) * values.length))];
};

function paint(curve) {
  const { values, range: [low, high], color } = curve;
  if (!values) return;
  const canvas = of(curve.id);
  const { brush, dot, x, y } = drawn.plane(canvas, curve);
  const height = (value) => y((value - low) / (high - low));
  brush.fillStyle = "#ffffff18";
  brush.fillRect(x(0), height(0), x(1) - x(0), dot);
  brush.strokeStyle = color;
  brush.lineWidth = 2 * dot;
  brush.beginPath();
  values.forEach((value, i) => brush.lineTo(x(i / Math.max(1, values.length - 1)), height(value)));
  brush.stroke();
  canvas.setAttribute("aria-valuenow", valueAt(curve).toFixed(2));
  canvas.setAttribute("aria-valuetext", `${valueAt(curve).toFixed(2)} at ${Math.round(100 * drawn.middle(curve))} %`);
}

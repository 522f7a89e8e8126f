// t and a of a dance, as small curves in its cell: which harmonic each sound band drives, and how strongly each harmonic
// answers.
import { element } from "./page.js";

const SVG = "http://www.w3.org/2000/svg";
const CURVES = [["transfer", "t"], ["amplification", "a"]];

/** As many points of a line as can be told apart. Where the processor composes the page, it draws them in every frame. */
const POINTS = 64;

/** At most `POINTS` values: of each stretch of `values` the one farthest from 0, so that no peak is lost. */
function fewer(values) {
  const count = Math.min(POINTS, values.length);
  return Array.from({ length: count }, (_, i) => {
    const [from, to] = [i, i + 1].map((each) => Math.floor((each * values.length) / count));
    return values.slice(from, to).reduce((far, value) => (Math.abs(value) > Math.abs(far) ? value : far));
  });
}

/** The path of values between `low` and `high` across a square of 100. */
function path(all, low, high) {
  const values = fewer(all);
  const x = (i) => (100 * i) / Math.max(1, values.length - 1);
  const y = (value) => (100 * (high - value)) / (high - low);
  return `M${values.map((value, i) => `${x(i).toFixed(1)} ${y(value).toFixed(1)}`).join("L")}`;
}

/** What `small().show` shows. */
export function paths(transfer, amplification) {
  const peak = amplification.reduce((most, a) => Math.max(most, Math.abs(a)), 1e-6);
  return { transfer: path(transfer, 0, 1), amplification: path(amplification, -peak, peak) };
}

function made(tag, attributes) {
  const shape = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) shape.setAttribute(name, value);
  return shape;
}

/** A box for both curves, and what shows `paths` in it, or none. */
export function small() {
  const box = element("div", { className: "mapping", hidden: true });
  box.setAttribute("aria-hidden", true);
  // A dark rim below each line: it can be seen on any background.
  const lines = CURVES.map(([name, letter]) => {
    const both = ["rim", "line"].map((each) => made("path", { class: each }));
    const curve = made("svg", { class: name, viewBox: "0 0 100 100", preserveAspectRatio: "none" });
    curve.append(...both);
    box.append(element("span", { className: name, textContent: letter }), curve);
    return [name, both];
  });
  let shown;
  const show = (curves) => {
    if (curves === shown) return;
    shown = curves;
    box.hidden = !curves;
    if (curves) for (const [name, both] of lines) for (const line of both) line.setAttribute("d", curves[name]);
  };
  return { box, show };
}

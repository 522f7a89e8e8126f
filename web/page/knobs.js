// The knobs and switches of the instrument: controls made from the module's tables, as the window's are.
import { knobs } from "./chladni_web.js";
import { attempt, capitalized, element, hasModifier, knobRow, of, refill } from "./page.js";

/** Steps of a slider from one end to the other. */
const STEPS = 400;
/** Sand has a button of its own, which sets the stage for it, too. */
const ELSEWHERE = ["sand"];

/** The quantity that slides evenly, of a value and back: by even factors, of the cube root where the range begins at 0 or below. */
const scaleOf = ({ low, high, by_factors }) => {
  if (!by_factors) return { to: (x) => x, back: (x) => x };
  return low > 0 ? { to: Math.log, back: Math.exp } : { to: Math.cbrt, back: (x) => x ** 3 };
};
const rounded = ({ decimals, factor }, value) => (decimals === 0 && factor === 1 ? Math.round(value) : value);
const words = ({ factor, decimals, unit }, value) => `${(value * factor).toFixed(decimals).replace("-", "−")}${unit}`;

const rows = new Map();
const boxes = new Map();
const groups = [];
let act;

/** A knob's row: its name, its slider, its value. */
function row(knob) {
  const { to, back } = scaleOf(knob);
  const [first, last] = [to(knob.low), to(knob.high)];
  const { label, slider, output } = knobRow(knob.name, knob.tip, { min: 0, max: STEPS, step: "any" });
  slider.addEventListener("input", () => {
    const value = rounded(knob, back(first + (slider.value / STEPS) * (last - first)));
    act({ do: "set", parameter: knob.parameter, value: Math.min(knob.high, Math.max(knob.low, value)) });
  });
  // A key goes a fiftieth; a slider without steps would go a hundredth of one.
  slider.addEventListener("keydown", (event) => {
    const by = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (!by || hasModifier(event)) return;
    event.preventDefault();
    slider.value = Number(slider.value) + (by * STEPS) / 50;
    slider.dispatchEvent(new Event("input"));
  });
  rows.set(knob.parameter, { show: (value, why) => {
    if (!slider.matches(":active")) slider.value = ((to(value) - first) / (last - first)) * STEPS;
    output.textContent = words(knob, value);
    slider.setAttribute("aria-valuetext", output.textContent);
    slider.disabled = !!why;
    label.title = slider.title = why ?? knob.tip;
  } });
  return label;
}

function group(name, made, parameters = []) {
  const why = element("p", { className: "small" });
  groups.push({ why, parameters });
  return element("details", {}, element("summary", { textContent: name }), ...made, why);
}

function box([name, text, tip]) {
  const check = element("input", { type: "checkbox" });
  check.addEventListener("change", () => act({ do: "switch", switch: name, on: check.checked }));
  boxes.set(name, check);
  return element("label", { title: tip }, check, text);
}

/** `acts(action)` does an action; `setTimbre(name)` chooses how harmonics ring. */
export function listen(acts, setTimbre) {
  act = acts;
  const table = JSON.parse(knobs());
  of("form").append(...table.forms.map(([form, name, tip]) => Object.assign(new Option(name, form), { title: tip })));
  of("choir").append(...table.choirs.map(([choir, name]) => new Option(name, choir)));
  of("timbre").append(new Option("None", ""), ...table.timbres.map((name) => new Option(capitalized(name), name)));
  const own = Object.assign(new Option("Its own", "own"), { hidden: true });
  of("timbre").append(own);
  of("form").addEventListener("change", () => act({ do: "set-form", form: of("form").value }));
  of("choir").addEventListener("change", () => act({ do: "set-choir", choir: of("choir").value }));
  of("timbre").addEventListener("change", attempt(() => setTimbre(of("timbre").value)));
  of("harmonics").addEventListener("input", () => {
    const { value, max } = of("harmonics");
    act({ do: "set-harmonics", harmonics: value === max ? 0 : Number(value) });
  });
  const ofKnobs = table.knobs.map(([name, all]) => group(name, all.map(row), all.map(({ parameter }) => parameter)));
  const switches = table.switches.map(([name, all]) => [name, all.filter(([each]) => !ELSEWHERE.includes(each))]);
  refill(of("knobs"), [...ofKnobs, ...switches.filter(([, all]) => all.length).map(([name, all]) => group(name, all.map(box)))]);
}

/** Shows what a concert's state says. */
export function show({ settings, harmonics, timbre, idle }) {
  of("form").value = settings.form;
  of("form").title = of("form").selectedOptions[0]?.title ?? "";
  of("choir").value = settings.choir;
  of("timbre").value = timbre ?? "own";
  of("harmonics").max = harmonics;
  of("harmonics").value = settings.harmonics || harmonics;
  of("harmonics-value").textContent = of("harmonics").value;
  for (const [parameter, { show: set }] of rows) set(settings.knobs[parameter], idle[parameter]);
  for (const [name, check] of boxes) check.checked = settings.switches[name];
  for (const { why, parameters } of groups) {
    why.textContent = [...new Set(parameters.map((parameter) => idle[parameter]).filter(Boolean))].join(" ");
    why.hidden = !why.textContent;
  }
}

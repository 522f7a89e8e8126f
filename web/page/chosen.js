// The chosen layer beyond its amount: its name, how it is matched, the head that it is compared with, the edge of its region.
import { head_sliders } from "./chladni_web.js";
import { attempt, capitalized, knobRow, of, on, say } from "./page.js";

let room;
let layer;
/** The sliders of a head. */
const head = [];

const percent = (share) => (share < 0.001 ? "Less than 0.1 %" : `${(100 * share).toFixed(1)} %`);

/** Shows the chosen layer, or that there is none. */
export function show(chosen) {
  layer = chosen;
  if (!layer) return;
  if (document.activeElement !== of("layer-name")) of("layer-name").value = layer.name;
  of("template-row").hidden = layer.template_text === null;
  if (document.activeElement !== of("template-text")) of("template-text").value = layer.template_text ?? "";
  of("solo").setAttribute("aria-pressed", layer.solo);
  of("match").hidden = !layer.has_mesh && !layer.head;
  of("method-row").hidden = of("fit-size-row").hidden = !layer.has_mesh;
  of("method").value = layer.method;
  of("fit-size").checked = layer.fits_size;
  of("infill-row").hidden = layer.untrusted === null;
  of("infill").value = layer.infill;
  of("infill-value").textContent = layer.infill.toFixed(2);
  of("untrusted").textContent = layer.untrusted === null ? "" : `${percent(layer.untrusted)} of the shape is not trusted: there the difference goes on from its surroundings.`;
  of("head-row").hidden = !layer.head;
  layer.head?.forEach((value, i) => head[i](value));
  const { roll_off, clamp } = layer.smoothing;
  of("edge").value = roll_off;
  of("clamp").checked = clamp;
  of("clamp-row").hidden = roll_off !== "sharp";
  for (const id of ["edge-row", "softness-row"]) of(id).hidden = layer.everywhere;
}

function slider([name, about], i) {
  const { label, slider: input, output } = knobRow(capitalized(name.replace("-", " ")), about, { min: -1, max: 1, step: 0.01 });
  input.addEventListener("input", () => { output.textContent = Number(input.value).toFixed(2); });
  // The match follows, which takes seconds: once the slider is let go.
  input.addEventListener("change", attempt(() => { room.sitting().set_head(layer.id, i, Number(input.value)); return room.changed(); }));
  head[i] = (value) => {
    if (!input.matches(":active")) input.value = value;
    output.textContent = value.toFixed(2);
  };
  return label;
}

/** Moves μ to where hardly a triangle folds. */
function goFurthest() {
  if (layer.mu * layer.strength === 0) {
    return say("Nothing moves at a μ or strength of 0. Set both, μ a little to the side on which it is to grow.");
  }
  const mu = room.sitting().furthest_mu();
  if (mu === undefined) return say("This layer never folds in that direction, or does not act yet.");
  return room.set({ mu });
}

/** `caricature` has `sitting()`, `act(action)`, `set(property)`, `slide(id, to)` and `changed()`. */
export function listen(caricature) {
  room = caricature;
  of("head-sliders").append(...JSON.parse(head_sliders()).map(slider));
  of("layer-name").addEventListener("change", () => room.set({ name: of("layer-name").value }));
  on("solo", () => room.set({ solo: !layer.solo }));
  on("duplicate", () => room.act({ duplicate: layer.id }));
  of("mu-value").addEventListener("change", () => {
    const typed = Number(of("mu-value").value);
    const isNumber = of("mu-value").value !== "" && Number.isFinite(typed);
    const mu = isNumber ? Math.min(100, Math.max(-100, typed)) : layer.mu;
    // It keeps the focus, and is not drawn anew until it loses that.
    of("mu-value").value = mu.toFixed(2);
    return isNumber ? room.set({ mu }) : room.changed();
  });
  on("furthest", goFurthest);
  of("template-text").addEventListener("change", attempt(() => { room.sitting().set_template(layer.id, of("template-text").value); return room.changed(); }));
  // What was refused may be corrected, until the box is left.
  of("template-text").addEventListener("blur", () => show(layer));
  of("method").addEventListener("change", attempt(() => { room.sitting().set_method(layer.id, of("method").value); return room.changed(); }));
  of("fit-size").addEventListener("change", attempt(() => { room.sitting().fit_size(layer.id, of("fit-size").checked); return room.changed(); }));
  room.slide("infill", (infill) => ({ infill }));
  for (const edit of ["clear", "grow", "shrink", "smooth"]) on(`region-${edit}`, () => room.act({ paint: { layer: layer.id, edit } }));
  const smoothing = () => ({ smoothing: { ...layer.smoothing, roll_off: of("edge").value, clamp: of("clamp").checked } });
  for (const id of ["edge", "clamp"]) of(id).addEventListener("change", () => room.set(smoothing()));
}

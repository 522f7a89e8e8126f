// The list of layers: the topmost layer is the topmost row.
import { of, refill } from "./page.js";

/** `key` is who has the focus again when the list is drawn anew. */
function button(key, text, label, act) {
  const made = document.createElement("button");
  made.dataset.key = key;
  made.textContent = text;
  made.setAttribute("aria-label", label);
  made.title = label;
  made.onclick = act;
  return made;
}

/** As it is set in type. */
const number = (x) => x.toFixed(2).replace("-", "−");

const said = ({ state, why, mu, template, folds }) => {
  if (state === "failed") return why;
  if (state === "waiting") return `waits for ${template}…`;
  const folded = folds ? `, ${folds} folded` : "";
  return `μ ${number(mu)} · ${template}${folded}`;
};

function row(layer, chosen, top, bottom, choices) {
  const item = document.createElement("li");
  item.className = `${chosen ? "chosen" : ""} ${layer.state}`;
  const key = (what) => `${layer.id} ${what}`;
  const eye = button(key("eye"), layer.enabled ? "◉" : "○", `Show ${layer.name}`, () => choices.enable(layer, !layer.enabled));
  eye.setAttribute("aria-pressed", layer.enabled);
  const name = document.createElement("button");
  name.className = "name";
  name.dataset.key = key("name");
  name.setAttribute("aria-pressed", chosen);
  const [title, small] = [document.createElement("strong"), document.createElement("small")];
  title.textContent = layer.solo ? `${layer.name} (solo)` : layer.name;
  small.textContent = said(layer);
  name.append(title, small);
  name.onclick = () => choices.select(layer);
  item.append(eye, name);
  if (layer.state === "failed") item.append(button(key("again"), "↻", `Try the match of ${layer.name} again`, () => choices.retry(layer)));
  const up = button(key("up"), "▲", `Move ${layer.name} up`, () => choices.move(layer, 1));
  up.disabled = top;
  const down = button(key("down"), "▼", `Move ${layer.name} down`, () => choices.move(layer, -1));
  down.disabled = bottom;
  item.append(up, down, button(key("delete"), "✕", `Delete ${layer.name}`, () => choices.remove(layer)));
  return item;
}

/** Shows the layers of a sitting's state, where they have changed. */
export function drawLayers(parent, { layers, selected }, choices) {
  const shown = JSON.stringify([selected, layers.map(({ id, name, enabled, solo, state, ...rest }) => [id, name, enabled, solo, state, said({ state, ...rest })])]);
  if (parent.dataset.shown === shown) return;
  parent.dataset.shown = shown;
  refill(parent, layers.map((layer, i) => row(layer, layer.id === selected, i === layers.length - 1, i === 0, choices)).reverse());
}

/** Offers the results of the layers as templates of a layer above them. */
export function offerResults(select, { results }) {
  const group = select.querySelector("optgroup") ?? select.appendChild(Object.assign(document.createElement("optgroup"), { label: "The result of" }));
  const names = JSON.stringify(results);
  if (group.dataset.shown === names) return;
  group.dataset.shown = names;
  group.hidden = results.length === 0;
  group.replaceChildren(...results.map(([id, name]) => Object.assign(new Option(name, `layer:${id}`), { title: "What comes above it grows" })));
}

/** Shows the parts as buttons, where they have changed. */
export function drawParts(parent, names, taken, choices) {
  if (parent.dataset.shown !== names.join("|")) {
    parent.dataset.shown = names.join("|");
    parent.replaceChildren(...names.map((name, part) => {
      const made = button(name, name, name, () => choices.toggle(part, made.getAttribute("aria-pressed") === "true"));
      made.removeAttribute("title");
      made.onpointerenter = made.onfocus = () => choices.point(part);
      made.onpointerleave = made.onblur = () => choices.point(names.length);
      return made;
    }));
  }
  names.forEach((name, part) => parent.children[part].setAttribute("aria-pressed", taken.includes(name)));
}

/** The numbers of the chosen layer. */
export function showLayer({ mu, least_mu, strength, model, curve, smoothing, everywhere, coverage, residual, flipped, stretched, warnings }) {
  of("mu").min = least_mu;
  of("mu").value = mu;
  if (document.activeElement !== of("mu-value")) of("mu-value").value = mu.toFixed(2);
  of("strength").value = strength;
  of("model").value = model;
  of("curve").value = curve;
  of("softness").value = Math.log(smoothing.wavelength);
  of("softness").setAttribute("aria-valuetext", `${Math.round(100 * smoothing.wavelength)} % of the shape's size`);
  of("everywhere").setAttribute("aria-pressed", everywhere);
  const covered = coverage === null ? "" : `The match covers ${Math.round(100 * coverage)} % of the shape.`;
  const left = residual === null ? "" : `Half of its points come within ${(100 * residual).toFixed(1)} % of its size of the template.`;
  const bent = flipped + stretched === 0 ? "" : `Triangles turned over: ${flipped}, strongly stretched: ${stretched}.`;
  of("quality").textContent = [covered, left, bent, ...warnings].filter((text) => text !== "").join(" ");
}

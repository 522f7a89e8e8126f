// The dance on stage, or the first that is chosen: its name, its own strength and its own μ.
import { of, on } from "./page.js";

let shown;

/** A hand is on a slider, or a name is being typed: it stays that of the dance for which it was begun. */
export const isHeld = () => document.activeElement === of("dance-name") || ["own-gain", "own-mu"].some((id) => of(id).matches(":active"));

/** Shows dance `item` of a state, or none. */
export function show(item, { dances, without_mu }) {
  if (dances[shown] && isHeld()) item = shown;
  shown = dances[item] && item;
  of("this-dance").disabled = shown === undefined;
  of("dance-number").textContent = shown === undefined ? "" : `${item + 1}`;
  if (shown === undefined) return;
  const { name, gain, stereo_mu, locked, favorite } = dances[item];
  of("dance-lock").setAttribute("aria-pressed", locked);
  of("dance-favor").setAttribute("aria-pressed", favorite);
  if (document.activeElement !== of("dance-name")) of("dance-name").value = name;
  of("dance-name").placeholder = `Dance ${item + 1}`;
  of("own-gain").value = gain;
  of("own-gain-value").textContent = gain.toFixed(2);
  of("own-mu").value = stereo_mu;
  of("own-mu-value").textContent = stereo_mu.toFixed(2);
  of("own-mu").disabled = !!without_mu;
  of("own-mu-row").title = without_mu ?? "";
}

/** `choices` has `vary(item)`, `lock(item)` and `favor(item)`. */
export function listen(act, choices) {
  for (const deed of ["vary", "lock", "favor"]) on(`dance-${deed}`, () => choices[deed](shown));
  const follow = (id, event, action) => of(id).addEventListener(event, () => { if (shown !== undefined) act(action(shown, of(id).value)); });
  follow("dance-name", "change", (item, name) => ({ do: "rename", item, name }));
  follow("own-gain", "input", (item, gain) => ({ do: "set-item-gain", item, gain: Number(gain) }));
  follow("own-mu", "input", (item, mu) => ({ do: "set-stereo-mu", item, stereo_mu: Number(mu) }));
}

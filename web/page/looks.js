// The look of the dance: a whole scene, and parts of it that were chosen for themselves.
import { look_parts, looks } from "./chladni_web.js";
import { of, options } from "./page.js";

const parts = [];

/** `set(looks)` shows looks, as a show file names them; `now()` gives those that are shown. */
export function listen(set, now) {
  of("look").append(...options(JSON.parse(looks()), (name) => name));
  // A look is a whole: parts that were chosen for another one go.
  of("look").addEventListener("change", () => set({ ...now(), look: of("look").value, ...Object.fromEntries(parts.map((part) => [part, ""])), blur_percent: undefined }));
  for (const [part, names] of JSON.parse(look_parts())) {
    parts.push(part);
    of(`look-${part}`).append(new Option("As the look", ""), ...options(names, (name) => name));
    of(`look-${part}`).addEventListener("change", () => set({ ...now(), [part]: of(`look-${part}`).value }));
  }
}

export function show(shown) {
  const { look = "" } = shown;
  // That of a sheet, which is made for sand, is not offered for others.
  if (look && ![...of("look").options].some(({ value }) => value === look)) of("look").append(...options([look], (name) => name));
  of("look").value = look;
  for (const part of parts) of(`look-${part}`).value = shown[part] ?? "";
}

// The look of the dance: a whole scene, and parts of it that were chosen for themselves.
import { look_parts, looks } from "./chladni_web.js";
import { capitalized, of, options } from "./page.js";

const parts = [];
/** The palette that is the shape's texture or colors. */
const OWN = "own";

/** The checkboxes of effects, each of which can be left out of all looks. */
const boxes = () => of("effects").querySelectorAll("input");

/** `set(looks)` shows looks, as a show file names them; `now()` gives those that are shown. */
export function listen(set, now) {
  of("look").append(...options(JSON.parse(looks()), (name) => name));
  // A look is a whole: parts that were chosen for another one go.
  of("look").addEventListener("change", () => set({ ...now(), look: of("look").value, ...Object.fromEntries(parts.map((part) => [part, ""])), blur_percent: undefined }));
  for (const [part, names] of JSON.parse(look_parts())) {
    parts.push(part);
    of(`look-${part}`).append(new Option("As the look", ""), ...names.map((name) => new Option(name === OWN ? "Own colors" : capitalized(name), name)));
    of(`look-${part}`).addEventListener("change", () => set({ ...now(), [part]: of(`look-${part}`).value }));
  }
  for (const box of boxes()) {
    box.addEventListener("change", () => {
      const without = (now().without ?? []).filter((name) => name !== box.value);
      set({ ...now(), without: box.checked ? without : [...without, box.value] });
    });
  }
}

/** Shows looks in the controls, of a shape that brings colors or does not; `effects` are those that the look has itself. */
export function show(shown, hasOwnColors, effects) {
  const { look = "" } = shown;
  // That of a sheet, which is made for sand, is not offered for others.
  if (look && ![...of("look").options].some(({ value }) => value === look)) of("look").append(...options([look], (name) => name));
  of("look").value = look;
  for (const part of parts) of(`look-${part}`).value = shown[part] ?? "";
  of("no-own-colors").hidden = shown.palette !== OWN || hasOwnColors;
  for (const box of boxes()) {
    const has = effects.includes(box.value);
    box.checked = has && !shown.without?.includes(box.value);
    box.disabled = !has;
    box.title = has ? "" : "This look has none";
  }
}

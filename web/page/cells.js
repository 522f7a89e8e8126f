// What lies over a gallery's picture: a button for each item, so that pointer, keys and screen readers reach it.
import { small } from "./mapping.js";
import { setText } from "./page.js";

const made = [];
/** Those of the room that is shown. */
let current;

function cell(item) {
  const box = document.createElement("div");
  const button = (name, act) => Object.assign(document.createElement("button"), { className: name, onclick: act });
  const choose = button("choose", () => current.choose(item));
  choose.ondblclick = () => current.perform?.(item);
  const favor = button("favor", () => current.favor(item));
  const deeds = Object.assign(document.createElement("div"), { className: "deeds" });
  const vary = button("vary", () => current.vary(item));
  const lock = button("lock", () => current.lock(item));
  const stage = button("stage", () => current.perform(item));
  vary.textContent = "Vary";
  vary.title = "Change it a little, at random";
  lock.textContent = "Lock";
  lock.title = "It keeps its place when others are bred";
  deeds.append(vary, lock, stage);
  const curves = small();
  box.append(choose, curves.box, favor, deeds);
  return { box, curves, choose, stage, favor, vary, lock };
}

/**
 * Lays the buttons over cells of a picture of `width` × `height` pixels: x, y, width and height of each. `choices` has
 * the `label` of all and what they do, `choose(item)` and `perform(item)`; what the second is called, `performs` and,
 * aloud, `says(item)`;
 * `name(item)` for items without a name; and, where there is such a thing, `favor(item)`, `lock(item)`, `vary(item)` and
 * `curves(item)`, the small curves of its cell. Items may have a `text` in place of their number, and be `idle`: nothing
 * is chosen by them. Where `isNamed`, the texts are names.
 */
export function drawCells(parent, cells, items, width, height, choices) {
  current = choices;
  if (parent.getAttribute("aria-label") !== choices.label) parent.setAttribute("aria-label", choices.label);
  const count = cells.length / 4;
  while (made.length > count) made.pop().box.remove();
  while (made.length < count) {
    const next = cell(made.length);
    parent.append(next.box);
    made.push(next);
  }
  made.forEach(({ box, curves, choose, stage, favor, vary, lock }, item) => {
    const [x, y, w, h] = cells.slice(4 * item, 4 * item + 4);
    const { chosen = false, favorite = false, locked = false, name, idle = false, text = item + 1 } = items[item] ?? {};
    const at = `left:${(100 * x) / width}%;top:${(100 * y) / height}%;width:${(100 * w) / width}%;height:${(100 * h) / height}%`;
    if (box.dataset.at !== at) box.style.cssText = box.dataset.at = at;
    box.className = ["cell", chosen && "chosen", choices.isNamed && "named"].filter(Boolean).join(" ");
    curves.show(choices.curves?.(item));
    setText(choose, text);
    choose.disabled = idle;
    choose.setAttribute("aria-pressed", chosen);
    choose.setAttribute("aria-label", name || choices.name(item));
    choose.title = choices.titled ? name : "";
    stage.hidden = !choices.perform;
    setText(stage, choices.performs ?? "");
    if (choices.says) stage.setAttribute("aria-label", choices.says(item));
    vary.hidden = !choices.vary;
    vary.setAttribute("aria-label", `Vary ${item + 1}`);
    lock.hidden = !choices.lock;
    lock.setAttribute("aria-pressed", locked);
    lock.setAttribute("aria-label", `Lock ${item + 1}`);
    favor.hidden = !choices.favor;
    setText(favor, favorite ? "★" : "☆");
    favor.setAttribute("aria-pressed", favorite);
    favor.setAttribute("aria-label", `Favorite ${item + 1}`);
  });
}

// What lies over a gallery's picture: a button for each item, so that pointer, keys and screen readers reach it.

const made = [];
/** Those of the room that is shown. */
let current;

function cell(item) {
  const box = document.createElement("div");
  const [choose, stage, favor] = Array.from({ length: 3 }, () => document.createElement("button"));
  choose.className = "choose";
  choose.onclick = () => current.choose(item);
  choose.ondblclick = () => current.perform?.(item);
  stage.className = "stage";
  stage.onclick = () => current.perform(item);
  favor.className = "favor";
  favor.onclick = () => current.favor(item);
  box.append(choose, favor, stage);
  return { box, choose, stage, favor };
}

/**
 * Lays the buttons over cells of a picture of `width` × `height` pixels: x, y, width and height of each. `choices` has
 * what they do, `choose(item)` and `perform(item)`; what the second is called, `performs` and, aloud, `says(item)`;
 * `name(item)` for items without a name; and, where there are favorites, `favor(item)`. Items may have a `text` in place
 * of their number, and be `idle`: nothing is chosen by them.
 * Where `isNamed`, the texts are names.
 */
export function drawCells(parent, cells, items, width, height, choices) {
  current = choices;
  const count = cells.length / 4;
  while (made.length > count) made.pop().box.remove();
  while (made.length < count) {
    const next = cell(made.length);
    parent.append(next.box);
    made.push(next);
  }
  made.forEach(({ box, choose, stage, favor }, item) => {
    const [x, y, w, h] = cells.slice(4 * item, 4 * item + 4);
    const { chosen = false, favorite = false, name, idle = false, text = item + 1 } = items[item] ?? {};
    const at = `left:${(100 * x) / width}%;top:${(100 * y) / height}%;width:${(100 * w) / width}%;height:${(100 * h) / height}%`;
    if (box.dataset.at !== at) box.style.cssText = box.dataset.at = at;
    box.className = ["cell", chosen && "chosen", choices.isNamed && "named"].filter(Boolean).join(" ");
    choose.textContent = text;
    choose.disabled = idle;
    choose.setAttribute("aria-pressed", chosen);
    choose.setAttribute("aria-label", name || choices.name(item));
    choose.title = choices.titled ? name : "";
    stage.hidden = !choices.perform;
    stage.textContent = choices.performs ?? "";
    if (choices.says) stage.setAttribute("aria-label", choices.says(item));
    favor.hidden = !choices.favor;
    favor.textContent = favorite ? "★" : "☆";
    favor.setAttribute("aria-pressed", favorite);
    favor.setAttribute("aria-label", `Favorite ${item + 1}`);
  });
}

// What lies over a gallery's picture: a button for each item, so that pointer, keys and screen readers reach it.

const made = [];
/** Those of the room that is shown. */
let current;

function cell(item) {
  const box = document.createElement("div");
  const [choose, stage] = [document.createElement("button"), document.createElement("button")];
  choose.className = "choose";
  choose.textContent = item + 1;
  choose.onclick = () => current.choose(item);
  choose.ondblclick = () => current.perform(item);
  stage.className = "stage";
  stage.onclick = () => current.perform(item);
  box.append(choose, stage);
  return { box, choose, stage };
}

/**
 * Lays the buttons over cells of a picture of `width` × `height` pixels: x, y, width and height of each. `choices` has
 * what they do, `choose(item)` and `perform(item)`; what the second is called, `performs` and, aloud, `says(item)`; and
 * `name(item)` for items without a name.
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
  made.forEach(({ box, choose, stage }, item) => {
    const [x, y, w, h] = cells.slice(4 * item, 4 * item + 4);
    const { chosen = false, name } = items[item] ?? {};
    const at = `left:${(100 * x) / width}%;top:${(100 * y) / height}%;width:${(100 * w) / width}%;height:${(100 * h) / height}%`;
    if (box.dataset.at !== at) box.style.cssText = box.dataset.at = at;
    box.className = chosen ? "cell chosen" : "cell";
    choose.setAttribute("aria-pressed", chosen);
    choose.setAttribute("aria-label", name || choices.name(item));
    choose.title = choices.titled ? name : "";
    stage.textContent = choices.performs;
    stage.setAttribute("aria-label", choices.says(item));
  });
}

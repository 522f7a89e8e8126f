// What lies over the gallery's picture: a button for each dance, so that pointer, keys and screen readers reach it.

const made = [];

function cell(item, choices) {
  const box = document.createElement("div");
  const [choose, stage] = [document.createElement("button"), document.createElement("button")];
  choose.className = "choose";
  choose.textContent = item + 1;
  choose.onclick = () => choices.choose(item);
  choose.ondblclick = () => choices.perform(item);
  stage.className = "stage";
  stage.textContent = "Stage";
  stage.setAttribute("aria-label", `Put dance ${item + 1} on stage`);
  stage.onclick = () => choices.perform(item);
  box.append(choose, stage);
  return { box, choose };
}

/** Lays the buttons over cells of a picture of `width` × `height` pixels: x, y, width and height of each. */
export function drawCells(parent, cells, state, width, height, choices) {
  const count = state.on_stage ? 0 : cells.length / 4;
  while (made.length > count) made.pop().box.remove();
  while (made.length < count) {
    const next = cell(made.length, choices);
    parent.append(next.box);
    made.push(next);
  }
  made.forEach(({ box, choose }, item) => {
    const [x, y, w, h] = cells.slice(4 * item, 4 * item + 4);
    const dance = state.dances[item] ?? {};
    const at = `left:${(100 * x) / width}%;top:${(100 * y) / height}%;width:${(100 * w) / width}%;height:${(100 * h) / height}%`;
    if (box.dataset.at !== at) box.style.cssText = box.dataset.at = at;
    box.className = dance.chosen ? "cell chosen" : "cell";
    choose.setAttribute("aria-pressed", !!dance.chosen);
    choose.setAttribute("aria-label", dance.name || `Dance ${item + 1}`);
  });
}

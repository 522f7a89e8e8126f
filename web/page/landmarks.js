// Landmarks: their numbers over both shapes, and their list.
import { of, refill } from "./page.js";

/** Colors that people with any color vision can tell apart, as the dots have them. */
const COLORS = ["#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7"];

/** Lays numbers beside the dots of a picture of `width` × `height` pixels: number, x and y of each. */
export function drawNumbers(labels, width, height) {
  const at = (i) => labels.slice(3 * i, 3 * i + 3);
  of("labels").replaceChildren(...Array.from({ length: labels.length / 3 }, (_, i) => {
    const [number, x, y] = at(i);
    const made = document.createElement("span");
    made.textContent = number;
    made.style.cssText = `left:${(100 * x) / width}%;top:${(100 * y) / height}%`;
    return made;
  }));
}

/** Lists the landmarks of a layer; `remove(index)` takes one away. */
export function listLandmarks(landmarks, remove) {
  const shown = JSON.stringify(landmarks);
  if (of("landmark-list").dataset.shown === shown) return;
  of("landmark-list").dataset.shown = shown;
  refill(of("landmark-list"), landmarks.map(({ shape, template }, index) => {
    const [item, dot, text, button] = ["li", "i", "span", "button"].map((name) => document.createElement(name));
    dot.style.background = COLORS[index % COLORS.length];
    text.textContent = `${index + 1}: vertex ${shape} on ${template}`;
    button.textContent = "✕";
    button.dataset.key = `${index} remove`;
    button.setAttribute("aria-label", `Remove landmark ${index + 1}`);
    button.onclick = () => remove(index);
    item.append(dot, text, button);
    return item;
  }));
}

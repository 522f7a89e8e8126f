// The chosen layer in its three models beside the original: their names lie over the picture, and a press takes one.
import { drawCells } from "./cells.js";
import { of } from "./page.js";

/** Lays the names over a picture of `width` × `height` pixels; `set(property)` changes the chosen layer. */
export function drawModels(sitting, { layers, selected }, set, width, height) {
  const { model } = layers.find(({ id }) => id === selected) ?? {};
  const models = [...of("model").options].map(({ value, text }) => ({ text, name: text, chosen: value === model }));
  const items = [...models, { text: "Original", name: "Original", idle: true }];
  const choices = {
    label: "The layer in its three models: a press takes one",
    choose: (item) => set({ model: of("model").options[item].value }),
    isNamed: true,
  };
  drawCells(of("cells"), [...sitting.cells()], items, width, height, choices);
}

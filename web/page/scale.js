// The scale curve of the chosen layer, drawn by hand over what the layer exaggerates.
import * as drawn from "./drawn.js";
import { of } from "./page.js";
import { stir } from "./picture.js";

/** Pixels beside and under the curve, for the names of gains and wavelengths. */
const MARGINS = { left: 20, below: 18 };
const [LINE, FAINT, BEFORE, AFTER] = ["#e2a646", "#a9a69f", "#a9a69f55", "#e2a64680"];
const FONT = 10.5;

let room;
let plot;

const isShown = () => of("drawn-scale").open && !!plot;

const curve = {
  // Keys change a point.
  width: 0,
  height: () => room.sitting().scale_height(drawn.middle(curve)),
  draw: (from, to) => {
    stir();
    const begins = from === to;
    const took = room.sitting().draw_scale(begins ? undefined : from, ...to);
    room.refresh();
    return took ? to : from;
  },
  put: (x, y) => room.sitting().put_scale_point(x, y),
  done: () => { room.sitting().finish(); room.refresh(); },
  paint: () => { if (isShown()) paint(); },
};

/** Shows the curve of the chosen layer as it is now. */
export function show() {
  plot = of("drawn-scale").open ? JSON.parse(room.sitting().scale_plot()) : undefined;
  if (!plot) return;
  of("finest").value = plot.residual;
  of("finest-value").textContent = `×${plot.residual.toFixed(2)}`;
  paint();
}

function paint() {
  const { line, reached, bars, gains, waves } = plot;
  const canvas = of("scale-curve");
  const { brush, dot, x, y } = drawn.plane(canvas, curve, MARGINS);
  brush.font = `${FONT * dot}px system-ui, sans-serif`;
  brush.fillStyle = "#ffffff14";
  for (const [height] of gains) brush.fillRect(x(0), y(height), x(1) - x(0), dot);
  for (const [place] of waves) brush.fillRect(x(place), y(1), dot, y(0) - y(1));
  const bands = bars.length - 1;
  bars.slice(0, bands).forEach((heights, band) => heights.forEach((height, i) => {
    brush.fillStyle = [BEFORE, AFTER][i];
    brush.fillRect(x(band / bands) + dot, y(height), x(1 / bands) - x(0) - 2 * dot, y(0) - y(height));
  }));
  const stroke = (from, to, color) => {
    brush.strokeStyle = color;
    brush.lineWidth = 2 * dot;
    brush.beginPath();
    for (let i = from; i <= to; i++) brush.lineTo(x(i / (line.length - 1)), y(line[i]));
    brush.stroke();
  };
  const end = Math.min(line.length - 1, Math.ceil(reached * (line.length - 1)));
  // Beyond the finest harmonic nothing answers.
  stroke(end, line.length - 1, FAINT);
  stroke(0, end, LINE);
  brush.fillStyle = FAINT;
  brush.textAlign = "right";
  for (const [height, name] of gains) brush.fillText(name, x(0) - 4 * dot, y(height) + 4 * dot);
  brush.textAlign = "center";
  for (const [place, name] of waves) brush.fillText(name, x(place), y(0) + 15 * dot);
  const words = room.sitting().scale_words(drawn.middle(curve));
  canvas.setAttribute("aria-valuenow", curve.height().toFixed(2));
  canvas.setAttribute("aria-valuetext", words);
  of("scale-words").textContent = words;
}

export function listen(caricature) {
  room = caricature;
  drawn.listen(of("scale-curve"), curve, MARGINS);
  of("drawn-scale").addEventListener("toggle", () => { if (room.sitting()) show(); });
  of("finest").addEventListener("input", () => { room.sitting().set_residual(Number(of("finest").value)); room.refresh(); });
  of("finest").addEventListener("change", curve.done);
}

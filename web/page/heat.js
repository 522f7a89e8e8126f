// What the shape's color shows: a heat map and its legend.
import { color_maps, quantities } from "./chladni_web.js";
import { attempt, numberIn, of } from "./page.js";

const [NONE, OWN] = [0, 1];
/** The number of the harmonics among what is shown: browsers may translate its name. */
let harmonicQuantity;

const css = ([r, g, b]) => `rgb(${r} ${g} ${b})`;
const tick = (value) => Number(value.toPrecision(3)).toString().replace("-", "−");

function drawLegend(legend) {
  of("legend").hidden = !legend;
  if (!legend) return;
  const { low, high, colors, ticks } = legend;
  of("legend").querySelector("div").style.background = `linear-gradient(to right, ${colors.map(css).join()})`;
  of("legend").setAttribute("aria-label", `From ${tick(low)} to ${tick(high)}`);
  of("legend").querySelector("p").replaceChildren(...ticks.map((value) => {
    const made = document.createElement("span");
    made.textContent = tick(value);
    made.style.left = `${(100 * (value - low)) / (high - low)}%`;
    return made;
  }));
}

/** Shows what a sitting's state says. */
export function drawHeat({ heat, own_look, solved, harmonics }) {
  of("heat").value = heat.quantity;
  const isHarmonic = Number(heat.quantity) === harmonicQuantity;
  of("heat").options[OWN].hidden = !own_look;
  of("heat").disabled = !solved;
  of("heat-row").hidden = !heat.legend;
  of("harmonic-row").hidden = !isHarmonic;
  of("harmonic").max = Math.max(0, harmonics - 1);
  of("harmonic").value = heat.harmonic;
  of("color-map").value = heat.map;
  of("color-row").hidden = isHarmonic;
  drawLegend(heat.legend);
}

/** `show(quantity, harmonic, map)` shows something else. */
export function listen(show) {
  const names = JSON.parse(quantities());
  harmonicQuantity = names.indexOf("A harmonic");
  of("heat").append(...names.map((name, i) => new Option(i === NONE ? "Its material" : name, i)));
  of("color-map").append(...JSON.parse(color_maps()).map((name) => new Option(name, name)));
  const changed = attempt(() => show(Number(of("heat").value), numberIn(of("harmonic")), of("color-map").value));
  for (const id of ["heat", "harmonic", "color-map"]) of(id).addEventListener("change", changed);
}

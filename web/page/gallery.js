// The gallery of dances: what can be done with each, breeding, and its generations.
import { paths } from "./mapping.js";
import { of, on, say } from "./page.js";

/** The room does `act(action)`, `breed()`, and `begin(size, isOther)` a gallery of the same or another seed; it has t and a of
 * a dance, `curves(item)`. */
let room;
let state;
/** The small curves of each dance, with the number of what they were drawn from. */
const drawn = [];

const act = (action) => room.act(action);

export const choices = {
  label: "Dances: choose those you love, then breed",
  choose: (item) => act({ do: "choose", item, on: !state.dances[item].chosen }),
  perform: (first) => act({ do: "perform-gallery", first }),
  performs: "Stage",
  says: (item) => `Put dance ${item + 1} on stage`,
  name: (item) => `Dance ${item + 1}`,
  favor: (item) => act({ do: "favorite", item, on: !state.dances[item].favorite }),
  lock: (item) => act({ do: "lock", item, on: !state.dances[item].locked }),
  vary: (item) => act({ do: "mutate", item, amount: 0.2 }),
  curves: (item) => drawn[item]?.paths,
};

/** Breeds; where children are suggested, the page stands still for it. */
async function breed() {
  const isSuggested = state.settings.switches.suggest;
  if (isSuggested) {
    say("The best of two hundred children are looked for…");
    await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
  }
  room.breed();
  if (isSuggested) say("");
}

/** Shows what a concert's state says. */
export function show(now) {
  state = now;
  state.dances.forEach(({ curves }, item) => {
    if (drawn[item]?.curves !== curves) drawn[item] = { curves, paths: paths(...room.curves(item)) };
  });
  const chosen = state.dances.filter((dance) => dance.chosen).length;
  const least = state.settings.switches.suggest ? 1 : 2;
  of("breed").textContent = chosen >= least ? `Breed ${chosen}` : "Breed";
  of("breed").disabled = chosen < least || state.on_stage;
  of("breed").title = chosen < least ? `Choose ${least === 1 ? "a dance" : "two dances"} or more that you love` : "Their children take the place of all but the locked ones";
  of("generations").hidden = state.generations < 2 || state.on_stage;
  of("generation").textContent = `${state.generation + 1} of ${state.generations}`;
  for (const [id, to] of [["earlier", state.back], ["later", state.forth]]) of(id).disabled = to === null;
  of("favorites").hidden = state.favorites === 0;
  of("favorites").textContent = `★ ${state.favorites} on stage`;
  of("gallery-size").value = state.dances.length;
  of("seed").textContent = state.seed;
}

export function listen(musicRoom) {
  room = musicRoom;
  on("breed", breed);
  on("earlier", () => act({ do: "go-to", generation: state.back }));
  on("later", () => act({ do: "go-to", generation: state.forth }));
  on("favorites", () => {
    // One after the other, even where the beat was not set to step.
    act({ do: "switch", switch: "beat-steps", on: true });
    act({ do: "perform-favorites", first: 0 });
  });
  on("other-dances", () => room.begin(state.dances.length, true));
  of("gallery-size").addEventListener("change", () => room.begin(Number(of("gallery-size").value), false));
}

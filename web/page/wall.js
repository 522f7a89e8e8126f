// The gallery of caricatures: twelve of the open shape, to be chosen from and bred. A worker has them.
import { ask, giveUp, obsolete, runs } from "./work.js";
import { attempt, busy, of, on, refill, report } from "./page.js";
import { drawCells } from "./cells.js";

const NAME = "gallery";

let room;
let shown;
/** It is being made. */
let opening = false;
/** Others are about to hang there. */
let stepping = false;
/** How many surprises there were, in all galleries. */
let surprises = 0;

/** Does `act`, unless other figures are on their way: a press is meant for those that are seen. */
const ofSeen = (act) => async (...args) => { if (!stepping) await act(...args); };

/** Without its worker there is no gallery any more. */
const asks = (call, ...args) => ask({ work: "wall", call, args }, undefined, NAME).catch((error) => {
  if (!runs(NAME)) leave();
  throw error;
});

/** Shows what the worker has brought. */
function take({ state, positions }) {
  shown = report.wall = JSON.parse(state);
  if (positions) room.sitting().show_gallery(positions);
  refresh();
}

function refresh() {
  of("wall").hidden = !shown;
  for (const part of document.querySelectorAll("[data-figure]")) part.hidden = !!shown;
  of("gallery").setAttribute("aria-pressed", !!shown);
  room.sitting()?.redraw();
  if (!shown) return;
  for (const item of shown.items) item.idle = stepping;
  of("wall-breed").textContent = shown.chosen ? `Breed ${shown.chosen}` : "Breed";
  of("wall-breed").disabled = !shown.chosen;
  of("wall-back").disabled = shown.first;
  refill(of("wall-locks"), shown.groups.map(([name, locked]) => {
    const made = button(name, async () => take(await asks("lock", name, !locked)));
    made.setAttribute("aria-pressed", locked);
    return made;
  }));
  of("wall-favorites-row").hidden = !shown.favorites.length;
  const taken = (number) => async () => hang((await busy("a favorite", () => asks("favorite", number))).found);
  refill(of("wall-favorites"), shown.favorites.map((name, number) => button(`★ ${name}`, taken(number))));
}

function button(name, act) {
  const made = document.createElement("button");
  made.textContent = made.dataset.key = name;
  made.onclick = attempt(ofSeen(act));
  return made;
}

/** Opens the gallery of the open shape. */
async function open() {
  const { name, bytes, basis } = room.shape();
  const sitting = room.sitting();
  const asked = { work: "openWall", name, bytes: bytes?.slice(), basis, project: sitting.project_text(), matches: sitting.matches() };
  opening = true;
  room.refresh();
  try {
    const brought = await busy("the gallery", (tell) => ask(asked, tell, NAME));
    if (room.sitting() === sitting) take(brought);
  } finally {
    opening = false;
    room.refresh();
  }
}

/** Whether it is being made: nobody needs to ask for it again. */
export const isOpening = () => opening;

/** Back to the figure, from a gallery that is still being made, too. */
export function leave() {
  if (opening || shown) giveUp(obsolete(), [NAME]);
  if (!shown) return;
  shown = report.wall = undefined;
  room.sitting()?.leave_gallery();
  refresh();
}

/** Whether the gallery is shown. */
export const isOpen = () => !!shown;

/** Whether its figures swell now. */
export const swells = () => !!shown && of("wall-swell").checked;

/** Swells the figures as far as they have at a time in milliseconds. */
export function swell(now) {
  if (shown) room.sitting().swell_gallery(swells() ? now / 1000 : undefined);
}

/** Layers of one that was taken go on top. */
async function hang(layers) {
  leave();
  room.sitting().hang(layers);
  await room.changed();
}

const choices = {
  label: "Caricatures: choose those you like, then breed",
  choose: attempt(ofSeen(async (item) => take(await asks("choose", item, !shown.items[item].chosen)))),
  perform: attempt(ofSeen(async (item) => hang((await asks("layers", item)).found))),
  favor: attempt(ofSeen(async (item) => take(await asks("favor", item, !shown.items[item].favorite)))),
  performs: "Take",
  says: (item) => `Take caricature ${item + 1}: it becomes layers`,
  name: (item) => `Caricature ${item + 1}`,
  titled: true,
};

/** Lays the buttons over the picture. */
export function drawWall(width, height) {
  const cells = shown ? [...room.sitting().cells()] : [];
  drawCells(of("cells"), cells, shown?.items ?? [], width, height, choices);
}

/** Hangs others: children, those before, or new ones. */
async function hangOthers(step) {
  stepping = true;
  refresh();
  try { take(await busy("the gallery", () => asks("step", step))); } finally {
    stepping = false;
    refresh();
  }
}

export function listen(caricature) {
  room = caricature;
  on("gallery", () => (shown ? leave() : open()));
  on("wall-close", leave);
  // Whoever asks for less motion begins without.
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const follow = () => { of("wall-swell").checked = !still.matches; };
  still.addEventListener("change", follow);
  follow();
  for (const step of ["breed", "back", "others"]) {
    on(`wall-${step}`, ofSeen(() => hangOthers(step)));
  }
  on("wall-surprise", ofSeen(async () => hang((await busy("a surprise", () => asks("surprise", ++surprises))).found)));
}

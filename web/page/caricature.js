// The caricature room: it shows a sitting, and passes on what a person does. All that deforms is in the module.
import { Sitting, samples, starting_points } from "./chladni_web.js";
import { ask, giveUp, obsolete } from "./work.js";
import { attempt, attemptOf, base, busy, label, numberIn, of, on, options, report, say } from "./page.js";
import { scale, show as showPicture, stir } from "./picture.js";
import * as brought from "./brought.js";
import * as chosen from "./chosen.js";
import * as exports from "./exports.js";
import * as heat from "./heat.js";
import * as ink from "./ink.js";
import { drawNumbers, listLandmarks } from "./landmarks.js";
import { drawModels } from "./models.js";
import * as scaleCurve from "./scale.js";
import * as wall from "./wall.js";
import { PLAIN_HEAD, matchedBefore } from "./plain_head.js";
import { drawLayers, drawParts, offerResults, showLayer } from "./layers.js";

/** Harmonics of a new project; its file says so, and the desktop takes as many. */
const harmonicsOf = (bytes) => ((bytes?.length ?? 0) < 8e6 ? 256 : 128);
/** Milliseconds after which layers are limited where they keep triangles. */
const REST = 700;

let sitting;
let state;
let shape = {};
/** The matches with each file that the shape was asked for, by the file's name. */
const requests = new Map();
/** How often a shape was opened: what was asked for an older one is not wanted any more. */
let opened = 0;
/** The shape that is being matched. */
let matching = 0;
/** Its harmonics are being solved for, as many as were asked for last. */
let solving = false;
let harmonicsAsked;
/** As many as were solved for last. */
let harmonicsSolved;
/** How often parts were asked for. */
let partings = 0;

export const viewer = () => sitting;
export const view = () => JSON.parse(sitting.state());
const stem = () => label(base(state.shape)).replace(/\?.*|\.[^.]*$/g, "");

/** A drawing in ink is shown; tools need the figure itself. */
const isInInk = () => of("ink").checked && held === "turn" && !wall.isOpen() && !state.in_models;
let wasInInk = false;

const room = {
  name: "The shape.",
  // Nothing moves by itself but the gallery.
  get rests() { return !wall.swells(); },
  frame: (now, width, height) => {
    if (!sitting) return false;
    wall.swell(now);
    const inInk = isInInk();
    if (inInk !== wasInInk) { wasInInk = inInk; ink.again(); sitting.redraw(); }
    if (inInk) return ink.inked(sitting, of("tones").checked, now, width, height);
    return sitting.frame(width, height, scale(width));
  },
  pixels: () => sitting.pixels(),
  drawing: () => (isInInk() ? ink.newest() : undefined),
  drawn: (width, height) => {
    if (state.in_models && !wall.isOpen()) drawModels(sitting, state, set, width, height); else wall.drawWall(width, height);
    drawNumbers(held === "landmarks" ? [...sitting.landmark_labels()] : [], width, height);
  },
  byProcessor: () => {
    if (!sitting) return;
    sitting.draw_by_processor();
    // What lay on the card is gone: the gallery, and the shapes with landmarks.
    if (wall.isOpen()) wall.leave();
    refresh();
  },
};

// ---- shapes, matches, projects

export { openProject, takeMesh, waitsFor } from "./brought.js";

/** The project is one of a file: what is changed in it is missed even where no layer is left. */
let isOfFile = false;
/** The name of the file from which it was opened, without its ending. */
let projectStem;

/** Whether there are layers, or changes of a project, that no file has. */
export const isUnsaved = () => !!state?.modified && (state.layers.length > 0 || isOfFile);

/** Whether another shape may take the place of what is not saved; says so, else. */
function mayReplace() {
  const lost = state?.layers.length ? "The layers of this shape" : "The changes of this project";
  if (!isUnsaved() || confirm(`${lost} are not saved. Open another one without them?`)) return true;
  say("The shape has stayed: Save project keeps its layers.");
  refresh();
  return false;
}

/** Opens a shape with its project, by name and text, and the meshes that `came` with that, or with a first layer against one
 * of the starting points. Its harmonics and matches come later. */
async function openShape(name, bytes, project, first, came = []) {
  if (!mayReplace()) return;
  say(`${label(name)}…`);
  // That is to be seen before the page reads the shape.
  await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
  const next = new Sitting(name, bytes, project?.text, harmonicsOf(bytes));
  const mine = ++opened;
  giveUp(obsolete(), ["solve", "match", "gallery"]);
  wall.leave();
  sitting?.free();
  sitting = next;
  isOfFile = project !== undefined;
  projectStem = project?.name.replace(/\.[^.]*$/, "");
  requests.clear();
  brought.forgetIdle(name, JSON.parse(sitting.needs()).templates);
  for (const [each, mesh] of came) brought.files.set(each, mesh);
  empty(false);
  ink.again(true);
  shape = { name, bytes };
  if (first !== undefined) { sitting.begin(first); sitting.mark_saved(); }
  hold("turn");
  refresh();
  attemptOf(label(name), () => Promise.all([solve(mine), match()]));
}

/** Has a worker solve for the harmonics of the shape. */
async function solve(mine) {
  const { name, bytes } = shape;
  const { harmonics, laplacian } = JSON.parse(sitting.needs());
  const asked = { work: "solve", name, bytes: bytes?.slice(), harmonics, laplacian };
  harmonicsAsked = harmonics;
  solving = true;
  refresh();
  try {
    const { basis, secs } = await busy(label(name), (tell) => ask(asked, tell, "solve"));
    sitting.take_harmonics(basis, harmonics);
    harmonicsSolved = harmonics;
    shape.basis = basis;
    report.solveSecs = secs;
    if (!state.parts.length) sitting.find_parts(Number(of("level").value));
    // A small shape has fewer harmonics than it was asked for.
    const { vertices, harmonics: found } = view();
    say(sitting.take_notes() || `${label(name)}: ${vertices} vertices, ${found} harmonics in ${secs.toFixed(1)} s`);
  } catch (error) {
    if (mine !== opened || harmonics !== harmonicsAsked) return;
    // Those that are there stay.
    if (state.solved) {
      harmonicsAsked = harmonicsSolved;
      sitting.restore_harmonics(harmonicsSolved);
      solving = false;
      refresh();
    }
    throw error;
  } finally {
    if (mine === opened && harmonics === harmonicsAsked) { solving = false; refresh(); }
  }
}

/** Solves for other harmonics where the project asks for them. */
async function solveAgain() {
  if (state.wanted_harmonics === harmonicsAsked) return;
  giveUp(obsolete(), ["solve"]);
  wall.leave();
  await solve(opened);
}

/** Has the worker match what layers wait for, one after the other. */
async function match() {
  const mine = opened;
  if (matching === mine) return;
  matching = mine;
  try {
    for (let next; mine === opened && (next = sitting.missing()); refresh()) {
      const { request, template, file } = JSON.parse(next);
      const mesh = file ? brought.files.get(base(template)) : undefined;
      if (file) remember(base(template), request);
      // Another file of its name has come since.
      const isOutdated = () => file && brought.files.get(base(template)) !== mesh;
      if (file && !mesh) { sitting.fail(request, `bring ${base(template)}, too`); continue; }
      try {
        const asked = { work: "match", name: shape.name, bytes: shape.bytes?.slice(), request, template: mesh };
        const before = await matchedBefore(shape.name, template, request);
        const { found, secs } = before ? { found: before, secs: 0 } : await busy(label(base(template)), (tell) => ask(asked, tell, "match"));
        if (mine !== opened) return;
        if (isOutdated()) continue;
        sitting.install(request, found);
        report.matchSecs = secs;
      } catch (error) {
        if (mine !== opened) return;
        if (isOutdated()) continue;
        sitting.fail(request, error.message ?? String(error));
        say(error.message ?? String(error), true);
      }
    }
  } finally {
    if (mine === opened) { matching = 0; refresh(); }
  }
}

function remember(file, request) {
  if (!requests.has(file)) requests.set(file, new Set());
  requests.get(file).add(request);
}

/** Another mesh has come by this name: matches with the one before are forgotten. */
function forgetMatches(name) {
  if (held === "landmarks") hold("turn");
  // Its worker has the matches with the file before.
  if (requests.has(name)) wall.leave();
  for (const request of requests.get(name) ?? []) sitting.forget(request);
  requests.delete(name);
}

// ---- what is done

/** The project has changed by more than its numbers. */
async function changed() {
  refresh();
  await Promise.all([solveAgain(), match()]);
}

let resting;
function refresh() {
  if (!sitting) return;
  state = report.sitting = JSON.parse(sitting.state());
  drawLayers(of("layers"), state, layerChoices);
  offerResults(of("add"), state);
  const layer = state.layers.find(({ id }) => id === state.selected);
  of("undo").disabled = !state.undo;
  of("redo").disabled = !state.redo;
  of("undo").title = state.undo ? `Undo: ${state.undo}` : "Undo";
  of("redo").title = state.redo ? `Redo: ${state.redo}` : "Redo";
  of("one-layer").disabled = of("where").disabled = !layer;
  const option = [...of("sitter").options].find(({ value }) => value === state.shape);
  of("sitter").value = option ? state.shape : "";
  of("sitter").querySelector("[value='']").textContent = option ? "Other…" : state.shape;
  of("solve").hidden = state.solved || solving;
  of("gallery").disabled = !state.solved || solving || wall.isOpening();
  heat.drawHeat(state);
  of("keep").checked = state.keep_triangles;
  of("up").value = state.up;
  of("up-name").textContent = state.up_in_doubt ? "Is this up?" : "Up";
  of("original").setAttribute("aria-pressed", state.bare);
  of("models").setAttribute("aria-pressed", state.in_models);
  of("models").disabled = !layer && !state.in_models;
  of("parts-of").value = state.level === null ? "head" : "form";
  of("level-row").hidden = state.level === null;
  of("pointed").textContent = state.pointed.join(", ");
  drawParts(of("parts"), state.parts, layer?.parts ?? [], partChoices);
  if (layer) showLayer(layer);
  chosen.show(layer);
  if (document.activeElement !== of("wanted-harmonics")) of("wanted-harmonics").value = state.wanted_harmonics;
  scaleCurve.show();
  showLandmarks(layer);
  clearTimeout(resting);
  if (state.keep_triangles && state.solved) resting = setTimeout(attempt(() => {
    sitting.keep_triangles();
    // Fewer are folded now.
    state = report.sitting = JSON.parse(sitting.state());
    drawLayers(of("layers"), state, layerChoices);
  }), REST);
}

function showLandmarks(layer) {
  // The layer is another, or gone.
  if (held === "landmarks" && state.hint === null) hold("turn");
  of("landmarks").disabled = !layer?.has_mesh;
  of("landmarks").setAttribute("aria-pressed", held === "landmarks");
  of("picking").hidden = held !== "landmarks";
  of("landmark-hint").textContent = state.hint ?? "";
  if (layer) listLandmarks(layer.landmarks, attempt((index) => { sitting.remove_landmark(index); return changed(); }));
}

/** Begins to pick landmarks on the chosen layer, or ends it. */
function pickLandmarks() {
  if (held === "landmarks") { hold("turn"); return refresh(); }
  wall.leave();
  const { template } = state.layers.find(({ id }) => id === state.selected);
  sitting.begin_landmarks(brought.files.get(base(template))?.slice());
  hold("landmarks");
  refresh();
}

/** Shows the figure again where the gallery covers it; gives whether it was seen. */
function uncover() {
  if (!wall.isOpen()) return true;
  wall.leave();
  return false;
}

/** Does an action at once. */
const act = attempt((action) => { stir(); sitting.act(JSON.stringify(action)); return changed(); });
const set = (to, layer = state.selected) => act({ set: { layer, to } });
const paint = (edit) => act({ paint: { layer: state.selected, edit } });

const layerChoices = {
  select: attempt(({ id }) => { sitting.select(id); refresh(); }),
  enable: ({ id }, enabled) => set({ enabled }, id),
  move: ({ id }, by) => act({ move: { layer: id, index: state.layers.findIndex((layer) => layer.id === id) + by } }),
  remove: ({ id }) => act({ remove: id }),
  retry: attempt(({ id }) => { sitting.select(id); sitting.retry(); return changed(); }),
};
const partChoices = {
  point: attempt((part) => { sitting.point_at_part(part); }),
  toggle: attempt((part, taken) => {
    const layer = state.layers.find(({ id }) => id === state.selected);
    sitting.point_at_part(part);
    sitting.take_part(!layer.everywhere, taken);
    return changed();
  }),
};

/** Follows a slider, once a picture; what it did is one step. */
function slide(id, to) {
  let asked;
  of(id).addEventListener("input", () => {
    if (!asked) requestAnimationFrame(attempt(() => {
      asked = false;
      stir();
      sitting.drag(JSON.stringify({ set: { layer: state.selected, to: to(Number(of(id).value)) } }));
      refresh();
    }));
    asked = true;
  });
  of(id).addEventListener("change", () => requestAnimationFrame(attempt(() => { sitting.finish(); refresh(); })));
}

// ---- tools

let held = "turn";
function hold(tool) {
  held = tool;
  if (tool === "brush" && state && !state.solved) say("The brush waits until the shape is solved.");
  if (tool !== "landmarks") sitting?.leave_landmarks();
  // Tools work on the result.
  if (tool !== "turn" && state?.in_models) sitting.show_models(false);
  sitting?.hold(tool === "landmarks" ? "turn" : tool);
  for (const name of ["turn", "parts", "brush"]) of(`hold-${name}`).setAttribute("aria-pressed", name === tool);
  for (const tools of document.querySelectorAll("[data-tool]")) tools.hidden = tools.dataset.tool !== tool;
  of("picture").style.cursor = tool === "turn" ? "grab" : "crosshair";
  takeBrush();
}
const takeBrush = () => {
  const numbers = ["brush-size", "brush-hardness", "brush-intensity"].map((id) => Number(of(id).value));
  const switches = ["erase", "both-sides", "fill"].map((id) => of(id).checked);
  sitting?.set_brush(...numbers, ...switches);
};

/** What a pointer does on the figure. */
export const tool = {
  hover: attempt((x, y) => {
    if (held === "turn" || held === "landmarks" || wall.isOpen()) return;
    stir();
    sitting.point(x, y);
    if (held === "parts") of("pointed").textContent = JSON.parse(sitting.state()).pointed.join(", ");
  }),
  /** A press with the right button is the tool's. */
  takesMenu: () => held === "landmarks",
  leave: attempt(() => { if (held === "parts" || held === "brush") { sitting.point_nowhere(); of("pointed").textContent = ""; } }),
  grabs: (x, y) => {
    if (wall.isOpen()) return false;
    if (held === "landmarks") return sitting.hold_landmark(x, y, scale());
    return held === "brush" && state.solved && !!state.layers.length && sitting.point(x, y);
  },
  paints: () => held === "brush",
  stroke: attempt((x, y) => { stir(); if (held === "landmarks") sitting.move_landmark(x, y); else sitting.press(x, y); }),
  release: attempt(() => {
    if (held === "landmarks") { sitting.drop_landmark(); return changed(); }
    sitting.finish();
    return refresh();
  }),
  click: attempt((x, y, event) => {
    if (wall.isOpen()) return undefined;
    if (held === "landmarks") {
      if (event.button === 2) sitting.remove_landmark_near(x, y, scale()); else sitting.pick_landmark(x, y);
      return changed();
    }
    if (held !== "parts" || event.button !== 0 || !state.layers.length) return undefined;
    sitting.point(x, y);
    sitting.take_part(event.shiftKey || of("add-part").checked, event.ctrlKey);
    return refresh();
  }),
};

// ---- the room

export function open() {
  showPicture(room);
  if (sitting) {
    // The other room's picture is still there.
    ink.again();
    sitting.redraw();
    return;
  }
  // A project waits for its mesh: there is nothing to work on yet, but something to open.
  empty(true);
  wall.drawWall(1, 1);
}

/** Whether there is no shape: what needs one rests, and the picture of the other room is not seen. */
function empty(isSo) {
  document.body.toggleAttribute("data-empty", isSo);
  if (isSo) of("sitter").value = "";
  for (const child of of("bench").children) child.inert = isSo && !child.querySelector("#sitter, #open-project");
  for (const id of ["undo", "redo", "save-project"]) of(id).inert = isSo;
}

/** A mask was brought; `enter()` shows the room for one that can be used. */
export async function takeMask(name, bytes, enter) {
  if (!sitting) throw new Error(`${name}: a mask is the region of a layer: choose a shape first, or open one.`);
  return exports.takeMask(name, bytes, enter);
}

/** The sample head, compared with a plain one. */
export async function begin() {
  if (sitting) return refresh();
  await openShape("sample:head", undefined, undefined, PLAIN_HEAD);
}

export function listen() {
  const heads = JSON.parse(samples()).map(([name]) => name).sort((a, b) => ["head", "template"].includes(b) - ["head", "template"].includes(a));
  of("sitter").append(...options(heads, (name) => `sample:${name}`), new Option("Other…", ""));
  of("sitter").addEventListener("change", attempt(() => {
    const name = of("sitter").value;
    if (name) return openShape(name);
    // Until a file has been chosen, the shape is the one that is there.
    refresh();
    return of("file").click();
  }));
  const points = JSON.parse(starting_points());
  of("add").append(...points.map(([name, tip], i) => Object.assign(new Option(name, i), { title: tip })), new Option("A mesh…", "mesh"));
  of("add").addEventListener("change", attempt(async () => {
    const { value } = of("add");
    of("add").value = "";
    if (value === "mesh") return of("file").click();
    if (value.startsWith("layer:")) sitting.compare_with_layer(Number(value.slice(6)));
    else sitting.begin(Number(value));
    return changed();
  }));
  on("solve", () => solve(opened));
  on("undo", () => { const label = sitting.undo(); if (label) say(`Undone: ${label}`); return changed(); });
  on("redo", () => { const label = sitting.redo(); if (label) say(`Done again: ${label}`); return changed(); });
  addEventListener("keydown", attempt((event) => {
    if (document.body.dataset.view !== "caricature" || !sitting || !(event.ctrlKey || event.metaKey)) return;
    const key = event.key.toLowerCase();
    if (!["z", "y"].includes(key)) return;
    // There it is the text's own.
    if (event.target.closest("input[type=text], input[type=number], dialog")) return;
    event.preventDefault();
    if (event.shiftKey || key === "y") sitting.redo(); else sitting.undo();
    return changed();
  }));
  slide("mu", (mu) => ({ mu }));
  slide("strength", (strength) => ({ strength }));
  slide("softness", (log) => {
    const { smoothing } = state.layers.find(({ id }) => id === state.selected);
    return { smoothing: { ...smoothing, wavelength: Math.exp(log) } };
  });
  of("model").addEventListener("change", () => set({ model: of("model").value }));
  of("curve").addEventListener("change", attempt(() => { sitting.set_curve(state.selected, of("curve").value); return changed(); }));
  for (const name of ["turn", "parts", "brush"]) on(`hold-${name}`, () => { hold(name); refresh(); });
  for (const id of ["brush-size", "brush-hardness", "brush-intensity", "erase", "both-sides", "fill"]) of(id).addEventListener("change", takeBrush);
  on("everywhere", () => paint({ set: "everywhere" }));
  on("invert", () => paint("invert"));
  of("parts-of").addEventListener("change", attempt(findParts));
  of("level").addEventListener("change", attempt(findPartsByForm));
  of("keep").addEventListener("change", () => act({ keep_triangles: of("keep").checked }));
  of("up").addEventListener("change", attempt(() => { sitting.stand(of("up").value); return changed(); }));
  for (const from of ["front", "portrait", "right"]) on(`look-${from}`, () => sitting.look(from));
  on("models", () => {
    const isShown = uncover();
    hold("turn");
    sitting.show_models(!isShown || !state.in_models);
    refresh();
  });
  on("original", () => {
    const isShown = uncover() && !state.in_models;
    if (state.in_models) sitting.show_models(false);
    sitting.show_original(!isShown || !state.bare);
    refresh();
  });
  heat.listen((quantity, harmonic, map) => { sitting.show_heat(quantity, harmonic, map); refresh(); });
  on("landmarks", pickLandmarks);
  for (const id of ["ink", "tones"]) of(id).addEventListener("change", () => { of("tones-row").hidden = !of("ink").checked; if (of("ink").checked) hold("turn"); refresh(); });
  const wantedHarmonics = of("wanted-harmonics");
  wantedHarmonics.addEventListener("change", () => {
    const count = numberIn(wantedHarmonics) || state.wanted_harmonics;
    wantedHarmonics.value = count;
    return act({ set_harmonics: count });
  });
  const saved = () => { isOfFile = true; refresh(); };
  const caricature = { sitting: () => sitting, shape: () => shape, stem, projectStem: () => projectStem ?? stem(), refresh, saved, changed, act, set, slide, isInInk };
  brought.listen({ ...caricature, state: () => state, openShape, forgetMatches });
  chosen.listen(caricature);
  exports.listen(caricature);
  scaleCurve.listen(caricature);
  wall.listen(caricature);
  hold("turn");
}

function findPartsByForm() {
  partings++;
  sitting.find_parts(Number(of("level").value));
  refresh();
}

async function findParts() {
  if (of("parts-of").value === "form") return findPartsByForm();
  const mine = ++partings;
  try {
    const asked = { work: "parts", name: shape.name, bytes: shape.bytes?.slice() };
    const { parts } = await busy(label(shape.name), (tell) => ask(asked, tell, "match"));
    // Others were asked for meanwhile.
    if (mine !== partings) return;
    if (parts) sitting.take_parts_of_head(parts);
    if (!parts) say(`${shape.name} does not look like a head: its parts are found by their form.`);
  } catch (error) {
    if (mine === partings) throw error;
  } finally { refresh(); }
}

// Meshes that were brought, by their names: shapes and templates; and a project that waits for its shape.
import { needs_of_project } from "./chladni_web.js";
import { attemptOf, base, of, say } from "./page.js";

/** The caricature room: its `sitting()`, `state()`, `shape()`, `openShape()`, `changed()` and `forgetMatches()`. */
let room;
/** What was brought, by name: shapes and templates. */
export const files = new Map();
/** A project that waits for its shape, and the templates that it names besides. */
let waiting;

/** Whether a project waits for the mesh of this name, or will need it as a template. */
export const waitsFor = (name) => waiting?.shape === name || !!waiting?.templates.includes(name);

/** How many bytes of meshes are kept that neither the open shape nor a project that waits needs: a project may name them. */
const IDLE_BYTES = 2 ** 27;

/** Forgets such meshes, the oldest first, where they are large together. The open shape has this name, and these
 * templates. */
export function forgetIdle(name, templates) {
  const needed = new Set([base(name), ...templates.map(base), ...(waiting?.templates ?? [])]);
  const idle = [...files].filter(([each]) => !needed.has(each));
  let bytes = idle.reduce((sum, [, mesh]) => sum + mesh.length, 0);
  for (const [each, mesh] of idle) {
    if (bytes <= IDLE_BYTES) return;
    files.delete(each);
    bytes -= mesh.length;
  }
}

/** Whether two files hold the same bytes. */
const areSame = (one, other) => one?.length === other?.length && one.every((byte, i) => byte === other[i]);

/** Keeps a mesh by its name. Where another one had that name, matches with it are forgotten. Gives whether layers are
 * compared with what is another file now. */
function keep(name, bytes) {
  const before = files.get(name);
  files.set(name, bytes);
  if (!room.sitting() || !before || areSame(before, bytes)) return false;
  room.forgetMatches(name);
  return comparedWith(name).length > 0;
}

/** The layers that are compared with this file. */
const comparedWith = (name) => room.state()?.layers.filter(({ template }) => base(template) === name) ?? [];

/** Takes landmarks from the layers that are compared with this file, which is another one now: they are vertices of
 * the one before. Gives whether there were any. */
function dropLandmarks(name) {
  const sitting = room.sitting();
  const { selected } = room.state();
  const marked = comparedWith(name).filter(({ landmarks }) => landmarks.length);
  for (const { id } of marked) { sitting.select(id); sitting.open_landmarks(""); }
  if (marked.length && selected !== null) sitting.select(selected);
  return marked.length > 0;
}

/** The page knows a file by its name alone: a project may not name two files of one name. */
function refuseNamesakes(name, paths) {
  const names = [...new Set(paths)].map(base);
  const twice = names.find((each, i) => names.indexOf(each) < i);
  if (twice) throw new Error(`${name} names two meshes that are both called ${twice}: a page knows files by their names alone; rename one.`);
}

/** Opens the text of a project, once its shape is there. What it names of the meshes `beside` it, by their names, it takes
 * out of them; they come before others of their names. One that can be read calls `enter()`. */
export async function openProject(name, bytes, beside = new Map(), enter = () => {}) {
  const text = new TextDecoder().decode(bytes);
  const needs = JSON.parse(needs_of_project(name, text));
  refuseNamesakes(name, [needs.shape, ...needs.templates]);
  enter();
  const shapeName = base(needs.shape);
  const brought = needs.file ? beside.get(shapeName) ?? files.get(shapeName) : undefined;
  if (needs.file && !brought) {
    waiting = { name, bytes, shape: shapeName, templates: needs.templates.map(base) };
    return say(`${name} is made on ${shapeName}: bring that mesh, too.`, false, 600);
  }
  waiting = undefined;
  const named = new Set([shapeName, ...needs.templates.map(base)]);
  const came = [...beside].filter(([each]) => named.has(each));
  for (const [each] of came) beside.delete(each);
  await room.openShape(needs.shape, brought, { name, text }, undefined, came);
}

/** A mesh was brought: the shape of a project that waits, a template that a layer or such a project waits for, or, as the
 * user says, one of both. */
export async function takeMesh(name, bytes) {
  const isNew = !files.has(name);
  const isOther = keep(name, bytes);
  const without = isOther && dropLandmarks(name) ? ", without their landmarks" : "";
  const matchAnew = () => { attemptOf(name, room.changed); };
  if (waiting?.shape === name) {
    await openProject(waiting.name, waiting.bytes);
    // Where the shape has stayed, its layers are matched anew.
    return isOther ? matchAnew() : undefined;
  }
  const wanting = comparedWith(name).filter((layer) => layer.state === "failed");
  for (const layer of wanting) { room.sitting().select(layer.id); room.sitting().retry(); }
  if (isOther) say(`${name} is another file now: the layers that are compared with it are matched anew${without}.`);
  if (wanting.length || isOther) return matchAnew();
  if (waitsFor(name)) return say(`${name} is kept for ${waiting.name}, which is made on ${waiting.shape}: bring that mesh, too.`, false, 600);
  // Its turn among the matches has not come.
  if (isNew && comparedWith(name).length) return say(`${name} is kept for the layers that are compared with it.`);
  try {
    switch (room.sitting() ? await whichOf(name) : "shape") {
      case "shape": await room.openShape(name, bytes); return undefined;
      case "template":
        // A project would name both by the same name, and take the shape for its template.
        if (isNamesake(name, bytes)) {
          throw new Error(`${name} has the name of the shape, and a page knows files by their names alone: rename one.`);
        }
        // Another shape may have been opened since the question.
        files.set(name, bytes);
        room.sitting().compare(name);
        return matchAnew();
      default: return undefined;
    }
  } finally { keepShape(name); }
}

/** Whether another mesh than the shape has its name. */
function isNamesake(name, bytes) {
  const shape = room.shape();
  return name === base(shape.name) && !areSame(shape.bytes, bytes);
}

/** Where the shape has stayed, a mesh of its name was not taken: the name is the shape's. */
function keepShape(name) {
  if (room.sitting() && isNamesake(name, files.get(name))) files.set(name, room.shape().bytes);
}

/** The last question: each waits for the answer to the one before. */
let question = Promise.resolve();

/** What is to become of a mesh. */
function whichOf(name) {
  const dialog = of("which");
  question = question.then(() => new Promise((done) => {
    // The room may have been left while another question waited.
    if (document.body.dataset.view !== "caricature") return done("");
    of("which-name").textContent = name;
    dialog.returnValue = "";
    dialog.onclose = () => done(dialog.returnValue);
    dialog.showModal();
  }));
  return question;
}

export function listen(caricature) {
  room = caricature;
}

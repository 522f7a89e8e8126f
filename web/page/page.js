// What both rooms share: elements, messages, downloads.

export const of = (id) => document.getElementById(id);

/** Whether a key comes with Ctrl, ⌘ or Alt: it is the browser's or the system's. */
export const hasModifier = (event) => event.ctrlKey || event.metaKey || event.altKey;

/** How long an error can be read. */
const ERROR_SECS = 20;

/** What workers do now, in words, and how far they are. */
const working = new Map();
const shares = new Map();
/** What went wrong last, and the time until which it can be read. */
let failed;
let saying;
/** What is said from then on, once the page's module has stopped in the middle of its work. */
const STOPPED = "The page has stopped (no memory, or a bug): open it again. What was not saved is lost.";
let hasStopped = false;

/** Says something in the line at the top, for so long; nothing leaves an error there, and what workers do. */
export function say(text, bad = false, secs = 8) {
  if (bad) failed = { text, until: performance.now() + 1000 * ERROR_SECS };
  else if (text) failed = undefined;
  if (text) write(text, bad ? ERROR_SECS : secs); else settle();
}

function write(text, secs) {
  // What is said already is not read aloud again.
  setText(of("status"), hasStopped ? STOPPED : text);
  of("status").classList.toggle("bad", hasStopped || !!failed);
  clearTimeout(saying);
  if (text) saying = setTimeout(settle, 1000 * secs);
}

/** Says what is left to be read: an error, the news, and what workers do. */
function settle(news) {
  const left = failed ? (failed.until - performance.now()) / 1000 : 0;
  if (left <= 0) failed = undefined;
  const text = [failed?.text, news, ...working.values()].filter(Boolean).join(" · ");
  write(text, news ? 20 : failed ? left : 600);
}

/** The page's module has stopped, so that nothing is to be asked of it any more. */
export const isStopped = () => hasStopped;

/** Whether it has stopped by this error, or earlier; says so. */
export function stops(error) {
  if (error instanceof WebAssembly.RuntimeError && !hasStopped) {
    hasStopped = true;
    settle();
  }
  return hasStopped;
}

addEventListener("error", ({ error }) => { stops(error); });

/** Does it, and says what went wrong. */
export const attempt = (act) => async (...args) => {
  try { return await act(...args); } catch (error) {
    // Whoever asked wants something else by now.
    if (!stops(error) && error.name !== "ObsoleteError") say(error.message ?? String(error), true);
    return undefined;
  }
};

/** Why a file cannot be read, where a browser's own words help nobody. A folder has no content to be read, either. */
const UNREADABLE = {
  NotFoundError: "it was moved or deleted, or is a folder.",
  NotReadableError: "it has changed since it was chosen, or another program holds it. Open it again.",
};

/** An error that says which file it is of. */
export function ofFile(name, error) {
  const why = error.message ?? String(error);
  if (stops(error) || ["AbortError", "ObsoleteError"].includes(error.name) || why.includes(name)) return error;
  const known = UNREADABLE[error.name];
  return new Error(known ? `${name} cannot be read: ${known}` : `${name}: ${why}`);
}

/** Does what a file, or a shape of this name, needs, and says of it what went wrong. */
export const attemptOf = (name, act) => attempt(async () => {
  try { return await act(); } catch (error) { throw ofFile(name, error); }
})();

/** What workers have done, where that is said, and what they have warned of. */
let remarks = [];

/** Does what a worker is asked for, which may be cancelled meanwhile. What is said of it is said of `what`: `work` gets
 * what the worker reports to. Its remarks are said in the end. */
export async function busy(what, work) {
  const job = Symbol(what);
  const tell = (kind, text) => {
    if (kind === "warning") return remarks.push(text);
    if (kind === "said") return remarks.unshift(text);
    // Not in the line that is read aloud.
    if (kind === "progress") return showShare(job, text);
    working.set(job, `${what}: ${text}…`);
    showShare(job);
    settle();
  };
  working.set(job, `${what}…`);
  of("cancel").hidden = false;
  try { return await work(tell); } finally {
    working.delete(job);
    showShare(job);
    of("cancel").hidden = working.size === 0;
    if (!working.size) {
      settle(remarks.join(" "));
      remarks = [];
    }
  }
}

/** Shows how far a job is, or that it is not known. */
function showShare(job, text) {
  if (text) shares.set(job, text); else shares.delete(job);
  of("progress").textContent = [...shares.values()].join(" · ");
}

/** A file's name without its folders, its accents composed: a Mac may write them apart. */
export const base = (path) => path.split(/[\\/]/).at(-1).normalize();

/** A shape as people call it. */
export const label = (name) => name.replace("sample:", "");

export const on = (id, act) => of(id).addEventListener("click", attempt(act));

/** The whole number in a field, within its bounds; 0 where there is none. Browsers hold keys to no bounds. */
export function numberIn({ value, min, max }) {
  const number = Math.round(Number(value));
  return number && Math.min(Math.max(number, Number(min)), Number(max));
}

export const capitalized = (name) => name[0].toUpperCase() + name.slice(1);

export const options = (names, value) => names.map((name) => new Option(capitalized(name), value(name)));

/** Writes a text where it is another than before, so that what a browser has translated stays. */
export function setText(place, text) {
  if (place.dataset.text !== String(text)) place.textContent = place.dataset.text = text;
}

/** A new element with these properties and children. */
export function element(tag, properties, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/** The row of a knob: its label, which holds its name, a slider over `range`, and the place of its value. */
export function knobRow(name, title, range) {
  const slider = element("input", { type: "range", ...range, title });
  const output = element("output", {});
  return { slider, output, label: element("label", { className: "knob", title }, name, slider, output) };
}

/** Where a button of the mouse is down, and what waits for it: a control that is replaced before the button comes up gets no
 * click. The press itself may be the cause, where it leaves a field. */
let pressed;
const waiting = new Map();

addEventListener("mousedown", ({ target }) => { pressed = target; }, true);
addEventListener("click", letGo);
// Where no click comes, as at the end of a drag.
for (const end of ["mouseup", "dragend", "contextmenu"]) addEventListener(end, () => setTimeout(letGo), true);

function letGo() {
  pressed = undefined;
  for (const [parent, children] of [...waiting]) refill(parent, children);
}

/** Puts `children` in place of those of an element, once none of these is pressed. What had the focus has it again: who has
 * the same `data-key`. Else, in the row that has come to its place, who has the same last word of it, or the first button.
 * Where there is no row, the control that the element names as `data-otherwise`. */
export function refill(parent, children) {
  if (pressed && parent.contains(pressed)) return waiting.set(parent, children);
  waiting.delete(parent);
  const focused = document.activeElement;
  const held = parent.contains(focused) ? focused.dataset.key : undefined;
  const row = [...parent.children].findIndex((child) => child.contains(focused));
  parent.replaceChildren(...children);
  if (!held) return;
  const there = children[Math.min(row, children.length - 1)];
  const again = parent.querySelector(`[data-key="${CSS.escape(held)}"]`)
    ?? there?.querySelector(`[data-key$=" ${CSS.escape(held.split(" ").at(-1))}"]`)
    ?? there?.querySelector("button")
    ?? document.getElementById(parent.dataset.otherwise);
  again?.focus();
}

/** How long a browser may take to fetch what it saves: some ask first. */
const SAVING_SECS = 120;

/** Downloads a file. */
export function save(name, content, type = "text/plain") {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000 * SAVING_SECS);
  say(`${name} goes to your downloads.`);
}

/** What tests and benchmarks read. */
export const report = (window.chladni = { frames: 0, drawMs: 0 });

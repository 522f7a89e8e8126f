// What both rooms share: elements, messages, downloads.

export const of = (id) => document.getElementById(id);

let saying;
/** Says something in the line at the top, for so long. */
export function say(text, bad = false, secs = 8) {
  of("status").textContent = text;
  of("status").classList.toggle("bad", bad);
  clearTimeout(saying);
  if (text) saying = setTimeout(() => say(""), 1000 * (bad ? 20 : secs));
}

/** Says what the worker reports of its work on something. */
export const told_by = (what) => (kind, text) => say(kind === "warning" ? text : `${what}: ${text}…`, false, 600);

/** Does it, and says what went wrong. */
export const attempt = (act) => async (...args) => {
  try { await act(...args); } catch (error) { say(error.message ?? String(error), true); }
};

let working = 0;
/** Does what a worker is asked for, which may be cancelled meanwhile. */
export async function busy(work) {
  working += 1;
  of("cancel").hidden = false;
  try { return await work(); } finally { of("cancel").hidden = --working === 0; }
}

export const on = (id, act) => of(id).addEventListener("click", attempt(act));

export const options = (names, value) => names.map((name) => new Option(name[0].toUpperCase() + name.slice(1), value(name)));

/** Downloads a file. */
export function save(name, content, type = "text/plain") {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  say(`${name} is among your downloads.`);
}

/** What tests and benchmarks read. */
export const report = (window.chladni = { frames: 0, drawMs: 0 });

// Asks a worker. There may be several, each of which does one thing at a time; what is asked can be given up.
import { BUILD } from "./built.js";
import { compile, cores, shared } from "./threads.js";

/** The module, compiled once for the page and all workers of one thread. */
export const compiled = compile("chladni_web_bg.wasm");
compiled.catch(() => { /* Whoever waits for it says so. */ });

/** Workers that have one thread in any case: a song is decoded from its beginning to its end, and ink is drawn while the
 * page draws, too. */
const ALONE = ["song", "ahead", "ink"];
/** Workers that know nothing of what they did before, and end once they have grown beyond so many bytes: no memory of a
 * module ever shrinks. */
const [FORGETFUL, MOST_BYTES] = [["song", "ahead", "work"], 128 << 20];
/** Bytes of a thread's stack, as on the desktop. */
const STACK = 2 << 20;

/** Those that have been started, each with its threads, by their names. */
const workers = new Map();
const waiting = new Map();
let next = 0;

/** A worker has ended by itself, which says nothing of what it was asked for. */
const stoppedBy = (why) => (
  Object.assign(new Error(`The work stopped: ${why || "not enough memory?"}`), { name: "StoppedError" }));

/** A worker, or a thread of it. */
function open(file, name) {
  const worker = new Worker(file, { type: "module", name });
  const stopped = (why) => giveUp(stoppedBy(why), [name]);
  worker.onmessage = ({ data }) => {
    if (data.kind === "broken") return workers.get(name)?.includes(worker) && stopped(data.text);
    const asked = waiting.get(data.id);
    if (!asked) return;
    if (data.kind === "done") {
      waiting.delete(data.id);
      asked.resolve(data);
      if (FORGETFUL.includes(name) && data.memoryBytes > MOST_BYTES && !works(name)) giveUp(obsolete(), [name]);
    }
    else if (data.kind === "failed") { waiting.delete(data.id); asked.reject(new Error(data.text)); }
    else asked.report(data.kind, data.text);
  };
  // Only an error of its code has a message.
  worker.onerror = (event) => stopped(event.message ?? "a part of the page could not be fetched.");
  return worker;
}

/** Has a worker begin, beside it as many threads as there are cores. */
async function begin(name, group) {
  const [worker] = group;
  const together = cores > 1 && !ALONE.includes(name) && await shared();
  if (!together) return worker.postMessage({ start: { module_or_path: await compiled, threads: 1, build: BUILD } });
  // It was given up meanwhile.
  if (workers.get(name) !== group) return undefined;
  const start = { module_or_path: together.module, memory: together.memory, thread_stack_size: STACK };
  worker.postMessage({ start: { ...start, threads: cores, build: BUILD } });
  while (group.length < cores) group.push(open("thread.js", name));
  for (const thread of group.slice(1)) thread.postMessage(start);
  return undefined;
}

function start(name) {
  const group = [open("worker.js", name)];
  workers.set(name, group);
  begin(name, group).catch((error) => giveUp(error, [name]));
  return group;
}

/** Whether there is a worker of this name, with what it knows. */
export const runs = (name) => workers.has(name);

/** Whether a worker of this name does something now. */
export const works = (name) => [...waiting.values()].some((asked) => asked.name === name);

/** What was asked for is not wanted any more: as an error that nobody needs to read. */
export const obsolete = () => new DOMException("something else is wanted", "ObsoleteError");

/** Ends what the workers of these names, or all that do something, work on; whoever waits for it gets `why`. */
export function giveUp(why = new DOMException("Cancelled", "AbortError"), names = [...waiting.values()].map(({ name }) => name)) {
  for (const name of names) {
    workers.get(name)?.forEach((worker) => worker.terminate());
    workers.delete(name);
  }
  for (const [id, asked] of [...waiting].filter(([, asked]) => names.includes(asked.name))) {
    waiting.delete(id);
    asked.reject(why);
  }
}

/** `report` gets ("step", "progress" or "warning", text). `bytes` are given away. Workers of other names work beside each
 * other. */
export function ask(request, report = () => {}, name = "work") {
  const [worker] = workers.get(name) ?? start(name);
  const id = next++;
  return new Promise((resolve, reject) => {
    waiting.set(id, { resolve, reject, report, name });
    worker.postMessage({ id, ...request }, request.bytes ? [request.bytes.buffer] : []);
  });
}

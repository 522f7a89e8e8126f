// Asks a worker. There may be several, each of which does one thing at a time; what is asked can be given up.

const MODULE = "chladni_web_bg.wasm";

/** The module, compiled once for the page and all workers. Not every server says what it is. */
export const compiled = WebAssembly.compileStreaming(fetch(MODULE))
  .catch(async () => WebAssembly.compile(await (await fetch(MODULE)).arrayBuffer()));
compiled.catch(() => { /* Whoever waits for it says so. */ });

/** Those that have been started, by their names. */
const workers = new Map();
const waiting = new Map();
let next = 0;

function start(name) {
  const worker = new Worker("worker.js", { type: "module", name });
  worker.onmessage = ({ data }) => {
    const asked = waiting.get(data.id);
    if (!asked) return;
    if (data.kind === "done") { waiting.delete(data.id); asked.resolve(data); }
    else if (data.kind === "failed") { waiting.delete(data.id); asked.reject(new Error(data.text)); }
    else asked.report(data.kind, data.text);
  };
  worker.onerror = (event) => giveUp(new Error(`The work stopped: ${event.message ?? "not enough memory?"}`), [name]);
  compiled.then((module) => worker.postMessage({ module }));
  workers.set(name, worker);
  return worker;
}

/** Ends what the workers of these names, or all of them, work on; whoever waits for it gets `why`. */
export function giveUp(why = new DOMException("Cancelled", "AbortError"), names = [...workers.keys()]) {
  for (const name of names) {
    workers.get(name)?.terminate();
    workers.delete(name);
  }
  for (const [id, asked] of [...waiting].filter(([, asked]) => names.includes(asked.name))) {
    waiting.delete(id);
    asked.reject(why);
  }
}

/** `report` gets ("step" or "warning", text). `bytes` are given away. Workers of other names work beside each other. */
export function ask(request, report = () => {}, name = "work") {
  const worker = workers.get(name) ?? start(name);
  const id = next++;
  return new Promise((resolve, reject) => {
    waiting.set(id, { resolve, reject, report, name });
    worker.postMessage({ id, ...request }, request.bytes ? [request.bytes.buffer] : []);
  });
}

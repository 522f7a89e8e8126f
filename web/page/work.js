// Asks the worker, one thing at a time; what is asked can be given up.

let worker;
let waiting = new Map();
let next = 0;

function start() {
  worker = new Worker("worker.js", { type: "module" });
  worker.onmessage = ({ data }) => {
    const asked = waiting.get(data.id);
    if (!asked) return;
    if (data.kind === "done") { waiting.delete(data.id); asked.resolve(data); }
    else if (data.kind === "failed") { waiting.delete(data.id); asked.reject(new Error(data.text)); }
    else asked.report(data.kind, data.text);
  };
  worker.onerror = (event) => giveUp(new Error(`The work stopped: ${event.message ?? "not enough memory?"}`));
}

/** Ends what is being worked on; whoever waits for it gets `why`. */
export function giveUp(why = new Error("Cancelled")) {
  worker?.terminate();
  worker = undefined;
  const all = waiting;
  waiting = new Map();
  for (const asked of all.values()) asked.reject(why);
}

/** `report` gets ("step" or "warning", text). `bytes` are given away. */
export function ask(request, report = () => {}) {
  if (!worker) start();
  const id = next++;
  return new Promise((resolve, reject) => {
    waiting.set(id, { resolve, reject, report });
    worker.postMessage({ id, ...request }, request.bytes ? [request.bytes.buffer] : []);
  });
}

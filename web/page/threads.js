// How many cores the slow work is done on. More than one need a module of their own, and a memory that several workers
// share, which browsers lend only to pages that are isolated from all others: by headers that the server sends, or that
// offline.js adds from the second opening on.
import { THREADED } from "./built.js";
import { say } from "./page.js";

const FILES = ["thread.js", "chladni_threads.js", "chladni_threads_bg.wasm"];
const PAGE_BYTES = 65536;
/** More than the module asks for at first (scripts/web). */
const FIRST_PAGES = (64 << 20) / PAGE_BYTES;
/** The most that a module can address, and less, for browsers that set all of it aside at once. */
const MOST_PAGES = [65536, 32768, 16384];

const all = navigator.hardwareConcurrency ?? 1;
const isBuilt = THREADED && all > 1;
/** Whether offline.js can isolate the page. */
const canIsolate = isBuilt && "serviceWorker" in navigator && window.crossOriginIsolated === false && window === window.top;

export const cores = isBuilt && window.crossOriginIsolated ? all : 1;

/** What has to be kept for work on several cores without a connection. */
export const threadFiles = cores > 1 || canIsolate ? FILES : [];

/** A module, compiled. Not every server says what it is. */
export const compile = (file) => WebAssembly.compileStreaming(fetch(file))
  .catch(async () => WebAssembly.compile(await (await fetch(file)).arrayBuffer()));

function sharedMemory() {
  for (const maximum of MOST_PAGES) {
    try { return new WebAssembly.Memory({ initial: FIRST_PAGES, maximum, shared: true }); } catch { /* Then less. */ }
  }
  throw new Error("the browser lends no memory that workers share");
}

let compiling;

/** What the workers of one piece of work begin with. Where that cannot be, they are told so: nothing, and one core. */
export async function shared() {
  try {
    compiling ??= compile("chladni_threads_bg.wasm").catch((error) => {
      // The next worker tries again.
      compiling = undefined;
      throw error;
    });
    return { module: await compiling, memory: sharedMemory() };
  } catch (error) {
    say(`This works on one core only (${error.message ?? error}).`, true);
    return undefined;
  }
}

let mayIsolate = canIsolate;

/** Says it where the page says who draws. */
export function tellCores() {
  const text = cores > 1 ? `Solves on ${cores} cores.`
    : mayIsolate ? `Solves on one core, and on ${all} once the page is opened again.` : "Solves on one core.";
  for (const place of document.querySelectorAll(".solved-by")) place.textContent = text;
}

/** The browser does not let offline.js keep the page. */
export function notKept() {
  mayIsolate = false;
  tellCores();
}

// Many threads, where the page is isolated: as a server makes it, or offline.js from the second opening on.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { ISOLATED, serve, torus } from "../browser.mjs";
import { acts } from "./caricature.mjs";
import { address, folder, opened, step, until } from "./driver.mjs";

const VIEWPORT = { width: 1000, height: 700 };
const mesh = torus(60, 30).toString();

/** The first harmonics of a torus, as the page's worker finds them, and on how many threads. */
const solved = (page) => page.evaluate(async (mesh) => {
  const { ask } = await import("./work.js");
  const bytes = new TextEncoder().encode(mesh);
  const { basis, threads } = await ask({ work: "solve", name: "torus.obj", bytes, harmonics: 100, laplacian: "delaunay" }, undefined, "solve");
  const length = new DataView(basis.buffer).getUint32(0, true);
  const { eigenvalues } = JSON.parse(new TextDecoder().decode(basis.slice(4, 4 + length)));
  return { eigenvalues, threads };
}, mesh);

const said = (page) => page.textContent(".solved-by");
const isolated = (page) => page.evaluate(() => window.crossOriginIsolated);
const cores = (page) => page.evaluate(() => navigator.hardwareConcurrency);

/** The work is done on all cores, and finds what one finds. */
async function onAll(page, alone) {
  assert.ok(await isolated(page));
  const all = await cores(page);
  assert.equal(await said(page), `Solves on ${all} cores.`);
  const { eigenvalues, threads } = await solved(page);
  assert.equal(threads, all);
  assert.equal(eigenvalues.length, alone.length);
  const off = Math.max(...eigenvalues.map((value, i) => Math.abs(value - alone[i]) / Math.max(alone[i], 1)));
  assert.ok(off < 1e-9, `an eigenvalue is off by ${off}`);
}

/** A worker that cannot start is ended, and the next request starts another. */
async function startsAgain(page) {
  const ends = await page.evaluate(async (mesh) => {
    const { ask, runs } = await import("./work.js");
    const asked = () => ask({ work: "solve", name: "torus.obj", bytes: new TextEncoder().encode(mesh), harmonics: 10, laplacian: "delaunay" }, undefined, "trial");
    const { Worker } = window;
    window.Worker = class extends Worker {
      postMessage(message, given) {
        const noModule = message.start && { start: { ...message.start, module_or_path: new Uint8Array(1) } };
        super.postMessage(noModule ?? message, given);
      }
    };
    const first = await asked().then(() => "solved", ({ name }) => name);
    window.Worker = Worker;
    return [first, runs("trial"), await asked().then(() => "solved", ({ message }) => message)];
  }, mesh);
  assert.deepEqual(ends, ["StoppedError", false, "solved"]);
}

/** A worker of another build than the page says so, and does nothing. */
async function tellsOfRelease(page) {
  const why = await page.evaluate(async (mesh) => {
    const { ask } = await import("./work.js");
    const { Worker } = window;
    window.Worker = class extends Worker {
      postMessage(message, given) {
        super.postMessage(message.start ? { start: { ...message.start, build: "another" } } : message, given);
      }
    };
    const bytes = new TextEncoder().encode(mesh);
    const asked = ask({ work: "solve", name: "torus.obj", bytes, harmonics: 10, laplacian: "delaunay" }, undefined, "release");
    return asked.then(() => "solved", ({ message }) => message).finally(() => { window.Worker = Worker; });
  }, mesh);
  assert.match(why, /newer version of the page/);
}

/** A module that could not be fetched once is fetched again. */
async function fetchesAgain(page) {
  const comes = await page.evaluate(async () => {
    // Not the page's own, which may have it already.
    const { shared } = await import("./threads.js?anew");
    const { fetch } = window;
    window.fetch = () => Promise.reject(new TypeError("on purpose"));
    const first = await shared();
    window.fetch = fetch;
    return [first, await shared()].map((found) => !!found);
  });
  assert.deepEqual(comes, [false, true]);
}

export async function threads() {
  // A server that knows nothing of such headers.
  const plain = await opened(VIEWPORT, false);
  assert.ok(!await isolated(plain.page));
  await startsAgain(plain.page);
  await tellsOfRelease(plain.page);
  const all = await cores(plain.page);
  const built = existsSync(join(folder, "chladni_threads_bg.wasm"));
  if (!built || all < 2) {
    assert.equal(await said(plain.page), "Solves on one core.");
    console.log(`web: ${built ? "this machine has one core" : "there is no module for threads"}: they are not tested`);
    return plain.page.context().close();
  }
  assert.equal(await said(plain.page), `Solves on one core, and on ${all} once the page is opened again.`);
  const alone = await solved(plain.page);
  assert.equal(alone.threads, 1);
  await until(plain.page, () => navigator.serviceWorker.controller);
  await plain.page.reload();
  await until(plain.page, () => window.chladni?.frames > 3 && window.chladni.sound.duration > 0);
  await onAll(plain.page, alone.eigenvalues);
  assert.deepEqual(plain.wrong, []);
  assert.deepEqual(plain.elsewhere, []);
  await plain.page.context().close();

  const server = await serve(folder, ISOLATED);
  assert.notEqual(server.address, address);
  const { page, wrong, elsewhere } = await opened(VIEWPORT, false, { at: server.address });
  await startsAgain(page);
  await fetchesAgain(page);
  await onAll(page, alone.eigenvalues);
  // What is given up takes its threads with it, and the next work begins anew.
  await page.evaluate(async (mesh) => {
    const { ask, giveUp } = await import("./work.js");
    const bytes = new TextEncoder().encode(mesh);
    const given = ask({ work: "solve", name: "torus.obj", bytes, harmonics: 100, laplacian: "delaunay" }, () => giveUp(), "solve");
    await given.then(() => { throw new Error("it was not given up"); }, ({ name }) => { if (name !== "AbortError") throw new Error(name); });
  }, mesh);
  await onAll(page, alone.eigenvalues);
  await page.click("#exaggerate");
  await acts(page);
  assert.deepEqual(wrong, []);
  assert.deepEqual(elsewhere, []);
  await page.context().close();
  server.stop();
  step(`it solves on ${all} threads where it is isolated, and finds what one finds`);
}

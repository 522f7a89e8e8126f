// The page without a connection, and without a place to keep it.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { serve } from "../browser.mjs";
import { acts } from "./caricature.mjs";
import { address, browser, empty, folder, step, until } from "./driver.mjs";

/** The service worker's answer to a request, with these caches and this network. */
function answered(request, caches, fetch) {
  const run = new Function("self", "caches", "fetch", readFileSync(join(folder, "offline.js"), "utf8"));
  const on = {};
  run({ registration: { scope: address }, addEventListener: (kind, act) => { on[kind] = act; } }, caches, fetch);
  let shown;
  on.fetch({ request, respondWith: (found) => { shown = found; } });
  return shown;
}

/** What the network gives is shown, whether a browser opens no cache or puts nothing into it. No browser can be asked to refuse. */
async function refused() {
  const came = { ok: true, type: "basic", clone: () => ({ arrayBuffer: async () => new ArrayBuffer(0) }) };
  const request = { method: "GET", url: `${address}main.js`, destination: "script" };
  const none = () => Promise.reject(new Error("refused"));
  for (const open of [none, async () => ({ put: none })]) {
    assert.equal(await answered(request, { open, match: none }, async () => came), came);
  }
  step("what cannot be kept is shown");
  // The connection breaks in the middle of a file, of which there is a copy.
  const kept = {};
  const fails = async () => { throw new TypeError("network error"); };
  const broken = { ...came, clone: () => ({ arrayBuffer: fails }) };
  const caches = { open: async () => ({ put: fails }), match: async () => kept };
  assert.equal(await answered(request, caches, async () => broken), kept);
  step("what was kept takes the place of a file that breaks off");
}

/** Workers come with a policy of their own; the page has it in itself, and other files need none. */
async function policies() {
  const caches = { open: async () => ({ put: async () => {} }) };
  for (const [destination, has] of [["worker", true], ["document", false], ["script", false]]) {
    const request = { method: "GET", url: `${address}file`, destination };
    const shown = await answered(request, caches, async () => new Response(""));
    const policy = shown.headers.get("content-security-policy");
    assert.equal(policy?.startsWith("default-src 'none'") ?? false, has, destination);
  }
}

export async function offline() {
  await refused();
  await policies();
  const server = await serve(folder);
  const context = await browser.newContext({ viewport: { width: 1000, height: 700 } });
  const page = await empty(context);
  await page.goto(`${server.address}?draw=cpu`);
  await until(page, () => window.chladni?.frames > 3 && window.chladni.sound.duration > 0);
  await until(page, async () => {
    const kept = await (await caches.open("chladni")).keys();
    return ["chladni_web_bg.wasm", "plate.body", "main.js", "worker.js"].every((name) => kept.some(({ url }) => url.endsWith(name)));
  });
  server.stop();
  await context.setOffline(true);
  // Under any of its addresses.
  for (const name of ["", "index.html"]) {
    await page.goto(server.address + name);
    await until(page, () => window.chladni?.frames > 3);
  }
  await page.click("#exaggerate");
  await acts(page);
  const runs = await Promise.all(page.workers().map((worker) =>
    worker.evaluate(() => import("data:text/javascript,").then(() => true, () => false))));
  assert.ok(runs.length > 0 && !runs.includes(true), "workers run no code but the page's");
  step("it opens again without a connection");
  await context.close();
}

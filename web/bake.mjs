// Makes the sample bodies ready beforehand, by the module itself: node web/bake.mjs PAGE
import { existsSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const page = resolve(process.argv[2]);
const wasm = join(page, "chladni_web_bg.wasm");
const { initSync, prepare, samples } = await import(pathToFileURL(join(page, "chladni_web.js")));
initSync({ module: readFileSync(wasm) });

/** Those of the plate are seen first; sand needs no more. */
const harmonics = (name) => (name === "plate" ? 64 : 96);

for (const [name] of JSON.parse(samples())) {
  const file = join(page, "bodies", `${name}.body`);
  if (existsSync(file) && statSync(file).mtimeMs > statSync(join(page, "..", "wasm32-unknown-unknown/release/chladni_web.wasm")).mtimeMs) continue;
  const began = performance.now();
  const body = prepare(`sample:${name}`, undefined, harmonics(name), () => {});
  writeFileSync(file, body);
  console.error(`bake: ${name}, ${(body.length / 1e6).toFixed(1)} MB in ${((performance.now() - began) / 1000).toFixed(1)} s`);
}

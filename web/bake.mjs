// Makes the sample bodies, and the match of the two sample heads, ready beforehand, by the module itself:
// node web/bake.mjs PAGE
import { existsSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { sampleHarmonics } from "./page/harmonics.js";
import { PLAIN_HEAD } from "./page/plain_head.js";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const page = resolve(process.argv[2]);
const wasm = join(page, "chladni_web_bg.wasm");
const { Sitting, initSync, match_template, prepare, samples } = await import(pathToFileURL(join(page, "chladni_web.js")));
initSync({ module: readFileSync(wasm) });

const built = statSync(join(page, "..", "wasm32-unknown-unknown/release/chladni_web.wasm")).mtimeMs;

function bake(name, make) {
  const file = join(page, "bodies", name);
  if (existsSync(file) && statSync(file).mtimeMs > built) return;
  const began = performance.now();
  const made = make();
  writeFileSync(file, made);
  console.error(`bake: ${name}, ${(made.length / 1e6).toFixed(1)} MB in ${((performance.now() - began) / 1000).toFixed(1)} s`);
}

for (const [name] of JSON.parse(samples())) {
  bake(`${name}.body`, () => prepare(`sample:${name}`, undefined, sampleHarmonics(name), () => {}));
}

// What the caricature room begins with: the request, and after it what answers it.
bake("head.match", () => {
  const sitting = new Sitting("sample:head", undefined, undefined, 1);
  sitting.begin(PLAIN_HEAD);
  const { request } = JSON.parse(sitting.missing());
  return `${request}\n${match_template("sample:head", undefined, request, undefined, () => {})}`;
});

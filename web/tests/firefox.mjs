// The same page in Firefox: both rooms, with what another engine does otherwise (workers, sound, pointers, downloads).
import assert from "node:assert/strict";
import { join } from "node:path";
import { head, launchFirefox, pixels, song, torus } from "../browser.mjs";
import { address, differs, drop, out, screens, state, step, tellsRefused } from "./driver.mjs";

const WAIT = { timeout: 180_000 };
const pause = (secs) => new Promise((done) => setTimeout(done, 1000 * secs));
const until = (page, condition) => page.waitForFunction(condition, WAIT);

export async function firefox() {
  const browser = await launchFirefox(out);
  if (!browser) return step("Firefox is not there: the page is not tried in it");
  try {
    const page = await browser.newPage();
    const wrong = [];
    page.on("console", (message) => { if (message.type() === "error") wrong.push(message.text()); });
    page.on("pageerror", (error) => wrong.push(error.message));
    await page.evaluateOnNewDocument(tellsRefused);
    // What was bred may go.
    page.on("dialog", (dialog) => dialog.accept());
    await page.setViewport({ width: 1440, height: 900 });
    await page.goto(address);
    await until(page, () => window.chladni?.frames > 3 && window.chladni.sound.duration > 0);
    await differs(() => pixels(page), pause, "sand on the plate");
    const shot = (name) => page.screenshot({ path: join(screens, `firefox-${name}.png`) });
    await shot("front");
    await music(page, shot);
    await caricature(page, shot);
    await webgl(page, shot);
    assert.deepEqual(wrong, []);
  } finally {
    await browser.close();
  }
}

async function music(page, shot) {
  await page.click("#enter");
  // With a sound device or without one.
  await until(page, () => window.chladni.state?.body === "sample:octopus" && !window.chladni.state.on_stage);
  await differs(() => pixels(page), pause, "twelve dances");
  await shot("gallery");
  await page.click(".cell:nth-child(2) .choose");
  await page.click(".cell:nth-child(7) .choose");
  await page.click("#breed");
  await until(page, () => window.chladni.state.generation === 1);
  await drop(page, ["ring.obj", torus(60, 30)], ["clicks.wav", song(6)]);
  await until(page, () => window.chladni.state.body === "ring.obj" && Math.abs(window.chladni.sound.duration - 6) < 0.1);
  await differs(() => pixels(page), pause, "a mesh and a song of one's own");
  assert.equal((await state(page)).dances.length, 12);
  step("Firefox: twelve dances, bred, on a mesh and a song that were dropped");
}

async function caricature(page, shot) {
  await page.goto(address);
  await until(page, () => window.chladni?.frames > 3);
  await page.click("#exaggerate");
  const acts = () => until(page, () => {
    const { sitting } = window.chladni;
    return sitting?.solved && sitting.layers.every((layer) => layer.state === "acts");
  });
  await acts();
  await shot("head");
  await drop(page, ["plain.obj", head(64, 48)]);
  await (await page.waitForSelector('#which button[value="shape"]', { visible: true })).click();
  await until(page, () => window.chladni.sitting?.shape === "plain.obj");
  await acts();
  await shot("own");
  step("Firefox: a head is exaggerated, and one that was dropped");
}

/** By WebGL2, where Firefox lends that without a screen. */
async function webgl(page, shot) {
  await page.goto(`${address}?draw=webgl`);
  await until(page, () => window.chladni?.frames > 3);
  const drawnBy = () => page.$eval("#front .drawn-by", (place) => place.textContent);
  const status = () => page.$eval("#status", (place) => place.textContent);
  if (await drawnBy() !== "Drawn by the graphics card through WebGL2, deformed by the processor.") return step(`Firefox: no WebGL2 here: ${await status()}`);
  await page.click("#enter");
  await until(page, () => window.chladni.state?.body === "sample:octopus");
  const { frames } = await page.evaluate(() => window.chladni);
  await page.waitForFunction((before) => window.chladni.frames > before + 5, WAIT, frames);
  await shot("webgl");
  assert.equal(await drawnBy(), "Drawn by the graphics card through WebGL2, deformed by the processor.", await status());
  step("Firefox: dances through WebGL2");
}

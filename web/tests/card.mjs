// The picture by a graphics card, through WebGPU or WebGL2, which a processor plays here: it is that of our own
// processor, and where the card is lost, that draws on.
import assert from "node:assert/strict";
import { WITH_CARD, WITH_WEBGL, launch } from "../browser.mjs";
import { acts } from "./caricature.mjs";
import { differs, drop, moves, opened, out, step, until } from "./driver.mjs";
import { skinned } from "./skinned.mjs";

const SMALL = { width: 640, height: 480 };
const drawnBy = (page) => page.textContent("#front .drawn-by");

/** The pixels of the whole page as it is seen, thinned out, where the shape is. */
async function seen(page) {
  const { x, y, width, height } = await page.locator("#picture").boundingBox();
  const png = await page.screenshot({ clip: { x, y, width, height } });
  return page.evaluate(async (bytes) => {
    const picture = await createImageBitmap(new Blob([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))]));
    const brush = new OffscreenCanvas(picture.width, picture.height).getContext("2d");
    brush.drawImage(picture, 0, 0);
    return [...brush.getImageData(0, 0, picture.width, picture.height).data];
  }, png.toString("base64"));
}

/** The page as it is seen once it changes no more. */
async function rested(page) {
  let before = await seen(page);
  for (let i = 0; i < 60; i++) {
    await page.waitForTimeout(1000);
    const now = await seen(page);
    if (now.every((value, i) => value === before[i])) return now;
    before = now;
  }
  throw new Error("the picture never comes to rest");
}

/** The same head, or another shape, by whoever is asked to draw. */
async function shape(within, draw, own) {
  const { page, wrong, shot } = await opened(SMALL, false, { within, query: `?draw=${draw}` });
  const by = await drawnBy(page);
  await page.click("#exaggerate");
  await acts(page);
  if (own) {
    await drop(page, ["skinned.glb", own]);
    await page.click('#which button[value="shape"]');
    await until(page, () => window.chladni.sitting?.shape === "skinned.glb" && window.chladni.sitting.solved);
  }
  const picture = await rested(page);
  await shot(`${own ? "skinned" : "head"}-${draw}`);
  assert.deepEqual(wrong, []);
  await page.context().close();
  return { by, picture };
}

/** Has the page remember how its card is lost: `window.lose()`. */
function rememberDevice() {
  const request = GPUAdapter.prototype.requestDevice;
  GPUAdapter.prototype.requestDevice = async function (...wanted) {
    const device = await request.apply(this, wanted);
    window.lose = () => device.destroy();
    return device;
  };
}
function rememberContext() {
  const get = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (...wanted) {
    const context = get.apply(this, wanted);
    if (wanted[0] === "webgl2") window.lose ??= () => context.getExtension("WEBGL_lose_context").loseContext();
    return context;
  };
}

/** The two ways to a card: flags of the browser, what the page is asked for and says then. */
const WEBGPU = { flags: WITH_CARD, draw: "gpu", says: "Drawn by the graphics card, deformed by the processor.", prepare: rememberDevice };
const WEBGL = { flags: WITH_WEBGL, draw: "webgl", says: "Drawn by the graphics card through WebGL2, deformed by the processor.", prepare: rememberContext };

export const webgpu = { pictures: () => compared(WEBGPU), loss: () => loses(WEBGPU) };
export const webgl = { pictures: () => compared(WEBGL), loss: () => loses(WEBGL), gallery, looks, skin: () => compared(WEBGL, skinned(60, 30)) };

async function compared({ flags, draw, says }, own) {
  const what = own ? "an image on a torus" : "a head";
  const within = await launch(out, flags);
  try {
    const [card, processor] = [await shape(within, draw, own), await shape(within, "cpu", own)];
    assert.deepEqual([card.by, processor.by], [says, "Drawn by the processor."]);
    assert.equal(card.picture.length, processor.picture.length);
    const apart = card.picture.map((value, i) => Math.abs(value - processor.picture[i]));
    const [mean, plain] = [apart.reduce((sum, a) => sum + a, 0) / apart.length, apart.filter((a) => a > 24).length / apart.length];
    assert.ok(mean < 0.5 && plain < 0.005, `${draw}: the two pictures are ${mean} apart in the mean, ${plain} of the values plainly`);
    step(`${draw}: ${what} by the card and by the processor: ${mean.toFixed(3)} of 255 apart in the mean, ${(100 * plain).toFixed(2)} % of it by more than 24`);
    const { page } = await opened(SMALL, false, { within });
    assert.equal(await drawnBy(page), "Drawn by the processor.", "a processor in disguise is not asked by itself");
    await page.context().close();
  } finally { await within.close(); }
}

/** Each cell of the gallery has a dance in its middle. */
async function fills(page) {
  const { width } = page.viewportSize();
  const picture = await seen(page);
  const left = await page.locator("#picture").boundingBox();
  for (const cell of await page.locator(".cell").all()) {
    const { x, y, width: wide, height: high } = await cell.boundingBox();
    let bright = 0;
    for (let row = y - left.y; row < y - left.y + high; row += 4) for (let column = x; column < x + wide; column += 4) {
      if (picture[4 * (Math.floor(row) * width + Math.floor(column)) + 1] > 90) bright++;
    }
    assert.ok(bright > 20, `a cell has ${bright} bright points`);
  }
}

/** The largest step of green from pixel to pixel. */
async function sharpest(page) {
  const picture = await seen(page);
  let most = 0;
  for (let i = 5; i < picture.length; i += 4) most = Math.max(most, Math.abs(picture[i] - picture[i - 4]));
  return most;
}

/** Every look, and sand on every one: the card goes on drawing. */
async function looks() {
  const within = await launch(out, WEBGL.flags);
  try {
    const { page, wrong, shot } = await opened(SMALL, false, { within, query: "?draw=webgl" });
    await page.click("#enter");
    await until(page, () => window.chladni.state.body === "sample:octopus");
    await page.locator(".cell").first().dblclick();
    await until(page, () => window.chladni.state.on_stage);
    const draws = async (what) => {
      const { frames } = await page.evaluate(() => window.chladni);
      await until(page, (before) => window.chladni.frames > before + 2, frames);
      assert.equal(await page.textContent("#controls .drawn-by"), WEBGL.says, `${what}: ${await page.textContent("#status")}`);
    };
    const names = await page.locator("#look option").evaluateAll((all) => all.map(({ value }) => value));
    for (const name of names) {
      await page.selectOption("#look", name);
      await draws(name);
      await shot(`webgl-${name}`);
      if (name === "dew") assert.ok(await sharpest(page) > 30, "dew: nothing is in focus");
    }
    await page.click("#sand");
    await draws("sand");
    assert.deepEqual(wrong, []);
    step(`webgl: ${names.length} looks, and sand`);
    await page.context().close();
  } finally { await within.close(); }
}

/** The small picture in which flashes are looked for is that of the card; and where it strobes, it is veiled. */
async function strobes(page) {
  const bright = await page.evaluate(async () => {
    const { smallPicture } = await import("./card.js");
    const { frames } = window.chladni;
    return new Promise((done) => requestAnimationFrame(function look() {
      if (window.chladni.frames === frames) return requestAnimationFrame(look);
      done(smallPicture()[0].filter((value, i) => i % 4 < 3 && value > 60).length);
    }));
  });
  assert.ok(bright > 500, `the small picture has ${bright} bright values`);
  await page.evaluate(() => {
    const read = CanvasRenderingContext2D.prototype.getImageData;
    let white = false;
    CanvasRenderingContext2D.prototype.getImageData = function (...where) {
      const image = read.apply(this, where);
      image.data.fill((white = !white) ? 255 : 0);
      return image;
    };
    window.calm = () => { CanvasRenderingContext2D.prototype.getImageData = read; };
  });
  const { frames } = await page.evaluate(() => window.chladni);
  await page.waitForTimeout(4000);
  const rate = ((await page.evaluate(() => window.chladni.frames)) - frames) / 4;
  // Every other picture is white.
  if (rate > 8) await until(page, () => /^rgb/.test(document.getElementById("picture").style.background));
  else step(`skipped: ${rate} pictures a second cannot flash more than three times`);
  // What is saved has the veil, too. Where pictures take seconds nothing strobes, so this one is judged beforehand.
  const laid = await page.evaluate(async () => {
    const { Concert } = await import("./chladni_web.js");
    const { judge } = Concert.prototype;
    const fill = CanvasRenderingContext2D.prototype.fillRect;
    Concert.prototype.judge = () => -128;
    const found = await new Promise((done) => {
      setTimeout(() => done("none"), 60_000);
      CanvasRenderingContext2D.prototype.fillRect = function (...where) {
        if (Math.max(this.canvas.width, this.canvas.height) === 2000 && /^rgba/.test(this.fillStyle)) done(this.fillStyle);
        return fill.apply(this, where);
      };
      document.getElementById("save-picture").click();
    });
    Object.assign(CanvasRenderingContext2D.prototype, { fillRect: fill });
    Concert.prototype.judge = judge;
    return found;
  });
  assert.match(laid, /^rgba\((0, 0, 0|255, 255, 255), 0?\.\d+\)$/);
  await page.evaluate(() => window.calm());
  step("a strobe of the card's is veiled");
}

async function loses({ flags, draw, prepare }) {
  const within = await launch(out, flags);
  try {
    const { page, shot } = await opened(SMALL, false, { within, query: `?draw=${draw}`, prepare });
    await shot(`front-${draw}`);
    await page.click("#enter");
    await until(page, () => window.chladni.state.body === "sample:octopus");
    await differs(() => seen(page), (secs) => page.waitForTimeout(1000 * secs), `dances by ${draw}`);
    await fills(page);
    const save = page.waitForEvent("download");
    await page.click("#save-picture");
    assert.equal((await save).suggestedFilename(), "chladni.png");
    await strobes(page);
    await shot(`gallery-${draw}`);
    const { dances } = await page.evaluate(() => window.chladni.state);
    await page.evaluate(() => window.lose());
    await until(page, () => document.querySelector("#controls .drawn-by").textContent === "Drawn by the processor.");
    assert.match(await page.textContent("#status"), /graphics card is gone/);
    await moves(page, "by the processor");
    assert.deepEqual((await page.evaluate(() => window.chladni.state)).dances, dances);
    await page.context().close();
    await losesAtFront(within, draw, prepare);
    await losesStill(within, draw, prepare);
    step(`${draw}: where the graphics card is lost, the processor goes on`);
  } finally { await within.close(); }
}

/** The processor goes on with the dances in the room, too, where the card is lost at the front. */
async function losesAtFront(within, draw, prepare) {
  const { page } = await opened(SMALL, false, { within, query: `?draw=${draw}`, prepare });
  const goes = async (id, body) => {
    await page.evaluate((id) => document.getElementById(id).click(), id);
    await until(page, (body) => window.chladni.state.body === body, body);
  };
  await goes("enter", "sample:octopus");
  await goes("home", "sample:plate");
  await page.evaluate(() => window.lose());
  await until(page, () => document.querySelector("#front .drawn-by").textContent === "Drawn by the processor.");
  await goes("enter", "sample:octopus");
  await moves(page, "dances that were left in the room");
  await page.context().close();
}

/** A plate that stands still is seen again where the card is lost. */
async function losesStill(within, draw, prepare) {
  const { page } = await opened(SMALL, false, { within, query: `?draw=${draw}`, prepare, reducedMotion: "reduce" });
  await until(page, () => window.chladni.standsAtSecs >= 6);
  const { frames } = await page.evaluate(() => window.chladni);
  await page.evaluate(() => window.lose());
  await until(page, () => document.querySelector("#front .drawn-by").textContent === "Drawn by the processor.");
  await until(page, (before) => window.chladni.frames > before, frames);
  await page.context().close();
}

/** Where the card is lost, a gallery of caricatures goes with its pictures, and so do its controls. */
async function gallery() {
  const within = await launch(out, WEBGL.flags);
  try {
    const { page } = await opened(SMALL, false, { within, query: "?draw=webgl", prepare: WEBGL.prepare });
    await page.click("#exaggerate");
    await acts(page);
    await page.evaluate(() => document.getElementById("gallery").click());
    await until(page, () => window.chladni.wall && document.querySelectorAll("#cells .cell").length === 12);
    await page.evaluate(() => window.lose());
    await until(page, () => document.querySelector("#front .drawn-by").textContent === "Drawn by the processor.");
    await until(page, () => !window.chladni.wall && !document.querySelector("#cells .cell"));
    assert.deepEqual(await page.evaluate(() => [document.getElementById("wall").hidden, document.getElementById("gallery").getAttribute("aria-pressed")]), [true, "false"]);
    step("webgl: where the graphics card is lost, a gallery of caricatures is left");
    await page.context().close();
  } finally { await within.close(); }
}

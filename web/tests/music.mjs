// The music room: it moves, breeds, takes a mesh and a song, saves and opens again.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { song, torus } from "../browser.mjs";
import { skinned } from "./skinned.mjs";
import { downloaded, drop, moves, opened, screens, state, step, until } from "./driver.mjs";

/** Both curves of a dance. */
const mapping = (text) => ["transfer", "amplification"].map((name) => new RegExp(`^${name} = (.*)$`, "m").exec(text)[1]);

/** The text of the dance that would be saved. */
const saved = async (page) => readFileSync(await downloaded(page, "#save-preset"), "utf8");

/** Draws a curve of the dance on stage, by pointer and by keys. */
async function draws(page) {
  await page.click("#draw");
  const curves = () => page.evaluate(() => ["transfer", "amplification"].map((id) => Number(document.getElementById(id).getAttribute("aria-valuenow"))));
  const { x, y, width, height } = await page.locator("#amplification").boundingBox();
  await page.mouse.move(x + 4, y + 4);
  await page.mouse.down();
  for (let i = 1; i <= 10; i++) await page.mouse.move(x + (i * width) / 10 - 4, y + (i * height) / 10 - 4);
  await page.mouse.up();
  await page.focus("#amplification");
  for (let i = 0; i < 40; i++) await page.keyboard.press("ArrowLeft");
  const [, first] = await curves();
  assert.ok(first > 0.9, `the curve begins at ${first}`);
  for (let i = 0; i < 4; i++) await page.keyboard.press("ArrowDown");
  assert.ok(Math.abs((await curves())[1] - (first - 0.4)) < 0.02, "a key goes a twentieth of the range");
  await page.click("#smooth-amplification");
  await page.focus("#transfer");
  const [before] = await curves();
  await page.keyboard.press(before > 0.5 ? "ArrowDown" : "ArrowUp");
  assert.ok(Math.abs((await curves())[0] - before) > 0.04);
  await moves(page, "a dance whose curves were drawn");
  step("curves are drawn by pointer and by keys");
}

/** Until the tempo that is shown, in whole beats per minute, is this one. */
const beatsAt = (page, bpm) => until(page, (bpm) => Math.abs(Number.parseInt(document.getElementById("tempo").textContent, 10) - bpm) <= 1, bpm);

/** The tempo that is shown, once there is one. */
async function tempo(page) {
  await until(page, () => /^\d+\sBPM, \d+\s%\ssure$/.test(document.getElementById("tempo").textContent));
  return Number.parseInt(await page.textContent("#tempo"), 10);
}

/** The spectrum of the sound has a middle and sides; the beat is halved and doubled, by buttons and by keys. Gives its tempo. */
async function hears(page) {
  await until(page, () => {
    const canvas = document.getElementById("spectrum");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const lit = [0, 0];
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 3] < 128) continue;
      if (data[i] > 1.5 * data[i + 2]) lit[0]++;
      if (data[i + 2] > 1.5 * data[i]) lit[1]++;
    }
    return Math.min(...lit) > 20;
  });
  const bpm = await tempo(page);
  await page.click("#double-beat");
  await beatsAt(page, 2 * bpm);
  await page.focus("#picture");
  await page.keyboard.press("[");
  await beatsAt(page, bpm);
  await page.keyboard.press("]");
  await beatsAt(page, 2 * bpm);
  for (let i = 0; i < 2; i++) await page.click("#halve-beat");
  await beatsAt(page, bpm / 2);
  assert.ok(await page.isHidden("#tap-beat"), "the beat of a song is not tapped");
  step(`the spectrum is drawn, and the beat, ${bpm} a minute, is halved and doubled`);
  return bpm;
}

/** t and a as they are drawn in a cell of the gallery. */
const smallCurves = (page, cell) => page.$$eval(`.cell:nth-child(${cell}) .mapping .line`, (lines) => lines.map((line) => line.getAttribute("d")));

/** Drops a silent song of 70 minutes: of so few samples a second, and so coarse, that its file is small. */
const dropLongSong = (page) => page.evaluate(() => {
  const [rate, frames] = [8000, 33_600_000];
  const header = new DataView(new ArrayBuffer(44));
  const text = (at, words) => [...words].forEach((letter, i) => header.setUint8(at + i, letter.charCodeAt(0)));
  const long = (at, value) => header.setUint32(at, value, true);
  const short = (at, value) => header.setUint16(at, value, true);
  text(0, "RIFF"); long(4, 36 + frames); text(8, "WAVEfmt "); long(16, 16); short(20, 1); short(22, 1);
  long(24, rate); long(28, rate); short(32, 1); short(34, 8); text(36, "data"); long(40, frames);
  const dropped = new DataTransfer();
  dropped.items.add(new File([header, new Uint8Array(frames).fill(128)], "long.wav"));
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: dropped, bubbles: true, cancelable: true }));
});

/** A favorite, a lock, a name, generations, other dances. */
async function marks(page) {
  const dance = (item) => page.evaluate((item) => window.chladni.state.dances[item], item);
  await page.locator(".cell:nth-child(3) .lock").dispatchEvent("click");
  await page.locator(".cell:nth-child(3) .favor").dispatchEvent("click");
  const kept = await dance(2);
  assert.ok(kept.locked && kept.favorite);
  await page.click(".cell:nth-child(3) .choose");
  await page.click("#more");
  await page.fill("#dance-name", "Of the sea");
  await page.press("#dance-name", "Tab");
  assert.equal((await dance(2)).name, "Of the sea");
  await page.fill("#own-gain", "2.5");
  assert.ok(Math.abs((await dance(2)).gain - 2.5) < 1e-6);
  await page.click(".cell:nth-child(5) .choose");
  const { generation } = await state(page);
  await page.click("#breed");
  await until(page, (generation) => window.chladni.state.generation > generation, generation);
  assert.equal((await dance(2)).name, "Of the sea", "a locked dance keeps its place");
  await page.click("#earlier");
  await until(page, (generation) => window.chladni.state.generation === generation, generation);
  await page.click("#later");
  await until(page, (generation) => window.chladni.state.generation > generation, generation);
  await page.click("#favorites");
  await until(page, () => window.chladni.state.on_stage);
  assert.ok((await state(page)).settings.switches["beat-steps"], "one after the other");
  await page.click("#back");
  await until(page, () => !window.chladni.state.on_stage);
  // A hand that takes the stage ends the autopilot, and has the gallery that was there before it.
  const { generation: before } = await state(page);
  await page.click("#pilot");
  await until(page, () => window.chladni.state.piloted);
  await page.click("#favorites");
  await until(page, () => window.chladni.state.on_stage && !window.chladni.state.piloted);
  assert.equal((await state(page)).generation, before);
  assert.equal(await page.getAttribute("#pilot", "aria-pressed"), "false");
  await page.click("#back");
  await until(page, () => !window.chladni.state.on_stage);
  await page.evaluate(() => { for (const each of document.querySelectorAll("#drawer details")) each.open = true; });
  const { seed } = await state(page);
  await page.click("#other-dances");
  await until(page, (seed) => window.chladni.state.seed === `${Number(seed) + 1}` && window.chladni.state.generations === 1, seed);
  await page.selectOption("#gallery-size", "9");
  await until(page, () => window.chladni.state.dances.length === 9);
  await page.selectOption("#gallery-size", "12");
  await until(page, () => window.chladni.state.dances.length === 12);
  // A show may have a seed that no number of the page can hold.
  const seeds = await page.evaluate(async () => {
    const { Concert } = await import("./chladni_web.js");
    const body = await (await fetch("bodies/plate.body")).arrayBuffer();
    const concert = new Concert(new Uint8Array(body), 6, 1);
    concert.open_show(concert.save_show().replace(/^seed = .*$/m, "seed = 9007199254740993"));
    const seeds = [false, true].map((isOther) => {
      concert.new_gallery(9, isOther);
      return JSON.parse(concert.state()).seed;
    });
    concert.free();
    return seeds;
  });
  assert.deepEqual(seeds, ["9007199254740993", "2"]);
  step("dances are marked, locked, named, and found again in their generations");
}

/** Knobs, switches, form, timbre and parts of the look. */
async function turns(page) {
  const settings = async () => (await state(page)).settings;
  const row = (name, role = "slider") => page.locator("#knobs").getByRole(role, { name, exact: true });
  const { knobs } = await settings();
  assert.equal(await page.locator("#knobs input[type=range]").count(), Object.keys(knobs).length, "all knobs are there");
  await row("Limit").fill("400");
  assert.equal((await settings()).knobs.limit, 1);
  assert.equal(await row("Limit").getAttribute("aria-valuetext"), "100.0 %");
  await row("Bands").fill("200");
  const { bands } = (await settings()).knobs;
  assert.ok(Number.isInteger(bands) && bands > 60 && bands < 140, `half of the way in even factors: ${bands}`);
  assert.ok(await row("Grains").isDisabled(), "there is no sand");
  await page.selectOption("#form", "modal");
  assert.equal((await settings()).form, "modal");
  assert.ok(await row("Fine detail").isDisabled(), "nothing finer moves along the normals");
  await page.selectOption("#timbre", "bell");
  assert.ok(Math.abs((await settings()).knobs.damping - 0.04) < 1e-6);
  await row("Damping").press("ArrowRight");
  assert.equal(await page.inputValue("#timbre"), "own");
  await page.selectOption("#timbre", "");
  assert.equal((await settings()).switches.resonate, false);
  assert.ok(await row("Damping").isDisabled());
  await page.fill("#harmonics", "20");
  assert.equal((await settings()).harmonics, 20);
  await row("In any field of view", "checkbox").check();
  assert.ok((await settings()).switches["flash-fields"]);
  await row("Suggest", "checkbox").check();
  await page.click(".cell:nth-child(2) .choose");
  const { generation } = await state(page);
  await page.click("#breed");
  await until(page, (generation) => window.chladni.state.generation > generation, generation);
  const savedShow = async () => readFileSync(await downloaded(page, "#save-show"), "utf8");
  await page.selectOption("#stance-up", "z");
  const [upward] = /^stands = "up z, front .*"$/m.exec(await savedShow());
  await page.click("#turn-front");
  assert.notEqual(/^stands = "up z, front .*"$/m.exec(await savedShow())[0], upward);
  await moves(page, "a shape that stands otherwise");
  await page.selectOption("#stance-up", "");
  assert.doesNotMatch(await savedShow(), /^stands/m);
  await page.selectOption("#look", "ember");
  await page.selectOption("#look-material", "clay");
  await page.selectOption("#look-background", "night");
  assert.deepEqual((await state(page)).looks, { look: "ember", material: "clay", background: "night" });
  await page.selectOption("#look", "aurora");
  assert.deepEqual((await state(page)).looks, { look: "aurora" });
  const corners = page.getByRole("checkbox", { name: "Dark corners" });
  await corners.uncheck();
  await page.selectOption("#look", "ember");
  assert.deepEqual((await state(page)).looks, { look: "ember", without: ["corners"] });
  assert.equal(await corners.isChecked(), false, "what is left out is left out of all looks");
  assert.ok(await page.getByRole("checkbox", { name: "Grain", exact: true }).isDisabled(), "this look has none");
  await corners.check();
  await page.selectOption("#look", "aurora");
  assert.deepEqual((await state(page)).looks, { look: "aurora" });
  await moves(page, "with other knobs");
  step(`${Object.keys(knobs).length} knobs and all switches, form, timbre, suggested children and parts of the look`);
}

/** A shape with an image of red and blue squares dances in it, where that is chosen. */
async function ownColors(page) {
  const colored = () => page.evaluate(() => {
    const { width, height } = document.getElementById("picture");
    const { data } = document.getElementById("picture").getContext("2d").getImageData(0, 0, width, height);
    const count = [0, 0];
    for (let i = 0; i < data.length; i += 4) {
      const [r, g, b] = data.subarray(i, i + 3);
      if (r > 60 && r > 2 * b && r > 2 * g) count[0]++;
      if (b > 60 && b > 1.8 * r) count[1]++;
    }
    return Math.min(...count) / (width * height);
  });
  const told = () => page.isVisible("#no-own-colors");
  await page.click("#more");
  await page.evaluate(() => { for (const each of document.querySelectorAll("#drawer details")) each.open = true; });
  await page.selectOption("#look", "plain");
  await page.selectOption("#look-palette", "own");
  assert.ok(await told(), "the octopus brings no colors");
  await drop(page, ["skinned.glb", skinned(60, 30)]);
  await until(page, () => window.chladni.state.body === "skinned.glb");
  // A look that was chosen stays.
  assert.equal((await state(page)).looks.palette, "own");
  await page.selectOption("#look", "plain");
  await page.selectOption("#look-palette", "own");
  assert.ok(!(await told()), "this shape does");
  await page.selectOption("#look-background", "white");
  let share = 0;
  for (let i = 0; i < 30 && share < 0.01; i++) {
    await page.waitForTimeout(500);
    share = await colored();
  }
  assert.ok(share >= 0.01, `${share} of the picture is red, or blue`);
  await page.selectOption("#look-palette", "");
  for (let i = 0; i < 30 && share > 0.001; i++) {
    await page.waitForTimeout(500);
    share = await colored();
  }
  assert.ok(share <= 0.001, `${share} of the picture is red, or blue, in the look`);
  await page.click("#more");
  step("a shape with an image dances in it");
}

export async function laptop() {
  const { page, wrong, elsewhere, shot } = await opened({ width: 1440, height: 900 }, false);
  await moves(page, "sand on the plate");
  await page.waitForTimeout(4000);
  await shot("laptop-front");
  step("the front page moves");

  await page.click("#enter");
  await until(page, () => window.chladni.state.body === "sample:octopus" && !window.chladni.state.on_stage);
  assert.equal((await state(page)).dances.length, 12);
  await moves(page, "twelve dances");
  await page.waitForTimeout(3000);
  await shot("laptop-gallery");
  const tuneBpm = await hears(page);

  await page.click(".cell:nth-child(2) .choose");
  await page.click(".cell:nth-child(7) .choose");
  await until(page, () => window.chladni.state.dances.filter((dance) => dance.chosen).length === 2);
  await page.click("#breed");
  await until(page, () => window.chladni.state.generation === 1);
  step("twelve dances, two of them bred");

  await page.hover(".cell:nth-child(5)");
  await page.click(".cell:nth-child(5) .stage");
  await until(page, () => window.chladni.state.on_stage);
  await moves(page, "the stage");
  await page.waitForTimeout(2000);
  await shot("laptop-stage");
  await draws(page);
  await shot("laptop-curves");
  await page.click("#back");
  assert.ok(await page.isHidden("#curves"), "curves are those of the stage");
  await until(page, () => !window.chladni.state.on_stage);
  await page.selectOption("#look", "ember");
  await page.click("#pilot");
  await until(page, () => window.chladni.state.piloted);
  await moves(page, "the autopilot");
  await page.click("#back");
  step("stage, look and autopilot");

  await ownColors(page);
  await drop(page, ["torus.obj", torus(60, 30)]);
  await until(page, () => window.chladni.state.body === "torus.obj");
  await beatsAt(page, tuneBpm / 2);
  await page.click("#double-beat");
  await beatsAt(page, tuneBpm);
  await moves(page, "a mesh that was dropped");
  await shot("laptop-mesh");
  await drop(page, ["clicks.wav", song(12)]);
  await until(page, () => document.getElementById("song").textContent === "clicks.wav");
  await until(page, () => window.chladni.position() > 1);
  await moves(page, "a song that was dropped");
  step("a mesh and a song were dropped");

  const songBpm = await tempo(page);
  await page.click("#halve-beat");
  await beatsAt(page, songBpm / 2);
  const before = await state(page);
  const saving = page.waitForEvent("download");
  await page.click("#save-show");
  const show = join(screens, "show.toml");
  await (await saving).saveAs(show);
  assert.match(readFileSync(show, "utf8"), /^octave = -1$/m);
  await page.click("#double-beat");
  await beatsAt(page, songBpm);
  await page.click(".cell:nth-child(1) .choose");
  await page.click(".cell:nth-child(4) .choose");
  await page.click("#breed");
  await until(page, (generation) => window.chladni.state.generation > generation, before.generation);
  await page.setInputFiles("#file", show);
  await until(page, (generation) => window.chladni.state.generation === generation, before.generation);
  const { dances, settings } = await state(page);
  assert.deepEqual({ dances, settings }, { dances: before.dances, settings: before.settings });
  await beatsAt(page, songBpm / 2);
  step("a show was saved and opened again, and its beat is read as it was");

  await drop(page, ["broken.obj", Buffer.from("v 1 2\nf 1 2 3\n")]);
  await until(page, () => document.getElementById("status").className === "bad");
  await drop(page, ["broken.ogg", Buffer.from("OggS, but no more")]);
  await until(page, () => document.getElementById("status").textContent.includes("broken.ogg"));
  await dropLongSong(page);
  await until(page, () => document.getElementById("status").textContent.includes("long.wav: longer than the 69 minutes that a page has memory for"));
  await moves(page, "after broken files");
  step("broken files are reported, and the dance goes on");

  // A dance that was saved takes the last place, but not that of a dance that is locked.
  const preset = await saved(page);
  const presses = (cell, what) => page.locator(`.cell:nth-child(${cell}) .${what}`).dispatchEvent("click");
  await presses(12, "lock");
  const curves = await smallCurves(page, 11);
  assert.ok(curves.length === 2 && curves.every((curve) => /^M0\.0 .*L100\.0 /.test(curve)), `t and a: ${curves}`);
  await presses(11, "vary");
  await until(page, (before) => {
    const lines = [...document.querySelectorAll(".cell:nth-child(11) .mapping .line")];
    return lines.some((line, i) => line.getAttribute("d") !== before[i]);
  }, curves);
  await presses(11, "choose");
  assert.notDeepEqual(mapping(await saved(page)), mapping(preset));
  await presses(11, "choose");
  const others = Array.from({ length: 11 }, (_, i) => i + 1);
  for (const cell of others) await presses(cell, "lock");
  await drop(page, ["dance.toml", Buffer.from(preset)]);
  await until(page, () => document.getElementById("status").textContent.includes("all dances are locked"));
  for (const cell of others) await presses(cell, "lock");
  await drop(page, ["dance.toml", Buffer.from(preset)]);
  await until(page, () => document.getElementById("status").textContent.includes("this dance is in the gallery now"));
  await presses(11, "choose");
  assert.deepEqual(mapping(await saved(page)), mapping(preset));
  await presses(11, "choose");
  step("a dance is saved, varied and opened again");
  await marks(page);
  await turns(page);
  await shot("laptop-drawer");
  await page.click("#more");

  await drop(page, ["large.obj", torus(240, 160)]);
  await until(page, () => /large.obj/.test(document.getElementById("status").textContent) && !document.getElementById("cancel").hidden);
  // Each percent is seen, and not read aloud.
  await until(page, () => /\d %$/.test(document.getElementById("progress").textContent));
  assert.doesNotMatch(await page.textContent("#status"), /large\.obj[^·]*%/);
  await page.click("#cancel");
  await until(page, () => document.getElementById("cancel").hidden);
  assert.equal(await page.textContent("#progress"), "");
  assert.equal((await state(page)).body, "torus.obj");
  await moves(page, "the shape that was there before");
  step("the solve of a mesh is cancelled, and the dance goes on");

  const plays = (text) => until(page, (text) => document.getElementById("song").textContent === text, text);
  await drop(page, ["one.wav", song(4)], ["two.wav", Buffer.from("RIFF, but no more")], ["three.wav", song(3)]);
  await plays("2 of 3: one.wav");
  await until(page, () => !document.getElementById("next").hidden);
  await shot("laptop-songs");
  await plays("3 of 3: three.wav");
  await plays("1 of 3: clicks.wav");
  await page.click("#previous");
  await plays("3 of 3: three.wav");
  await page.click("#next");
  await plays("1 of 3: clicks.wav");
  await moves(page, "a song of a list");
  step("songs play one after the other");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

/** The front's plate stays in sight where the screen is turned, and is in the middle of the room. */
export async function plate() {
  const { page, wrong, elsewhere } = await opened({ width: 844, height: 390 }, true);
  const shift = async () => (await page.evaluate(() => window.chladni.view())).shift;
  const near = (found, wanted) => assert.ok(found.every((value, i) => Math.abs(value - wanted[i]) < 1e-3), `${found}`);
  near(await shift(), [0.62, 0]);
  await page.setViewportSize({ width: 390, height: 844 });
  await until(page, () => window.chladni.view().shift[1] < 0);
  near(await shift(), [0, -0.16]);
  await drop(page, ["clicks.wav", song(20)]);
  await until(page, () => document.getElementById("song").textContent === "clicks.wav");
  assert.equal((await state(page)).body, "sample:plate");
  near(await shift(), [0, 0]);
  step("the plate of the front stays in sight, and is in the middle of the room");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

export async function phone() {
  const { page, wrong, elsewhere, shot } = await opened({ width: 390, height: 844 }, true);
  await page.waitForTimeout(3000);
  await shot("phone-front");
  await page.tap("#enter");
  await until(page, () => window.chladni.state.body === "sample:octopus");
  assert.equal((await state(page)).dances.length, 6);
  await moves(page, "six dances");
  await page.waitForTimeout(2000);
  await shot("phone-gallery");
  await page.tap(".cell:nth-child(1) .stage");
  await until(page, () => window.chladni.state.on_stage);
  await moves(page, "the stage");
  await shot("phone-stage");
  await page.tap("#draw");
  await shot("phone-curves");
  await page.tap("#draw");

  const touches = await page.context().newCDPSession(page);
  const touch = (type, ...points) => touches.send("Input.dispatchTouchEvent", {
    type, touchPoints: points.map(([x, y], id) => ({ x, y, id })),
  });
  const view = async () => (await page.evaluate(() => window.chladni.view()));
  const first = await view();
  await touch("touchStart", [200, 300]);
  for (let x = 200; x <= 300; x += 20) await touch("touchMove", [x, 300]);
  await touch("touchEnd");
  const turned = await view();
  assert.ok(Math.abs(turned.yaw_rad - first.yaw_rad) > 0.1, "a finger turns");
  await touch("touchStart", [150, 300], [250, 300]);
  for (let apart = 50; apart <= 90; apart += 10) await touch("touchMove", [200 - apart, 300], [200 + apart, 300]);
  await touch("touchEnd");
  assert.ok((await view()).distance < 0.8 * turned.distance, "two fingers pinch");
  step("a phone: six dances, one finger turns and two pinch");
  // The system's Back leads from a room to the front, once for each visit.
  for (const enter of ["#enter", "#exaggerate"]) {
    await page.goBack();
    await until(page, () => document.body.dataset.view === "front");
    await page.tap(enter);
    await until(page, () => document.body.dataset.view !== "front");
  }
  const entries = await page.evaluate(() => history.length);
  await page.tap("#home");
  await until(page, () => document.body.dataset.view === "front");
  await page.tap("#enter");
  assert.equal(await page.evaluate(() => history.length), entries, "one entry stands for all visits");
  await page.tap("#film-song");
  await page.waitForSelector("#whole-film[open]");
  await page.goBack();
  await until(page, () => document.body.dataset.view === "front");
  assert.equal(await page.locator("dialog[open]").count(), 0, "what is asked about a room goes with it");
  step("Back leads from a room to the front");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

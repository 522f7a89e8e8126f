// All that can be used has a name and is reached by the keyboard; less motion is none, and large text can be read.
import assert from "node:assert/strict";
import { song, torus } from "../browser.mjs";
import { acts } from "./caricature.mjs";
import { dances, downloaded, drop, moves, opened, says, songIs, step, still, until } from "./driver.mjs";
import { holdBack, holdsBack, isHeldBack } from "./held.mjs";

const CONTROLS = "button, input, select, textarea, summary, a[href], [tabindex='0']";

/** Every focusable thing that a screen reader is given has a name. */
async function named(page, where) {
  const session = await page.context().newCDPSession(page);
  const { nodes } = await session.send("Accessibility.getFullAXTree");
  const focusable = nodes.filter(({ ignored, properties = [] }) => !ignored && properties.some(({ name, value }) => name === "focusable" && value.value));
  const nameless = focusable.filter(({ name, role }) => role.value !== "RootWebArea" && !name?.value?.trim());
  assert.deepEqual(nameless.map(({ role }) => role.value), [], `${where}: without a name`);
  assert.ok(focusable.length > 4, `${where}: ${focusable.length} that can be focused`);
  await session.detach();
}

/** The tabulator reaches every control that is seen. */
async function reached(page, where) {
  const wanted = await page.evaluate((CONTROLS) => {
    const modal = document.querySelector("dialog:modal") ?? document.body;
    const seen = [...modal.querySelectorAll(CONTROLS)].filter((each) =>
      !each.disabled && !each.closest(":disabled, [inert]") && each.checkVisibility({ visibilityProperty: true }) && each.tabIndex >= 0);
    seen.forEach((each, i) => { each.dataset.tab = i; });
    window.met = new Set();
    window.meet = ({ target }) => { if (target.dataset?.tab) window.met.add(target.dataset.tab); };
    addEventListener("focusin", window.meet);
    (modal === document.body ? document.activeElement : undefined)?.blur();
    return seen.length;
  }, CONTROLS);
  for (let i = 0; i < 2 * wanted + 10 && (i % 10 || await page.evaluate(() => window.met.size) < wanted); i++) await page.keyboard.press("Tab");
  const missed = await page.evaluate(() => {
    removeEventListener("focusin", window.meet);
    const all = [...document.querySelectorAll("[data-tab]")];
    const missed = all.filter(({ dataset }) => !window.met.has(dataset.tab)).map(({ id, className, tagName }) => `${tagName} ${id || className}`);
    for (const each of all) delete each.dataset.tab;
    return missed;
  });
  assert.deepEqual(missed, [], `${where}: not reached by the tabulator`);
  return wanted;
}

export async function names() {
  const { page, wrong, elsewhere } = await opened({ width: 1280, height: 800 }, false);
  const counts = [];
  const holds = async (where) => { await named(page, where); counts.push(`${where} ${await reached(page, where)}`); };
  await holds("front");
  await page.click("#enter");
  await until(page, () => window.chladni.state.body === "sample:octopus" && document.querySelectorAll(".cell").length === 12);
  await page.click("#more");
  await page.evaluate(() => { for (const each of document.querySelectorAll("#drawer details")) each.open = true; });
  await holds("gallery of dances");
  assert.match(await page.getAttribute("#cells", "aria-label"), /^Dances:/);
  await page.locator(".cell:nth-child(2) .stage").dispatchEvent("click");
  await until(page, () => window.chladni.state.on_stage);
  await page.click("#draw");
  await holds("stage");
  await page.click("#film-song");
  await holds("film");
  await page.click("#film-cancel");
  await page.click("#home");
  await page.click("#exaggerate");
  await acts(page);
  await page.evaluate(() => { for (const each of document.querySelectorAll("#bench details")) each.open = true; });
  for (const tool of ["turn", "parts", "brush"]) {
    await page.click(`#hold-${tool}`);
    await holds(tool);
  }
  await page.click("#gallery");
  await until(page, () => window.chladni.wall && document.querySelectorAll("#cells .cell").length === 12);
  await holds("gallery of caricatures");
  assert.match(await page.getAttribute("#cells", "aria-label"), /^Caricatures:/);
  await page.click("#wall-close");
  assert.match(await page.getAttribute("#softness", "aria-valuetext"), /^\d+ % of the shape's size$/);
  step(`all controls have names and are reached by the tabulator: ${counts.join(", ")}`);
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

/** Full screen shows the picture alone; keys play, pause and go on. */
export async function fullScreen() {
  const { page, wrong, elsewhere } = await opened({ width: 1280, height: 800 }, false);
  await page.click("#enter");
  await until(page, () => window.chladni.state.body === "sample:octopus" && window.chladni.sound.isHeard);
  await drop(page, ["one.wav", song(20)], ["two.wav", song(20)]);
  await until(page, () => document.getElementById("song").textContent === "1 of 2: one.wav");
  await page.click("#full");
  await until(page, () => document.body.dataset.bare === "yes" && document.fullscreenElement);
  assert.ok(await page.isHidden("#controls"));
  await page.keyboard.press("Space");
  await until(page, () => !window.chladni.sound.isHeard);
  await page.keyboard.press("Space");
  await until(page, () => window.chladni.sound.isHeard);
  await page.keyboard.press("PageDown");
  await until(page, () => document.getElementById("song").textContent === "2 of 2: two.wav");
  await page.keyboard.press("PageUp");
  await until(page, () => document.getElementById("song").textContent === "1 of 2: one.wav");
  await page.evaluate(() => document.exitFullscreen());
  await until(page, () => document.body.dataset.bare === undefined);
  assert.ok(await page.isVisible("#controls"));
  // A project leads to the other room, which has its line at the top.
  await page.click("#full");
  await until(page, () => document.body.dataset.bare === "yes" && document.fullscreenElement);
  const project = 'format_version = 4\nlayer = []\n\n[shape]\nsource = "dent.obj"\nharmonics = 32\n';
  await drop(page, ["dent.chladni", Buffer.from(project)]);
  await says(page, "bring that mesh");
  for (const id of ["home", "status"]) assert.ok(await page.isVisible(`#${id}`), id);
  step("full screen and back; keys play, pause and go on");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

/** What a browser has translated stays, though pictures go on. */
export async function translated() {
  const { page, wrong } = await opened({ width: 1280, height: 800 }, false);
  await page.click("#enter");
  await until(page, () => window.chladni.state.body === "sample:octopus" && document.querySelectorAll(".cell").length === 12);
  await page.evaluate(() => { document.querySelector(".cell .stage").textContent = "舞台"; });
  const { frames } = await page.evaluate(() => window.chladni);
  await until(page, (before) => window.chladni.frames > before + 2, frames);
  assert.equal(await page.textContent(".cell .stage"), "舞台");
  step("what a browser has translated stays");
  assert.deepEqual(wrong, []);
  await page.context().close();
}

/** The picture changes no more, though time passes. */
async function stands(page) {
  await still(page);
  const { frames } = await page.evaluate(() => window.chladni);
  await page.waitForTimeout(1500);
  assert.equal(await page.evaluate(() => window.chladni.frames), frames, "nothing is drawn while all stands still");
}

export async function motion() {
  const { page, wrong, elsewhere, shot } = await opened({ width: 1280, height: 800 }, false);
  await moves(page, "sand on the plate");
  await page.click("#hold-still");
  await stands(page);
  const before = await page.evaluate(() => window.chladni.view().yaw_rad);
  const { frames } = await page.evaluate(() => window.chladni);
  await page.mouse.move(900, 200);
  await page.mouse.down();
  await page.mouse.move(1000, 200, { steps: 5 });
  await page.mouse.up();
  assert.notEqual(await page.evaluate(() => window.chladni.view().yaw_rad), before);
  assert.ok(await page.evaluate(() => window.chladni.frames) > frames, "a hand still turns it");
  assert.equal(await page.textContent("#hold-still"), "Let the plate move");
  await page.click("#hold-still");
  await moves(page, "the plate again");
  await page.context().close();

  const less = await opened({ width: 1280, height: 800 }, false, { reducedMotion: "reduce" });
  await until(less.page, () => window.chladni.standsAtSecs >= 6);
  await stands(less.page);
  await less.shot("laptop-still");
  assert.equal(await less.page.textContent("#hold-still"), "Let the plate move");
  await less.page.click("#hold-still");
  await moves(less.page, "the plate of those who want it to move");
  step("the front stands still where less motion is asked for, and for all who want it");
  assert.deepEqual([wrong, elsewhere, less.wrong, less.elsewhere], [[], [], [], []]);
  await less.page.context().close();
}

/** On a phone at twice its size, and with text of twice its size, everything on the front can be read and pressed. */
export async function large() {
  for (const [name, viewport, text] of [["phone-zoomed", { width: 195, height: 422 }, false], ["laptop-large-text", { width: 1280, height: 800 }, true], ["phone-large-text", { width: 390, height: 844 }, true]]) {
    const { page, wrong, shot } = await opened(viewport, false);
    if (text) await page.evaluate(() => document.documentElement.style.setProperty("font-size", "187.5%", "important"));
    await page.waitForTimeout(300);
    await shot(`${name}-front`);
    for (const id of ["enter", "exaggerate", "hold-still", "bring"]) {
      await page.locator(`#${id}`).scrollIntoViewIfNeeded();
      const box = await page.locator(`#${id}`).boundingBox();
      assert.ok(box.x >= 0 && box.y >= 0 && box.x + box.width <= viewport.width + 1 && box.y + box.height <= viewport.height + 1, `${name}: ${id} at ${JSON.stringify(box)}`);
      const hit = await page.evaluate(([x, y, id]) => document.elementFromPoint(x, y)?.closest(`#${id}`) !== null, [box.x + box.width / 2, box.y + Math.min(box.height, 20) / 2, id]);
      assert.ok(hit, `${name}: ${id} is pressed`);
    }
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name}: nothing is beside the page`);
    assert.deepEqual(wrong, []);
    await page.context().close();
  }
  const { page } = await opened({ width: 390, height: 844 }, true);
  assert.equal(await page.evaluate(() => getComputedStyle(document.getElementById("picture")).touchAction), "pinch-zoom", "two fingers enlarge the front");
  step("the front at a phone's 200 %, and with text of twice its size");
  await page.context().close();
}

/** Long names, narrow windows and a system's own colors leave in sight what is said, chosen and pressed. */
export async function inSight() {
  const { page, wrong, elsewhere } = await opened({ width: 1280, height: 800 }, false, { prepare: holdsBack });
  const rightOf = (selector) => page.evaluate((selector) => (
    Math.max(...[...document.querySelectorAll(selector)].map((each) => each.getBoundingClientRect().right))), selector);
  await page.click("#enter");
  await dances(page, "sample:octopus");
  await page.click("#more");
  const name = "01 - Some Artist - A Title of a Song (Remastered 2011).wav";
  await drop(page, [name, song(20)]);
  await songIs(page, name);
  const edge = await rightOf("#drawer");
  assert.ok(await rightOf("#song-list button, #shuffle, #volume") < edge, "the songs are as wide as the drawer");
  const mesh = `${"long_".repeat(46)}.obj`;
  await drop(page, [mesh, torus(24, 12)]);
  await dances(page, mesh);
  assert.ok(await rightOf("#shape") < 1280, "the list of shapes is as wide as the window");
  step("long names leave all in sight");

  await page.emulateMedia({ forcedColors: "active" });
  await page.click("#cells .cell:nth-child(2) .choose");
  await page.waitForSelector(".cell.chosen");
  const [mark, ...marked] = await page.evaluate(() => {
    const probe = document.body.appendChild(document.createElement("i"));
    probe.style.color = "Highlight";
    const colorOf = (element, property) => getComputedStyle(element)[property];
    const [more, cell, songPlayed] = ["#more", ".cell.chosen", "#song-list .chosen"].map((each) => document.querySelector(each));
    const colors = [colorOf(probe, "color"), colorOf(more, "backgroundColor"), colorOf(cell, "borderTopColor"), colorOf(songPlayed, "outlineColor")];
    probe.remove();
    return colors;
  });
  assert.deepEqual(marked, [mark, mark, mark], "what is chosen has the system's mark");
  await page.emulateMedia({ forcedColors: "none" });
  step("a system's own colors show what is chosen");

  await page.setViewportSize({ width: 320, height: 640 });
  await holdBack(page, "prepare narrow.obj");
  await drop(page, ["narrow.obj", torus(24, 12)]);
  await isHeldBack(page);
  await page.evaluate(() => { document.getElementById("progress").textContent = "large.obj: 100 % · 45 %"; });
  assert.ok(await rightOf("#top > *") <= 320, "the line at the top is as wide as a phone");
  assert.ok(await page.isVisible("#cancel"));
  assert.ok(await page.evaluate(() => document.getElementById("status").clientWidth > 250), "the status can be read");
  step("a phone shows what is being done");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

/** A saved picture of the stage has 2000 pixels, however few the page draws. */
export async function pictures() {
  const { readFileSync } = await import("node:fs");
  const { page, wrong } = await opened({ width: 1000, height: 700 }, false);
  await page.click("#enter");
  await until(page, () => window.chladni.state.body === "sample:octopus");
  // Nothing is drawn meanwhile.
  await page.evaluate(() => { window.requestAnimationFrame = () => 0; });
  await page.waitForTimeout(200);
  const png = readFileSync(await downloaded(page, "#save-picture"));
  const [width, height] = [png.readUInt32BE(16), png.readUInt32BE(20)];
  const { clientWidth, clientHeight } = await page.evaluate(() => { const { clientWidth, clientHeight } = document.getElementById("picture"); return { clientWidth, clientHeight }; });
  assert.equal(Math.max(width, height), 2000);
  assert.ok(Math.abs(width / height - clientWidth / clientHeight) < 0.01, `${width}×${height} of ${clientWidth}×${clientHeight}`);
  step(`a picture of the stage is saved, ${width}×${height}`);
  assert.deepEqual(wrong, []);
  await page.context().close();
}

// The page in a real browser: it opens, moves, takes a mesh and a song, breeds, exaggerates, saves and opens again.
// node web/test.mjs PAGE OUT [music|caricature|offline]; pictures of it go into OUT/screens. Projects are compared with those of
// the desktop's command where that is built.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { differing, head, launch, pixels, serve, song, torus } from "./browser.mjs";

const [folder, out] = process.argv.slice(2, 4).map((path) => resolve(path));
const only = process.argv[4];
const screens = join(out, "screens");
mkdirSync(screens, { recursive: true });
const { address, stop } = await serve(folder);
const browser = await launch(out);
const WAIT = { timeout: 180_000 };
const step = (text) => console.log(`web: ${text}`);

async function opened(viewport, touch) {
  const context = await browser.newContext({ viewport, hasTouch: touch, isMobile: touch, acceptDownloads: true });
  const page = await context.newPage();
  const wrong = [];
  const elsewhere = [];
  page.on("console", (message) => { if (message.type() === "error") wrong.push(message.text()); });
  page.on("pageerror", (error) => wrong.push(error.message));
  page.on("request", (request) => {
    const { url } = { url: request.url() };
    if (!url.startsWith(address) && !url.startsWith("blob:") && !url.startsWith("data:")) elsewhere.push(url);
    assert.equal(request.method(), "GET", "nothing is uploaded");
  });
  await page.goto(address);
  await page.waitForFunction(() => window.chladni?.frames > 3 && window.chladni.sound.duration > 0, null, WAIT);
  return { page, wrong, elsewhere, shot: (name) => page.screenshot({ path: join(screens, `${name}.png`) }) };
}

/** Until so much of the picture has changed. */
async function moves(page, what, least = 60) {
  const before = await pixels(page);
  let most = 0;
  for (let i = 0; i < 60 && most < least; i++) {
    await page.waitForTimeout(200);
    most = Math.max(most, differing(before, await pixels(page)));
  }
  assert.ok(most >= least, `${what}: only ${most} of 4000 pixels have changed`);
}

const drop = (page, name, bytes) => page.evaluate(([name, bytes]) => {
  const files = new DataTransfer();
  files.items.add(new File([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))], name));
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: files, bubbles: true, cancelable: true }));
}, [name, bytes.toString("base64")]);
const until = (page, condition, argument) => page.waitForFunction(condition, argument, WAIT);
const state = (page) => page.evaluate(() => window.chladni.state);

async function laptop() {
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
  await page.click("#back");
  await until(page, () => !window.chladni.state.on_stage);
  await page.selectOption("#look", "ember");
  await page.click("#pilot");
  await until(page, () => window.chladni.state.piloted);
  await moves(page, "the autopilot");
  await page.click("#back");
  step("stage, look and autopilot");

  await drop(page, "torus.obj", torus(60, 30));
  await until(page, () => window.chladni.state.body === "torus.obj");
  await moves(page, "a mesh that was dropped");
  await shot("laptop-mesh");
  await drop(page, "clicks.wav", song(12));
  await until(page, () => document.getElementById("song").textContent === "clicks.wav");
  await until(page, () => window.chladni.position() > 1);
  await moves(page, "a song that was dropped");
  step("a mesh and a song were dropped");

  const before = await state(page);
  const saving = page.waitForEvent("download");
  await page.click("#save-show");
  const show = join(out, "screens", "show.toml");
  await (await saving).saveAs(show);
  await page.click(".cell:nth-child(1) .choose");
  await page.click(".cell:nth-child(4) .choose");
  await page.click("#breed");
  await until(page, (generation) => window.chladni.state.generation > generation, before.generation);
  await page.setInputFiles("#file", show);
  await until(page, (generation) => window.chladni.state.generation === generation, before.generation);
  const { dances, settings } = await state(page);
  assert.deepEqual({ dances, settings }, { dances: before.dances, settings: before.settings });
  step("a show was saved and opened again");

  await drop(page, "broken.obj", Buffer.from("v 1 2\nf 1 2 3\n"));
  await until(page, () => document.getElementById("status").className === "bad");
  await drop(page, "broken.ogg", Buffer.from("OggS, but no more"));
  await until(page, () => document.getElementById("status").textContent.includes("broken.ogg"));
  await moves(page, "after broken files");
  step("broken files are reported, and the dance goes on");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

async function phone() {
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
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

// ---- the caricature room

const sitting = (page) => page.evaluate(() => window.chladni.sitting);
/** Until the shape is solved and all its layers act. */
const acts = (page) => until(page, () => {
  const { sitting } = window.chladni;
  return sitting?.solved && sitting.layers.every((layer) => layer.state === "acts");
});

/** Moves a slider as a hand does. */
const slide = (page, id, value) => page.evaluate(([id, value]) => {
  const slider = document.getElementById(id);
  slider.value = value;
  slider.dispatchEvent(new Event("input"));
  slider.dispatchEvent(new Event("change"));
}, [id, value]);

/** The picture once it changes no more. */
async function still(page) {
  let before = await pixels(page);
  for (let i = 0; i < 60; i++) {
    await page.waitForTimeout(400);
    const now = await pixels(page);
    if (now.length === before.length && differing(before, now) === 0) return now;
    before = now;
  }
  throw new Error("the picture never comes to rest");
}

async function downloaded(page, id) {
  const saving = page.waitForEvent("download");
  await page.click(id);
  const download = await saving;
  const path = join(screens, download.suggestedFilename());
  await download.saveAs(path);
  return path;
}

/** The project P of a name after these calls of the desktop's command; nothing where that is not built. */
function desktop(name, ...calls) {
  const chladni = process.env.CHLADNI ?? join(out, "../release/chladni");
  if (!existsSync(chladni)) return console.log(`web: ${chladni} is not there: projects are not compared`);
  const path = join(screens, name);
  for (const call of calls) execFileSync(chladni, call.map((word) => (word === "P" ? name : word)), { cwd: screens, stdio: "pipe" });
  return readFileSync(path, "utf8");
}

/** Checks that the page has written the bytes that the command writes. */
function same(project, calls) {
  rmSync(join(screens, "desktop.chladni"), { force: true });
  const written = desktop("desktop.chladni", ...calls);
  if (written) assert.equal(readFileSync(project, "utf8"), written);
}

async function caricatureLaptop() {
  const { page, wrong, elsewhere, shot } = await opened({ width: 1440, height: 900 }, false);
  await page.click("#exaggerate");
  await acts(page);
  const gentle = await still(page);
  await shot("laptop-caricature");
  await slide(page, "mu", -1.4);
  await until(page, () => window.chladni.sitting.layers[0].mu === -1.4);
  const strong = await still(page);
  assert.ok(differing(gentle, strong) > 100, "μ changes the face");
  same(await downloaded(page, "#save-project"), [["project", "new", "sample:head", "-k", "256", "-o", "P"],
    ["project", "add-layer", "P", "--template", "sample:template", "--name", "Plain head 1", "--mu", "-1.4"]]);
  step("a head is exaggerated");

  await page.click("#original");
  assert.ok(differing(strong, await still(page)) > 100, "the original is shown");
  await page.click("#original");
  assert.ok(differing(strong, await still(page)) < 20, "and the result again");

  await page.click("#hold-parts");
  await page.hover('#parts button:has-text("nose")');
  const pointed = await still(page);
  assert.ok(differing(strong, pointed) > 20, "the part that is pointed at is shown");
  const box = await page.locator("#picture").boundingBox();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.25 * box.height);
  await until(page, () => document.getElementById("pointed").textContent === "crown");
  await page.mouse.click(box.x + 0.5 * box.width, box.y + 0.25 * box.height);
  await until(page, () => window.chladni.sitting.layers[0].parts.join() === "crown");
  await page.click('#parts button:has-text("nose")');
  await until(page, () => window.chladni.sitting.layers[0].parts.join() === "nose,crown");
  await page.click('#parts button:has-text("crown")');
  await until(page, () => window.chladni.sitting.layers[0].parts.join() === "nose");
  await page.mouse.move(box.x + 5, box.y + 5);
  await still(page);
  await shot("laptop-parts");
  step("parts are shown and taken");

  await page.click("#undo");
  await until(page, () => window.chladni.sitting.layers[0].parts.length === 2);
  await page.click("#redo");
  await until(page, () => window.chladni.sitting.layers[0].parts.length === 1);
  await page.click("#hold-turn");
  const nosy = await still(page);
  const project = await downloaded(page, "#save-project");
  const saved = readFileSync(project, "utf8");
  const rewritten = desktop("head.chladni", ["project", "add-layer", "P", "--template", "ellipsoid"]);
  if (rewritten) {
    assert.ok(rewritten.startsWith(saved), "the command writes what it read of the page's project");
    writeFileSync(project, saved);
  }
  await page.selectOption("#add", { label: "Ellipsoid" });
  await acts(page);
  await slide(page, "mu", -0.9);
  await until(page, () => window.chladni.sitting.layers.length === 2 && window.chladni.sitting.layers[1].mu === -0.9);
  assert.ok(differing(nosy, await still(page)) > 100, "a second layer changes the face");
  await page.setInputFiles("#file", project);
  await until(page, () => window.chladni.sitting.layers.length === 1);
  await acts(page);
  assert.ok(differing(nosy, await still(page)) < 20, "a project that is opened again looks as it did");
  assert.equal(readFileSync(await downloaded(page, "#save-project"), "utf8"), saved);
  step("a project was saved and opened again");

  await page.click("#hold-brush");
  await page.click("#everywhere");
  await page.mouse.move(box.x + 0.42 * box.width, box.y + 0.3 * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.3 * box.height, { steps: 4 });
  await page.mouse.up();
  await until(page, () => !window.chladni.sitting.layers[0].everywhere && window.chladni.sitting.undo === "paint");
  await still(page);
  await shot("laptop-brush");
  step("the brush paints");

  const obj = await downloaded(page, "#export-obj");
  assert.equal(readFileSync(obj, "utf8").match(/^v /gm).length, (await sitting(page)).vertices);
  const glb = readFileSync(await downloaded(page, "#export-glb"));
  assert.equal(glb.toString("latin1", 0, 4), "glTF");
  assert.ok(glb.includes("Plain head 1"), "a layer is a slider of the GLB");
  const png = readFileSync(await downloaded(page, "#export-png"));
  assert.ok(png.readUInt32BE(16) === 2000 || png.readUInt32BE(20) === 2000, "a picture of 2000 pixels");
  step("OBJ, GLB and a picture were exported");

  await drop(page, "broken.obj", Buffer.from("v 1 2\nf 1 2 3\n"));
  await page.click('#which button[value="shape"]');
  await until(page, () => document.getElementById("status").className === "bad");
  assert.equal((await sitting(page)).shape, "sample:head");
  const own = head(72, 48);
  writeFileSync(join(screens, "plain.obj"), own);
  await drop(page, "plain.obj", own);
  await page.click('#which button[value="shape"]');
  await until(page, () => window.chladni.sitting.shape === "plain.obj" && window.chladni.sitting.solved);
  await page.selectOption("#add", { label: "Ellipsoid" });
  await slide(page, "mu", -2);
  await acts(page);
  const exaggerated = await still(page);
  await shot("laptop-own");
  const other = await downloaded(page, "#save-project");
  same(other, [["project", "new", "plain.obj", "-k", "256", "-o", "P"],
    ["project", "add-layer", "P", "--template", "ellipsoid", "--name", "Ellipsoid 1", "--mu", "-2"]]);
  await page.selectOption("#sitter", "sample:template");
  await until(page, () => window.chladni.sitting.shape === "sample:template");
  await page.setInputFiles("#file", other);
  await until(page, () => window.chladni.sitting.shape === "plain.obj");
  await acts(page);
  assert.ok(differing(exaggerated, await still(page)) < 20, "a project of a mesh that was dropped opens again");
  await page.selectOption("#sitter", "sample:head");
  await page.click("#cancel");
  await until(page, () => !document.getElementById("solve").hidden);
  await page.click("#solve");
  await until(page, () => window.chladni.sitting.solved);
  step("a solve is cancelled, and asked for again");

  await drop(page, "other.obj", head(40, 30));
  await page.click('#which button[value="template"]');
  await until(page, () => window.chladni.sitting.layers.length === 1);
  await acts(page);
  step("a dropped mesh is exaggerated, and one is compared with");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

async function caricaturePhone() {
  const { page, wrong, elsewhere, shot } = await opened({ width: 390, height: 844 }, true);
  await page.tap("#exaggerate");
  await acts(page);
  await still(page);
  await shot("phone-caricature");
  const touches = await page.context().newCDPSession(page);
  const touch = (type, ...points) => touches.send("Input.dispatchTouchEvent", {
    type, touchPoints: points.map(([x, y], id) => ({ x, y, id })),
  });
  const view = () => page.evaluate(() => window.chladni.view());
  const first = await view();
  await touch("touchStart", [150, 200]);
  for (let x = 150; x <= 250; x += 20) await touch("touchMove", [x, 200]);
  await touch("touchEnd");
  const turned = await view();
  assert.ok(Math.abs(turned.yaw_rad - first.yaw_rad) > 0.1, "a finger turns");
  await touch("touchStart", [150, 200], [250, 200]);
  for (let apart = 50; apart <= 90; apart += 10) await touch("touchMove", [200 - apart, 200], [200 + apart, 200]);
  await touch("touchEnd");
  assert.ok((await view()).distance < 0.8 * turned.distance, "two fingers pinch");
  await page.tap("#hold-parts");
  await page.touchscreen.tap(195, 120);
  await until(page, () => !window.chladni.sitting.layers[0].everywhere);
  await still(page);
  await shot("phone-parts");
  step("a phone: one finger turns, two pinch, a tap takes a part");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

// ---- without a connection

async function offline() {
  const server = await serve(folder);
  const context = await browser.newContext({ viewport: { width: 1000, height: 700 } });
  const page = await context.newPage();
  await page.goto(server.address);
  await until(page, () => window.chladni?.frames > 3 && window.chladni.sound.duration > 0);
  await until(page, async () => {
    const kept = await (await caches.open("chladni")).keys();
    return ["chladni_web_bg.wasm", "plate.body", "main.js", "worker.js"].every((name) => kept.some(({ url }) => url.endsWith(name)));
  });
  server.stop();
  await context.setOffline(true);
  await page.reload();
  await until(page, () => window.chladni?.frames > 3);
  await page.click("#exaggerate");
  await acts(page);
  step("it opens again without a connection");
  await context.close();
}

const rooms = { music: [laptop, phone], caricature: [caricatureLaptop, caricaturePhone], offline: [offline] };
try {
  for (const [room, tests] of Object.entries(rooms)) {
    if (!only || only === room) for (const test of tests) await test();
  }
} finally {
  await browser.close();
  stop();
}

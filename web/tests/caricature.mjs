// The caricature room: a head is exaggerated; projects are compared with those of the desktop's command where that is
// built.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { differing, head } from "../browser.mjs";
import { downloaded, drop, opened, out, screens, step, still, until } from "./driver.mjs";

const sitting = (page) => page.evaluate(() => window.chladni.sitting);
/** Until the shape is solved and all its layers act. */
export const acts = (page) => until(page, () => {
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

export async function laptop() {
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
  const second = await still(page);
  assert.ok(differing(nosy, second) > 100, "a second layer changes the face");
  assert.deepEqual(await page.locator("#add optgroup option").allTextContents(), ["Plain head 1"], "the topmost is not compared with itself");
  await page.selectOption("#add", { label: "Plain head 1" });
  await until(page, () => window.chladni.sitting.layers[2]?.template === "the result of Plain head 1");
  await acts(page);
  await slide(page, "mu", -1.2);
  await until(page, () => window.chladni.sitting.layers[2].mu === -1.2);
  assert.ok(differing(second, await still(page)) > 20, "what the second layer did grows");
  await page.click("#mu-value", { clickCount: 3 });
  await page.keyboard.type("-1.1");
  // The press ends the number, and the list is drawn anew.
  await page.click('#layers li:last-child [data-key$=" eye"]');
  await until(page, () => window.chladni.sitting.layers[2].mu === -1.1 && !window.chladni.sitting.layers[0].enabled);
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

  await drop(page, ["broken.obj", Buffer.from("v 1 2\nf 1 2 3\n")]);
  await page.click('#which button[value="shape"]');
  await until(page, () => document.getElementById("status").className === "bad");
  assert.equal((await sitting(page)).shape, "sample:head");
  const own = head(72, 48);
  writeFileSync(join(screens, "plain.obj"), own);
  await drop(page, ["plain.obj", own]);
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
  // Cancelled, other harmonics are no step that could be undone.
  const { undo, harmonics } = await sitting(page);
  await page.evaluate(() => {
    const field = document.getElementById("wanted-harmonics");
    field.value = "200";
    field.dispatchEvent(new Event("change"));
    document.getElementById("cancel").click();
  });
  await until(page, (count) => window.chladni.sitting.wanted_harmonics === count, harmonics);
  assert.equal((await sitting(page)).undo, undo);
  // A shape that is not solved may get fewer.
  await page.evaluate(async () => {
    const [sitter, cancel] = ["sitter", "cancel"].map((id) => document.getElementById(id));
    sitter.value = "sample:template";
    sitter.dispatchEvent(new Event("change"));
    while (cancel.hidden) await new Promise(requestAnimationFrame);
    cancel.click();
  });
  await until(page, () => !document.getElementById("solve").hidden);
  await page.fill("#wanted-harmonics", "64");
  await page.press("#wanted-harmonics", "Enter");
  await until(page, () => window.chladni.sitting.solved && window.chladni.sitting.harmonics === 64);
  await page.selectOption("#sitter", "sample:head");
  await until(page, () => window.chladni.sitting.shape === "sample:head" && window.chladni.sitting.solved);
  step("a solve is cancelled, and asked for again, or for other harmonics");

  await drop(page, ["other.obj", head(40, 30)]);
  await page.click('#which button[value="template"]');
  await until(page, () => window.chladni.sitting.layers.length === 1);
  await acts(page);
  step("a dropped mesh is exaggerated, and one is compared with");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

export async function phone() {
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
  await page.tap("#hold-brush");
  await touch("touchStart", [185, 200]);
  await touch("touchStart", [185, 200], [215, 200]);
  for (const x of [225, 240, 230, 215]) await touch("touchMove", [185, 200], [x, 200]);
  await touch("touchEnd");
  assert.notEqual(await page.evaluate(() => window.chladni.sitting.undo), "paint", "two fingers paint nothing");
  await touch("touchStart", [185, 200]);
  for (let x = 185; x <= 215; x += 5) await touch("touchMove", [x, 200]);
  await touch("touchEnd");
  await until(page, () => window.chladni.sitting.undo === "paint");
  await page.tap("#undo");
  await until(page, () => window.chladni.sitting.undo !== "paint");
  await page.touchscreen.tap(195, 200);
  await until(page, () => window.chladni.sitting.undo === "paint");
  step("a phone: one finger turns or paints, two pinch, a tap takes a part");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

// The chosen layer of the caricature room: its scale drawn by hand, and its three models beside each other.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { differing } from "../browser.mjs";
import { acts } from "./caricature.mjs";
import { downloaded, opened, step, still, until } from "./driver.mjs";

const curveOf = (page) => page.evaluate(() => window.chladni.sitting.layers.at(-1).curve);

async function scale(page, shot) {
  const plain = await still(page);
  await page.click("#drawn-scale summary");
  await page.waitForFunction(() => document.getElementById("scale-curve").width > 100);
  await page.locator("#drawn-scale").scrollIntoViewIfNeeded();
  const box = await page.locator("#scale-curve").boundingBox();
  const at = (x, y) => [box.x + x * box.width, box.y + y * box.height];
  await page.mouse.move(...at(0.1, 0.8));
  const [clientX, clientY] = at(0.45, 0.15);
  const right = { button: 2, buttons: 2, pointerId: 1, pointerType: "mouse", clientX, clientY };
  await page.locator("#scale-curve").dispatchEvent("pointerdown", right);
  assert.equal(await curveOf(page), "smooth", "another button draws nothing");
  await page.mouse.down();
  await page.mouse.move(...at(0.45, 0.15), { steps: 12 });
  await page.mouse.move(...at(0.7, 0.7), { steps: 12 });
  await page.mouse.up();
  await until(page, () => window.chladni.sitting.layers.at(-1).curve === "");
  assert.ok(differing(plain, await still(page)) > 60, "the shape follows what is drawn");
  await shot("scale");
  // It is one step, and the same curve that the desktop reads.
  const project = readFileSync(await downloaded(page, "#save-project"), "utf8");
  const drawn = JSON.parse(project.match(/points = (\[\[.*\]\])/)?.[1] ?? "[]");
  assert.ok(drawn.length > 8, project);
  assert.ok(drawn.every(([wave, gain], i) => (i === 0 || wave < drawn[i - 1][0]) && gain >= 0 && gain <= 4));
  await page.click("#undo");
  await until(page, () => window.chladni.sitting.layers.at(-1).curve === "smooth");
  assert.ok(differing(plain, await still(page)) < 20, "one stroke is one step");
  // The same by keys: to the right, and up.
  await page.focus("#scale-curve");
  const words = () => page.getAttribute("#scale-curve", "aria-valuetext");
  for (let i = 0; i < 4; i++) await page.keyboard.press("ArrowRight");
  const before = await words();
  assert.match(before, /^Waves of [\d.]+ % of its size: ×\d\.\d\d$/);
  for (let i = 0; i < 3; i++) await page.keyboard.press("ArrowUp");
  const after = await words();
  assert.ok(Number(after.split("×")[1]) > Number(before.split("×")[1]), `${before}, then ${after}`);
  assert.equal(await curveOf(page), "");
  await page.focus("#finest");
  for (let i = 0; i < 5; i++) await page.keyboard.press("ArrowRight");
  await until(page, () => document.getElementById("finest-value").textContent === "×0.05");
  await page.selectOption("#curve", "smooth");
  await until(page, () => window.chladni.sitting.layers.at(-1).curve === "smooth");
  step("the scale of a layer is drawn by pointer and by keys");
}

async function models(page, shot) {
  const alone = await still(page);
  await page.click("#models");
  const names = () => page.locator("#cells .cell .choose").allTextContents();
  await until(page, () => document.querySelectorAll("#cells .cell").length === 4);
  assert.deepEqual(await names(), ["Coordinate", "Normal", "Distance", "Original"]);
  const before = await still(page);
  assert.ok(differing(alone, before) > 60);
  await shot("models");
  await page.focus("#mu");
  for (let i = 0; i < 40; i++) await page.keyboard.press("ArrowLeft");
  assert.ok(differing(before, await still(page)) > 40, "all of them follow the layer");
  assert.ok(await page.isDisabled("#cells .cell:nth-child(4) .choose"), "nothing is chosen by the original");
  const box = await page.locator("#cells .cell:nth-child(2)").boundingBox();
  await page.focus("#cells .cell:nth-child(2) .choose");
  await page.keyboard.press("Enter");
  await until(page, () => window.chladni.sitting.layers.at(-1).model === "normal");
  await until(page, () => document.querySelector("#cells .cell:nth-child(2)").classList.contains("chosen"));
  // A drag turns all of them, and chooses none.
  const seen = await still(page);
  await page.mouse.move(box.x + 0.3 * box.width, box.y + 0.5 * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.6 * box.width, box.y + 0.5 * box.height, { steps: 5 });
  await page.mouse.up();
  assert.ok(differing(seen, await still(page)) > 60);
  // Tools work on the result.
  await page.click("#hold-brush");
  await until(page, () => !window.chladni.sitting.in_models && !document.querySelector("#cells .cell"));
  await page.click("#hold-turn");
  step("the three models stand beside the original, and a press takes one");
}

export async function chosen() {
  for (const [name, viewport, touch] of [["laptop", { width: 1440, height: 900 }, false], ["phone", { width: 390, height: 844 }, true]]) {
    const { page, wrong, elsewhere, shot } = await opened(viewport, touch);
    await page.click("#exaggerate");
    await acts(page);
    await scale(page, (what) => shot(`${name}-${what}`));
    await models(page, (what) => shot(`${name}-${what}`));
    assert.deepEqual([wrong, elsewhere], [[], []]);
    await page.context().close();
  }
}

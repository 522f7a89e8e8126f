// The music room: it moves, breeds, takes a mesh and a song, saves and opens again.
import assert from "node:assert/strict";
import { join } from "node:path";
import { song, torus } from "../browser.mjs";
import { drop, moves, opened, screens, state, step, until } from "./driver.mjs";

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

  await drop(page, ["torus.obj", torus(60, 30)]);
  await until(page, () => window.chladni.state.body === "torus.obj");
  await moves(page, "a mesh that was dropped");
  await shot("laptop-mesh");
  await drop(page, ["clicks.wav", song(12)]);
  await until(page, () => document.getElementById("song").textContent === "clicks.wav");
  await until(page, () => window.chladni.position() > 1);
  await moves(page, "a song that was dropped");
  step("a mesh and a song were dropped");

  const before = await state(page);
  const saving = page.waitForEvent("download");
  await page.click("#save-show");
  const show = join(screens, "show.toml");
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

  await drop(page, ["broken.obj", Buffer.from("v 1 2\nf 1 2 3\n")]);
  await until(page, () => document.getElementById("status").className === "bad");
  await drop(page, ["broken.ogg", Buffer.from("OggS, but no more")]);
  await until(page, () => document.getElementById("status").textContent.includes("broken.ogg"));
  await moves(page, "after broken files");
  step("broken files are reported, and the dance goes on");

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
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

// The page while it begins: before its plate or its tune is there, and on a slow or a broken network.
import assert from "node:assert/strict";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { song } from "../browser.mjs";
import { address, browser, dances, drop, empty, folder, says, songIs, songNow, step, until } from "./driver.mjs";
import { holdsBack, release } from "./held.mjs";

const LAPTOP = { width: 1280, height: 800 };

/** The page before its plate is there. */
export async function beginnings() {
  const context = await browser.newContext({ viewport: LAPTOP });
  for (const brings of [false, true]) {
    const page = await empty(context);
    const wrong = [];
    page.on("pageerror", (error) => wrong.push(error.message));
    await page.addInitScript(holdsBack);
    // The plate has to be solved for; with a song, the tune comes late.
    const holds = brings ? "sample:" : "prepare";
    await page.addInitScript((holds) => { window.missing = "plate.body"; window.holds = holds; }, holds);
    await page.goto(address);
    await until(page, (least) => window.heldBack?.() >= least, brings ? 2 : 1);
    if (brings) {
      await drop(page, ["clicks.wav", song(30)]);
      await songIs(page, "clicks.wav");
      await release(page);
      await page.waitForTimeout(5000);
      const secs = await page.evaluate(() => Math.round(window.chladni.sound.duration));
      assert.deepEqual([await songNow(page), secs], ["clicks.wav", 30], "the tune does not take its place");
    } else await page.click("#enter");
    await dances(page, "sample:octopus");
    await until(page, () => window.chladni.sound.duration > 0);
    assert.deepEqual(wrong, []);
    await page.close();
  }
  await context.close();
  step("without waiting for the plate there is the octopus, and a song");
}

/** A page that begins where this holds of its window. */
async function begun(what) {
  const page = await empty(await browser.newContext({ viewport: LAPTOP }));
  await page.addInitScript(holdsBack);
  await page.addInitScript((what) => { Object.assign(window, what); }, what);
  await page.goto(address);
  return page;
}

/** The tune whose worker stopped is decoded again once it is to be heard. */
export async function lostTune() {
  const page = await begun({ breaks: "decode sample:tune" });
  await says(page, "it broke");
  await page.evaluate(() => { window.breaks = undefined; });
  await page.click("#enter");
  await until(page, () => window.chladni.sound.isHeard && document.getElementById("play").textContent === "Pause");
  assert.equal(await songNow(page), "Our own tune");
  await page.context().close();
  step("the tune that was lost comes when it is to be heard");
}

/** No film is made of a song that is not there. */
export async function withoutSong() {
  const page = await begun({ holds: "decode sample:tune" });
  await page.click("#enter");
  await dances(page, "sample:octopus");
  await page.click("#film-song");
  await page.click("#film-begin");
  await says(page, "There is no song yet");
  await until(page, () => !document.getElementById("whole-film").open);
  await page.context().close();
  step("a film of a song waits until there is one");
}

/** A slow network, and a broken one: what cannot be done yet says so, and the reason of a failure stays. */
export async function slowly() {
  const context = await browser.newContext({ viewport: LAPTOP, serviceWorkers: "block" });
  const page = await empty(context);
  const held = new Map();
  await page.route(/chladni_web_bg\.wasm|octopus\.body/, (route) => {
    held.set(route.request().url().split("/").at(-1), route);
  });
  const comes = async (name) => {
    for (let i = 0; i < 300 && !held.has(name); i++) await page.waitForTimeout(100);
    return held.get(name);
  };
  await page.goto(address);
  const module = await comes("chladni_web_bg.wasm");
  const rests = (id) => page.evaluate((id) => document.getElementById(id).matches(":disabled, [inert]"), id);
  assert.ok(await page.isVisible("#loading"));
  for (const id of ["enter", "exaggerate", "bring", "hold-still"]) assert.ok(await rests(id), id);
  const stays = await page.evaluate(() =>
    !document.body.dispatchEvent(new DragEvent("drop", { bubbles: true, cancelable: true })));
  assert.ok(stays, "a file that is dropped does not take the page's place");
  await module.continue();
  await page.click("#enter");
  assert.ok(await page.isHidden("#loading"));
  // The octopus is on its way.
  const octopus = await comes("octopus.body");
  // Unless the plate was faster than the press.
  const hasShape = () => page.evaluate(() => !!window.chladni.state);
  assert.ok(await rests("breed") || await hasShape(), "what needs a shape rests until there is one");
  for (const id of ["open", "more", "play"]) assert.ok(!await rests(id), id);
  await octopus.continue();
  await dances(page, "sample:octopus");
  assert.ok(!await page.evaluate(() => document.querySelector("#controls [inert], #drawer [inert]")));

  await page.unrouteAll();
  await page.route(/chladni_web_bg\.wasm/, (route) => route.abort());
  await page.goto(`${address}?anew`);
  await until(page, () => document.getElementById("loading").textContent.startsWith("Chladni could not be loaded"));
  assert.ok(await rests("enter"));
  await page.unrouteAll();
  await page.route(/\/wall\.js/, (route) => route.abort());
  await page.goto(`${address}?again`);
  await until(page, () =>
    document.getElementById("loading").textContent === "A part of the page did not come: open it again.");
  await page.goto(pathToFileURL(join(folder, "index.html")).href);
  await until(page, () => document.getElementById("loading").textContent.startsWith("This page needs a file server"));
  await context.close();
  step("a slow network is waited for, and a broken one is called so");
}

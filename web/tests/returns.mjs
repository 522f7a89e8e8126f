// What a person finds again: dances after a visit to the front, a show that was danced elsewhere, layers that no file has.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { head, song } from "../browser.mjs";
import { acts } from "./caricature.mjs";
import { dances as shapeDances, downloaded, drop, moves, opened, says, state, step, until } from "./driver.mjs";

const generation = (page, number) => until(page, (number) => window.chladni.state.generation === number, number);

async function breed(page) {
  const { generation: before } = await state(page);
  await page.click("#cells .cell:nth-child(2) .choose");
  await page.click("#cells .cell:nth-child(7) .choose");
  await page.click("#breed");
  await generation(page, before + 1);
}

/** Presses a button; gives where the song is right after that, and the dance's clock. */
const pressed = (page, id) => page.evaluate(async (id) => {
  const { clockSecs } = await import("./shows.js");
  document.getElementById(id).click();
  return [window.chladni.position(), clockSecs(performance.now())];
}, id);

/** Its text, and its action times. */
async function saved(page) {
  const text = readFileSync(await downloaded(page, "#save-show"), "utf8");
  return { text, lasts: Number(/^duration_secs = (.*)$/m.exec(text)[1]), times: [...text.matchAll(/^at_secs = (.*)$/gm)].map(([, secs]) => Number(secs)) };
}

export async function dances() {
  const { page, wrong, elsewhere } = await opened({ width: 1440, height: 900 }, false);
  await page.click("#enter");
  await shapeDances(page, "sample:octopus");
  await breed(page);
  await page.click("#home");
  await shapeDances(page, "sample:plate");
  await page.click("#exaggerate");
  await acts(page);
  await page.click("#home");
  await shapeDances(page, "sample:plate");
  await page.click("#enter");
  await generation(page, 1);
  await moves(page, "dances that were left for a while");
  step("dances are there again after a visit to the front and the other room");

  // A cover is none of the page's; the song beside it plays.
  await drop(page, ["cover.jpg", Buffer.from([255, 216, 255])], ["kl\u00e4nge.wav", song(20)]);
  await until(page, () => document.getElementById("song").textContent === "kl\u00e4nge.wav" && window.chladni.position() > 0.5);
  // The song and the dance go on where the room was left.
  const [position, clock] = await pressed(page, "home");
  await shapeDances(page, "sample:plate");
  await page.waitForTimeout(4000);
  const [positionThen, clockThen] = await pressed(page, "enter");
  assert.ok(Math.abs(positionThen - position) < 1 && Math.abs(clockThen - clock) < 1, `left at ${position} and ${clock} s, found at ${positionThen} and ${clockThen} s`);
  await until(page, () => window.chladni.state.body === "sample:octopus" && window.chladni.sound.isHeard);
  await page.click("#sand");
  await until(page, () => window.chladni.state.sand && window.chladni.state.on_stage);
  const first = await saved(page);
  assert.ok(first.lasts > 0 && first.lasts >= Math.max(...first.times), `a show lasts ${first.lasts} s`);

  // As the desktop saves it: its song lies elsewhere, on a Mac that writes accents apart.
  const place = '"/Users/somebody/My Music/kla\u0308nge.wav"';
  const theirs = first.text.replace('"kl\u00e4nge.wav"', place);
  assert.notEqual(theirs, first.text);
  await drop(page, ["theirs.toml", Buffer.from(theirs)]);
  await says(page, "theirs.toml is open.");
  await page.waitForTimeout(500);
  const later = await saved(page);
  assert.ok(later.lasts > first.lasts, "a show goes on where it ended");
  assert.ok(later.text.includes(place), "its song lies where it lay");
  await page.click("#play-show");
  await until(page, () => window.chladni.state.played && window.chladni.state.generation === 0);
  await page.click("#play-show");
  await until(page, () => !window.chladni.state.played);
  await drop(page, ["theirs.toml", Buffer.from(theirs)]);
  await until(page, () => window.chladni.state.sand);
  await page.click("#sand");
  await until(page, () => !window.chladni.state.sand && !window.chladni.state.on_stage);
  step("a show whose song lies elsewhere is played, and its sand is swept off");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

/** Another shape has dances of its own; the settings and a chosen look stay. */
export async function settings() {
  const { page, wrong, elsewhere } = await opened({ width: 1440, height: 900 }, false);
  const dancesOn = async (name) => {
    await page.selectOption("#shape", name);
    await shapeDances(page, name);
  };
  await page.click("#enter");
  await shapeDances(page, "sample:octopus");
  await page.click("#more");
  await page.evaluate(() => { for (const each of document.querySelectorAll("#drawer details")) each.open = true; });
  await page.uncheck('#effects [value="glow"]');
  await dancesOn("sample:bell");
  assert.deepEqual((await state(page)).looks, { look: "gold", without: ["glow"] }, "nobody has chosen another");
  await page.selectOption("#gallery-size", "9");
  await page.selectOption("#form", "modal");
  await page.selectOption("#timbre", "bell");
  await page.locator("#knobs").getByRole("checkbox", { name: "In any field of view", exact: true }).check();
  await page.selectOption("#look", "ember");
  const before = await state(page);
  assert.ok(before.settings.switches["flash-fields"]);
  await page.click("#sand");
  await until(page, () => window.chladni.state.sand);
  await dancesOn("sample:cat");
  const { settings: after, looks, dances: items, sand } = await state(page);
  assert.deepEqual({ after, looks }, { after: before.settings, looks: { look: "ember", without: ["glow"] } });
  assert.deepEqual([items.length, sand], [9, false]);
  step("knobs, switches, form, timbre, look and the size of the gallery stay when another shape dances");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

/** Shows are opened: dances that no file has are asked about, and stay where the show cannot be danced. */
export async function galleries() {
  const asked = [];
  let yes = false;
  const answers = (type) => { asked.push(type); return yes; };
  const { page, wrong, elsewhere } = await opened({ width: 1440, height: 900 }, false, { answers });
  await page.click("#enter");
  await shapeDances(page, "sample:octopus");
  await breed(page);
  const { text } = await saved(page);
  const cat = text.replace("sample:octopus", "sample:cat");
  assert.notEqual(cat, text);
  await breed(page);
  for (const show of [text, cat]) {
    asked.length = 0;
    await drop(page, ["show.toml", Buffer.from(show)]);
    await says(page, "The show is not open");
    assert.deepEqual(asked, ["confirm"]);
  }
  yes = true;
  // There is no hundredth dance: nobody can tell before the show is danced.
  for (const show of [text, cat]) {
    await drop(page, ["broken.toml", Buffer.from(show.replace("item = 1\n", "item = 99\n"))]);
    await says(page, "broken.toml: ");
    const { body, generation: now } = await state(page);
    assert.deepEqual([body, now], ["sample:octopus", 2], "dances stay until the show is open");
    assert.ok(await page.isHidden("#play-show"));
  }
  asked.length = 0;
  await drop(page, ["cat.toml", Buffer.from(cat)]);
  await says(page, "cat.toml is open.");
  assert.deepEqual(asked, ["confirm"], "dances were still unsaved");
  const { body } = await state(page);
  assert.equal(body, "sample:cat");
  await generation(page, 1);
  asked.length = 0;
  await drop(page, ["cat.toml", Buffer.from(cat)]);
  await says(page, "cat.toml is open.");
  assert.deepEqual(asked, [], "nobody is asked about a show that is in its file");
  // Nor are they lost where it is played.
  await breed(page);
  yes = false;
  await page.click("#play-show");
  await says(page, "The show is not played");
  assert.deepEqual(asked, ["confirm"]);
  await generation(page, 2);
  yes = true;
  await page.click("#play-show");
  await until(page, () => window.chladni.state.played && window.chladni.state.generation === 0);
  await page.click("#play-show");
  await until(page, () => !window.chladni.state.played);
  asked.length = 0;
  await drop(page, ["cat.toml", Buffer.from(cat)]);
  await says(page, "cat.toml is open.");
  assert.deepEqual(asked, [], "what was played is in its file");
  // Where a dance is locked, nothing is lost.
  await page.locator("#cells .cell:nth-child(4) .lock").dispatchEvent("click");
  // Favorites stay when another gallery begins: they are asked about, too.
  await page.locator("#cells .cell:nth-child(3) .favor").dispatchEvent("click");
  for (const from of [1, 2]) {
    const { seed } = await state(page);
    await page.locator("#other-dances").dispatchEvent("click");
    await until(page, (before) => window.chladni.state.seed !== before, seed);
    assert.deepEqual(asked, [], `favorites stay: gallery ${from}`);
  }
  await generation(page, 0);
  yes = false;
  asked.length = 0;
  await drop(page, ["cat.toml", Buffer.from(cat)]);
  await says(page, "The show is not open");
  assert.deepEqual(asked, ["confirm"]);
  step("unsaved dances are asked about before a show, and stay where it cannot be danced");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

/** Whoever has gone on while the shape of a show loads finds no show opened there. */
export async function overtaken() {
  // The cat comes when it is told to.
  const prepare = () => {
    const { fetch } = window;
    window.fetch = async (what, ...rest) => {
      if (what !== "bodies/cat.body") return fetch(what, ...rest);
      await new Promise((done) => { window.comes = done; });
      const cat = await fetch(what, ...rest);
      window.comes = undefined;
      return cat;
    };
  };
  const { page, wrong, elsewhere } = await opened({ width: 1440, height: 900 }, false, { prepare });
  await page.click("#enter");
  await shapeDances(page, "sample:octopus");
  await breed(page);
  const cat = (await saved(page)).text.replace("sample:octopus", "sample:cat");
  const ways = [
    ["sample:bell", () => page.selectOption("#shape", "sample:bell")],
    ["sample:plate", () => page.click("#home")],
  ];
  for (const [body, goOn] of ways) {
    await drop(page, ["cat.toml", Buffer.from(cat)]);
    await until(page, () => window.comes);
    await goOn();
    await shapeDances(page, body);
    const { seed } = await state(page);
    await page.evaluate(() => window.comes());
    await until(page, () => !window.comes);
    await page.waitForTimeout(1000);
    const now = await state(page);
    assert.deepEqual([now.body, now.seed], [body, seed]);
    assert.ok(await page.evaluate(() => document.getElementById("play-show").hidden), "no show was opened");
  }
  step("a show whose shape was overtaken by another wish does not open");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

export async function layers() {
  const asked = [];
  let yes = false;
  const answers = (type) => { asked.push(type); return yes; };
  const { page, wrong, elsewhere } = await opened({ width: 1440, height: 900 }, false, { answers });
  await drop(page, ["mask.npy", Buffer.from("no mask")]);
  await says(page, "choose a shape first");
  assert.equal(await page.evaluate(() => document.body.dataset.view), "front");
  await page.click("#exaggerate");
  await acts(page);

  // The focus stays where it was, though the list is drawn anew.
  await page.focus("#layers [data-key$=' eye']");
  await page.keyboard.press("Enter");
  await until(page, () => !window.chladni.sitting.layers[0].enabled);
  await page.keyboard.press("Enter");
  await until(page, () => window.chladni.sitting.layers[0].enabled);
  assert.match(await page.getAttribute(":focus", "aria-label"), /^Show /, "whether it is shown is said besides");
  await page.focus("#layers [data-key$=' delete']");
  await page.keyboard.press("Enter");
  await until(page, () => !window.chladni.sitting.layers.length && document.activeElement.id === "add");
  await page.click("#undo");
  await until(page, () => window.chladni.sitting.layers.length === 1);
  await page.click("#layers .name");
  await acts(page);

  await page.focus("#mu");
  await page.keyboard.press("ArrowLeft");
  await until(page, () => window.chladni.sitting.modified);
  await page.selectOption("#sitter", "sample:template");
  await until(page, () => window.chladni.sitting.shape === "sample:head");
  assert.deepEqual(asked, ["confirm"]);
  await says(page, "The shape has stayed");
  yes = true;
  await page.selectOption("#sitter", "sample:template");
  await until(page, () => window.chladni.sitting.shape === "sample:template" && window.chladni.sitting.solved);
  await page.selectOption("#sitter", "sample:head");
  await until(page, () => window.chladni.sitting.shape === "sample:head" && window.chladni.sitting.solved);
  assert.deepEqual(asked, ["confirm", "confirm"], "nobody is asked where there are no layers");

  // Two meshes are asked about one after the other.
  await drop(page, ["one.obj", head(24, 16)]);
  await page.waitForSelector("#which[open]");
  await drop(page, ["two.obj", head(20, 14)]);
  await page.waitForTimeout(300);
  assert.equal(await page.textContent("#which-name"), "one.obj");
  await page.click('#which button[value=""]');
  await until(page, () => document.getElementById("which-name").textContent === "two.obj" && document.getElementById("which").open);
  await page.click('#which button[value="template"]');
  await until(page, () => window.chladni.sitting.layers.length === 1);
  await acts(page);

  // A project of a file that has lost its last layer is one still.
  asked.length = 0;
  yes = false;
  await downloaded(page, "#save-project");
  await page.click("#layers [data-key$=' delete']");
  await until(page, () => !window.chladni.sitting.layers.length);
  await page.selectOption("#sitter", "sample:template");
  await says(page, "The shape has stayed");
  assert.deepEqual([asked, await page.evaluate(() => window.chladni.sitting.shape)], [["confirm"], "sample:head"]);
  await page.click("#undo");
  await until(page, () => window.chladni.sitting.layers.length === 1);
  await acts(page);
  yes = true;

  // A second press, while the gallery opens, does not open another.
  await page.evaluate(() => {
    const post = Worker.prototype.postMessage;
    window.opened = 0;
    Worker.prototype.postMessage = function (message, ...rest) { if (message.work === "openWall") window.opened++; return post.call(this, message, ...rest); };
    for (let i = 0; i < 3; i++) document.getElementById("gallery").click();
  });
  await until(page, () => window.chladni.wall && document.querySelectorAll("#cells .cell").length === 12);
  assert.equal(await page.evaluate(() => window.opened), 1);
  await page.click("#gallery");
  await until(page, () => !window.chladni.wall);

  // What is cancelled is what is worked on: an open gallery stays.
  await page.click("#gallery");
  await until(page, () => window.chladni.wall);
  const names = await page.evaluate(() => window.chladni.wall.items.map(({ name }) => name));
  await page.evaluate(() => document.getElementById("cancel").click());
  await page.click("#wall-others");
  await until(page, (name) => window.chladni.wall.items[0].name !== name, names[0]);
  step("unsaved layers are asked for, the focus stays, and a cancel leaves what rests");

  // Back leaves no question behind, nor one that waits for its answer.
  await drop(page, ["three.obj", head(22, 14)]);
  await page.waitForSelector("#which[open]");
  await drop(page, ["four.obj", head(22, 16)]);
  await page.goBack();
  await until(page, () => document.body.dataset.view === "front");
  await page.waitForTimeout(300);
  assert.equal(await page.locator("dialog[open]").count(), 0);
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

// What people do in another order than one would think.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { basename } from "node:path";
import { head, song } from "../browser.mjs";
import { address, browser, downloaded, downloading, drop, opened, step, until } from "./driver.mjs";

const click = (page, selector) => page.locator(selector).dispatchEvent("click");

/** A browser's ways to keep a screen awake, and to ask what sound is for. */
const asksBrowser = () => {
  window.locks = [];
  const request = async () => {
    const lock = { released: false, release: async () => { lock.released = true; } };
    window.locks.push(lock);
    return lock;
  };
  Object.defineProperty(navigator, "wakeLock", { value: { request } });
  Object.defineProperty(navigator, "audioSession", { value: { type: "auto" } });
};

export async function music() {
  const { page, wrong, elsewhere } = await opened({ width: 1366, height: 768 }, false, { prepare: asksBrowser });
  await page.click("#enter");
  await until(page, () => window.chladni.state.body === "sample:octopus");
  // While it dances aloud the screen stays awake, after a visit to another tab, too.
  const locks = (...released) => until(page, (released) => JSON.stringify(window.locks.map((lock) => lock.released)) === released, JSON.stringify(released));
  await locks(false);
  assert.equal(await page.evaluate(() => navigator.audioSession.type), "playback");
  await page.evaluate(() => { window.locks[0].released = true; document.dispatchEvent(new Event("visibilitychange")); });
  await locks(true, false);
  await page.click("#play");
  await locks(true, true);
  await page.click("#play");
  await locks(true, true, false);
  step("the screen stays awake while a shape dances");
  // The system interrupts the sound, as by a call: the song goes on once it may, and Play says which it is.
  const playSays = (text) => until(page, (text) => document.getElementById("play").textContent === text, text);
  await playSays("Pause");
  await page.evaluate(() => {
    const { context } = window.chladni.sound;
    context.resume = () => Promise.reject(new DOMException("a call", "InvalidStateError"));
    return context.suspend();
  });
  await playSays("Play");
  const at = await page.evaluate(() => window.chladni.sound.position());
  await until(page, (at) => window.chladni.sound.position() !== at, at);
  await page.evaluate(() => { delete window.chladni.sound.context.resume; });
  await page.click("#play");
  await playSays("Pause");
  await page.evaluate(() => window.chladni.sound.context.suspend());
  await until(page, () => window.chladni.sound.isHeard);
  step("a song goes on after an interruption");
  // The dance on stage is the one that is saved.
  await click(page, "#cells .cell:nth-child(5) .stage");
  await until(page, () => window.chladni.state.on_stage);
  const saved = readFileSync(await downloaded(page, "#save-preset"), "utf8");
  await page.click("#back");
  await until(page, () => !window.chladni.state.on_stage);
  const first = readFileSync(await downloaded(page, "#save-preset"), "utf8");
  assert.notEqual(saved, first);
  // Sand goes with the stage, whoever put it there.
  for (const leave of ["#back", "#pilot"]) {
    await page.click("#sand");
    await page.click("#pilot");
    await until(page, () => window.chladni.state.piloted);
    await page.click(leave);
    await until(page, () => !window.chladni.state.piloted && !window.chladni.state.sand);
    assert.equal(await page.isDisabled("#back"), !(await page.evaluate(() => window.chladni.state.on_stage)));
    if (await page.isEnabled("#back")) await page.click("#back");
  }
  // It takes the stage from the autopilot.
  await page.click("#pilot");
  await until(page, () => window.chladni.state.piloted);
  // A text that cannot be read ends nothing, and is called what it was meant as.
  await drop(page, ["newer.toml", Buffer.from("format_version = 99\nactions = []\n")]);
  await until(page, () => document.getElementById("status").textContent.startsWith("newer.toml: show format version 99"));
  assert.ok(await page.evaluate(() => window.chladni.state.piloted));
  await page.click("#sand");
  await until(page, () => window.chladni.state.sand && !window.chladni.state.piloted);
  assert.equal(await page.evaluate(() => window.chladni.state.settings.form), "modal", "it is set up for sand");
  await page.click("#back");
  await until(page, () => !window.chladni.state.sand && !window.chladni.state.on_stage);
  step("the dance on stage is saved, and sand leaves with it");
  // Songs that are passed over quickly are passed over.
  await drop(page, ...["a", "b", "c", "d", "e"].map((name) => [`${name}.wav`, song(4)]));
  await until(page, () => document.getElementById("song").textContent === "1 of 5: a.wav");
  for (let i = 0; i < 3; i++) await page.click("#next");
  await until(page, () => document.getElementById("song").textContent === "4 of 5: d.wav");
  assert.match(await page.getAttribute("#seek", "aria-valuetext"), /^0:0\d of 0:04$/);
  step("three songs are passed over by three presses");
  // What is wrong with a song is said once, though it is decoded in each round.
  const cut = song(3);
  await page.reload();
  await until(page, () => window.chladni?.frames > 3 && window.chladni.sound.duration > 0);
  await page.evaluate(() => {
    window.said = [];
    const status = document.getElementById("status");
    new MutationObserver(() => window.said.push(status.textContent)).observe(status, { childList: true, characterData: true, subtree: true });
  });
  await drop(page, ["whole.wav", song(2)], ["cut.wav", cut.subarray(0, cut.length - 60000)]);
  for (let round = 0; round < 3; round++) {
    for (const name of ["1 of 2: whole.wav", "2 of 2: cut.wav"]) {
      await until(page, (name) => document.getElementById("song").textContent === name, name);
      await page.click("#next");
    }
  }
  const warned = await page.evaluate(() => window.said.filter((text) => text.includes("cut.wav:") && !text.includes("decoding")));
  assert.equal(warned.length, 1, warned.join(" / "));
  // A list says in which order its songs play; what it names besides is asked for.
  await drop(page, ["b.wav", song(30)], ["a.wav", song(30)], ["set.m3u", Buffer.from("#EXTM3U\r\nmusic\\a.wav\r\nb.wav\r\ngone.mp3\r\n")]);
  await until(page, () => document.getElementById("song").textContent === "3 of 4: a.wav" && /together with the list: gone.mp3/.test(document.getElementById("status").textContent));
  await page.click("#more");
  // Taken out, the one that plays makes room for the next.
  await page.click('#song-list [aria-label="Take a.wav out of the list"]');
  await until(page, () => document.getElementById("song").textContent === "3 of 3: b.wav");
  await page.click('#song-list [aria-label="Take cut.wav out of the list"]');
  await until(page, () => document.getElementById("song").textContent === "2 of 2: b.wav");
  await page.fill("#volume", "20");
  assert.ok(Math.abs(await page.evaluate(() => window.chladni.sound.loudness.gain.value) - 0.2) < 1e-6);
  await page.selectOption("#repeat", "song");
  assert.ok(await page.evaluate(() => window.chladni.sound.source.loop), "the same song again");
  await page.click('#song-list .name:has-text("whole.wav")');
  await until(page, () => document.getElementById("song").textContent === "1 of 2: whole.wav");
  await page.selectOption("#repeat", "off");
  await page.click("#next");
  await until(page, () => document.getElementById("song").textContent === "2 of 2: b.wav");
  await page.fill("#seek", "0.99");
  await until(page, () => !window.chladni.sound.isHeard && window.chladni.position() === 0);
  // Where the browser holds the sound back, a song is in the list all the same.
  await page.evaluate(() => { AudioContext.prototype.resume = () => Promise.reject(new DOMException("held back", "InvalidStateError")); });
  await drop(page, ["held.wav", song(30)]);
  await until(page, () => document.getElementById("song").textContent === "3 of 3: held.wav");
  await drop(page, ["letter.pdf", Buffer.from("%PDF")], ["cover.jpg", Buffer.from([255, 216])]);
  await until(page, () => /^(letter.pdf|cover.jpg): the page opens meshes/.test(document.getElementById("status").textContent));
  // Its file is written to after it was chosen.
  await page.evaluate(() => {
    Blob.prototype.arrayBuffer = () => Promise.reject(new DOMException("permission problems", "NotReadableError"));
  });
  await drop(page, ["changed.wav", song(3)]);
  await until(page, () => document.getElementById("status").textContent.startsWith("changed.wav cannot be read: it has changed"));
  step("a damaged song is reported once, and what is none of the page's is refused");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

const MESH = head(24, 16);
const PROJECT = Buffer.from(`format_version = 4\nlayer = []\n\n[shape]\nsource = "dent.obj"\nharmonics = 32\n`);

export async function caricature() {
  const { page, wrong, elsewhere, shot } = await opened({ width: 390, height: 844 }, true);
  // A project comes without its mesh, which is then brought on its own.
  await page.setInputFiles("#file", { name: "dent.chladni", mimeType: "text/plain", buffer: PROJECT });
  await until(page, () => document.getElementById("status").textContent.includes("bring that mesh"));
  await shot("phone-waits");
  for (const [id, rests] of [["sitter", false], ["open-project", false], ["add", true], ["undo", true]]) {
    assert.equal(await page.evaluate((id) => !!document.getElementById(id).closest("[inert]"), id), rests, id);
  }
  await page.click("#home");
  await page.setInputFiles("#file", { name: "dent.obj", mimeType: "text/plain", buffer: MESH });
  await until(page, () => window.chladni.sitting?.shape === "dent.obj" && window.chladni.sitting.solved);
  assert.equal(await page.evaluate(() => document.querySelectorAll("#bench > [inert]").length), 0);
  // Together, in any order.
  await page.reload();
  await until(page, () => window.chladni?.frames > 3 && window.chladni.sound.duration > 0);
  await drop(page, ["dent.obj", MESH], ["dent.chladni", PROJECT]);
  await until(page, () => window.chladni.sitting?.shape === "dent.obj" && window.chladni.sitting.solved);
  const layer = '\n[[layer]]\nname = "Smooth"\ntemplate = "plain/dent.obj"\n';
  await drop(page, ["twice.chladni", Buffer.from(PROJECT.toString().replace("layer = []\n", "") + layer)]);
  await until(page, () => document.getElementById("status").textContent.startsWith("twice.chladni names two meshes that are both called dent.obj"));
  // Windows has other slashes, and a Mac may write an accent apart.
  const source = PROJECT.toString().replace('"dent.obj"', "'D:\\Shapes\\b\u00fcste.obj'");
  await drop(page, ["bu\u0308ste.obj", MESH], ["bust.chladni", Buffer.from(source)]);
  await until(page, () => window.chladni.sitting?.shape.endsWith("b\u00fcste.obj") && window.chladni.sitting.solved);
  const saving = downloading(page);
  await click(page, "#save-project");
  assert.equal(basename(await saving), "bust.chladni", "a project keeps its name");
  step("a project waits for its mesh, they may come together, and names say which is which");
  await drop(page, ["broken.wav", Buffer.from("no sound")]);
  await until(page, () => document.getElementById("status").textContent.startsWith("broken.wav: not a sound"));
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

/** The page runs no code but that of its own files. */
export async function policy() {
  // It is to be broken here.
  const context = await browser.newContext();
  const page = await context.newPage();
  await page.goto(address);
  const ran = await page.evaluate(async () => {
    const script = document.createElement("script");
    script.textContent = "window.ran = true";
    document.head.append(script);
    const isImported = await import("data:text/javascript,").then(() => true, () => false);
    return [!!window.ran, isImported];
  });
  assert.deepEqual(ran, [false, false]);
  await context.close();
  step("the page runs no code but its own");
}

/** Once the module has stopped in the middle of a picture nothing more is drawn, and only that is said. */
export async function stopped() {
  const { page, wrong } = await opened({ width: 1000, height: 700 }, false);
  await page.evaluate(async () => {
    const { Concert } = await import("./chladni_web.js");
    const { frame } = Concert.prototype;
    Concert.prototype.frame = () => {
      Concert.prototype.frame = frame;
      throw new WebAssembly.RuntimeError("unreachable");
    };
  });
  await until(page, () => document.getElementById("status").textContent.startsWith("The page has stopped"));
  const { frames } = await page.evaluate(() => window.chladni);
  await drop(page, ["letter.pdf", Buffer.from("%PDF")]);
  await page.waitForTimeout(1000);
  assert.equal(await page.evaluate(() => window.chladni.frames), frames);
  assert.match(await page.textContent("#status"), /^The page has stopped/);
  step("a page whose module has stopped says so");
  assert.deepEqual(wrong, []);
  await page.context().close();
}

// The music room listens to a microphone, into which a file plays here.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { WITHOUT_CARD, launch, microphone, song } from "../browser.mjs";
import { downloaded, drop, moves, opened, out, screens, state, step, still, until } from "./driver.mjs";

const LAPTOP = { width: 1100, height: 760 };

async function enter(within, viewport = LAPTOP, touch = false) {
  const opening = await opened(viewport, touch, { within });
  await opening.page.click("#enter");
  await until(opening.page, () => window.chladni.state.body === "sample:octopus");
  return opening;
}

/** The beat that is heard steps through the favorites. */
async function steps(page) {
  for (const cell of [2, 7]) await page.locator(`.cell:nth-child(${cell}) .favor`).dispatchEvent("click");
  await page.click("#favorites");
  await until(page, () => window.chladni.state.on_stage);
  const number = await page.textContent("#dance-number");
  const onStage = async () => readFileSync(await downloaded(page, "#save-preset"), "utf8");
  const first = await onStage();
  let now = first;
  // 16 beats, of 120 or 60 a minute.
  for (let i = 0; i < 40 && now === first; i++) {
    await page.waitForTimeout(1000);
    now = await onStage();
  }
  assert.notEqual(now, first, "favorites follow the beat of the microphone");
  // Curves and fields are those of the dance that has come.
  await until(page, (before) => document.getElementById("dance-number").textContent !== before, number);
  await page.click("#back");
  await until(page, () => !window.chladni.state.on_stage);
}

/** A live film has what is heard at each time: nothing, the microphone, nothing, the song. */
async function films(page) {
  await page.evaluate(() => {
    const { MediaRecorder } = window;
    window.MediaRecorder = class extends MediaRecorder {
      constructor(stream, ...rest) { super(stream, ...rest); window.filmed = stream; }
    };
  });
  await page.click("#play");
  await until(page, () => !window.chladni.sound.isHeard);
  await page.click("#film");
  await until(page, () => window.filmed);
  await page.evaluate(() => {
    const context = new AudioContext();
    window.ear = new AnalyserNode(context, { fftSize: 8192 });
    context.createMediaStreamSource(window.filmed).connect(window.ear);
  });
  const hears = (sounds) => until(page, (sounds) => {
    const samples = new Float32Array(window.ear.fftSize);
    window.ear.getFloatTimeDomainData(samples);
    return window.ear.context.state === "running" && samples.some((sample) => Math.abs(sample) > 0.02) === sounds;
  }, sounds);
  await hears(false);
  await page.click("#listen");
  await listens(page);
  await hears(true);
  await page.click("#listen");
  await page.waitForSelector("#microphone", { state: "hidden" });
  await hears(false);
  await page.click("#play");
  await hears(true);
  await downloaded(page, "#film");
  await until(page, () => window.filmed.getAudioTracks().every(({ readyState }) => readyState === "ended"));
  step("a live film has the sound of each moment");
}

const listens = (page) => until(page, () => document.getElementById("listen").getAttribute("aria-pressed") === "true");

export async function heard() {
  const wav = join(screens, "clicks.wav");
  writeFileSync(wav, song(12));
  const within = await launch(out, [...WITHOUT_CARD, ...microphone(wav)]);
  try {
    const { page, wrong, elsewhere, shot } = await enter(within);
    await page.click("#play");
    await until(page, () => !window.chladni.sound.isHeard);
    await still(page);
    await page.click("#listen");
    await listens(page);
    await moves(page, "to the microphone");
    await until(page, () => document.getElementById("loudness").value > 0.1);
    assert.ok(!(await page.evaluate(() => window.chladni.sound.isHeard)), "the song is silent meanwhile");
    assert.ok((await page.locator("#microphone option").count()) >= 1);
    assert.ok(await page.isHidden("#seek"));
    await page.click("#tap-beat");
    await until(page, () => document.getElementById("tempo").textContent.includes("BPM"));
    const other = await page.locator("#microphone option").last().getAttribute("value");
    await page.selectOption("#microphone", other);
    await listens(page);
    await page.waitForTimeout(1500);
    await shot("laptop-microphone");
    await steps(page);
    await page.selectOption("#shape", "sample:bell");
    await until(page, () => window.chladni.state.body === "sample:bell");
    await moves(page, "another shape, to the microphone");
    await page.click("#sand");
    await moves(page, "sand, to the microphone");
    await page.click("#sand");
    await page.click("#pilot");
    await until(page, () => window.chladni.state.piloted);
    await moves(page, "the autopilot, to the microphone");
    await page.click("#back");
    await page.click("#listen");
    await page.waitForSelector("#microphone", { state: "hidden" });
    assert.ok(await page.isHidden("#tap-beat"));
    await still(page);
    await page.click("#play");
    await moves(page, "to the song again");
    await films(page);
    assert.equal((await state(page)).dances.length, 12);
    // A show that is played is the user's own once something else is heard.
    const saved = readFileSync(await downloaded(page, "#save-show"), "utf8");
    const lasting = saved.replace(/^duration_secs = .*$/m, "duration_secs = 6000.0");
    assert.notEqual(lasting, saved);
    await drop(page, ["show.toml", Buffer.from(lasting)]);
    await until(page, () => !document.getElementById("play-show").hidden);
    await page.click("#play-show");
    await until(page, () => window.chladni.state.played);
    await page.click("#listen");
    await listens(page);
    await until(page, () => !window.chladni.state.played);
    step("a shape dances to a microphone, and to the song again");
    // Of two choices the last one is heard, whichever is lent first.
    await page.click("#listen");
    await page.waitForSelector("#microphone", { state: "hidden" });
    await page.evaluate(() => {
      const { mediaDevices } = navigator;
      const lend = mediaDevices.getUserMedia.bind(mediaDevices);
      window.lent = [];
      mediaDevices.getUserMedia = async (wish) => {
        if (!window.lendFirst) await new Promise((done) => { window.lendFirst = done; });
        const stream = await lend(wish);
        window.lent.push(stream);
        return stream;
      };
      for (let i = 0; i < 2; i++) document.getElementById("listen").click();
    });
    await listens(page);
    await page.evaluate(() => window.lendFirst());
    await until(page, () => window.lent[1]?.getTracks()[0].readyState === "ended");
    assert.equal(await page.evaluate(() => window.lent[0].getTracks()[0].readyState), "live");
    step("of two microphones that were chosen at once one is heard, and the other closed");
    assert.deepEqual([wrong, elsewhere], [[], []]);
    await page.context().close();

    const phone = await enter(within, { width: 390, height: 844 }, true);
    await phone.page.tap("#listen");
    await listens(phone.page);
    await phone.page.waitForTimeout(1500);
    await phone.shot("phone-microphone");
    await phone.page.context().close();
  } finally { await within.close(); }
}

/** Without a microphone, and where it is refused: the page says so, and the song goes on. */
export async function refused() {
  const { page } = await enter();
  await page.click("#listen");
  await until(page, () => /microphone/i.test(document.getElementById("status").textContent));
  assert.equal(await page.getAttribute("#listen", "aria-pressed"), "false");
  const refuse = () => navigator.mediaDevices.getUserMedia = () => Promise.reject(new DOMException("no", "NotAllowedError"));
  await page.evaluate(refuse);
  await page.click("#listen");
  await until(page, () => document.getElementById("status").textContent.includes("allow it for this page"));
  await moves(page, "the song goes on");
  // A device that never begins, as Firefox has it where there is none.
  await page.evaluate(() => {
    const { stream } = new AudioContext().createMediaStreamDestination();
    navigator.mediaDevices.getUserMedia = () => Promise.resolve(stream);
    AudioContext.prototype.resume = AudioContext.prototype.close = () => new Promise(() => {});
    Object.defineProperty(AudioContext.prototype, "state", { get: () => "suspended" });
  });
  await page.click("#listen");
  await until(page, () => document.getElementById("status").textContent.includes("No sound device answers"));
  assert.equal(await page.getAttribute("#listen", "aria-pressed"), "false");
  step("a microphone that is not lent is reported, and the song goes on");
  await page.context().close();
}

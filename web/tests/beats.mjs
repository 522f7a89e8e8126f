// The page finds the beats that the desktop's command finds, where that is built.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { song } from "../browser.mjs";
import { drop, opened, out, screens, step, until } from "./driver.mjs";

/** Seconds by which beats may differ: functions such as the sine are another library's in a page. */
const NEAR_SECS = 1e-6;

export async function beats() {
  const chladni = process.env.CHLADNI ?? join(out, "../release/chladni");
  if (!existsSync(chladni)) return step(`${chladni} is not there: beats are not compared`);
  const wav = song(20);
  writeFileSync(join(screens, "clicks.wav"), wav);
  const { page, wrong } = await opened({ width: 700, height: 500 }, false);
  await page.evaluate(async () => {
    const { Concert } = await import("./chladni_web.js");
    const know = Concert.prototype.know_song;
    window.beats = {};
    Concert.prototype.know_song = function (number, name, rate, left, right, beats, loud) {
      window.beats[name] = JSON.parse(beats);
      return know.call(this, number, name, rate, left, right, beats, loud);
    };
  });
  // Another shape hears the tune anew.
  await page.click("#enter");
  await until(page, () => window.beats["sample:tune"]);
  await drop(page, ["clicks.wav", wav]);
  await until(page, () => window.beats["clicks.wav"]);
  for (const [name, file] of [["sample:tune", "sample:tune"], ["clicks.wav", join(screens, "clicks.wav")]]) {
    const here = await page.evaluate((name) => window.beats[name], name);
    const there = JSON.parse(execFileSync(chladni, ["beats", file, "--json", "--quiet"]));
    assert.ok(there.beats_secs.length > 10);
    assert.equal(here.beats_secs.length, there.beats_secs.length, name);
    const apart = Math.max(...here.beats_secs.map((secs, i) => Math.abs(secs - there.beats_secs[i])));
    assert.ok(apart <= NEAR_SECS, `${name}: beats differ by ${apart} s`);
    assert.deepEqual(here.bars.map(({ beats }) => beats), there.bars.map(({ beats }) => beats));
    assert.ok(here.bars.every(({ at_secs }, i) => Math.abs(at_secs - there.bars[i].at_secs) <= NEAR_SECS));
    assert.ok(Math.abs(here.tempo_bpm - there.tempo_bpm) < 1e-3 && Math.abs(here.confidence - there.confidence) < 1e-3);
    step(`${name}: ${here.beats_secs.length} beats and ${here.bars.length} bars as on the desktop, at most ${apart.toExponential(1)} s apart`);
  }
  assert.deepEqual(wrong, []);
  await page.context().close();
}

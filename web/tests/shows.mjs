// What is kept of the music room: shows that are played, and films of the stage.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { song } from "../browser.mjs";
import { downloaded, downloading, drop, moves, opened, step, until } from "./driver.mjs";

export async function shows() {
  const { page, wrong, elsewhere, shot } = await opened({ width: 1440, height: 900 }, false);
  await page.click("#enter");
  await until(page, () => window.chladni.state.body === "sample:octopus");
  assert.ok(await page.isHidden("#play-show"), "there is no show yet");
  await drop(page, ["clicks.wav", song(20)]);
  await until(page, () => document.getElementById("song").textContent === "clicks.wav" && window.chladni.position() > 0.5);
  await page.click("#cells .cell:nth-child(2) .choose");
  await page.click("#cells .cell:nth-child(7) .choose");
  await until(page, () => window.chladni.state.dances.filter((dance) => dance.chosen).length === 2);
  await page.waitForTimeout(1500);
  await page.click("#breed");
  await until(page, () => window.chladni.state.generation === 1);
  await page.hover("#cells .cell:nth-child(3)");
  await page.click("#cells .cell:nth-child(3) .stage");
  await until(page, () => window.chladni.state.on_stage);
  const show = await downloaded(page, "#save-show");
  await page.setInputFiles("#file", show);
  await until(page, () => !document.getElementById("play-show").hidden);
  await page.evaluate(() => {
    const repeat = document.getElementById("repeat");
    repeat.value = "song";
    repeat.dispatchEvent(new Event("change"));
  });
  await page.click("#play-show");
  // All is as it was in the beginning, and comes to pass again.
  await until(page, () => window.chladni.state.played && window.chladni.state.generation === 0 && !window.chladni.state.on_stage);
  await moves(page, "a show that is played");
  await shot("laptop-show");
  await until(page, () => window.chladni.state.generation === 1);
  await until(page, () => window.chladni.state.on_stage);
  await until(page, () => !window.chladni.state.played);
  assert.equal(await page.textContent("#play-show"), "Play show");
  assert.ok(await page.evaluate(() => window.chladni.sound.repeats), "the same song again, once the show is over");
  await page.click("#play-show");
  await until(page, () => window.chladni.state.played);
  await page.selectOption("#look", "ember");
  await page.click("#cells .cell:nth-child(1) .choose");
  await until(page, () => !window.chladni.state.played);
  step("a show is played as it was danced, and is the user's own from the first touch on");
  const lasting = readFileSync(show, "utf8").replace(/^duration_secs = .*$/m, "duration_secs = 600.0");
  // One that was danced to live sound is silent, and is seen all the same; its end brings the song back.
  const live = lasting.replace(/^song = \d+\n/gm, "");
  assert.notEqual(live, lasting);
  await drop(page, ["live.toml", Buffer.from(live)]);
  await until(page, () => document.getElementById("status").textContent.includes("live.toml is open."));
  await page.click("#play-show");
  await until(page, () => window.chladni.state.played && window.chladni.state.generation === 0 && !window.chladni.state.on_stage);
  await until(page, () => window.chladni.state.played && window.chladni.state.on_stage);
  assert.ok(!(await page.evaluate(() => window.chladni.sound.isHeard)), "live sound was not recorded");
  await page.click("#play-show");
  await until(page, () => !window.chladni.state.played);
  await page.click("#play");
  await until(page, () => window.chladni.sound.isHeard && window.chladni.sound.number >= 0);
  await moves(page, "to the song, once the show is over");
  step("a show that begins with live sound is seen");
  // What is drawn meanwhile stays under the hand.
  await drop(page, ["lasting.toml", Buffer.from(lasting)]);
  await until(page, () => document.getElementById("status").textContent.includes("lasting.toml is open."));
  await page.click("#play-show");
  await until(page, () => window.chladni.state.played && !window.chladni.state.on_stage);
  await until(page, () => window.chladni.state.played && window.chladni.state.on_stage);
  await page.click("#draw");
  const value = () => page.evaluate(() => Number(document.getElementById("amplification").getAttribute("aria-valuenow")));
  const before = await value();
  const { x, y, height } = await page.locator("#amplification").boundingBox();
  // Beyond the middle of the first step, at which the value is read.
  await page.mouse.move(x + 20, before > 0 ? y + height - 4 : y + 4);
  await page.mouse.down();
  await page.waitForTimeout(1000);
  assert.ok(Math.abs((await value()) - before) > 0.9, "a stroke stays while the show goes on");
  assert.ok(await page.evaluate(() => window.chladni.state.played));
  await page.mouse.up();
  await until(page, () => !window.chladni.state.played);
  assert.ok(Math.abs((await value()) - before) > 0.9, "it is a dance of one's own then");
  step("a curve is drawn while a show is played");
  // The tune needs no file, and songs of one name are told apart by their order.
  await drop(page, ["tune.toml", Buffer.from(lasting.replace('"clicks.wav"', '"sample:tune"'))]);
  await until(page, () => document.getElementById("status").textContent === "tune.toml is open.");
  await drop(page, ["01.wav", song(2)], ["01.wav", song(3)]);
  await until(page, () => document.getElementById("song").textContent === "2 of 3: 01.wav");
  const found = await page.evaluate(async () => {
    const { all, findForShow } = await import("./songs.js");
    return findForShow(["01.wav", "sample:tune", "01.wav", "01.wav", "gone.wav"]).map((song) => (song?.file ? all().indexOf(song) : song?.name));
  });
  assert.deepEqual(found, [1, "sample:tune", 2, 1, undefined]);
  step("a show finds its songs, of which two may share a name");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

/** The flash guard has its own time: after a strobe it lets a show pass that begins anew at 0. */
export async function flashes() {
  const { page, wrong, elsewhere } = await opened({ width: 640, height: 480 }, false);
  const { most, left } = await page.evaluate(async () => {
    const { Concert } = await import("./chladni_web.js");
    const body = await (await fetch("bodies/plate.body")).arrayBuffer();
    const concert = new Concert(new Uint8Array(body), 6, 1);
    const flat = (level) => Uint8Array.from({ length: 4 * 16 * 16 }, (_, i) => (i % 4 === 3 ? 255 : level));
    const [dark, light] = [flat(0), flat(255)];
    let now = 100;
    const judged = (picture) => {
      now += 1 / 15;
      concert.go_on(now, -1, 0, 0);
      return Math.abs(concert.judge(picture, 16, 16));
    };
    const most = Math.max(...Array.from({ length: 180 }, (_, i) => judged(i % 2 ? dark : light)));
    concert.play_show(concert.save_show());
    // Three seconds of each, of which the veil may last for two.
    const left = [light, dark].map((picture) => Array.from({ length: 45 }, () => judged(picture)).at(-1));
    concert.free();
    return { most, left };
  });
  assert.ok(most > 0, "a strobe is veiled");
  assert.deepEqual(left, [0, 0], "the veil goes");
  step("flashes of before do not veil a show that is played");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

/** A show that is open before its song: dances take turns by what is heard meanwhile, and by all beats once the song comes. */
export async function withoutSong() {
  const { page, wrong, elsewhere } = await opened({ width: 640, height: 480 }, false);
  const { meanwhile, after, cautions, looks, body } = await page.evaluate(async () => {
    const { Concert } = await import("./chladni_web.js");
    const plate = new Uint8Array(await (await fetch("bodies/plate.body")).arrayBuffer());
    const beats_secs = Array.from({ length: 200 }, (_, i) => i / 2);
    const none = { bars: [], sections: [], energy: [] };
    const beats = JSON.stringify({ tempo_bpm: 120, beats_secs, confidence: 1, other_octaves_bpm: [60, 240], ...none });
    const silence = () => new Float32Array(8000);
    const know = (concert, number) => concert.know_song(number, `${number}.wav`, 8000, silence(), silence(), beats, 0.5);
    const play = (concert, number, from, to) => Array.from({ length: 4 * (to - from) + 1 }, (_, i) => {
      const secs = from + i / 4;
      concert.go_on(secs, number, secs, 100);
      return concert.staged();
    });
    const danced = new Concert(plate, 6, 1);
    know(danced, 0);
    play(danced, 0, 0, 30);
    const act = (action) => danced.act(JSON.stringify(action));
    act({ do: "set", parameter: "beats-per-step", value: 8 });
    act({ do: "switch", switch: "beat-steps", on: true });
    act({ do: "perform-gallery", first: 0 });
    play(danced, 0, 30, 31);
    const show = new Concert(plate, 6, 1);
    show.open_show(danced.save_show());
    know(show, 1);
    const meanwhile = new Set(play(show, 1, 0, 20)).size;
    know(show, 0);
    const after = show.staged();
    const done = (action) => `{ at_secs = 0.0, at_beat = 0.0, ${action} }`;
    const chosen = [0, 1].map((item) => done(`do = "choose", item = ${item}, on = true`));
    const actions = [...chosen, done('do = "breed"')];
    const bred = `format_version = 2\nseed = 1\nsize = 6\nactions = [${actions}]\n`;
    const cautions = [show.harmonics(), 512].map((count) => show.open_show(`harmonics = ${count}\n${bred}`));
    const looks = ["open_show", "play_show"].map((begins) => {
      show.set_look('{"look":"ember"}');
      show[begins](bred);
      return JSON.parse(show.state()).looks;
    });
    // As the desktop names a mesh: in a folder, and with its hash.
    const file = (path) => `[body]\npath = "${path}"\nblake3 = "${"0".repeat(64)}"\n`;
    const body = ["shapes/sample:plate", "shapes/other.obj"].map((path) => {
      show.open_show(`${bred}${file(path)}`);
      return /\[body\]\n((?:.+\n)*)/.exec(show.save_show())[1];
    });
    danced.free();
    show.free();
    return { meanwhile, after, cautions, looks, body };
  });
  assert.ok(!cautions[0]);
  assert.match(cautions[1], /bred with 512 harmonics/);
  assert.ok(meanwhile > 3, `${meanwhile} dances without the song`);
  assert.equal(after, 5, "after the 2 beats in the show and the 40 since");
  assert.deepEqual(looks, [{ look: "ember" }, { look: "ember" }], "a show that names no look keeps the one that is shown");
  assert.match(body[0], /^path = "shapes\/sample:plate"\nblake3 = "0{64}"\n/, "a body keeps its folder");
  assert.equal(body[1].trim(), 'path = "sample:plate"', "it is not danced on that mesh");
  step("a show that is open before its song goes on, and is right once that comes");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

/** How long a film is, how large, how many pictures of it differ, and whether it has sound, as the browser plays it. */
async function watched(page, bytes, type) {
  // The policy of the page itself plays none.
  const player = await page.context().newPage();
  const found = await player.evaluate(watchedHere, [bytes.toString("base64"), type]);
  await player.close();
  return found;
}

async function watchedHere([bytes, type]) {
  const video = document.createElement("video");
  video.src = URL.createObjectURL(new Blob([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))], { type }));
  video.muted = true;
  await new Promise((done, fail) => { video.onloadeddata = done; video.onerror = () => fail(new Error(video.error.message)); });
  const brush = new OffscreenCanvas(64, 48).getContext("2d", { willReadFrequently: true });
  const seen = new Set();
  let end = 0;
  video.ontimeupdate = () => {
    end = video.currentTime;
    brush.drawImage(video, 0, 0, 64, 48);
    seen.add(brush.getImageData(0, 0, 64, 48).data.join());
  };
  const ended = new Promise((done) => { video.onended = done; });
  await video.play();
  await ended;
  return { secs: end, width: video.videoWidth, height: video.videoHeight, pictures: seen.size, sounds: video.webkitAudioDecodedByteCount > 0 };
}

/** How many pieces the tracks of an MP4 have: pictures first, then sound. */
function pieces(film) {
  const found = [];
  for (let at = film.indexOf("stsz"); at >= 0; at = film.indexOf("stsz", at + 4)) found.push(film.readUInt32BE(at + 12));
  return found;
}

export async function wholeFilms() {
  for (const [name, viewport, touch, size] of [["laptop", { width: 1000, height: 700 }, false, [1280, 720]], ["phone", { width: 390, height: 844 }, true, [720, 1280]]]) {
    const { page, wrong, elsewhere, shot } = await opened(viewport, touch);
    await page.click("#enter");
    await until(page, () => window.chladni.state.body === "sample:octopus");
    await drop(page, ["clicks.wav", song(2)]);
    await until(page, () => document.getElementById("song").textContent === "clicks.wav");
    await page.locator("#cells .cell:nth-child(3) .stage").dispatchEvent("click");
    await until(page, () => window.chladni.state.on_stage);
    await page.click("#film-song");
    await page.selectOption("#film-size", size.join("x"));
    await page.selectOption("#film-rate", "24");
    await shot(`${name}-film-asks`);
    // A double click: what is there by the second press ends no film that has no picture yet.
    await page.evaluate(() => { for (const id of ["film-begin", "film-keep"]) document.getElementById(id).click(); });
    await until(page, () => /^Picture \d+ of 48/.test(document.getElementById("film-left").textContent));
    await shot(`${name}-film-going`);
    const path = await downloading(page);
    const film = readFileSync(path);
    const [pictures, sounds] = pieces(film);
    assert.ok(pictures === 48 && sounds > 80, `no picture is missing: ${pictures} and ${sounds}`);
    const seen = await watched(page, film, "video/mp4");
    assert.ok(Math.abs(seen.secs - 2) < 0.1 && seen.sounds && seen.pictures > 4, JSON.stringify(seen));
    assert.deepEqual([seen.width, seen.height], size);
    assert.ok(await page.isHidden("#whole-film"));
    // The next one is given up, by the keyboard.
    await page.click("#film-song");
    await page.click("#film-begin");
    await until(page, () => /^Picture/.test(document.getElementById("film-left").textContent));
    await page.keyboard.press("Escape");
    await until(page, () => !document.getElementById("whole-film").open);
    assert.equal(await page.textContent("#status"), "The film was given up.");
    await until(page, () => window.chladni.sound.isHeard);
    await moves(page, "the stage behind a film");
    step(`${name}: a film of the song waited for each of ${pictures} pictures, ${size.join("×")}`);
    assert.deepEqual([wrong, elsewhere], [[], []]);
    await page.context().close();
  }
}

/** Enters the room, and asks for a film of a minute's song, 24 pictures a second. */
async function asksForLongFilm(page) {
  await page.click("#enter");
  await until(page, () => window.chladni.state.body === "sample:octopus");
  await drop(page, ["clicks.wav", song(60)]);
  await until(page, () => document.getElementById("song").textContent === "clicks.wav");
  await page.click("#film-song");
  await page.selectOption("#film-rate", "24");
}

/** Browsers that encode no sound, or do not say how it is to be decoded. */
const SILENT = [() => { delete window.AudioEncoder; }, () => {
  window.AudioEncoder = class extends AudioEncoder {
    constructor({ output, error }) { super({ output: (chunk) => output(chunk, { decoderConfig: { sampleRate: 48_000 } }), error }); }
  };
}];

/** A film that is ended before its time has what is there by then; where no sound can be encoded it is silent, and says so. */
export async function stoppedFilms() {
  for (const prepare of [undefined, ...SILENT]) {
    const silent = !!prepare;
    const { page, wrong, elsewhere } = await opened({ width: 1000, height: 700 }, false, { prepare });
    await asksForLongFilm(page);
    await page.click("#film-begin");
    await until(page, () => /^Picture (2[4-9]|[3-9]\d|\d{3}) of/.test(document.getElementById("film-left").textContent));
    const film = readFileSync(await downloaded(page, "#film-keep"));
    const [pictures, sounds = 0] = pieces(film);
    assert.ok(pictures >= 24 && pictures < 700, `${pictures} of 1440`);
    const seen = await watched(page, film, "video/mp4");
    assert.ok(Math.abs(seen.secs - pictures / 24) < 0.15, `${seen.secs} s of ${pictures} pictures`);
    assert.deepEqual([sounds > 0, seen.sounds], [!silent, !silent]);
    const said = await page.textContent("#status");
    assert.equal(/^The film is silent/.test(said), silent, said);
    assert.ok(await page.isHidden("#whole-film"));
    step(`a film was ended after ${pictures} of 1440 pictures${silent ? ", without sound" : ""}`);
    assert.deepEqual([wrong, elsewhere], [[], []]);
    await page.context().close();
  }
}

/** Where a film fails, there is as much of it as there was by then. */
export async function brokenFilms() {
  const prepare = () => {
    const { encode } = VideoEncoder.prototype;
    let count = 0;
    VideoEncoder.prototype.encode = function (...given) {
      if (++count > 30) throw new Error("the encoder is tired");
      return encode.apply(this, given);
    };
    // It gives its pictures only once it is to end.
    window.VideoEncoder = class extends VideoEncoder {
      constructor({ output, error }) {
        const held = [];
        super({ output: (...given) => { held.push(given); }, error });
        this.letOut = () => { for (const given of held.splice(0)) output(...given); };
      }
      async flush() {
        await super.flush();
        this.letOut();
      }
    };
    // And this one all that it has recorded, after the error.
    const { start } = MediaRecorder.prototype;
    MediaRecorder.prototype.start = function () {
      window.breaks = () => this.dispatchEvent(Object.assign(new Event("error"), { error: new Error("the recorder is tired") }));
      return start.call(this);
    };
  };
  const { page, wrong, elsewhere } = await opened({ width: 1000, height: 700 }, false, { prepare });
  const says = (text) => until(page, (text) => document.getElementById("status").textContent === text, `The film ended early (${text}). Its part until then is among your downloads.`);
  await asksForLongFilm(page);
  const film = readFileSync(await downloaded(page, "#film-begin"));
  await says("the encoder is tired");
  const [pictures] = pieces(film);
  assert.equal(pictures, 30, "those that the encoder still had are there, too");
  const seen = await watched(page, film, "video/mp4");
  assert.ok(Math.abs(seen.secs - pictures / 24) < 0.25, `${seen.secs} s of ${pictures} pictures`);
  assert.ok(await page.isHidden("#whole-film"));
  await page.click("#film");
  await until(page, () => /^Stop, ([2-9]|\d\d) s/.test(document.getElementById("film").textContent));
  const saving = downloading(page);
  await page.evaluate(() => window.breaks());
  assert.ok(readFileSync(await saving).length > 0);
  await says("the recorder is tired");
  assert.equal(await page.textContent("#film"), "Film");
  step(`films that fail are kept as far as they went: ${pictures} of 30 pictures, and a recording`);
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

export async function films() {
  for (const [name, viewport, touch] of [["laptop", { width: 1000, height: 700 }, false], ["phone", { width: 390, height: 844 }, true]]) {
    const { page, wrong, elsewhere, shot } = await opened(viewport, touch);
    await page.click("#enter");
    await until(page, () => window.chladni.state.body === "sample:octopus");
    await until(page, () => window.chladni.sound.isHeard);
    await page.click("#film");
    await until(page, () => /^Stop, [4-9] s/.test(document.getElementById("film").textContent));
    await shot(`${name}-film`);
    const path = await downloaded(page, "#film");
    const type = path.endsWith("mp4") ? "video/mp4" : "video/webm";
    const film = await watched(page, readFileSync(path), type);
    assert.ok(film.secs > 3 && film.width % 2 === 0 && film.height % 2 === 0, JSON.stringify(film));
    assert.ok(film.pictures > 4 && film.sounds, JSON.stringify(film));
    assert.equal(await page.textContent("#film"), "Film");
    step(`${name}: the stage was filmed, ${film.width}×${film.height}, as ${type}`);
    assert.deepEqual([wrong, elsewhere], [[], []]);
    await page.context().close();
  }
}

// Somebody is faster than the page: what was asked for last is what happens, and what comes late does not undo it.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { song, torus } from "../browser.mjs";
import { acts } from "./caricature.mjs";
import { dances, downloaded, drop, opened, says, songIs, songNow, step, until } from "./driver.mjs";
import { comesLate, holdBack, holdsBack, isHeldBack, release } from "./held.mjs";

const LAPTOP = { width: 1280, height: 800 };

const body = (page) => page.evaluate(() => window.chladni.state.body);
const plays = (page) => until(page, () => window.chladni.state.played);
const generation = (page) => page.evaluate(() => window.chladni.state.generation);

async function entered(more = {}) {
  const opening = await opened(LAPTOP, false, { prepare: holdsBack, ...more });
  await opening.page.click("#enter");
  await dances(opening.page, "sample:octopus");
  return opening;
}

async function breed(page) {
  const before = await generation(page);
  await page.click("#cells .cell:nth-child(2) .choose");
  await page.click("#cells .cell:nth-child(7) .choose");
  await page.click("#breed");
  await until(page, (before) => window.chladni.state.generation === before + 1, before);
}

/** A song of the list is asked for, and its decoding held back. */
async function awaits(page, name) {
  await holdBack(page, `decode ${name}`);
  await page.click(`#song-list .name:has-text("${name}")`);
  await isHeldBack(page);
}

async function ends({ page, wrong, elsewhere }) {
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

/** Shapes and shows. */
export async function shapes() {
  let answer = true;
  const opening = await entered({ answers: () => answer });
  const { page } = opening;
  await breed(page);
  const show = readFileSync(await downloaded(page, "#save-show"));
  // A show on the shape that dances is opened after another shape was asked for.
  await holdBack(page, "cat.body");
  await page.selectOption("#shape", "sample:cat");
  await isHeldBack(page);
  await drop(page, ["show.toml", show]);
  await says(page, "show.toml is open.");
  await comesLate(page);
  assert.deepEqual([await body(page), await generation(page)], ["sample:octopus", 1]);
  step("a shape that was asked for does not end a show that was opened after it");

  // The room is left and entered again before the plate is there.
  await breed(page);
  await holdBack(page, "plate.body");
  await page.click("#home");
  await isHeldBack(page);
  await page.click("#enter");
  await comesLate(page);
  assert.deepEqual([await body(page), await generation(page)], ["sample:octopus", 2]);
  step("dances stay where the room is left for a moment");

  // A show and its mesh, together and one after the other.
  const theirs = Buffer.from(show.toString().replace("sample:octopus", "shapes/torus.obj"));
  const ring = torus(24, 12);
  await drop(page, ["theirs.toml", theirs], ["torus.obj", ring]);
  await dances(page, "torus.obj");
  await says(page, "theirs.toml is open.");
  assert.equal(await generation(page), 1, "the show is on its own shape");
  assert.ok(await page.isVisible("#play-show"));
  await page.selectOption("#shape", "sample:octopus");
  await dances(page, "sample:octopus");
  await drop(page, ["theirs.toml", theirs]);
  await says(page, "theirs.toml was danced by torus.obj: drop that mesh, too.");
  await drop(page, ["torus.obj", ring]);
  await dances(page, "torus.obj");
  assert.equal(await generation(page), 1);
  // The mesh is dropped first, and still prepared when the show comes.
  await page.selectOption("#shape", "sample:octopus");
  await dances(page, "sample:octopus");
  await holdBack(page, "prepare torus.obj");
  await drop(page, ["torus.obj", ring]);
  await isHeldBack(page);
  await drop(page, ["theirs.toml", theirs]);
  await says(page, "theirs.toml was danced by torus.obj: drop that mesh, too.");
  await release(page);
  await dances(page, "torus.obj");
  assert.equal(await generation(page), 1);
  // Another shape has taken its place: the mesh is one of its own.
  await drop(page, ["theirs.toml", Buffer.from(theirs.toString().replace("torus.obj", "other.obj"))]);
  await says(page, "drop that mesh, too.");
  await page.selectOption("#shape", "sample:octopus");
  await dances(page, "sample:octopus");
  await drop(page, ["other.obj", ring]);
  await dances(page, "other.obj");
  assert.equal(await generation(page), 0);
  step("a show waits for its mesh");

  // What is bred while another shape comes is not lost without a question.
  answer = false;
  for (const [what, ask] of [["bell.body", () => page.selectOption("#shape", "sample:bell")], ["prepare late.obj", () => drop(page, ["late.obj", ring])]]) {
    await holdBack(page, what);
    await ask();
    await isHeldBack(page);
    await breed(page);
    await release(page);
    await says(page, "The shape has stayed");
    assert.equal(await body(page), "other.obj", what);
    await downloaded(page, "#save-show");
  }
  step("nobody loses what was bred while a shape was on its way");

  // A mesh that is prepared while the room is left is found there.
  answer = true;
  await holdBack(page, "prepare kept.obj");
  await drop(page, ["kept.obj", ring]);
  await isHeldBack(page);
  await page.click("#home");
  await dances(page, "sample:plate");
  await release(page);
  await says(page, "kept.obj is ready");
  assert.equal(await body(page), "sample:plate");
  await page.click("#enter");
  await dances(page, "kept.obj");
  // One for which another shape was chosen meanwhile does not come.
  await holdBack(page, "prepare late.obj");
  await drop(page, ["late.obj", ring]);
  await isHeldBack(page);
  await page.click("#home");
  await dances(page, "sample:plate");
  await page.click("#enter");
  await dances(page, "kept.obj");
  await page.selectOption("#shape", "sample:bell");
  await dances(page, "sample:bell");
  await comesLate(page);
  assert.equal(await body(page), "sample:bell");
  step("a mesh that is prepared while the room is left dances once it is entered");

  // A song does not wait for the mesh that came with it; nor are materials and pictures beside that mesh refused.
  await page.evaluate(() => {
    const status = document.getElementById("status");
    window.refused = [];
    const note = () => { if (status.className === "bad") window.refused.push(status.textContent); };
    new MutationObserver(note).observe(status, { attributes: true, childList: true });
  });
  await holdBack(page, "prepare ring.obj");
  const beside = ["ring.mtl", "ring.PNG"].map((name) => [name, Buffer.from("newmtl ring\n")]);
  await drop(page, ["ring.obj", ring], ...beside, ["clicks.wav", song(20)]);
  await isHeldBack(page);
  await songIs(page, "clicks.wav");
  assert.deepEqual(await page.evaluate(() => window.refused), []);
  assert.equal(await body(page), "sample:bell");
  await release(page);
  await dances(page, "ring.obj");
  step("a song plays while the mesh beside it is prepared");

  // What went wrong can be read beside what a worker reports.
  await holdBack(page, "prepare band.obj");
  await drop(page, ["band.obj", ring]);
  await isHeldBack(page);
  await drop(page, ["letter.pdf", Buffer.from("%PDF")]);
  await says(page, "letter.pdf: the page opens");
  await release(page);
  await until(page, () => {
    const { textContent, className } = document.getElementById("status");
    return /letter\.pdf: .* · band\.obj: /.test(textContent) && className === "bad";
  });
  await dances(page, "band.obj");
  step("an error stays while a worker reports");
  await ends(opening);
}

/** Songs, and shows that are played. */
export async function songs() {
  const opening = await entered();
  const { page } = opening;
  await drop(page, ["clicks.wav", song(40)]);
  await songIs(page, "clicks.wav");
  // The bell has heard no other song.
  await page.selectOption("#shape", "sample:bell");
  await dances(page, "sample:bell");
  await page.waitForTimeout(500);
  const saved = readFileSync(await downloaded(page, "#save-show"), "utf8");
  // One that lasts.
  const show = Buffer.from(saved.replace(/^duration_secs = .*$/m, "duration_secs = 600.0"));
  assert.notEqual(show.toString(), saved);
  await drop(page, ["show.toml", show]);
  await says(page, "show.toml is open.");
  // A song that was asked for before the show is played.
  await holdBack(page, "decode late.wav");
  await drop(page, ["late.wav", song(30)]);
  await isHeldBack(page);
  await page.click("#play-show");
  await plays(page);
  await comesLate(page);
  assert.equal(await songNow(page), "1 of 2: clicks.wav");
  assert.ok(await page.evaluate(() => window.chladni.state.played));
  // One that is asked for then ends the show.
  await holdBack(page, "decode clicks.wav");
  await page.click("#next");
  await songIs(page, "2 of 2: late.wav");
  assert.ok(!(await page.evaluate(() => window.chladni.state.played)), "a song of the list is the user's own");
  step("a show keeps its song until another is asked for");

  // A show is ended that waits for its song: what dances does not wait.
  await isHeldBack(page);
  await page.click("#play-show");
  await plays(page);
  await page.waitForTimeout(500);
  await page.click("#play-show");
  await until(page, () => !window.chladni.state.played);
  const frames = await page.evaluate(() => window.chladni.frames);
  await until(page, (frames) => window.chladni.frames > frames + 2, frames);
  step("the picture goes on where a show is ended that waits for its song");

  // The room is left while a show waits for its song.
  await isHeldBack(page);
  await page.click("#play-show");
  await plays(page);
  const placeAt = (id) => page.evaluate((id) => {
    document.getElementById(id).click();
    return window.chladni.position();
  }, id);
  const leftAtSecs = await placeAt("home");
  await comesLate(page);
  assert.ok(!(await page.evaluate(() => window.chladni.sound.isHeard)), "nothing is heard at the front");
  await dances(page, "sample:plate");
  const enteredAtSecs = await placeAt("enter");
  assert.ok(Math.abs(enteredAtSecs - leftAtSecs) < 0.5, `the song goes on where it was left: ${enteredAtSecs} for ${leftAtSecs} s`);
  await dances(page, "sample:bell");

  // It is left while a song is decoded: the next one is next to the one that plays.
  await drop(page, ["third.wav", song(30)]);
  await songIs(page, "3 of 3: third.wav");
  await page.click("#next");
  await songIs(page, "1 of 3: clicks.wav");
  await holdBack(page, "decode third.wav");
  await page.click("#previous");
  await page.click("#home");
  await dances(page, "sample:plate");
  await release(page);
  await page.click("#enter");
  await dances(page, "sample:bell");
  await page.click("#next");
  await songIs(page, "2 of 3: late.wav");

  // One that is decoded is taken out.
  await page.click("#more");
  await drop(page, ["gone.wav", song(30)]);
  await songIs(page, "4 of 4: gone.wav");
  await page.click("#next");
  await songIs(page, "1 of 4: clicks.wav");
  await awaits(page, "gone.wav");
  await page.click('#song-list [aria-label="Take gone.wav out of the list"]');
  await comesLate(page);
  assert.equal(await songNow(page), "1 of 3: clicks.wav");
  step("songs that were asked for are forgotten where the room is left, or they are taken out");

  // The one that plays ends before the one that was chosen is decoded.
  await awaits(page, "third.wav");
  await page.fill("#seek", "0.99");
  await until(page, () => window.chladni.sound.hasEnded);
  await release(page);
  await songIs(page, "3 of 3: third.wav");
  await until(page, () => window.chladni.sound.isHeard);
  // And a pause meanwhile.
  await awaits(page, "late.wav");
  await page.click("#play");
  await release(page);
  await songIs(page, "2 of 3: late.wav");
  await page.waitForTimeout(1000);
  assert.ok(!(await page.evaluate(() => window.chladni.sound.isHeard)), "a pause has the last word");
  step("a song that is decoded is not passed over, nor does it end a pause");

  // The next song in another order, or once one is taken out, is decoded beforehand, too.
  // The order of the others stays.
  await page.evaluate(() => { Math.random = () => 0.99; });
  await holdBack(page, "decode clicks.wav");
  await page.click("#shuffle");
  await isHeldBack(page);
  // The worker that is to decode clicks.wav ends.
  await page.evaluate(() => {
    const { terminate } = Worker.prototype;
    window.terminated = 0;
    Worker.prototype.terminate = function () { window.terminated++; return terminate.call(this); };
  });
  await holdBack(page, "decode third.wav");
  await page.click('#song-list [aria-label="Take clicks.wav out of the list"]');
  await until(page, () => window.heldBack() === 2);
  assert.equal(await page.evaluate(() => window.terminated), 1, "a song that does not come next any more is not decoded");
  await release(page);
  step("the next song is decoded beforehand after Shuffle, and after one is taken out");

  // The worker stops that decodes the next song: that is not the song's fault.
  await page.evaluate(() => { window.breaks = "decode next.wav"; });
  await drop(page, ...["this.wav", "next.wav", "last.wav"].map((name) => [name, song(30)]));
  await says(page, "next.wav: The work stopped: it broke");
  assert.equal(await songNow(page), "3 of 5: this.wav");
  // Asked for, it leaves its turn to the one behind it.
  await page.click("#next");
  await songIs(page, "5 of 5: last.wav");
  await page.evaluate(() => { window.breaks = "decode last.wav"; });
  await page.click("#previous");
  await songIs(page, "4 of 5: next.wav");
  // The last one leaves its turn to the first of a list that begins anew.
  await page.click("#next");
  await songIs(page, "1 of 5: late.wav");
  await page.evaluate(() => { window.breaks = undefined; });
  step("a song stays where its worker stops");

  // The one that plays is taken out while another is decoded.
  await awaits(page, "next.wav");
  await page.click('#song-list [aria-label="Take late.wav out of the list"]');
  await page.waitForTimeout(500);
  assert.equal(await page.evaluate(() => window.heldBack()), 1, "it is decoded once");
  await comesLate(page);
  await songIs(page, "3 of 4: next.wav");
  await until(page, () => window.chladni.sound.isHeard);
  await awaits(page, "third.wav");
  await page.click("#play");
  await page.click('#song-list [aria-label="Take next.wav out of the list"]');
  await comesLate(page);
  await songIs(page, "1 of 3: third.wav");
  assert.ok(!(await page.evaluate(() => window.chladni.sound.isHeard)), "a pause has the last word");
  step("a song that was asked for comes where the one that plays is taken out");

  // A pause while a device begins.
  const isPlaying = await page.evaluate(async () => {
    const { Sound } = await import("./sound.js");
    const sound = new Sound();
    sound.load({ rate_hz: 8000, left: new Float32Array(8000), right: new Float32Array(8000) }, true);
    const began = sound.play();
    sound.pause();
    await began;
    return sound.playing || sound.isHeard;
  });
  assert.ok(!isPlaying, "a pause has the last word");
  await ends(opening);
}

/** Whether the page takes keys that are its own where nothing has the focus. */
const takesKeys = (page) => page.evaluate(() => ["PageDown", " "].map((key) =>
  !document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }))));

/** A film of the song: nothing comes into it, and it is not lost without a question. */
export async function films() {
  const opening = await entered();
  const { page } = opening;
  const asks = () => page.evaluate(() => !dispatchEvent(new Event("beforeunload", { cancelable: true })));
  await drop(page, ["clicks.wav", song(3)]);
  await songIs(page, "clicks.wav");
  // Where another one is in the list, this one does not end meanwhile.
  await page.evaluate(() => { document.getElementById("repeat").value = "song"; });
  assert.ok(!(await asks()));
  for (const [what, ask] of [["cat.body", () => page.selectOption("#shape", "sample:cat")], ["decode late.wav", () => drop(page, ["late.wav", song(2)])]]) {
    await holdBack(page, what);
    await ask();
    await isHeldBack(page);
    await page.click("#film-song");
    assert.deepEqual(await takesKeys(page), [false, false], "keys beneath a dialog");
    await page.selectOption("#film-rate", "24");
    const film = page.waitForEvent("download", { timeout: 180_000 });
    await page.click("#film-begin");
    await until(page, () => /^Picture/.test(document.getElementById("film-left").textContent));
    assert.ok(await asks(), "a film would be lost");
    assert.deepEqual(await takesKeys(page), [false, false], "keys beneath a film");
    await release(page);
    await film;
    await page.waitForTimeout(1000);
    assert.deepEqual([await body(page), /clicks.wav$/.test(await songNow(page))], ["sample:octopus", true], what);
    assert.ok(!(await asks()));
  }
  await page.click("#film");
  await until(page, () => /^Stop/.test(document.getElementById("film").textContent));
  assert.ok(await asks(), "a recording would be lost");
  // Files that cannot be used leave it as it is.
  for (const name of ["mask.npy", "empty.chladni"]) {
    await drop(page, [name, Buffer.from("")]);
    await says(page, name);
    assert.equal(await page.evaluate(() => document.body.dataset.view), "music", name);
    assert.match(await page.textContent("#film"), /^Stop/, name);
  }
  // Nor does a mesh that came with a project.
  const shape = await page.evaluate(() => window.chladni.state.body);
  await drop(page, ["empty.chladni", Buffer.from("")], ["beside.obj", torus(24, 12)]);
  await says(page, "empty.chladni");
  assert.equal(await page.evaluate(() => window.chladni.state.body), shape);
  await downloaded(page, "#film");
  assert.ok(!(await asks()));
  step("nothing comes into a film, and nobody loses one without a question");

  // A show whose shape is awaited does not leave its place to the song beside it.
  const show = readFileSync(await downloaded(page, "#save-show"), "utf8").replaceAll("sample:octopus", "sample:bell");
  await drop(page, ["long.wav", song(60)]);
  await until(page, () => /long.wav$/.test(document.getElementById("song").textContent));
  const filmed = await songNow(page);
  await holdBack(page, "bell.body");
  await drop(page, ["show.toml", Buffer.from(show)], ["beside.wav", song(2)]);
  await isHeldBack(page);
  await page.click("#film-song");
  await page.click("#film-begin");
  await until(page, () => /^Picture/.test(document.getElementById("film-left").textContent));
  await release(page);
  await says(page, "A film waits for its pictures");
  assert.deepEqual([await body(page), await songNow(page)], ["sample:octopus", filmed]);
  await page.click("#film-cancel");
  await until(page, () => !document.getElementById("whole-film").open);
  step("files that were opened before a film do not come into it");
  await ends(opening);
}

const isIdle = (page) => until(page, () => document.getElementById("cancel").hidden);

/** The caricature room. */
export async function layers() {
  const opening = await opened(LAPTOP, false, { prepare: holdsBack });
  const { page } = opening;
  await holdBack(page, "solve");
  await page.click("#exaggerate");
  await isHeldBack(page);
  await page.evaluate(async () => {
    const { Sitting } = await import("./chladni_web.js");
    const { keep_triangles } = Sitting.prototype;
    window.kept = 0;
    Sitting.prototype.keep_triangles = function () { window.kept++; return keep_triangles.call(this); };
  });
  await page.check("#keep");
  await until(page, () => window.chladni.sitting.keep_triangles);
  // Nothing is written without the layers that wait.
  await page.evaluate(() => document.getElementById("export-obj").click());
  await says(page, "export again once that is done");
  await page.waitForTimeout(1500);
  assert.equal(await page.evaluate(() => window.kept), 0, "an unsolved shape has no triangles to keep");
  await release(page);
  await acts(page);
  await until(page, () => window.kept > 0);
  await page.uncheck("#keep");

  // A second number of harmonics is given up: the first was never solved for.
  await holdBack(page, "solve");
  for (const count of ["64", "128"]) {
    await page.fill("#wanted-harmonics", count);
    await page.press("#wanted-harmonics", "Enter");
    await until(page, (count) => window.chladni.sitting.wanted_harmonics === count, Number(count));
    await isHeldBack(page);
  }
  await page.evaluate(() => document.getElementById("cancel").click());
  await isIdle(page);
  await release(page);
  await until(page, () => window.chladni.sitting.wanted_harmonics === 256);
  assert.equal(await page.evaluate(() => window.chladni.sitting.harmonics), 256);
  assert.ok(await page.isEnabled("#gallery"), "nothing is solved for any more");

  // Keys in a text are the text's own.
  const { mu } = await page.evaluate(() => window.chladni.sitting.layers[0]);
  const becomes = (mu, isSo) => until(page, ([mu, isSo]) => (window.chladni.sitting.layers[0].mu === mu) === isSo, [mu, isSo]);
  await page.focus("#mu");
  await page.keyboard.press("ArrowLeft");
  await becomes(mu, false);
  await page.focus("#layer-name");
  await page.keyboard.press("Control+z");
  await page.waitForTimeout(300);
  await becomes(mu, false);
  await page.focus("#mu");
  await page.keyboard.press("Control+z");
  await becomes(mu, true);

  // Parts by form, chosen while those of a head are looked for.
  await page.click("#hold-parts");
  await page.selectOption("#parts-of", "form");
  await until(page, () => window.chladni.sitting.level !== null);
  await holdBack(page, "parts");
  await page.selectOption("#parts-of", "head");
  await isHeldBack(page);
  await page.fill("#level", "0.6");
  await until(page, () => window.chladni.sitting.level > 0.5);
  await release(page);
  await isIdle(page);
  await page.waitForTimeout(300);
  assert.ok(await page.evaluate(() => window.chladni.sitting.level > 0.5), "parts by form stay");
  step("late harmonics and parts change nothing, and keys in a text are its own");

  // A drawing that is cancelled takes the figure with the worker: the next one brings it again.
  const draws = () => page.evaluate(() => document.getElementById("export-svg").click());
  await holdBack(page, "inkFile");
  await draws();
  await isHeldBack(page);
  await page.evaluate(() => document.getElementById("cancel").click());
  await isIdle(page);
  await release(page);
  const drawing = page.waitForEvent("download", { timeout: 120_000 });
  await draws();
  assert.match((await drawing).suggestedFilename(), /\.svg$/);
  step("a drawing in ink is made after one that was cancelled");
  await galleries(page);
  await ends(opening);
}

/** The gallery of caricatures, while it opens and while others are bred. */
async function galleries(page) {
  const gallery = () => page.evaluate(() => document.getElementById("gallery").click());
  await page.evaluate(() => { document.getElementById("wall-swell").checked = false; });
  await holdBack(page, "openWall");
  await gallery();
  await isHeldBack(page);
  // Landmarks take its place.
  await page.click("#landmarks");
  await until(page, () => !document.getElementById("gallery").disabled);
  await release(page);
  assert.ok(!(await page.evaluate(() => window.chladni.wall)), "it does not open any more");
  await page.click("#landmarks");
  await gallery();
  await until(page, () => window.chladni.wall && document.querySelectorAll("#cells .cell").length === 12);
  const [first] = await page.evaluate(() => window.chladni.wall.items.map(({ name }) => name));
  await holdBack(page, "wall ");
  await page.evaluate(() => document.getElementById("wall-others").click());
  await isHeldBack(page);
  const count = await page.evaluate(() => {
    for (const press of ["choose", "stage", "favor"]) document.querySelector(`#cells .cell:nth-child(3) .${press}`).click();
    for (const press of ["wall-others", "wall-surprise"]) document.getElementById(press).click();
    document.querySelector("#wall-locks button").click();
    return window.heldBack();
  });
  assert.equal(count, 1, "nothing is done to figures that are not seen yet");
  await release(page);
  await until(page, (first) => window.chladni.wall.items[0].name !== first, first);
  await page.evaluate(() => document.querySelector("#wall-locks button").click());
  await until(page, () => window.chladni.wall.groups[0][1]);
  assert.ok(await page.evaluate(() => window.chladni.wall.items.every(({ chosen, favorite }) => !chosen && !favorite)));
  step("a gallery is given up while it opens, and presses wait for figures that are seen");
  // It makes room for the models, and these for the original.
  const press = (id) => page.evaluate((id) => document.getElementById(id).click(), id);
  await press("models");
  await until(page, () => !window.chladni.wall && window.chladni.sitting.in_models);
  await press("original");
  await until(page, () => window.chladni.sitting.bare && !window.chladni.sitting.in_models);
  await press("original");
  await until(page, () => !window.chladni.sitting.bare);
  step("the models and the original are seen where a gallery was");
}

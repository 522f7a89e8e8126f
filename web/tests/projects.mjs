// Projects that come with their meshes, and meshes of the same names.
import assert from "node:assert/strict";
import { head } from "../browser.mjs";
import { acts } from "./caricature.mjs";
import { downloaded, drop, opened, says, step, until } from "./driver.mjs";
import { holdBack, holdsBack, isHeldBack, release } from "./held.mjs";

const LAPTOP = { width: 1280, height: 800 };

const PROJECT = Buffer.from(`format_version = 4

[shape]
source = "dent.obj"
harmonics = 32

[[layer]]
name = "Smooth"
mu = -1.0
template = "smooth.obj"
`);

/** A project that comes together with its meshes, while another shape is open. */
export async function projects() {
  const opening = await opened(LAPTOP, false, { prepare: holdsBack });
  const { page } = opening;
  await page.click("#exaggerate");
  await acts(page);
  await page.evaluate(() => {
    window.asked = 0;
    const { showModal } = HTMLDialogElement.prototype;
    HTMLDialogElement.prototype.showModal = function () { window.asked++; return showModal.call(this); };
  });
  await drop(page, ["dent.chladni", PROJECT], ["smooth.obj", head(20, 14)], ["dent.obj", head(24, 16)]);
  await until(page, () => window.chladni.sitting.shape === "dent.obj");
  await acts(page);
  assert.equal(await page.evaluate(() => window.asked), 0, "nobody is asked what a template of the project is");
  // Others of the same names take their places: together with the project, and a template alone.
  await page.evaluate(() => {
    const { postMessage } = Worker.prototype;
    window.templates = [];
    Worker.prototype.postMessage = function (message, ...rest) {
      if (message.work === "match") window.templates.push(message.template.length);
      return postMessage.call(this, message, ...rest);
    };
  });
  const isMatchedWith = async (template) => {
    await until(page, (length) => window.templates.at(-1) === length, template.length);
    await acts(page);
  };
  const [together, alone] = [head(16, 12), head(18, 13)];
  const { vertices } = await page.evaluate(() => window.chladni.sitting);
  await drop(page, ["dent.chladni", PROJECT], ["smooth.obj", together], ["dent.obj", head(28, 18)]);
  await until(page, (before) => window.chladni.sitting.vertices > before, vertices);
  await isMatchedWith(together);
  await drop(page, ["smooth.obj", alone]);
  await isMatchedWith(alone);
  assert.equal(await page.evaluate(() => window.asked), 0);
  const matched = await page.evaluate(() => window.templates.length);
  assert.equal(matched, 2, "each is matched once");
  // The gallery, whose caricatures were made of the one before, closes.
  await page.click("#gallery");
  await until(page, () => window.chladni.wall);
  const third = head(22, 15);
  await drop(page, ["smooth.obj", third]);
  await until(page, () => !window.chladni.wall);
  await isMatchedWith(third);
  // Landmarks are vertices of the file before, and go with it.
  const choosing = page.waitForEvent("filechooser");
  await page.click("#landmarks");
  await page.click("#open-landmarks");
  await (await choosing).setFiles({ name: "three.txt", mimeType: "text/plain", buffer: Buffer.from("0 0\n50 50\n99 99\n") });
  await until(page, () => window.chladni.sitting.layers[0].landmarks.length === 3);
  const fourth = head(17, 11);
  await drop(page, ["smooth.obj", fourth]);
  await until(page, () => !window.chladni.sitting.layers[0].landmarks.length);
  await isMatchedWith(fourth);
  step("files of the same names take the places of those before");
  // Layers without their template are left out of an export, and named.
  await drop(page, ["gone.chladni", Buffer.from(PROJECT.toString().replace("smooth.obj", "gone.obj"))]);
  await until(page, () => window.chladni.sitting.layers[0]?.state === "failed" && window.chladni.sitting.solved);
  await downloaded(page, "#export-obj");
  await says(page, "Written without the layer Smooth");
  step("a project comes with its meshes in any order, and says which layers an export lacks");
  // The question about the second mesh does not wait until the first is solved.
  await holdBack(page, "solve one.obj");
  await drop(page, ["one.obj", head(24, 16)], ["two.obj", head(20, 14)]);
  await page.click('#which button[value="shape"]');
  await isHeldBack(page);
  await until(page, () => document.getElementById("which-name").textContent === "two.obj" && document.getElementById("which").open);
  await page.click('#which button[value="template"]');
  await until(page, () => window.chladni.sitting.layers.length === 1);
  await release(page);
  await acts(page);
  step("of two meshes the second is asked about while the first is solved");
  // In a project a template by the name of the shape would be the shape itself.
  await drop(page, ["one.obj", head(20, 14)]);
  await page.click('#which button[value="template"]');
  await says(page, "one.obj has the name of the shape");
  assert.equal(await page.evaluate(() => window.chladni.sitting.layers.length), 1);
  // It has no more harmonics than vertices.
  for (const [typed, wanted, found] of [["999999", 2048, 362], ["-1", 16, 16]]) {
    await page.fill("#wanted-harmonics", typed);
    await page.press("#wanted-harmonics", "Enter");
    await until(page, (wanted) => window.chladni.sitting.wanted_harmonics === wanted, wanted);
    assert.equal(await page.inputValue("#wanted-harmonics"), String(wanted));
    await says(page, `one.obj: 362 vertices, ${found} harmonics`);
  }
  // Neither that mesh nor one that is not wanted has taken its place: a project is made on the shape itself.
  await drop(page, ["one.obj", head(20, 14)]);
  await page.click('#which button[value=""]');
  const theirs = PROJECT.toString().replace("dent.obj", "one.obj").replace("smooth.obj", "two.obj");
  await drop(page, ["one.chladni", Buffer.from(theirs)]);
  await until(page, () => window.chladni.sitting.wanted_harmonics === 32);
  assert.equal(await page.evaluate(() => window.chladni.sitting.vertices), 362);
  await acts(page);
  step("a template of the shape's name is refused, and numbers of harmonics stay within bounds");
  assert.deepEqual([opening.wrong, opening.elsewhere], [[], []]);
  await page.context().close();
}

// The caricature room's other tools: ink, heat maps, masks, landmarks, and the gallery.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { differing, pixels } from "../browser.mjs";
import { acts } from "./caricature.mjs";
import { downloaded, drop, moves, opened, step, still, until } from "./driver.mjs";

const layer = (page) => page.evaluate(() => window.chladni.sitting.layers.at(-1));
const PAPER = [250, 247, 240];

/** The upper left pixel of the picture. */
const corner = (page) => page.evaluate(() => [...document.getElementById("picture").getContext("2d").getImageData(1, 1, 1, 1).data.slice(0, 3)]);

/** Until the picture is on paper, with so many dark pixels of the thinned ones or more. */
async function isDrawn(page, least) {
  for (let i = 0; i < 300; i++) {
    const [r] = await corner(page);
    const dark = (await pixels(page)).filter((value) => value < 120).length;
    if (r === PAPER[0] && dark >= least) return dark;
    await page.waitForTimeout(200);
  }
  throw new Error("no drawing in ink is seen");
}

async function ink(page, shot) {
  await page.click("#look-portrait");
  const plain = await still(page);
  await page.check("#ink");
  const dark = await isDrawn(page, 20);
  await still(page);
  await shot("laptop-ink");
  const box = await page.locator("#picture").boundingBox();
  const before = await pixels(page);
  await page.mouse.move(box.x + 60, box.y + 60);
  await page.mouse.down();
  await page.mouse.move(box.x + 260, box.y + 60, { steps: 6 });
  await page.mouse.up();
  assert.ok(differing(before, await still(page)) > 20, `it is drawn from elsewhere (${dark} dark pixels before)`);
  await page.click("#look-portrait");
  await page.check("#tones");
  await still(page);
  await shot("laptop-tones");
  const svg = readFileSync(await downloaded(page, "#export-svg"), "utf8");
  assert.match(svg, /^<svg .*\n<rect id="paper"/);
  assert.match(svg, /<g id="contours"[^>]*>\n<path/);
  assert.match(svg, /<g id="tones">\n<path/);
  const png = readFileSync(await downloaded(page, "#export-png"));
  assert.ok(png.readUInt32BE(16) === 2000 || png.readUInt32BE(20) === 2000);
  // Tools need the figure itself: it is seen, and so it is saved.
  await page.click("#hold-parts");
  const figure = readFileSync(await downloaded(page, "#export-png"));
  await page.click("#hold-turn");
  assert.notDeepEqual(figure, png);
  await page.uncheck("#tones");
  await page.uncheck("#ink");
  assert.ok(differing(plain, await still(page)) < 20, "the shape is seen again as it was");
  step("a shape is drawn in ink, live and as SVG and PNG");
}

/** A menu of the browser takes the release of a press; in Parts only the left button takes one. */
async function presses(page) {
  const send = (...events) => page.evaluate((events) => {
    const picture = document.getElementById("picture");
    const { left, top, width, height } = picture.getBoundingClientRect();
    for (const [type, across, more] of events) {
      picture.dispatchEvent(new PointerEvent(type, {
        pointerId: 1, pointerType: "mouse", bubbles: true, clientX: left + width / 2 + across, clientY: top + height / 4, ...more,
      }));
    }
    return window.chladni.view().yaw_rad;
  }, events);
  const takes = (key, more) => page.evaluate(([key, more]) => !document.getElementById("picture")
    .dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more })), [key, more]);
  for (const [key, more] of [["ArrowLeft", { altKey: true }], ["f", { ctrlKey: true }], ["+", { metaKey: true }]]) {
    assert.ok(!(await takes(key, more)), `${key} with a modifier is the browser's`);
  }
  const before = await send();
  const after = await send(["pointerdown", 0, { button: 2, buttons: 2 }], ["pointermove", 60, {}], ["pointermove", 120, {}]);
  assert.equal(after, before, "nothing is pressed any more");
  await page.click("#hold-parts");
  await send(["pointermove", 0, {}]);
  assert.notEqual(await page.textContent("#pointed"), "", "the pointer is on a part");
  const isWhole = async (button) => {
    await send(["pointerdown", 0, { button, buttons: button === 2 ? 2 : 1 }], ["pointerup", 0, { button }]);
    return (await layer(page)).everywhere;
  };
  assert.deepEqual([await isWhole(2), await isWhole(0)], [true, false]);
  await page.click("#undo");
  await until(page, () => window.chladni.sitting.layers.at(-1).everywhere);
  await page.click("#hold-turn");
  step("a menu does not keep a button pressed, and its button takes no part");
}

async function heat(page, shot) {
  const plain = await still(page);
  const names = await page.locator("#heat option").allTextContents();
  for (const name of names.filter((name) => !/own colors/.test(name))) {
    await page.selectOption("#heat", { label: name });
    const seen = differing(plain, await still(page));
    const wanted = /Displacement|Difference|Confidence|harmonic|Place/.test(name);
    assert.ok(!wanted || seen > 100, `${name} is seen: ${seen}`);
    assert.equal(await page.isVisible("#legend"), /Displacement|Difference|Confidence|Held back|harmonic/.test(name), name);
    if (/Difference/.test(name)) await shot("laptop-heat");
  }
  await page.selectOption("#heat", { label: "A harmonic" });
  const first = await still(page);
  await page.fill("#harmonic", "9");
  await page.press("#harmonic", "Enter");
  await until(page, () => window.chladni.sitting.heat.harmonic === 9);
  assert.ok(differing(first, await still(page)) > 60, "another harmonic is seen");
  await page.fill("#harmonic", "-3");
  await page.press("#harmonic", "Enter");
  await until(page, () => window.chladni.sitting.heat.harmonic === 0);
  // A browser that translates the page gives the choices other names.
  await page.selectOption("#heat", { label: names[0] });
  const harmonic = names.indexOf("A harmonic");
  await page.evaluate((i) => { document.getElementById("heat").options[i].text = "倍音"; }, harmonic);
  await page.selectOption("#heat", { index: harmonic });
  await until(page, () => !document.getElementById("harmonic-row").hidden);
  await page.selectOption("#heat", { label: names[0] });
  assert.ok(differing(plain, await still(page)) < 20);
  assert.notEqual(await page.getAttribute("#status", "class"), "bad");
  step(`${names.length} heat maps, with their legends`);
}

/** The numbers of a region in a NumPy array. */
const numbers = (npy) => {
  const all = [];
  for (let at = 10 + npy.readUInt16LE(8); at < npy.length; at += 4) all.push(npy.readFloatLE(at));
  return all;
};

async function brush(page) {
  const half = async () => {
    const all = numbers(readFileSync(await downloaded(page, "#save-mask-npy")));
    assert.ok(all.every((value) => value === 0 || value === 0.5), "no more than the intensity");
    return all.filter((value) => value === 0.5).length / all.length;
  };
  const box = await page.locator("#picture").boundingBox();
  const press = async (step) => {
    await page.mouse.click(box.x + 0.5 * box.width, box.y + 0.3 * box.height);
    await until(page, (step) => window.chladni.sitting.undo === step && !window.chladni.sitting.layers.at(-1).everywhere, step);
    return half();
  };
  await page.click("#hold-brush");
  await page.fill("#brush-intensity", "0.5");
  await page.click("#region-clear");
  const dab = await press("paint");
  await page.check("#fill");
  const filled = await press("fill component");
  assert.ok(dab > 0 && dab < 0.4 && filled > 0.5, `${dab} are painted, ${filled} filled`);
  await page.check("#erase");
  assert.equal(await press("fill component"), 0, "all that is connected is erased");
  await page.uncheck("#erase");
  await page.uncheck("#fill");
  step("the brush paints with half its intensity, and fills");
  // A stroke ends where the room is left in its middle.
  const [x, y] = [box.x + 0.5 * box.width, box.y + 0.3 * box.height];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.goBack();
  await until(page, () => document.body.dataset.view === "front");
  await page.mouse.up();
  await page.click("#exaggerate");
  const first = await half();
  await page.mouse.click(x, y + 0.2 * box.height);
  const both = await half();
  assert.ok(first > 0 && both > first, `${first} are painted, then ${both}`);
  await page.click("#undo");
  assert.equal(await half(), first, "the second stroke is a step of its own");
  await page.fill("#brush-intensity", "1");
  await page.click("#everywhere");
  await page.click("#hold-turn");
  step("a stroke ends where the room is left");
}

async function masks(page) {
  await page.click("#hold-parts");
  await page.click('#parts button:has-text("nose")');
  await until(page, () => window.chladni.sitting.layers.at(-1).parts.join() === "nose");
  const npy = readFileSync(await downloaded(page, "#save-mask-npy"));
  assert.equal(npy.toString("latin1", 1, 6), "NUMPY");
  const npz = readFileSync(await downloaded(page, "#save-mask-npz"));
  assert.ok(npz.subarray(0, 100).includes("mask.npy"), "an archive with the array “mask”");
  const ply = await downloaded(page, "#save-mask-ply");
  assert.match(readFileSync(ply).toString("latin1", 0, 400), /property (float|double) mask/);
  const everywhere = async () => {
    await page.click("#everywhere");
    await until(page, () => window.chladni.sitting.layers.at(-1).everywhere);
  };
  const isNose = () => until(page, () => window.chladni.sitting.layers.at(-1).parts.join() === "nose");
  await everywhere();
  await drop(page, ["nose.npy", npy]);
  await isNose();
  await everywhere();
  await drop(page, ["nose.npz", npz]);
  await isNose();
  await everywhere();
  const choosing = page.waitForEvent("filechooser");
  await page.click("#open-mask");
  await (await choosing).setFiles(ply);
  await isNose();
  await drop(page, ["other.npy", npy.subarray(0, npy.length - 4)]);
  await until(page, () => document.getElementById("status").className === "bad");
  await everywhere();
  await page.click("#hold-turn");
  step("a region goes out as .npy, .npz and PLY, and comes back");
}

/** Says that another axis points up, and leaves it to the estimate again: what is shown turns, and back. */
async function turnsWithUp(page, what) {
  const stood = await still(page);
  await page.selectOption("#up", "x");
  await until(page, () => window.chladni.sitting.up === "x");
  const turned = differing(stood, await still(page));
  assert.ok(turned > 60, `${what}: ${turned} of 4000 pixels have changed`);
  await page.selectOption("#up", "");
  await until(page, () => window.chladni.sitting.up === "");
  assert.ok(differing(stood, await still(page)) < 20, `${what} as before`);
}

async function landmarks(page, shot) {
  await page.click("#landmarks");
  await until(page, () => /Click a place on the shape/.test(document.getElementById("landmark-hint").textContent));
  const box = await page.locator("#picture").boundingBox();
  await turnsWithUp(page, "the shape beside its template");
  const press = (half, x, y) => page.mouse.click(box.x + (half + 0.5 + x) * 0.5 * box.width, box.y + (0.5 + y) * box.height);
  await page.evaluate(() => { window.chladni.matchSecs = 0; });
  let count = 0;
  for (const [x, y] of [[0, 0.05], [-0.07, -0.06], [0.07, -0.06]]) {
    await press(0, x, y);
    await until(page, () => /same place on the template/.test(document.getElementById("landmark-hint").textContent));
    await press(1, x, y);
    await until(page, (count) => window.chladni.sitting.layers.at(-1).landmarks.length === count, ++count);
  }
  await until(page, () => document.querySelectorAll("#labels span").length === 6);
  await until(page, () => window.chladni.matchSecs > 0 && document.getElementById("cancel").hidden);
  await acts(page);
  await still(page);
  await shot("laptop-landmarks");
  const txt = readFileSync(await downloaded(page, "#save-landmarks"), "utf8");
  assert.equal(txt.split("\n").filter((line) => /^\d+ \d+/.test(line)).length, 3);
  // A press on one leaves it where it is, and begins no other pair.
  const picked = await page.evaluate(() => [window.chladni.sitting.layers.at(-1).landmarks, window.chladni.sitting.hint]);
  await press(0, 0, 0.05);
  assert.deepEqual(await page.evaluate(() => [window.chladni.sitting.layers.at(-1).landmarks, window.chladni.sitting.hint]), picked);
  // The first is dragged elsewhere.
  const before = (await layer(page)).landmarks[0].shape;
  const at = [box.x + 0.25 * box.width, box.y + 0.55 * box.height];
  await page.mouse.move(...at);
  await page.mouse.down();
  await page.mouse.move(at[0], at[1] + 40, { steps: 5 });
  await page.mouse.up();
  await until(page, (before) => window.chladni.sitting.layers.at(-1).landmarks[0].shape !== before, before);
  await page.focus("#landmark-list button");
  await page.keyboard.press("Enter");
  await until(page, () => window.chladni.sitting.layers.at(-1).landmarks.length === 2);
  await until(page, () => document.activeElement.getAttribute("aria-label") === "Remove landmark 1");
  await until(page, () => document.querySelectorAll("#labels span").length === 4);
  await page.mouse.click(box.x + 0.215 * box.width, box.y + 0.44 * box.height, { button: "right" });
  await until(page, () => window.chladni.sitting.layers.at(-1).landmarks.length === 1);
  await page.click("#landmarks");
  assert.ok(await page.isHidden("#picking"));
  await page.click("#undo");
  await until(page, () => window.chladni.sitting.layers.at(-1).landmarks.length === 2);
  for (let i = 0; i < 5; i++) await page.click("#undo");
  await until(page, () => window.chladni.sitting.layers.at(-1).landmarks.length === 0);
  await acts(page);
  step("landmarks are picked, dragged, listed and saved, and the match follows");
}

async function gallery(page, shot) {
  const { layers } = await page.evaluate(() => window.chladni.sitting);
  await page.click("#gallery");
  await until(page, () => window.chladni.wall && document.querySelectorAll("#cells .cell").length === 12);
  await moves(page, "figures that swell");
  await page.uncheck("#wall-swell");
  await turnsWithUp(page, "the gallery");
  const full = await still(page);
  const names = () => page.evaluate(() => window.chladni.wall.items.map(({ name }) => name));
  const first = await names();
  assert.ok(new Set(first).size > 6, "they differ");
  await page.click("#cells .cell:nth-child(2) .choose");
  await page.click("#cells .cell:nth-child(7) .choose");
  await until(page, () => window.chladni.wall.chosen === 2);
  await page.hover("#cells .cell:nth-child(5)");
  await page.click("#cells .cell:nth-child(5) .favor");
  await until(page, () => window.chladni.wall.favorites.length === 1);
  const [favorite] = await page.evaluate(() => window.chladni.wall.favorites);
  assert.equal(favorite, first[4]);
  await until(page, () => document.querySelector("#cells .cell:nth-child(5) .favor").ariaPressed === "true");
  await shot("laptop-wall");
  await page.click("#wall-locks button");
  await until(page, () => window.chladni.wall.groups[0][1]);
  await page.click("#wall-breed");
  await until(page, () => !window.chladni.wall.first);
  assert.notDeepEqual(await names(), first);
  await page.click("#wall-back");
  await until(page, () => window.chladni.wall.first);
  assert.deepEqual(await names(), first);
  assert.ok(differing(full, await still(page)) < 20, "they hang as they did, as far as they swell");
  const before = await still(page);
  await page.click("#wall-others");
  await until(page, (name) => window.chladni.wall.items[0].name !== name, first[0]);
  assert.ok(differing(before, await still(page)) > 60, "others hang there");
  await page.hover("#cells .cell:nth-child(3)");
  await page.click("#cells .cell:nth-child(3) .stage");
  await until(page, (count) => !window.chladni.wall && window.chladni.sitting.layers.length > count, layers.length);
  // It looks as it hung there: those that were there are hidden, and come back with it.
  await until(page, (count) => window.chladni.sitting.layers.every(({ state }, i) => state === (i < count ? "off" : "acts")), layers.length);
  await still(page);
  await shot("laptop-taken");
  const taken = await page.evaluate(() => window.chladni.sitting.layers.length);
  await page.click("#undo");
  await until(page, (count) => window.chladni.sitting.layers.length === count, layers.length);
  await acts(page);
  await page.click("#gallery");
  await until(page, () => window.chladni.wall);
  assert.ok(await page.isHidden("#wall-favorites-row"), "favorites are those of one gallery");
  await page.focus("#cells .cell:nth-child(2) .favor");
  await page.keyboard.press("Enter");
  await until(page, () => window.chladni.wall.items[1].favorite && window.chladni.wall.favorites.length === 1);
  await page.click("#wall-others");
  await until(page, () => !window.chladni.wall.items[1].favorite);
  await page.focus("#wall-favorites button");
  await page.keyboard.press("Enter");
  await until(page, (count) => !window.chladni.wall && window.chladni.sitting.layers.length > count, layers.length);
  // It looks as it hung there: those that were there are hidden, and come back with it.
  await until(page, (count) => window.chladni.sitting.layers.every(({ state }, i) => state === (i < count ? "off" : "acts")), layers.length);
  await page.click("#undo");
  await until(page, (count) => window.chladni.sitting.layers.length === count, layers.length);
  const surprise = async () => {
    await page.click("#gallery");
    await until(page, () => window.chladni.wall);
    await page.click("#wall-surprise");
    await until(page, (count) => !window.chladni.wall && window.chladni.sitting.layers.length > count, layers.length);
    // It looks as it hung there: those that were there are hidden, and come back with it.
    await until(page, (count) => window.chladni.sitting.layers.every(({ state }, i) => state === (i < count ? "off" : "acts")), layers.length);
    return page.evaluate((count) => window.chladni.sitting.layers.slice(count).map(({ template, model, mu }) => [template, model, mu]), layers.length);
  };
  const surprised = await surprise();
  await page.click("#undo");
  await until(page, (count) => window.chladni.sitting.layers.length === count, layers.length);
  assert.notDeepEqual(await surprise(), surprised, "another surprise each time");
  step(`a gallery of twelve: bred, back, others, one taken as ${taken - layers.length} layers, a favorite, and a surprise; its figures swell`);
}

/** Names, copies, places and numbers of layers; regions by rings; matches; a head of sliders; harmonics; exports. */
async function layersToo(page, shot) {
  const layers = () => page.evaluate(() => window.chladni.sitting.layers);
  const top = async () => (await layers()).at(-1);
  const is = (what, argument) => until(page, what, argument);
  // The surprise goes; the plain head stays.
  await page.click("#undo");
  await is(() => window.chladni.sitting.layers.length === 1);
  await acts(page);
  const before = 1;
  await page.fill("#layer-name", "The chin");
  await page.press("#layer-name", "Tab");
  await is(() => window.chladni.sitting.layers.at(-1).name === "The chin");
  await page.fill("#mu-value", "-4.25");
  await page.press("#mu-value", "Enter");
  await is(() => window.chladni.sitting.layers.at(-1).mu === -4.25);
  await page.click("#duplicate");
  await is((count) => window.chladni.sitting.layers.length === count + 1, before);
  const copy = await top();
  assert.equal(copy.mu, -4.25);
  await page.click("#solo");
  await is(() => window.chladni.sitting.layers.filter(({ state }) => state === "acts").length === 1);
  await page.click("#solo");
  await page.click(`#layers [data-key="${copy.id} down"]`);
  await is((id) => window.chladni.sitting.layers.at(-2).id === id, copy.id);
  await page.click(`#layers [data-key="${copy.id} up"]`);
  await is((id) => window.chladni.sitting.layers.at(-1).id === id, copy.id);
  step("layers are named, copied, alone, moved, and take μ as a number");

  await page.click("#hold-parts");
  await page.click('#parts button:has-text("nose")');
  await is(() => !window.chladni.sitting.layers.at(-1).everywhere);
  const values = async () => readFileSync(await downloaded(page, "#save-mask-npy"));
  const sum = (npy) => numbers(npy).reduce((total, value) => total + value, 0);
  const nose = sum(await values());
  await page.click("#region-grow");
  const grown = sum(await values());
  await page.click("#region-shrink");
  const shrunk = sum(await values());
  await page.click("#region-smooth");
  assert.ok(grown > nose && shrunk < grown, `${nose}, grown to ${grown}, shrunk to ${shrunk}`);
  await page.selectOption("#edge", "sharp");
  await is(() => window.chladni.sitting.layers.at(-1).smoothing.roll_off === "sharp");
  const { clamp } = (await top()).smoothing;
  await page.click("#clamp");
  await is((clamp) => window.chladni.sitting.layers.at(-1).smoothing.clamp !== clamp, clamp);
  await page.selectOption("#edge", "heat");
  await page.click("#region-clear");
  assert.equal(sum(await values()), 0);
  await page.click("#everywhere");
  await page.click("#hold-turn");
  step("regions grow, shrink, soften, and have a sharp edge");

  await page.evaluate(() => { document.getElementById("match").open = document.getElementById("head-row").open = true; });
  await page.fill("#infill", "0.5");
  await is(() => window.chladni.sitting.layers.at(-1).infill === 0.5);
  await page.evaluate(() => { window.chladni.matchSecs = 0; });
  await page.selectOption("#method", "icp");
  await is(() => window.chladni.matchSecs > 0 && window.chladni.sitting.layers.at(-1).method === "icp");
  await page.uncheck("#fit-size");
  await is(() => !window.chladni.sitting.layers.at(-1).fits_size);
  await acts(page);
  await page.selectOption("#add", { label: "Head of sliders" });
  await is((count) => window.chladni.sitting.layers.length === count + 2, before);
  await acts(page);
  const slider = page.locator("#head-sliders").getByRole("slider", { name: "Width", exact: true });
  await slider.fill("0.5");
  await is(() => window.chladni.sitting.layers.at(-1).head?.[0] === 0.5);
  await acts(page);
  await still(page);
  await shot("laptop-head");
  step("matches by another method, at its own size; a head of sliders follows them");

  assert.ok(await page.isHidden("#template-row"), "a mesh has no numbers");
  await page.selectOption("#add", { label: "Own detail" });
  await is((count) => window.chladni.sitting.layers.length === count + 3, before);
  await acts(page);
  assert.equal(await page.inputValue("#template-text"), "self:lowpass=20");
  const write = async (text) => { await page.fill("#template-text", text); await page.press("#template-text", "Enter"); };
  await write("self:lowpass=12");
  await is(() => window.chladni.sitting.layers.at(-1).template_text === "self:lowpass=12");
  await write("nose.ply");
  await is(() => /nose.ply: write ellipsoid/.test(document.getElementById("status").textContent));
  assert.equal((await top()).template_text, "self:lowpass=12");
  await page.locator("#template-text").blur();
  assert.equal(await page.inputValue("#template-text"), "self:lowpass=12");
  await write("sphere:0,0,0,1");
  await is(() => window.chladni.sitting.layers.at(-1).template === "given sphere");
  await write("self:lowpass=12");
  await acts(page);
  await page.fill("#mu-value", "-0.01");
  await page.press("#mu-value", "Enter");
  await is(() => window.chladni.sitting.layers.at(-1).mu === -0.01);
  await page.click("#furthest");
  await is(() => window.chladni.sitting.layers.at(-1).mu !== -0.01);
  const detail = await top();
  assert.ok(detail.mu < 0, "on the side where it was");
  await page.click(`#layers [data-key="${detail.id} delete"]`);
  await is((count) => window.chladni.sitting.layers.length === count + 2, before);
  step(`numbers of templates are written, and μ goes as far as it goes, to ${detail.mu.toFixed(2)}`);

  await page.fill("#wanted-harmonics", "64");
  await page.press("#wanted-harmonics", "Enter");
  await is(() => window.chladni.sitting.harmonics === 64 && window.chladni.sitting.wanted_harmonics === 64);
  await page.click("#undo");
  await is(() => window.chladni.sitting.harmonics === 256);
  await acts(page);
  // Until a new match is there a layer acts with the one before, and is not exported.
  await is(() => document.getElementById("cancel").hidden);
  const { vertices } = await page.evaluate(() => window.chladni.sitting);
  const ply = readFileSync(await downloaded(page, "#export-ply")).toString("latin1", 0, 300);
  assert.match(ply, new RegExp(`^ply[^]*element vertex ${vertices}\n`));
  const stl = readFileSync(await downloaded(page, "#export-stl"));
  assert.equal(stl.length, 84 + 50 * stl.readUInt32LE(80));
  step("other harmonics are solved for; PLY and STL are exported");
}

export async function laptop() {
  const { page, wrong, elsewhere, shot } = await opened({ width: 1440, height: 900 }, false);
  await page.click("#exaggerate");
  await acts(page);
  for (const tool of [presses, ink, heat, brush, masks, landmarks, gallery, layersToo]) await tool(page, shot);
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

export async function phone() {
  const { page, wrong, elsewhere, shot } = await opened({ width: 390, height: 844 }, true);
  await page.emulateMedia({ reducedMotion: "reduce" });
  await page.tap("#exaggerate");
  await acts(page);
  await page.check("#ink");
  await isDrawn(page, 10);
  await still(page);
  await shot("phone-ink");
  await page.uncheck("#ink");
  await page.selectOption("#heat", { label: "Difference from the template" });
  await still(page);
  await shot("phone-heat");
  await page.tap("#landmarks");
  await until(page, () => !document.getElementById("picking").hidden);
  await still(page);
  await shot("phone-landmarks");
  await page.tap("#landmarks");
  await page.tap("#gallery");
  await until(page, () => window.chladni.wall && document.querySelectorAll("#cells .cell").length === 12);
  assert.ok(!(await page.isChecked("#wall-swell")), "who asks for less motion gets none");
  await still(page);
  await page.tap("#cells .cell:nth-child(2) .favor");
  await until(page, () => window.chladni.wall.favorites.length === 1);
  await shot("phone-wall");
  await page.tap("#cells .cell:nth-child(1) .choose");
  await until(page, () => window.chladni.wall.chosen === 1);
  await page.tap("#wall-close");
  step("a phone: ink, heat map, landmarks and gallery");
  assert.deepEqual([wrong, elsewhere], [[], []]);
  await page.context().close();
}

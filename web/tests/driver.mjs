// What all tests of the page share: a browser, and a person's hands.
import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join, resolve } from "node:path";
import { differing, launch, pixels, serve } from "../browser.mjs";

export const [folder, out] = process.argv.slice(2, 4).map((path) => resolve(path));
export const screens = join(out, "screens");
mkdirSync(screens, { recursive: true });
export const { address, stop } = await serve(folder);
export const browser = await launch(out);
const WAIT = { timeout: 180_000 };
/** What the page's Content-Security-Policy has refused. */
const refused = [];
/** Has a page write that to its console. */
export const tellsRefused = () => addEventListener("securitypolicyviolation", ({ effectiveDirective, blockedURI }) =>
  console.error(`The policy refuses ${blockedURI}, by ${effectiveDirective}`));
/** No page was refused anything. */
export const keepsPolicy = () => assert.deepEqual(refused, []);
export const step = (text) => console.log(`web: ${text}`);

/** A page that is still empty, and will tell what its policy refuses. */
export async function empty(context) {
  const page = await context.newPage();
  page.on("console", (message) => { if (message.text().startsWith("The policy refuses")) refused.push(message.text()); });
  await page.addInitScript(tellsRefused);
  return page;
}

export async function opened(viewport, touch, { within = browser, at = address, query = "", prepare, reducedMotion, answers = () => true } = {}) {
  const context = await within.newContext({ viewport, hasTouch: touch, isMobile: touch, acceptDownloads: true, reducedMotion });
  const page = await empty(context);
  const wrong = [];
  const elsewhere = [];
  page.on("console", (message) => { if (message.type() === "error") wrong.push(message.text()); });
  page.on("pageerror", (error) => wrong.push(error.message));
  page.on("request", (request) => {
    const { url } = { url: request.url() };
    if (!url.startsWith(at) && !url.startsWith("blob:") && !url.startsWith("data:")) elsewhere.push(url);
    assert.equal(request.method(), "GET", "nothing is uploaded");
  });
  page.on("dialog", (dialog) => (answers(dialog.type()) ? dialog.accept() : dialog.dismiss()));
  if (prepare) await page.addInitScript(prepare);
  await page.goto(at + query);
  // A plate that stands still is drawn once.
  await page.waitForFunction((least) => window.chladni?.frames >= least && window.chladni.sound.duration > 0, reducedMotion ? 1 : 4, WAIT);
  return { page, wrong, elsewhere, shot: (name) => page.screenshot({ path: join(screens, `${name}.png`) }) };
}

/** Until so many of the picture's pixels differ from those it has now. */
export async function differs(picture, pause, what, least = 60) {
  const before = await picture();
  let most = 0;
  for (let i = 0; i < 60 && most < least; i++) {
    await pause(0.2);
    most = Math.max(most, differing(before, await picture()));
  }
  assert.ok(most >= least, `${what}: only ${most} of 4000 pixels have changed`);
}

/** Until so much of the picture has changed. */
export const moves = (page, what, least) =>
  differs(() => pixels(page), (secs) => page.waitForTimeout(1000 * secs), what, least);

export const drop = (page, ...files) => page.evaluate((files) => {
  const dropped = new DataTransfer();
  for (const [name, bytes] of files) dropped.items.add(new File([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))], name));
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: dropped, bubbles: true, cancelable: true }));
}, files.map(([name, bytes]) => [name, bytes.toString("base64")]));
export const until = (page, condition, argument) => page.waitForFunction(condition, argument, WAIT);
/** Another shape dances, the line at the top says something, a song is the one that plays. */
export const dances = (page, name) => until(page, (name) => window.chladni.state?.body === name, name);
export const says = (page, text) => (
  until(page, (text) => document.getElementById("status").textContent.includes(text), text));
export const songIs = (page, text) => until(page, (text) => document.getElementById("song").textContent === text, text);
export const songNow = (page) => page.textContent("#song");
export const state = (page) => page.evaluate(() => window.chladni.state);

/** The picture once it changes no more. */
export async function still(page) {
  let before = await pixels(page);
  for (let i = 0; i < 60; i++) {
    await page.waitForTimeout(400);
    const now = await pixels(page);
    if (now.length === before.length && differing(before, now) === 0) return now;
    before = now;
  }
  throw new Error("the picture never comes to rest");
}

export async function downloaded(page, id) {
  const saving = downloading(page);
  await page.click(id);
  return saving;
}

/** The next file that the page gives away. */
export async function downloading(page) {
  const download = await page.waitForEvent("download", { timeout: 120_000 });
  const path = join(screens, download.suggestedFilename());
  await download.saveAs(path);
  return path;
}

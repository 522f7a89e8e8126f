// Holds back what the page waits for, so that something else comes before it.
import { until } from "./driver.mjs";

/** What workers and files are asked for can be held back: what `holds` is part of, until `release()`. A worker that is asked
 * for exactly what `breaks` says stops. */
export function holdsBack() {
  const held = [];
  window.holds = undefined;
  window.heldBack = () => held.length;
  window.release = () => { window.holds = undefined; for (const goOn of held.splice(0)) goOn(); };
  const isHeld = (text) => window.holds && text.includes(window.holds);
  const { postMessage } = Worker.prototype;
  Worker.prototype.postMessage = function (message, ...rest) {
    const post = () => postMessage.call(this, message, ...rest);
    const what = `${message.work} ${message.name}`;
    if (window.breaks === what) return this.onerror(new ErrorEvent("error", { message: "it broke" }));
    return message.work && isHeld(what) ? held.push(post) : post();
  };
  const { fetch } = window;
  window.fetch = async (what, ...rest) => {
    if (isHeld(String(what))) await new Promise((done) => held.push(done));
    if (window.missing && String(what).includes(window.missing)) return new Response("", { status: 404 });
    return fetch(what, ...rest);
  };
}

export const holdBack = (page, what) => page.evaluate((what) => { window.holds = what; }, what);
export const isHeldBack = (page) => until(page, () => window.heldBack() > 0);
export const release = (page) => page.evaluate(() => window.release());
/** What was held back has had the time to do harm. */
export async function comesLate(page) {
  await release(page);
  await page.waitForTimeout(2000);
}

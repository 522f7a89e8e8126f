// Keeps the screen awake, where the browser does: one that goes dark stops the page.

let wanted = false;
/** The browser's lock; it releases that whenever the page is hidden. */
let lock;
let asking = false;

async function follow() {
  if (asking) return;
  if (!wanted) {
    lock?.release();
    lock = undefined;
    return;
  }
  if (document.hidden || !navigator.wakeLock || lock?.released === false) return;
  asking = true;
  // A device may refuse it, for one whose battery is low.
  lock = await navigator.wakeLock.request("screen").catch(() => undefined);
  asking = false;
  if (!wanted) follow();
}

document.addEventListener("visibilitychange", follow);

/** The screen is to stay awake from now on, or no more. */
export function keepAwake(on) {
  if (wanted === on) return;
  wanted = on;
  follow();
}

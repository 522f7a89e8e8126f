// Pointers, touch and keys: one finger or the mouse turns, or does what the room's tool does; two fingers pinch and
// shift, the wheel comes nearer.
import { hasModifier } from "./page.js";
import { scale, stir } from "./picture.js";

/** A pointer that has gone so many pixels drags; it no longer clicks. */
const DRAG = 6;

/**
 * `room()` has `viewer()`, which turns, shifts and zooms, and may have a `tool`: `hover(x, y)` and `leave()` of a pointer
 * that is not pressed, `grabs(x, y)` whether a press begins a stroke, `paints()` whether that begins at the press rather than
 * where the pointer drags, `stroke(x, y)`, `release()`, and `click(x, y, event)` of what was not grabbed; all in pixels of the
 * picture.
 */
export function hands(places, room) {
  const down = new Map();
  let dragged = false;
  /** The tool of the stroke that is under way: the room may be left before the button comes up. */
  let stroking;
  let from;

  const viewer = () => room().viewer();
  const tool = () => (viewer() ? room().tool : undefined);
  const at = (event) => {
    const { left, top } = places[0].getBoundingClientRect();
    return [(event.clientX - left) * scale(), (event.clientY - top) * scale()];
  };
  const middle = () => {
    const all = [...down.values()];
    const sum = (of) => all.reduce((total, at) => total + of(at), 0) / all.length;
    const [x, y] = [sum((at) => at.x), sum((at) => at.y)];
    return { x, y, apart: all.length > 1 ? Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y) : 0 };
  };
  const letGo = () => {
    const held = stroking;
    stroking = undefined;
    held?.release();
  };

  const begin = (event) => {
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    letGo();
    if (down.size === 1) {
      dragged = false;
      tool()?.hover(...at(event));
      if (event.button === 0 && !event.altKey && tool()?.grabs(...at(event))) stroking = tool();
      // A finger may be the first of two, which pinch: it paints once it drags, or by a tap.
      if (stroking?.paints() && event.pointerType !== "touch") stroking.stroke(...at(event));
    }
    from = middle();
  };
  const move = (event) => {
    if (stroking && stroking !== tool()) letGo();
    if (!viewer()) return;
    // No button is down any more: a menu of the browser got the release, so the drag ends here.
    if (event.pointerType === "mouse" && !event.buttons) end(event);
    if (!down.has(event.pointerId)) {
      if (event.target === places[0]) tool()?.hover(...at(event));
      return;
    }
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const to = middle();
    const [dx, dy] = [to.x - from.x, to.y - from.y];
    if (!dragged && Math.hypot(dx, dy) < DRAG && down.size === 1) return;
    dragged = true;
    stir();
    if (stroking) stroking.stroke(...at(event));
    else if (down.size === 1 && !event.shiftKey) viewer().turn(dx, dy);
    else viewer().shift(dx / places[0].clientHeight, dy / places[0].clientHeight);
    if (from.apart && to.apart) viewer().zoom(Math.log(to.apart / from.apart) * 9.5);
    from = to;
  };
  const end = (event) => {
    if (!down.delete(event.pointerId)) return;
    const held = !!stroking;
    const tapped = held && !dragged && event.type === "pointerup" && event.pointerType === "touch";
    if (tapped && stroking === tool() && stroking.paints()) stroking.stroke(...at(event));
    letGo();
    if (down.size) from = middle();
    else if (!dragged && !held && event.type === "pointerup" && event.target === places[0]) tool()?.click(...at(event), event);
    if (event.pointerType === "touch") tool()?.leave();
  };
  const wheel = (event) => {
    event.preventDefault();
    stir();
    viewer()?.zoom(-event.deltaY / 100);
  };
  const keys = {
    ArrowLeft: (c) => c.turn(-20, 0), ArrowRight: (c) => c.turn(20, 0), ArrowUp: (c) => c.turn(0, -20),
    ArrowDown: (c) => c.turn(0, 20), "+": (c) => c.zoom(1), "-": (c) => c.zoom(-1), f: (c) => c.fit(),
  };

  for (const place of places) {
    place.addEventListener("pointerdown", begin);
    place.addEventListener("contextmenu", (event) => { if (tool()?.takesMenu?.()) event.preventDefault(); });
    place.addEventListener("wheel", wheel, { passive: false });
    // A drag that ends on a dance does not choose it.
    place.addEventListener("click", (event) => { if (dragged && event.detail) event.stopPropagation(); }, true);
  }
  addEventListener("pointermove", move);
  addEventListener("pointerup", end);
  addEventListener("pointercancel", end);
  places[0].addEventListener("pointerleave", () => { if (!down.size) tool()?.leave(); });
  places[0].addEventListener("keydown", (event) => {
    const act = keys[event.key];
    if (!act || !viewer() || hasModifier(event)) return;
    event.preventDefault();
    stir();
    act(viewer());
  });
}

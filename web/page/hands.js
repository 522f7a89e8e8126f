// Pointers, touch and keys turn the viewer: one finger or the mouse turns, two pinch and shift, the wheel comes nearer.

/** A pointer that has gone so many pixels drags; it no longer clicks. */
const DRAG = 6;

export function hands(places, concert) {
  const down = new Map();
  let dragged = false;
  let from;

  const middle = () => {
    const all = [...down.values()];
    const sum = (of) => all.reduce((total, at) => total + of(at), 0) / all.length;
    const [x, y] = [sum((at) => at.x), sum((at) => at.y)];
    return { x, y, apart: all.length > 1 ? Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y) : 0 };
  };

  const begin = (event) => {
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (down.size === 1) dragged = false;
    from = middle();
  };
  const move = (event) => {
    if (!down.has(event.pointerId) || !concert()) return;
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const to = middle();
    const [dx, dy] = [to.x - from.x, to.y - from.y];
    if (!dragged && Math.hypot(dx, dy) < DRAG && down.size === 1) return;
    dragged = true;
    if (down.size === 1 && !event.shiftKey) concert().turn(dx, dy);
    else concert().shift(dx / places[0].clientHeight, dy / places[0].clientHeight);
    if (from.apart && to.apart) concert().zoom(Math.log(to.apart / from.apart) * 9.5);
    from = to;
  };
  const end = (event) => {
    down.delete(event.pointerId);
    if (down.size) from = middle();
  };
  const wheel = (event) => {
    event.preventDefault();
    concert()?.zoom(-event.deltaY / 100);
  };
  const keys = {
    ArrowLeft: (c) => c.turn(-20, 0), ArrowRight: (c) => c.turn(20, 0), ArrowUp: (c) => c.turn(0, -20),
    ArrowDown: (c) => c.turn(0, 20), "+": (c) => c.zoom(1), "-": (c) => c.zoom(-1), f: (c) => c.fit(),
  };

  for (const place of places) {
    place.addEventListener("pointerdown", begin);
    place.addEventListener("wheel", wheel, { passive: false });
    // A drag that ends on a dance does not choose it.
    place.addEventListener("click", (event) => { if (dragged && event.detail) event.stopPropagation(); }, true);
  }
  addEventListener("pointermove", move);
  addEventListener("pointerup", end);
  addEventListener("pointercancel", end);
  places[0].addEventListener("keydown", (event) => {
    const act = keys[event.key];
    if (!act || !concert()) return;
    event.preventDefault();
    act(concert());
  });
}

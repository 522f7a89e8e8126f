// The slow part beside the page: shapes are solved and matched and songs decoded here. Whoever wants it to stop ends
// the worker.
import { BUILD } from "./built.js";

/** The module: that of one thread, or the one whose threads (thread.js) share its memory. */
let engine;
/** What it works in, which grows and never shrinks. */
let memory;

let began;
const ready = new Promise((done) => { began = done; });

async function begin({ threads, build, ...start }) {
  // A page that was opened before a release gets the workers of the next one, which its module does not fit.
  if (build !== BUILD) throw new Error("there is a newer version of the page. Save your work, then open it again.");
  engine = await import(threads > 1 ? "./chladni_threads.js" : "./chladni_web.js");
  const own = await engine.default(start);
  memory = start.memory ?? own.memory;
  if (threads > 1) engine.open_pool(threads);
}

/** The figure that is drawn in ink, and the gallery: each worker has at most one. */
let inker;
let wall;

/** Takes the figure where it is another. */
function takeFigure({ positions, corners }) {
  if (!positions) return;
  inker?.free();
  inker = new engine.Inker(positions, corners);
}

const hung = (withPositions) => {
  if (!withPositions) return [{ state: wall.state() }];
  const positions = wall.positions();
  return [{ state: wall.state(), positions }, [positions.buffer]];
};

/** Each gives what is sent, and what of it is given away. */
const works = {
  prepare: ({ name, bytes, harmonics }, tell) => {
    const body = engine.prepare(name, bytes, harmonics, tell);
    return [{ body }, [body.buffer]];
  },
  solve: ({ name, bytes, harmonics, laplacian }, tell) => {
    const basis = engine.solve(name, bytes, harmonics, laplacian, tell);
    return [{ basis }, [basis.buffer]];
  },
  match: ({ name, bytes, request, template }, tell) => [{ found: engine.match_template(name, bytes, request, template, tell) }],
  parts: ({ name, bytes }, tell) => [{ parts: engine.parts_of_head(name, bytes, tell) }],
  ink: ({ viewer, tones, shade, width, height, ...figure }) => {
    takeFigure(figure);
    const pixels = inker.pixels(viewer, tones, shade, width, height);
    return [{ pixels }, [pixels.buffer]];
  },
  inkFile: ({ format, viewer, tones, width, height, ...figure }) => {
    takeFigure(figure);
    return [{ file: inker[format](viewer, tones, width, height) }];
  },
  openWall: ({ name, bytes, basis, project, matches }, tell) => {
    wall?.free();
    wall = undefined;
    wall = new engine.Wall(name, bytes, basis, project, matches, tell);
    return hung(true);
  },
  wall: ({ call, args }) => {
    const found = wall[call](...args);
    return found === undefined ? hung(call === "step") : [{ found }];
  },
  decode: ({ name, bytes }, tell) => {
    tell("step", "decoding, and finding the beats");
    const song = engine.decode(name, bytes);
    const [left, right] = [song.take_left(), song.take_right()];
    const { rate_hz, beats, loud, damage } = song;
    song.free();
    if (damage) tell("warning", `${name}: ${damage}`);
    return [{ left, right, rate_hz, beats, loud }, [left.buffer, right.buffer]];
  },
};

onmessage = async ({ data: { start, id, work, ...request } }) => {
  if (start) {
    const beginning = begin(start);
    began(beginning);
    // So that the next request starts another worker.
    return beginning.catch((error) => postMessage({ kind: "broken", text: error.message ?? String(error) }));
  }
  const tell = (kind, text) => postMessage({ id, kind, text });
  try {
    await ready;
    const from = performance.now();
    const [done, given] = works[work](request, tell);
    const secs = (performance.now() - from) / 1000;
    const about = { secs, threads: engine.threads?.() ?? 1, memoryBytes: memory.buffer.byteLength };
    postMessage({ id, kind: "done", ...about, ...done }, given ?? []);
  } catch (error) {
    const text = error.message ?? String(error);
    postMessage({ id, kind: "failed", text });
    // Whoever stopped in the middle of a module may hold what others wait for.
    if (error instanceof WebAssembly.RuntimeError) postMessage({ kind: "broken", text });
  }
};

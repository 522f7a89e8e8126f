// The slow part beside the page: shapes are solved and matched and songs decoded here. Whoever wants it to stop ends
// the worker.
import init, { Inker, Wall, decode, match_template, parts_of_head, prepare, solve } from "./chladni_web.js";

let begin;
const ready = new Promise((done) => { begin = done; });

/** The figure that is drawn in ink, and the gallery: each worker has at most one. */
let inker;
let wall;

/** Takes the figure where it is another. */
function takeFigure({ positions, corners }) {
  if (!positions) return;
  inker?.free();
  inker = new Inker(positions, corners);
}

const hung = (withPositions) => {
  if (!withPositions) return [{ state: wall.state() }];
  const positions = wall.positions();
  return [{ state: wall.state(), positions }, [positions.buffer]];
};

/** Each gives what is sent, and what of it is given away. */
const works = {
  prepare: ({ name, bytes, harmonics }, tell) => {
    const body = prepare(name, bytes, harmonics, tell);
    return [{ body }, [body.buffer]];
  },
  solve: ({ name, bytes, harmonics, laplacian }, tell) => {
    const basis = solve(name, bytes, harmonics, laplacian, tell);
    return [{ basis }, [basis.buffer]];
  },
  match: ({ name, bytes, request, template }, tell) => [{ found: match_template(name, bytes, request, template, tell) }],
  parts: ({ name, bytes }, tell) => [{ parts: parts_of_head(name, bytes, tell) }],
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
    wall = new Wall(name, bytes, basis, project, matches, tell);
    return hung(true);
  },
  wall: ({ call, args }) => {
    const found = wall[call](...args);
    return found === undefined ? hung(call === "step") : [{ found }];
  },
  decode: ({ name, bytes }, tell) => {
    tell("step", "decoding, and finding the beats");
    const song = decode(name, bytes);
    const [left, right] = [song.take_left(), song.take_right()];
    const { rate_hz, beats, loud, damage } = song;
    song.free();
    if (damage) tell("warning", `${name}: ${damage}`);
    return [{ left, right, rate_hz, beats, loud }, [left.buffer, right.buffer]];
  },
};

onmessage = async ({ data: { module, id, work, ...request } }) => {
  if (module) return begin(init({ module_or_path: module }));
  const tell = (kind, text) => postMessage({ id, kind, text });
  try {
    await ready;
    const began = performance.now();
    const [done, given] = works[work](request, tell);
    postMessage({ id, kind: "done", secs: (performance.now() - began) / 1000, ...done }, given ?? []);
  } catch (error) {
    postMessage({ id, kind: "failed", text: error.message ?? String(error) });
  }
};

// The slow part beside the page: shapes are solved and matched and songs decoded here. Whoever wants it to stop ends
// the worker.
import init, { decode, match_template, parts_of_head, prepare, solve } from "./chladni_web.js";

let begin;
const ready = new Promise((done) => { begin = done; });

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
  decode: ({ name, bytes }, tell) => {
    tell("step", "decoding, and finding the beats");
    const song = decode(name, bytes);
    const [left, right] = [song.take_left(), song.take_right()];
    const { rate_hz, beats, damage } = song;
    song.free();
    if (damage) tell("warning", `${name}: ${damage}`);
    return [{ left, right, rate_hz, beats }, [left.buffer, right.buffer]];
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

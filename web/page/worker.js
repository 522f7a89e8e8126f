// The slow part beside the page: bodies are solved and songs decoded here. Whoever wants it to stop ends the worker.
import init, { prepare, decode } from "./chladni_web.js";

const ready = init();

onmessage = async ({ data: { id, work, name, bytes, harmonics } }) => {
  const tell = (kind, text) => postMessage({ id, kind, text });
  try {
    await ready;
    const began = performance.now();
    if (work === "prepare") {
      const body = prepare(name, bytes, harmonics, tell);
      postMessage({ id, kind: "done", body, secs: (performance.now() - began) / 1000 }, [body.buffer]);
    } else {
      tell("step", "decoding, and finding the beats");
      const song = decode(name, bytes);
      const [left, right] = [song.take_left(), song.take_right()];
      const { rate_hz, beats, damage } = song;
      song.free();
      if (damage) tell("warning", `${name}: ${damage}`);
      postMessage({ id, kind: "done", left, right, rate_hz, beats, secs: (performance.now() - began) / 1000 },
        [left.buffer, right.buffer]);
    }
  } catch (error) {
    postMessage({ id, kind: "failed", text: error.message ?? String(error) });
  }
};

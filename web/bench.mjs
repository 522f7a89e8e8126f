// What a page costs: sizes, the first picture, pictures a second, a caricature, a solve. node web/bench.mjs PAGE OUT [weights|music|caricature|clock|shares|solves]
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { brotliCompressSync, gzipSync } from "node:zlib";
import { ISOLATED, WITH_CARD, launch, serve, torus } from "./browser.mjs";

const [folder, out] = process.argv.slice(2).map((path) => resolve(path));
const mb = (bytes) => `${(bytes / 1e6).toFixed(2)} MB`;
const files = (at) => readdirSync(join(folder, at)).filter((name) => /\.(html|js|css|wasm|body)$/.test(name)).map((name) => join(at, name));
const sizes = (names) => {
  const all = names.map((name) => readFileSync(join(folder, name)));
  const sum = (of) => mb(all.reduce((total, bytes) => total + of(bytes).length, 0));
  return `${sum((bytes) => bytes)}, gzip ${sum((bytes) => gzipSync(bytes))}, brotli ${sum((bytes) => brotliCompressSync(bytes))}`;
};
const threads = ["thread.js", "chladni_threads.js", "chladni_threads_bg.wasm"].filter((name) => files(".").includes(name));
const first = files(".").filter((name) => !threads.includes(name));
/** Bytes to be fetched. */
function weights() {
  console.log(`module and page: ${sizes(first)}`);
  console.log(`for the first picture, with the plate: ${sizes([...first, "bodies/plate.body"])}`);
  console.log(`for threads, once something is solved: ${sizes(threads)}`);
  console.log(`octopus: ${sizes(["bodies/octopus.body"])}`);
  console.log(`sample head, and its match: ${sizes(["bodies/head.body", "bodies/head.match"])}`);
}

const { address, stop } = await serve(folder);
const browser = await launch(out);

async function measured(name, viewport, enter) {
  const page = await (await browser.newContext({ viewport })).newPage();
  await page.goto(address);
  await page.waitForFunction(() => window.chladni?.frames > 3 && window.chladni.sound.duration > 0, null, { timeout: 180_000 });
  const first = await page.evaluate(() => window.chladni.firstPictureMs);
  if (enter) await enter(page);
  await page.waitForTimeout(8000);
  const found = await page.evaluate(async () => {
    const from = [window.chladni.frames, performance.now()];
    await new Promise((done) => setTimeout(done, 10_000));
    const { frames, drawMs } = window.chladni;
    const canvas = document.getElementById("picture");
    return { fps: (1000 * (frames - from[0])) / (performance.now() - from[1]), drawMs, size: `${canvas.width}×${canvas.height}` };
  });
  console.log(`${name}: first picture ${first.toFixed(0)} ms, ${found.fps.toFixed(1)} pictures a second of ${found.size}, ${found.drawMs.toFixed(0)} ms each`);
  return page;
}

const laptop = { width: 1440, height: 900 };
const gallery = async (page) => {
  await page.click("#enter", { timeout: 180_000 });
  await page.waitForFunction(() => window.chladni.state.body === "sample:octopus", null, { timeout: 180_000 });
};

async function music() {
  await (await measured("front page, 1440×900", laptop)).close();
  await (await measured("gallery of twelve, 1440×900", laptop, gallery)).close();
  await (await measured("gallery of six, 390×844", { width: 390, height: 844 }, gallery)).close();
  const stage = await measured("one dance on stage, 1440×900", laptop, async (page) => {
    await gallery(page);
    await page.hover(".cell:nth-child(5)");
    await page.click(".cell:nth-child(5) .stage");
  });
  await stage.close();
}

async function caricature() {
  const page = await (await browser.newContext({ viewport: laptop })).newPage();
  await page.goto(address);
  await page.waitForFunction(() => window.chladni?.frames > 3, null, { timeout: 180_000 });
  const { seen, acts } = await page.evaluate(() => new Promise((done) => {
    const began = performance.now();
    const since = () => performance.now() - began;
    let seen;
    document.getElementById("exaggerate").click();
    const look = () => {
      const { sitting } = window.chladni;
      if (sitting) seen ??= since();
      if (sitting?.layers[0]?.state !== "acts") return setTimeout(look, 20);
      done({ seen, acts: since() / 1000 });
    };
    look();
  }));
  const { solveSecs, matchSecs } = await page.evaluate(() => window.chladni);
  await page.waitForTimeout(2000);
  const found = await page.evaluate(() => new Promise((done) => {
    const [slider, from, began] = [document.getElementById("mu"), window.chladni.frames, performance.now()];
    let steps = 0;
    const step = () => {
      slider.value = -0.5 - 0.01 * (steps % 50);
      slider.dispatchEvent(new Event("input"));
      if (++steps < 150) return requestAnimationFrame(step);
      const { frames, drawMs } = window.chladni;
      done({ fps: (1000 * (frames - from)) / (performance.now() - began), drawMs });
    };
    step();
  }));
  console.log(`sample head of 18,822 vertices: seen after ${seen.toFixed(0)} ms, its first layer acts after ${acts.toFixed(1)} s ` +
    `(256 harmonics ${solveSecs.toFixed(1)} s, beside them the match ${matchSecs.toFixed(1)} s)`);
  console.log(`μ follows a slider with ${found.fps.toFixed(1)} pictures a second, ${found.drawMs.toFixed(0)} ms to draw`);
  await page.close();
}

/** 15,051 vertices, 256 harmonics, in turn: in the worker on one thread and on all, and by the desktop's command on as many.
 * The medians of five. */
async function solves() {
  const path = join(out, "torus-15k.obj");
  const mesh = torus(173, 87);
  writeFileSync(path, mesh);
  // A document in which nothing is drawn beside the solve, as the command draws nothing.
  const quiet = async (at) => {
    const page = await (await browser.newContext()).newPage();
    await page.goto(`${at}style.css`);
    return page;
  };
  const isolated = await serve(folder, ISOLATED);
  const pages = [await quiet(address), await quiet(isolated.address)];
  const within = (page) => page.evaluate(async (text) => {
    const { ask } = await import("/work.js");
    const bytes = new TextEncoder().encode(text);
    const { secs, threads } = await ask({ work: "solve", name: "torus.obj", bytes, harmonics: 256, laplacian: "delaunay" });
    return [secs, threads];
  }, mesh.toString());
  const chladni = process.env.CHLADNI ?? join(out, "../release/chladni");
  const desktop = (threads) => {
    const from = performance.now();
    const options = ["--no-cache", "--quiet", "-k", "256", "--threads", threads];
    execFileSync(chladni, ["basis", path, ...options], { stdio: "pipe" });
    return (performance.now() - from) / 1000;
  };
  const found = new Map();
  const note = (what, secs) => found.set(what, [...found.get(what) ?? [], secs].sort((a, b) => a - b));
  for (let run = 0; run < 5; run++) {
    for (const page of pages) {
      const [secs, threads] = await within(page);
      note(`the page, threads: ${threads}`, secs);
      if (existsSync(chladni)) note(`the desktop, threads: ${threads}`, desktop(threads));
    }
  }
  const told = [...found].map(([what, secs]) => `${what}: ${secs[2].toFixed(2)} s (${secs[0].toFixed(2)} to ${secs.at(-1).toFixed(2)})`);
  console.log(`15,051 vertices, 256 harmonics, median of 5. ${told.join("; ")}`);
  isolated.stop();
}

const opened = async (within, query = "") => {
  const page = await (await within.newContext({ viewport: { width: 1280, height: 720 } })).newPage();
  await page.goto(`${address}${query}`);
  await page.waitForFunction(() => window.chladni?.frames > 3 && window.chladni.sound.duration > 0, null, { timeout: 180_000 });
  return page;
};
const onStage = async (page) => {
  await gallery(page);
  await page.locator(".cell:nth-child(5) .stage").dispatchEvent("click");
  await page.waitForFunction(() => window.chladni.state.on_stage && window.chladni.sound.isHeard, null, { timeout: 60_000 });
  await page.waitForTimeout(5000);
};

/** How far the picture's place in the song lies behind that of the sound, when the next picture begins, beside how long that takes. */
async function clock() {
  const page = await opened(browser);
  await onStage(page);
  const found = await page.evaluate(async () => {
    const { Concert } = await import("./chladni_web.js");
    const { frame } = Concert.prototype;
    const [behind, lengths, apart] = [[], [], []];
    let last;
    return new Promise((done) => {
      Concert.prototype.frame = function (...given) {
        const [position, now] = [given[2], performance.now() / 1000];
        const late = window.chladni.sound.position() - (last?.position ?? position);
        if (last && late > 0 && late < 2) {
          behind.push(late);
          lengths.push(now - last.now);
          apart.push(Math.abs(position - last.position - (now - last.now)));
        }
        last = { position, now };
        if (behind.length === 300) { Concert.prototype.frame = frame; done([behind, lengths, apart]); }
        return frame.apply(this, given);
      };
    });
  });
  const texts = found.map((secs) => {
    const sorted = secs.toSorted((a, b) => a - b);
    return [0.5, 0.95, 1].map((share) => (1000 * sorted[Math.min(299, Math.floor(share * 300))]).toFixed(1)).join(", ");
  });
  console.log(`300 pictures on stage, median, 95 %, most: the sound is ahead of a picture by ${texts[0]} ms when the next begins, ` +
    `which a picture's length explains (${texts[1]} ms); the song's clock and the page's differ in one by ${texts[2]} ms`);
  await page.close();
}

/** The time that deforming takes of a picture beside drawing it, by the processor and by a card, which a processor plays here. */
async function shares() {
  const withCard = await launch(out, WITH_CARD);
  for (const [name, within, query] of [["the processor draws", browser, "?draw=cpu"], ["a software card draws", withCard, "?draw=gpu"]]) {
    for (const [what, enter] of [["gallery of twelve", gallery], ["stage", onStage]]) {
      const page = await opened(within, query);
      await enter(page);
      await page.waitForTimeout(4000);
      const [deform, draw, length, vertices] = await page.evaluate(async () => {
        const { Concert } = await import("./chladni_web.js");
        const { frame } = Concert.prototype;
        const all = [];
        let [last, vertices] = [];
        await new Promise((done) => {
          Concert.prototype.frame = function (...given) {
            const drawn = frame.apply(this, given);
            vertices = this.vertices();
            const now = performance.now();
            if (last) all.push([...this.took_ms(), now - last]);
            last = now;
            if (all.length === 100) { Concert.prototype.frame = frame; done(); }
            return drawn;
          };
        });
        return [...[0, 1, 2].map((i) => all.map((each) => each[i]).sort((a, b) => a - b)[50]), vertices];
      });
      console.log(`${name}, ${what}, ${vertices} vertices each: medians of 100: deforming ${deform.toFixed(1)} ms, drawing ${draw.toFixed(1)} ms, ` +
        `from one picture to the next ${length.toFixed(1)} ms: deforming takes ${((100 * deform) / length).toFixed(0)} %`);
      await page.close();
    }
  }
  await withCard.close();
}

const only = process.argv[4];
const parts = { weights, music, caricature, clock, shares, solves };
for (const [name, part] of Object.entries(parts)) if (!only || only === name) await part();
await browser.close();
stop();

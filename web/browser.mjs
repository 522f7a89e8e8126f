// A page in headless Chromium or Firefox, and files made up for it: for tests and benchmarks.
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { existsSync, readFileSync } from "node:fs";
import { extname, join } from "node:path";

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm" };
const FLAGS = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync"];

/** Headers with which browsers lend a page memory that its workers share. */
export const ISOLATED = { "cross-origin-opener-policy": "same-origin", "cross-origin-embedder-policy": "require-corp" };

/** Serves a folder, as any file server does, or with these headers; resolves to its address. */
export function serve(folder, headers = {}) {
  const server = createServer((request, response) => {
    const path = join(folder, new URL(request.url, "http://x").pathname.replace(/\/$/, "/index.html"));
    if (!path.startsWith(folder) || !existsSync(path)) return response.writeHead(404).end();
    response.writeHead(200, { "content-type": TYPES[extname(path)] ?? "application/octet-stream", ...headers });
    response.end(readFileSync(path));
  });
  return new Promise((done) => server.listen(0, "localhost", () =>
    done({ address: `http://localhost:${server.address().port}/`, stop: () => { server.close(); server.closeAllConnections(); } })));
}

/** Flags with which no graphics card is asked, and with which a processor plays one. */
export const WITHOUT_CARD = ["--disable-gpu"];
export const WITH_CARD = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan",
  "--use-vulkan=swiftshader", "--use-angle=vulkan"];
/** Flags with which a processor plays a graphics card that has WebGL2 alone. */
export const WITH_WEBGL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];

/** Flags with which a WAV file plays into a microphone that nobody has to allow. */
export const microphone = (wav) => ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream", `--use-file-for-fake-audio-capture=${wav}`];

/** Chromium of the system, driven by playwright-core of the tools folder. */
export async function launch(out, flags = WITHOUT_CARD) {
  const { chromium } = createRequire(join(out, "tools/"))("playwright-core");
  const executablePath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);
  return chromium.launch({ executablePath, args: [...FLAGS, ...flags] });
}

/** Firefox of the system, driven by puppeteer-core of the tools folder; undefined where it is not there. */
export async function launchFirefox(out) {
  const executablePath = ["/usr/bin/firefox", "/usr/bin/firefox-esr"].find(existsSync);
  if (!executablePath) return undefined;
  return createRequire(join(out, "tools/"))("puppeteer-core").launch({ browser: "firefox", executablePath });
}

/** The picture's pixels, thinned out. */
export const pixels = (page) => page.evaluate(() => {
  const canvas = document.getElementById("picture");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return Array.from({ length: 4000 }, (_, i) => data[4 * Math.floor((i * data.length) / 16000) + (i % 3)]);
});

/** How many of the thinned pixels differ plainly. */
export const differing = (a, b) => a.filter((value, i) => Math.abs(value - b[i]) > 8).length;

/** A plain head as OBJ: an ellipsoid with a nose. */
export function head(around, down) {
  const lines = [];
  const at = (i, j) => 2 + (j - 1) * around + (i % around);
  const place = (turn, fall) => {
    const nose = 0.35 * Math.exp(-12 * (turn * turn + (fall - 1.7) ** 2));
    const round = Math.sin(fall);
    return `v ${0.8 * round * Math.sin(turn)} ${1.2 * Math.cos(fall)} ${(1 + nose) * round * Math.cos(turn)}`;
  };
  lines.push(place(0, 0));
  for (let j = 1; j < down; j++) for (let i = 0; i < around; i++) {
    lines.push(place((2 * Math.PI * i) / around - (i > around / 2 ? 2 * Math.PI : 0), (Math.PI * j) / down));
  }
  lines.push(place(0, Math.PI));
  const last = 2 + (down - 1) * around;
  for (let i = 0; i < around; i++) {
    lines.push(`f 1 ${at(i, 1)} ${at(i + 1, 1)}`, `f ${last} ${at(i + 1, down - 1)} ${at(i, down - 1)}`);
    for (let j = 1; j < down - 1; j++) {
      lines.push(`f ${at(i, j)} ${at(i, j + 1)} ${at(i + 1, j + 1)}`, `f ${at(i, j)} ${at(i + 1, j + 1)} ${at(i + 1, j)}`);
    }
  }
  return Buffer.from(lines.join("\n") + "\n");
}

/** A torus as OBJ. */
export function torus(around, across) {
  const lines = [];
  for (let i = 0; i < around; i++) for (let j = 0; j < across; j++) {
    const [u, v] = [(2 * Math.PI * i) / around, (2 * Math.PI * j) / across];
    lines.push(`v ${(1 + 0.4 * Math.cos(v)) * Math.cos(u)} ${0.4 * Math.sin(v)} ${(1 + 0.4 * Math.cos(v)) * Math.sin(u)}`);
  }
  const at = (i, j) => (i % around) * across + (j % across) + 1;
  for (let i = 0; i < around; i++) for (let j = 0; j < across; j++) {
    lines.push(`f ${at(i, j)} ${at(i, j + 1)} ${at(i + 1, j + 1)}`, `f ${at(i, j)} ${at(i + 1, j + 1)} ${at(i + 1, j)}`);
  }
  return Buffer.from(lines.join("\n"));
}

/** Some seconds of clicks at 120 a minute over a rising tone, as WAV. */
export function song(secs) {
  const rate = 22050;
  const frames = secs * rate;
  const wav = Buffer.alloc(44 + 4 * frames);
  wav.write("RIFF", 0); wav.writeUInt32LE(36 + 4 * frames, 4); wav.write("WAVEfmt ", 8);
  wav.writeUInt32LE(16, 16); wav.writeUInt16LE(1, 20); wav.writeUInt16LE(2, 22); wav.writeUInt32LE(rate, 24);
  wav.writeUInt32LE(4 * rate, 28); wav.writeUInt16LE(4, 32); wav.writeUInt16LE(16, 34);
  wav.write("data", 36); wav.writeUInt32LE(4 * frames, 40);
  for (let n = 0; n < frames; n++) {
    const t = n / rate;
    const click = Math.exp(-40 * (t % 0.5)) * Math.sin(2 * Math.PI * 90 * (t % 0.5));
    const tone = 0.3 * Math.sin(2 * Math.PI * (220 + 60 * t) * t);
    wav.writeInt16LE(Math.round(12000 * (click + tone)), 44 + 4 * n);
    wav.writeInt16LE(Math.round(12000 * (click + 0.5 * tone)), 46 + 4 * n);
  }
  return wav;
}

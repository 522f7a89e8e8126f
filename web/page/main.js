// The page: its front, the way into both rooms, and the files that are brought.
import init, { kind, songs_in_list, without_companions } from "./chladni_web.js";
import { compiled, giveUp } from "./work.js";
import { openCard } from "./card.js";
import { hands } from "./hands.js";
import { attempt, attemptOf, base, of, on, report, say } from "./page.js";
import { start as draw } from "./picture.js";
import { notKept, tellCores, threadFiles } from "./threads.js";
import * as music from "./music.js";
import { TUNE, decode } from "./songs.js";
import { isFilmed, isUnfinished } from "./room_films.js";
import * as caricature from "./caricature.js";

const { dataset } = document.body;
const isIn = (view) => dataset.view === view;
report.view = () => (isIn("caricature") ? caricature : music).view();

/** Shows a room. The browser's Back leads from it to the front: one entry of its history stands for all visits. */
function showRoom(view) {
  if (!history.state?.inRoom) history.pushState({ inRoom: true }, "");
  // Full screen shows the picture alone in the music room only.
  if (view !== "music") delete dataset.bare;
  dataset.view = view;
}

async function goHome() {
  // They are about the room that is left.
  for (const dialog of document.querySelectorAll("dialog[open]")) dialog.close();
  music.leave();
  delete dataset.empty;
  delete dataset.bare;
  dataset.view = "front";
  await music.front();
}

async function enterMusic() {
  if (isIn("music")) return;
  showRoom("music");
  delete dataset.empty;
  await music.open();
}

function enterCaricature() {
  if (isIn("caricature")) return;
  showRoom("caricature");
  music.leave();
  caricature.open();
}

/** Opens what was brought where it belongs; `beside` it, by their names, are meshes that a project may need. Projects and
 * masks that cannot be used change no room. Shapes are solved and matched after that, so that the files behind one do
 * not wait. */
async function take(name, bytes, beside) {
  switch (/\.np[yz]$/i.test(name) ? "mask" : kind(name)) {
    case "text": await enterMusic(); return music.openText(name, bytes);
    case "project": await caricature.openProject(name, bytes, beside, enterCaricature); return true;
    case "mesh":
      if (caricature.waitsFor(name)) enterCaricature();
      if (isIn("caricature")) return caricature.takeMesh(name, bytes);
      await enterMusic();
      attemptOf(name, () => music.openMesh(name, bytes));
      return undefined;
    case "mask": return caricature.takeMask(name, bytes, enterCaricature);
    default: throw new Error(`${name}: the page opens meshes, songs and lists of them, shows, dances, projects and masks.`);
  }
}

/** One that cannot be opened, such as the cover of an album, leaves the others. */
const takeFile = (file, beside) => attemptOf(file.name, async () => take(file.name, new Uint8Array(await file.arrayBuffer()), beside));

/** What says what it needs comes before what it needs. */
const order = ({ name }) => (["text", "project"].includes(kind(name)) ? 0 : 1);

/** The file by the name by which others may ask for it. */
const composed = (file) => (file.name === base(file.name) ? file : new File([file], base(file.name)));

/** A film that waits for its pictures has the shape and the song with which it began. */
function refuseWhileFilmed() {
  if (isFilmed()) throw new Error("A film waits for its pictures: open files once it is done, or stop it.");
}

const open = attempt(async (brought) => {
  refuseWhileFilmed();
  const files = withoutCompanions(brought.map(composed));
  const [songs, lists] = ["song", "list"].map((wanted) => files.filter(({ name }) => kind(name) === wanted));
  const beside = await meshesBesideProjects(files);
  const came = new Set(beside.keys());
  let isRefused = false;
  for (const file of files.toSorted((a, b) => order(a) - order(b))) {
    // The meshes that came with a project which cannot be used were meant for it.
    const isTaken = came.has(file.name) && (isRefused || !beside.has(file.name));
    if ([...songs, ...lists].includes(file) || isTaken) continue;
    // It may have begun while the files before this one were opened.
    refuseWhileFilmed();
    const isOpen = await takeFile(file, beside);
    isRefused ||= kind(file.name) === "project" && !isOpen;
  }
  const { inOrder, missing } = await inOrderOf(lists, songs);
  if (inOrder.length) {
    refuseWhileFilmed();
    await Promise.all([enterMusic(), music.openSongs(inOrder)]);
  }
  if (missing.length) throw new Error(`${lists[0].name}: a page finds no files by itself. Open these together with the list: ${missing.slice(0, 5).join(", ")}${missing.length > 5 ? `, and ${missing.length - 5} more` : ""}.`);
});

/** The files that are opened by themselves, as on the desktop. */
function withoutCompanions(files) {
  const opened = without_companions(files.map(({ name }) => name));
  return files.filter(({ name }) => opened.includes(name));
}

/** The meshes that came with a project, by their names. */
async function meshesBesideProjects(files) {
  const found = new Map();
  if (!files.some(({ name }) => kind(name) === "project")) return found;
  for (const file of files.filter(({ name }) => kind(name) === "mesh")) {
    // One that cannot be read is reported when it is to be taken.
    const bytes = await file.arrayBuffer().catch(() => undefined);
    if (bytes) found.set(file.name, new Uint8Array(bytes));
  }
  return found;
}

/** Songs in the order of the lists that came with them, those of no list behind them; and what the lists name besides. */
async function inOrderOf(lists, songs) {
  const names = [];
  // VLC writes names as in addresses.
  const plain = (name) => { try { return base(decodeURIComponent(name)); } catch { return name; } };
  const meant = (name) => (songs.some((song) => song.name === name) ? name : plain(name));
  for (const list of lists) names.push(...songs_in_list(new Uint8Array(await list.arrayBuffer())).map(base).map(meant));
  const place = ({ name }) => (names.includes(name) ? names.indexOf(name) : names.length);
  return { inOrder: songs.toSorted((a, b) => place(a) - place(b)), missing: names.filter((name) => !songs.some((song) => song.name === name)) };
}

/** Asks before the page is closed, where a caricature, a gallery or a film would be lost. */
function asksBeforeClosing(event) {
  if (caricature.isUnsaved() || music.isUnsaved() || isUnfinished()) event.preventDefault();
}

function listen() {
  addEventListener("beforeunload", asksBeforeClosing);
  on("enter", async () => { showRoom("music"); await music.enter(); });
  on("exaggerate", () => { enterCaricature(); return caricature.begin(); });
  on("bring", () => of("file").click());
  for (const id of ["open", "open-project"]) on(id, () => of("file").click());
  on("home", goHome);
  addEventListener("popstate", attempt(() => {
    if (isIn("front") || history.state?.inRoom) return undefined;
    // A film that waits for its pictures stays until it is done.
    return isFilmed() ? showRoom(dataset.view) : goHome();
  }));
  on("cancel", () => giveUp());
  // An iPhone's browser has none for pages.
  of("full").hidden = !document.fullscreenEnabled;
  on("full", async () => {
    if (document.fullscreenElement) return document.exitFullscreen();
    await document.documentElement.requestFullscreen();
    dataset.bare = isIn("music") ? "yes" : "";
  });
  document.addEventListener("fullscreenchange", () => { if (!document.fullscreenElement) delete dataset.bare; });
  of("file").addEventListener("change", () => { open([...of("file").files]); of("file").value = ""; });
  addEventListener("drop", (event) => open([...event.dataTransfer.files]));
  hands([of("picture"), of("cells")], () => (isIn("caricature") ? caricature : music));
  music.listen();
  caricature.listen();
  for (const button of of("front").querySelectorAll("button")) button.disabled = false;
  of("loading").hidden = true;
}

/** The module and what draws; where they cannot be had, the reason stays to be read. */
async function load() {
  try {
    const { memory } = await init({ module_or_path: await compiled });
    await openCard();
    return memory;
  } catch (error) {
    of("loading").textContent = `Chladni could not be loaded (${error.message ?? error}): open the page again.`;
    return undefined;
  }
}

const start = attempt(async () => {
  const tune = decode({ name: TUNE });
  tune.catch(() => {});
  const memory = await load();
  if (!memory) return;
  tellCores();
  listen();
  draw(memory);
  // Where a room is entered at once the plate is not needed any more, but the tune is.
  const began = await Promise.allSettled([music.front(), music.know(tune)]);
  const failed = began.find(({ reason }) => reason && !["ObsoleteError", "AbortError"].includes(reason.name));
  if (failed) throw failed.reason;
  say("");
});
start();

// What was loaded once opens without a connection, too.
navigator.serviceWorker?.register("offline.js").then(() => navigator.serviceWorker.ready).then(({ active }) => {
  const loaded = performance.getEntriesByType("resource").map(({ name }) => name);
  const later = ["worker.js", "capture.js", ...threadFiles].map((name) => new URL(name, location).href);
  active.postMessage([location.href, ...later, ...loaded]);
}).catch(notKept); // Not every browser lets a page be kept.

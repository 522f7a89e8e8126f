// The list of songs: one plays after the other, and each is decoded while the one before it plays.
import { busy, ofFile, say } from "./page.js";
import { ask, giveUp, obsolete, works } from "./work.js";

/** Our own, which makes room for any other. */
export const TUNE = "sample:tune";

/** Each has a name and a file; the one that plays also has its sound, and each that was heard has the `reading` of its beats. */
const list = [];
let playing;
/** What comes after it, once it was asked for. */
let ahead;

export const current = () => playing;
export const count = () => list.length;
export const all = () => list;
export const place = () => list.indexOf(playing);

/** A song by its name: one that was brought, or the tune. */
export const find = (name) => list.find((song) => song.name === name) ?? (name === TUNE ? { name } : undefined);

/** The songs of a show by their names, nothing for one that is missing. Of two that share a name, each has its own song, in
 * the order of the list. The show says itself how their beats are read. */
export function findForShow(names) {
  return names.map((name, i) => {
    const before = names.slice(0, i).filter((each) => each === name).length;
    const song = list.filter((each) => each.name === name)[before] ?? find(name);
    if (song) song.reading = undefined;
    return song;
  });
}

/** Adds songs at the end of the list; gives the first of them. */
export function add(files) {
  const songs = files.map((file) => ({ name: file.name, file }));
  list.push(...songs);
  return songs[0];
}

/** The tune alone, as it was decoded. */
export function begin(sound) {
  playing = { name: TUNE, sound };
  // Before a song that is still being decoded, which takes its place.
  list.unshift(playing);
  return playing;
}

/** So many places after a song, or before it; the first comes after the last. */
export const beside = (song, steps) => list.at((list.indexOf(song) + steps) % list.length);

/** What stands behind a song, if anything does. */
export const behind = (song) => list[list.indexOf(song) + 1];

/** Takes out a song; the last one makes room for the tune. Gives what is to play in its place, where it was the one that played. */
export function takeOut(song) {
  const next = strike(song) ?? list[0];
  if (!next) list.push({ name: TUNE });
  return song === playing ? next ?? list[0] : undefined;
}

/** Puts the songs in an order by chance; the one that plays comes first. */
export function shuffle() {
  list.sort((a, b) => (b === playing) - (a === playing));
  for (let last = list.length - 1; last > 1; last--) {
    const other = 1 + Math.floor(Math.random() * last);
    [list[last], list[other]] = [list[other], list[last]];
  }
}

/** Takes out a song that cannot be read; gives what stands in its place, if anything does. */
export function strike(song) {
  const index = list.indexOf(song);
  if (index >= 0) list.splice(index, 1);
  return list[index];
}

/** The sound of a song, decoded by a worker. */
export async function decode(song, report, worker = "song") {
  const bytes = song.file && new Uint8Array(await song.file.arrayBuffer());
  return ask({ work: "decode", name: song.name, bytes }, report, worker);
}

/** The sound of a song: the one that was decoded beforehand, where that went well. */
export async function soundOf(song) {
  const { sound, warnings } = ahead?.song === song ? ahead : {};
  ahead = undefined;
  const early = await sound?.catch(() => undefined);
  if (!early) return busy(song.name, (tell) => decode(song, (kind, text) => { if (kind !== "warning" || isNews(song, text)) tell(kind, text); }));
  const news = warnings.filter((text) => isNews(song, text));
  if (news.length) say(news.join(" "), false, 20);
  return early;
}

/** Whether that was not said of a song before: each is decoded again whenever it comes round. */
function isNews(song, text) {
  song.said ??= new Set();
  const isKnown = song.said.has(text);
  song.said.add(text);
  return !isKnown;
}

/** A song plays from now on, as it sounds. */
export function play(song, sound) {
  // Samples of the one before are not heard until it comes again.
  if (playing) playing.sound = undefined;
  song.sound = sound;
  playing = song;
  if (list.length > 1 && list[0].name === TUNE) list.shift();
}

/** Decodes the next song while this one plays. One that was decoded earlier and no longer comes next is dropped. What cannot be
 * read is struck and reported to `failed`, and the next is taken. If only its worker stopped, that is reported, too, and the
 * song stays. */
export function prepare(failed) {
  const song = playing && beside(playing, 1);
  if (ahead?.song === song) return;
  const isOvertaken = !!ahead && works("ahead");
  ahead = undefined;
  if (isOvertaken) giveUp(obsolete(), ["ahead"]);
  if (!song || song === playing) return;
  const warnings = [];
  const tell = (kind, text) => { if (kind === "warning") warnings.push(text); };
  ahead = { song, warnings, sound: decode(song, tell, "ahead") };
  ahead.sound.catch((error) => {
    // Cancelled, it is decoded when it is to play; another one may have come before it.
    if (error.name === "AbortError" || ahead?.song !== song) return;
    if (error.name === "StoppedError") {
      ahead = undefined;
      failed(ofFile(song.name, error));
      return;
    }
    strike(song);
    failed(ofFile(song.name, error));
    prepare(failed);
  });
}

// A saved show, played: the module does again what was done, and says what is to be heard; songs follow that here.
import { base, of, say } from "./page.js";
import * as songs from "./songs.js";

/** The show that was opened last: its text and what it needs. */
let opened;
/** Since when, in milliseconds of the page, the show waits for a song that is being decoded. */
let waitsSince;
/** Seconds of the page's clock in which the dance stood still, or had one of its own. */
let waitedSecs = 0;
let wasPlayed = false;

/** A show was opened. */
export function know(text, needs) { opened = { text, needs }; }

/** The names of its songs that are not here. */
const missingOf = (needs) => needs.songs.filter((name) => !songs.find(name));

/** The news that a show with these needs is open on its body: what it still lacks, and what is other here. */
export function isOpen(name, needs, looks) {
  const missing = missingOf(needs);
  const lacks = missing.length && `${name} is open. It was danced to ${missing.join(", ")}: drop that song, too.`;
  const behind = [looks.picture, looks.panorama].filter(Boolean).map(base);
  const unseen = !lacks && behind.length
    && `${behind.join(" and ")} cannot be shown behind it: the page has no pictures of one's own.`;
  return [lacks || `${name} is open.`, needs.caution, needs.others, unseen].filter(Boolean).join(" ");
}

export const isWaiting = () => waitsSince !== undefined;
/** The page's clock without the times in which a show waited. */
export const clockSecs = (now) => now / 1000 - waitedSecs;
/** The show waits no more, if it did; that time does not count. */
export function endWait() {
  if (!isWaiting()) return;
  skip((performance.now() - waitsSince) / 1000);
  waitsSince = undefined;
}
/** So much of the page's time does not count: the dance had a clock of its own. */
export function skip(secs) { waitedSecs += secs; }

/** The songs of the show that was opened, by their numbers there. */
function cast() {
  if (!opened) return [];
  const missing = missingOf(opened.needs);
  if (missing.length) throw new Error(`The show was danced to ${missing.join(", ")}: drop that song, too.`);
  return songs.findForShow(opened.needs.songs);
}

/** Plays it on `concert` from its beginning; gives its songs. */
export function begin(concert) {
  const all = cast();
  concert.play_show(opened.text);
  wasPlayed = true;
  return all;
}

/** Follows what is to be heard by now. `hear(song, secs, playing)` lets it be heard: of no song, nothing. */
export async function follow(concert, all, hear) {
  const text = isWaiting() ? undefined : concert.cue();
  if (!text) return;
  const { song, song_secs, playing } = JSON.parse(text);
  if (song === null) say("What came in live was not recorded: it is silent here.");
  const began = waitsSince = performance.now();
  // The room may have been left meanwhile.
  try { await hear(all[song], song_secs, playing); } finally { if (waitsSince === began) endWait(); }
}

/** Shows whether a show can be played, or is; true where one has just ended by itself or by a hand. */
export function draw(played) {
  of("play-show").hidden = !opened;
  of("play-show").textContent = played ? "Stop show" : "Play show";
  const ended = wasPlayed && !played;
  wasPlayed = played;
  return ended;
}

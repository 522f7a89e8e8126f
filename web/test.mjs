// The page in a real browser: it opens, moves, takes a mesh and a song, breeds, exaggerates, saves and opens again.
// node web/test.mjs PAGE OUT [music|beats|shows|returns|haste|beginnings|films|microphone|caricature|tools|ways|access|
// models|card|webgl|threads|offline|firefox]; pictures of it go into OUT/screens.
import * as access from "./tests/access.mjs";
import { browser, keepsPolicy, stop } from "./tests/driver.mjs";
import * as card from "./tests/card.mjs";
import { beats } from "./tests/beats.mjs";
import * as beginnings from "./tests/beginnings.mjs";
import * as caricature from "./tests/caricature.mjs";
import { firefox } from "./tests/firefox.mjs";
import * as haste from "./tests/haste.mjs";
import * as microphone from "./tests/microphone.mjs";
import * as models from "./tests/models.mjs";
import * as music from "./tests/music.mjs";
import { offline } from "./tests/offline.mjs";
import { projects } from "./tests/projects.mjs";
import * as returns from "./tests/returns.mjs";
import * as shows from "./tests/shows.mjs";
import { threads } from "./tests/threads.mjs";
import * as tools from "./tests/tools.mjs";
import * as ways from "./tests/ways.mjs";

const only = process.argv[4];
const rooms = {
  music: [music.laptop, music.plate, music.phone],
  beats: [beats],
  shows: [shows.shows, shows.flashes, shows.withoutSong, shows.films],
  returns: [returns.dances, returns.settings, returns.galleries, returns.overtaken, returns.layers],
  haste: [haste.shapes, haste.songs, haste.films, haste.layers, projects],
  beginnings: [beginnings.beginnings, beginnings.lostTune, beginnings.withoutSong, beginnings.slowly],
  films: [shows.wholeFilms, shows.stoppedFilms, shows.brokenFilms],
  microphone: [microphone.heard, microphone.refused],
  caricature: [caricature.laptop, caricature.phone],
  tools: [tools.laptop, tools.phone],
  ways: [ways.music, ways.caricature, ways.policy, ways.stopped],
  access: [access.names, access.translated, access.fullScreen, access.motion, access.large, access.inSight, access.pictures],
  models: [models.chosen],
  card: [card.webgpu.pictures, card.webgpu.loss],
  webgl: [card.webgl.pictures, card.webgl.loss, card.webgl.gallery, card.webgl.looks, card.webgl.skin],
  threads: [threads],
  offline: [offline],
  firefox: [firefox],
};
try {
  for (const [room, tests] of Object.entries(rooms)) {
    if (!only || only === room) for (const test of tests) {
      await test();
      keepsPolicy();
    }
  }
} finally {
  await browser.close();
  stop();
}

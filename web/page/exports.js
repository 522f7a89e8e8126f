// What the caricature room gives away and takes beside meshes and projects: pictures, drawings, masks, landmarks.
import { inkFile } from "./ink.js";
import { attempt, busy, of, on, save, say } from "./page.js";
import { LONGEST, sizeOf } from "./picture.js";

const TYPES = { glb: "model/gltf-binary", obj: "model/obj", ply: "application/octet-stream", stl: "model/stl" };

let room;

const size = () => sizeOf(LONGEST);

/** A picture as it is seen: drawn in ink or not. */
async function savePicture() {
  const name = `${room.stem()}-caricature.png`;
  if (!room.isInInk()) return save(name, room.sitting().export_picture(...size()), "image/png");
  save(name, await drawn("png"), "image/png");
}

const drawn = (format) => busy("the drawing", () => inkFile(room.sitting(), format, of("tones").checked, ...size()));

/** A mask was brought: the region of the chosen layer. One that can be used calls `enter()`. */
export async function takeMask(name, bytes, enter = () => {}) {
  room.sitting().open_mask(name, bytes);
  enter();
  await room.changed();
  say(`${name} is the region of the chosen layer.`);
}

/** Asks for one file, and has `take(name, bytes)` take it. */
function ask(accept, take) {
  const input = Object.assign(document.createElement("input"), { type: "file", accept });
  input.onchange = attempt(async () => {
    const [file] = input.files;
    if (file) await take(file.name, new Uint8Array(await file.arrayBuffer()));
  });
  input.click();
}

export function listen(caricature) {
  room = caricature;
  on("save-project", () => { save(`${room.projectStem()}.chladni`, room.sitting().save_project()); room.saved(); });
  for (const format of ["glb", "obj", "ply", "stl"]) {
    on(`export-${format}`, () => {
      save(`${room.stem()}-caricature.${format}`, room.sitting().export(format), TYPES[format]);
      const notes = room.sitting().take_notes();
      if (notes) say(notes);
    });
  }
  on("export-png", savePicture);
  on("export-svg", async () => save(`${room.stem()}-caricature.svg`, await drawn("svg"), "image/svg+xml"));
  on("open-mask", () => ask(".npy,.npz,.ply,.obj,.off,.glb", takeMask));
  for (const ending of ["npy", "npz", "ply"]) {
    on(`save-mask-${ending}`, () => save(`${room.stem()}-mask.${ending}`, room.sitting().save_mask(ending), "application/octet-stream"));
  }
  on("open-landmarks", () => ask(".txt", (name, bytes) => {
    room.sitting().open_landmarks(new TextDecoder().decode(bytes));
    return room.changed();
  }));
  on("save-landmarks", () => save(`${room.stem()}-landmarks.txt`, room.sitting().save_landmarks()));
}

// A torus with an image around it, as GLB.
import { crc32, deflateSync } from "node:zlib";

/** A picture of squares as PNG. */
function squares(side) {
  const chunk = (kind, bytes) => {
    const body = Buffer.concat([Buffer.from(kind), bytes]);
    const framed = Buffer.alloc(body.length + 8);
    framed.writeUInt32BE(bytes.length, 0);
    body.copy(framed, 4);
    framed.writeUInt32BE(crc32(body), body.length + 4);
    return framed;
  };
  const header = Buffer.alloc(13);
  header.writeUInt32BE(side, 0);
  header.writeUInt32BE(side, 4);
  header.set([8, 2], 8);
  const rows = Buffer.alloc(side * (1 + 3 * side));
  for (let y = 0; y < side; y++) for (let x = 0; x < side; x++) {
    const odd = ((x >> 4) ^ (y >> 4)) & 1;
    rows.set(odd ? [220, 60, 40] : [60, 110, 200], y * (1 + 3 * side) + 1 + 3 * x);
  }
  const signature = Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]);
  return Buffer.concat([signature, chunk("IHDR", header), chunk("IDAT", deflateSync(rows)), chunk("IEND", Buffer.alloc(0))]);
}

export function skinned(around, across) {
  const [places, uvs, corners] = [[], [], []];
  for (let i = 0; i <= around; i++) for (let j = 0; j <= across; j++) {
    const [u, v] = [(2 * Math.PI * (i % around)) / around, (2 * Math.PI * (j % across)) / across];
    places.push((1 + 0.4 * Math.cos(v)) * Math.cos(u), 0.4 * Math.sin(v), (1 + 0.4 * Math.cos(v)) * Math.sin(u));
    uvs.push((4 * i) / around, (2 * j) / across);
  }
  const at = (i, j) => i * (across + 1) + j;
  for (let i = 0; i < around; i++) for (let j = 0; j < across; j++) {
    corners.push(at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i + 1, j));
  }
  const parts = [Buffer.from(Float32Array.from(places).buffer), Buffer.from(Float32Array.from(uvs).buffer),
    Buffer.from(Uint32Array.from(corners).buffer), squares(64)];
  let end = 0;
  const bufferViews = parts.map((part) => {
    const view = { buffer: 0, byteOffset: end, byteLength: part.length };
    end += part.length;
    return view;
  });
  const accessor = (bufferView, componentType, type, count) => ({ bufferView, componentType, type, count });
  const json = Buffer.from(JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, indices: 2, material: 0 }] }],
    accessors: [
      { ...accessor(0, 5126, "VEC3", places.length / 3), min: [-1.4, -0.4, -1.4], max: [1.4, 0.4, 1.4] },
      accessor(1, 5126, "VEC2", uvs.length / 2), accessor(2, 5125, "SCALAR", corners.length),
    ],
    bufferViews, buffers: [{ byteLength: end }], images: [{ bufferView: 3, mimeType: "image/png" }], textures: [{ source: 0 }],
    materials: [{ pbrMetallicRoughness: { baseColorTexture: { index: 0 } } }],
  }));
  const padded = (bytes, by) => Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4, by)]);
  const block = (kind, bytes) => {
    const head = Buffer.alloc(8);
    head.writeUInt32LE(bytes.length, 0);
    head.write(kind, 4, "latin1");
    return Buffer.concat([head, bytes]);
  };
  const body = Buffer.concat([block("JSON", padded(json, 32)), block("BIN\0", padded(Buffer.concat(parts), 0))]);
  const head = Buffer.alloc(12);
  head.write("glTF", 0, "latin1");
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + body.length, 8);
  return Buffer.concat([head, body]);
}

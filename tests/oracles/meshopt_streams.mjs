// Writes streams of meshoptimizer's encoder, with the output of its decoder, for the tests of src/gltf/meshopt.
//
//   npm install meshoptimizer && node tests/oracles/meshopt_streams.mjs
import { MeshoptEncoder, MeshoptDecoder } from 'meshoptimizer';
import fs from 'fs';
await MeshoptEncoder.ready; await MeshoptDecoder.ready;
// Pseudo-random numbers with a fixed seed.
let state = 12345;
const random = () => ((state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32);
const streams = [];
function add(name, mode, filter, count, stride, source, version) {
  let stream;
  if (mode === 'ATTRIBUTES') stream = MeshoptEncoder.encodeVertexBufferLevel ? MeshoptEncoder.encodeVertexBufferLevel(source, count, stride, 3, version) : null;
  else stream = MeshoptEncoder.encodeGltfBuffer(source, count, stride, mode);
  const decoded = new Uint8Array(count * stride);
  MeshoptDecoder.decodeGltfBuffer(decoded, count, stride, stream, mode, filter);
  streams.push({ name, mode, filter, count, stride, stream: Buffer.from(stream).toString('base64'), decoded: Buffer.from(decoded).toString('base64') });
  console.log(name, stream.length, stream[0].toString(16), decoded.length);
}
const bytes = (typed) => new Uint8Array(typed.buffer, typed.byteOffset, typed.byteLength);
for (const version of [0, 1]) {
  const v = `v${version}`;
  // 333 elements: two blocks, the last group incomplete.
  const smooth = new Uint16Array(333 * 4).map((_, i) => 20000 + 15000 * Math.sin((i >> 2) / 40 + (i & 3)) + random() * 3);
  add(`smooth shorts ${v}`, 'ATTRIBUTES', 'NONE', 333, 8, bytes(smooth), version);
  const noise = new Uint8Array(100 * 12).map(() => random() * 256);
  add(`noise ${v}`, 'ATTRIBUTES', 'NONE', 100, 12, noise, version);
  const floats = new Float32Array(77 * 3).map((_, i) => Math.fround(Math.cos(i / 9) * (1 + (i % 3))));
  add(`floats ${v}`, 'ATTRIBUTES', 'NONE', 77, 12, bytes(floats), version);
  add(`zeros ${v}`, 'ATTRIBUTES', 'NONE', 400, 4, new Uint8Array(1600), version);
  const wide = new Uint8Array(20 * 256).map((_, i) => (i % 256 < 250 ? (i >> 8) + (i & 15) : random() * 4));
  add(`wide ${v}`, 'ATTRIBUTES', 'NONE', 20, 256, wide, version);
  const sparse = new Uint8Array(48 * 4).map((_, i) => (i % 61 === 0 ? 200 : i & 1));
  add(`sparse steps ${v}`, 'ATTRIBUTES', 'NONE', 48, 4, sparse, version);
  const unit = new Float32Array(40 * 4);
  for (let i = 0; i < 40; i++) { const a = i * 0.7, z = 1 - 2 * (i + 0.5) / 40, r = Math.sqrt(1 - z * z); unit.set([r * Math.cos(a), r * Math.sin(a), z, i & 1 ? 1 : -1], i * 4); }
  for (const [stride, bits] of [[4, 8], [4, 6], [8, 12], [8, 16]]) add(`octahedral ${bits} ${v}`, 'ATTRIBUTES', 'OCTAHEDRAL', 40, stride, MeshoptEncoder.encodeFilterOct(unit, 40, stride, bits), version);
  const rotations = new Float32Array(40 * 4);
  for (let i = 0; i < 40; i++) { const q = [random() - 0.5, random() - 0.5, random() - 0.5, random() - 0.5]; const l = Math.hypot(...q); rotations.set(q.map((c) => c / l), i * 4); }
  for (const bits of [16, 10]) add(`quaternion ${bits} ${v}`, 'ATTRIBUTES', 'QUATERNION', 40, 8, MeshoptEncoder.encodeFilterQuat(rotations, 40, 8, bits), version);
  const values = new Float32Array(40 * 3).map(() => (random() - 0.5) * 10 ** (random() * 12 - 6));
  for (const [bits, kind] of [[23, 'Separate'], [15, 'SharedVector'], [12, 'SharedComponent']]) add(`exponential ${bits} ${v}`, 'ATTRIBUTES', 'EXPONENTIAL', 40, 12, MeshoptEncoder.encodeFilterExp(values, 40, 12, bits, kind), version);
  const colors = new Float32Array(40 * 4).map(() => random());
  for (const [stride, bits] of [[4, 8], [4, 5], [8, 16], [8, 11]]) add(`color ${bits} ${v}`, 'ATTRIBUTES', 'COLOR', 40, stride, MeshoptEncoder.encodeFilterColor(colors, 40, stride, bits), version);
}
// A grid of 12 x 9 cells, in row order.
const grid = [];
for (let y = 0; y < 9; y++) for (let x = 0; x < 12; x++) { const a = y * 13 + x; grid.push(a, a + 1, a + 13, a + 13, a + 1, a + 14); }
const plain = new Uint32Array(grid);
const [remap] = MeshoptEncoder.reorderMesh(plain, true, false);
add('triangles in order', 'TRIANGLES', 'NONE', plain.length, 4, bytes(plain));
const shorts = new Uint16Array(plain);
add('triangles of shorts', 'TRIANGLES', 'NONE', shorts.length, 2, bytes(shorts));
const soup = new Uint32Array(300).map(() => random() * 5000);
add('triangles at random', 'TRIANGLES', 'NONE', 300, 4, bytes(soup));
const restart = new Uint32Array([...plain.slice(0, 60), ...plain.slice(0, 60)]);
add('triangles twice', 'TRIANGLES', 'NONE', 120, 4, bytes(restart));
const strip = new Uint32Array(200).map((_, i) => (i & 1 ? 1000 + i : i));
add('indices of a strip', 'INDICES', 'NONE', 200, 4, bytes(strip));
const short = new Uint16Array(90).map(() => random() * 65000);
add('indices of shorts', 'INDICES', 'NONE', 90, 2, bytes(short));
const root = process.env.RAYFRAME_ROOT ?? new URL('../..', import.meta.url).pathname;
fs.writeFileSync(`${root}/src/gltf/meshopt/streams.json`, JSON.stringify(streams, null, 0).replaceAll('},{', '},\n{') + '\n');

// Encodes the ring of scenes/storage/plain.gltf and its chequer texture with the reference encoders, losslessly.
//
//   npm install meshoptimizer draco3dgltf sharp ktx2-encoder
//   cargo run -p make_scenes && node tests/oracles/storage_streams.mjs
//
// Writes to tests/make_scenes/streams. make_scenes embeds the streams in the other scenes of scenes/storage.
import fs from 'fs';
import { MeshoptEncoder } from 'meshoptimizer';
import draco3d from 'draco3dgltf';
import sharp from 'sharp';
import { encodeToKTX2 } from 'ktx2-encoder';

const root = process.env.RAYFRAME_ROOT ?? new URL('../..', import.meta.url).pathname;
const folder = `${root}/tests/make_scenes/streams`;
const gltf = JSON.parse(fs.readFileSync(`${root}/scenes/storage/plain.gltf`));
const buffer = Buffer.from(gltf.buffers[0].uri.split(',')[1], 'base64');
const primitive = gltf.meshes[gltf.nodes.find((node) => node.name === 'ring').mesh].primitives[0];
const bytesOf = (index) => {
  const view = gltf.bufferViews[gltf.accessors[index].bufferView];
  return new Uint8Array(buffer.subarray(view.byteOffset, view.byteOffset + view.byteLength));
};
const base64 = (bytes) => Buffer.from(bytes).toString('base64');
const { POSITION, NORMAL, TEXCOORD_0 } = primitive.attributes;
const count = gltf.accessors[POSITION].count;
const indices = new Uint16Array(bytesOf(primitive.indices).slice().buffer);

// meshopt
await MeshoptEncoder.ready;
const result = {};
for (const version of [0, 1]) {
  const pack = (accessor, stride) => base64(MeshoptEncoder.encodeVertexBufferLevel(bytesOf(accessor), count, stride, 3, version));
  result[`v${version}`] = {
    positions: pack(POSITION, 12),
    normals: pack(NORMAL, 12),
    uvs: pack(TEXCOORD_0, 8),
    indices: base64(MeshoptEncoder.encodeGltfBuffer(bytesOf(primitive.indices), indices.length, 2, 'TRIANGLES')),
  };
}

// Draco
const encoderModule = await draco3d.createEncoderModule();
const builder = new encoderModule.MeshBuilder();
const mesh = new encoderModule.Mesh();
builder.AddFacesToMesh(mesh, indices.length / 3, new Uint32Array(indices));
const floats = (accessor) => new Float32Array(bytesOf(accessor).slice().buffer);
const positions = builder.AddFloatAttributeToMesh(mesh, encoderModule.POSITION, count, 3, floats(POSITION));
const normals = builder.AddFloatAttributeToMesh(mesh, encoderModule.NORMAL, count, 3, floats(NORMAL));
const uvs = builder.AddFloatAttributeToMesh(mesh, encoderModule.TEX_COORD, count, 2, floats(TEXCOORD_0));
const encoder = new encoderModule.Encoder();
encoder.SetEncodingMethod(encoderModule.MESH_EDGEBREAKER_ENCODING);
const packed = new encoderModule.DracoInt8Array();
const length = encoder.EncodeMeshToDracoBuffer(mesh, packed);
const stream = Buffer.alloc(length);
for (let i = 0; i < length; i++) stream[i] = packed.GetValue(i);
const decoderModule = await draco3d.createDecoderModule();
const decoder = new decoderModule.Decoder();
const decoded = new decoderModule.Mesh();
decoder.DecodeArrayToMesh(stream, length, decoded);
result.draco = { stream: base64(stream), vertices: decoded.num_points(), indices: decoded.num_faces() * 3, positions, normals, uvs };
console.log('draco', length, result.draco.vertices, result.draco.indices, count, indices.length);
fs.writeFileSync(`${folder}/ring.json`, JSON.stringify(result, null, 1) + '\n');

// The chequer has 8 by 4 cells of 4 by 4 texels, in two colours that ETC1S stores exactly.
const width = 32, height = 16, colours = [[233, 200, 125, 255], [59, 92, 142, 255]];
const data = new Uint8Array(width * height * 4);
for (let y = 0; y < height; y++) for (let x = 0; x < width; x++) data.set(colours[((x >> 2) + (y >> 2)) & 1], (y * width + x) * 4);
const raw = { raw: { width, height, channels: 4 } };
fs.writeFileSync(`${folder}/chequer.webp`, await sharp(data, raw).removeAlpha().webp({ lossless: true }).toBuffer());
fs.writeFileSync(`${folder}/lossy.webp`, await sharp(data, raw).removeAlpha().webp({ quality: 90 }).toBuffer());
const png = new Uint8Array(await sharp(data, raw).png().toBuffer());
const imageDecoder = async () => ({ data, width, height });
const encode = async (name, options) =>
  fs.writeFileSync(`${folder}/${name}`, await encodeToKTX2(png, { imageDecoder, generateMipmap: true, isPerceptual: true, isSetKTX2SRGBTransferFunc: true, ...options }));
await encode('chequer_uastc.ktx2', { isUASTC: true, needSupercompression: true });
await encode('chequer_etc1s.ktx2', { isUASTC: false, qualityLevel: 255, compressionLevel: 5 });

// The report, and pictures unpacked when they are looked at.

const report = JSON.parse(byId("data").textContent);

// A shot of which nothing is known has a frame that says so.
for (const shot of report.shots) {
  const nothing = { frame: null, hash: null, expected: null, actual: null, errors: null, left_out: null, comparison: null };
  if (shot.frames.length === 0) shot.frames.push({ name: shot.name, status: "broken", messages: ["has no frames"], ...nothing });
}

/** Pictures that are unpacked, the latest last. */
const unpacked = new Map();
const KEPT = 12;

function kept(key, make) {
  const found = unpacked.get(key) || make();
  unpacked.delete(key);
  unpacked.set(key, found);
  if (unpacked.size > KEPT) unpacked.delete(unpacked.keys().next().value);
  return found;
}

async function inflated(index) {
  if (typeof DecompressionStream === "undefined") {
    throw new Error("This browser cannot unpack the pictures; one of 2023 or later can.");
  }
  const text = atob(byId("picture-" + index).textContent);
  const packed = new Uint8Array(text.length);
  for (let at = 0; at < packed.length; at++) packed[at] = text.charCodeAt(at);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The colours of a picture: three planes of halves. The packing is described in encoded_image.rs. */
function unpackedPicture(picture) {
  return kept("colors " + picture.picture, async () => {
    const { width, height, is_light: isLight } = picture;
    const bytes = await inflated(picture.picture);
    const count = width * height;
    const [g, r, b] = [0, 1, 2].map((plane) => {
      const values = new Uint16Array(count);
      const [high, low] = [plane * count, (plane + 3) * count];
      for (let at = 0; at < count; at++) {
        const before = at === 0 ? 0 : at % width === 0 ? values[at - width] : values[at - 1];
        values[at] = ((bytes[high + at] << 8) | bytes[low + at]) + before;
      }
      return values;
    });
    let isFinite = true;
    for (let at = 0; at < count; at++) {
      r[at] += g[at];
      b[at] += g[at];
      for (const half of [r[at], g[at], b[at]]) if ((half & 0x7c00) === 0x7c00) isFinite = false;
    }
    return { width, height, isLight, isFinite, planes: [r, g, b] };
  });
}

/** FLIP of every pixel, 0 to 255. */
function unpackedErrors(index, width) {
  return kept("errors " + index, async () => {
    const values = await inflated(index);
    for (let at = 1; at < values.length; at++) {
      values[at] += at % width === 0 ? values[at - width] : values[at - 1];
    }
    return values;
  });
}

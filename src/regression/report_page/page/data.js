// The report, and its images, which are unpacked when they are shown.

const report = JSON.parse(byId("data").textContent);

// A shot without frames gets one that says so.
for (const shot of report.shots) {
  const images = { expected: null, actual: null, errors: null, omitted: null };
  const comparison = { identical: false, checks: [], layers: [], root_mean_square: null, flip: null, likely: null };
  const frame = { name: shot.name, frame: null, status: "broken", verdict: "failed", messages: ["has no frames"], hash: null };
  if (shot.frames.length === 0) shot.frames.push({ ...frame, ...images, ...comparison });
}

/** Unpacked images, the latest last. */
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
    throw new Error("This browser cannot unpack the images; one of 2023 or later can.");
  }
  const text = atob(byId("image-" + index).textContent);
  const packed = new Uint8Array(text.length);
  for (let at = 0; at < packed.length; at++) packed[at] = text.charCodeAt(at);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The colours of an image: three planes of halves. encoded_image.rs describes the packing. */
function unpackedImage(image) {
  return kept("colors " + image.index, async () => {
    const { width, height, is_light: isLight } = image;
    const bytes = await inflated(image.index);
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

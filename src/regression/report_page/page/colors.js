// Conversion of halves to display colours, and of errors to colours of the heat map.

/** The value of each half. */
const VALUES = (() => {
  const values = new Float32Array(65536);
  for (let half = 0; half < 65536; half++) {
    const [exponent, fraction] = [(half >> 10) & 31, half & 1023];
    let value = exponent === 0 ? fraction * 2 ** -24 : (1 + fraction / 1024) * 2 ** (exponent - 15);
    if (exponent === 31) value = fraction === 0 ? Infinity : NaN;
    values[half] = half & 0x8000 ? -value : value;
  }
  return values;
})();

const encoded = (light) => (light <= 0.0031308 ? light * 12.92 : 1.055 * light ** (1 / 2.4) - 0.055);
const decoded = (value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);
const byteOf = (light) => (light > 0 ? Math.floor(encoded(Math.min(light, 1)) * 255 + 0.5) : 0);

/** Linear light of each half of an image of display values. */
let displayLight = null;
function lightTable(isLight) {
  if (isLight) return VALUES;
  displayLight = displayLight || VALUES.map((value) => (value > 0 ? decoded(value) : 0));
  return displayLight;
}

/** The display value of each half at an exposure. */
const exposed = { key: "", tables: {} };
function byteTable(isLight, stops) {
  if (exposed.key !== String(stops)) Object.assign(exposed, { key: String(stops), tables: {} });
  if (!exposed.tables[isLight]) {
    const [light, scale] = [lightTable(isLight), 2 ** stops];
    const table = new Uint8ClampedArray(65536);
    for (let half = 0; half < 65536; half++) table[half] = byteOf(light[half] * scale);
    exposed.tables[isLight] = table;
  }
  return exposed.tables[isLight];
}

/** The last canvas image made from a source, remade when `key` changes. */
const images = new WeakMap();
function lastImage(source, key, make) {
  if (images.get(source)?.key !== key) images.set(source, { key, image: make() });
  return images.get(source).image;
}

const shownImage = (source, stops) => lastImage(source, stops, () => exposedImage(source, stops));

/** An image as it is displayed. Pixels that are not finite are magenta. */
function exposedImage(source, stops) {
  const image = new ImageData(source.width, source.height);
  const [table, [r, g, b], data] = [byteTable(source.isLight, stops), source.planes, image.data];
  for (let at = 0, to = 0; at < r.length; at++, to += 4) {
    data[to] = table[r[at]];
    data[to + 1] = table[g[at]];
    data[to + 2] = table[b[at]];
    data[to + 3] = 255;
  }
  if (!source.isFinite) {
    const isBroken = (half) => (half & 0x7c00) === 0x7c00;
    for (let at = 0; at < r.length; at++) {
      if (isBroken(r[at]) || isBroken(g[at]) || isBroken(b[at])) data.set([255, 0, 255, 255], at * 4);
    }
  }
  return image;
}

/** Display values of linear light in 65536 steps, for differences, which are no halves. */
const BYTES = Uint8ClampedArray.from({ length: 65536 }, (_, at) => byteOf(at / 65535));

/** The absolute difference of two images of one size, in linear light. */
function shownDifference(expected, actual, stops) {
  const image = new ImageData(actual.width, actual.height);
  const [ours, theirs, scale] = [lightTable(actual.isLight), lightTable(expected.isLight), 2 ** stops * 65535];
  for (let plane = 0; plane < 3; plane++) {
    const [a, b] = [actual.planes[plane], expected.planes[plane]];
    for (let at = 0, to = plane; at < a.length; at++, to += 4) {
      const apart = Math.abs(ours[a[at]] - theirs[b[at]]) * scale;
      image.data[to] = apart < 65535 ? BYTES[Math.round(apart)] : a[at] === b[at] ? 0 : 255;
    }
  }
  for (let to = 3; to < image.data.length; to += 4) image.data[to] = 255;
  return image;
}

const shownErrors = (errors, width, height) => lastImage(errors, "errors", () => coloredErrors(errors, width, height));

function coloredErrors(errors, width, height) {
  const image = new ImageData(width, height);
  const data = image.data;
  for (let at = 0, to = 0; at < errors.length; at++, to += 4) {
    const color = report.magma[errors[at]];
    data[to] = color[0];
    data[to + 1] = color[1];
    data[to + 2] = color[2];
    data[to + 3] = 255;
  }
  return image;
}

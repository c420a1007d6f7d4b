// Small versions of expected and actual images in the overview, unpacked when they come into view.

/** Height of a thumbnail, CSS pixels. */
const THUMBNAIL_HEIGHT = 54;

const waiting = [];
let isDrawing = false;

const thumbnailObserver = new IntersectionObserver((entries) => {
  for (const { isIntersecting, target } of entries) {
    if (!isIntersecting) continue;
    thumbnailObserver.unobserve(target);
    waiting.push(target);
  }
  drawWaiting();
});

/** Draws one after the other, so that the page stays usable. */
async function drawWaiting() {
  if (isDrawing) return;
  isDrawing = true;
  while (waiting.length > 0) {
    const canvas = waiting.shift();
    try {
      await drawThumbnail(canvas, canvas.thumbnailOf);
    } catch {
      canvas.remove();
    }
  }
  isDrawing = false;
}

async function drawThumbnail(canvas, image) {
  const whole = document.createElement("canvas");
  [whole.width, whole.height] = [image.width, image.height];
  whole.getContext("2d").putImageData(exposedImage(await unpackedImage(image), 0), 0, 0);
  const context = canvas.getContext("2d");
  context.imageSmoothingQuality = "high";
  context.drawImage(whole, 0, 0, canvas.width, canvas.height);
}

/** A canvas for an image of the report. */
function thumbnail(image, title) {
  const width = Math.max(1, Math.min(4 * THUMBNAIL_HEIGHT, Math.round((image.width / image.height) * THUMBNAIL_HEIGHT)));
  const canvas = element("canvas", { className: "thumbnail", title, role: "img", "aria-label": title });
  const scale = window.devicePixelRatio || 1;
  [canvas.width, canvas.height] = [width * scale, THUMBNAIL_HEIGHT * scale];
  canvas.style.width = width + "px";
  canvas.style.height = THUMBNAIL_HEIGHT + "px";
  canvas.thumbnailOf = image;
  thumbnailObserver.observe(canvas);
  return canvas;
}

/** Expected and actual image of a frame, as far as the page has them. */
function thumbnails(frame) {
  const images = [
    [frame?.expected, "expected"],
    [frame?.actual, "actual"],
  ];
  return images.filter(([image]) => image).map(([image, title]) => thumbnail(image, title));
}

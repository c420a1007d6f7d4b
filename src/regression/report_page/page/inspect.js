// Pointer events on images: panning, the slider, and the values under a pixel.

function listen(pane) {
  const { port, canvas } = pane;
  port.addEventListener("scroll", () => {
    for (const other of view.panes) {
      if (other !== pane) other.port.scrollTo(port.scrollLeft, port.scrollTop);
    }
  });
  let drag = null;
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    byId("stage").focus({ preventScroll: true, focusVisible: false });
    inspectAt(pane, event);
    drag = { x: event.clientX, y: event.clientY, left: port.scrollLeft, top: port.scrollTop };
    if (pane.name === "wipe" || event.pointerType === "mouse") canvas.setPointerCapture(event.pointerId);
    if (pane.name === "wipe") wipeTo(pane, event);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (drag && pane.name === "wipe") wipeTo(pane, event);
    else if (drag && event.pointerType === "mouse") {
      port.scrollTo(drag.left + drag.x - event.clientX, drag.top + drag.y - event.clientY);
    } else inspectAt(pane, event);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (drag = null));
}

function wipeTo(pane, event) {
  const box = pane.canvas.getBoundingClientRect();
  setWipe((event.clientX - box.left) / box.width);
}

function inspectAt(pane, event) {
  const box = pane.canvas.getBoundingClientRect();
  inspect(
    Math.floor(((event.clientX - box.left) / box.width) * pane.width),
    Math.floor(((event.clientY - box.top) / box.height) * pane.height),
  );
}

/** Selects the pixel whose values are shown. */
function inspect(x, y) {
  if (view.panes.length === 0) return;
  // Of two sizes the larger can be inspected; the other has no values there.
  const within = (value, side) => Math.min(Math.max(value, 0), Math.max(...view.panes.map((pane) => pane[side])) - 1);
  state.pixel = [within(x, "width"), within(y, "height")];
  cross();
  tell();
}

/** Moves the inspected pixel by keys and scrolls it into view. */
function moveInspected(right, down) {
  const pane = view.panes[0];
  if (!pane) return;
  const [x, y] = state.pixel || [pane.width >> 1, pane.height >> 1];
  inspect(x + right, y + down);
  reveal();
}

function reveal() {
  for (const { port, scale } of view.panes) {
    const [x, y] = state.pixel.map((value) => value * scale);
    if (x < port.scrollLeft + 20 || x > port.scrollLeft + port.clientWidth - 20) port.scrollLeft = x - port.clientWidth / 2;
    if (y < port.scrollTop + 20 || y > port.scrollTop + port.clientHeight - 20) port.scrollTop = y - port.clientHeight / 2;
  }
}

function goTo([x, y]) {
  inspect(x, y);
  reveal();
  byId("viewer").scrollIntoView({ block: "nearest" });
}

/** Rings around the pixel on every pane. */
function cross() {
  for (const { cross: ring, scale, width, height } of view.panes) {
    ring.hidden = !state.pixel || state.pixel[0] >= width || state.pixel[1] >= height;
    if (ring.hidden) continue;
    ring.style.left = (state.pixel[0] + 0.5) * scale + "px";
    ring.style.top = (state.pixel[1] + 0.5) * scale + "px";
  }
}

function valueText(value) {
  if (Number.isNaN(value)) return "NaN";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e4)) return value.toExponential(2);
  return value.toFixed(size < 10 ? 4 : 2);
}

/** The values of the pixel that is inspected. */
function tell() {
  const line = (name, text) => element("span", {}, element("b", {}, name + " "), text);
  if (!state.pixel) {
    byId("inspector").replaceChildren(element("span", {}, element("b", {}, "Point at a pixel, or press i, to read its values.")));
    return;
  }
  const [x, y] = state.pixel;
  const values = (image) => {
    if (!image || x >= image.width || y >= image.height) return null;
    return image.planes.map((plane) => VALUES[plane[y * image.width + x]]);
  };
  const text = (list) => list.map((value) => valueText(value).padStart(9)).join("").slice(1);
  const [expected, actual] = [values(view.expected), values(view.actual)];
  const parts = [line("column", `${x}  `), line("expected", expected ? text(expected) : "none"), line("actual  ", actual ? text(actual) : "none")];
  parts[0].append(element("b", {}, "row "), String(y));
  if (expected && actual && view.expected.isLight === view.actual.isLight) {
    parts.push(line("actual − expected", text(actual.map((value, plane) => value - expected[plane]))));
  }
  if (view.errors && canShow("heat")) parts.push(line("FLIP", (view.errors[y * view.actual.width + x] / 255).toFixed(3)));
  byId("inspector").replaceChildren(...parts);
}

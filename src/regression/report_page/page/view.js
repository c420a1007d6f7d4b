// The image panes: what they show, at what size.

const MODES = [
  ["side", "Side by side", "1"],
  ["wipe", "Slider", "2"],
  ["flicker", "Flicker", "3"],
  ["heat", "Heat map", "4"],
  ["difference", "Difference", "5"],
];
const ZOOMS = [0, 1, 2, 4, 8];

/** The unpacked images of the shown frame, and its panes. */
const view = { expected: null, actual: null, errors: null, panes: [], loaded: null, ticket: 0 };

function canShow(mode) {
  const isPair = view.expected && view.actual;
  const isSame = isPair && view.expected.width === view.actual.width && view.expected.height === view.actual.height;
  if (mode === "heat") return Boolean(view.errors && isSame);
  if (mode === "difference") return Boolean(isSame);
  return mode === "side" || Boolean(isPair);
}
const shownMode = () => (canShow(state.mode) ? state.mode : "side");

/** Unpacks the images of a frame and shows them. */
async function load(frame) {
  const ticket = ++view.ticket;
  const size = frame.actual || frame.expected;
  const parts = [
    frame.expected && unpackedImage(frame.expected),
    frame.actual && unpackedImage(frame.actual),
    frame.errors !== null && size && unpackedErrors(frame.errors, size.width),
  ];
  let [expected, actual, errors, problem] = [null, null, null, ""];
  try {
    [expected, actual, errors] = await Promise.all(parts);
  } catch (error) {
    problem = error.message;
  }
  if (ticket !== view.ticket) return;
  Object.assign(view, { expected, actual, errors, loaded: frame });
  byId("viewer").hidden = !expected && !actual;
  byId("no-images").hidden = Boolean(expected || actual);
  byId("no-images").replaceChildren(...missingImages(frame, problem));
  arrange();
}

function missingImages(frame, problem) {
  if (problem) return [problem];
  if (frame.omitted) {
    const { why, command } = frame.omitted;
    const limit = `${report.budget_mebibytes} MiB that a page holds`;
    const isTooLarge = why === "too_large";
    const reason = isTooLarge ? `they alone exceed the ${limit}` : `those of other frames come first and leave too little of the ${limit}`;
    const text = `The images of this frame are omitted: ${reason}. `;
    if (command) return [text + (isTooLarge ? "The heat map as an image file has no such limit:" : "A page of this frame alone shows them:"), commandBox(command)];
    const leavesMore = !isTooLarge && report.can_approve && report.shots.length > 1 && frame.status !== "orphaned";
    return [text + (leavesMore ? "A test of this shot alone leaves more of it; the worst frames come first." : "")];
  }
  if (!differs(frame)) return ["This frame is identical to its reference" + (report.can_approve ? "; rayframe test --report-passing shows such images." : ". Its images are not shown.")];
  if (frame.status === "broken") return ["There is no image."];
  return ["There are no colours to show."];
}

/** Builds the panes of the mode. */
function arrange() {
  const mode = shownMode();
  const names =
    mode === "side" ? ["expected", "actual"].filter((name) => view[name]) : [mode];
  view.panes = names.map(makePane);
  const stage = byId("stage");
  stage.replaceChildren(...view.panes.map((pane) => pane.root));
  stage.classList.toggle("two", names.length === 2);
  stage.classList.toggle("wiping", mode === "wipe");
  showModes(mode);
  fit();
  paint();
  beat();
}

function makePane(name) {
  const sizes = [view.expected, view.actual].filter((image) => image && (!view[name] || image === view[name]));
  const [width, height] = ["width", "height"].map((side) => Math.max(...sizes.map((image) => image[side])));
  const canvas = element("canvas", { width, height, role: "img" });
  const sheet = element("div", { className: "sheet" }, canvas);
  const port = element("div", { className: "port", tabIndex: -1 }, sheet);
  const [label, note] = [element("strong"), element("span")];
  const root = element("figure", { className: "pane" }, element("figcaption", { className: "pane-label" }, label, note), port);
  root.style.margin = "0";
  const pane = { name, canvas, sheet, port, label, note, root, width, height };
  if (name === "wipe") pane.line = sheet.appendChild(element("div", { className: "wipe-line" }));
  pane.cross = sheet.appendChild(element("div", { className: "cross", hidden: true }));
  listen(pane);
  return pane;
}

/** Sizes of sheets and of the windows that they scroll in. */
function fit() {
  const tallest = innerWidth > 820 ? Math.min(innerHeight * 0.58, 720) : innerHeight * 0.62;
  const around = innerWidth > 820 ? 20 : 0;
  for (const pane of view.panes) {
    const { width, height, port, sheet } = pane;
    pane.scale = state.zoom || Math.max(0.01, Math.min((port.clientWidth - around) / width, (tallest - around) / height, 16));
    sheet.style.width = width * pane.scale + "px";
    sheet.style.height = height * pane.scale + "px";
    sheet.classList.toggle("pixels", pane.scale >= 1);
    port.style.height = Math.max(120, Math.min(tallest, height * pane.scale + around)) + (state.zoom ? 14 : 0) + "px";
    mark(pane);
  }
  cross();
}

const TITLES = { expected: "expected", actual: "actual", heat: "FLIP, what an eye sees", difference: "difference" };

function paint() {
  for (const pane of view.panes.filter(({ isDark }) => !isDark)) {
    try {
      paintPane(pane);
      pane.holds = pane.holds || holdsPixels(pane);
    } catch (error) {
      pane.holds = false;
      console.warn(error);
    }
    if (!pane.holds) darken(pane);
  }
  tell();
}

/** Whether the canvas holds pixels. Beyond a browser's limit it stays empty without an error. Images are opaque. */
const holdsPixels = ({ canvas }) => canvas.getContext("2d").getImageData(0, 0, 1, 1).data[3] === 255;

/** Replaces a pane that cannot be shown by a message. */
function darken(pane) {
  pane.isDark = true;
  pane.label.textContent = TITLES[pane.name] || pane.name;
  const count = `${pane.width} by ${pane.height} pixels`;
  const why = pane.width * pane.height === 0 ? "The image is empty" : `This browser cannot show an image of ${count}; one of a desktop computer may, or a crop of the image`;
  pane.port.replaceChildren(element("p", { className: "note" }, why + "."));
}

function paintPane(pane) {
  const context = pane.canvas.getContext("2d", { willReadFrequently: true });
  const show = (image) => context.putImageData(shownImage(image, state.stops), 0, 0);
  context.clearRect(0, 0, pane.width, pane.height);
  pane.label.textContent = TITLES[pane.name] || "";
  pane.note.textContent = "";
  if (pane.name === "wipe") {
    const column = Math.round(state.wipe * pane.width);
    show(view.expected);
    const image = shownImage(view.actual, state.stops);
    context.clearRect(column, 0, pane.width - column, pane.height);
    context.putImageData(image, 0, 0, column, 0, Math.max(0, image.width - column), image.height);
    pane.line.style.left = (column / pane.width) * 100 + "%";
    pane.label.textContent = "◂ expected";
    pane.note.append(element("strong", {}, "actual ▸"));
  } else if (pane.name === "flicker") {
    show(view[state.flicker.shows]);
    pane.label.textContent = state.flicker.shows;
  } else if (pane.name === "heat") {
    context.putImageData(shownErrors(view.errors, pane.width, pane.height), 0, 0);
  } else if (pane.name === "difference") {
    context.putImageData(shownDifference(view.expected, view.actual, state.stops + state.gain), 0, 0);
    pane.note.textContent = `linear light × ${2 ** state.gain}`;
  } else {
    show(view[pane.name]);
    if (view.panes.length === 1) pane.note.textContent = pane.name === "actual" ? "no reference" : "no render";
  }
  const shown = pane.name === "flicker" ? state.flicker.shows : TITLES[pane.name] || "expected, then actual";
  pane.canvas.setAttribute("aria-label", `${shown}, ${pane.width} by ${pane.height} pixels`);
}

/** Draws boxes around the worst locations on a pane. */
function mark(pane) {
  pane.sheet.querySelectorAll(".mark").forEach((old) => old.remove());
  if (!state.marker) return;
  for (const { x, y, side, title } of worstLocations()) {
    const size = Math.max(side * pane.scale, 16);
    const box = element("div", { className: "mark", title });
    box.style.width = box.style.height = size + "px";
    box.style.left = (x + side / 2) * pane.scale - size / 2 + "px";
    box.style.top = (y + side / 2) * pane.scale - size / 2 + "px";
    pane.sheet.append(box);
  }
}

function worstLocations() {
  if (!view.loaded || view.loaded.identical) return [];
  const { flip, checks } = view.loaded;
  const locations = flip && flip.tile > 0 ? [{ x: flip.tile_at[0], y: flip.tile_at[1], side: 8, title: "worst tile" }] : [];
  const isTile = (at) => locations.length > 0 && at[0] === locations[0].x && at[1] === locations[0].y;
  for (const check of checks) {
    if (!check.passes && check.at && !isTile(check.at)) {
      locations.push({ x: check.at[0], y: check.at[1], side: 1, title: check.measure });
    }
  }
  return locations;
}

/** Alternates the images while flicker runs. */
let beating = 0;
function beat() {
  clearTimeout(beating);
  if (shownMode() !== "flicker" || !state.flicker.runs || state.shot < 0 || !view.loaded) return;
  beating = setTimeout(() => {
    swap();
    beat();
  }, 1000 / state.flicker.rate);
}

function swap() {
  state.flicker.shows = state.flicker.shows === "expected" ? "actual" : "expected";
  if (shownMode() === "flicker") paint();
}

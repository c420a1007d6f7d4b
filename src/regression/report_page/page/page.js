// Navigation, settings and start of the page.

/** Shows a frame of a shot, or the overview. */
function go(shot, frame) {
  const isNew = shot !== state.shot;
  Object.assign(state, { shot, frame });
  if (isNew) state.pixel = null;
  const name = shot < 0 ? "" : "#" + encodeURIComponent(shownFrame().name);
  if (location.hash !== name && (name || location.hash)) {
    try {
      history.replaceState(null, "", name || "#");
    } catch {
      // A page in a frame may not.
    }
  }
  byId("overview").hidden = shot >= 0;
  byId("failure").hidden = shot < 0;
  if (shot >= 0) {
    if (isNew) byId("graph").replaceChildren();
    showDetails();
    showGraph();
    load(shownFrame());
    if (isNew) say(`${shownFrame().name}, ${kindOf(shownFrame())}`);
  } else beat();
  showApprovals();
  if (isNew) {
    showList();
    byId("shots").querySelector("[aria-current=true]")?.scrollIntoView({ block: "nearest" });
  }
}

function goByHash() {
  let name = "";
  try {
    name = decodeURIComponent(location.hash.slice(1));
  } catch {
    // It was typed by hand.
  }
  const shot = report.shots.findIndex((one) => one.frames.some((frame) => frame.name === name));
  if (shot < 0) return go(-1, 0);
  go(shot, report.shots[shot].frames.findIndex((frame) => frame.name === name));
}

/** Goes to the next or the previous failure of the list. */
function step(direction) {
  const indices = listed();
  const at = indices.indexOf(state.shot);
  const next = at < 0 ? (direction > 0 ? 0 : indices.length - 1) : at + direction;
  if (next >= 0 && next < indices.length) go(indices[next], worstFrame(report.shots[indices[next]]));
}

function stepFrame(direction, onlyDiffering) {
  const frames = shownShot()?.frames || [];
  for (let at = state.frame + direction; at >= 0 && at < frames.length; at += direction) {
    if (!onlyDiffering || differs(frames[at])) return go(state.shot, at);
  }
}

function setMode(mode, isQuiet) {
  if (!canShow(mode)) return;
  state.mode = mode;
  if (mode === "flicker" && !isQuiet && !calm.matches) state.flicker.runs = true;
  if (state.shot >= 0) arrange();
}

function setFlicker(runs) {
  state.flicker.runs = runs;
  showModeTools(shownMode());
  beat();
}

function toggleFlicker() {
  const runs = !(state.flicker.runs && shownMode() === "flicker");
  setMode("flicker", true);
  setFlicker(runs);
}

function setWipe(share) {
  state.wipe = Math.min(1, Math.max(0, share));
  if (shownMode() !== "wipe") return;
  const range = byId("wipe");
  if (range) range.value = Math.round(state.wipe * 1000);
  paint();
}

function setStops(stops) {
  state.stops = Math.min(10, Math.max(-10, stops));
  byId("stops").value = state.stops;
  const text = `${state.stops > 0 ? "+" : state.stops < 0 ? "−" : ""}${Math.abs(state.stops).toFixed(2)} stops`;
  byId("stops-text").textContent = text;
  byId("stops").setAttribute("aria-valuetext", text);
  byId("stops-reset").disabled = state.stops === 0;
  paint();
}

function setZoom(zoom) {
  state.zoom = zoom;
  fit();
  showZooms();
  if (state.pixel) reveal();
}

function setMarker(on) {
  state.marker = on;
  byId("marker-toggle").setAttribute("aria-pressed", String(on));
  view.panes.forEach(mark);
}

function setFilter(text) {
  state.filter = text;
  byId("filter").value = text;
  showList();
  if (state.shot >= 0) showDetails();
}

const THEMES = ["auto", "light", "dark"];
function setTheme(theme) {
  if (theme === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
  byId("theme").textContent = "Theme: " + theme;
  byId("theme").setAttribute("aria-label", "Theme: " + theme);
  memory.write("theme", theme);
}
const nextTheme = () => setTheme(THEMES[(THEMES.indexOf(byId("theme").textContent.slice(7)) + 1) % THEMES.length]);

function connect() {
  const on = (id, kind, act) => byId(id).addEventListener(kind, act);
  on("previous", "click", () => step(-1));
  on("next", "click", () => step(1));
  on("stops", "input", () => setStops(Number(byId("stops").value)));
  on("stops-reset", "click", () => setStops(0));
  on("marker-toggle", "click", () => setMarker(!state.marker));
  on("filter", "input", () => setFilter(byId("filter").value));
  on("home", "click", () => go(-1, 0));
  on("to-overview", "click", () => (go(-1, 0), openList(false)));
  on("list-toggle", "click", () => openList(!byId("list").classList.contains("open")));
  on("theme", "click", nextTheme);
  on("help-open", "click", () => byId("help").showModal());
  on("keys-on", "change", () => memory.write("keys", (keysAreOn = byId("keys-on").checked)));
  on("approve-frame", "change", () => approve([shownFrame()], byId("approve-frame").checked));
  on("approve-shot", "change", () => approve(shownShot().frames, byId("approve-shot").checked));
  on("approve-shown", "click", () => approve(listed().flatMap((index) => selectedApprovable(report.shots[index])), true));
  on("export", "click", exportApprovals);
  document.addEventListener("keydown", onKey);
  addEventListener("hashchange", goByHash);
  addEventListener("resize", () => {
    if (state.shot < 0) return;
    showGraph();
    fit();
  });
}

function begin() {
  byId("app").hidden = false;
  byId("title").textContent = report.title || "report";
  byId("hint").hidden = report.shots.length === 0;
  byId("counts").replaceChildren(
    element("span", { className: total("failed") > 0 ? "bad" : "quiet" }, `${total("failed")} failed`),
    element("span", { className: total("changed") > 0 ? "warn" : "quiet" }, `${total("changed")} changed`),
    element("span", { className: "good" }, `${total("identical")} identical`),
  );
  byId("accept-command").replaceChildren(commandBox(report.accept_command, "accept"));
  byId("keys-on").checked = keysAreOn;
  setTheme(THEMES.includes(memory.read("theme")) ? memory.read("theme") : "auto");
  // A single shot without approvals needs no list.
  const isAlone = report.shots.length < 2 && !report.can_approve && !report.asset;
  document.body.classList.toggle("alone", isAlone);
  byId("home").hidden = !isAlone || report.shots.length === 0;
  recallApprovals();
  connect();
  showKinds();
  showKeys();
  showZooms();
  setStops(0);
  showOverview();
  showList();
  // A page of one shot shows it at once.
  if (!location.hash && report.shots.length === 1 && !report.asset) go(0, worstFrame(report.shots[0]));
  else goByHash();
}

begin();

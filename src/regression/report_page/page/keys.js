// Keyboard shortcuts, and the table that lists them.

const KEYS = [
  { keys: ["j", "n"], does: "next failure", act: () => step(1) },
  { keys: ["k", "p"], does: "previous failure", act: () => step(-1) },
  { keys: ["ArrowRight"], shown: "→", does: "next frame", act: () => stepFrame(1, false) },
  { keys: ["ArrowLeft"], shown: "←", does: "previous frame", act: () => stepFrame(-1, false) },
  { keys: ["Shift+ArrowRight"], shown: "Shift →", does: "next frame that differs", act: () => stepFrame(1, true) },
  { keys: ["Shift+ArrowLeft"], shown: "Shift ←", does: "previous frame that differs", act: () => stepFrame(-1, true) },
  { keys: ["g"], does: "overview", act: () => go(-1, 0) },
  { keys: ["/"], does: "filter the list", act: () => (openList(true), byId("filter").focus()) },
  ...MODES.map(([mode, name, key]) => ({ keys: [key], does: name.toLowerCase(), act: () => setMode(mode) })),
  { keys: [" "], shown: "Space", does: "swap expected and actual", act: () => (setMode("flicker", true), setFlicker(false), swap()) },
  { keys: ["f"], does: "flicker on and off", act: () => toggleFlicker() },
  { keys: ["<", ","], shown: ",", does: "slider to the left", act: () => setWipe(state.wipe - 0.02) },
  { keys: [">", "."], shown: ".", does: "slider to the right", act: () => setWipe(state.wipe + 0.02) },
  { keys: ["+", "="], shown: "+", does: "exposure one stop up", act: () => setStops(state.stops + 1) },
  { keys: ["-"], shown: "−", does: "exposure one stop down", act: () => setStops(state.stops - 1) },
  { keys: ["0"], does: "exposure as rendered", act: () => setStops(0) },
  { keys: ["z"], does: "zoom: fit, 1, 2, 4, 8", act: () => setZoom(ZOOMS[(ZOOMS.indexOf(state.zoom) + 1) % ZOOMS.length]) },
  { keys: ["m"], does: "mark the worst location", act: () => setMarker(!state.marker) },
  { keys: ["i"], does: "inspect the worst location; arrow keys move on, with Shift by ten", act: () => inspectWorst() },
  { keys: ["a"], approves: true, does: "approve the image, or not", act: () => toggleApproval([shownFrame()]) },
  { keys: ["A"], approves: true, does: "approve the shot, or not", act: () => toggleApproval(shownShot()?.frames) },
  { keys: ["x"], approves: true, does: "export approvals", act: () => exportApprovals() },
  { keys: ["t"], does: "theme: automatic, light, dark", act: () => nextTheme() },
  { keys: ["?"], does: "this table", act: () => byId("help").showModal() },
];
const usedKeys = () => KEYS.filter((entry) => report.can_approve || !entry.approves);
let keysAreOn = memory.read("keys") !== false;

function toggleApproval(frames) {
  const possible = (frames || []).filter((frame) => frame && canApprove(frame));
  if (possible.length > 0) approve(possible, !possible.every(isApproved));
}

function inspectWorst() {
  const [worst] = worstLocations();
  byId("stage").focus();
  if (worst) goTo([worst.x + (worst.side >> 1), worst.y + (worst.side >> 1)]);
  else moveInspected(0, 0);
}

/** Whether the element that has the focus needs this key itself. */
function isTaken(target, key) {
  if (target.matches("input[type=search], textarea, select")) return true;
  const isArrow = key.includes("Arrow");
  if (target.matches("input[type=range]")) return isArrow;
  if (target.matches("button, input, a, summary")) return key === " " || key === "Enter";
  return isArrow && target.matches("pre, .scroll");
}

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || byId("help").open) return;
  if (event.target.id === "filter" && event.key === "Escape") {
    setFilter("");
    byId("main").focus();
    return;
  }
  if (isTaken(event.target, event.key)) return;
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  if (event.target.id === "stage" && arrows[event.key]) {
    const [right, down] = arrows[event.key].map((one) => one * (event.shiftKey ? 10 : 1));
    moveInspected(right, down);
    return event.preventDefault();
  }
  const name = (event.shiftKey && event.key.startsWith("Arrow") ? "Shift+" : "") + event.key;
  const entry = usedKeys().find(({ keys }) => keys.includes(name));
  if (!entry || (!keysAreOn && name.length === 1 && name !== "?")) return;
  event.preventDefault();
  entry.act();
}

function showKeys() {
  const name = (entry) => element("span", {}, element("kbd", {}, entry.shown || entry.keys[0]));
  byId("help-keys").replaceChildren(...usedKeys().map((entry) => element("div", {}, name(entry), element("span", {}, entry.does))));
  const short = [["j", "k", "failure"], ["←", "→", "frame"], ["1", "5", "view", "–"], ["+", "−", "exposure"], ["f", "flicker"], ["i", "inspect"], ...(report.can_approve ? [["a", "approve"]] : []), ["?", "all keys"]];
  const hints = short.map((parts) => {
    const keys = parts.filter((part) => part.length === 1 && part !== "–").map((key) => element("kbd", {}, key));
    return element("span", {}, ...keys.flatMap((key, at) => (at > 0 ? [parts[3] === "–" ? "–" : " ", key] : [key])), " " + parts.find((part) => part.length > 1));
  });
  byId("hint").replaceChildren(...hints);
}

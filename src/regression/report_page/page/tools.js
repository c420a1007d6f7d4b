// The controls above the images, which depend on the mode.

/** Buttons of which one is pressed. */
function segment(name, isPressed, isPossible, title, act) {
  const button = element("button", { type: "button", title, disabled: !isPossible, "aria-pressed": String(isPressed) }, name);
  button.addEventListener("click", act);
  return button;
}

/** Replaces buttons and keeps the focus on the one of that name. */
function renew(holder, buttons) {
  const focused = holder.contains(document.activeElement) ? document.activeElement.textContent : null;
  holder.replaceChildren(...buttons);
  buttons.find((button) => button.textContent === focused)?.focus();
}

function showModes(shown) {
  renew(
    byId("modes"),
    MODES.map(([mode, name, key]) => segment(name, mode === shown, canShow(mode), `${name} (${key})`, () => setMode(mode))),
  );
  showModeTools(shown);
}

function showZooms() {
  renew(
    byId("zooms"),
    ZOOMS.map((zoom) => segment(zoom ? zoom + "×" : "Fit", zoom === state.zoom, true, "Zoom (z)", () => setZoom(zoom))),
  );
}

function range(id, name, [min, max, by], value, act, title) {
  const input = element("input", { type: "range", id, min, max, step: by, value, title: title || "" });
  const output = element("output", { htmlFor: id });
  const change = () => (output.textContent = act(Number(input.value)));
  input.addEventListener("input", change);
  change();
  return [element("label", { htmlFor: id }, name), input, output];
}

/** The controls of a mode: slider, rate, gain or legend. */
function showModeTools(mode) {
  const holder = byId("mode-tools");
  if (holder.dataset.mode === mode && (mode === "wipe" || mode === "difference")) return;
  holder.dataset.mode = mode;
  const parts = {
    side: () => [element("span", { className: "quiet" }, view.expected && view.actual ? "Both scroll together; drag to pan." : view.actual ? "There is no reference." : "Nothing was rendered for this reference.")],
    wipe: () =>
      range("wipe", "Slider", [0, 1000, 5], Math.round(state.wipe * 1000), (value) => {
        if (Math.round(state.wipe * 1000) !== value) setWipe(value / 1000);
        return "";
      }),
    flicker: () => [
      segment(state.flicker.runs ? "Stop" : "Start", false, true, "Flicker on and off (f)", () => setFlicker(!state.flicker.runs)),
      segment("Swap", false, true, "Swap expected and actual (Space)", () => (setFlicker(false), swap())),
      ...range("rate", "Rate", [0.5, FASTEST_SWAPS, 0.5], state.flicker.rate, (value) => {
        state.flicker.rate = value;
        beat();
        return `${value.toFixed(1)} a second`;
      }, `Swaps a second; at most ${FASTEST_SWAPS}, for faster flashes can harm people`),
    ],
    heat: () => [legend()],
    difference: () =>
      range("gain", "Amplified", [0, 10, 1], state.gain, (value) => {
        const isNew = state.gain !== value;
        state.gain = value;
        if (isNew) paint();
        return `× ${2 ** value}`;
      }),
  }[mode]();
  renew(holder, parts);
}

/** The colours of errors from 0 to 1, with the limit of the worst tile. */
function legend() {
  const canvas = element("canvas", { width: 256, height: 1, role: "img", "aria-label": "Colours of FLIP from 0 to 1" });
  canvas.getContext("2d").putImageData(shownErrors(Uint8Array.from({ length: 256 }, (_, at) => at), 256, 1), 0, 0);
  const tick = (at, text) => {
    const label = element("span", {}, text);
    label.style.left = at * 100 + "%";
    return label;
  };
  const limit = shownShot().limits.tile_flip;
  const ticks = [tick(0, limit > 0.08 ? "0" : "0 as expected"), tick(1, "1")];
  if (limit > 0.03 && limit < 0.75) {
    ticks.splice(1, 0, tick(limit, `▴ limit of the worst tile ${limit}`));
    ticks[1].className = "limit-at";
  }
  return element("div", { className: "legend" }, canvas, element("div", { className: "legend-ticks" }, ...ticks));
}

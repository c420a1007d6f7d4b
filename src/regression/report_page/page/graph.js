// A graph of the errors of a sequence by frame, with their limits.

const PLOTS = [
  { name: "mean FLIP", value: "mean", limit: "mean_flip" },
  { name: "worst tile", value: "tile", limit: "tile_flip" },
];
const [LEFT, RIGHT, PLOT_HEIGHT, PLOT_STEP] = [52, 8, 56, 66];

function showGraph() {
  const holder = byId("graph");
  const shot = shownShot();
  if (!shot || shot.frames.length < 2) return holder.replaceChildren();
  const frame = shownFrame();
  const box = holder.firstElementChild || makeGraph(holder);
  const flip = frame.flip;
  const numbers = flip ? `: mean FLIP ${flip.mean.toFixed(4)}, worst tile ${flip.tile.toFixed(4)}` : "";
  box.querySelector(".graph-shown").textContent = frameLabel(frame) + numbers;
  const count = shot.frames.filter(fails).length;
  const changed = differing(shot).length - count;
  box.querySelector(".graph-count").textContent = `${count} of ${plural(shot.frames.length, "frame")} failed${changed > 0 ? `, ${changed} changed` : ""}`;
  const slider = box.querySelector("[role=slider]");
  slider.setAttribute("aria-valuemax", shot.frames.length);
  slider.setAttribute("aria-valuenow", state.frame + 1);
  slider.setAttribute("aria-valuetext", `${frameLabel(frame)}, ${kindOf(frame)}${numbers}`);
  slider.replaceChildren(graphImage(shot, Math.max(240, slider.clientWidth)));
}

function makeGraph(holder) {
  const slider = element("div", { role: "slider", tabIndex: 0, "aria-label": "Frame", "aria-valuemin": 1 });
  const head = element(
    "div",
    { className: "graph-head" },
    element("span", { className: "graph-shown numbers" }),
    element("span", { className: "graph-count quiet" }),
  );
  const box = element("div", { className: "graph" }, head, slider);
  holder.replaceChildren(box);
  const choose = (event) => {
    const width = slider.clientWidth - LEFT - RIGHT;
    const share = (event.clientX - slider.getBoundingClientRect().left - LEFT) / width;
    const count = shownShot().frames.length;
    go(state.shot, Math.min(count - 1, Math.max(0, Math.floor(share * count))));
  };
  slider.addEventListener("click", choose);
  slider.addEventListener("pointermove", (event) => {
    if (event.buttons === 1 && event.pointerType === "mouse") choose(event);
  });
  return box;
}

function graphImage(shot, width) {
  const step = (width - LEFT - RIGHT) / shot.frames.length;
  const x = (index) => LEFT + (index + 0.5) * step;
  const bottom = PLOT_STEP + PLOT_HEIGHT + 4;
  const root = vector("svg", { viewBox: `0 0 ${width} 148`, preserveAspectRatio: "none", "aria-hidden": "true" });
  const band = Math.min(Math.max(step, 3), 14);
  root.append(vector("rect", { class: "chosen", x: x(state.frame) - band / 2, y: 2, width: band, height: bottom }));
  PLOTS.forEach((plot, row) => root.append(...plotted(shot, plot, { x, top: 4 + row * PLOT_STEP, step, width })));
  const label = (index, anchor) => {
    const { frame } = shot.frames[index];
    return vector("text", { x: x(index), y: bottom + 16, "text-anchor": anchor }, String(frame ?? index + 1));
  };
  const last = shot.frames.length - 1;
  if (x(state.frame) - LEFT > 60) root.append(label(0, "middle"));
  if (width - x(state.frame) > 60) root.append(label(last, "middle"));
  const chosen = label(state.frame, "middle");
  chosen.setAttribute("font-weight", "700");
  root.append(chosen);
  return root;
}

/** One curve over its axis. */
function plotted(shot, plot, { x, top, step, width }) {
  const values = shot.frames.map((frame) => frame.flip?.[plot.value] ?? null);
  const limit = shot.limits[plot.limit];
  const highest = Math.max(...values, limit ?? 0) * 1.1 || 1;
  const y = (value) => top + PLOT_HEIGHT * (1 - value / highest);
  const base = top + PLOT_HEIGHT;
  const parts = [
    vector("line", { class: "axis", x1: LEFT, x2: width - RIGHT, y1: base, y2: base }),
    vector("text", { x: 0, y: top + 10 }, plot.name.split(" ")[0]),
    vector("text", { x: 0, y: top + 23 }, plot.name.split(" ")[1]),
  ];
  if (limit !== null) {
    parts.push(vector("line", { class: "limit", x1: LEFT, x2: width - RIGHT, y1: y(limit), y2: y(limit) }));
    parts.push(vector("text", { class: "limit-text", x: 0, y: top + 38 }, "≤ " + limit));
  }
  let path = "";
  values.forEach((value, index) => {
    if (value !== null) path += (path === "" || values[index - 1] === null ? "M" : "L") + x(index) + " " + y(value);
  });
  parts.push(vector("path", { class: "curve", d: path }));
  shot.frames.forEach((frame, index) => {
    const value = values[index];
    if (value === null) {
      const size = 3.5;
      parts.push(vector("path", { class: "absent", d: `M${x(index) - size} ${base - 2 * size}l${2 * size} ${2 * size}m0 ${-2 * size}l${-2 * size} ${2 * size}` }));
    } else if (differs(frame) || step > 5) {
      parts.push(vector("circle", { class: `point ${fails(frame) ? "fails" : frame.verdict}`, cx: x(index), cy: y(value), r: fails(frame) ? 3.5 : 2 }));
    }
  });
  return parts;
}

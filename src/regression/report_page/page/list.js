// The list of failures and changes with its filter, and the overview.

/** The verdicts of shots, worst first, with their titles. */
const VERDICTS = [
  ["failed", "Failed"],
  ["changed", "Changed within limits"],
  ["identical", "Identical"],
];
const KINDS = ["different", "missing", "orphaned", "broken", "changed"];

/** The kinds of a shot's frames that are not identical. */
const kindsOf = (shot) => new Set(differing(shot).map(kindOf));

const kindText = (shot) => [...kindsOf(shot)].join(", ") || "identical";

/** Whether texts hold all words of the filter. */
function hasFilteredWords(...texts) {
  const text = texts.join("\n").toLowerCase();
  return state.filter.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

/** The frames of a shot that are not identical and that the filters select. */
function selected(shot) {
  const isKind = (frame) => state.kinds.size === 0 || state.kinds.has(kindOf(frame));
  return differing(shot).filter((frame) => isKind(frame) && hasFilteredWords(shot.name, frame.name, ...frame.messages, frame.likely || ""));
}

/** Whether the filters select frames of a shot, or its name. */
const isListed = (shot) => selected(shot).length > 0 || (state.kinds.size === 0 && hasFilteredWords(shot.name));

/** What a tick in the list approves: the frames that can be approved and that the filters select. */
const selectedApprovable = (shot) => selected(shot).filter(canApprove);
const listed = () => report.shots.map((_, index) => index).filter((index) => isListed(report.shots[index]));

/** A name with its folders in grey. */
function nameParts(name) {
  const cut = name.lastIndexOf("/") + 1;
  return [element("span", { className: "folder" }, name.slice(0, cut)), name.slice(cut)];
}

function showList() {
  const indices = listed();
  const sections = VERDICTS.flatMap(([verdict, title]) => {
    const items = indices.filter((index) => verdictOf(report.shots[index]) === verdict);
    return items.length > 0 ? [element("li", { className: "section quiet" }, title), ...items.map(listItem)] : [];
  });
  const onlyFailures = report.shots.every((shot) => verdictOf(shot) === "failed");
  byId("shots").replaceChildren(...(onlyFailures ? indices.map(listItem) : sections));
  byId("to-overview").setAttribute("aria-current", String(state.shot < 0));
  byId("shots-none").hidden = indices.length > 0 || report.shots.length === 0;
}

function listItem(index) {
  const shot = report.shots[index];
  const frames = differing(shot);
  const worst = frames.find(fails) || frames[0];
  const kind = worst ? kindOf(worst) : "identical";
  const [all, shown] = [approvable(shot), selectedApprovable(shot)];
  const isDone = all.length > 0 && all.every(isApproved);
  const count = shot.frames.length > 1 ? `${frames.length}/${shot.frames.length}` : "";
  const button = element(
    "button",
    { type: "button", "aria-current": String(index === state.shot), title: `${shot.name}: ${kindText(shot)}${isDone ? ", approved" : ""}` },
    element("span", { className: `dot ${isDone ? "approved" : kind}` }),
    element("span", { className: "name" }, ...nameParts(shot.name), element("span", { className: "unseen" }, `, ${kind}${isDone ? ", approved" : ""}`)),
    element("span", { className: "quiet numbers" }, count),
  );
  button.addEventListener("click", () => {
    go(index, worstFrame(shot));
    openList(false);
  });
  const item = element("li", { className: index === state.shot ? "current" : "" });
  if (report.can_approve) {
    const box = element("input", { type: "checkbox", "aria-label": "Approve " + shot.name });
    showTick(box, shown);
    box.addEventListener("change", () => {
      approve(shown, box.checked);
      byId("shots").querySelector(`[aria-label="${CSS.escape("Approve " + shot.name)}"]`)?.focus();
    });
    item.append(element("span", { className: "tick" }, box));
  }
  item.append(button);
  return item;
}

function showKinds() {
  const count = (kind) => report.shots.filter((shot) => kindsOf(shot).has(kind)).length;
  const buttons = KINDS.filter((kind) => count(kind) > 0).map((kind) => {
    const button = element("button", { type: "button", "aria-pressed": String(state.kinds.has(kind)) }, `${kind} ${count(kind)}`);
    button.addEventListener("click", () => {
      if (!state.kinds.delete(kind)) state.kinds.add(kind);
      button.setAttribute("aria-pressed", String(state.kinds.has(kind)));
      showList();
    });
    return button;
  });
  byId("kinds").replaceChildren(...buttons);
  byId("kinds").hidden = buttons.length < 2;
}

function openList(on) {
  byId("list").classList.toggle("open", on);
  byId("list-toggle").setAttribute("aria-expanded", String(on));
}

const total = (key) => report.folders.reduce((sum, folder) => sum + folder[key], 0);

function showOverview() {
  const [failed, changed, identical] = [total("failed"), total("changed"), total("identical")];
  const differences = [...(failed > 0 ? [`${failed} failed`] : []), ...(changed > 0 ? [`${changed} changed within limits`] : [])];
  byId("overview-title").textContent =
    differences.length > 0
      ? `Of ${plural(failed + changed + identical, "image")}, ${differences.join(", ")}`
      : identical === 1
        ? "The image matches its reference"
        : `All ${identical} images match their references`;
  byId("overview-title").className = failed > 0 ? "" : changed > 0 ? "warn" : "good";
  byId("overview-note").hidden = report.omitted === 0;
  byId("overview-note").textContent =
    `The images of ${plural(report.omitted, "frame")} are omitted: a page holds at most ${report.budget_mebibytes} MiB of images. ` +
    "Where a command can show them, the frame names it.";
  byId("overview-command").replaceChildren(commandBox(report.command, "the command of this report"));
  byId("folders").replaceChildren(...(report.folders.length > 0 && !report.asset ? [folderTable()] : []));
  showFileChanges();
  const indices = report.shots.map((_, index) => index);
  const tables = VERDICTS.map(([verdict, title]) => {
    const shots = indices.filter((index) => verdictOf(report.shots[index]) === verdict);
    return element("div", { className: "kind" }, ...(shots.length > 0 ? [element("h3", {}, title), shotTable(shots)] : []));
  });
  byId("verdicts").replaceChildren(...tables);
}

const row = (kind, ...cells) => element("tr", {}, ...cells.map((cell, at) => element(kind, { className: at > 0 ? "number" : "path", scope: kind === "th" ? "col" : "" }, cell)));

function folderTable() {
  const isTimed = report.folders.some((folder) => folder.seconds > 0);
  const cells = (name, { identical, changed, failed, seconds }) => [
    name,
    String(identical),
    element("span", { className: changed > 0 ? "warn" : "quiet" }, String(changed)),
    element("span", { className: failed > 0 ? "bad" : "quiet" }, String(failed)),
    ...(isTimed ? [seconds.toFixed(1) + " s"] : []),
  ];
  const body = report.folders.map((folder) => row("td", ...cells(folder.name || "./", folder)));
  const sums = { identical: total("identical"), changed: total("changed"), failed: total("failed"), seconds: total("seconds") };
  const table = element(
    "table",
    {},
    element("thead", {}, row("th", "folder", "identical", "changed", "failed", ...(isTimed ? ["time"] : []))),
    element("tbody", {}, ...body),
  );
  if (body.length > 1) table.append(element("tfoot", {}, row("td", ...cells("all", sums))));
  return element("div", { className: "scroll narrow" }, table);
}

/** The table of the shots of these indices. */
function shotTable(indices) {
  const rows = indices.map((index) => {
    const shot = report.shots[index];
    const worst = shot.frames[worstFrame(shot)];
    const link = element("button", { type: "button", className: "link" }, ...nameParts(shot.name));
    link.addEventListener("click", () => go(index, worstFrame(shot)));
    const largest = (key) => {
      const values = shot.frames.flatMap((frame) => frame.flip?.[key] ?? []);
      return element("td", { className: "number" }, values.length > 0 ? Math.max(...values).toFixed(4) : "");
    };
    const lost = shot.frames.flatMap((frame) => frame.messages.filter((message) => message.startsWith("lost: ")));
    const why = [...new Set([...lost, worst?.likely || worst?.messages[0] || ""])].filter(Boolean).join("; ");
    const images = element("td", { className: "thumbnails" }, ...thumbnails(worst));
    return element("tr", {}, element("th", { scope: "row", className: "path" }, link), images, element("td", {}, kindText(shot)), largest("mean"), largest("tile"), element("td", { className: "why" }, why));
  });
  const head = [report.asset ? "images" : "shot", "expected, actual", "kind", "mean FLIP", "worst tile", "likely cause or message"].map((name, at) => element("th", { scope: "col", className: at === 3 || at === 4 ? "number" : "" }, name));
  return element("div", { className: "scroll" }, element("table", {}, element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows)));
}

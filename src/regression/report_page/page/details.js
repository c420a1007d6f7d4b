// Details of a failure or change: messages, measures, layers, commands.

function showDetails() {
  const [shot, frame] = [shownShot(), shownFrame()];
  byId("shot-name").replaceChildren(...nameParts(shot.frames.length > 1 ? frame.name : shot.name));
  byId("status").textContent = kindOf(frame) === "changed" ? "changed within limits" : kindOf(frame);
  byId("status").className = "status " + kindOf(frame);
  byId("preset").textContent = "preset " + shot.preset;
  const indices = listed();
  byId("previous").disabled = indices.indexOf(state.shot) <= 0;
  byId("next").disabled = indices.indexOf(state.shot) === indices.length - 1;
  byId("position").textContent = `${indices.indexOf(state.shot) + 1 || "–"} of ${indices.length}`;
  byId("messages").replaceChildren(...frame.messages.map((message) => element("li", {}, message)));
  byId("messages").className = frame.verdict;
  const cause = frame.likely;
  byId("cause").hidden = !cause;
  byId("cause").replaceChildren(element("span", { className: "quiet" }, "Likely cause: "), element("strong", {}, cause || ""));
  byId("measures").replaceChildren(...measures(frame));
  byId("layers").replaceChildren(...layers(frame));
  byId("commands").replaceChildren(...commands(shot));
}

function commands(shot) {
  if (shot.commands.length === 0) return [];
  const boxes = shot.commands.map(([name, command]) => element("div", { className: "named-command" }, element("p", {}, name), commandBox(command, name)));
  return [element("h3", {}, "Commands"), ...boxes];
}

const heading = (...names) => element("thead", {}, element("tr", {}, ...names.map(([name, isNumber]) => element("th", { scope: "col", className: isNumber ? "number" : "" }, name))));
const number = (text) => element("td", { className: "number" }, text);

/** A pixel position as a button that shows it. */
function position(at) {
  if (!at) return element("td", {});
  const button = element("button", { type: "button", className: "link numbers", title: "Inspect this pixel", disabled: byId("viewer").hidden }, `${at[0]}, ${at[1]}`);
  button.addEventListener("click", () => goTo(at));
  return element("td", { className: "number" }, button);
}

/** A number with four significant digits; `null` stands for infinite numbers. */
function shortText(value) {
  if (value === null) return "inf";
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 1e9) return String(value);
  return size < 1e-4 || size >= 1e4 ? value.toExponential(1) : String(Number(value.toPrecision(4)));
}

function measures(frame) {
  const rows = frame.checks.map((check) => {
    const bar = element("i");
    const share = check.limit === null ? 0 : check.measured === null ? NaN : check.measured / check.limit;
    // The limit is in the middle of the bar. A share without a value fills it, if the check fails.
    bar.style.width = Math.min(100, (Number.isNaN(share) ? (check.passes ? 0 : 2) : share) * 50) + "%";
    return element(
      "tr",
      { className: check.passes ? "" : "fails" },
      element("th", { scope: "row" }, check.measure),
      number(shortText(check.measured)),
      number(check.limit === null ? "none" : shortText(check.limit)),
      element("td", {}, element("span", { className: "share" + (check.passes ? "" : " fails"), "aria-hidden": "true" }, bar)),
      element("td", { className: check.passes ? "good" : "bad" }, check.passes ? "ok" : "FAIL"),
      position(check.at),
    );
  });
  const square = frame.root_mean_square;
  const decibels = square?.peak_ratio_decibels?.toFixed(1) ?? "inf";
  const squares = square ? [element("p", { className: "quiet numbers" }, `RMSE ${shortText(square.error)}, PSNR ${decibels} dB`)] : [];
  if (rows.length === 0 && squares.length === 0) return [];
  const table = element("table", {}, heading(["measure"], ["measured", 1], ["limit", 1], [""], ["result"], ["worst at", 1]), element("tbody", {}, ...rows));
  return [element("h3", {}, "Measures"), ...(rows.length > 0 ? [element("div", { className: "scroll" }, table)] : []), ...squares];
}

function layers(frame) {
  const rows = frame.layers.flatMap((layer) =>
    layer.channels.map((channel, at) =>
      element(
        "tr",
        {},
        element("th", { scope: "row" }, at === 0 ? layer.layer : ""),
        number(at === 0 ? String(layer.different_pixels) : ""),
        element("td", {}, element("code", {}, channel.channel)),
        number(String(channel.different)),
        number(valueText(channel.largest)),
        number(channel.largest_relative === null ? "∞" : valueText(channel.largest_relative * 100) + " %"),
        position(channel.different > 0 ? channel.largest_at : null),
      ),
    ),
  );
  if (rows.length === 0) return [];
  const head = heading(["layer"], ["pixels too far off", 1], ["channel"], ["values that differ", 1], ["largest difference", 1], ["largest share", 1], ["largest at", 1]);
  return [element("h3", {}, "Layers"), element("div", { className: "scroll" }, element("table", {}, head, element("tbody", {}, ...rows)))];
}

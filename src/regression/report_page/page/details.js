// What is known about the failure: messages, measures, layers, commands.

function showDetails() {
  const [shot, frame] = [shownShot(), shownFrame()];
  byId("shot-name").replaceChildren(...nameParts(shot.frames.length > 1 ? frame.name : shot.name));
  byId("status").textContent = frame.status;
  byId("status").className = "status " + frame.status;
  byId("preset").textContent = "preset " + shot.preset;
  const places = listed();
  byId("previous").disabled = places.indexOf(state.shot) <= 0;
  byId("next").disabled = places.indexOf(state.shot) === places.length - 1;
  byId("position").textContent = `${places.indexOf(state.shot) + 1 || "–"} of ${places.length}`;
  byId("messages").replaceChildren(...frame.messages.map((message) => element("li", {}, message)));
  const cause = frame.comparison?.cause;
  byId("cause").hidden = !cause;
  byId("cause").replaceChildren(element("span", { className: "quiet" }, "Likely cause: "), element("strong", {}, cause || ""));
  byId("measures").replaceChildren(...measures(frame.comparison));
  byId("layers").replaceChildren(...layers(frame.comparison));
  byId("commands").replaceChildren(...commands(shot));
}

function commands(shot) {
  if (shot.commands.length === 0) return [];
  const boxes = shot.commands.map(([name, command]) => element("div", { className: "named-command" }, element("p", {}, name), commandBox(command, name)));
  return [element("h3", {}, "Commands"), ...boxes];
}

const heading = (...names) => element("thead", {}, element("tr", {}, ...names.map(([name, isNumber]) => element("th", { scope: "col", className: isNumber ? "number" : "" }, name))));
const number = (text) => element("td", { className: "number" }, text);

/** A place as a button that goes there. */
function place(at) {
  if (!at) return element("td", {});
  const button = element("button", { type: "button", className: "link numbers", title: "Inspect this pixel", disabled: byId("viewer").hidden }, `${at[0]}, ${at[1]}`);
  button.addEventListener("click", () => goTo(at));
  return element("td", { className: "number" }, button);
}

function measures(comparison) {
  if (!comparison) return [];
  const rows = comparison.checks.map((check) => {
    const bar = element("i");
    // The limit is in the middle; what is not a number is beyond.
    bar.style.width = Math.min(100, (check.share ?? (check.passes ? 0 : 2)) * 50) + "%";
    return element(
      "tr",
      { className: check.passes ? "" : "fails" },
      element("th", { scope: "row" }, check.measure),
      number(check.measured),
      number(check.limit === "inf" ? "none" : check.limit),
      element("td", {}, element("span", { className: "share" + (check.passes ? "" : " fails"), "aria-hidden": "true" }, bar)),
      element("td", { className: check.passes ? "good" : "bad" }, check.passes ? "ok" : "FAIL"),
      place(check.at),
    );
  });
  const squares = comparison.rmse === null ? [] : [element("p", { className: "quiet numbers" }, `RMSE ${comparison.rmse}, PSNR ${comparison.psnr}`)];
  const table = element("table", {}, heading(["measure"], ["measured", 1], ["limit", 1], [""], ["verdict"], ["worst at", 1]), element("tbody", {}, ...rows));
  return [element("h3", {}, "Measures"), ...(rows.length > 0 ? [element("div", { className: "scroll" }, table)] : []), ...squares];
}

function layers(comparison) {
  const rows = (comparison?.layers || []).flatMap((layer) =>
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
        place(channel.different > 0 ? channel.largest_at : null),
      ),
    ),
  );
  if (rows.length === 0) return [];
  const head = heading(["layer"], ["pixels too far off", 1], ["channel"], ["values that differ", 1], ["largest difference", 1], ["largest share", 1], ["largest at", 1]);
  return [element("h3", {}, "Layers"), element("div", { className: "scroll" }, element("table", {}, head, element("tbody", {}, ...rows)))];
}

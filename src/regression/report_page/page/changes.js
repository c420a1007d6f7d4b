// The changes of an asset: what is lost, and a table of what changed in the file.

function showFileChanges() {
  const { asset } = report;
  if (!asset) return;
  byId("list-toggle").textContent = "Images";
  byId("shots-none").textContent = "No image matches.";
  byId("filter").placeholder = "Filter images  /";
  byId("losses").hidden = asset.losses.length === 0;
  byId("losses").replaceChildren(...asset.losses.map((loss) => element("li", { className: "bad" }, loss)));
  byId("file-changes").hidden = false;
  const title = element("h3", { id: "file-changes-title" }, "Changes of the file");
  if (asset.groups.length === 0) {
    byId("file-changes").replaceChildren(title, element("p", { className: "quiet" }, "Nothing changed but, perhaps, values of vertices, texels and keyframes."));
    return;
  }
  byId("file-changes").replaceChildren(title, element("div", { className: "scroll" }, element("table", {}, ...asset.groups.flatMap(changeGroup))));
}

const MARKS = { "-": "removed", "+": "added", "~": "changed" };

/** A heading that opens and closes the rows of a group. Long groups are closed at first. */
function changeGroup({ title, rows }) {
  const body = element("tbody", { hidden: rows.length > 24 }, ...rows.map(changeRow));
  const items = rows.filter((row) => row.name).length;
  const button = element("button", { type: "button", className: "link", "aria-expanded": String(!body.hidden) }, title);
  button.addEventListener("click", () => {
    body.hidden = !body.hidden;
    button.setAttribute("aria-expanded", String(!body.hidden));
  });
  const heading = element("th", { scope: "rowgroup", colSpan: 3, className: "group-title" }, button, element("span", { className: "quiet numbers" }, ` ${items}`));
  return [element("tbody", {}, element("tr", {}, heading)), body];
}

function changeRow({ mark, name, property, values }) {
  const sign = element("span", { className: "sign " + MARKS[mark], title: MARKS[mark] }, mark === "-" ? "−" : mark);
  const label = name ? [sign, element("span", { className: "unseen" }, MARKS[mark] + " "), name] : [];
  return element("tr", { className: name ? "" : "more" }, element("th", { scope: "row", className: "path" }, ...label), element("td", { className: "property" }, property), element("td", { className: "values numbers" }, values));
}

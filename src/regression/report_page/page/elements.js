// Elements, texts that are copied, and a memory that may be missing.

const byId = (id) => document.getElementById(id);

/** An element with properties, and children that are elements or texts. Texts never become markup. */
function element(name, properties, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(properties || {})) {
    if (key in made && !key.startsWith("aria")) made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

function vector(name, attributes, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** Tells a screen reader. */
function say(text) {
  byId("spoken").textContent = text;
}

/** A command with a button that copies it. */
function commandBox(command, name) {
  const text = element("code", {}, command);
  const button = element("button", { type: "button", "aria-label": "Copy: " + (name || "command") }, "Copy");
  button.addEventListener("click", async () => {
    button.textContent = (await copied(command, text)) ? "Copied" : "Press Ctrl+C";
    say(button.textContent);
    setTimeout(() => (button.textContent = "Copy"), 1600);
  });
  return element("div", { className: "command" }, element("pre", {}, text), button);
}

/** Where a page may not write to the clipboard, the text is selected instead. */
async function copied(text, shown) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    getSelection().selectAllChildren(shown);
    try {
      return document.execCommand("copy");
    } catch {
      return false;
    }
  }
}

/** What the browser remembers; nothing where it may not. */
const memory = {
  read(key) {
    try {
      return JSON.parse(localStorage.getItem("rayframe:" + key));
    } catch {
      return null;
    }
  },
  write(key, value) {
    try {
      localStorage.setItem("rayframe:" + key, JSON.stringify(value));
    } catch {
      // It is lost with the page.
    }
  },
};

const calm = matchMedia("(prefers-reduced-motion: reduce)");
const plural = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;

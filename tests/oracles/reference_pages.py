#!/usr/bin/env python3
"""Writes docs/cli.md from the help of the program, and docs/schemas.md from schema/*.json.

usage: reference_pages.py RAYFRAME [--check]

With --check nothing is written; the exit code is 1 where a page is not what would be written.
"""

import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
# What stands in place of the page's own text.
NOTE = "<!-- Written by tests/oracles/reference_pages.py; edits are lost. -->\n"
# Verbs whose options repeat those of another.
BASE = {"farm": "render", "watch": "render"}


def help_of(rayframe, *verb):
    return subprocess.run([rayframe, *verb, "--help"], capture_output=True, text=True, check=True).stdout


def paragraphs(lines):
    """Joins wrapped lines. Returns paragraphs, and items of lists as paragraphs that begin with '- '."""
    result, is_open = [], False
    for line in (line.strip() for line in lines):
        if not line:
            is_open = False
        elif is_open and not line.startswith("- "):
            result[-1] += " " + line
        else:
            result.append(line)
            is_open = True
    return result


def parse(text):
    """The description, the usage and the sections of a help text: (heading, [(entry, paragraphs)])."""
    description, usage, sections = [], "", []
    for line in text.splitlines():
        indent = len(line) - len(line.lstrip())
        if line.startswith("Usage:"):
            usage = re.sub(r"^Usage: \S+", "rayframe", line)
        elif line and indent == 0 and usage and line.endswith(":"):
            sections.append((line[:-1], []))
        elif not usage:
            description.append(line)
        elif sections and line and indent <= 6:
            entry, *rest = re.split(r"\s{2,}", line.strip(), maxsplit=1)
            sections[-1][1].append((entry, rest))
        elif sections and sections[-1][1]:
            sections[-1][1][-1][1].append(line)
    return " ".join(paragraphs(description)), usage, [(name, [(entry, paragraphs(lines)) for entry, lines in entries]) for name, entries in sections]


def escaped(text):
    """Plain text as Markdown: what is in backticks stays as it is."""
    parts = text.split("`")
    parts[::2] = [re.sub(r"([<*\[\]])", r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)


def cell(text):
    return text.replace("|", "\\|")


def is_help(entry):
    return entry in ("-h, --help", "-V, --version")


def table(kind, rows):
    """A table of rows, without the column of defaults where none has one."""
    if any(default for _, _, default in rows):
        return f"| {kind} | meaning | default |\n|---|---|---|\n" + "".join(f"| {entry} | {text} | {default} |\n" for entry, text, default in rows)
    return f"| {kind} | meaning |\n|---|---|\n" + "".join(f"| {entry} | {text} |\n" for entry, text, _ in rows)


def row(entry, texts, anchor):
    """The cells of one row: the entry, what it does, its default."""
    text, default = " ".join(part for part in texts if not part.startswith(("- ", "Possible values:"))), ""
    if found := re.search(r"\s*\[default: (.*?)\](?= \[|$)", text):
        text, default = text[: found.start()] + text[found.end() :], found[1]
    items = [part[2:] for part in texts if part.startswith("- ")]
    values = [re.sub(r"^(\S+?): *", r"`\1`: ", escaped(item)) for item in items]
    text = "<br>".join([escaped(text), *values]).removeprefix("<br>")
    target = f'<a id="{anchor}"></a>' if anchor else ""
    return f"{target}`{cell(entry)}`", cell(text), cell(escaped(default))


def long_name(entry):
    found = re.search(r"--([a-z-]+)", entry)
    return found and found[1]


def verb_page(verb, text, base):
    """The part of docs/cli.md about a verb, without what it shares with `base`."""
    description, usage, sections = parse(text)
    page = f"\n## rayframe {verb}\n\n{escaped(description)}.\n\n```console\n$ {usage}\n```\n"
    shared = []
    for heading, entries in sections:
        rows = []
        for entry, texts in entries:
            if is_help(entry):
                continue
            if base and (entry, texts) in base:
                shared.append(entry)
                continue
            name = long_name(entry)
            rows.append(row(entry, texts, name and f"{verb}-{name}"))
        if rows:
            kind = "argument" if heading == "Arguments" else "option"
            title = "" if heading in ("Arguments", "Options") else f"\n### {heading} of {verb}\n"
            page += f"{title}\n{table(kind, rows)}"
    if shared:
        links = [f"[`--{long_name(entry)}`](#{BASE[verb]}-{long_name(entry)})" for entry in shared if long_name(entry)]
        page += f"\nAs for `{BASE[verb]}`: {', '.join(links)}.\n"
    return page


def cli_page(rayframe):
    description, usage, sections = parse(help_of(rayframe))
    verbs = [(verb, " ".join(texts)) for verb, texts in dict(sections)["Commands"] if verb != "help"]
    page = f"{NOTE}\n# Command line\n\n{description}. This is the text of `rayframe VERB --help`; `rayframe man` prints the same as manual pages. "
    page += "Options of `render` are also settings of [shot files](shots.md). Exit codes are in [exit-codes.md](exit-codes.md).\n\n"
    page += "| verb | what it does |\n|---|---|\n"
    page += "".join(f"| [`{verb}`](#rayframe-{verb}) | {cell(escaped(text))} |\n" for verb, text in verbs)
    helps = {verb: help_of(rayframe, verb) for verb, _ in verbs}
    for verb, text in helps.items():
        base = BASE.get(verb)
        entries = [entry for _, entries in parse(helps[base])[2] for entry in entries] if base else []
        page += verb_page(verb, text, entries)
    return page


def type_of(node):
    """The values that a schema allows, in a few words."""
    if "const" in node:
        return f"`{json.dumps(node['const'])}`"
    if "enum" in node:
        return ", ".join(f"`{json.dumps(value)}`" for value in node["enum"])
    if "oneOf" in node:
        return " or ".join(dict.fromkeys(type_of(part) for part in node["oneOf"]))
    kinds = node.get("type", "any")
    text = " or ".join(kinds if isinstance(kinds, list) else [kinds])
    if "items" in node:
        count = f" of {node['minItems']}" if node.get("minItems") and node.get("minItems") == node.get("maxItems") else ""
        text = text.replace("array", f"array{count} ({type_of(node['items'])})")
    if "maximum" in node:
        text += f", {node['minimum']} to {node['maximum']}"
    elif node.get("minimum"):
        text += f", at least {node['minimum']}"
    if node.get("minLength") and node.get("minLength") == node.get("maxLength"):
        text += f" of {node['minLength']} characters"
    return text


def fields(node, path=""):
    """(path, schema, whether it is required) of all fields below an object, array or choice."""
    for name, child in node.get("properties", {}).items():
        here = f"{path}.{name}" if path else name
        yield here, child, name in node.get("required", [])
        yield from fields(child, here)
    if isinstance(node.get("items"), dict):
        yield from fields(node["items"], path + "[]")
    for part in node.get("oneOf", []):
        kind = part.get("properties", {}).get("kind", {}).get("const")
        for here, child, required in fields(part, path):
            note = f"Of kind `{kind}`. " if kind and not here.endswith(".kind") else ""
            yield here, {**child, "description": note + child.get("description", "")}, required


def field_table(rows):
    table = "| field | value | meaning |\n|---|---|---|\n"
    for path, node, required in dict.fromkeys((path, json.dumps(node), required) for path, node, required in rows):
        node = json.loads(node)
        text = escaped(node.get("description", "")) + ("" if required else " (not always there)")
        table += f"| `{path}` | {cell(type_of(node))} | {cell(text.strip())} |\n"
    return table


def schema_part(file):
    schema = json.loads(file.read_text())
    title = schema["title"]
    page = f"\n## {title}\n\n{escaped(schema['description'])} Schema: [{file.name}](../schema/{file.name}).\n\n"
    if "properties" in schema:
        return page + field_table(fields(schema))
    variants = schema["oneOf"]
    lists = [list(fields(variant)) for variant in variants]
    common = [field for field in lists[0] if all(field in other for other in lists)]
    names = [variant["properties"]["event"]["const"] for variant in variants]
    event = ("event", {"enum": names, "description": "What happened; each has a table below"}, True)
    page += f"In each object:\n\n{field_table([event, *common])}"
    for variant, rows in zip(variants, lists):
        name = variant["properties"]["event"]["const"]
        page += f"\n### Event `{name}`\n\n{escaped(variant['description'])}.\n"
        own = [field for field in rows if field not in common and field[0] != "event"]
        page += f"\n{field_table(own)}" if own else ""
    return page


def schema_page():
    page = f"{NOTE}\n# JSON output\n\nWhat `check --json`, `diff --json`, `info --json`, `test --json`, `--progress json`, `--manifest`, `--stats` and `rayframe farm` write, field by field. The schemas are JSON Schema 2020-12. "
    page += "`a.b` is field `b` of object `a`, `a[]` an element of array `a`.\n"
    return page + "".join(schema_part(file) for file in sorted((ROOT / "schema").glob("*.json")))


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--check"]
    if len(arguments) != 1:
        sys.exit(__doc__)
    pages = {"docs/cli.md": cli_page(arguments[0]), "docs/schemas.md": schema_page()}
    stale = [name for name, text in pages.items() if not (ROOT / name).is_file() or (ROOT / name).read_text() != text]
    if "--check" in sys.argv:
        for name in stale:
            print(f"{name} is not what the program says; run: python3 tests/oracles/reference_pages.py RAYFRAME")
        sys.exit(1 if stale else 0)
    for name in stale:
        (ROOT / name).write_text(pages[name])
        print(f"wrote {name}")


if __name__ == "__main__":
    main()

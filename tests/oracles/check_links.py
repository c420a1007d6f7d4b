#!/usr/bin/env python3
"""Checks the links between the pages of the repository, without a network.

usage: check_links.py [--targets | --site FOLDER]

Every relative link and image of README.md, CHANGELOG.md, SECURITY.md, docs/*.md and the READMEs of packages names a file that git
has or would add, and every anchor a heading, by GitHub's rules, or an `id`. docs/SUMMARY.md lists every page of docs/. With --targets the pages and what
they link to are printed, one file a line: what a site needs. With --site the links of the HTML
pages of a built site are checked instead, and that they load nothing from elsewhere. The exit code is 1 where a link is broken.
"""

import os
import pathlib
import re
import subprocess
import sys
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = ("README.md", "CHANGELOG.md", "SECURITY.md", "docs/*.md", "packaging/*/README.md")
LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\[\]]*\])*\]\(\s*<?([^()\s>]*(?:\([^()]*\))?[^()\s>]*)>?(?:\s+\"[^\"]*\")?\s*\)")


def prose(text):
    """The lines of a page without fenced code, with their numbers."""
    fence = ""
    for number, line in enumerate(text.splitlines(), 1):
        mark = re.match(r"\s*(`{3,}|~{3,})", line)
        if mark and not fence:
            fence = mark[1]
        elif fence and line.strip() == fence:
            fence = ""
        elif not fence:
            yield number, line


def without_code(line):
    return re.sub(r"(`+).*?\1", "", line)


def slug(heading):
    """The anchor that GitHub makes of a heading."""
    plain = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").replace("*", "")
    return re.sub(r"[^\w\- ]", "", plain.strip().lower()).replace(" ", "-")


def anchors(text):
    """All anchors of a page; equal headings are numbered."""
    found, counts = set(re.findall(r'<a id="([^"]+)"', text)), {}
    for _, line in prose(text):
        if heading := re.match(r"#{1,6}\s+(.*?)\s*#*$", line):
            name = slug(heading[1])
            count = counts.get(name, 0)
            counts[name] = count + 1
            found.add(f"{name}-{count}" if count else name)
    return found


def links(text):
    for number, line in prose(text):
        for target in LINK.findall(without_code(line)):
            yield number, target


def known_files():
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True)
    return {name for name in listed.stdout.splitlines() if (ROOT / name).is_file()}


def check(pages, files):
    """Broken links as texts, and all files that links name."""
    broken, targets = [], set()
    names = {name: anchors(text) for name, text in pages.items()}
    for page, text in pages.items():
        for number, link in links(text):
            if re.match(r"[a-z]+:", link):
                continue
            path, _, anchor = urllib.parse.unquote(link).partition("#")
            target = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
            targets.add(target)
            if target not in files:
                broken.append(f"{page}:{number}: {link}: there is no file {target}")
            elif anchor and target in names and anchor not in names[target]:
                broken.append(f"{page}:{number}: {link}: {target} has no heading of that name")
    return broken, targets


def check_site(folder):
    """Broken links of the HTML pages below a folder, and addresses that they load, as texts; and the number of pages."""
    pages = {path: path.read_text() for path in folder.rglob("*.html")}
    names = {path: set(re.findall(r'\bid="([^"]*)"', text)) for path, text in pages.items()}
    broken = []
    for page, text in pages.items():
        # The page of errors stands for any address, and the printed page repeats all others.
        if page.name in ("404.html", "print.html", "toc.html"):
            continue
        for tag, link in re.findall(r'<(\w+)\b[^>]*?\b(?:href|src)="([^"]*)"', text):
            if re.match(r"[a-z]+:|//", link):
                broken += [] if tag == "a" or link.startswith("data:") else [f"{page}: loads {link}"]
                continue
            path, _, anchor = urllib.parse.unquote(link).partition("#")
            target = pathlib.Path(os.path.normpath(page.parent / path)) if path else page
            target = target / "index.html" if target.is_dir() else target
            if not target.is_file():
                broken.append(f"{page}: {link}: there is no file {target}")
            elif anchor and target in names and anchor not in names[target]:
                broken.append(f"{page}: {link}: there is no such anchor")
    return broken, len(pages)


def main():
    if "--site" in sys.argv:
        broken, count = check_site(pathlib.Path(sys.argv[-1]))
        print("\n".join([*broken, f"{count} pages of the site, {len(broken)} broken links"]))
        sys.exit(bool(broken) or count == 0)
    files = known_files()
    names = sorted(str(path.relative_to(ROOT)) for pattern in PAGES for path in ROOT.glob(pattern))
    pages = {name: (ROOT / name).read_text() for name in names if name in files}
    broken, targets = check(pages, files)
    contents = {os.path.normpath(f"docs/{link}") for _, link in links(pages.get("docs/SUMMARY.md", ""))}
    broken += [f"docs/SUMMARY.md: {name} is missing" for name in pages if name.startswith("docs/") and name not in contents | {"docs/SUMMARY.md"}]
    if "--targets" in sys.argv:
        print("\n".join(sorted((targets | set(pages)) & files)))
    else:
        print("\n".join([*broken, f"{len(pages)} pages, {len(targets)} files linked, {len(broken)} broken links"]))
    sys.exit(bool(broken))


if __name__ == "__main__":
    main()

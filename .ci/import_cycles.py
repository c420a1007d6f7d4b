#!/usr/bin/env python3
"""Checks that no two source files import each other, also through others, and that modules are in the order of docs/architecture.md.

A file imports another when it names an item that the other defines: in a `use` tree, or in a path that starts with `crate::`,
`rayframe::`, `super::` or `self::`. Re-exports are followed to the file that defines the item; `mod` declarations, and re-exports that
the file itself does not use, are not imports, nor are methods, which may be defined anywhere. Code below `#[cfg(test)] mod tests` at a
file's end is left out.

usage: import_cycles.py
"""
import os, re, sys
from collections import defaultdict

os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
src, page = "src", "docs/architecture.md"
files = {}  # module path tuple -> file
for root, _, names in os.walk(src):
    for name in names:
        if not name.endswith(".rs"): continue
        path = os.path.join(root, name)
        rel = os.path.relpath(path, src)[:-3].split(os.sep)
        if rel[-1] == "tests" or "tests" in rel: continue
        if rel in (["lib"], ["main"]): mod = ()
        elif rel[-1] == "mod": mod = tuple(rel[:-1])
        else: mod = tuple(rel)
        if rel == ["main"]: continue
        files[mod] = path

# In this order at each place: comments, raw strings, strings, characters. A quote in one of them begins none of the others.
SKIPPED = re.compile(
    r'//[^\n]*|/\*.*?\*/|\bb?r(#*)".*?"\1|b?"(?:\\.|[^"\\])*"|b?' + r"'(?:\\(?:u\{\w+\}|x\w\w|.)|[^'\\])'", re.S)

def strip(text):
    text = SKIPPED.sub(lambda m: '' if m.group().startswith('/') else '""', text)
    i = re.search(r'#\[cfg\(test\)\]\s*(?:pub(?:\([^)]*\))?\s+)?mod \w+ \{', text)
    return text[:i.start()] if i else text

texts = {m: strip(open(p, encoding='utf-8').read()) for m, p in files.items()}

def expand(tree):
    """Flattens a use tree into (path, alias) pairs."""
    tree = tree.strip()
    depth = 0
    brace = tree.find('{')
    if brace < 0:
        m = re.match(r'(.*?)(?:\s+as\s+(\w+))?$', tree, re.S)
        path = [p.strip() for p in m.group(1).split('::')]
        return [(path, m.group(2))]
    head = [p.strip() for p in tree[:brace].split('::') if p.strip()]
    body = tree[brace+1:tree.rfind('}')]
    parts, depth, start = [], 0, 0
    for i, c in enumerate(body):
        if c == '{': depth += 1
        elif c == '}': depth -= 1
        elif c == ',' and depth == 0:
            parts.append(body[start:i]); start = i+1
    parts.append(body[start:])
    out = []
    for p in parts:
        if p.strip():
            out += [(head + path, alias) for path, alias in expand(p)]
    return out

uses, reexports = defaultdict(list), defaultdict(dict)
for mod, text in texts.items():
    for m in re.finditer(r'(pub(?:\([^)]*\))?\s+)?use\s+([^;]+);', text):
        for path, alias in expand(m.group(2)):
            if path[-1] == 'self': path = path[:-1]
            name = alias or path[-1]
            if m.group(1): reexports[mod][name] = path
            else: uses[mod].append(path)
    body = re.sub(r'(pub(?:\([^)]*\))?\s+)?use\s+[^;]+;', '', text)
    for m in re.finditer(r'\b((?:crate|rayframe|super|self)(?:::\w+)+)', body):
        if 'pub(in ' + m.group(1) in body: continue
        uses[mod].append(m.group(1).split('::'))
    body = re.sub(r'\bmod \w+;', '', body)
    # re-exported items that the file uses itself
    uses[mod] += [path for name, path in reexports[mod].items() if re.search(r'(?<![:\w.])' + name + r'\b', body)]
    # paths through a module that is in scope: `use super::options;` then `options::count`
    scope = {}
    for path in uses[mod]:
        scope[path[-1]] = path
    children = {m[-1]: ['self', m[-1]] for m in files if len(m) == len(mod)+1 and m[:len(mod)] == mod}
    for m in re.finditer(r'(?<![:\w])(\w+)((?:::\w+)+)', body):
        first = m.group(1)
        rest = m.group(2).split('::')[1:]
        base = scope.get(first) or children.get(first)
        if base: uses[mod].append(base + rest)

def absolute(mod, path):
    cur = list(mod)
    i = 0
    if path[0] in ('crate', 'rayframe'): cur = []; i = 1
    elif path[0] == 'self': i = 1
    elif path[0] == 'super':
        while i < len(path) and path[i] == 'super':
            if not cur: return None
            cur.pop(); i += 1
    else:
        if tuple(cur + [path[0]]) in files: pass
        else: return None
    return cur, path[i:]

def resolve(mod, path, depth=0):
    """The file that defines what `path` names, seen from `mod`."""
    if depth > 12: return None
    start = absolute(mod, path)
    if start is None: return None
    cur, rest = start
    while rest:
        here = tuple(cur)
        if tuple(cur + [rest[0]]) in files:
            cur = cur + [rest[0]]; rest = rest[1:]; continue
        if here in files and rest[0] in reexports[here]:
            return resolve(here, reexports[here][rest[0]] + rest[1:], depth+1)
        return here if here in files else None
    return None  # a module itself, not an item

edges = defaultdict(set)
for mod in files:
    for path in uses[mod]:
        target = resolve(mod, path)
        if target is not None and target != mod and target in files and target != ():
            edges[mod].add(target)

# Tarjan
index, low, stack, on, comps, counter = {}, {}, [], set(), [], [0]
sys.setrecursionlimit(10000)
def visit(v):
    index[v] = low[v] = counter[0]; counter[0] += 1
    stack.append(v); on.add(v)
    for w in edges[v]:
        if w not in index: visit(w); low[v] = min(low[v], low[w])
        elif w in on: low[v] = min(low[v], index[w])
    if low[v] == index[v]:
        comp = []
        while True:
            w = stack.pop(); on.discard(w); comp.append(w)
            if w == v: break
        if len(comp) > 1: comps.append(comp)
for v in sorted(files): 
    if v not in index: visit(v)
for comp in sorted(comps, key=len):
    print("cycle of %d files:" % len(comp))
    inside = set(comp)
    for v in sorted(comp):
        print("  %s -> %s" % (files[v], ", ".join(sorted(files[w] for w in edges[v] & inside))))

# The table of modules: each uses only modules above it, and those before it in its row.
with open(page, encoding="utf-8") as text:
    table = text.read().split("## Modules\n", 1)[1].split("\n## ", 1)[0]
rows = re.findall(r"^\| (`\w+`(?:, `\w+`)*) \|", table, re.M)
order = {name: i for i, name in enumerate(re.findall(r"\w+", " ".join(rows)))}
modules = {m[0] for m in files if m} | {"main"}
wrong = [f"{page}: the table of modules lacks `{name}`" for name in sorted(modules - order.keys())]
wrong += [f"{page}: the table of modules names `{name}`, which is none" for name in sorted(order.keys() - modules)]
for v in sorted(files):
    for w in sorted(edges[v]):
        if v and v[0] in order and w[0] in order and order[v[0]] < order[w[0]]:
            wrong.append(f"{files[v]} uses {files[w]}, whose module is below its own in {page}")
for line in wrong: print(line)
print("%d files, %d import cycles, %d modules, %d against their order" % (len(files), len(comps), len(modules), len(wrong)))
sys.exit(1 if comps or wrong else 0)

#!/usr/bin/env node
// Packs the launcher and, for each program given, the package of its platform:
//
//   node packaging/npm/pack.mjs OUT [linux-x64=FILE] [darwin-arm64=FILE] …
//
// Prints the names of the packed files.

import { execFileSync } from "node:child_process";
import { chmodSync, copyFileSync, cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const [out, ...programs] = process.argv.slice(2);
if (!out) {
  console.error("usage: node packaging/npm/pack.mjs OUT [PLATFORM=FILE]…");
  process.exit(2);
}
mkdirSync(out, { recursive: true });
const launcher = JSON.parse(readFileSync(join(here, "package.json"), "utf8"));
const stage = mkdtempSync(join(tmpdir(), "rayframe-npm-"));

function pack(folder) {
  for (const licence of ["LICENSE-MIT", "LICENSE-APACHE"]) copyFileSync(join(here, "..", "..", licence), join(folder, licence));
  // On Windows npm is a script, which a shell runs. Paths would need its quotes, so that the file is copied from here.
  const options = { cwd: folder, encoding: "utf8", shell: process.platform === "win32" };
  const packed = execFileSync("npm", ["pack", "--silent"], options).trim();
  copyFileSync(join(folder, packed), join(out, packed));
  console.log(join(out, packed));
}

try {
  const main = join(stage, "rayframe");
  mkdirSync(main);
  for (const file of ["package.json", "README.md", "bin"]) cpSync(join(here, file), join(main, file), { recursive: true });
  pack(main);

  for (const program of programs) {
    const [platform, file] = program.split("=");
    const name = `@rayframe/${platform}`;
    if (!(name in launcher.optionalDependencies) || !file) throw new Error(`${program}: not a platform of package.json and a file`);
    const [os, cpu] = platform.split("-");
    const folder = join(stage, platform);
    const binary = os === "win32" ? "rayframe.exe" : "rayframe";
    mkdirSync(folder);
    copyFileSync(file, join(folder, binary));
    chmodSync(join(folder, binary), 0o755);
    const { version, license } = launcher;
    const description = `The program of rayframe for ${platform}`;
    const manifest = { name, version, description, license, os: [os], cpu: [cpu], files: [binary, "LICENSE-*"], preferUnplugged: true };
    writeFileSync(join(folder, "package.json"), `${JSON.stringify(manifest, null, 2)}\n`);
    pack(folder);
  }
} finally {
  rmSync(stage, { recursive: true });
}

#!/usr/bin/env node
// Runs the program of this platform, which a package of its own holds. RAYFRAME_BINARY names another one.

"use strict";

const { spawn } = require("node:child_process");
const { constants } = require("node:os");

function program() {
  if (process.env.RAYFRAME_BINARY) return process.env.RAYFRAME_BINARY;
  const platform = `${process.platform}-${process.arch}`;
  const file = process.platform === "win32" ? "rayframe.exe" : "rayframe";
  try {
    return require.resolve(`@rayframe/${platform}/${file}`);
  } catch {
    console.error(
      `rayframe: error: the package @rayframe/${platform} is not installed; ` +
        "install without --omit=optional, or name a program in RAYFRAME_BINARY",
    );
    process.exit(69);
  }
}

const child = spawn(program(), process.argv.slice(2), { stdio: "inherit" });

// A terminal sends signals to both processes, others to this one alone. The program ends by a signal within a second.
for (const signal of ["SIGINT", "SIGTERM", "SIGHUP"]) {
  process.on(signal, () => {
    if (!(signal === "SIGINT" && process.stdin.isTTY)) child.kill(signal);
  });
}

child.on("error", (error) => {
  console.error(`rayframe: error: the program cannot be started: ${error.message}`);
  process.exit(69);
});

child.on("exit", (code, signal) => {
  if (!signal) process.exit(code);
  process.removeAllListeners(signal);
  process.kill(process.pid, signal);
  // Where the signal does not end this process.
  setTimeout(() => process.exit(128 + (constants.signals[signal] ?? 0)), 100);
});

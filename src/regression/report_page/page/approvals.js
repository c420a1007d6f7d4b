// What somebody approves, and the file that says so.

/** Names of approved pictures, each with the hash of what was seen. */
const approved = new Map();
const MEMORY = "approved:" + report.title;

/** Whether a picture can be approved: one that was rendered, or a reference that nothing asks for. */
function canApprove(frame) {
  if (!report.can_approve) return false;
  if (frame.status === "dangling") return true;
  return (frame.status === "different" || frame.status === "missing") && frame.hash !== null;
}
const isApproved = (frame) => approved.has(frame.name);
const approvable = (shot) => shot.frames.filter(canApprove);
const hashOf = (frame) => (frame.status === "dangling" ? null : frame.hash);

/** Ticks of before, where the pictures are still those that were seen. */
function recallApprovals() {
  const stored = memory.read(MEMORY) || {};
  for (const frame of report.shots.flatMap(approvable)) {
    if (Object.hasOwn(stored, frame.name) && stored[frame.name] === hashOf(frame)) approved.set(frame.name, hashOf(frame));
  }
}

function approve(frames, on) {
  for (const frame of frames.filter(canApprove)) {
    if (on) approved.set(frame.name, hashOf(frame));
    else approved.delete(frame.name);
  }
  memory.write(MEMORY, Object.fromEntries(approved));
  showApprovals();
  showList();
  say(byId("approved-count").textContent);
}

/** One tick for several pictures: on, off or between. */
function showTick(box, frames) {
  const count = frames.filter(isApproved).length;
  box.checked = frames.length > 0 && count === frames.length;
  box.indeterminate = count > 0 && count < frames.length;
  box.disabled = frames.length === 0;
}

function showApprovals() {
  const all = report.shots.flatMap(approvable);
  byId("approvals").hidden = !report.can_approve || report.shots.length === 0;
  byId("approved-count").textContent = `${approved.size} of ${plural(all.length, "picture")} approved`;
  byId("export").disabled = approved.size === 0;
  const [shot, frame] = [shownShot(), shownFrame()];
  byId("approve").hidden = !report.can_approve || !frame || (!fails(frame) && approvable(shot).length === 0);
  if (!frame) return;
  showTick(byId("approve-frame"), canApprove(frame) ? [frame] : []);
  byId("approve-frame").nextElementSibling.textContent =
    frame.status === "dangling" ? "Approve removing it" : frame.status === "broken" ? "Cannot be approved" : "Approve this picture";
  showTick(byId("approve-shot"), approvable(shot));
  byId("approve-shot").nextElementSibling.textContent = `the whole shot (${approvable(shot).length})`;
  byId("approve-shot-label").hidden = shot.frames.length < 2;
}

function approvalsText() {
  const names = report.shots.flatMap(approvable).filter(isApproved);
  const list = names.map((frame) => ({ name: frame.name, hash: hashOf(frame) }));
  return JSON.stringify({ schema: 1, approved: list }, null, 2) + "\n";
}

function exportApprovals() {
  if (approved.size === 0) return say("Nothing is approved.");
  const address = URL.createObjectURL(new Blob([approvalsText()], { type: "application/json" }));
  const link = element("a", { href: address, download: "approvals.json" });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
  say("approvals.json saved.");
}

// What somebody approves, and the file that says so.

/** Names of approved pictures, each with what was seen. */
const approved = new Map();
/** Ticks are this page's own: suites of one name lie in several places. */
const MEMORY = "approved:" + JSON.stringify([location.href.split("#")[0], report.title, report.accept_command]);

/** Whether a picture can be approved: one that was rendered, or a reference that nothing asks for. */
function canApprove(frame) {
  if (!report.can_approve) return false;
  if (frame.status === "orphaned") return true;
  return (frame.status === "different" || frame.status === "missing") && frame.hash !== null;
}
const isApproved = (frame) => approved.has(frame.name);
const approvable = (shot) => shot.frames.filter(canApprove);

/** What a tick was given for. A reference that nothing asks for has no hash, so it is told by its packed pixels. */
function seen(frame) {
  if (frame.status !== "orphaned") return frame.hash;
  const text = frame.expected ? byId("picture-" + frame.expected.picture).textContent : "";
  let sum = 0x811c9dc5;
  // FNV-1a.
  for (let at = 0; at < text.length; at++) sum = Math.imul(sum ^ text.charCodeAt(at), 0x01000193) >>> 0;
  return `${text.length} ${sum}`;
}

/** Ticks of before, where the pictures are still those that were seen; the others are forgotten. */
function recallApprovals() {
  const stored = memory.read(MEMORY);
  if (!stored) return;
  for (const frame of report.shots.flatMap(approvable)) {
    if (Object.hasOwn(stored, frame.name) && stored[frame.name] === seen(frame)) approved.set(frame.name, seen(frame));
  }
  remember();
}

const remember = () => memory.write(MEMORY, Object.fromEntries(approved));

function approve(frames, on) {
  for (const frame of frames.filter(canApprove)) {
    if (on) approved.set(frame.name, seen(frame));
    else approved.delete(frame.name);
  }
  remember();
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
    frame.status === "orphaned" ? "Approve removing it" : frame.status === "broken" ? "Cannot be approved" : "Approve this picture";
  showTick(byId("approve-shot"), approvable(shot));
  byId("approve-shot").nextElementSibling.textContent = `the whole shot (${approvable(shot).length})`;
  byId("approve-shot-label").hidden = shot.frames.length < 2;
}

function approvalsText() {
  const names = report.shots.flatMap(approvable).filter(isApproved);
  const list = names.map((frame) => ({ name: frame.name, hash: frame.status === "orphaned" ? null : frame.hash }));
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

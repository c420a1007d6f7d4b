// Approvals, and their export.

/** Names of approved images, each with the fingerprint of what was shown. */
const approved = new Map();
/** The key under which ticks are stored. It includes the address, because several suites may share a name. */
const MEMORY = "approved:" + JSON.stringify([location.href.split("#")[0], report.title, report.accept_command]);

/** Whether a frame can be approved: its image was rendered, or it is an orphaned reference. */
function canApprove(frame) {
  if (!report.can_approve) return false;
  if (frame.status === "orphaned") return true;
  return ["different", "missing", "changed"].includes(kindOf(frame)) && frame.hash !== null;
}
const isApproved = (frame) => approved.has(frame.name);
const approvable = (shot) => shot.frames.filter(canApprove);

/** The fingerprint of what a tick approves: the hash, or for an orphaned reference a hash of its packed pixels. */
function fingerprint(frame) {
  if (frame.status !== "orphaned") return frame.hash;
  const text = frame.expected ? byId("image-" + frame.expected.index).textContent : "";
  let sum = 0x811c9dc5;
  // FNV-1a.
  for (let at = 0; at < text.length; at++) sum = Math.imul(sum ^ text.charCodeAt(at), 0x01000193) >>> 0;
  return `${text.length} ${sum}`;
}

/** Restores stored ticks whose images have not changed, and discards the others. */
function recallApprovals() {
  const stored = memory.read(MEMORY);
  if (!stored) return;
  for (const frame of report.shots.flatMap(approvable)) {
    if (Object.hasOwn(stored, frame.name) && stored[frame.name] === fingerprint(frame)) approved.set(frame.name, fingerprint(frame));
  }
  remember();
}

const remember = () => memory.write(MEMORY, Object.fromEntries(approved));

function approve(frames, on) {
  for (const frame of frames.filter(canApprove)) {
    if (on) approved.set(frame.name, fingerprint(frame));
    else approved.delete(frame.name);
  }
  remember();
  showApprovals();
  showList();
  say(byId("approved-count").textContent);
}

/** One tick for several frames: on, off or indeterminate. */
function showTick(box, frames) {
  const count = frames.filter(isApproved).length;
  box.checked = frames.length > 0 && count === frames.length;
  box.indeterminate = count > 0 && count < frames.length;
  box.disabled = frames.length === 0;
}

function showApprovals() {
  const all = report.shots.flatMap(approvable);
  byId("approvals").hidden = !report.can_approve || report.shots.length === 0;
  byId("approved-count").textContent = `${approved.size} of ${plural(all.length, "image")} approved`;
  byId("export").disabled = approved.size === 0;
  const [shot, frame] = [shownShot(), shownFrame()];
  byId("approve").hidden = !report.can_approve || !frame || (!differs(frame) && approvable(shot).length === 0);
  if (!frame) return;
  showTick(byId("approve-frame"), canApprove(frame) ? [frame] : []);
  byId("approve-frame").nextElementSibling.textContent =
    frame.status === "orphaned" ? "Approve removing it" : frame.status === "broken" ? "Cannot be approved" : "Approve this image";
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

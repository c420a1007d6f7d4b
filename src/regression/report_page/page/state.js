// The state of the page; everything else is rendered from it.

/** Swaps a second. Web Content Accessibility Guidelines 2.2, criterion 2.3.1, allow three flashes a second. */
const FASTEST_SWAPS = 3;

const state = {
  /** The shot's index; −1 is the overview. */
  shot: -1,
  frame: 0,
  mode: "side",
  stops: 0,
  /** A factor, or 0 to fit. */
  zoom: 0,
  /** Stops by which differences are amplified. */
  gain: 3,
  /** Where expected ends and actual begins, as a share of the width. */
  wipe: 0.5,
  flicker: { runs: false, rate: 2, shows: "expected" },
  marker: true,
  /** Column and row. */
  pixel: null,
  filter: "",
  kinds: new Set(),
};

const shownShot = () => report.shots[state.shot];
const shownFrame = () => shownShot()?.frames[state.frame];
const fails = (frame) => frame.verdict === "failed";
const differs = (frame) => frame.verdict !== "identical";
const differing = (shot) => shot.frames.filter(differs);

/** The kind of a frame in lists: its status, or the verdict of a frame that passes. */
const kindOf = (frame) => (frame.status === "passed" ? frame.verdict : frame.status);

/** The worst verdict of a shot's frames. */
const verdictOf = (shot) => (shot.frames.some(fails) ? "failed" : shot.frames.some(differs) ? "changed" : "identical");

/** The frame that is shown first: the failure with the worst tile, or else the first failure, or else the change with the worst tile. */
const worstFrame = (shot) => shot.worst;

function frameLabel(frame) {
  return frame.frame === null ? frame.name : "frame " + frame.frame;
}

// The page: wires the connection, the picture, the hands and the panels.

import { Connection, ask } from "./connection.js";
import { CropBox } from "./crop_box.js";
import { Curtain } from "./curtain.js";
import { Curve } from "./curve.js";
import { ErrorMap } from "./error_map.js";
import { Hands } from "./hands.js";
import { isLocal } from "./local.js";
import { Marks } from "./marks.js";
import { Panels } from "./panels.js";
import { OpenPanel } from "./open.js";
import { Pick } from "./pick.js";
import { PictureView } from "./picture.js";
import { RayPanel } from "./ray.js";
import { Slices } from "./slices.js";
import { Status } from "./status.js";

const byId = (id) => document.getElementById(id);

const canvas = byId("picture");
const status = new Status();
const marks = new Marks(byId("overlay"));
let client = 0;
let tool = "turn";
let range = [0, 1];

const send = (edit) => connection?.send(edit) ?? 0;

const picture = new PictureView(canvas, (size) => send({ kind: "size", size }));
const curve = new Curve(byId("curve"), {
  changed: (points) => send({ kind: "transfer", points }),
  gesture: (begins) => send({ kind: "gesture", begins }),
  chosen: (point) => panels?.point(point),
});
let panels = null;
panels = new Panels({ send, curve, size: () => picture.size });
panels.point(null);

// Window and level: what the points were when the drag began.
const windowing = { from: null, width: 0, level: 0 };
function windowed(phase, dx, dy) {
  if (phase === "begin") Object.assign(windowing, { from: curve.points, width: 0, level: 0 });
  if (phase !== "move" || !windowing.from?.length) return;
  windowing.width += dx;
  windowing.level -= dy;
  curve.windowed(windowing.from, Math.exp(2 * windowing.width), windowing.level * (range[1] - range[0]));
}

const errorMap = new ErrorMap({ canvas: byId("errors"), rests, opened: () => curtain.choose("", "") });
// The map is that of the first picture, and would lie over the second.
const curtain = new Curtain({ canvas: byId("second"), rests, opened: () => errorMap.on && errorMap.toggle() });
const ray = new RayPanel({ picture, rests, second: (place) => curtain.settingAt(place) });
const questions = [errorMap, ray, curtain];
const slices = new Slices({ windows: () => tool === "window", moved: () => redraw() });

const cropBox = new CropBox(byId("crop-box"), { picture: canvas, send });
const pick = new Pick({ marked: (value) => curve.mark(value) });
const open = new OpenPanel({ failed: (text) => toast(text) });

/** Asks a pixel; the crosshair of the slices goes to what is seen there. */
async function asked(place) {
  ray.open(place);
  const found = slices.isOpen ? await pick.once(place) : null;
  if (found) slices.moveTo(found.at);
}

new Hands(canvas, { send, tool: () => tool, windowed, hovered: (place) => pick.at(place), asked });

const connection = new Connection({
  open() {
    byId("curtain").hidden = true;
    if (picture.size[0] > 0) send({ kind: "size", size: picture.size });
  },
  closed(isBye, reason) {
    byId("curtain-text").textContent = isLocal
      ? `The program in this page has ended: ${reason}. Load the page anew.`
      : isBye
      ? "The program has ended. Start vr view again; this page does the rest if it comes back at this address."
      : "The program does not answer. This page connects again by itself.";
    byId("curtain").hidden = false;
  },
  hello(message) {
    client = message.client;
  },
  opened({ opened }) {
    range = opened.range;
    marks.opened = opened;
    curve.open(opened);
    panels.open(opened);
    slices.open(opened);
    cropBox.open(opened);
    redraw();
  },
  state({ state }) {
    panels.show(state, state.by?.[0] === client);
    curtain.offer(state);
    cropBox.show(state.clip);
  },
  async picture(head, bytes, since) {
    if (!(await picture.show(head, bytes))) return;
    status.picture(head, since);
    for (const question of questions) question.shown(head);
    panels.look(head.camera);
    redraw();
  },
  error(message) {
    status.error(message);
    if (!status.head) return;
    for (const question of questions) question.shown(status.head);
  },
  problem: ({ reason }) => status.problem(reason),
  refused: ({ reason }) => toast(reason),
});

function redraw() {
  ray.mark();
  if (!picture.head) return;
  cropBox.draw(picture.head.camera);
  marks.draw(picture.head.camera, canvas.clientHeight, slices.shown);
}

/** True if no better picture of this scene is to come. */
function rests() {
  const { head } = status;
  return head?.stage === "proven" || (head?.stage === "measured" && !panels.state?.render.max_error);
}

// One message at a time, gone after a while.
let fading = 0;
function toast(text) {
  byId("toast").textContent = text;
  byId("toast").hidden = false;
  clearTimeout(fading);
  fading = setTimeout(() => (byId("toast").hidden = true), 6000);
}

function choose(name) {
  tool = name;
  canvas.dataset.tool = name;
  for (const button of document.querySelectorAll("[data-tool]")) {
    if (button.tagName === "BUTTON") button.setAttribute("aria-pressed", String(button.dataset.tool === name));
  }
}
for (const button of document.querySelectorAll("button[data-tool]")) button.addEventListener("click", () => choose(button.dataset.tool));
choose("turn");

function togglePanel(shows = document.body.classList.contains("no-panel")) {
  document.body.classList.toggle("no-panel", !shows);
  byId("panel-toggle").setAttribute("aria-expanded", String(shows));
  byId("panel").inert = !shows;
}
byId("panel-toggle").addEventListener("click", () => togglePanel());
// On a narrow screen the picture comes first.
if (window.matchMedia("(max-width: 640px)").matches) togglePanel(false);

byId("undo").addEventListener("click", () => send({ kind: "undo" }));
byId("redo").addEventListener("click", () => send({ kind: "redo" }));
byId("fit").addEventListener("click", () => send({ kind: "fit" }));
byId("fullscreen").addEventListener("click", () => {
  if (document.fullscreenElement) document.exitFullscreen();
  else document.documentElement.requestFullscreen?.().catch(() => toast("the browser allows no fullscreen here"));
});

const SIDES = ["front", "back", "left", "right", "top", "bottom"];
window.addEventListener("keydown", (event) => {
  const isTyping = event.target.matches?.("input:not([type=range]):not([type=checkbox]), select");
  if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !isTyping) {
    event.preventDefault();
    send({ kind: event.shiftKey ? "redo" : "undo" });
    return;
  }
  if (isTyping || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "Escape" && !byId("help").open) ray.close();
  const side = SIDES[Number(event.key) - 1];
  if (side) send({ kind: "side", side });
  const acts = {
    f: () => send({ kind: "fit" }),
    r: () => send({ kind: "reset-camera" }),
    o: () => byId("perspective").click(),
    t: () => choose("turn"),
    m: () => choose("move"),
    z: () => choose("zoom"),
    w: () => choose("window"),
    e: () => errorMap.toggle(),
    c: () => curtain.toggle(),
    i: () => ray.open([0, 0]),
    s: () => slices.toggle(),
    b: () => cropBox.toggle(),
    p: () => togglePanel(),
    "?": () => byId("help").showModal(),
  };
  acts[event.key]?.();
});

window.addEventListener("resize", redraw);

// For tests and for the curious: what is on the screen, and how fast it came.
window.vr = { status, picture, curve, errorMap, ray, curtain, slices, marks, cropBox, pick, open, send, ask, get rests() { return rests(); } };

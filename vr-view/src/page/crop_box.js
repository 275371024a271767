// Crop box in the picture: its edges, and a handle on each face, which is dragged or moved by keys.

import { short } from "./color.js";
import { projected, svg } from "./marks.js";

const byId = (id) => document.getElementById(id);

const AXES = ["x", "y", "z"];
/** Share of the volume's extent that a key moves a face by, and that is left between two faces. */
const KEY_STEP = 0.01;
const PAGE_STEP = 0.1;
const MIN_SHARE = 0.005;
/** Pixels from the rim of the picture within which every handle stays, so that a face that is out of sight can be taken hold of. */
const RIM = 18;
/** Pixels of a face's way for those of a way across the view, below which the way is too short to be followed: up and down count then. */
const MIN_SLANT = 0.2;

export class CropBox {
  /** `send(edit)` sends; `element` lies over the picture, `picture` is the canvas below it. */
  constructor(element, { picture, send }) {
    Object.assign(this, { element, picture, send });
    this.opened = null;
    this.camera = null;
    /** Lower and upper corner as they are shown. */
    this.corners = null;
    this.dragged = null;
    this.scheduled = false;
    this.edges = Array.from({ length: 12 }, () => svg("line", { class: "edge" }, element));
    this.handles = AXES.flatMap((name, axis) => [0, 1].map((end) => this.handle(name, axis, end)));
    byId("crop-handles").addEventListener("change", () => this.shown());
  }

  get isOpen() {
    return byId("crop-handles").checked;
  }

  toggle() {
    byId("crop-handles").checked = !this.isOpen;
    this.shown();
  }

  shown() {
    this.element.toggleAttribute("hidden", !this.isOpen);
    this.draw(this.camera);
  }

  handle(name, axis, end) {
    const label = `${end ? "Upper" : "Lower"} end of ${name}`;
    const handle = svg("g", { class: `handle axis-${axis}`, role: "slider", tabindex: 0, "aria-label": label }, this.element);
    // More than is seen can be touched.
    svg("circle", { class: "touch", r: 15 }, handle);
    svg("circle", { class: "knob", r: 7 }, handle);
    svg("title", {}, handle, `${label}: drag, or arrow keys`);
    handle.addEventListener("pointerdown", (event) => this.down(event, handle, axis, end));
    handle.addEventListener("pointermove", (event) => this.move(event));
    for (const kind of ["pointerup", "pointercancel"]) handle.addEventListener(kind, () => this.up());
    handle.addEventListener("keydown", (event) => this.key(event, axis, end));
    handle.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.picture.dispatchEvent(new WheelEvent("wheel", event));
    }, { passive: false });
    return { handle, axis, end };
  }

  open(opened) {
    this.opened = opened;
    if (this.clip) this.show(this.clip);
  }

  /** Shows the box of a scene after a change; one that is dragged stays under the hand. */
  show(clip) {
    this.clip = clip;
    if (!this.opened || this.dragged) return;
    const [low, high] = this.opened.bounds;
    const [from, to] = clip.box ?? this.opened.bounds;
    // A box may be larger than the volume.
    this.corners = [from.map((x, k) => Math.max(x, low[k])), to.map((x, k) => Math.min(x, high[k]))];
    this.draw(this.camera);
  }

  /** Place of a point of the world in CSS pixels; null behind the eye. */
  place(camera, point) {
    const at = projected(camera, point);
    const { clientWidth: width, clientHeight: height } = this.picture;
    return at && [width / 2 + at[0] * height, height / 2 - at[1] * height];
  }

  /** Middle of a face. */
  middle(corners, axis, end) {
    return corners[0].map((low, k) => (k === axis ? corners[end][k] : (low + corners[1][k]) / 2));
  }

  draw(camera) {
    this.camera = camera;
    if (!this.isOpen || !camera || !this.corners) return;
    const corner = (i) => this.place(camera, [0, 1, 2].map((k) => this.corners[(i >> k) & 1][k]));
    let edge = 0;
    for (const axis of [0, 1, 2]) {
      for (let i = 0; i < 8; i += 1) {
        if ((i >> axis) & 1) continue;
        const ends = [corner(i), corner(i | (1 << axis))];
        const line = this.edges[edge];
        edge += 1;
        line.toggleAttribute("hidden", !ends.every(Boolean));
        if (!ends.every(Boolean)) continue;
        for (const [key, value] of Object.entries({ x1: ends[0][0], y1: ends[0][1], x2: ends[1][0], y2: ends[1][1] })) line.setAttribute(key, value);
      }
    }
    const [low, high] = this.opened.bounds;
    const unit = this.opened.unit ?? (this.opened.patient ? "mm" : "");
    // What lies over the picture is above the handles.
    const top = Math.max(byId("top").getBoundingClientRect().bottom - this.picture.getBoundingClientRect().top, 0);
    const ends = [[0, this.picture.clientWidth], [top, this.picture.clientHeight]];
    for (const { handle, axis, end } of this.handles) {
      const at = this.place(camera, this.middle(this.corners, axis, end));
      handle.toggleAttribute("hidden", !at);
      const [x, y] = (at ?? [0, 0]).map((place, k) => Math.max(Math.min(place, ends[k][1] - RIM), ends[k][0] + RIM));
      if (at) handle.setAttribute("transform", `translate(${x} ${y})`);
      const now = this.corners[end][axis];
      const told = { "aria-valuemin": low[axis], "aria-valuemax": high[axis], "aria-valuenow": now, "aria-valuetext": `${short(now)} ${unit}`.trim() };
      for (const [key, value] of Object.entries(told)) handle.setAttribute(key, value);
    }
  }

  down(event, handle, axis, end) {
    if (event.button !== 0 || !this.corners || this.dragged) return;
    event.preventDefault();
    handle.focus({ preventScroll: true });
    handle.setPointerCapture(event.pointerId);
    const from = this.corners[end][axis];
    this.dragged = { axis, end, from, x: event.clientX, y: event.clientY, way: this.way(axis, end) };
    this.send({ kind: "gesture", begins: true });
  }

  /** Pixels to the right and down that a face moves by for each length of the world. */
  way(axis, end) {
    const { camera, corners } = this;
    const [low, high] = this.opened.bounds;
    const step = 0.005 * (high[axis] - low[axis]);
    const middle = this.middle(corners, axis, end);
    const moved = (by) => this.place(camera, middle.map((x, k) => (k === axis ? x + by : x)));
    const [a, b] = [moved(-step), moved(step)];
    const way = a && b ? [(b[0] - a[0]) / (2 * step), (b[1] - a[1]) / (2 * step)] : [0, 0];
    const across = this.picture.clientHeight / camera.height;
    if (Math.hypot(...way) >= MIN_SLANT * across) return way;
    // Up is away from the eye.
    return [0, camera.forward[axis] > 0 ? -across : across];
  }

  move(event) {
    if (!this.dragged) return;
    const { axis, end, from, x, y, way } = this.dragged;
    const along = (event.clientX - x) * way[0] + (event.clientY - y) * way[1];
    this.put(axis, end, from + along / (way[0] ** 2 + way[1] ** 2));
  }

  up() {
    if (!this.dragged) return;
    if (this.scheduled) this.flush();
    this.dragged = null;
    this.send({ kind: "gesture", begins: false });
  }

  key(event, axis, end) {
    if (!this.corners || event.altKey || event.ctrlKey || event.metaKey) return;
    const [low, high] = this.opened.bounds.map((corner) => corner[axis]);
    const steps = { ArrowLeft: -KEY_STEP, ArrowDown: -KEY_STEP, ArrowRight: KEY_STEP, ArrowUp: KEY_STEP, PageDown: -PAGE_STEP, PageUp: PAGE_STEP, Home: -1, End: 1 };
    const step = steps[event.key];
    if (step === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    this.put(axis, end, this.corners[end][axis] + step * (high - low));
  }

  /** Moves a face, as far as the volume goes, and not past the other one. */
  put(axis, end, value) {
    const [low, high] = this.opened.bounds.map((corner) => corner[axis]);
    const gap = MIN_SHARE * (high - low);
    const [least, most] = end === 0 ? [low, this.corners[1][axis] - gap] : [this.corners[0][axis] + gap, high];
    this.corners = this.corners.map((corner) => [...corner]);
    this.corners[end][axis] = Math.min(Math.max(value, Math.min(least, high)), Math.max(most, low));
    this.draw(this.camera);
    if (this.scheduled) return;
    this.scheduled = true;
    requestAnimationFrame(() => this.scheduled && this.flush());
  }

  flush() {
    this.scheduled = false;
    const isWhole = this.corners.every((corner, end) => corner.every((x, k) => x === this.opened.bounds[end][k]));
    this.send({ kind: "crop", corners: isWhole ? null : this.corners });
  }
}

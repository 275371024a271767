// One slice: its pixels in grey by window and level, the labels over them in their colours, and the crosshair.

import { encoded, short } from "./color.js";
import { ask, takenApart } from "./connection.js";
import { svg } from "./marks.js";

/** Most pixels along a side that are asked for. */
const MAX_SIDE = 512;
/** Milliseconds after which a slice on its way is given up for a newer one: a quick one is waited for, so that something is seen while a hand moves. */
const PATIENCE = 150;
/** Part of a pixel's colour that is its label's. */
const LABEL = 0.45;
/** What slices across each axis are called, in a patient and elsewhere. */
export const NAMES = { patient: ["Sagittal", "Coronal", "Axial"], own: ["Across x", "Across y", "Across z"] };

export class SliceView {
  /**
   * `owner` has the crosshair and the window. `failed(text)` is told what went wrong.
   */
  constructor(axis, { owner, failed }) {
    Object.assign(this, { axis, owner, failed });
    this.slice = null;
    this.wanted = null;
    this.waits = null;
    const find = (part) => document.getElementById(`slice-${axis}-${part}`);
    this.frame = find("frame");
    this.canvas = find("canvas");
    this.cross = find("cross");
    this.caption = find("caption");
    this.title = find("title");
    new ResizeObserver(() => this.layout()).observe(this.frame);
    this.bind();
  }

  bind() {
    const { canvas, owner } = this;
    let drag = null;
    canvas.addEventListener("pointerdown", (event) => {
      if (!this.slice) return;
      canvas.setPointerCapture(event.pointerId);
      canvas.focus({ preventScroll: true });
      event.preventDefault();
      const windows = event.button === 2 || event.shiftKey || owner.windows();
      drag = { windows, x: event.clientX, y: event.clientY, from: [...owner.window] };
      if (!windows) owner.moveTo(this.placeAt(event));
    });
    canvas.addEventListener("pointermove", (event) => {
      this.hover(event);
      if (!drag) return;
      if (!drag.windows) {
        owner.moveTo(this.placeAt(event));
        return;
      }
      const { clientWidth, clientHeight } = canvas;
      owner.windowed(drag.from, (event.clientX - drag.x) / clientWidth, (event.clientY - drag.y) / clientHeight);
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (drag = null));
    canvas.addEventListener("pointerleave", () => this.caption.replaceChildren());
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.turned = (this.turned ?? 0) + event.deltaY * (event.deltaMode === 1 ? 40 : 1);
      const count = Math.trunc(this.turned / 40);
      if (count === 0) return;
      this.turned -= 40 * count;
      owner.step(this.axis, -Math.max(Math.min(count, 5), -5));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      if (event.altKey || event.ctrlKey || event.metaKey || !this.slice) return;
      const way = { ArrowLeft: ["right", -1], ArrowRight: ["right", 1], ArrowUp: ["down", -1], ArrowDown: ["down", 1] }[event.key];
      const through = { PageUp: 1, PageDown: -1 }[event.key];
      if (through) owner.step(this.axis, through);
      else if (way) {
        const [axis, sign] = along(this.slice[way[0]]);
        owner.step(axis, sign * way[1]);
      } else return;
      event.preventDefault();
      event.stopPropagation();
    });
  }

  /** Share of the way across and down at a pointer. */
  shareAt({ clientX, clientY }) {
    const box = this.canvas.getBoundingClientRect();
    return [(clientX - box.left) / box.width, (clientY - box.top) / box.height].map((t) => Math.min(Math.max(t, 0), 1));
  }

  /** World position at a pointer. */
  placeAt(event) {
    const { corner, right, down } = this.slice;
    const [across, downward] = this.shareAt(event);
    return corner.map((c, k) => c + across * right[k] + downward * down[k]);
  }

  /** Says the value under the pointer, and its label. */
  hover(event) {
    if (!this.slice) return;
    const [width, height] = this.slice.size;
    const [across, downward] = this.shareAt(event);
    const index = Math.min(Math.floor(downward * height), height - 1) * width + Math.min(Math.floor(across * width), width - 1);
    const value = this.slice.values[index];
    const label = this.slice.labels[(this.slice.indices[index] ?? 0) - 1];
    const words = [Number.isNaN(value) ? "no value" : short(value), ...(label ? [label.name ?? `label ${label.number}`] : [])];
    this.caption.textContent = words.join(" · ");
  }

  /** Asks for the slice through the crosshair, unless it is there; `always` where the volume is another one. */
  ask(always = false) {
    const at = this.owner.crosshair[this.axis];
    if (!always && this.wanted === at) return this.drawCross();
    this.wanted = at;
    if (!always && this.waits && performance.now() - this.waits.since < PATIENCE) return;
    this.waits?.abort.abort();
    this.fetch();
  }

  async fetch() {
    const own = { since: performance.now(), abort: new AbortController() };
    this.waits = own;
    const at = this.wanted;
    const box = this.frame.getBoundingClientRect();
    const side = Math.min(Math.max(Math.round(Math.max(box.width, box.height) * window.devicePixelRatio), 64), MAX_SIDE);
    try {
      const query = new URLSearchParams({ axis: this.axis, at, side });
      const response = await ask(`slice?${query}`, { signal: own.abort.signal });
      if (!response.ok) throw new Error((await response.text()).trim());
      const data = await response.arrayBuffer();
      if (this.waits !== own) return;
      const { head, bytes } = takenApart(data);
      const count = head.size[0] * head.size[1];
      // Numbers begin at any byte of the message; their own buffer begins at one that suits them.
      const rest = data.slice(bytes.byteOffset);
      this.slice = { ...head, values: new Float32Array(rest, 0, count), indices: rest.byteLength > 4 * count ? new Uint16Array(rest, 4 * count, count) : [] };
      this.layout();
      this.draw();
    } catch (error) {
      if (this.waits === own && error.name !== "AbortError") this.failed(error.message);
    }
    if (this.waits !== own) return;
    this.waits = null;
    if (this.wanted !== at && this.owner.isOpen) this.fetch();
  }

  /** Gives up what is on its way. */
  close() {
    this.waits?.abort.abort();
    this.waits = null;
    this.wanted = null;
  }

  /** Makes the slice as large as its frame allows, in its own proportions. */
  layout() {
    if (!this.slice) return;
    const length = (v) => Math.hypot(...v) || 1e-9;
    const [wide, tall] = [length(this.slice.right), length(this.slice.down)];
    const scale = Math.min(this.frame.clientWidth / wide, this.frame.clientHeight / tall);
    for (const element of [this.canvas, this.cross]) {
      element.style.width = `${Math.max(Math.round(scale * wide), 1)}px`;
      element.style.height = `${Math.max(Math.round(scale * tall), 1)}px`;
    }
    this.drawCross();
  }

  /** Draws the pixels by window and labels. */
  draw() {
    if (!this.slice) return;
    const { size, values, indices, labels } = this.slice;
    const [low, high] = this.owner.window;
    [this.canvas.width, this.canvas.height] = size;
    const image = new ImageData(...size);
    const scale = 255 / Math.max(high - low, Number.MIN_VALUE);
    const colors = labels.map(({ color }) => color.map((c) => 255 * encoded(c)));
    for (let i = 0; i < values.length; i += 1) {
      const grey = Math.min(Math.max((values[i] - low) * scale, 0), 255);
      const isVacuum = Number.isNaN(values[i]);
      const color = colors[(indices[i] ?? 0) - 1];
      for (let c = 0; c < 3; c += 1) {
        const base = isVacuum ? 0 : grey;
        image.data[4 * i + c] = color ? base + LABEL * (color[c] - base) : base;
      }
      image.data[4 * i + 3] = isVacuum && !color ? 0 : 255;
    }
    this.canvas.getContext("2d").putImageData(image, 0, 0);
    this.drawCross();
  }

  /** Draws the crosshair, in the colours of the slices that its lines stand for, and the letters of the sides. */
  drawCross() {
    const { slice, cross, owner } = this;
    if (!slice) return;
    const { corner, right, down } = slice;
    const [width, height] = [parseFloat(cross.style.width), parseFloat(cross.style.height)];
    cross.setAttribute("viewBox", `0 0 ${width} ${height}`);
    cross.replaceChildren();
    const share = (way) => {
      const [axis] = along(way);
      return way[axis] === 0 ? 0.5 : (owner.crosshair[axis] - corner[axis]) / way[axis];
    };
    const [x, y] = [share(right) * width, share(down) * height];
    svg("line", { class: `cross axis-${along(right)[0]}`, x1: x, x2: x, y1: 0, y2: height }, cross);
    svg("line", { class: `cross axis-${along(down)[0]}`, x1: 0, x2: width, y1: y, y2: y }, cross);
    const letters = owner.letters;
    const name = (way, sign) => {
      const [axis, along_] = along(way);
      return letters[axis][sign * along_ > 0 ? 1 : 0];
    };
    const places = [[right, -1, 8, height / 2], [right, 1, width - 8, height / 2], [down, -1, width / 2, 12], [down, 1, width / 2, height - 5]];
    for (const [way, sign, lx, ly] of places) svg("text", { class: "letter", x: lx, y: ly }, cross, name(way, sign));
  }
}

/** The axis that a vector goes along, and its sign there. */
function along(vector) {
  const axis = vector.reduce((best, c, k) => (Math.abs(c) > Math.abs(vector[best]) ? k : best), 0);
  return [axis, Math.sign(vector[axis]) || 1];
}

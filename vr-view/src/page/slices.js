// Slices: three of them through one place, beside the picture.

import { short } from "./color.js";
import { ask } from "./connection.js";
import { names } from "./marks.js";
import { NAMES, SliceView } from "./slice_view.js";

const byId = (id) => document.getElementById(id);

/** Shares of the voxels below and above the window at first. */
const TAILS = [0.01, 0.995];

export class Slices {
  /** `windows()` is true if a drag sets window and level; `moved()` is called when the crosshair, or whether it is shown, changes. */
  constructor({ windows, moved }) {
    Object.assign(this, { windows, moved });
    this.isOpen = false;
    this.opened = null;
    this.crosshair = [0, 0, 0];
    this.window = [0, 1];
    this.place = null;
    const failed = (text) => (byId("slices-text").textContent = text);
    this.views = [2, 1, 0].map((axis) => new SliceView(axis, { owner: this, failed }));
    byId("slices-toggle").addEventListener("click", () => this.toggle());
    byId("slices-window").addEventListener("click", () => this.resetWindow());
    byId("slices-mark").addEventListener("change", () => this.moved());
    for (const [id, end] of [["window-low", 0], ["window-high", 1]]) {
      byId(id).addEventListener("change", ({ target }) => {
        if (!Number.isFinite(target.valueAsNumber)) return;
        const next = [...this.window];
        next[end] = target.valueAsNumber;
        this.setWindow(next);
      });
    }
  }

  /** Letters at the ends of each axis. */
  get letters() {
    return names(this.opened?.patient);
  }

  /** The crosshair in the world, where it is to be seen in the picture; null elsewhere. */
  get shown() {
    return this.isOpen && this.opened && byId("slices-mark").checked ? this.crosshair : null;
  }

  /** Shows what was opened. */
  open(opened) {
    const isFirst = this.opened === null;
    const [low, high] = opened.bounds;
    this.opened = opened;
    // A place that both volumes have is kept.
    const isInside = this.crosshair.every((c, k) => c >= low[k] && c <= high[k]);
    if (isFirst || !isInside) this.crosshair = low.map((c, k) => (c + high[k]) / 2);
    const called = opened.patient ? NAMES.patient : NAMES.own;
    for (const view of this.views) {
      view.title.textContent = called[view.axis];
      view.canvas.setAttribute("aria-label", `${called[view.axis]} slice. Arrow keys move the crosshair, page up and page down step through.`);
    }
    this.resetWindow();
    if (this.isOpen) this.show(true);
  }

  toggle() {
    this.isOpen = !this.isOpen;
    document.body.classList.toggle("with-slices", this.isOpen);
    byId("slices").hidden = !this.isOpen;
    byId("slices-toggle").setAttribute("aria-pressed", String(this.isOpen));
    if (this.isOpen) this.show(true);
    else for (const view of this.views) view.close();
    this.moved();
  }

  /** Asks for what the crosshair needs: slices that are there stay. */
  show(always = false) {
    if (!this.opened) return;
    for (const view of this.views) view.ask(always);
    this.tell();
    this.moved();
  }

  /** Moves the crosshair to a place in the world. */
  moveTo(place) {
    const [low, high] = this.opened.bounds;
    this.crosshair = place.map((c, k) => Math.min(Math.max(c, low[k]), high[k]));
    if (this.isOpen) this.show();
  }

  /** Moves the crosshair by a number of slices along an axis. */
  step(axis, count) {
    const place = [...this.crosshair];
    place[axis] += count * this.opened.steps[axis];
    this.moveTo(place);
  }

  setWindow([low, high]) {
    if (!(high > low)) high = low + Math.abs(low) * 1e-6 + 1e-12;
    this.window = [low, high];
    for (const [id, end] of [["window-low", 0], ["window-high", 1]]) {
      if (document.activeElement !== byId(id)) byId(id).value = Number(this.window[end].toPrecision(5));
    }
    for (const view of this.views) view.draw();
  }

  /** The window after a drag: sideways for its width, up and down for its level. */
  windowed([low, high], across, downward) {
    const middle = (low + high) / 2 + downward * (high - low);
    const half = ((high - low) / 2) * Math.exp(2 * across);
    this.setWindow([middle - half, middle + half]);
  }

  /** The window over all values but the rarest. */
  resetWindow() {
    const { range: [low, high], histogram } = this.opened;
    const total = histogram.reduce((sum, n) => sum + n, 0);
    let [sum, from, to] = [0, 0, histogram.length];
    histogram.forEach((n, i) => {
      if (sum + n <= TAILS[0] * total) from = i + 1;
      sum += n;
      if (sum >= TAILS[1] * total) to = Math.min(to, i + 1);
    });
    const value = (i) => low + (i / Math.max(histogram.length, 1)) * (high - low);
    this.setWindow(total > 0 && from < to ? [value(from), value(to)] : [low, high]);
  }

  /** Says value and label under the crosshair; while one answer is on its way, only the newest place waits. */
  async tell() {
    if (this.telling) {
      this.asksAgain = true;
      return;
    }
    this.telling = true;
    const [x, y, z] = this.crosshair;
    try {
      const response = await ask(`place?${new URLSearchParams({ x, y, z })}`);
      if (!response.ok) throw new Error((await response.text()).trim());
      this.place = await response.json();
      const { value, label } = this.place;
      const unit = this.opened.unit ?? (this.opened.patient ? "mm" : "");
      const words = [value === null ? "no value here" : `value ${short(value)}`];
      if (label) words.push(label.name ?? `label ${label.number}`);
      byId("slices-text").textContent = `${words.join(", ")} at ${[x, y, z].map(short).join(", ")} ${unit}`.trim();
    } catch (error) {
      byId("slices-text").textContent = error.message;
    }
    this.telling = false;
    if (this.asksAgain) {
      this.asksAgain = false;
      this.tell();
    }
  }
}

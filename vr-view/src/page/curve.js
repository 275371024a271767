// The curve: opacity and colours over the values, with their histogram behind it.

import { hex, short } from "./color.js";
import { svg } from "./marks.js";

/** Opacities are drawn by their square root: those of fog are small, and matter. */
const height = (opacity) => Math.sqrt(opacity);
const opacityAt = (y) => Math.min(Math.max(y, 0), 1) ** 2;

/** Margin around the drawing, in pixels: handles stick out. */
const EDGE = 9;
/** Pixels within which a handle is taken. */
const NEAR = 14;
/** Steps of a line between two points: straight in opacity, curved as drawn. */
const STEPS = 12;

const copy = (points) => points.map((p) => ({ ...p, color: [...p.color] }));

export class Curve {
  /** `changed(points)` is called with each change; `gesture(begins)` around drags; `chosen(point)` with the point that is chosen, or null. */
  constructor(element, { changed, gesture, chosen }) {
    Object.assign(this, { element, changed, gesture, chosen });
    this.points = [];
    this.range = [0, 1];
    this.histogram = [];
    this.isLogarithmic = true;
    this.selected = -1;
    this.marked = null;
    this.drag = null;
    /** Size of the drawing in pixels. Kept, since reading the element's size between changes makes the browser lay out the page each time. */
    this.box = { width: 1, height: 1 };
    element.addEventListener("pointerdown", (e) => this.down(e));
    element.addEventListener("pointermove", (e) => this.move(e));
    for (const end of ["pointerup", "pointercancel"]) element.addEventListener(end, () => this.up());
    element.addEventListener("dblclick", (e) => this.add(this.at(e)));
    element.addEventListener("keydown", (e) => this.key(e));
    new ResizeObserver(() => this.resized()).observe(element);
  }

  get isDragged() {
    return this.drag !== null;
  }

  open({ range, histogram }) {
    this.range = range[0] < range[1] ? range : [range[0] - 0.5, range[0] + 0.5];
    this.histogram = histogram;
    this.draw();
  }

  set(points) {
    this.points = copy(points);
    this.select(Math.min(this.selected, points.length - 1));
  }

  select(index) {
    this.selected = index;
    this.draw();
    this.chosen(this.points[index] ?? null);
  }

  /** Takes over the size of the element. */
  resized() {
    const { clientWidth, clientHeight } = this.element;
    this.box = { width: Math.max(clientWidth - 2 * EDGE, 1), height: Math.max(clientHeight - 2 * EDGE, 1) };
    this.draw();
  }

  /** Places of a point in the drawing; one beyond the values of the volume lies on the rim. */
  x(value) {
    const t = (value - this.range[0]) / (this.range[1] - this.range[0]);
    return EDGE + Math.min(Math.max(t, 0), 1) * this.box.width;
  }

  y(opacity) {
    return EDGE + (1 - height(opacity)) * this.box.height;
  }

  /** Value and opacity at a pointer. */
  at(event) {
    const box = this.element.getBoundingClientRect();
    const t = (event.clientX - box.left - EDGE) / this.box.width;
    const y = 1 - (event.clientY - box.top - EDGE) / this.box.height;
    return { value: this.range[0] + Math.min(Math.max(t, 0), 1) * (this.range[1] - this.range[0]), opacity: opacityAt(y) };
  }

  nearest(event) {
    const box = this.element.getBoundingClientRect();
    const [px, py] = [event.clientX - box.left, event.clientY - box.top];
    let [best, distance] = [-1, NEAR];
    this.points.forEach((p, i) => {
      const d = Math.hypot(this.x(p.value) - px, this.y(p.opacity) - py);
      // Of two that lie on each other, the later one can be drawn apart to the right.
      if (d <= distance) [best, distance] = [i, d];
    });
    return best;
  }

  down(event) {
    if (event.button !== 0 || this.points.length === 0) return;
    event.preventDefault();
    this.element.focus({ preventScroll: true });
    this.element.setPointerCapture(event.pointerId);
    const index = this.nearest(event);
    const start = this.at(event);
    if (index >= 0) {
      this.drag = { indices: [index], start, from: copy(this.points) };
    } else {
      // The line between two points moves both up and down.
      const next = this.points.findIndex((p) => p.value > start.value);
      const indices = next < 0 ? [this.points.length - 1] : next === 0 ? [0] : [next - 1, next];
      this.drag = { indices, start, from: copy(this.points), vertical: true };
    }
    this.gesture(true);
    this.select(index >= 0 ? index : this.selected);
  }

  move(event) {
    if (!this.drag) {
      this.element.style.cursor = this.nearest(event) >= 0 ? "grab" : "ns-resize";
      return;
    }
    const { indices, start, from, vertical } = this.drag;
    const now = this.at(event);
    const points = copy(from);
    for (const i of indices) {
      points[i].opacity = opacityAt(height(from[i].opacity) + height(now.opacity) - height(start.opacity));
      if (!vertical) {
        points[i].value = this.between(points, i, now.value);
        points[i].opacity = now.opacity;
      }
    }
    this.points = points;
    this.draw();
    this.chosen(this.points[this.selected] ?? null);
    this.later();
  }

  up() {
    if (!this.drag) return;
    this.drag = null;
    this.changed(copy(this.points));
    this.scheduled = false;
    this.gesture(false);
  }

  /** Tells of a change with the next picture of the screen. */
  later() {
    if (this.scheduled) return;
    this.scheduled = true;
    requestAnimationFrame(() => {
      if (!this.scheduled) return;
      this.scheduled = false;
      this.changed(copy(this.points));
    });
  }

  /** A value kept between those of the neighbours; at one of them it makes a jump. */
  between(points, i, value) {
    const low = points[i - 1]?.value ?? -Infinity;
    const high = points[i + 1]?.value ?? Infinity;
    return Math.min(Math.max(value, low), high);
  }

  /** Adds a point on the curve's colours. */
  add({ value, opacity }) {
    const next = this.points.findIndex((p) => p.value > value);
    const index = next < 0 ? this.points.length : next;
    const [a, b] = [this.points[index - 1], this.points[index]];
    const t = a && b && b.value > a.value ? (value - a.value) / (b.value - a.value) : 0;
    const near = a ?? b;
    const mixed = a && b ? a.color.map((c, k) => c + t * (b.color[k] - c)) : [...near.color];
    const emission = near.emission ? (a && b ? a.emission.map((c, k) => c + t * (b.emission[k] - c)) : near.emission) : null;
    this.points.splice(index, 0, { value, color: mixed, opacity, emission });
    this.select(index);
    this.changed(copy(this.points));
  }

  remove() {
    if (this.selected < 0 || this.points.length < 2) return;
    this.points.splice(this.selected, 1);
    this.select(Math.min(this.selected, this.points.length - 1));
    this.changed(copy(this.points));
  }

  /** A second point at the value of the chosen one: the curve jumps there. */
  jump() {
    const point = this.points[this.selected];
    if (!point) return;
    this.points.splice(this.selected + 1, 0, { ...point, color: [...point.color], opacity: point.opacity > 0.5 ? 0 : 1 });
    this.select(this.selected + 1);
    this.changed(copy(this.points));
  }

  /** Sets parts of the chosen point. */
  change(part) {
    const point = this.points[this.selected];
    if (!point) return;
    if (part.value !== undefined) part.value = this.between(this.points, this.selected, part.value);
    Object.assign(point, part);
    this.draw();
    this.changed(copy(this.points));
  }

  /** Moves all points: those of a window that is `scale` times as wide, shifted by a value. */
  windowed(from, scale, shift) {
    const [first, last] = [from[0].value, from.at(-1).value];
    const middle = (first + last) / 2;
    this.points = copy(from).map((p) => ({ ...p, value: middle + (p.value - middle) * scale + shift }));
    this.draw();
    this.later();
  }

  key(event) {
    const point = this.points[this.selected];
    const step = (this.range[1] - this.range[0]) / (event.shiftKey ? 1000 : 100);
    const rise = event.shiftKey ? 0.005 : 0.05;
    const lifted = (by) => ({ opacity: opacityAt(height(point.opacity) + by) });
    const acts = {
      Delete: () => this.remove(),
      Backspace: () => this.remove(),
      Insert: () => {
        const next = this.points[this.selected + 1] ?? this.points[this.selected - 1] ?? point;
        this.add({ value: (point.value + next.value) / 2, opacity: (point.opacity + next.opacity) / 2 });
      },
      ArrowLeft: () => this.change({ value: point.value - step }),
      ArrowRight: () => this.change({ value: point.value + step }),
      ArrowUp: () => this.change(lifted(rise)),
      ArrowDown: () => this.change(lifted(-rise)),
    }[event.key];
    if (event.key === "Tab") {
      const next = this.selected + (event.shiftKey ? -1 : 1);
      if (next < 0 || next >= this.points.length) return;
      event.preventDefault();
      this.select(next);
    } else if (acts && point) {
      event.preventDefault();
      event.stopPropagation();
      acts();
      this.chosen(this.points[this.selected] ?? null);
    }
  }

  /** Marks a value; null for none. */
  mark(value) {
    this.marked = value;
    this.draw();
  }

  draw() {
    const { element } = this;
    const { width, height: tall } = this.box;
    element.setAttribute("viewBox", `0 0 ${width + 2 * EDGE} ${tall + 2 * EDGE}`);
    element.replaceChildren();
    const floor = EDGE + tall;
    // The histogram behind it all.
    const bars = this.histogram.map((n) => (this.isLogarithmic ? Math.log1p(n) : n));
    const sorted = [...bars].sort((a, b) => a - b);
    // On a straight scale, background alone would fill it.
    const top = this.isLogarithmic ? sorted.at(-1) : sorted[Math.floor(0.985 * (sorted.length - 1))];
    if (top > 0) {
      const step = width / bars.length;
      const parts = bars.map((n, i) => `L${EDGE + i * step} ${floor - Math.min(n / top, 1) * tall}h${step}`);
      svg("path", { class: "histogram", d: `M${EDGE} ${floor}${parts.join("")}L${EDGE + width} ${floor}Z` }, element);
    }
    for (const opacity of [0.05, 0.25, 0.5, 1]) {
      svg("line", { class: "grid", x1: EDGE, x2: EDGE + width, y1: this.y(opacity), y2: this.y(opacity) }, element);
      svg("text", { class: "tick", x: EDGE + width - 2, y: this.y(opacity) + 9 }, element, String(opacity));
    }
    if (this.points.length === 0) return;
    // Colours under the curve, mixed in linear light as they are drawn.
    const definitions = svg("defs", {}, element);
    const gradient = svg("linearGradient", { id: "colors", gradientUnits: "userSpaceOnUse", x1: EDGE, x2: EDGE + width, y1: 0, y2: 0 }, definitions);
    gradient.setAttribute("color-interpolation", "linearRGB");
    for (const p of this.points) {
      svg("stop", { offset: (this.x(p.value) - EDGE) / width, "stop-color": hex(p.color) }, gradient);
    }
    const line = this.line();
    svg("path", { class: "fill", fill: "url(#colors)", d: `M${EDGE} ${floor}L${line}L${EDGE + width} ${floor}Z` }, element);
    svg("path", { class: "line", d: `M${line}` }, element);
    if (this.marked !== null) {
      svg("line", { class: "mark", x1: this.x(this.marked), x2: this.x(this.marked), y1: EDGE, y2: floor }, element);
    }
    this.points.forEach((p, i) => {
      const isOut = p.value < this.range[0] || p.value > this.range[1];
      const classes = `handle${i === this.selected ? " selected" : ""}${isOut ? " out" : ""}`;
      const handle = svg("circle", { class: classes, cx: this.x(p.value), cy: this.y(p.opacity), r: i === this.selected ? 6.5 : 5, fill: hex(p.color) }, element);
      svg("title", {}, handle, `${short(p.value)}: opacity ${short(p.opacity)}`);
    });
  }

  /** The curve as path data, without its first letter. */
  line() {
    const at = (value, opacity) => `${this.x(value).toFixed(2)} ${this.y(opacity).toFixed(2)}`;
    const [first, last] = [this.points[0], this.points.at(-1)];
    const places = [`${EDGE} ${this.y(first.opacity).toFixed(2)}`, at(first.value, first.opacity)];
    for (let i = 1; i < this.points.length; i += 1) {
      const [a, b] = [this.points[i - 1], this.points[i]];
      for (let k = 1; k <= STEPS; k += 1) {
        const t = k / STEPS;
        places.push(at(a.value + t * (b.value - a.value), a.opacity + t * (b.opacity - a.opacity)));
      }
    }
    places.push(`${EDGE + this.box.width} ${this.y(last.opacity).toFixed(2)}`);
    return places.join("L");
  }
}


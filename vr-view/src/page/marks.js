// Marks over the picture: which way is which, and how large it is.

import { short } from "./color.js";

const SVG = "http://www.w3.org/2000/svg";

/** Makes an element of SVG. */
export function svg(name, attributes, parent, text) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  parent?.append(element);
  return element;
}

/** Names of the ends of each axis: a patient's sides, or the axes themselves. */
export function names(patient) {
  return patient ? [["L", "R"], ["P", "A"], ["I", "S"]] : [["", "x"], ["", "y"], ["", "z"]];
}

/** Where a camera sees a point of the world, in heights of the picture from its middle; null behind the eye. */
export function projected({ eye, right, up, forward, height, fov }, point) {
  const local = [right, up, forward].map((axis) => axis.reduce((sum, c, k) => sum + c * (point[k] - eye[k]), 0));
  if (fov === null) return [local[0] / height, local[1] / height];
  if (local[2] <= 0) return null;
  const tall = 2 * Math.tan((fov * Math.PI) / 360) * local[2];
  return [local[0] / tall, local[1] / tall];
}

export class Marks {
  constructor(overlay) {
    this.overlay = overlay;
    this.opened = null;
    this.camera = null;
  }

  /** Draws all anew for a camera. `height` is the picture's in CSS pixels; `crosshair` a place in the world, or null. */
  draw(camera, height, crosshair) {
    this.camera = camera;
    this.overlay.replaceChildren();
    if (crosshair && this.opened) this.crosshair(crosshair, height);
    const bottom = this.overlay.getBoundingClientRect().height;
    this.marker(camera).setAttribute("transform", `translate(58 ${bottom - 52})`);
    this.bar(camera, height)?.setAttribute("transform", `translate(122 ${bottom - 18})`);
  }

  /** Draws lines through a place, along the axes, as far as the volume goes. */
  crosshair(at, height) {
    const group = svg("g", { class: "crosshair" }, this.overlay);
    const { clientWidth } = this.overlay.parentElement;
    const seen = (point) => {
      const place = projected(this.camera, point);
      return place && [clientWidth / 2 + place[0] * height, height / 2 - place[1] * height];
    };
    const [low, high] = this.opened.bounds;
    for (const axis of [0, 1, 2]) {
      const [from, to] = [low, high].map((end) => seen(at.map((c, k) => (k === axis ? end[k] : c))));
      if (from && to) svg("line", { class: `cross axis-${axis}`, x1: from[0], y1: from[1], x2: to[0], y2: to[1] }, group);
    }
    const middle = seen(at);
    if (middle) svg("circle", { class: "cross-middle", cx: middle[0], cy: middle[1], r: 4 }, group);
  }

  marker({ right, up, forward }) {
    const group = svg("g", { class: "marker" }, this.overlay);
    const ends = [0, 1, 2].flatMap((axis) => {
      const toward = -forward[axis];
      const end = { axis, x: right[axis], y: -up[axis], toward };
      return [{ ...end, sign: 1 }, { axis, x: -end.x, y: -end.y, toward: -toward, sign: -1 }];
    });
    // What is nearer is drawn over what is further.
    ends.sort((a, b) => a.toward - b.toward);
    const labels = names(this.opened?.patient);
    svg("circle", { class: "rim", r: 38, cx: 0, cy: 0 }, group);
    for (const { axis, x, y, toward, sign } of ends) {
      const label = labels[axis][sign > 0 ? 1 : 0];
      const end = svg("g", { class: `axis axis-${axis}${sign > 0 ? "" : " negative"}`, opacity: 0.55 + 0.45 * (toward + 1) / 2 }, group);
      if (sign > 0) svg("line", { x1: 0, y1: 0, x2: 26 * x, y2: 26 * y }, end);
      svg("circle", { cx: 30 * x, cy: 30 * y, r: label ? 7.5 : 3 }, end);
      if (label) svg("text", { x: 30 * x, y: 30 * y, dy: "0.35em" }, end, label);
    }
    return group;
  }

  bar({ height: world }, height) {
    if (!this.opened || !height) return null;
    // The longest round length below a third of the height.
    const most = world / 3.2;
    const power = 10 ** Math.floor(Math.log10(most));
    const length = [5, 2, 1].find((n) => n * power <= most) * power;
    const width = (length / world) * height;
    const group = svg("g", { class: "bar" }, this.overlay);
    svg("path", { d: `M0 -5V0H${width}V-5` }, group);
    svg("text", { x: width / 2, y: -8 }, group, `${short(length)} ${this.opened.unit ?? (this.opened.patient ? "mm" : "")}`.trim());
    group.dataset.width = width;
    return group;
  }
}

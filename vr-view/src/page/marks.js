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
function names(patient) {
  return patient ? [["L", "R"], ["P", "A"], ["I", "S"]] : [["", "x"], ["", "y"], ["", "z"]];
}

export class Marks {
  constructor(overlay) {
    this.overlay = overlay;
    this.opened = null;
    this.camera = null;
  }

  /** Draws both anew for a camera. `height` is the picture's in CSS pixels. */
  draw(camera, height) {
    this.camera = camera;
    this.overlay.replaceChildren();
    const bottom = this.overlay.getBoundingClientRect().height;
    this.marker(camera).setAttribute("transform", `translate(58 ${bottom - 52})`);
    this.bar(camera, height)?.setAttribute("transform", `translate(122 ${bottom - 18})`);
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

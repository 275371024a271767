// A pixel's truth: what its ray meets by depth, what the renderer and the reference make of it, and how far apart they are.

import { short } from "./color.js";
import { svg } from "./marks.js";
import { Question } from "./question.js";

const byId = (id) => document.getElementById(id);

/** Width of the plot, height of a curve and of the gap above it, in units of its viewBox. */
const [WIDTH, HEIGHT, GAP] = [320, 42, 21];

const CHANNELS = ["red", "green", "blue", "opacity"];

export class RayPanel extends Question {
  /** `picture` is on the screen; `second(place)` is the setting of a second picture that lies over it there, or null. */
  constructor({ picture, rests, second }) {
    super({ rests, say: (text) => (byId("ray-text").textContent = text) });
    Object.assign(this, { picture, second });
    /** Setting of the picture whose pixel is asked for; null for the first one. */
    this.setting = null;
    /** Place in heights of the picture from its middle; null while the panel is closed. */
    this.place = null;
    byId("ray-close").addEventListener("click", () => this.close());
  }

  get isOpen() {
    return this.place !== null;
  }

  /** Opens the panel for a place in the picture. */
  open(place) {
    this.place = place;
    this.clear();
    byId("ray").hidden = false;
    byId("ray-mark").hidden = false;
    this.mark();
    this.ask();
  }

  close() {
    if (!this.isOpen) return;
    this.place = null;
    this.clear();
    byId("ray").hidden = true;
    byId("ray-mark").hidden = true;
    this.picture.canvas.focus({ preventScroll: true });
  }

  /** Puts the mark where the pixel is. */
  mark() {
    if (!this.isOpen) return;
    const { clientWidth, clientHeight } = this.picture.canvas;
    byId("ray-mark").style.left = `${clientWidth / 2 + this.place[0] * clientHeight}px`;
    byId("ray-mark").style.top = `${clientHeight / 2 - this.place[1] * clientHeight}px`;
  }

  /** The pixel at the place, in a picture of a size. */
  pixel([width, height]) {
    const inside = (n, size) => Math.min(Math.max(Math.floor(n), 0), size - 1);
    return [inside(width / 2 + this.place[0] * height, width), inside(height / 2 - this.place[1] * height, height)];
  }

  hide() {
    byId("ray").classList.add("stale");
  }

  asking() {
    const [x, y] = this.pixel(this.picture.size);
    byId("ray-title").textContent = `Pixel ${x}, ${y}`;
    this.say("asking the reference");
    const query = new URLSearchParams({ x, y });
    this.setting = this.second(this.place);
    if (this.setting) query.set("renderer", this.setting.renderer);
    if (this.setting?.quality) query.set("quality", this.setting.quality);
    return `truth/ray?${query}`;
  }

  read(response) {
    return response.json();
  }

  /** Bytes of the pixel as the screen has it. */
  onScreen([x, y]) {
    const canvas = this.setting ? byId("second") : this.picture.canvas;
    return [...canvas.getContext("2d").getImageData(x, y, 1, 1).data.slice(0, 3)];
  }

  show({ pixel, renderer, rgba, exact, error, bound, is_proven: isProven, screen, steps, model, supersampling }) {
    byId("ray").classList.remove("stale");
    byId("ray-title").textContent = `Pixel ${pixel.join(", ")} by ${renderer}${this.setting ? ", second picture" : ""}`;
    const table = byId("ray-table");
    const row = (name, color, numbers, className) => {
      const line = document.createElement("tr");
      line.className = className;
      const head = Object.assign(document.createElement("th"), { scope: "row" });
      if (color) {
        const swatch = document.createElement("i");
        swatch.style.background = `rgb(${color.join(" ")})`;
        head.append(swatch);
      }
      head.append(name);
      line.append(head, ...numbers.map((text) => Object.assign(document.createElement("td"), { textContent: text })));
      return line;
    };
    const digits = (n) => (Math.abs(n) < 5e-5 ? "0" : n.toFixed(4));
    table.tBodies[0].replaceChildren(
      row("on the screen", this.onScreen(pixel), rgba.map(digits), ""),
      row("reference", screen[1], exact.map(digits), ""),
      row("difference, 1/255", null, error.map((e) => short(255 * e)), "difference"),
    );
    const notes = [`reference ${isProven ? "proven" : "estimated"} within ${short(bound)}`];
    notes.push(steps === null ? `${renderer} lists no steps as it draws at rest: curves are the reference's` : `${steps} steps of ${renderer}, dashed where they differ`);
    if (supersampling > 1) notes.push(`the pixel is the mean of ${supersampling}×${supersampling} rays; this is the one in the middle`);
    if (model) notes.push(`${renderer} integrates ${model}`);
    this.say(`${notes.join("; ")}.`);
    this.plot();
  }

  /** Draws the curves, one below the other, over one axis of depth. */
  plot() {
    const { parts, has_light: hasLight, renderer } = this.found;
    const plot = byId("ray-plot");
    plot.replaceChildren();
    if (parts.length === 0) {
      plot.setAttribute("viewBox", `0 0 ${WIDTH} 20`);
      plot.setAttribute("aria-label", "The ray misses the volume.");
      svg("text", { x: 0, y: 14, class: "axis-text" }, plot, "The ray misses the volume.");
      return;
    }
    const [begin, end] = [parts[0].ends[0], parts.at(-1).ends[1]];
    const x = (s) => (WIDTH * (s - begin)) / (end - begin);
    let top = 0;
    const curve = (name, [low, high], draw, unit = "") => {
      // Not the rounding of a zero.
      const [from, to] = [low, high].map((n) => short(Math.abs(n) < 1e-9 * (high - low) ? 0 : n));
      const place = (n) => top + GAP + HEIGHT * (1 - (n - low) / (high - low || 1));
      const group = svg("g", { class: `ray-curve ${name}` }, plot);
      svg("rect", { class: "frame", x: 0, y: top + GAP, width: WIDTH, height: HEIGHT }, group);
      svg("text", { class: "axis-text", x: 0, y: top + GAP - 4 }, group, `${name}${unit}`);
      svg("text", { class: "axis-text end", x: WIDTH, y: top + GAP - 4 }, group, `${from} to ${to}`);
      draw(group, place);
      top += GAP + HEIGHT;
    };
    /** A line through the middle or the end of each part; where it has no value, it is broken. */
    const line = (group, place, className, value, at = (part) => part.ends[1]) => {
      let isBroken = true;
      let path = "";
      for (const part of parts) {
        const n = value(part);
        if (n !== null) path += `${isBroken ? "M" : "L"}${x(at(part)).toFixed(1)} ${place(n).toFixed(1)}`;
        isBroken = n === null;
      }
      if (path) svg("path", { class: className, d: path }, group);
    };
    const middle = (part) => (part.ends[0] + part.ends[1]) / 2;
    const values = parts.flatMap((part) => part.values ?? []);
    if (values.length > 0) {
      curve("value", [Math.min(...values), Math.max(...values)], (group, place) => {
        line(group, place, "exact", (part) => part.values && (part.values[0] + part.values[1]) / 2, middle);
      });
    }
    const differs = parts.some((part) => part.drawn?.some((n, c) => Math.abs(n - part.exact[c]) > 1e-4));
    if (hasLight) {
      const opacities = parts.map((part) => part.opacity);
      curve("opacity", [0, Math.max(...opacities, 1e-9)], (group, place) => {
        const tops = parts.map((part) => `L${x(part.ends[0]).toFixed(1)} ${place(part.opacity).toFixed(1)}H${x(part.ends[1]).toFixed(1)}`);
        svg("path", { class: "area", d: `M0 ${place(0)}${tops.join("")}L${WIDTH} ${place(0)}Z` }, group);
      }, ` of each ${short((end - begin) / parts.length)} of depth`);
      const brightest = Math.max(...parts.flatMap((part) => [...part.exact.slice(0, 3), ...(part.drawn ?? []).slice(0, 3)]), 1e-9);
      curve("light", [0, brightest], (group, place) => {
        for (const c of [0, 1, 2]) {
          line(group, place, `exact ${CHANNELS[c]}`, (part) => part.exact[c]);
          if (differs) line(group, place, `drawn ${CHANNELS[c]}`, (part) => part.drawn?.[c] ?? null);
        }
      }, " so far: red, green, blue");
      curve("transmittance", [0, 1], (group, place) => {
        line(group, place, "exact", (part) => 1 - part.exact[3]);
        if (differs) line(group, place, "drawn", (part) => (part.drawn ? 1 - part.drawn[3] : null));
      });
    }
    svg("text", { class: "axis-text", x: 0, y: top + 14 }, plot, short(begin));
    svg("text", { class: "axis-text middle", x: WIDTH / 2, y: top + 14 }, plot, "depth along the ray");
    svg("text", { class: "axis-text end", x: WIDTH, y: top + 14 }, plot, short(end));
    plot.setAttribute("viewBox", `0 0 ${WIDTH} ${top + 18}`);
    const last = parts.at(-1);
    plot.setAttribute("aria-label", `Curves by depth from ${short(begin)} to ${short(end)}; transmittance falls from 1 to ${short(1 - last.exact[3])}${last.drawn ? `, by ${renderer} to ${short(1 - last.drawn[3])}` : ""}.`);
  }
}

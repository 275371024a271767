// Error map over the picture at rest: the pixels that were compared with the reference, coloured by how far they are from it.

import { short } from "./color.js";

const byId = (id) => document.getElementById(id);

/** Errors of the ticks of the legend, in 1/255. */
const TICKS = [0.001, 0.01, 0.1, 1, 10];
/** Side of a mark, in sides of the part of the picture that it stands for: between marks, the picture is seen. */
const MARK = 0.62;

export class ErrorMap {
  /** `rests()` is true if no better picture of this scene is to come than the one on the screen; `opened()` is called when the map is switched on. */
  constructor({ canvas, rests, opened }) {
    Object.assign(this, { canvas, rests, opened });
    this.on = false;
    this.found = null;
    /** Counts questions: an answer to any but the last one is not shown. */
    this.asked = 0;
    this.waits = false;
    byId("error-map").addEventListener("click", () => this.toggle());
  }

  toggle() {
    this.on = !this.on;
    if (this.on) this.opened();
    byId("error-map").setAttribute("aria-pressed", String(this.on));
    this.clear();
    byId("error-legend").hidden = !this.on;
    this.ask();
  }

  /** Takes away what belongs to no picture on the screen. */
  clear() {
    this.asked += 1;
    this.waits = false;
    this.found = null;
    this.canvas.hidden = true;
    byId("error-scale").hidden = true;
    byId("error-text").textContent = "waits until the picture rests";
  }

  /** A picture was shown, or more is known of it. */
  shown(head) {
    if (!this.on) return;
    if (head.stage === "draft" || head.stage === "finer") this.clear();
    else this.ask();
  }

  async ask() {
    if (!this.on || this.found || this.waits || !this.rests()) return;
    this.asked += 1;
    const turn = this.asked;
    this.waits = true;
    byId("error-text").textContent = "comparing with the reference";
    try {
      const answer = await fetch("truth/error-map");
      const text = await answer.text();
      if (turn !== this.asked) return;
      // After an edit, the next picture at rest asks again.
      if (answer.status === 409) return this.clear();
      if (!answer.ok) throw new Error(text.trim());
      this.found = JSON.parse(text);
      this.draw();
    } catch (error) {
      if (turn === this.asked) byId("error-text").textContent = error.message;
    }
  }

  draw() {
    const { size, parts, pixels, colors, renderer, rmse, max, ends, legend } = this.found;
    const { canvas } = this;
    [canvas.width, canvas.height] = size;
    canvas.hidden = false;
    const context = canvas.getContext("2d");
    context.fillStyle = "rgb(0 0 0 / 0.55)";
    context.fillRect(0, 0, ...size);
    const side = Math.max(1, Math.round(MARK * Math.min(size[0] / parts[0], size[1] / parts[1])));
    pixels.forEach(([x, y], i) => {
      context.fillStyle = `rgb(${colors[i].join(" ")})`;
      context.fillRect(x - (side >> 1), y - (side >> 1), side, side);
    });
    // The legend, its ticks, and where the largest error stands.
    const [low, high] = ends.map(Math.log10);
    const place = (error) => `${100 * Math.min(Math.max((Math.log10(error) - low) / (high - low), 0), 1)}%`;
    byId("error-bar").style.backgroundImage = `linear-gradient(to right, ${legend.map((c) => `rgb(${c.join(" ")})`).join(", ")})`;
    const ticks = TICKS.map((count) => {
      const tick = Object.assign(document.createElement("span"), { textContent: String(count) });
      tick.style.left = place(count / 255);
      return tick;
    });
    byId("error-ticks").replaceChildren(...ticks);
    byId("error-largest").style.left = place(max);
    byId("error-scale").hidden = false;
    byId("error-text").textContent =
      `largest ${short(255 * max)}/255, RMSE ${short(255 * rmse)}/255 · ${renderer}, ${pixels.length} of ${size[0] * size[1]} pixels compared`;
  }
}

// Error map over the picture at rest: the pixels that were compared with the reference, coloured by how far they are from it.

import { short } from "./color.js";
import { Question } from "./question.js";

const byId = (id) => document.getElementById(id);

/** Errors of the ticks of the legend, in 1/255. */
const TICKS = [0.001, 0.01, 0.1, 1, 10];
/** Side of a mark, in sides of the part of the picture that it stands for: between marks, the picture is seen. */
const MARK = 0.62;

export class ErrorMap extends Question {
  /** `opened()` is called when the map is switched on. */
  constructor({ canvas, rests, opened }) {
    super({ rests, say: (text) => (byId("error-text").textContent = text) });
    Object.assign(this, { canvas, opened });
    this.on = false;
    byId("error-map").addEventListener("click", () => this.toggle());
  }

  get isOpen() {
    return this.on;
  }

  toggle() {
    this.on = !this.on;
    if (this.on) this.opened();
    byId("error-map").setAttribute("aria-pressed", String(this.on));
    this.clear();
    byId("error-legend").hidden = !this.on;
    this.ask();
  }

  hide() {
    this.canvas.hidden = true;
    byId("error-scale").hidden = true;
  }

  asking() {
    this.say("comparing with the reference");
    return "truth/error-map";
  }

  read(response) {
    return response.json();
  }

  show({ size, parts, pixels, colors, renderer, rmse, max, ends, legend }) {
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
    this.say(`largest ${short(255 * max)}/255, RMSE ${short(255 * rmse)}/255 · ${renderer}, ${pixels.length} of ${size[0] * size[1]} pixels compared`);
  }
}

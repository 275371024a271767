// Curtain: the picture at rest of a second setting beside the first, with a divider between them.

import { takenApart } from "./connection.js";
import { Question } from "./question.js";
import { duration, words } from "./status.js";

const byId = (id) => document.getElementById(id);

/** Part of the width that a key moves the divider by. */
const STEP = 0.02;

export class Curtain extends Question {
  /** `opened()` is called when a setting is chosen. */
  constructor({ canvas, rests, opened }) {
    super({ rests, say: (text) => (byId("second-text").textContent = this.setting ? text : "") });
    Object.assign(this, { canvas, opened });
    /** Renderer and quality of the second picture; null where there is none. */
    this.setting = null;
    /** Renderer and quality of the first one. */
    this.own = { renderer: "", quality: null };
    /** Description of the first picture. */
    this.first = null;
    /** Place of the divider in widths of the picture. */
    this.split = 0.5;
    this.last = null;
    this.bind();
  }

  get isOpen() {
    return this.setting !== null;
  }

  bind() {
    const choose = () => this.choose(byId("second-renderer").value, byId("second-quality").value);
    byId("second-renderer").addEventListener("change", () => {
      byId("second-quality").value = "";
      choose();
    });
    byId("second-quality").addEventListener("change", choose);
    byId("beside").addEventListener("click", () => this.toggle());
    const line = byId("divider");
    const move = ({ clientX }) => {
      const box = this.canvas.getBoundingClientRect();
      this.moveTo((clientX - box.left) / box.width);
    };
    line.addEventListener("pointerdown", (event) => {
      line.setPointerCapture(event.pointerId);
      line.focus({ preventScroll: true });
      event.preventDefault();
    });
    line.addEventListener("pointermove", (event) => line.hasPointerCapture(event.pointerId) && move(event));
    line.addEventListener("keydown", (event) => {
      const to = { ArrowLeft: this.split - STEP, ArrowRight: this.split + STEP, Home: 0, End: 1 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      this.moveTo(to);
    });
  }

  /** Offers the renderers that draw the scene, and the qualities. */
  offer({ renderers, render, quality }) {
    const option = (value, text, disabled = false) => Object.assign(document.createElement("option"), { value, textContent: text, disabled });
    const chosen = this.setting?.renderer ?? "";
    byId("second-renderer").replaceChildren(option("", "nothing"), ...renderers.map(({ name, refusal }) => option(name, name, refusal !== null)));
    byId("second-renderer").value = chosen;
    byId("second-quality").disabled = chosen === "";
    this.own = { renderer: render.renderer, quality };
  }

  /** Opens the curtain for what was chosen last, at first a draft by the same renderer; or closes it. */
  toggle() {
    if (this.setting) this.choose("", "");
    else this.choose(this.last?.renderer ?? this.own.renderer, this.last?.quality ?? "draft");
  }

  choose(renderer, quality) {
    this.setting = renderer ? { renderer, quality } : null;
    this.last = this.setting ?? this.last;
    if (this.setting) this.opened();
    byId("second-renderer").value = renderer;
    byId("second-quality").value = quality;
    byId("second-quality").disabled = renderer === "";
    byId("beside").setAttribute("aria-pressed", String(this.setting !== null));
    this.clear();
    this.ask();
  }

  /** While something moves, the first is shown alone. */
  hide() {
    this.veil(true);
  }

  veil(hidden) {
    for (const id of ["second", "divider", "first-label", "second-label"]) byId(id).hidden = hidden;
  }

  /** The second picture's setting, where a place in heights from the middle lies on its side of the divider; null elsewhere. */
  settingAt([x]) {
    if (!this.setting || !this.found) return null;
    const { clientWidth, clientHeight } = this.canvas;
    return (x * clientHeight) / clientWidth + 0.5 >= this.split ? this.setting : null;
  }

  shown(head) {
    this.first = head;
    super.shown(head);
  }

  asking() {
    this.say("is drawn");
    const query = new URLSearchParams({ renderer: this.setting.renderer });
    if (this.setting.quality) query.set("quality", this.setting.quality);
    return `truth/second?${query}`;
  }

  /** The description of the picture, and the picture itself. */
  async read(response) {
    const { head, bytes } = takenApart(await response.arrayBuffer());
    const pixels = head.coding === "png" ? new Blob([bytes], { type: "image/png" }) : new ImageData(bytes, ...head.size);
    return { head, image: await createImageBitmap(pixels, { colorSpaceConversion: "none" }) };
  }

  show({ head, image }) {
    const { canvas, first } = this;
    [canvas.width, canvas.height] = head.size;
    canvas.getContext("2d").drawImage(image, 0, 0);
    const label = (id, { renderer, milliseconds, error }, name) => {
      const lines = [name ? `${renderer}, ${name}` : renderer, duration(milliseconds), words(error)];
      byId(id).replaceChildren(...lines.map((text) => Object.assign(document.createElement("span"), { textContent: text })));
      byId(id).dataset.kind = error.kind;
    };
    label("first-label", first, this.own.quality);
    label("second-label", head, this.setting.quality);
    this.say("to the right of the divider");
    this.veil(false);
    this.moveTo(this.split);
  }

  moveTo(split) {
    this.split = Math.min(Math.max(split, 0), 1);
    const percent = 100 * this.split;
    this.canvas.style.clipPath = `inset(0 0 0 ${percent}%)`;
    const line = byId("divider");
    line.style.left = `${percent}%`;
    line.setAttribute("aria-valuenow", String(Math.round(percent)));
  }
}

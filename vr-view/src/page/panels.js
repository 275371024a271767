// Panels: everything beside the picture. What the program says is shown; what a hand does is sent.

import { hex, linear, short } from "./color.js";
import { svg } from "./marks.js";

const byId = (id) => document.getElementById(id);

/** Names of qualities for people. */
const QUALITIES = { draft: "draft", normal: "normal", fine: "fine", proven: "proven" };

/** Sides of a patient that the sides of a volume are: what is to the right of the front is the patient's left. */
const PATIENT = { front: "Anterior", back: "Posterior", left: "Right", right: "Left", top: "Superior", bottom: "Inferior" };

export class Panels {
  constructor({ send, curve, size }) {
    Object.assign(this, { send, curve, size });
    this.opened = null;
    this.state = null;
    this.camera = null;
    this.baseUnit = null;
    this.bindCurve();
    this.bindLight();
    this.bindView();
    this.bindCrop();
    this.bindRenderer();
    this.bindSave();
  }

  /** Calls back while a slider moves, as one gesture, and writes its number beside it. */
  slider(input, changed, text = short) {
    const output = input.parentElement.querySelector("output");
    const write = () => {
      if (output) output.textContent = text(Number(input.value));
    };
    let moves = false;
    input.addEventListener("input", () => {
      if (!moves) this.send({ kind: "gesture", begins: true });
      moves = true;
      write();
      changed(Number(input.value));
    });
    input.addEventListener("change", () => {
      if (moves) this.send({ kind: "gesture", begins: false });
      moves = false;
    });
    return (value) => {
      if (document.activeElement === input && moves) return;
      input.value = value;
      write();
    };
  }

  bindCurve() {
    const { curve } = this;
    byId("point-color").addEventListener("input", (e) => curve.change({ color: linear(e.target.value) }));
    byId("point-value").addEventListener("change", (e) => Number.isFinite(e.target.valueAsNumber) && curve.change({ value: e.target.valueAsNumber }));
    byId("point-opacity").addEventListener("change", (e) => {
      if (Number.isFinite(e.target.valueAsNumber)) curve.change({ opacity: Math.min(Math.max(e.target.valueAsNumber, 0), 1) });
    });
    byId("point-jump").addEventListener("click", () => curve.jump());
    byId("point-remove").addEventListener("click", () => curve.remove());
    byId("log").addEventListener("change", (e) => {
      curve.isLogarithmic = e.target.checked;
      curve.draw();
    });
    byId("preset").addEventListener("change", (e) => {
      if (e.target.value === "auto") this.send({ kind: "automatic-look" });
      else if (e.target.value) this.send({ kind: "preset", name: e.target.value });
      e.target.value = "";
    });
    const times = (x) => `× ${short(10 ** x)}`;
    this.setDensity = this.slider(byId("density"), (x) => this.send({ kind: "unit-distance", length: this.baseUnit / 10 ** x }), times);
  }

  /** Shows the chosen point of the curve. */
  point(point) {
    byId("point-row").classList.toggle("idle", point === null);
    for (const id of ["point-color", "point-value", "point-opacity", "point-jump", "point-remove"]) byId(id).disabled = point === null;
    if (!point) return;
    const set = (id, value) => {
      if (document.activeElement !== byId(id)) byId(id).value = value;
    };
    set("point-color", hex(point.color));
    set("point-value", Number(point.value.toPrecision(6)));
    set("point-opacity", Number(point.opacity.toPrecision(3)));
  }

  /** Gradient of all values within a voxel or so: a surface's. */
  steepest() {
    if (!this.opened) return 1;
    const { range: [low, high], spacing } = this.opened;
    return (high - low || 1) / spacing;
  }

  shading(part) {
    const shading = { ...this.state.shading, ...part };
    this.state.shading = shading;
    this.send({ kind: "shading", shading });
  }

  bindLight() {
    byId("shaded").addEventListener("change", (e) => this.shading({ enabled: e.target.checked }));
    this.setLight = {};
    for (const key of ["ambient", "diffuse", "specular", "power"]) {
      this.setLight[key] = this.slider(byId(key), (value) => this.shading({ [key]: value }));
    }
    // Opacity that follows the gradient: none where the volume is flat, all of it from a magnitude on.
    this.setEdges = this.slider(byId("edges"), (share) => {
      this.shading({ gradient_opacity: share > 0 ? [[0, 0], [share * share * this.steepest(), 1]] : [] });
    }, (share) => (share > 0 ? short(share * share * this.steepest()) : "off"));
    byId("headlight").addEventListener("click", () => this.shading({ lights: [{ headlight: true, direction: null, color: [1, 1, 1] }] }));
    byId("background").addEventListener("input", (e) => this.send({ kind: "background", color: linear(e.target.value) }));
    const ball = byId("light");
    let drags = false;
    const place = (event) => {
      const box = ball.getBoundingClientRect();
      const scale = 2.3 / box.width;
      this.lightAt((event.clientX - box.left - box.width / 2) * scale, -(event.clientY - box.top - box.height / 2) * scale);
    };
    ball.addEventListener("pointerdown", (event) => {
      ball.setPointerCapture(event.pointerId);
      drags = true;
      this.send({ kind: "gesture", begins: true });
      place(event);
    });
    ball.addEventListener("pointermove", (event) => drags && place(event));
    for (const end of ["pointerup", "pointercancel"]) {
      ball.addEventListener(end, () => {
        if (drags) this.send({ kind: "gesture", begins: false });
        drags = false;
      });
    }
    ball.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
      if (event.key === "Enter") byId("headlight").click();
      if (!by) return;
      event.preventDefault();
      const [x, y] = this.lightPlace() ?? [0, 0];
      this.lightAt(x + by[0], y + by[1]);
    });
  }

  /** Puts the light to the right and above as seen, on the half of a sphere before the picture. */
  lightAt(x, y) {
    if (!this.camera) return;
    const length = Math.hypot(x, y);
    if (length > 0.98) [x, y] = [(x / length) * 0.98, (y / length) * 0.98];
    const z = Math.sqrt(1 - x * x - y * y);
    const { right, up, forward } = this.camera;
    const direction = [0, 1, 2].map((k) => right[k] * x + up[k] * y - forward[k] * z);
    const color = this.state.shading.lights[0]?.color ?? [1, 1, 1];
    this.shading({ lights: [{ headlight: false, direction, color }] });
    this.drawLight();
  }

  /** Place of the light in the picture; null where it is a headlight. */
  lightPlace() {
    const direction = this.state?.shading?.lights[0]?.direction;
    if (!direction || !this.camera) return null;
    const length = Math.hypot(...direction);
    const along = (axis) => direction.reduce((sum, c, k) => sum + (c / length) * axis[k], 0);
    return [along(this.camera.right), along(this.camera.up), -along(this.camera.forward)];
  }

  drawLight() {
    const ball = byId("light");
    ball.replaceChildren();
    svg("circle", { r: 1, class: "ball" }, ball);
    svg("path", { d: "M-1 0H1M0-1V1", class: "cross" }, ball);
    const [x, y, z] = this.lightPlace() ?? [0, 0, 1];
    svg("circle", { cx: x, cy: -y, r: 0.17, class: z < 0 ? "lamp behind" : "lamp" }, ball);
  }

  bindView() {
    for (const button of document.querySelectorAll("[data-side]")) {
      button.addEventListener("click", () => this.send({ kind: "side", side: button.dataset.side }));
    }
    byId("perspective").addEventListener("change", (e) => this.send({ kind: "projection", perspective: e.target.checked }));
    this.setFov = this.slider(byId("fov"), (degrees) => this.send({ kind: "field-of-view", degrees }), (x) => `${Math.round(x)}°`);
    byId("reset").addEventListener("click", () => this.send({ kind: "reset-camera" }));
  }

  bindCrop() {
    this.crop = [...document.querySelectorAll(".range2")].map((row) => [...row.querySelectorAll("input")]);
    this.crop.forEach((pair) => pair.forEach((input, end) => {
      // One end does not pass the other.
      const changed = () => {
        const [low, high] = pair.map((i) => Number(i.value));
        if (low > high - 0.005) input.value = end === 0 ? Math.max(high - 0.005, 0) : Math.min(low + 0.005, 1);
        this.sendCrop();
      };
      this.slider(input, changed);
    }));
    byId("uncrop").addEventListener("click", () => {
      this.send({ kind: "crop", corners: null });
      this.send({ kind: "planes", planes: [] });
    });
    byId("plane").addEventListener("change", (e) => {
      const { forward } = this.camera;
      this.planeNormal = forward;
      byId("plane-depth").value = 0;
      if (e.target.checked) this.sendPlane(0);
      else this.send({ kind: "planes", planes: [] });
    });
    this.setDepth = this.slider(byId("plane-depth"), (depth) => this.sendPlane(depth));
  }

  sendCrop() {
    const [low, high] = this.opened.bounds;
    const at = (end) => this.crop.map((pair, k) => low[k] + Number(pair[end].value) * (high[k] - low[k]));
    const isWhole = this.crop.every(([a, b]) => Number(a.value) === 0 && Number(b.value) === 1);
    this.send({ kind: "crop", corners: isWhole ? null : [at(0), at(1)] });
  }

  /** Middle of the volume along the plane's normal, and half its extent. */
  planeExtent() {
    const [low, high] = this.opened.bounds;
    const normal = this.planeNormal;
    const middle = normal.reduce((sum, n, k) => sum + (n * (low[k] + high[k])) / 2, 0);
    const half = normal.reduce((sum, n, k) => sum + (Math.abs(n) * (high[k] - low[k])) / 2, 0);
    return [middle, half];
  }

  sendPlane(depth) {
    const [middle, half] = this.planeExtent();
    this.send({ kind: "planes", planes: [{ normal: this.planeNormal, offset: middle + depth * half }] });
  }

  bindRenderer() {
    byId("renderer").addEventListener("change", (e) => this.send({ kind: "renderer", name: e.target.value }));
    byId("quality").addEventListener("change", (e) => e.target.value && this.send({ kind: "quality", quality: e.target.value }));
  }

  bindSave() {
    const links = { "save-scene": "scene.toml", "save-png": "picture.png", "save-exr": "picture.exr", "save-transfer": "transfer.json" };
    for (const [id, name] of Object.entries(links)) byId(id).href = `save/${name}`;
    const sized = () => {
      const [width, height] = ["save-width", "save-height"].map((id) => byId(id).valueAsNumber);
      const query = width >= 1 && height >= 1 ? `?width=${width}&height=${height}` : "";
      byId("save-png").href = `save/picture.png${query}`;
      byId("save-exr").href = `save/picture.exr${query}`;
    };
    for (const id of ["save-width", "save-height"]) byId(id).addEventListener("input", sized);
  }

  /** Shows what was opened. */
  open(opened) {
    this.opened = opened;
    // The name of the file is enough, if the folder is long.
    const title = opened.title.replace(/^.*\//, "");
    byId("title").textContent = title;
    byId("title").title = opened.title;
    document.title = `${title} – vr`;
    byId("notes").replaceChildren(...opened.notes.map((note) => Object.assign(document.createElement("li"), { textContent: note })));
    byId("section-notes").hidden = opened.notes.length === 0;
    const option = (value, text) => Object.assign(document.createElement("option"), { value, textContent: text });
    const group = (label, presets) => {
      const element = Object.assign(document.createElement("optgroup"), { label });
      element.append(...presets.map((preset) => option(preset.name, preset.title)));
      return element;
    };
    byId("preset").replaceChildren(
      option("", "Choose…"),
      option("auto", "From the volume itself"),
      group("For such volumes", opened.presets.filter((preset) => preset.suits)),
      group("Others", opened.presets.filter((preset) => !preset.suits)),
    );
    if (opened.patient) {
      for (const button of document.querySelectorAll("[data-side]")) button.textContent = PATIENT[button.dataset.side];
    }
    if (this.state) this.show(this.state);
  }

  /** Shows the scene after a change. `isOwn`: it was made here, and what is being dragged stays. */
  show(state, isOwn) {
    this.state = state;
    const { transfer, shading, clip, background, render, quality, qualities, renderers } = state;
    // The curve, unless a hand is on it.
    byId("section-curve").classList.toggle("rows", Boolean(transfer.rows));
    if (transfer.points && !(isOwn && this.curve.isDragged)) this.curve.set(transfer.points);
    this.baseUnit ??= transfer.unit_distance;
    this.setDensity(Math.log10(this.baseUnit / transfer.unit_distance));
    // Light.
    byId("shaded").checked = shading.enabled;
    byId("shading").hidden = !shading.enabled;
    for (const [key, set] of Object.entries(this.setLight)) set(shading[key]);
    this.showEdges(shading.gradient_opacity ?? []);
    this.drawLight();
    if (document.activeElement !== byId("background")) byId("background").value = hex(background);
    // Clipping.
    if (this.opened) {
      const [low, high] = this.opened.bounds;
      this.crop.forEach((pair, k) => pair.forEach((input, end) => {
        if (document.activeElement === input) return;
        input.value = clip.box ? (clip.box[end][k] - low[k]) / (high[k] - low[k]) : end;
      }));
      const plane = clip.planes[0];
      byId("plane").checked = Boolean(plane);
      byId("plane-row").hidden = !plane;
      if (plane) {
        this.planeNormal = plane.normal;
        const [middle, half] = this.planeExtent();
        this.setDepth((plane.offset - middle) / half);
      }
    }
    // Renderers; the reason stands with those that do not draw this.
    byId("renderer").replaceChildren(...renderers.map(({ name, refusal }) => {
      const option = Object.assign(document.createElement("option"), { value: name, textContent: name, disabled: refusal !== null });
      if (refusal) option.title = refusal;
      return option;
    }));
    byId("renderer").value = render.renderer;
    const known = qualities.map((name) => Object.assign(document.createElement("option"), { value: name, textContent: QUALITIES[name] }));
    const own = Object.assign(document.createElement("option"), { value: "", textContent: "as set" });
    byId("quality").replaceChildren(...(quality ? known : [own, ...known]));
    byId("quality").value = quality ?? "";
    byId("undo").disabled = !state.can_undo;
    byId("redo").disabled = !state.can_redo;
  }

  /** Shows factors on the opacity by gradient; those that no slider makes stand as they are. */
  showEdges(factors) {
    const isRamp = factors.length === 2 && factors[0][0] === 0 && factors[0][1] === 0 && factors[1][1] === 1;
    this.setEdges(isRamp ? Math.min(Math.sqrt(factors[1][0] / this.steepest()), 1) : 0);
    if (factors.length > 0 && !isRamp) byId("edges").parentElement.querySelector("output").textContent = "as set";
    byId("edges").disabled = this.opened?.has_gradient === false;
  }

  /** Shows what a picture says of the camera. */
  look(camera) {
    this.camera = camera;
    byId("perspective").checked = camera.fov !== null;
    byId("fov-row").hidden = camera.fov === null;
    if (camera.fov !== null) this.setFov(camera.fov);
    this.drawLight();
  }
}

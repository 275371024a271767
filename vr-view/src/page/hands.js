// Hands: pointer, wheel, touch and keys become edits of the camera, at most one of a kind for each picture of the screen.

/** Degrees of a drag across the height of the picture. */
const TURN = 180;
/** Pixels of the screen that a hand may tremble within a click. */
const TREMBLE = 4;
/** Degrees and heights of an arrow key. */
const KEY_TURN = 5;
const KEY_MOVE = 0.05;

export class Hands {
  /**
   * `send(edit)` sends; `tool()` is what a drag does; `windowed(phase, dx, dy)` takes drags of the tool `window`; `asked(place)` takes
   * clicks with Alt, and those of the tool `ray`; `hovered(place)` is told where the pointer is, or null.
   */
  constructor(element, { send, tool, windowed, hovered, asked }) {
    Object.assign(this, { element, send, tool, windowed, hovered, asked });
    /** Where a click began that asks for a pixel, until it becomes a drag. */
    this.click = null;
    this.pointers = new Map();
    this.waiting = { right: 0, up: 0, moveRight: 0, moveUp: 0, factor: 1, at: [0, 0], roll: 0 };
    this.scheduled = false;
    element.addEventListener("pointerdown", (e) => this.down(e));
    element.addEventListener("pointermove", (e) => this.move(e));
    for (const end of ["pointerup", "pointercancel"]) element.addEventListener(end, (e) => this.up(e));
    element.addEventListener("pointerleave", () => this.hovered(null));
    element.addEventListener("wheel", (e) => this.wheel(e), { passive: false });
    element.addEventListener("contextmenu", (e) => e.preventDefault());
    element.addEventListener("keydown", (e) => this.key(e));
    element.addEventListener("dblclick", () => this.send({ kind: "fit" }));
  }

  /** Place in heights of the picture from its middle. */
  place({ clientX, clientY }) {
    const box = this.element.getBoundingClientRect();
    return [(clientX - box.left - box.width / 2) / box.height, (box.top + box.height / 2 - clientY) / box.height];
  }

  down(event) {
    this.element.focus({ preventScroll: true });
    this.element.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, this.place(event));
    this.hovered(null);
    const asks = event.button === 0 && (event.altKey || this.tool() === "ray");
    this.click = asks && this.pointers.size === 1 ? [event.clientX, event.clientY] : null;
    if (this.pointers.size === 1) {
      this.gesture = this.meaning(event);
      this.send({ kind: "gesture", begins: true });
      if (this.gesture === "window") this.windowed("begin", 0, 0);
    }
    event.preventDefault();
  }

  meaning({ button, shiftKey, ctrlKey, metaKey, altKey }) {
    if (button === 1 || button === 2 || shiftKey) return "move";
    if (ctrlKey || metaKey) return "zoom";
    if (altKey) return "window";
    // Of the tool that asks, a click is a question, and a drag turns as ever.
    return this.tool() === "ray" ? "turn" : this.tool();
  }

  move(event) {
    const place = this.place(event);
    const last = this.pointers.get(event.pointerId);
    if (!last) {
      this.hovered(place);
      return;
    }
    if (this.click && Math.hypot(event.clientX - this.click[0], event.clientY - this.click[1]) <= TREMBLE) return;
    this.click = null;
    const [dx, dy] = [place[0] - last[0], place[1] - last[1]];
    if (this.pointers.size === 2) {
      // Both fingers together: they move, pinch and roll at once.
      const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
      const before = [last[0] - other[0], last[1] - other[1]];
      const after = [place[0] - other[0], place[1] - other[1]];
      const factor = Math.hypot(...after) / Math.max(Math.hypot(...before), 1e-6);
      const turned = Math.atan2(after[1], after[0]) - Math.atan2(before[1], before[0]);
      this.waiting.moveRight -= dx / 2;
      this.waiting.moveUp -= dy / 2;
      this.waiting.factor *= Math.min(Math.max(factor, 0.5), 2);
      this.waiting.at = [(place[0] + other[0]) / 2, (place[1] + other[1]) / 2];
      this.waiting.roll += Math.atan2(Math.sin(turned), Math.cos(turned)) * (180 / Math.PI);
    } else if (this.pointers.size === 1) {
      if (this.gesture === "turn") {
        this.waiting.right -= dx * TURN;
        this.waiting.up -= dy * TURN;
      } else if (this.gesture === "move") {
        this.waiting.moveRight -= dx;
        this.waiting.moveUp -= dy;
      } else if (this.gesture === "zoom") {
        this.waiting.factor *= Math.exp(3 * dy);
        this.waiting.at = [0, 0];
      } else {
        this.windowed("move", dx, dy);
      }
    }
    this.pointers.set(event.pointerId, place);
    this.schedule();
  }

  up(event) {
    if (!this.pointers.delete(event.pointerId)) return;
    if (this.pointers.size === 0) {
      this.flush();
      if (this.gesture === "window") this.windowed("end", 0, 0);
      this.send({ kind: "gesture", begins: false });
      if (this.click && event.type === "pointerup") this.asked(this.place(event));
      this.click = null;
    }
  }

  wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1;
    // Trackpads tell a pinch as a wheel with Ctrl, in small numbers.
    const rate = event.ctrlKey ? 0.01 : 0.0015;
    const by = Math.min(Math.max(-event.deltaY * lines * rate, -1), 1);
    this.waiting.factor *= Math.exp(by);
    this.waiting.at = this.place(event);
    this.schedule();
  }

  key(event) {
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (arrows && event.shiftKey) {
      this.waiting.moveRight += arrows[0] * KEY_MOVE;
      this.waiting.moveUp += arrows[1] * KEY_MOVE;
    } else if (arrows) {
      this.waiting.right += arrows[0] * KEY_TURN;
      this.waiting.up += arrows[1] * KEY_TURN;
    } else if (event.key === "+" || event.key === "=" || event.key === "-") {
      this.waiting.factor *= event.key === "-" ? 1 / 1.15 : 1.15;
      this.waiting.at = [0, 0];
    } else if (event.key === "," || event.key === ".") {
      this.waiting.roll += event.key === "," ? KEY_TURN : -KEY_TURN;
    } else {
      return;
    }
    event.preventDefault();
    this.schedule();
  }

  schedule() {
    if (this.scheduled) return;
    this.scheduled = true;
    requestAnimationFrame(() => this.flush());
  }

  /** Sends all that has come together since the last picture of the screen. */
  flush() {
    this.scheduled = false;
    const { right, up, moveRight, moveUp, factor, at, roll } = this.waiting;
    this.waiting = { right: 0, up: 0, moveRight: 0, moveUp: 0, factor: 1, at: [0, 0], roll: 0 };
    if (moveRight || moveUp) this.send({ kind: "pan", right: moveRight, up: moveUp });
    if (factor !== 1) this.send({ kind: "zoom", factor, at });
    if (roll) this.send({ kind: "roll", degrees: roll });
    if (right || up) this.send({ kind: "orbit", right, up });
  }
}

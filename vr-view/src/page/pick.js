// Pick: the value of what is seen under the pointer, marked in the curve.

import { short } from "./color.js";
import { ask } from "./connection.js";

const byId = (id) => document.getElementById(id);

export class Pick {
  /** `marked(value)` is called with the value under the pointer, or null. */
  constructor({ marked }) {
    this.marked = marked;
    this.found = null;
    /** Place under the pointer; null outside of the picture. */
    this.place = null;
    this.asks = false;
  }

  /** The pointer is at a place, in heights of the picture from its middle, or nowhere. */
  at(place) {
    this.place = place;
    if (place) this.ask();
    else this.show(null);
  }

  /** Asks for the newest place; while one answer is on its way, no other is asked for. */
  async ask() {
    if (this.asks) return;
    this.asks = true;
    while (this.place) {
      const place = this.place;
      const found = await this.once(place);
      if (this.place) this.show(found);
      if (this.place === place) break;
    }
    this.asks = false;
  }

  show(found) {
    this.found = found;
    this.marked(found?.value ?? null);
    byId("status-pick").textContent = found ? `${short(found.value)} under the pointer` : "";
    byId("status-pick").title = found ? `Value of the heaviest sample of the ray: ${Math.round(100 * found.share)} % of its opacity` : "";
  }

  /** What is seen at a place, once. */
  async once([x, y]) {
    const response = await ask(`pick?${new URLSearchParams({ x, y })}`).catch(() => null);
    return response?.ok ? response.json() : null;
  }
}

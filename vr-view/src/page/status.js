// The line that says what is on the screen: renderer, time, and how far it is from the truth.

import { short } from "./color.js";

const byId = (id) => document.getElementById(id);

/** Pictures and latencies that are kept for the rate, and for tests. */
const KEPT = 120;

export class Status {
  constructor() {
    this.head = null;
    /** Times at which moving pictures were shown, and milliseconds from an edit to its picture. */
    this.shown = [];
    this.latencies = [];
  }

  /** A picture was shown at a time; `since` is when the first edit was sent that it shows. */
  picture(head, since) {
    const now = performance.now();
    this.head = head;
    const last = this.shown.at(-1);
    if (head.stage === "draft") {
      this.shown.push(now);
      if (this.shown.length > KEPT) this.shown.shift();
      if (since !== null) {
        this.latencies.push(now - since);
        if (this.latencies.length > KEPT) this.latencies.shift();
      }
    }
    const rate = head.stage === "draft" && last !== undefined && now - last < 500 ? this.rate() : null;
    byId("status-rate").textContent = rate ? `${Math.round(rate)} a second` : "";
    this.write();
  }

  /** Pictures a second of the last ones that followed each other. */
  rate() {
    const times = this.shown.slice(-20);
    let first = times.length - 1;
    while (first > 0 && times[first] - times[first - 1] < 300) first -= 1;
    const count = times.length - 1 - first;
    return count > 2 ? (1000 * count) / (times.at(-1) - times[first]) : null;
  }

  /** More is known of the error of a picture. */
  error({ picture, error }) {
    if (this.head?.picture !== picture) return;
    this.head.error = error;
    if (error.kind === "measured") this.head.stage = "measured";
    this.write();
  }

  problem(reason) {
    byId("status-stage").dataset.stage = "problem";
    byId("status-error").textContent = reason;
  }

  write() {
    const { stage, renderer, size, full_size: full, milliseconds, error } = this.head;
    byId("status-stage").dataset.stage = stage;
    byId("status-renderer").textContent = renderer;
    const isWhole = size[0] === full[0] && size[1] === full[1];
    byId("status-size").textContent = isWhole ? `${size[0]}×${size[1]}` : `${size[0]}×${size[1]} of ${full[0]}×${full[1]}`;
    byId("status-time").textContent = duration(milliseconds);
    byId("status-error").textContent = words(error);
    byId("status-error").dataset.kind = error.kind;
  }
}

/** A time in words. */
export function duration(milliseconds) {
  return milliseconds < 1000 ? `${short(milliseconds)} ms` : `${short(milliseconds / 1000)} s`;
}

/** What is known of an error, in words. */
export function words(error) {
  const measured = error.rmse == null ? "" : ` · RMSE ${short(error.rmse)} measured`;
  switch (error.kind) {
    case "estimated":
      return `RMSE about ${short(error.rmse)}, estimated`;
    case "measured":
      return `RMSE ${short(error.rmse)}, at most ${short(error.max)}: measured on ${error.pixels} pixels`;
    case "proven":
      return `every pixel within ${short(error.bound)}: proven${measured}`;
    case "unproven":
      return `not proven within ${short(error.bound)} for ${error.rays} pixels${measured}`;
    default:
      return "error not known yet";
  }
}

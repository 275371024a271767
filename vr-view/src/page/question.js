// A question about the picture at rest: asked once, its answer shown, and both taken away as soon as the picture changes.

import { ask } from "./connection.js";

export class Question {
  /**
   * `rests()` is true if no better picture of this scene is to come than the one on the screen; `say(text)` shows words in place of an answer.
   * A kind of question has `isOpen`, `asking()`, which says so and returns the address, `read(response)`, `show(found)` and `hide()`.
   */
  constructor({ rests, say }) {
    Object.assign(this, { rests, say });
    this.found = null;
    /** Handle on the question on its way, or on one that failed: an answer to any other is not shown. */
    this.waits = null;
  }

  /** Takes away what belongs to no picture on the screen. */
  clear() {
    this.waits?.abort();
    this.waits = null;
    this.found = null;
    this.hide();
    this.say("waits until the picture rests");
  }

  /** A picture was shown, or more is known of it. */
  shown(head) {
    if (!this.isOpen) return;
    if (head.stage === "draft" || head.stage === "finer") this.clear();
    else this.ask();
  }

  async ask() {
    if (!this.isOpen || this.found || this.waits || !this.rests()) return;
    const own = new AbortController();
    this.waits = own;
    try {
      const response = await ask(this.asking(), { signal: own.signal });
      const found = response.ok ? await this.read(response) : await response.text();
      if (this.waits !== own) return;
      // After an edit, the next picture at rest asks again.
      if (response.status === 409) return this.clear();
      if (!response.ok) throw new Error(found.trim());
      this.found = found;
      this.show(found);
      this.waits = null;
    } catch (error) {
      if (this.waits === own) this.say(error.message);
    }
  }
}

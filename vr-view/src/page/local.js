// Without a server: a worker of this page holds the program as a module, and draws; nothing leaves the machine.

const byId = (id) => document.getElementById(id);

/** True if the page has the program within it. */
export const isLocal = byId("module") !== null;

/** Beginnings of addresses that are asked while the hand rests: they wait until the worker has drawn what it draws. */
const PATIENT = ["pick", "place", "truth"];

/** Bytes of the module, which the page has packed and in letters. */
async function moduleBytes() {
  const letters = atob(byId("module").textContent.trim());
  const packed = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

/** Address that the worker can look at while it draws, and that is taken back when a message waits. */
const newAddress = () => URL.createObjectURL(new Blob(["calm"]));

/** The program in a worker: messages as a socket carries them, and questions as `fetch` asks them. */
export class LocalProgram {
  constructor() {
    this.worker = null;
    this.calm = newAddress();
    /** Questions that wait for the one before to be answered. */
    this.waiting = [];
    this.asked = null;
    this.isReady = false;
    this.isOver = false;
    this.number = 0;
    document.body.classList.add("local");
    document.addEventListener("click", (event) => this.clicked(event));
  }

  /** Begins. `on` has `open()`, `message(data)` and `close(reason)`. */
  async connect(on) {
    try {
      const script = new Blob([byId("worker").textContent], { type: "text/javascript" });
      const module = await moduleBytes();
      this.worker = new Worker(URL.createObjectURL(script));
      this.worker.onmessage = ({ data }) => {
        if (data.ready) this.begin(on);
        else if (data.answer) this.answered(data.answer);
        else if (data.ended) this.end(on, data.ended);
        else on.message(data.told);
      };
      this.worker.onerror = (event) => this.end(on, event.message || "the module does not begin");
      this.worker.postMessage({ module, calm: this.calm }, [module]);
    } catch (error) {
      this.end(on, error.message);
    }
  }

  begin(on) {
    this.isReady = true;
    on.open();
    this.next();
  }

  end(on, reason) {
    if (this.isOver) return;
    this.isOver = true;
    this.worker?.terminate();
    this.worker = null;
    for (const { fail } of [this.asked, ...this.waiting].filter(Boolean)) fail(new TypeError(reason));
    [this.asked, this.waiting] = [null, []];
    on.close(reason);
  }

  /** Sends something for which the worker gives up what it draws. */
  interrupting(message, moved = []) {
    URL.revokeObjectURL(this.calm);
    this.calm = newAddress();
    this.worker.postMessage({ ...message, calm: this.calm }, moved);
  }

  send(text) {
    this.interrupting({ edit: text });
  }

  /** Asks the program at an address, as `fetch` does. */
  ask(address, { method = "GET", body = null, signal = null } = {}) {
    return new Promise((done, fail) => {
      const question = { method, address: String(address), body, signal, done, fail };
      signal?.addEventListener("abort", () => {
        this.waiting = this.waiting.filter((waiting) => waiting !== question);
        fail(new DOMException("given up", "AbortError"));
      });
      this.waiting.push(question);
      this.next();
    });
  }

  async next() {
    if (this.asked || this.waiting.length === 0 || !(this.isReady || this.isOver)) return;
    const question = this.waiting.shift();
    this.asked = question;
    const { method, address, body, fail } = question;
    try {
      const bytes = body ? await new Response(body).arrayBuffer() : new ArrayBuffer(0);
      if (!this.worker) throw new TypeError("the program has ended");
      this.number += 1;
      const head = JSON.stringify({ id: this.number, method, address });
      const message = { ask: head, body: bytes };
      if (PATIENT.some((start) => address.startsWith(start))) this.worker.postMessage(message, [bytes]);
      else this.interrupting(message, [bytes]);
    } catch (error) {
      this.asked = null;
      fail(error);
      this.next();
    }
  }

  answered(data) {
    const length = new DataView(data).getUint32(0, true);
    const { id, status, kind } = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    if (id !== this.number || !this.asked) return;
    const { done } = this.asked;
    this.asked = null;
    done(new Response(data.slice(4 + length), { status, headers: { "Content-Type": kind } }));
    this.next();
  }

  /** Has a file that a link names made by the program, and saved. */
  async clicked(event) {
    const link = event.target.closest?.("a[download]");
    const address = link?.getAttribute("href");
    if (!address?.startsWith("save/")) return;
    event.preventDefault();
    const answer = await this.ask(address).catch(() => null);
    if (!answer?.ok) return;
    const saved = Object.assign(document.createElement("a"), { href: URL.createObjectURL(await answer.blob()), download: link.download });
    saved.click();
    setTimeout(() => URL.revokeObjectURL(saved.href), 60000);
  }
}

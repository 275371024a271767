// The connection: edits out, pictures and words in, by a socket, which connects again when the program comes back, or by a worker of this page; and questions.

import { LocalProgram, isLocal } from "./local.js";

const local = isLocal ? new LocalProgram() : null;

/** Asks the program at an address, with the options and the answer of `fetch`. */
export const ask = (address, options) => (local ? local.ask(address, options) : fetch(address, options));

/** The head of a picture, and its pixels. */
export function takenApart(data) {
  const length = new DataView(data).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  return { head, bytes: new Uint8ClampedArray(data, 4 + length) };
}

/** Connection to the program. `on` has a function for each kind of message, and `picture(head, bytes)`, `open()` and `closed(isBye)`. */
export class Connection {
  constructor(on) {
    this.on = on;
    this.number = 0;
    /** Open socket, or the program within the page; null while there is none. */
    this.link = null;
    this.wait = 250;
    /** Time at which each edit was sent whose picture is not here yet. */
    this.sent = new Map();
    this.connect();
  }

  connect() {
    let isBye = local !== null;
    const on = {
      open: (link) => {
        this.link = link;
        this.wait = 250;
        this.sent.clear();
        this.on.open();
      },
      message: (data) => {
        if (typeof data !== "string") {
          this.picture(data);
          return;
        }
        const message = JSON.parse(data);
        if (message.kind === "bye") isBye = true;
        else this.on[message.kind]?.(message);
      },
      close: (reason) => {
        this.link = null;
        this.on.closed(isBye, reason);
      },
    };
    if (local) local.connect({ ...on, open: () => on.open(local) });
    else this.connectSocket(on);
  }

  connectSocket(on) {
    const address = new URL("socket", location.href);
    address.protocol = "ws:";
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => on.open(socket);
    socket.onmessage = ({ data }) => on.message(data);
    socket.onclose = ({ reason }) => {
      on.close(reason);
      // The address has the token of one run: a program that is started anew at another one is another page.
      this.wait = Math.min(2 * this.wait, 4000);
      setTimeout(() => this.connect(), this.wait);
    };
  }

  async picture(data) {
    const { head, bytes } = takenApart(data);
    let since = null;
    for (const [number, time] of this.sent) {
      if (number > head.answers) break;
      since ??= time;
      this.sent.delete(number);
    }
    await this.on.picture(head, bytes, since);
    // The program sends no more pictures than are shown.
    if (!local && this.link?.readyState === WebSocket.OPEN) this.link.send(JSON.stringify({ shown: head.picture }));
  }

  /** Sends an edit, and returns its number; 0 while there is no connection. */
  send(edit) {
    if (!this.link || this.link.readyState > WebSocket.OPEN) return 0;
    this.number += 1;
    if (this.sent.size < 1000) this.sent.set(this.number, performance.now());
    this.link.send(JSON.stringify({ number: this.number, edit }));
    return this.number;
  }
}

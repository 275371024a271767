// The socket: edits out, pictures and words in; connects again when the program comes back.

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
    this.socket = null;
    this.wait = 250;
    /** Time at which each edit was sent whose picture is not here yet. */
    this.sent = new Map();
    this.connect();
  }

  connect() {
    const address = new URL("socket", location.href);
    address.protocol = "ws:";
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    let isBye = false;
    socket.onopen = () => {
      this.socket = socket;
      this.wait = 250;
      this.sent.clear();
      this.on.open();
    };
    socket.onmessage = ({ data }) => {
      if (typeof data !== "string") {
        this.picture(data);
        return;
      }
      const message = JSON.parse(data);
      if (message.kind === "bye") isBye = true;
      else this.on[message.kind]?.(message);
    };
    socket.onclose = ({ reason }) => {
      this.socket = null;
      this.on.closed(isBye, reason);
      // The address has the token of one run: a program that is started anew at another one is another page.
      this.wait = Math.min(2 * this.wait, 4000);
      setTimeout(() => this.connect(), this.wait);
    };
  }

  picture(data) {
    const { head, bytes } = takenApart(data);
    let since = null;
    for (const [number, time] of this.sent) {
      if (number > head.answers) break;
      since ??= time;
      this.sent.delete(number);
    }
    this.on.picture(head, bytes, since);
  }

  /** Sends an edit, and returns its number; 0 while there is no connection. */
  send(edit) {
    if (this.socket?.readyState !== WebSocket.OPEN) return 0;
    this.number += 1;
    if (this.sent.size < 1000) this.sent.set(this.number, performance.now());
    this.socket.send(JSON.stringify({ number: this.number, edit }));
    return this.number;
  }
}

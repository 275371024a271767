// The worker of a page without a server: holds the module, passes messages on, and has it draw in between.

let calls = null;
/** Address that can be looked at as long as no message waits that makes stale what is drawn. */
let calm = "";
let canLook = false;
let timer = 0;
let isDue = false;

const decoder = new TextDecoder();
const encoder = new TextEncoder();
const turn = new MessageChannel();

/** True if the address is there. Looks at once: a worker that draws takes no messages. */
function isCalm() {
  try {
    const request = new XMLHttpRequest();
    request.open("GET", calm, false);
    request.send();
    return request.status === 200;
  } catch {
    return false;
  }
}

/** Takes what the module gives: words, a picture, an answer, or the reason why it ends. */
function take(kind, start, length) {
  const bytes = new Uint8Array(calls.memory.buffer, start, length).slice();
  if (kind === 0) postMessage({ told: decoder.decode(bytes) });
  else if (kind === 1) postMessage({ told: bytes.buffer }, [bytes.buffer]);
  else if (kind === 2) postMessage({ answer: bytes.buffer }, [bytes.buffer]);
  else postMessage({ ended: decoder.decode(bytes) });
}

function put(...parts) {
  const length = parts.reduce((sum, part) => sum + part.length, 0);
  let at = calls.room(length);
  for (const part of parts) {
    new Uint8Array(calls.memory.buffer, at, part.length).set(part);
    at += part.length;
  }
}

/** Has a stage drawn soon, behind the messages that wait already. */
function draw() {
  clearTimeout(timer);
  if (isDue) return;
  isDue = true;
  turn.port2.postMessage(null);
}

turn.port1.onmessage = () => {
  isDue = false;
  const wait = calls.step();
  if (wait === 0) draw();
  else if (wait > 0) timer = setTimeout(draw, wait);
};

onmessage = async ({ data }) => {
  calm = data.calm ?? calm;
  if (data.module) {
    const page = { now: () => performance.now(), interrupted: () => (canLook && !isCalm() ? 1 : 0), take };
    canLook = isCalm();
    calls = (await WebAssembly.instantiate(data.module, { page })).instance.exports;
    postMessage({ ready: true });
    calls.begin();
  } else if (data.edit !== undefined) {
    put(encoder.encode(data.edit));
    calls.receive();
  } else {
    const head = encoder.encode(data.ask);
    put(head, new Uint8Array(data.body));
    calls.ask(head.length);
  }
  draw();
};

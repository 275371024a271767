// The worker of a page without a server: holds the module, passes messages on, and has it draw in between.

let calls = null;
/** Messages that wait for the one before, or for a stage that is drawn. */
const messages = [];
let isBusy = false;
let timer = 0;

const decoder = new TextDecoder();
const encoder = new TextEncoder();

/** True if the browser can put a module aside while it draws, and take messages meanwhile. */
const suspends = typeof WebAssembly.Suspending === "function";
/** Address that can be looked at as long as no message waits that makes stale what is drawn: for browsers that cannot put a module aside. */
let calm = "";
let canLook = false;

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

const channel = new MessageChannel();
let goOn = null;
channel.port1.onmessage = () => goOn();

/** Lets messages come in. */
const turn = () => new Promise((done) => {
  goOn = done;
  channel.port2.postMessage(null);
});

/** 1 if a message waits that makes stale what is drawn. */
async function isStale() {
  await turn();
  return messages.some((message) => message.calm) ? 1 : 0;
}

/** Takes what the module gives: words, a picture, an answer, or the reason why it ends. */
function take(kind, start, length) {
  const bytes = new Uint8Array(calls.memory.buffer, start, length).slice();
  if (kind === 0) postMessage({ told: decoder.decode(bytes) });
  else if (kind === 1) postMessage({ told: bytes.buffer }, [bytes.buffer]);
  else if (kind === 2) postMessage({ answer: bytes.buffer }, [bytes.buffer]);
  else postMessage({ ended: decoder.decode(bytes) });
}

async function begin(module) {
  canLook = !suspends && isCalm();
  const interrupted = suspends ? new WebAssembly.Suspending(isStale) : () => (canLook && !isCalm() ? 1 : 0);
  const page = { now: () => performance.now(), interrupted, take };
  const { exports } = (await WebAssembly.instantiate(module, { page })).instance;
  const drawing = suspends ? WebAssembly.promising : (call) => call;
  calls = { ...exports, step: drawing(exports.step), ask: drawing(exports.ask) };
  postMessage({ ready: true });
  calls.begin();
}

/** Puts bytes where the module takes them. */
function put(...parts) {
  let at = calls.room(parts.reduce((sum, part) => sum + part.length, 0));
  for (const part of parts) {
    new Uint8Array(calls.memory.buffer, at, part.length).set(part);
    at += part.length;
  }
}

async function passOn(message) {
  calm = message.calm ?? calm;
  if (message.module) {
    await begin(message.module);
  } else if (message.edit !== undefined) {
    put(encoder.encode(message.edit));
    calls.receive();
  } else {
    const head = encoder.encode(message.ask);
    put(head, new Uint8Array(message.body));
    await calls.ask(head.length);
  }
}

/** Passes on all messages, then draws a stage, again and again, until nothing is left to do. */
async function work() {
  if (isBusy) return;
  isBusy = true;
  clearTimeout(timer);
  try {
    for (;;) {
      if (messages.length > 0) {
        await passOn(messages.shift());
        continue;
      }
      const wait = await calls.step();
      if (wait !== 0) {
        if (wait > 0) timer = setTimeout(work, wait);
        if (messages.length === 0) break;
      }
      await turn();
    }
    isBusy = false;
  } catch (error) {
    postMessage({ ended: error.message });
  }
}

onmessage = ({ data }) => {
  messages.push(data);
  work();
};

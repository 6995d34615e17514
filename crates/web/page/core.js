// The numerics: crates/core as WebAssembly, on this page and in its workers.

/** Functions of a module: call("avar", model, sizes) returns its numbers, null if the arguments were refused. */
export function coreOf(module) {
  const { exports } = new WebAssembly.Instance(module, {});
  return (name, ...parts) => {
    const values = parts.map((part) => (typeof part === "number" ? [part] : part));
    const start = exports.input(values.reduce((sum, part) => sum + part.length, 0));
    let offset = 0;
    const input = new Float64Array(exports.memory.buffer, start);
    for (const part of values) {
      input.set(part, offset);
      offset += part.length;
    }
    const count = exports[name]();
    return count < 0 ? null : new Float64Array(exports.memory.buffer, exports.output(), count).slice();
  };
}

/** The module from its text: gzip in base 64. */
export async function moduleOf(packed) {
  const bytes = Uint8Array.from(atob(packed), (c) => c.charCodeAt(0));
  const unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compile(await new Response(unpacked).arrayBuffer());
}

/** Cluster sizes 1, 2, 3, 4, 6, 8, 12 … up to a share of the record. */
export function halfOctaves(samples, share = 2) {
  const sizes = [];
  for (let size = 1; size <= samples / share; size *= 2) {
    sizes.push(size);
    if (size >= 2 && 1.5 * size <= samples / share) sizes.push(1.5 * size);
  }
  return sizes;
}

/** Cluster sizes close to evenly spaced on a logarithmic axis. */
export function denseSizes(samples, perDecade = 20) {
  const largest = Math.max(1, Math.floor(samples / 2)), steps = Math.ceil(perDecade * Math.log10(largest));
  const sizes = new Set();
  for (let k = 0; k <= steps; k++) sizes.add(Math.min(largest, Math.round(10 ** (k / perDecade))));
  return [...sizes];
}

/** Frequencies from the reciprocal of the record to half the rate. [Hz] */
export function frequenciesOf(samples, tau0, perDecade = 24) {
  const low = Math.log10(1 / (samples * tau0)), high = Math.log10(0.5 / tau0);
  const steps = Math.max(8, Math.ceil(perDecade * (high - low)));
  return Array.from({ length: steps + 1 }, (_, k) => 10 ** (low + ((high - low) * k) / steps));
}

const LONGEST_REST = 250; // [ms]

/**
 * A worker that answers one request after the other; of those that wait, only the newest of a kind is kept. `stop` ends what it is
 * at. One that rests is idle as long as its last answer took, so that the page has a core.
 */
export function workerOf(module, script, onanswer, { rests = false } = {}) {
  const address = URL.createObjectURL(new Blob([script], { type: "text/javascript" })), waiting = new Map();
  let worker = null, busy = false, begun = 0;
  function start() {
    worker = new Worker(address);
    worker.postMessage({ module });
    worker.onmessage = ({ data }) => {
      const free = () => {
        busy = false;
        next();
      };
      if (rests) setTimeout(free, Math.min(LONGEST_REST, performance.now() - begun));
      else free();
      onanswer(data);
    };
  }
  function next() {
    if (busy || !waiting.size) return;
    const [kind, request] = waiting.entries().next().value;
    waiting.delete(kind);
    busy = true;
    begun = performance.now();
    worker.postMessage({ kind, ...request });
  }
  start();
  return {
    ask(kind, request) {
      waiting.set(kind, request);
      next();
    },
    stop() {
      waiting.clear();
      if (!busy) return;
      worker.terminate();
      busy = false;
      start();
    },
  };
}

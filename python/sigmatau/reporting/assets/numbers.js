// Numbers: packed series, texts, ticks.

/** Numbers of `sigmatau.reporting.charts.packed`; null where there is none. */
export function unpacked({ low, high, data }) {
  const bytes = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Array.from({ length: bytes.length / 2 }, (_, k) => {
    const found = view.getUint16(2 * k, true), share = found / 65534;
    return found === 65535 ? null : low * (1 - share) + high * share;
  });
}

const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

/** A number with so many digits, with a power of ten if it is very large or small: "0.0123", "1.2 × 10⁻⁹". */
export function text(value, digits = 3, most = 1e6) {
  if (value === null || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  digits = Math.min(digits, 17);
  if (size >= 1e-3 && size < most) return String(Number(value.toPrecision(Math.max(digits, Math.ceil(Math.log10(size))))));
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  const power = String(Number(exponent)).split("").map((c) => RAISED[c]).join("");
  return Number(mantissa) === 1 ? `10${power}` : `${Number(mantissa)} × 10${power}`;
}

/** Ticks of a logarithmic axis: decades, and 2 and 5 between them where there are few. */
export function logTicks(low, high) {
  const first = Math.floor(Math.log10(low)), last = Math.ceil(Math.log10(high));
  const decades = Math.log10(high / low);
  const steps = decades < 1.2 ? [1, 1.5, 2, 3, 4, 5, 7] : decades < 3.5 ? [1, 2, 5] : [1];
  const every = Math.max(1, Math.ceil(decades / 9));
  const ticks = [];
  for (let k = first; k <= last; k++) {
    if (steps.length === 1 && k % every) continue;
    for (const step of steps) {
      const at = Number(`${step}e${k}`);
      if (at >= low * (1 - 1e-9) && at <= high * (1 + 1e-9)) ticks.push(at);
    }
  }
  return ticks.length > 1 ? ticks : linearTicks(low, high);
}

/** Ticks of a linear axis: five or so at 1, 2 or 5 times a power of ten. */
export function linearTicks(low, high, count = 6) {
  const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
  if (!(power > 1e-13 * Math.max(Math.abs(low), Math.abs(high)))) return [low]; // nothing lies between
  const ticksOf = (step) => {
    const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
    return Array.from({ length: last - first + 1 }, (_, k) => Number(((first + k) * step).toPrecision(15)));
  };
  const steps = [1, 2, 5, 10].map((k) => k * power), at = steps.findIndex((k) => k >= raw * (1 - 1e-9));
  const ticks = ticksOf(steps[at]);
  return ticks.length > 1 || at === 0 ? ticks : ticksOf(steps[at - 1]); // a single tick has no scale
}

/** Texts of ticks: of a linear axis with as many decimals as their distance needs. */
export function tickTexts(ticks, log) {
  const most = log && ticks.some((tick) => tick >= 1e5) ? 1e4 : 1e6;
  const short = ticks.map((tick) => text(tick, 3, most));
  if (ticks.length < 2 || (log && new Set(short).size === short.length)) return short;
  const step = Math.abs(ticks[1] - ticks[0]), largest = Math.max(...ticks.map(Math.abs));
  if (largest >= 1e8 || largest < 1e-3) return ticks.map((tick) => text(tick, 2 + Math.max(0, Math.floor(Math.log10(largest / step)))));
  const decimals = Math.min(Math.max(0, -Math.floor(Math.log10(step) + 1e-9)), 12);
  return ticks.map((tick) => tick.toFixed(decimals));
}

/** A range with some room around the smallest and the largest of numbers. */
export function rangeOf(values, log) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value === null || !Number.isFinite(value) || (log && value <= 0)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (low > high) return log ? [0.1, 10] : [0, 1];
  if (log) return low === high ? [low / 2, high * 2] : [low / 1.12, high * 1.12];
  const room = low === high ? Math.abs(low) * 0.05 || 1 : (high - low) * 0.04;
  return [low - room, high + room];
}

/** Time axis of a duration: unit and its size in seconds. */
export function timeUnit(duration) {
  if (duration >= 7200) return { text: "h", size: 3600 };
  return duration > 600 ? { text: "min", size: 60 } : { text: "s", size: 1 };
}

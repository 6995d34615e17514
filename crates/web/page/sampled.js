// What a sampled record holds of the chosen noise, and the length of record for an error of a coefficient.

import { TERMS } from "./settings.js";

const HALVINGS = 40, PER_DECADE = 20, MIN_PLANNED = 256, MAX_PLANNED = 1e8, STEP_OF_TIME = 1.01;

/**
 * White noise behind its filter after sampling: noise above half the rate folds back. `white`: coefficient N of the samples at low
 * frequencies, Σ |H(k/τ0)|² folded; `corner`: frequency of half that density, null if there is none. In SI.
 */
export function foldedNoise(call, model) {
  const [, random_walk, , , , , , order, corner, tau0] = model;
  if (!order || !random_walk) return { white: random_walk, corner: null };
  const density = (f) => call("psd", [0, random_walk, 0, 0, 0, 0, 1, order, corner, tau0], [f])[0];
  let low = 1e-6 / tau0, high = 0.5 / tau0;
  const white = density(low);
  if (density(high) > white / 2) return { white: Math.sqrt(white), corner: null };
  for (let k = 0; k < HALVINGS; k++) {
    const middle = (low + high) / 2;
    if (density(middle) > white / 2) low = middle;
    else high = middle;
  }
  return { white: Math.sqrt(white), corner: low };
}

/** Inverse of a small matrix by Gauss-Jordan elimination; null if it is singular. */
function inverse(matrix) {
  const n = matrix.length, rows = matrix.map((row, k) => [...row, ...row.map((_, j) => (j === k ? 1 : 0))]);
  for (let k = 0; k < n; k++) {
    const pivot = rows.slice(k).reduce((best, row, j) => (Math.abs(row[k]) > Math.abs(rows[best][k]) ? k + j : best), k);
    if (!(Math.abs(rows[pivot][k]) > 1e-13)) return null;
    [rows[k], rows[pivot]] = [rows[pivot], rows[k]];
    rows[k] = rows[k].map((value) => value / rows[k][k]);
    for (let j = 0; j < n; j++) if (j !== k) rows[j] = rows[j].map((value, i) => value - rows[j][k] * rows[k][i]);
  }
  return rows.map((row) => row.slice(n));
}

/**
 * By noise term that is present: samples of the record in which its coefficient has a relative standard error; 0 above 10⁸. The bound
 * of Cramér and Rao: Whittle's information on the squares of the coefficients, T ∫ Sᵢ Sⱼ / S² df, for a model whose terms are known.
 */
export function samplesForCoefficients(call, model, error) {
  const tau0 = model[9], plain = [...model.slice(0, 7), 0, 1, tau0];
  plain[4] = 0; // the ramp is not noise
  const present = TERMS.map((_, k) => k).filter((k) => plain[k] > 0), parts = plain[5] > 0 ? [...present, 5] : present;
  if (!present.length) return {};
  const longest = MAX_PLANNED * tau0, low = Math.log(0.25 / longest), high = Math.log(0.5 / tau0);
  const count = Math.ceil(((high - low) / Math.LN10) * PER_DECADE), step = (high - low) / count;
  const f = Array.from({ length: count + 1 }, (_, k) => Math.exp(low + k * step)), psd = call("psd", plain, f), n = f.length;
  // Integrals from each frequency to half the rate, by the trapezoidal rule in ln f; relative to the coefficients.
  const share = (part, k) => psd[(part + 1) * n + k] / psd[k];
  const integrals = [parts.map(() => parts.map(() => 0))];
  for (let k = n - 2; k >= 0; k--)
    integrals.push(integrals.at(-1).map((row, a) => row.map((sum, b) => sum + 0.5 * step * (share(parts[a], k) * share(parts[b], k) * f[k] + share(parts[a], k + 1) * share(parts[b], k + 1) * f[k + 1]))));
  const needed = {};
  for (let time = MIN_PLANNED * tau0; time <= longest && Object.keys(needed).length < present.length; time *= STEP_OF_TIME) {
    const from = Math.min(n - 1, Math.round((high - Math.log(0.25 / time)) / step)), covariance = inverse(integrals[from].map((row) => row.map((sum) => sum * time)));
    if (!covariance) continue;
    present.forEach((part, a) => {
      const { id } = TERMS[part];
      if (!(id in needed) && 0.5 * Math.sqrt(covariance[a][a]) <= error) needed[id] = Math.round(time / tau0);
    });
  }
  return needed;
}

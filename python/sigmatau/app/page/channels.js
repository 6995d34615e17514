// Options of reading by channel: which column is which channel, and units. Written as mappings, as TOML has them.

import { session, setOptions } from "./session.js";

export const COMMON = ["time", "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z", "temperature"];
export const SIGNAL = "signal"; // a further signal, by the name of its column

export const sensorName = (channel) => (/^(gyro|accel)(_|$)/.test(channel) ? channel.split("_")[0] : channel);

/** An option of pairs as a mapping: `gyro=deg/s,accel=g` and lists of such texts too. */
export function asPairs(value) {
  if (value === undefined || value === null) return {};
  if (typeof value === "object" && !Array.isArray(value)) return { ...value };
  const texts = (Array.isArray(value) ? value : [value]).flatMap((text) => String(text).split(","));
  return Object.fromEntries(texts.filter((text) => text.includes("=")).map((text) => { const place = text.indexOf("="); return [text.slice(0, place).trim(), text.slice(place + 1).trim()]; }));
}

/** Use a column as a channel, or not at all; the other columns of its topic stay what they are.
 *
 * Numbers of columns count in one topic: of a file with several the topic of the column is read, and no other.
 */
export function assign(columns, changed, channel, topics) {
  const channels = {};
  for (const column of columns.filter(({ topic }) => topic === changed.topic)) {
    const name = column === changed ? channel : column.channel;
    if (name && (column === changed || name !== channel)) channels[name] ??= column.number;
  }
  const units = asPairs(session.options.unit);
  if (changed.channel && changed.channel !== channel) delete units[changed.channel]; // it was of the other use
  setOptions({ channels, unit: units, ...(topics.length > 1 ? { topic: changed.topic } : {}) });
}

/** What changes when a topic is read, or several; what was stated about the columns of another one is dropped. */
export const topicChanges = (topic) => ({ topic, channels: undefined, unit: undefined, scale: undefined });

/** Give a unit to a channel: to the whole sensor where all its columns have one unit. */
export function setUnit(columns, column, unit) {
  const sensor = sensorName(column.channel), units = asPairs(session.options.unit);
  const mates = columns.filter((mate) => mate.channel && sensorName(mate.channel) === sensor);
  const isShared = sensor !== column.channel && mates.every((mate) => (mate.unit ?? "") === (column.unit ?? ""));
  for (const mate of isShared ? mates : [column]) delete units[mate.channel];
  if (unit.trim()) units[isShared ? sensor : column.channel] = unit.trim();
  setOptions({ unit: units });
}

/** Add a pair to an option of pairs. */
export function setPair(option, key, value) {
  const pairs = asPairs(session.options[option]);
  if (value === "") delete pairs[key];
  else pairs[key] = value;
  setOptions({ [option]: pairs });
}

/** A name of a channel that options can state: letters, digits and underscores of the name of a column. */
export function signalName(column) {
  const name = column.name.replace(/\[.*$/, "").trim().replace(/[^\p{L}\p{N}]+/gu, "_").replace(/^_+|_+$/g, "");
  return name && !COMMON.includes(name) && !/^(gyro|accel)/.test(name) ? name : `column_${column.number}`;
}

export const UNITS = {
  gyro: ["deg/s", "rad/s", "deg/h", "mdeg/s", "mrad/s", "rad/h"],
  accel: ["m/s^2", "g", "mg", "ug", "mGal"],
  time: ["s", "ms", "us", "ns"],
  temperature: ["degC", "K"],
};

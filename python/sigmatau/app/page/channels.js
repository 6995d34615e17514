// Reading options by channel: the column of each channel, and units. They are mappings, as in TOML.

import { session, setOptions } from "./session.js";

/** Reads and changes the options of the session. A live record, and a file added to a comparison, have other options. */
export const ofSession = { all: () => session.options, change: setOptions, hasTable: true };

export const COMMON = ["time", "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z", "temperature"];
export const SIGNAL = "signal"; // a further signal, by the name of its column

export const sensorName = (channel) => (/^(gyro|accel)(_|$)/.test(channel) ? channel.split("_")[0] : channel);

/** An option of pairs as a mapping; it may also be a text, `gyro=deg/s,accel=g`, or a list of such texts. */
export function asPairs(value) {
  if (value === undefined || value === null) return {};
  if (typeof value === "object" && !Array.isArray(value)) return { ...value };
  const texts = (Array.isArray(value) ? value : [value]).flatMap((text) => String(text).split(","));
  return Object.fromEntries(texts.filter((text) => text.includes("=")).map((text) => { const place = text.indexOf("="); return [text.slice(0, place).trim(), text.slice(place + 1).trim()]; }));
}

const AXES = { gyro: "xyz", accel: "xyz" }; // sensors that are assigned to three columns at once

/** `count` columns of a topic from a column on; empty if the topic has fewer. */
export function columnsFrom(columns, first, count) {
  const mates = columns.filter(({ topic }) => topic === first.topic), place = mates.indexOf(first);
  return place + count <= mates.length ? mates.slice(place, place + count) : [];
}

/** Set the channel of a column; an empty name means that it is not used. `gyro` and `accel` set three columns from this one on, as axes x, y, z.
 *
 * Columns are numbered within a topic. In a file with several topics, only the topic of the column is then read.
 */
export function assign({ all, change }, columns, changed, channel, topics) {
  const channels = {}, chosen = AXES[channel] ? columnsFrom(columns, changed, 3).map((column, k) => [column, `${channel}_${AXES[channel][k]}`]) : [[changed, channel]];
  for (const column of columns.filter(({ topic }) => topic === changed.topic)) {
    const name = chosen.find(([mate]) => mate === column);
    if (name ? name[1] : column.channel && !chosen.some(([, taken]) => taken === column.channel)) channels[name?.[1] ?? column.channel] ??= column.number;
  }
  const units = asPairs(all().unit);
  for (const [column, name] of chosen) if (column.channel && column.channel !== name) delete units[column.channel]; // the unit belonged to the previous channel
  change({ channels, unit: units, ...(topics.length > 1 ? { topic: changed.topic } : {}) });
}

/** Changes of options that select a topic, or several; options about columns of other topics are removed. */
export const topicChanges = (topic) => ({ topic, channels: undefined, unit: undefined, scale: undefined });

/** Set the unit of a channel; if all columns of the sensor have the same unit, set that of the sensor. */
export function setUnit({ all, change }, columns, column, unit) {
  const sensor = sensorName(column.channel), units = asPairs(all().unit);
  const mates = columns.filter((mate) => mate.channel && sensorName(mate.channel) === sensor);
  const isShared = sensor !== column.channel && mates.every((mate) => (mate.unit ?? "") === (column.unit ?? ""));
  for (const mate of isShared ? mates : [column]) delete units[mate.channel];
  if (unit.trim()) units[isShared ? sensor : column.channel] = unit.trim();
  change({ unit: units });
}

/** Set a key of an option of pairs; an empty value removes it. */
export function setPair({ all, change }, option, key, value) {
  const pairs = asPairs(all()[option]);
  if (value === "") delete pairs[key];
  else pairs[key] = value;
  change({ [option]: pairs });
}

/** Name of a channel made from that of a column: only letters, digits and underscores, as options need. */
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

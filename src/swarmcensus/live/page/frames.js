"use strict";
// Decodes messages of frames; live/frames.py describes them.

const KIND = 0x53574152;
const LAYER = { intervals: 1, decisions: 2, moves: 4 };
const [NO_ESTIMATE, MOST] = [65535, 65534]; // in place of an estimate; an estimate of 1
const FLAG = { looked: 1, readBlack: 2, onBlack: 4, done: 8 };

function framesOf(buffer) {
  const words = new Uint32Array(buffer, 0, 8);
  const [kind, side, count, robots, columns, layers] = words;
  if (kind !== KIND) throw new Error("no frames");
  const planes = 1 + (layers & LAYER.moves ? 2 : 0) + (layers & LAYER.intervals ? 2 : 0);
  let at = 32;
  const numbers = new Float64Array(buffer, at, count * columns);
  at += 8 * count * columns;
  const ticks = new Uint32Array(buffer, at, count);
  at += 4 * count;
  const starts = new Uint32Array(buffer, at, count + 1);
  at += 4 * (count + 1);
  const values = new Uint16Array(buffer, at, count * planes * robots);
  at += 2 * count * planes * robots;
  const flags = new Uint8Array(buffer, at, count * 2 * robots);
  at += 2 * count * robots;
  const links = layers & LAYER.moves ? new Uint16Array(buffer, at, starts[count]) : new Uint8Array(buffer, at, starts[count]);
  const frames = [];
  for (let k = 0; k < count; k++) {
    const plane = (p) => values.subarray((k * planes + p) * robots, (k * planes + p + 1) * robots);
    const moves = layers & LAYER.moves;
    frames.push({
      tick: ticks[k],
      numbers: numbers.subarray(k * columns, (k + 1) * columns),
      estimates: plane(0),
      x: moves ? plane(1) : null,
      y: moves ? plane(2) : null,
      flags: flags.subarray(2 * k * robots, (2 * k + 1) * robots),
      headings: flags.subarray((2 * k + 1) * robots, (2 * k + 2) * robots),
      links: links.subarray(starts[k], starts[k + 1]),
    });
  }
  return { side, frames };
}

// the estimate of a robot; null without one
function estimateOf(frame, robot) {
  const value = frame.estimates[robot];
  return value === NO_ESTIMATE ? null : value / MOST;
}

// the reading of a robot in this tick, and whether it was wrong; null without one
function lookOf(frame, robot) {
  const flag = frame.flags[robot];
  const said = Boolean(flag & FLAG.readBlack);
  return flag & FLAG.looked ? { said, wrong: said !== Boolean(flag & FLAG.onBlack) } : null;
}

function bytesOf(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes;
}

async function inflated(text) {
  const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

"use strict";
// The source of frames: a server that computes them, or a recording in the page. Both have the same methods.

const GONE = "The server is gone. If it answers again, such as after a sleep of the machine, this page continues. Otherwise start swarmcensus watch again and open the address that it prints.";
const OTHER = "Another server answers here, because swarmcensus watch was started again. Open the address that it printed.";
const FULL = "The server takes no more pages. Close an open one, and this page continues.";
const FAILED = "The connection was lost twice while the server worked on this request, so the page does not repeat it.";
const WAITS = [250, 500, 1000, 2000, 4000]; // milliseconds between attempts to connect
const SUDDEN = 2; // attempts that may fail before the page complains, within a second; it keeps trying

class Live {
  constructor() {
    this.token = new URLSearchParams(location.search).get("token") || "";
    this.number = 0;
    this.waiting = new Map();
    this.begun = null; // the latest request to begin that the server answered
    this.tries = 0; // attempts since the last answer
    this.lost = false;
    this.why = ""; // the complaint about a lost connection that is shown
    this.again = false; // whether the server has not yet prepared the trial again after a reconnection
    this.parts = [];
    this.closed = () => {};
    this.found = () => {};
  }

  open() {
    return new Promise((resolve) => {
      this.opened = resolve;
      this.connect();
    });
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/live?token=${encodeURIComponent(this.token)}`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => {
      this.lost = false;
      this.again = this.begun !== null; // the server does not remember this page
      this.socket.onmessage = ({ data }) => this.take(data);
      if (this.again) this.send(0, { do: "begin", ask: this.begun });
      for (const [id, { words }] of this.waiting) this.send(id, words);
      this.opened();
      if (!this.again && !this.waiting.size) this.answered();
    };
    this.socket.onclose = () => {
      if (!this.lost && !this.again) this.blame();
      if (this.lost) this.tellWhy(this.tries >= SUDDEN);
      this.lost = true;
      this.parts = [];
      setTimeout(() => this.connect(), WAITS[Math.min(this.tries, WAITS.length - 1)]);
      this.tries += 1;
    };
  }

  // only an answer proves that the server works: a connection may open and close again at once
  answered() {
    if (!this.tries) return;
    this.tries = 0;
    this.why = "";
    this.found();
  }

  // a socket cannot distinguish a server that refuses this page from one that is gone; an HTTP request can
  async tellWhy(gone) {
    const reply = fetch(`/?token=${encodeURIComponent(this.token)}`, { method: "HEAD" });
    const status = await reply.then((answer) => answer.status, () => null);
    const late = status === 200 ? FULL : GONE;
    const why = status === 403 ? OTHER : gone ? late : "";
    if (!this.lost || !why || why === this.why) return;
    this.why = why;
    this.closed(new Error(why));
  }

  // requests are answered in order, so the first that waits is the one that the server worked on
  blame() {
    const [id, request] = this.waiting.entries().next().value || [];
    if (!request || ++request.closed < 2) return;
    this.waiting.delete(id);
    request.reject(new Error(FAILED));
  }

  send(id, words) {
    this.socket.send(JSON.stringify({ id, ...words }));
  }

  take(data) {
    if (data instanceof ArrayBuffer) {
      this.parts.push(framesOf(data));
      return;
    }
    const answer = JSON.parse(data);
    this.answered();
    if (answer.id === 0) this.again = false;
    const request = this.waiting.get(answer.id);
    const parts = this.parts;
    this.parts = [];
    if (!request) return;
    this.waiting.delete(answer.id);
    if (answer.error) request.reject(Object.assign(new Error(answer.error), { key: answer.key }));
    else request.resolve({ ...answer, parts });
  }

  // requests made without a connection are sent once there is one
  ask(does, more) {
    return new Promise((resolve, reject) => {
      const id = ++this.number;
      const words = { do: does, ...more };
      this.waiting.set(id, { resolve, reject, words, closed: 0 });
      if (this.socket.readyState === WebSocket.OPEN) this.send(id, words);
    });
  }

  async begin(ask, tick, view) {
    const answer = await this.ask("begin", { ask, tick, view });
    this.begun = ask;
    return answer;
  }

  // the frames of each side; null if the server needs longer
  async frames(from, step, count) {
    const answer = await this.ask("frames", { from, step, count });
    return answer.going ? null : answer.parts.map((part) => part.frames);
  }

  // K of each side; null if the server needs longer
  async settled() {
    const answer = await this.ask("settled");
    return answer.going ? null : answer.settled;
  }

  // what is new of logs that grow
  news(since) {
    return this.ask("news", { since });
  }

  // a field of a robot's memory at some rounds, and of the swarm's; null if the server needs longer
  async memory({ side, robot, name }, from, step, count) {
    const answer = await this.ask("memory", { side, robot, name, from, step, count });
    return answer.going ? null : answer.memory;
  }

  async robot(side, robot, tick) {
    for (;;) {
      const answer = await this.ask("robot", { side, robot, tick });
      if (!answer.going) return answer.told;
    }
  }
}

function quantile(sorted, part) {
  const at = part * (sorted.length - 1);
  const [low, high] = [sorted[Math.floor(at)], sorted[Math.ceil(at)]];
  return sorted.length ? low + (at % 1) * (high - low) : NaN;
}

class Recorded {
  constructor(recording) {
    this.recording = recording;
    this.closed = () => {};
  }

  async open() {
    this.sides = [];
    for (const blocks of this.recording.frames) {
      const frames = [];
      for (const block of blocks) frames.push(...framesOf(await inflated(block)).frames);
      this.sides.push(frames);
    }
    this.states = [];
    for (const text of this.recording.states) {
      const shuffled = new Uint8Array(await inflated(text));
      const size = shuffled.length / 4;
      const bytes = new Uint8Array(shuffled.length);
      for (let i = 0; i < size; i++) for (let k = 0; k < 4; k++) bytes[4 * i + k] = shuffled[k * size + i];
      this.states.push(new Float32Array(bytes.buffer));
    }
  }

  async begin(ask, tick, view) {
    const { form, scenes } = this.recording;
    const known = { ...form.asked, ...form.now, of: form.mark };
    const other = Object.keys(ask).find((key) => ask[key] !== known[key]);
    if (other) throw new Error(`This page has one trial, and ${other} = ${ask[other].slice(0, 40)} is not in it.`);
    for (const [key, most] of [["tick", scenes[0].rounds], ["robot", scenes[0].robots - 1]]) {
      if (key in view && !(/^\d+$/.test(view[key]) && view[key] <= most)) throw new Error(`${key} = ${view[key].slice(0, 40)}: should be a whole number from 0 to ${most.toLocaleString("en")}`);
    }
    return { scenes: this.recording.scenes, form: this.recording.form };
  }

  async frames(from, step, count) {
    return this.sides.map((frames) => {
      const found = [];
      for (let k = 0; k < count; k++) {
        const tick = from + k * step;
        if (tick < frames.length) found.push(frames[tick]);
      }
      return found;
    });
  }

  async settled() {
    return this.recording.settled;
  }

  async memory({ side, robot, name }, from, by, count) {
    const { names, step, scenes } = this.recording;
    const { robots, dishonest, rounds } = scenes[side];
    const rows = Math.floor(rounds / step) + 1;
    const of = (one, tick) => this.states[side][(names[side].indexOf(name) * robots + one) * rows + Math.floor(tick / step)];
    const honest = Array.from({ length: robots }, (_, one) => one).filter((one) => !dishonest.includes(one));
    return Array.from({ length: count }, (_, k) => from + k * by).filter((tick) => tick <= rounds).map((tick) => {
      const sorted = honest.map((one) => of(one, tick)).filter((value) => !Number.isNaN(value)).sort((a, b) => a - b);
      return [tick, of(robot, tick), ...[0, 0.25, 0.5, 0.75, 1].map((part) => quantile(sorted, part))];
    });
  }

  async robot(side, robot, tick) {
    const { names, step } = this.recording;
    const scene = this.recording.scenes[side];
    const rows = Math.floor(scene.rounds / step) + 1;
    const row = Math.floor(tick / step);
    const fields = {};
    names[side].forEach((name, k) => {
      const value = this.states[side][(k * scene.robots + robot) * rows + row];
      fields[name] = Number.isNaN(value) ? null : value;
    });
    const frame = this.sides[side][tick];
    return {
      robot, tick, fields, recorded: row * step, brain: scene.brain, honest: !scene.dishonest.includes(robot),
      estimate: estimateOf(frame, robot) === null ? null : Number(estimateOf(frame, robot).toFixed(4)), truth: frame.numbers[scene.columns.indexOf("truth")], heard: null,
      ...(frame.x ? { tile: frame.flags[robot] & FLAG.onBlack ? 1 : 0, reading: frame.flags[robot] & FLAG.looked ? (frame.flags[robot] & FLAG.readBlack ? 1 : 0) : null } : {}),
    };
  }
}

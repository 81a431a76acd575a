"use strict";
// The source of frames where brains are tried: MicroPython runs the brain in a recorded world, in a worker.

const QUIET = 8000; // milliseconds after which a brain that does not return is ended
const GRID = 8191; // steps of recorded positions

// a world for one accuracy: what workers need, as files, and what frames show
async function worldOf(recording, job) {
  const world = recording.worlds[job.world];
  const { scene, delay } = world;
  const { robots, rounds } = scene;
  const readings = new Uint8Array(await inflated(recording.worlds[world.of].readings[job.accuracy]));
  if (!scene.moves) {
    const edges = new Uint16Array(bytesOf(scene.edges).buffer);
    return { ...world, edges, files: { blacks: readings, pairs: Uint8Array.from(edges), counts: new Uint8Array(Uint16Array.of(edges.length / 2).buffer) } };
  }
  const length = rounds + 1;
  const path = new Uint16Array(3 * robots * length);
  const steps = new Int8Array(await inflated(world.moved));
  for (let k = 0; k < 3 * robots; k++) {
    path[k * length] = world.start.flat()[k];
    for (let tick = 1; tick < length; tick++) path[k * length + tick] = path[k * length + tick - 1] + steps[k * rounds + tick - 1];
  }
  const turned = new Uint8Array(await inflated(world.turned));
  const bits = new Uint8Array(turned.length * 8 + 1);
  const bit = (from, k) => (from[k >> 3] >> (7 - (k & 7))) & 1;
  const wide = Math.ceil(length / 8);
  const at = (k, tick) => bits[k * length + tick];
  for (let k = 0; k < turned.length / wide; k++) for (let tick = 0; tick < length; tick++) bits[k * length + tick] = (tick ? at(k, tick - 1) : 0) ^ bit(turned, 8 * k * wide + tick);
  const blacks = Uint8Array.from({ length: robots * rounds }, (_, k) => (at(k % robots, Math.floor(k / robots) + 1) ? bit(readings, k) : 255));
  const pair = (i, j) => 2 * robots + (i * (2 * robots - i - 1)) / 2 + j - i - 1;
  const [heard, links] = [[], [[]]];
  for (let tick = 1; tick < length; tick++) {
    links.push([]);
    for (let i = 0; i < robots; i++) for (let j = 0; j < robots; j++) if (i !== j && at(pair(Math.min(i, j), Math.max(i, j)), tick)) links[tick].push(i, j);
    heard.push(links[tick].length / 2);
  }
  const files = { blacks, pairs: Uint8Array.from(links.flat()), counts: new Uint8Array(Uint16Array.from(heard).buffer) };
  return { ...world, path, links, files, at, blacks, delay };
}

Recorded = class extends Recorded {
  async open() {
    const { worker, program, wasm } = this.recording.programs;
    const texts = await Promise.all([worker, program].map(async (text) => new TextDecoder().decode(await inflated(text))));
    [this.wasm, this.program] = [await inflated(wasm), texts[1]];
    this.address = URL.createObjectURL(new Blob([texts[0]], { type: "text/javascript" }));
    window.addEventListener("message", ({ data }) => data.world && this.run(data));
    const begun = new Promise((resolve) => (this.begun = resolve));
    this.tell({ state: "ready" });
    await begun;
  }

  tell(message) {
    parent.postMessage(message, "*");
  }

  async run(job) {
    this.end();
    const world = await worldOf(this.recording, job);
    const { robots, rounds } = world.scene;
    [this.job, this.world, this.known] = [job, world, -1];
    this.lying = world.liars.slice(0, job.liars);
    this.estimates = new Float64Array((rounds + 1) * robots);
    this.spoke = new Uint8Array((rounds + 1) * robots);
    this.scene = { ...world.scene, brain: job.name, dishonest: this.lying, opinions: /^OPINION\s*=\s*True/m.test(job.brain) };
    const told = { robots, accuracy: Number(job.accuracy), looks: world.looks, delay: world.delay, liars: this.lying };
    this.worker = new Worker(this.address);
    this.worker.onmessage = ({ data }) => this.take(data);
    const files = { ...world.files, job: JSON.stringify(told), "brain.py": job.brain, "adversary.py": job.adversary };
    this.worker.postMessage({ wasm: this.wasm, program: this.program, files, keys: world.keys, rounds });
    this.started = performance.now();
    if (this.begun) this.begun = void this.begun();
    else begin({}, 0, null).then(playUnasked);
  }

  end() {
    this.worker?.terminate();
    clearTimeout(this.watch);
  }

  // what the worker says: that it is ready, estimates of some ticks, or an error
  take({ estimates, spoke, error }) {
    clearTimeout(this.watch);
    if (error) return this.fail(error);
    this.watch = setTimeout(() => this.fail(`The brain was stopped: it did not return for ${QUIET / 1000} seconds. Does each of its loops end?`), QUIET);
    if (!estimates) return;
    const { robots, rounds } = this.scene;
    const first = (this.known + 1) * robots;
    this.estimates.set(estimates, first);
    this.spoke.set(spoke, first + estimates.length - spoke.length);
    this.known += estimates.length / robots;
    if (this.known < rounds) return;
    this.end();
    this.tell({ state: "done", seconds: (performance.now() - this.started) / 1000 });
  }

  fail(text) {
    this.end();
    this.failed = true;
    state.halted = true;
    pause();
    this.tell({ state: "failed", text, tick: this.known });
  }

  async begin() {
    return { scenes: [this.scene], form: this.world.form };
  }

  // frames that are there; null as long as there are none of those asked for
  async frames(from, step, count) {
    const found = [];
    for (let tick = from; tick <= this.known && found.length < count; tick += step) found.push(this.frame(tick));
    if (found.length || from > this.scene.rounds) return [found];
    return new Promise((soon) => setTimeout(soon, 20, null));
  }

  frame(tick) {
    const { scene, world, estimates } = this;
    const { robots, rounds, columns, bins } = scene;
    const row = Array.from(estimates.subarray(tick * robots, (tick + 1) * robots));
    const own = row.filter((_, i) => !this.lying.includes(i)).sort((a, b) => a - b);
    const share = (holds) => own.filter(holds).length / own.length;
    const bin = (x) => Math.min(Math.floor(x * bins), bins - 1);
    const [lowest, low, median, high, highest] = [0, 0.25, 0.5, 0.75, 1].map((part) => quantile(own, part));
    const right = tick && !scene.opinions ? share((x) => bin(x) === bin(world.truth)) : NaN;
    const opinions = scene.opinions ? { black: share((x) => x === 1), white: share((x) => x === 0) } : {};
    const values = { truth: world.truth, lowest, low, median, high, highest, right, ...opinions };
    const shown = { tick, numbers: Float64Array.from(columns, (name) => values[name] ?? NaN), estimates: Uint16Array.from(row, (x) => Math.round(x * MOST)), flags: new Uint8Array(robots) };
    if (!scene.moves) return { ...shown, links: Uint8Array.from({ length: world.edges.length / 2 }, (_, e) => this.spoke[tick * robots + world.edges[2 * e + 1]]) };
    const plane = (k, kind, scale) => kind.from({ length: robots }, (_, i) => Math.round(world.path[(k * robots + i) * (rounds + 1) + tick] * scale));
    const flag = (i) => {
      const read = tick ? world.blacks[(tick - 1) * robots + i] : 255;
      return (read === 255 ? 0 : FLAG.looked) + (read === 1 ? FLAG.readBlack : 0) + (world.at(robots + i, tick) ? FLAG.onBlack : 0);
    };
    const links = world.links[tick].filter((_, k, all) => all[k - (k % 2)] < all[k - (k % 2) + 1]);
    return { ...shown, flags: shown.flags.map((_, i) => flag(i)), x: plane(0, Uint16Array, 65535 / GRID), y: plane(1, Uint16Array, 65535 / GRID), headings: plane(2, Uint8Array, 1), links };
  }

  async settled() {
    return [null];
  }

  async robot(side, robot, tick) {
    return { robot, tick, fields: {}, recorded: tick, brain: this.job.name, honest: !this.lying.includes(robot), estimate: this.estimates[tick * this.scene.robots + robot], truth: this.world.truth, heard: null };
  }
};

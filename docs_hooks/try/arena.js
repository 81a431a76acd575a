"use strict";
// The source of frames where brains are tried: MicroPython runs the brain in a recorded world, in a worker.

const QUIET = 8000; // milliseconds after which a brain that does not return is ended

// a world for one accuracy: its frames, and the files that the worker needs
async function worldOf(worlds, name, accuracy) {
  const world = worlds[name];
  const { scene } = world;
  const bytes = await inflated(world.frames);
  const wide = (scene.moves ? 3 : 1) * scene.robots;
  const places = new Uint16Array(bytes, 36 + (scene.rounds + 1) * 8 * (scene.columns.length + 1), (scene.rounds + 1) * wide);
  for (let k = wide; k < places.length; k++) places[k] += places[k - wide]; // they are stored as differences
  const { frames } = framesOf(bytes);
  const readings = new Uint8Array(await inflated((worlds[world.readings]?.readings ?? world.readings)[accuracy]));
  const black = (k) => (readings[k >> 3] >> (7 - (k & 7))) & 1;
  const read = frames.slice(1).flatMap(({ flags }) => Array.from(flags, (flag) => flag & FLAG.looked));
  const blacks = scene.moves ? Uint8Array.from(read, (has, k) => (has ? black(k) : 255)) : readings;
  const heard = ({ links }) => {
    const pairs = Array.from({ length: links.length / 2 }, (_, k) => [links[2 * k], links[2 * k + 1]]);
    return pairs.flatMap(([i, j]) => [[i, j], [j, i]]).sort((a, b) => a[0] - b[0] || a[1] - b[1]).flat();
  };
  const edges = new Uint16Array(scene.moves ? [] : bytesOf(scene.edges).buffer);
  const pairs = scene.moves ? frames.slice(1).map(heard) : [[...edges]];
  const counts = Uint16Array.from(pairs, (some) => some.length / 2);
  return { ...world, frames, blacks, edges, files: { blacks, pairs: Uint8Array.from(pairs.flat()), counts: new Uint8Array(counts.buffer) } };
}

Recorded = class extends Recorded {
  async open() {
    const [worker, program, wasm] = await Promise.all(this.recording.programs.map(inflated));
    [this.wasm, this.program, this.worlds] = [wasm, new TextDecoder().decode(program), {}];
    this.address = URL.createObjectURL(new Blob([worker], { type: "text/javascript" }));
    window.addEventListener("message", ({ source, data }) => source === parent && (data.brain === undefined ? this.shade(data) : this.run(data)));
    const begun = new Promise((resolve) => (this.begun = resolve));
    parent.postMessage({ state: "ready" }, "*");
    await begun;
  }

  // light or dark, as the page is
  shade({ dark }) {
    document.documentElement.style.colorScheme = dark ? "dark" : "light";
    document.documentElement.classList.toggle("dark", dark);
    TONES.clear();
    state.charts?.build();
    again();
  }

  async run(job) {
    this.end();
    const key = `${job.world} ${job.accuracy}`;
    const world = (this.worlds[key] ??= await worldOf(this.recording.worlds, job.world, job.accuracy));
    const { robots, rounds } = world.scene;
    const liars = world.liars.slice(0, job.liars);
    this.scene = { ...world.scene, brain: job.name, dishonest: liars, opinions: /^OPINION\s*=\s*True/m.test(job.brain) };
    [this.world, this.known, this.failed, this.started] = [world, -1, null, performance.now()];
    this.estimates = new Float64Array((rounds + 1) * robots);
    this.spoke = new Uint8Array((rounds + 1) * robots);
    const told = JSON.stringify({ robots, liars, accuracy: Number(job.accuracy), looks: world.looks, delay: world.delay });
    this.worker = new Worker(this.address);
    this.worker.onmessage = ({ data }) => this.take(data);
    this.worker.postMessage({ wasm: this.wasm, program: this.program, keys: world.keys, rounds, files: { ...world.files, job: told, "brain.py": job.brain, "adversary.py": job.adversary } });
    this.first = new Promise((resolve, reject) => Object.assign(this, { resolve, reject }));
    if (this.begun) this.begun = void this.begun();
    else begin({}, 0, null).then(() => this.failed || playUnasked());
  }

  end() {
    this.worker?.terminate();
    clearTimeout(this.watch);
  }

  // what the worker says: that it is ready, what robots believe in the next rounds and which of them spoke, or an error
  take({ estimates, spoke, error }) {
    clearTimeout(this.watch);
    if (error) return this.stop({ state: "failed", text: error });
    const endless = `The brain did not return for ${QUIET / 1000} seconds, and was stopped: does each of its loops end, and do its lists stay short in memory?`;
    this.watch = setTimeout(() => this.stop({ state: "failed", text: endless }), QUIET);
    if (!estimates) return;
    const { robots, rounds } = this.scene;
    this.estimates.set(estimates, (this.known + 1) * robots);
    this.known += estimates.length / robots;
    this.spoke.set(spoke, (this.known + 1) * robots - spoke.length);
    this.resolve();
    if (this.known === rounds) this.stop({ state: "done", seconds: (performance.now() - this.started) / 1000 });
  }

  stop(news) {
    this.end();
    parent.postMessage(news, "*");
    if (news.state === "done") return;
    this.failed = new Error("The brain failed. What you see is from before.");
    this.reject(this.failed);
    state.halted = true;
    if (state.form) pause();
  }

  async begin() {
    await this.first;
    return { scenes: [this.scene], form: this.world.form };
  }

  // those frames that are there; null if there are none yet
  async frames(from, step, count) {
    const found = [];
    for (let tick = from; tick <= this.known && found.length < count; tick += step) found.push(this.frame(tick));
    if (found.length) return [found];
    if (this.failed) throw this.failed;
    return new Promise((soon) => setTimeout(soon, 20, null));
  }

  frame(tick) {
    const { frames, blacks, edges } = this.world;
    const { robots, columns, bins, dishonest, opinions, moves } = this.scene;
    const all = this.estimates.subarray(tick * robots, (tick + 1) * robots);
    const own = all.filter((_, i) => !dishonest.includes(i)).sort();
    const truth = frames[tick].numbers[columns.indexOf("truth")];
    const bin = (x) => Math.min(Math.floor(x * bins), bins - 1);
    const share = (holds) => own.filter(holds).length / own.length;
    const values = { truth, right: tick && !opinions ? share((x) => bin(x) === bin(truth)) : NaN };
    ["lowest", "low", "median", "high", "highest"].forEach((name, k) => (values[name] = quantile(own, k / 4)));
    if (opinions) [values.black, values.white] = [share((x) => x === 1), share((x) => x === 0)];
    const read = tick ? blacks.subarray((tick - 1) * robots, tick * robots) : new Uint8Array(robots).fill(255);
    const flags = frames[tick].flags.map((flag, i) => (flag & FLAG.onBlack) + (read[i] === 255 ? 0 : FLAG.looked) + (read[i] === 1 ? FLAG.readBlack : 0));
    const links = moves ? frames[tick].links : Uint8Array.from({ length: edges.length / 2 }, (_, e) => this.spoke[tick * robots + edges[2 * e + 1]]);
    return { ...frames[tick], flags, links, numbers: Float64Array.from(columns, (name) => values[name] ?? NaN), estimates: Uint16Array.from(all, (x) => Math.round(Math.min(Math.max(x, 0), 1) * MOST)) };
  }

  async robot(side, robot, tick) {
    const estimate = this.estimates[tick * this.scene.robots + robot];
    return { robot, tick, estimate, fields: {}, recorded: tick, brain: this.scene.brain, honest: !this.scene.dishonest.includes(robot), truth: NaN, heard: null };
  }
};

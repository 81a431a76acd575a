"use strict";
// Curves of the run: estimates, shares, messages. They grow as frames are seen.

const MOST_POINTS = 2000;
const FINE = 500; // first rounds, which have one point each
const GAP = 12; // pixels from which on missing points interrupt a line
const LEAST = 0.05; // the height of the axis of estimates that follows them
const [LOWEST, HEIGHT, HIGHEST] = [96, 170, 260]; // of a chart
const NAME = 18; // pixels for the name of the time axis, below the last chart
const SIDES = ["--a", "--b"];
const KINDS = { decided: ["--decided", [8, 4]], decided_right: ["--decided-right", [2, 3]], done: ["--done", [10, 3, 2, 3]] };
const WIDE = matchMedia("(min-width: 72rem)"); // windows in which charts are next to the swarm
const MEMORY = ["value", "lowest", "low", "median", "high", "highest"]; // of one field: of a robot, and of the swarm
const SHORT = new Intl.NumberFormat("en", { notation: "compact", maximumSignificantDigits: 4 });

// The points of curves: every round at first, later every n-th.
class History {
  constructor(scene, room) {
    this.columns = scene.columns;
    this.room = room; // in rounds
    const fine = Math.min(FINE, room);
    const every = Math.max(1, Math.ceil((room - fine) / MOST_POINTS));
    this.at = (tick) => (tick <= fine ? tick : fine + Math.floor((tick - fine) / every));
    this.ticks = Array.from({ length: this.at(room) + 1 }, (_, k) => (k <= fine ? k : fine + (k - fine) * every));
    this.rows = scene.columns.map(() => new Array(this.ticks.length).fill(null));
    this.seen = new Uint8Array(this.ticks.length);
  }

  put(frame) {
    const at = this.at(frame.tick);
    if (this.seen[at] && frame.tick !== this.ticks[at]) return;
    this.seen[at] = 1;
    for (let c = 0; c < this.rows.length; c++) this.rows[c][at] = Number.isNaN(frame.numbers[c]) ? null : frame.numbers[c];
  }

  // forget the points from a round on
  forget(tick) {
    const from = this.at(tick);
    this.seen.fill(0, from);
    for (const row of this.rows) row.fill(null, from);
  }

  // take over the points that another history has of the same rounds
  takeOver(other) {
    other.ticks.forEach((tick, k) => {
      const at = this.at(tick);
      if (!other.seen[k] || this.ticks[at] !== tick) return;
      this.seen[at] = 1;
      this.rows.forEach((row, c) => (row[at] = other.rows[c][k]));
    });
  }

  of(name) {
    return this.rows[this.columns.indexOf(name)];
  }

  // the first missing points before a tick, as rounds, with those between them; null if none is missing
  missing(tick) {
    const end = this.at(tick);
    const from = this.seen.subarray(0, end).indexOf(0);
    if (from < 0) return null;
    const to = from + this.seen.subarray(from, Math.min(end, from + AT_ONCE)).lastIndexOf(0) + 1;
    const last = from < FINE ? Math.min(to - 1, FINE) : to - 1; // only equally spaced points
    const by = last > from ? (this.ticks[last] - this.ticks[from]) / (last - from) : 1;
    return { from: this.ticks[from], by, count: last - from + 1 };
  }
}

function number(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  return Math.abs(value) >= 1000 || Number.isInteger(value) ? Math.round(value).toLocaleString("en") : value.toFixed(4);
}

const dim = (name, part) => `color-mix(in srgb, ${tone(name)} ${part}%, transparent)`;

// what makes a good swarm look wrong: an estimate next to the fill ratio is in its bin or in the one below
function cautionOf(scenes) {
  const { on_edges: found, bins, opinions } = scenes[0];
  if (!found.length || opinions) return "";
  return `f = ${found.join(", ")} is on the edge between two of the ${bins} bins: about half of good estimates count as wrong.`;
}

class Charts {
  // `big` is the size of letters and lines, 1 on the page; a width is that of the host where none is given
  constructor(host, scenes, seek, grows, { big = 1, width = 0, height = 0 } = {}) {
    Object.assign(this, { host, scenes, big, fixed: { width, height } });
    this.seek = seek;
    this.histories = scenes.map((scene) => new History(scene, grows ? Math.max(FINE + MOST_POINTS, scene.rounds) : scene.rounds));
    this.tick = 0;
    this.frames = []; // those of the moment, which legends tell unless the mouse points at another one
    this.settled = []; // K of each side
    this.memory = null; // the field of a robot's memory that is drawn: side, robot, name, history
    [this.log, this.full] = [false, false];
    this.due = 0;
    this.plots = [];
  }

  of() {
    return this.scenes.some(({ dishonest }) => dishonest.length) ? " of honest robots" : "";
  }

  // of one chart; those of a pair are next to each other in wide windows
  get width() {
    const columns = getComputedStyle(this.host).gridTemplateColumns.split(" ").map(Number.parseFloat);
    return this.fixed.width || Math.max(columns.length > 1 ? 160 : 260, Math.floor(columns[0]) || 0);
  }

  // where charts are next to the swarm they fill the height of the window
  fit() {
    if (this.fixed.height) return;
    const columns = this.several && WIDE.matches ? this.columns : 1;
    const stacked = this.plots.slice(-Math.ceil(this.plots.length / columns)); // one of each row: the last is the highest
    const drawn = stacked.reduce((sum, plot) => sum + plot.height, 0);
    const { top, height } = this.host.getBoundingClientRect();
    const room = window.innerHeight - top - window.scrollY - (height - drawn) - NAME - 8;
    const each = WIDE.matches ? Math.min(Math.max(Math.floor(room / stacked.length), LOWEST), HIGHEST) : HEIGHT;
    this.plots.forEach((plot, k) => plot.setSize({ width: this.width, height: each + (k === this.plots.length - 1 ? NAME : 0) }));
  }

  // of the charts of a pair in wide windows
  get columns() {
    return this.memory ? 2 : 3;
  }

  get several() {
    return this.scenes.length > 1;
  }

  label(text, side) {
    return this.several ? `${text}, ${this.scenes[side].brain}` : text;
  }

  build(log = this.log, full = this.full) {
    [this.log, this.full] = [log, full];
    this.destroy();
    this.fitted = false;
    this.host.style.setProperty("--charts", this.columns);
    this.plots = [...(this.memory ? [this.remembered()] : []), this.estimates(), ...(judged() || this.scenes[0].options || this.scenes[0].ends ? [this.shares()] : []), this.messages()];
    this.refresh();
  }

  destroy() {
    for (const plot of this.plots) plot.destroy();
    this.plots = [];
    this.host.replaceChildren();
  }

  xs() {
    return this.histories[0].ticks.map((tick) => tick || (this.log ? Number.EPSILON : 0)); // 0 has no logarithm
  }

  make(title, unit, series, names, bands = [], more = {}) {
    const values = () => names.map(([side, name]) => this.historyOf(side).of(name));
    const { big } = this;
    series.forEach((one, k) => (one.value = (u, value) => number(u.cursor.left >= 0 ? value : this.now(...names[k]))));
    const moment = (u, tick) => (u.cursor.left >= 0 && tick !== null ? Math.round(tick) : this.tick).toLocaleString("en");
    const box = document.createElement("div");
    box.className = "chart";
    const head = document.createElement("h3");
    head.textContent = title;
    box.append(head);
    if (more.caution) box.append(element("p", { class: "caution" }, more.caution));
    this.host.append(box);
    const axis = { stroke: tone("--soft"), grid: { stroke: tone("--line"), width: 1 }, ticks: { stroke: tone("--line") }, font: `${12 * big}px system-ui, sans-serif`, labelFont: `${12 * big}px system-ui, sans-serif`, labelSize: 20 * big, labelGap: 0 };
    const plot = new uPlot(
      {
        width: this.width, height: this.fixed.height || HEIGHT, bands, padding: [15 * big, 20 * big, 0, 0],
        scales: { x: { time: false, distr: this.log ? 3 : 1, range: () => [this.log ? 1 : 0, this.end()] }, y: { range: (_, low, high) => (more.range ? more.range() : [0, Math.max(high || 0, 1)]) } },
        axes: [{ ...axis, size: 28 * big, space: 60 * big, ...(more.last ? { label: this.scenes[0].unit, labelSize: NAME * big } : {}) }, { ...axis, label: unit, size: 56 * big, space: 26 * big, values: (_, ticks) => ticks.map((tick) => SHORT.format(tick)) }],
        series: [{ label: this.scenes[0].unit, value: moment }, ...series],
        legend: { live: true, markers: { dash: (u, i) => (u.series[i].dash ? "dashed" : "solid") } },
        cursor: { drag: { setScale: false } },
        hooks: {
          draw: [(u) => this.mark(u)],
          ready: [
            (u) => {
              u.over.addEventListener("click", () => this.seek(Math.round(u.posToVal(u.cursor.left, "x"))));
              u.over.addEventListener("mouseleave", () => u.setLegend({ idx: null }));
            },
          ],
        },
      },
      [this.xs(), ...values()],
      box,
    );
    // a style sheet may hide the brains of a pair, which colours tell too
    box.querySelectorAll(".u-label").forEach((label, k) => {
      const { text, label: whole } = plot.series[k];
      if (whole.startsWith(`${text}, `)) label.replaceChildren(text, element("span", { class: "brain" }, whole.slice(text.length)));
    });
    plot.values = values;
    return plot;
  }

  historyOf(side) {
    return side === MEMORY ? this.memory.history : this.histories[side];
  }

  now(side, name) {
    if (side === MEMORY) return this.memory.history.of(name)[this.memory.history.at(this.tick)];
    return this.frames[side]?.numbers[this.scenes[side].columns.indexOf(name)];
  }

  // the moment, and K
  mark(u) {
    const g = u.ctx;
    const { left, top, width, height } = u.bbox;
    const line = (x, colour, dash) => {
      g.strokeStyle = tone(colour);
      g.setLineDash(dash);
      g.beginPath();
      g.moveTo(x, top);
      g.lineTo(x, top + height);
      g.stroke();
    };
    g.save();
    const unit = this.big * devicePixelRatio;
    g.lineWidth = 1.5 * unit;
    g.font = `bold ${12 * unit}px system-ui, sans-serif`;
    g.textBaseline = "top";
    this.settled.forEach((k, side) => {
      const x = !k || k > this.tick ? -1 : u.valToPos(Math.max(k, this.log ? 1 : 0), "x", true);
      if (x < left || x > left + width) return;
      line(x, SIDES[side], [3 * unit, 3 * unit]);
      g.fillStyle = tone(this.several ? SIDES[side] : "--ink");
      g.textAlign = this.several ? ["right", "left"][side] : "center"; // above the curves
      g.fillText("K", x, top - 13 * unit);
    });
    line(u.valToPos(this.tick, "x", true), "--ink", []);
    g.restore();
  }

  line(text, side, more = {}) {
    const gaps = (u, k, from, to, found) => (this.log ? [] : found.filter(([left, right]) => right - left > GAP * devicePixelRatio));
    return { text, label: this.label(text, side), stroke: tone(SIDES[side]), width: (this.several && side === 0 ? 4 : 2) * this.big, points: { show: false }, gaps, ...more };
  }

  // of a pair the colour tells the side, otherwise what is counted
  kind(text, side, name) {
    const [colour, dash] = KINDS[name];
    return this.line(text, side, { dash, ...(this.several ? {} : { stroke: tone(colour) }) });
  }

  estimates() {
    const opinions = this.scenes.filter(({ opinions }) => opinions).length;
    const series = judged() ? [{ ...this.line("truth", 0, { stroke: tone("--ink"), dash: [6, 4], width: 1.5 * this.big }), label: "fill ratio" }] : [];
    const names = judged() ? [[0, "truth"]] : [];
    const bands = [];
    this.scenes.forEach((scene, side) => {
      if (scene.opinions) {
        series.push(this.line("for black", side), this.line("for white", side, { dash: [2, 3] }));
        names.push([side, "black"], [side, "white"]);
        return;
      }
      this.spread(side, side, series, names, bands);
      series.push(this.line("median", side));
      names.push([side, "median"]);
      if (scene.layers & LAYER.intervals) {
        const dotted = { dash: [2, 3], width: 1.5 * this.big };
        series.push(this.line("interval from", side, dotted), this.line("to", side, dotted));
        names.push([side, "interval_low"], [side, "interval_high"]);
      }
    });
    const alike = opinions ? `Opinions${this.of()}: shares for black and white` : `Estimates${this.of()}: median, middle half, range`;
    const title = opinions % this.scenes.length ? "Estimates, and shares of opinions" : alike;
    const range = () => (this.full || opinions ? [0, 1] : this.followed());
    return this.make(title, opinions ? "share" : "fill ratio", series, names, bands, { range });
  }

  // bands from the lowest to the highest value, and of the middle half
  spread(of, side, series, names, bands) {
    const first = series.length + 1;
    const hidden = { width: 0, stroke: "transparent", class: "quiet" };
    for (const [name, text] of [["highest", "highest"], ["lowest", "lowest"], ["high", "upper quarter"], ["low", "lower quarter"]]) {
      series.push(this.line(text, side, hidden));
      names.push([of, name]);
    }
    bands.push({ series: [first, first + 1], fill: dim(SIDES[side], 14) }, { series: [first + 2, first + 3], fill: dim(SIDES[side], 30) });
  }

  // one field of a robot's memory, and of the swarm's
  remembered() {
    const { side, robot, name, history } = this.memory;
    const [series, names, bands] = [[], [], []];
    this.spread(MEMORY, side, series, names, bands);
    series.push({ ...this.line("median", side, { dash: [6, 4], width: 1.5 * this.big }), label: "median" }, { ...this.line("", side, { stroke: tone("--ink"), width: 2 * this.big }), label: `robot ${robot}` });
    names.push([MEMORY, "median"], [MEMORY, "value"]);
    const range = () => {
      const known = ["value", "lowest", "highest"].flatMap((one) => history.of(one)).filter((value) => value !== null);
      const [low, high] = [Math.min(...known), Math.max(...known)];
      return low < high ? [low, high] : known.length ? [low - 0.5, low + 0.5] : [0, 1];
    };
    return this.make(`${this.label(name, side)}: robot ${robot}, and the swarm`, name, series, names, bands, { range });
  }

  // draw a field of a robot's memory; null: no longer
  remember(what) {
    const same = this.memory && what && ["side", "robot", "name"].every((key) => this.memory[key] === what[key]);
    if (same || (!this.memory && !what)) return;
    this.memory = what && { ...what, history: new History({ columns: MEMORY }, this.histories[0].room) };
    this.build();
  }

  // take the rows of an answer: a round, and the values of MEMORY
  putMemory(rows) {
    for (const [tick, ...numbers] of rows) this.memory.history.put({ tick, numbers: numbers.map((value) => (typeof value === "number" ? value : NaN)) });
  }

  // the range of the estimates and of the truth, without the first quarter of what is seen
  followed() {
    let [low, high] = [1, 0];
    for (const history of this.histories) {
      const last = history.seen.lastIndexOf(1);
      const from = history.at(Math.floor(history.ticks[Math.max(last, 0)] / 4));
      for (const name of ["truth", "lowest", "highest"]) {
        const row = history.of(name);
        for (let k = from; k <= last; k++) if (row[k] !== null) [low, high] = [Math.min(low, row[k]), Math.max(high, row[k])];
      }
    }
    if (low > high) return [0, 1];
    const room = Math.max(0.06 * (high - low), (LEAST - (high - low)) / 2);
    return [Math.max(0, low - room), Math.min(1, high + room)];
  }

  shares() {
    const series = [];
    const names = [];
    this.scenes.forEach((scene, side) => {
      if (!scene.opinions && judged()) {
        series.push(this.line(`in right bin (of ${scene.bins})`, side));
        names.push([side, "right"]);
      }
      if (scene.options) {
        series.push(this.kind("decided", side, "decided"), this.kind(`decided right (of ${scene.options})`, side, "decided_right"));
        names.push([side, "decided"], [side, "decided_right"]);
      }
      if (scene.ends) {
        series.push(this.kind("done", side, "done"));
        names.push([side, "done"]);
      }
    });
    const caution = cautionOf(this.scenes);
    return this.make(`Shares of ${this.of() ? "honest " : ""}robots`, "share", series, names, [], { range: () => [0, 1], caution });
  }

  messages() {
    const series = [];
    const names = [];
    this.scenes.forEach((_, side) => {
      series.push(this.line("sent", side, { dash: [6, 4] }), this.line("heard", side));
      names.push([side, "sent"], [side, "heard"]);
    });
    return this.make("Messages so far: sent (dashed), heard", "messages", series, names, [], { last: true });
  }

  put(side, frames) {
    for (const frame of frames) this.histories[side].put(frame);
  }

  // logs have grown: points from a round on are others now
  grow(tick) {
    for (const history of this.histories) history.forget(tick);
    this.memory?.history.forget(tick);
    while (this.scenes[0].rounds > this.histories[0].room) {
      this.histories = this.histories.map((history, side) => {
        const made = new History(this.scenes[side], FINE + 2 * (history.room - FINE));
        made.takeOver(history);
        return made;
      });
      if (this.memory) this.memory.history = new History({ columns: MEMORY }, this.histories[0].room);
    }
  }

  // at most five times a second, not with every frame
  show(tick, frames, now, force = false) {
    [this.tick, this.frames] = [tick, frames];
    if (!force && now < this.due) return;
    this.due = now + 200;
    this.refresh();
  }

  // legends tell the moment, unless the mouse points at another one
  tell() {
    for (const plot of this.plots) if (!(plot.cursor.left >= 0)) plot.setLegend({ idx: null });
  }

  refresh() {
    for (const plot of this.plots) plot.setData([this.xs(), ...plot.values()]);
    this.tell();
    if (this.fitted || !this.frames.length) return;
    this.fitted = true;
    requestAnimationFrame(() => this.fit()); // before that, new charts have no size of their own
  }

  // the end of the time axis, which grows with the frames seen
  end() {
    const { seen, ticks } = this.histories[0];
    return Math.max(2, Math.min(this.scenes[0].rounds, Math.max(50, Math.ceil(1.2 * (ticks[seen.lastIndexOf(1)] || 0)))));
  }
}

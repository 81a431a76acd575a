"use strict";
// Curves of the run: estimates, shares, messages. They grow as frames are seen.

const MOST_POINTS = 2000;
const FINE = 500; // first rounds, which have one point each
const GAP = 12; // pixels from which on missing points interrupt a line
const NEAR = 0.1; // half the height of the close-up around the fill ratio
const SIDES = ["--a", "--b"];
const SHORT = new Intl.NumberFormat("en", { notation: "compact" });

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

  // the first run of missing points before a tick, as rounds; null if none is missing
  missing(tick) {
    const end = this.at(tick);
    const from = this.seen.subarray(0, end).indexOf(0);
    if (from < 0) return null;
    const next = this.seen.subarray(from, end).indexOf(1);
    const to = next < 0 ? end : from + next;
    const last = from < FINE ? Math.min(to - 1, FINE) : to - 1; // only equally spaced points
    const by = last > from ? (this.ticks[last] - this.ticks[from]) / (last - from) : 1;
    return { from: this.ticks[from], by, count: last - from + 1 };
  }
}

const dim = (name, part) => `color-mix(in srgb, ${tone(name)} ${part}%, transparent)`;

class Charts {
  constructor(host, scenes, seek, grows) {
    this.host = host;
    this.scenes = scenes;
    this.seek = seek;
    this.histories = scenes.map((scene) => new History(scene, grows ? Math.max(FINE + MOST_POINTS, scene.rounds) : scene.rounds));
    this.tick = 0;
    [this.log, this.close] = [false, false];
    this.due = 0;
    this.plots = [];
  }

  get several() {
    return this.scenes.length > 1;
  }

  label(text, side) {
    return this.several ? `${text}, ${this.scenes[side].brain}` : text;
  }

  build(log = this.log, close = this.close) {
    [this.log, this.close] = [log, close];
    this.destroy();
    this.plots = [this.estimates(), this.shares(), this.messages()];
    this.refresh();
  }

  destroy() {
    for (const plot of this.plots) plot.destroy();
    this.host.replaceChildren();
  }

  xs() {
    return this.histories[0].ticks.map((tick) => tick || (this.log ? Number.EPSILON : 0)); // 0 has no logarithm
  }

  make(title, unit, series, values, bands = [], more = {}) {
    const box = document.createElement("div");
    box.className = "chart";
    const head = document.createElement("h3");
    head.textContent = title;
    box.append(head);
    this.host.append(box);
    const axis = { stroke: tone("--soft"), grid: { stroke: tone("--line"), width: 1 }, ticks: { stroke: tone("--line") }, font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif", labelSize: 20, labelGap: 0 };
    const plot = new uPlot(
      {
        width: Math.max(260, this.host.clientWidth), height: 190, bands,
        scales: { x: { time: false, distr: this.log ? 3 : 1, range: () => [this.log ? 1 : 0, this.end()] }, y: { range: (_, low, high) => (more.range ? more.range() : [0, Math.max(high || 0, 1)]) } },
        axes: [{ ...axis, label: this.scenes[0].unit, size: 36 }, { ...axis, label: unit, size: 62, values: (_, ticks) => ticks.map((tick) => SHORT.format(tick)) }],
        series: [{ label: this.scenes[0].unit }, ...series],
        legend: { live: true, markers: { dash: (u, i) => (u.series[i].dash ? "dashed" : "solid") } },
        cursor: { drag: { setScale: false } },
        hooks: {
          draw: [(u) => this.mark(u)],
          ready: [(u) => u.over.addEventListener("click", () => this.seek(Math.round(u.posToVal(u.cursor.left, "x"))))],
        },
      },
      [this.xs(), ...values()],
      box,
    );
    plot.values = values;
    return plot;
  }

  mark(u) {
    const x = u.valToPos(this.tick, "x", true);
    const g = u.ctx;
    g.save();
    g.strokeStyle = tone("--ink");
    g.lineWidth = 1.5;
    g.setLineDash([]);
    g.beginPath();
    g.moveTo(x, u.bbox.top);
    g.lineTo(x, u.bbox.top + u.bbox.height);
    g.stroke();
    g.restore();
  }

  line(text, side, more = {}) {
    const gaps = (u, k, from, to, found) => (this.log ? [] : found.filter(([left, right]) => right - left > GAP * devicePixelRatio));
    const value = (_, v) => (v === null || v === undefined ? "–" : Math.abs(v) >= 1000 ? Math.round(v).toLocaleString("en") : v.toPrecision(4).replace(/\.?0+$/, ""));
    return { label: this.label(text, side), stroke: tone(SIDES[side]), width: this.several && side === 0 ? 4 : 2, value, points: { show: false }, gaps, ...more };
  }

  estimates() {
    const series = [{ ...this.line("truth", 0, { stroke: tone("--ink"), dash: [6, 4], width: 1.5 }), label: "fill ratio" }];
    const names = [[0, "truth"]];
    const bands = [];
    this.scenes.forEach((scene, side) => {
      const first = series.length + 1;
      const hidden = { width: 0, stroke: "transparent", class: "quiet" };
      series.push(
        this.line("highest", side, hidden), this.line("lowest", side, hidden), this.line("upper quarter", side, hidden),
        this.line("lower quarter", side, hidden), this.line("median", side),
      );
      names.push([side, "highest"], [side, "lowest"], [side, "high"], [side, "low"], [side, "median"]);
      bands.push({ series: [first, first + 1], fill: dim(SIDES[side], 14) }, { series: [first + 2, first + 3], fill: dim(SIDES[side], 30) });
      if (scene.layers & LAYER.intervals) {
        const dotted = { dash: [2, 3], width: 1.5 };
        series.push(this.line("interval from", side, dotted), this.line("to", side, dotted));
        names.push([side, "interval_low"], [side, "interval_high"]);
      }
    });
    return this.make("Estimates: median, middle half and range of the honest robots", "fill ratio", series, () => names.map(([side, name]) => this.histories[side].of(name)), bands, { range: () => this.closely() });
  }

  // the range of the axis of estimates
  closely() {
    const truth = this.histories[0].of("truth").findLast((value) => value !== null) ?? 0.5;
    return this.close ? [Math.max(0, truth - NEAR), Math.min(1, truth + NEAR)] : [0, 1];
  }

  shares() {
    const series = [];
    const names = [];
    this.scenes.forEach((scene, side) => {
      series.push(this.line("in the right bin", side));
      names.push([side, "right"]);
      if (scene.options) {
        series.push(this.line("decided", side, { dash: [8, 4] }), this.line("decided right", side, { dash: [2, 3] }));
        names.push([side, "decided"], [side, "decided_right"]);
      }
      if (scene.ends) {
        series.push(this.line("done", side, { dash: [8, 3, 2, 3] }));
        names.push([side, "done"]);
      }
    });
    return this.make("Shares of the honest robots", "share", series, () => names.map(([side, name]) => this.histories[side].of(name)), [], { range: () => [0, 1] });
  }

  messages() {
    const series = [];
    const names = [];
    this.scenes.forEach((_, side) => {
      series.push(this.line("sent", side, { dash: [6, 4] }), this.line("heard", side));
      names.push([side, "sent"], [side, "heard"]);
    });
    return this.make("Messages of all robots so far", "messages", series, () => names.map(([side, name]) => this.histories[side].of(name)));
  }

  put(side, frames) {
    for (const frame of frames) this.histories[side].put(frame);
  }

  // logs have grown: points from a round on are others now
  grow(tick) {
    for (const history of this.histories) history.forget(tick);
    while (this.scenes[0].rounds > this.histories[0].room) {
      this.histories = this.histories.map((history, side) => {
        const made = new History(this.scenes[side], FINE + 2 * (history.room - FINE));
        made.takeOver(history);
        return made;
      });
    }
  }

  // at most five times a second, not with every frame
  show(tick, now, force = false) {
    this.tick = tick;
    if (!force && now < this.due) return;
    this.due = now + 200;
    this.refresh();
  }

  refresh() {
    const idx = this.histories[0].at(this.tick);
    for (const plot of this.plots) {
      plot.setData([this.xs(), ...plot.values()]);
      plot.setLegend({ idx });
    }
  }

  // the end of the time axis, which grows with the frames seen
  end() {
    const { seen, ticks } = this.histories[0];
    return Math.max(2, Math.min(this.scenes[0].rounds, Math.max(50, Math.ceil(1.2 * (ticks[seen.lastIndexOf(1)] || 0)))));
  }

  resize() {
    for (const plot of this.plots) plot.setSize({ width: Math.max(260, this.host.clientWidth), height: 190 });
  }
}

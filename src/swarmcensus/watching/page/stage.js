"use strict";
// One swarm on a canvas: the floor and who stands where, or the network and what it carries.

const FLOOR = { black: [112, 117, 122], white: [226, 229, 232], grey: (f) => [226 - 114 * f, 229 - 112 * f, 232 - 110 * f] };

class Stage {
  constructor(canvas, scene) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.scene = scene;
    this.dishonest = new Set(scene.dishonest);
    this.zoom = 1;
    this.centre = [0.5, 0.5];
    this.frame = null;
    this.colour = "belief";
    this.chosen = null;
    this.follow = false;
    if (scene.moves) this.layFloor();
    else {
      this.places = new Float32Array(bytesOf(scene.places).buffer);
      this.edges = new Uint16Array(bytesOf(scene.edges).buffer);
      this.pairs = this.pair();
      this.room = this.roomBetween();
    }
  }

  layFloor() {
    const { floor, across, turns } = this.scene;
    if (!floor) return;
    const packed = bytesOf(floor);
    this.turns = turns ? new Int32Array(bytesOf(turns).buffer) : null;
    this.tiles = new Uint8Array(across * across);
    for (let i = 0; i < this.tiles.length; i++) this.tiles[i] = (packed[i >> 3] >> (7 - (i & 7))) & 1;
    this.painted = document.createElement("canvas");
    this.painted.width = this.painted.height = across;
    this.paint(1);
  }

  paint(tick) {
    const { across } = this.scene;
    const image = new ImageData(across, across);
    for (let row = 0; row < across; row++) {
      for (let column = 0; column < across; column++) {
        const i = row * across + column;
        const black = this.tiles[i] ^ (this.turns && tick >= this.turns[i] ? 1 : 0);
        image.data.set([...(black ? FLOOR.black : FLOOR.white), 255], 4 * ((across - 1 - row) * across + column));
      }
    }
    this.painted.getContext("2d").putImageData(image, 0, 0);
    this.paintedAt = tick;
  }

  // directed links as lines to draw, each with the one or two links that it stands for
  pair() {
    const lines = new Map();
    for (let e = 0; 2 * e < this.edges.length; e++) {
      const [i, j] = [this.edges[2 * e], this.edges[2 * e + 1]].sort((a, b) => a - b);
      const key = i * 65536 + j;
      if (!lines.has(key)) lines.set(key, { i, j, links: [] });
      lines.get(key).links.push(e);
    }
    return [...lines.values()];
  }

  // where robot i is, in [0, 1], y upwards
  place(i, frame = this.frame) {
    if (frame.x) return [frame.x[i] / 65535, frame.y[i] / 65535];
    return [this.places[2 * i], 1 - this.places[2 * i + 1]];
  }

  toScreen([x, y]) {
    const size = this.canvas.width;
    return [((x - this.centre[0]) * this.zoom + 0.5) * size, (0.5 - (y - this.centre[1]) * this.zoom) * size];
  }

  robotAt(clientX, clientY) {
    if (!this.frame) return null;
    const box = this.canvas.getBoundingClientRect();
    const scale = this.canvas.width / box.width;
    const [px, py] = [(clientX - box.left) * scale, (clientY - box.top) * scale];
    let best = null;
    let near = Math.max(this.radius() + 4, 14) * scale;
    for (let i = 0; i < this.scene.robots; i++) {
      const [x, y] = this.toScreen(this.place(i));
      const distance = Math.hypot(x - px, y - py);
      if (distance < near) [best, near] = [i, distance];
    }
    return best;
  }

  radius() {
    const size = this.canvas.width;
    if (this.scene.moves) return Math.max((this.scene.radius / this.scene.side) * size * this.zoom, 2.2);
    return Math.min(Math.max(0.4 * this.room * size * this.zoom, size / 180), size / 44);
  }

  // how far apart robots that are side by side are, as a rule
  roomBetween() {
    const { robots } = this.scene;
    if (robots > 400 || robots < 2) return 1 / Math.ceil(Math.sqrt(robots));
    const nearest = [];
    for (let i = 0; i < robots; i++) {
      let near = 1;
      for (let j = 0; j < robots; j++) if (j !== i) near = Math.min(near, Math.hypot(this.places[2 * i] - this.places[2 * j], this.places[2 * i + 1] - this.places[2 * j + 1]));
      nearest.push(near);
    }
    return nearest.sort((a, b) => a - b)[robots >> 1];
  }

  fit() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const size = Math.max(64, Math.round(this.canvas.clientWidth * ratio));
    if (this.canvas.width !== size) this.canvas.width = this.canvas.height = size;
  }

  draw(frame) {
    this.frame = frame;
    this.fit();
    if (this.follow && this.chosen !== null) this.centre = this.place(this.chosen);
    const g = this.context;
    const size = this.canvas.width;
    g.fillStyle = tone("--sheet");
    g.fillRect(0, 0, size, size);
    if (this.scene.moves) this.drawFloor(frame);
    this.drawLinks(frame);
    if (!this.scene.moves && this.scene.robots > 400) this.drawSquares(frame);
    else this.drawRobots(frame);
    if (this.chosen !== null && this.chosen < this.scene.robots) this.drawChosen(frame);
  }

  drawFloor(frame) {
    const g = this.context;
    const [left, top] = this.toScreen([0, 1]);
    const [right, bottom] = this.toScreen([1, 0]);
    if (this.painted) {
      if (this.turns && frame.tick !== this.paintedAt) this.paint(frame.tick);
      const { side, tile, across } = this.scene;
      const beyond = ((across * tile) / side - 1) / 2; // walls cut through the outermost tiles
      const [x, y] = this.toScreen([-beyond, 1 + beyond]);
      const width = this.toScreen([1 + beyond, 0])[0] - x;
      g.save();
      g.beginPath();
      g.rect(left, top, right - left, bottom - top);
      g.clip();
      g.imageSmoothingEnabled = across > this.canvas.width;
      g.drawImage(this.painted, x, y, width, width);
      g.restore();
    } else {
      g.fillStyle = `rgb(${FLOOR.grey(frame.numbers[0]).map(Math.round).join(" ")})`;
      g.fillRect(left, top, right - left, bottom - top);
    }
    g.strokeStyle = tone("--ink");
    g.lineWidth = 2;
    g.strokeRect(left, top, right - left, bottom - top);
  }

  drawLinks(frame) {
    const g = this.context;
    if (this.scene.moves) {
      g.beginPath();
      for (let e = 0; e < frame.links.length; e += 2) {
        g.moveTo(...this.toScreen(this.place(frame.links[e])));
        g.lineTo(...this.toScreen(this.place(frame.links[e + 1])));
      }
      const width = Math.max(1.5, this.canvas.width / 320);
      for (const [colour, more] of [["#ffffff", 2 * (this.scene.robots <= 300)], ["#007a59", 0]]) {
        g.strokeStyle = colour;
        g.lineWidth = width + more;
        g.stroke();
      }
      return;
    }
    const dense = this.pairs.length > 1000;
    for (const lit of [false, true]) {
      g.strokeStyle = lit ? `rgb(0 158 115 / ${dense ? 0.25 : 0.85})` : tone("--line");
      g.lineWidth = lit && !dense ? 2 : 1;
      g.beginPath();
      for (const { i, j, links } of this.pairs) {
        if (links.some((e) => frame.links[e]) !== lit) continue;
        g.moveTo(...this.toScreen(this.place(i)));
        g.lineTo(...this.toScreen(this.place(j)));
      }
      g.stroke();
    }
  }

  // robots by colour, so that the colour is set once for all that have it
  byColour(frame) {
    const groups = new Map();
    const truth = frame.numbers[0];
    for (let i = 0; i < this.scene.robots; i++) {
      const step = stepOf(this.colour, frame.estimates[i], truth);
      if (!groups.has(step)) groups.set(step, []);
      groups.get(step).push(i);
    }
    return groups;
  }

  drawSquares(frame) {
    const g = this.context;
    const cell = (this.canvas.width / Math.ceil(Math.sqrt(this.scene.robots))) * this.zoom;
    for (const [step, robots] of this.byColour(frame)) {
      g.fillStyle = SCALES[this.colour][step];
      for (const i of robots) {
        const [x, y] = this.toScreen(this.place(i));
        g.fillRect(x - 0.46 * cell, y - 0.46 * cell, 0.92 * cell, 0.92 * cell);
      }
    }
    this.drawLiars(frame, cell / 2);
  }

  drawRobots(frame) {
    const g = this.context;
    const r = this.radius();
    const edge = Math.max(1, r / 6);
    for (const [step, robots] of this.byColour(frame)) {
      g.fillStyle = SCALES[this.colour][step];
      g.beginPath();
      for (const i of robots) {
        const [x, y] = this.toScreen(this.place(i));
        g.moveTo(x + r, y);
        g.arc(x, y, r, 0, 2 * Math.PI);
      }
      g.fill();
      g.lineWidth = edge;
      g.strokeStyle = r > 4 ? "#101010" : "rgb(0 0 0 / 0.5)";
      g.stroke();
    }
    if (this.scene.moves && r > 3) this.drawHeadings(frame, r);
    this.drawLiars(frame, r);
  }

  drawHeadings(frame, r) {
    const g = this.context;
    const wrong = [];
    g.strokeStyle = "#000000";
    g.lineWidth = Math.max(1.2, r / 5);
    g.beginPath();
    for (let i = 0; i < this.scene.robots; i++) {
      const [x, y] = this.toScreen(this.place(i));
      const angle = (frame.headings[i] / 256) * 2 * Math.PI;
      g.moveTo(x, y);
      g.lineTo(x + r * Math.cos(angle), y - r * Math.sin(angle));
      const flags = frame.flags[i];
      if (flags & FLAG.looked && !(flags & FLAG.readBlack) !== !(flags & FLAG.onBlack)) wrong.push([x, y]);
    }
    g.stroke();
    g.strokeStyle = "#d55e00";
    g.lineWidth = Math.max(1.5, r / 4);
    g.beginPath();
    for (const [x, y] of wrong) {
      g.moveTo(x + r * 1.35, y);
      g.arc(x, y, r * 1.35, 0, 2 * Math.PI);
    }
    g.stroke();
  }

  // a shape, and no colour alone, says who lies
  drawLiars(frame, r) {
    const g = this.context;
    g.strokeStyle = "#cc79a7";
    g.lineWidth = Math.max(1.5, r / 3.5);
    g.beginPath();
    for (const i of this.dishonest) {
      const [x, y] = this.toScreen(this.place(i));
      g.moveTo(x - r, y - r);
      g.lineTo(x + r, y + r);
      g.moveTo(x + r, y - r);
      g.lineTo(x - r, y + r);
    }
    g.stroke();
  }

  drawChosen(frame) {
    const g = this.context;
    const r = this.radius();
    const [x, y] = this.toScreen(this.place(this.chosen));
    for (const [colour, width] of [["#000000", 5], ["#ffffff", 2.5]]) {
      g.strokeStyle = colour;
      g.lineWidth = width;
      g.beginPath();
      g.arc(x, y, r + 5, 0, 2 * Math.PI);
      g.stroke();
    }
    if (this.scene.moves) {
      g.setLineDash([4, 5]);
      g.strokeStyle = "#009e73";
      g.lineWidth = 1.5;
      g.beginPath();
      g.arc(x, y, (this.scene.range / this.scene.side) * this.canvas.width * this.zoom, 0, 2 * Math.PI);
      g.stroke();
      g.setLineDash([]);
    }
  }

  near(factor) {
    this.zoom = Math.min(Math.max(this.zoom * factor, 1), 40);
    if (this.zoom === 1) this.centre = [0.5, 0.5];
  }

  shift(dx, dy) {
    const size = this.canvas.clientWidth * this.zoom;
    this.centre = [this.centre[0] - dx / size, this.centre[1] + dy / size];
  }
}

"use strict";
// One swarm: the floor and the robots on it, or the network and its messages, in units of the width, with y downwards.
// Konva manages layers, scales units to pixels, and reports clicks and drags.

Konva.autoDrawEnabled = false; // draw() is called explicitly for each frame
Konva.dragDistance = 4;
Konva.pixelRatio = Math.min(window.devicePixelRatio || 1, 2);

const MANY = 300; // robots that would be lost on a floor of much contrast
const tilesOf = ({ robots }) => (robots > MANY ? [[136, 140, 144], [92, 96, 100]] : [[208, 212, 216], [56, 60, 64]]); // white, black
const GREEN = "#007a59"; // of links of a network on a white line
const BLACK = "#101010"; // of what lies on a floor, on a white line: green and grey are hard to tell apart for many people
const MARGIN = 8; // pixels around the swarm, so that the ring of a chosen robot is not cut
const COVERED = 0.2; // the part of the picture that all links together may cover: many are drawn thin

const SMALL = 3; // pixels up to which the radius of a moving robot is small
const RIM = 2; // pixels of white around a robot that moves

function circles(g, places, r) {
  for (const [x, y] of places) {
    g.moveTo(x + r, y);
    g.arc(x, y, r, 0, 2 * Math.PI);
  }
}

class Stage {
  constructor(host, scene, view, { choose, changed, moved }) {
    Object.assign(this, { host, scene, view, frame: null, before: [], colour: "off", chosen: null, follow: false, own: null });
    this.konva = new Konva.Stage({ container: host, width: 1, height: 1 });
    this.layers = ["ground", "web", "swarm"].map((name) => (this[name] = new Konva.Layer({ listening: false })));
    this.konva.add(...this.layers);
    if (scene.moves) this.layFloor();
    else this.layNetwork();
    this.layRobots();
    this.listen(choose, changed, moved);
  }

  // a path that is traced again for each frame; the width of its lines is in pixels at any zoom
  path(layer, trace, attributes = {}) {
    const sceneFunc = (g, own) => {
      g.beginPath();
      trace(g);
      g.fillStrokeShape(own);
    };
    const made = new Konva.Shape({ sceneFunc, strokeScaleEnabled: false, ...attributes });
    layer.add(made);
    return made;
  }

  layFloor() {
    const { floor, turns, across, side, tile } = this.scene;
    const inside = (this.inside = new Konva.Group({ clip: { x: 0, y: 0, width: 1, height: 1 } }));
    if (floor) {
      this.tiles = bytesOf(floor); // eight in a byte
      this.turns = turns ? new Int32Array(bytesOf(turns).buffer) : [];
      const beyond = ((across * tile) / side - 1) / 2; // walls cut through the outermost tiles
      inside.add(this.pixels(across, { x: -beyond, y: -beyond, width: 1 + 2 * beyond, height: 1 + 2 * beyond }));
    } else inside.add((this.even = new Konva.Rect({ width: 1, height: 1 })));
    this.wall = new Konva.Rect({ width: 1, height: 1, strokeWidth: 2, strokeScaleEnabled: false });
    this.ground.add(inside, this.wall);
    const inReach = (g) => {
      const { links } = this.frame;
      if (this.isSmall) return; // they would hide the robots
      for (let e = 0; e < links.length; e += 2) this.trace(g, links[e], links[e + 1]);
    };
    this.path(this.swarm, inReach, { stroke: "#ffffff", strokeWidth: 4 });
    this.path(this.swarm, inReach, { stroke: BLACK, strokeWidth: 1.5 });
    this.layOwn();
  }

  layNetwork() {
    this.places = new Float32Array(bytesOf(this.scene.places).buffer);
    this.edges = new Uint16Array(bytesOf(this.scene.edges).buffer);
    this.lines = this.paired();
    const { crowd } = this.scene;
    if (crowd) this.swarm.add(this.pixels(crowd, { width: 1, height: 1 }));
    const length = ({ i, j }) => Math.hypot(...this.place(i).map((at, k) => at - this.place(j)[k]));
    this.length = this.lines.reduce((sum, line) => sum + length(line), 0);
    this.still = this.path(this.ground, (g) => this.lines.forEach(({ i, j }) => this.trace(g, i, j)), { visible: !crowd });
    const lit = (g) => {
      for (const line of this.near()) if (line.links.some((e) => this.frame.links[e])) this.trace(g, line.i, line.j);
    };
    if (crowd) this.path(this.swarm, lit, { stroke: "#ffffff", strokeWidth: 4.5 });
    this.layOwn();
    this.lit = this.path(crowd ? this.swarm : this.web, lit, { strokeWidth: 2 });
  }

  // in a crowd lines would hide each other: only those of the chosen robot are drawn
  near() {
    if (!this.scene.crowd) return this.lines;
    if (this.nearTo !== this.chosen) {
      this.nearTo = this.chosen;
      this.nearLines = this.lines.filter(({ i, j }) => i === this.chosen || j === this.chosen);
    }
    return this.nearLines ?? [];
  }

  // the links of the chosen robot where all would be too many: grey, and green where they carried a message, or black on a floor
  layOwn() {
    const links = (carried) => (g) => this.own?.hears.forEach((sender, k) => Boolean(this.own.carried[k]) === carried && this.trace(g, this.own.robot, sender));
    this.path(this.swarm, links(false), { stroke: "#6b7278", strokeWidth: 1 });
    this.path(this.swarm, links(true), { stroke: "#ffffff", strokeWidth: 3.5 });
    this.path(this.swarm, links(true), { stroke: this.scene.moves ? BLACK : GREEN, strokeWidth: 1.5 });
  }

  layRobots() {
    const { crowd, moves, robots } = this.scene;
    this.groups = SCALES.belief.map(() => []);
    this.trail = new Trail(this);
    const rims = (g) => !this.isSmall && circles(g, Array.from({ length: robots }, (_, i) => this.place(i)), this.radius + RIM * this.pixel);
    if (moves) this.path(this.swarm, rims, { fill: "#ffffff" });
    this.discs = crowd ? [] : this.groups.map((_, step) => this.path(this.swarm, (g) => circles(g, this.groups[step], this.radius)));
    this.squares = document.createElement("canvas");
    this.swarm.add((this.small = new Konva.Shape({ sceneFunc: (g) => g.drawImage(this.squares, ...this.corner(), this.size * this.pixel, this.size * this.pixel), visible: false })));
    this.headings = this.path(this.swarm, (g) => this.traceHeadings(g), { stroke: "#000000", visible: moves });
    const misread = (attributes) => this.path(this.swarm, (g) => circles(g, this.misread(), 1.3 * this.radius + 1.5 * this.pixel), { visible: moves, ...attributes });
    this.wrong = [misread({ stroke: "#ffffff" }), misread({ stroke: "#000000", dash: [3, 2.5] })];
    this.done = this.path(this.swarm, (g) => circles(g, this.finished(), 0.35 * this.radius), { fill: "#ffffff", stroke: "#101010", strokeWidth: 1, visible: this.scene.ends && !crowd });
    // liars are marked by a shape, not by colour alone, which stands out from every colour of a robot
    this.liars = ["#ffffff", "#000000"].map((stroke) => this.path(this.swarm, (g) => this.traceCrosses(g), { stroke }));
    this.rings = [["#000000", 5], ["#ffffff", 2.5]].map(([stroke, strokeWidth]) => new Konva.Circle({ stroke, strokeWidth, strokeScaleEnabled: false }));
    const radius = moves ? this.scene.range / this.scene.side : 0;
    this.reach = [{ stroke: "#ffffff", strokeWidth: 4 }, { stroke: BLACK, strokeWidth: 1.5, dash: [8, 5] }].map((drawn) => new Konva.Circle({ radius, strokeScaleEnabled: false, ...drawn }));
    this.swarm.add(...this.rings, ...this.reach);
  }

  // an image of `across` x `across` pixels to paint on
  pixels(across, place) {
    this.dots = document.createElement("canvas");
    this.dots.width = this.dots.height = across;
    return new Konva.Image({ image: this.dots, ...place });
  }

  listen(choose, changed, moved) {
    let pressed = null;
    this.konva.on("mousedown touchstart", () => {
      pressed = this.pointed();
      this.host.focus({ preventScroll: true });
    });
    this.konva.on("click tap", () => {
      const [x, y] = this.pointed();
      const robot = this.robotAt([x, y]);
      const stayed = pressed && Math.hypot(x - pressed[0], y - pressed[1]) < 6 * this.pixel;
      if (robot !== null && stayed) choose(robot);
    });
    this.konva.on("dragmove", () => {
      const { x, y } = this.konva.position();
      this.view.look([x, y].map((from) => (this.size / 2 - from) / this.scale));
      moved();
    });
    this.konva.on("wheel", ({ evt }) => {
      evt.preventDefault();
      if (evt.deltaY === 0 || this.konva.isDragging()) return;
      this.view.near(evt.deltaY < 0 ? 1.2 : 1 / 1.2, this.pointed());
      changed();
    });
    this.pinch(changed);
  }

  // two fingers go nearer or farther, around the place between them
  pinch(changed) {
    let before = null;
    const found = ({ touches: [one, other] }) => {
      const { left, top } = this.host.getBoundingClientRect();
      const middle = [(one.clientX + other.clientX) / 2 - left, (one.clientY + other.clientY) / 2 - top];
      return { apart: Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY), middle };
    };
    const two = (does) => (event) => {
      if (event.touches.length !== 2 || !this.frame) return void (before = null);
      event.preventDefault(); // the browser does not zoom the whole page
      does(found(event));
    };
    const begin = (now) => {
      this.konva.stopDrag();
      before = now;
    };
    const go = (now) => {
      if (!before) return begin(now);
      this.konva.stopDrag();
      const at = before.middle.map((place, k) => this.view.centre[k] + (place - this.size / 2) / this.scale);
      this.view.near(now.apart / Math.max(before.apart, 1), at);
      this.view.look(at.map((place, k) => place - (now.middle[k] - this.size / 2) / this.scale));
      before = now;
      changed();
    };
    this.host.addEventListener("touchstart", two(begin), { passive: false });
    this.host.addEventListener("touchmove", two(go), { passive: false });
    for (const end of ["touchend", "touchcancel"]) this.host.addEventListener(end, () => (before = null));
  }

  // pixels for the width of the swarm
  get scale() {
    return (this.size - 2 * MARGIN) * this.view.zoom;
  }

  pointed() {
    const { x, y } = this.konva.getRelativePointerPosition();
    return [x, y];
  }

  // the lines to draw, each with the one or two directed links that it stands for
  paired() {
    const lines = new Map();
    for (let e = 0; 2 * e < this.edges.length; e++) {
      const [i, j] = [this.edges[2 * e], this.edges[2 * e + 1]].sort((a, b) => a - b);
      const key = i * 65536 + j;
      if (!lines.has(key)) lines.set(key, { i, j, links: [] });
      lines.get(key).links.push(e);
    }
    return [...lines.values()];
  }

  place(i, frame = this.frame) {
    if (this.places) return [this.places[2 * i], this.places[2 * i + 1]];
    return [frame.x[i] / 65535, 1 - frame.y[i] / 65535];
  }

  trace(g, i, j) {
    const [from, to] = [this.place(i), this.place(j)];
    const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    const part = this.scene.room / 2 / Math.hypot(dx, dy);
    g.moveTo(...from);
    if (this.scene.wraps && part < 0.4) {
      // around a torus: out at one edge and in at the opposite one
      g.lineTo(from[0] - part * dx, from[1] - part * dy);
      g.moveTo(to[0] + part * dx, to[1] + part * dy);
    }
    g.lineTo(...to);
  }

  robotAt(point) {
    let [best, near] = [null, Math.max(this.radius + 4 * this.pixel, 14 * this.pixel)];
    for (let i = 0; this.frame && i < this.scene.robots; i++) {
      const [x, y] = this.place(i);
      const distance = Math.hypot(x - point[0], y - point[1]);
      if (distance < near) [best, near] = [i, distance];
    }
    return best;
  }

  // the radius of a robot, never too small to be visible
  fitRobots() {
    const { moves, radius, side, crowd, room, robots } = this.scene;
    if (moves) this.radius = Math.max(radius / side, Math.min(2.2 * this.pixel, 0.3 / Math.sqrt(robots)));
    else if (crowd) this.radius = 0.5 / crowd;
    else this.radius = Math.min(Math.max(0.4 * room, (this.size / 180) * this.pixel), (this.size / 44) * this.pixel);
    this.isSmall = moves && this.radius <= SMALL * this.pixel;
  }

  draw(frame) {
    this.frame = frame;
    this.size = Math.max(64, this.host.clientWidth);
    if (this.konva.width() !== this.size) this.konva.size({ width: this.size, height: this.size });
    if (this.follow && this.chosen !== null) this.view.look(this.place(this.chosen));
    const { scale } = this;
    const [x, y] = this.view.centre.map((c) => this.size / 2 - c * scale);
    this.konva.setAttrs({ x, y, scaleX: scale, scaleY: scale, draggable: this.view.zoom > 1 });
    this.host.classList.toggle("near", this.view.zoom > 1);
    this.pixel = 1 / scale;
    this.fitRobots();
    this.drawGround();
    this.drawWeb();
    this.drawRobots();
    this.drawChosen();
    this.swarm.draw();
  }

  // draw the ground only if it changed
  drawGround() {
    const turned = this.turns?.length ? this.turns.reduce((sum, turn) => sum + (turn <= this.frame.tick), 0) : 0;
    const f = this.frame.numbers[0];
    const [white, black] = tilesOf(this.scene);
    const grey = this.even ? `rgb(${white.map((part, k) => Math.round(part + f * (black[k] - part))).join(" ")})` : "";
    const now = [this.konva.x(), this.konva.y(), this.pixel, turned, grey, tone("--ink"), this.size].join();
    if (now === this.drawn) return;
    this.wall?.stroke(tone("--ink"));
    this.inside?.opacity(Number(tone("--floor")));
    this.still?.setAttrs({ stroke: tone("--still"), strokeWidth: Math.min(1, this.thin()) });
    this.even?.fill(grey);
    if (this.tiles && turned !== this.turned) this.paintFloor();
    this.ground.imageSmoothingEnabled(this.scene.across > this.scale * Konva.pixelRatio);
    this.ground.draw();
    [this.drawn, this.turned] = [now, turned];
  }

  // the width of a link at which all of them cover only a part of the picture
  thin() {
    return Math.min(Math.max((COVERED * this.scale) / this.length, 0.02), 2);
  }

  // draw the links of a network only if other ones carried messages, or the view changed
  drawWeb() {
    this.lit?.stroke(this.scene.crowd ? GREEN : tone("--link"));
    if (!this.lit || this.scene.crowd) return;
    const { links } = this.frame;
    if (this.webbed === this.drawn && links.length === this.carried?.length && links.every((link, e) => link === this.carried[e])) return;
    [this.webbed, this.carried] = [this.drawn, links];
    this.lit.strokeWidth(this.thin());
    this.web.draw();
  }

  paintFloor() {
    const { across } = this.scene;
    const image = new ImageData(across, across);
    const words = new Uint32Array(image.data.buffer);
    const shades = pixels(tilesOf(this.scene));
    for (let i = 0; i < words.length; i++) {
      const black = ((this.tiles[i >> 3] >> (7 - (i & 7))) & 1) ^ (this.frame.tick >= this.turns[i] ? 1 : 0);
      words[(across - 1 - Math.floor(i / across)) * across + (i % across)] = shades[black];
    }
    this.dots.getContext("2d").putImageData(image, 0, 0);
  }

  drawRobots() {
    const { robots, crowd, moves } = this.scene;
    const steps = stepsOf(this.colour, this.frame.estimates, this.frame.numbers[0], (this.steps ??= new Uint8Array(robots)));
    const shown = this.radius / this.pixel;
    const thick = (least, part, most) => Math.min(Math.max(least, shown / part), most);
    this.small.visible(this.isSmall);
    this.discs.forEach((disc) => disc.visible(false));
    if (crowd) this.paintCrowd(steps);
    else if (this.small.visible()) this.paintSmall(steps);
    else {
      for (const group of this.groups) group.length = 0;
      steps.forEach((step, i) => this.groups[step].push(this.place(i)));
      const edge = { stroke: moves ? BLACK : tone("--edge"), strokeWidth: thick(0.5, 6, 2) };
      this.discs.forEach((disc, step) => disc.setAttrs({ visible: this.groups[step].length > 0, fill: SCALES[this.colour][step], ...edge }));
    }
    for (const part of [this.headings, ...this.wrong]) part.visible(moves && shown > 3);
    this.headings.setAttrs({ stroke: this.colour === "opinion" ? "#7d8389" : "#000000", strokeWidth: thick(1.2, 5, 3) });
    this.wrong.forEach((part, k) => part.strokeWidth(thick(1.2, 5, 3) + (k ? 0 : 1.2)));
    const line = crowd ? Math.max(1, shown / 3) : thick(1.8, 4, 4);
    this.liars[0].strokeWidth(line + (crowd ? Math.min(2, shown / 2) : 2.5));
    this.liars[1].strokeWidth(line);
  }

  paintCrowd(steps) {
    const { crowd } = this.scene;
    this.image ??= new ImageData(crowd, crowd);
    const words = new Uint32Array(this.image.data.buffer);
    const scale = WORDS[this.colour];
    for (let i = 0; i < steps.length; i++) words[i] = scale[steps[i]];
    this.dots.getContext("2d").putImageData(this.image, 0, 0);
    this.swarm.imageSmoothingEnabled(false);
  }

  // the upper left corner of what is visible
  corner() {
    return this.view.centre.map((c) => c - (this.size / 2) * this.pixel);
  }

  // many small robots as squares of pixels, which take a tenth of the time of shapes
  paintSmall(steps) {
    const across = Math.round(this.size * Konva.pixelRatio);
    if (this.squares.width !== across) {
      this.squares.width = this.squares.height = across;
      this.image = new ImageData(across, across);
    }
    const words = new Uint32Array(this.image.data.buffer).fill(0);
    const [left, top] = this.corner();
    const to = across / (this.size * this.pixel);
    const half = Math.max(1, Math.round(0.9 * this.radius * to));
    const colours = WORDS[this.colour];
    for (let i = 0; i < steps.length; i++) {
      const [x, y] = this.place(i);
      const [column, row] = [Math.round((x - left) * to), Math.round((y - top) * to)];
      if (column < half || row < half || column >= across - half || row >= across - half) continue;
      for (let at = -half; at <= half; at++) {
        const from = (row + at) * across + column;
        words.fill(colours[steps[i]], from - half, from + half + 1);
      }
    }
    this.squares.getContext("2d").putImageData(this.image, 0, 0);
    this.swarm.imageSmoothingEnabled(false);
  }

  traceHeadings(g) {
    for (let i = 0; i < this.scene.robots; i++) {
      const [x, y] = this.place(i);
      const angle = (this.frame.headings[i] / 256) * 2 * Math.PI;
      g.moveTo(x, y);
      g.lineTo(x + this.radius * Math.cos(angle), y - this.radius * Math.sin(angle));
    }
  }

  misread() {
    const found = [];
    for (let i = 0; i < this.scene.robots; i++) if (lookOf(this.frame, i)?.wrong) found.push(this.place(i));
    return found;
  }

  finished() {
    return Array.from({ length: this.scene.robots }, (_, i) => i).filter((i) => this.frame.flags[i] & FLAG.done).map((i) => this.place(i));
  }

  traceCrosses(g) {
    const r = this.scene.crowd ? 0.8 * this.radius : Math.max(this.radius, 4.5 * this.pixel);
    for (const i of this.scene.dishonest) {
      const [x, y] = this.place(i);
      g.moveTo(x - r, y - r);
      g.lineTo(x + r, y + r);
      g.moveTo(x + r, y - r);
      g.lineTo(x - r, y + r);
    }
  }

  drawChosen() {
    const visible = this.chosen !== null && this.chosen < this.scene.robots;
    const [x, y] = visible ? this.place(this.chosen) : [0, 0];
    for (const ring of this.rings) ring.setAttrs({ visible, x, y, radius: this.radius + 5 * this.pixel });
    for (const circle of this.reach) circle.setAttrs({ visible: visible && this.scene.moves, x, y });
    this.trail.show(visible && this.scene.moves);
  }

  destroy() {
    this.konva.destroy();
  }
}

"use strict";
// What the page saves: a picture, a film of what it shows, and the page with its trial as one file.

const FILM = [1280, 720]; // pixels; a picture has twice as many
const [LINE, KEY_FONT] = [17, "12.5px system-ui, sans-serif"]; // of the keys of curves
const SMOOTH = 30; // pictures of a film per second
const QUALITY = 8_000_000; // bits of a film per second
const FILMS = ["video/mp4;codecs=avc1.640028", "video/mp4;codecs=avc1.42E01F", "video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];

// The swarms, the curves, their keys and the moment on one sheet, with curves of its size.
class Sheet {
  constructor(scale) {
    this.scale = scale;
    this.canvas = element("canvas", { width: FILM[0] * scale, height: FILM[1] * scale });
    this.size = state.scenes.length > 1 ? 402 : 576; // of a swarm
    this.left = 24 + state.scenes.length * (this.size + 24); // of the curves
    this.each = (FILM[1] - 104) / (state.charts.memory ? 4 : 3); // pixels for each curve, its title and its key
    const [width, height, big] = [FILM[0] - 24 - this.left, this.each, 1.15].map((length) => Math.round(100 * length * scale) / 100);
    this.charts = new Charts(element("div"), state.scenes, () => {}, false, { big, width: Math.round(width), height: Math.round(height) });
    this.charts.histories = state.charts.histories;
    this.charts.memory = state.charts.memory;
    this.charts.build(state.charts.log, state.charts.full);
    const g = this.canvas.getContext("2d");
    this.keys = this.charts.plots.map((plot) => rowsOf(g, keyOf(plot), FILM[0] - 24 - this.left));
    this.charts.plots.forEach((plot, k) => plot.setSize({ width: plot.width, height: Math.round((this.each - 22 - LINE * this.keys[k].length) * scale) }));
  }

  draw(crisp = false) {
    const g = this.canvas.getContext("2d");
    const text = (words, x, y, font, colour = "--ink", align = "left", width = FILM[0] - 48) => {
      [g.font, g.fillStyle, g.textAlign] = [`${font} system-ui, sans-serif`, tone(colour), align];
      g.fillText(words, x, y, width);
    };
    g.setTransform(this.scale, 0, 0, this.scale, 0, 0);
    g.fillStyle = tone("--ground");
    g.fillRect(0, 0, ...FILM);
    text(state.scenes.map(({ brain }) => brain).join(" and "), 24, 34, "bold 22px");
    text(titled(), 24, 58, "15px", "--soft");
    state.stages.forEach((stage, side) => this.drawSwarm(g, text, stage, side, crisp));
    this.drawCurves(g, text);
    drawLegend(g, text, 24, (state.scenes.length > 1 ? 90 : 74) + this.size + 20);
    text($("clock").textContent, FILM[0] - 24, 708, "bold 18px", "--ink", "right");
  }

  drawSwarm(g, text, stage, side, crisp) {
    const x = 24 + side * (this.size + 24);
    const y = state.scenes.length > 1 ? 90 : 74;
    if (state.scenes.length > 1) {
      g.fillStyle = tone(SIDES[side]);
      g.fillRect(x, side ? 77 : 76, 24, side ? 4 : 6);
      text(state.scenes[side].brain, x + 30, 84, "bold 14px");
    }
    const layers = crisp ? [stage.konva.toCanvas({ pixelRatio: (this.size * this.scale) / stage.size, imageSmoothingEnabled: stage.ground.imageSmoothingEnabled() })] : stage.layers.map((layer) => layer.getNativeCanvasElement());
    for (const layer of layers) g.drawImage(layer, x, y, this.size, this.size);
    g.strokeStyle = tone("--line");
    g.strokeRect(x, y, this.size, this.size);
  }

  drawCurves(g, text) {
    const now = performance.now();
    this.charts.settled = state.charts.settled;
    this.charts.show(state.tick, state.charts.frames, now);
    this.charts.plots.forEach((plot, k) => {
      const title = plot.root.parentElement.querySelector("h3").textContent;
      const top = 82 + k * this.each;
      text(title, this.left, top, "bold 14px", "--ink", "left", FILM[0] - 12 - this.left);
      this.keys[k].forEach((row, line) => drawKey(g, plot, row, this.left, top + LINE * (line + 1)));
      g.drawImage(plot.ctx.canvas, this.left, top + LINE * this.keys[k].length + 4, plot.width / this.scale, plot.height / this.scale);
    });
  }

  destroy() {
    this.charts.destroy();
  }
}

// the entries of a chart's key: its lines and bands, and what to know about it
function keyOf(plot) {
  const lines = plot.series.slice(1).filter(({ class: quiet }) => quiet !== "quiet").map((series) => ({ label: series.label, series }));
  const bands = plot.bands.map(({ fill }, k) => ({ label: k % 2 ? "middle half" : "range", fill }));
  const caution = plot.root.parentElement.querySelector(".caution")?.textContent;
  return [...lines, ...bands.slice(0, 2), ...(caution ? [{ label: caution }] : [])];
}

// entries of a key in rows of a width
function rowsOf(g, entries, width) {
  const rows = [[]];
  let x = 0;
  g.font = KEY_FONT;
  for (const entry of entries) {
    entry.width = g.measureText(entry.label).width + (entry.series || entry.fill ? 46 : 16);
    if (x && x + entry.width > width) {
      rows.push([]);
      x = 0;
    }
    rows.at(-1).push(entry);
    x += entry.width;
  }
  return rows;
}

function drawKey(g, plot, row, left, y) {
  let x = left;
  g.save();
  [g.font, g.textAlign] = [KEY_FONT, "left"];
  for (const { label, series, fill, width } of row) {
    if (fill) {
      g.fillStyle = typeof fill === "function" ? fill(plot, 0) : fill;
      g.fillRect(x, y - 10, 24, 11);
    } else if (series) {
      [g.strokeStyle, g.lineWidth] = [series.stroke(plot), 2];
      g.setLineDash(series.dash || []);
      g.beginPath();
      g.moveTo(x, y - 4);
      g.lineTo(x + 24, y - 4);
      g.stroke();
    }
    g.fillStyle = tone(series || fill ? "--ink" : "--bad");
    g.fillText(label, x + (series || fill ? 30 : 0), y, plot.width);
    x += width;
  }
  g.restore();
}

function drawLegend(g, text, x, y) {
  let at = x;
  const add = (words) => {
    text(words, at, y, "13px", "--soft");
    at += g.measureText(words).width + 8;
  };
  if (!opined()) {
    const [low, high] = TOLD[state.colour]();
    add(low);
    g.drawImage($("scale"), at, y - 10, 180, 10);
    at += 188;
    add(high);
  }
  const mark = (name, colour, opacity, trace) => {
    [g.strokeStyle, g.lineWidth, g.globalAlpha] = [tone("--soft"), 1, opacity];
    [g.fillStyle] = named([colour]);
    g.beginPath();
    trace();
    g.fill();
    g.stroke();
    g.globalAlpha = 1;
    at += 20;
    add(name);
  };
  for (const [name, colour] of $("opinions").hidden ? [] : Object.entries(OPINION)) mark(`opinion ${name}`, colour, 1, () => g.arc(at + 7, y - 5, 7, 0, 2 * Math.PI));
  if (!$("tiles").hidden) tilesOf(state.scenes[0]).forEach((shade, black) => mark(black ? "black tile" : "white tile", shade, Number(tone("--floor")), () => g.rect(at, y - 12, 14, 14)));
  text(legendWords().join(" · "), x, y + 20, "13px", "--soft", "left", 900);
}

function download(content, ending) {
  const link = element("a", { href: URL.createObjectURL(content), download: `${nameOfFile()}.${ending}` });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

// such as commons-tick-200; of a path only the file's name
const nameOfFile = () => [...state.scenes.map(({ brain }) => brain.split(/[/\\]/).at(-1)), state.scenes[0].unit, state.tick].join("-").replace(/[^\w.=-]+/g, "-");

// curves are in a picture from the start to the moment, however soon it is saved
async function savePicture() {
  if (state.playing) pause();
  $("picture").disabled = true;
  const lacks = () => [...state.charts.histories, state.charts.memory?.history].some((history) => history?.missing(state.tick));
  const patience = performance.now() + 2000;  // logs that grow always lack the last rounds
  while (!state.halted && (state.preparing || state.drawn !== state.tick || (lacks() && performance.now() < patience))) {
    await new Promise(requestAnimationFrame);
  }
  $("picture").disabled = false;
  $("save").open = false;
  const sheet = new Sheet(2);
  sheet.draw();
  await new Promise(requestAnimationFrame); // curves are drawn a moment later
  sheet.draw(true);
  sheet.canvas.toBlob((content) => download(content, "png"));
  sheet.destroy();
}

// Films what the page shows, as it plays; every current browser can record, in MP4 or WebM.
class Film {
  constructor(seconds) {
    const kind = window.MediaRecorder && FILMS.find((one) => MediaRecorder.isTypeSupported(one));
    if (!kind) throw new Error("This browser records no films. Save a picture, or use another browser.");
    this.seconds = seconds;
    this.sheet = new Sheet(1);
    this.run = state.run;
    this.draw();
    this.parts = [];
    this.recorder = new MediaRecorder(this.sheet.canvas.captureStream(SMOOTH), { mimeType: kind, videoBitsPerSecond: QUALITY });
    this.recorder.ondataavailable = ({ data }) => this.parts.push(data);
    this.recorder.onstop = () => download(new Blob(this.parts, { type: kind }), kind.slice(6).split(";")[0]);
    this.recorder.start(1000);
    this.began = performance.now();
    this.ticking = setInterval(() => this.tell(), 200);
  }

  draw() {
    if (this.run !== state.run || this.sheet.charts.memory !== state.charts.memory) {
      // another trial, on the canvas that is recorded
      this.sheet.destroy();
      [this.sheet, this.run] = [Object.assign(new Sheet(1), { canvas: this.sheet.canvas }), state.run];
    }
    this.sheet.draw();
  }

  tell() {
    const passed = (performance.now() - this.began) / 1000;
    $("film").textContent = "Stop";
    $("save").firstElementChild.textContent = `Film: ${Math.floor(passed)} of ${this.seconds} s`;
    if (passed >= this.seconds) this.end();
  }

  end() {
    clearInterval(this.ticking);
    this.recorder.stop();
    this.sheet.destroy();
    state.film = null;
    $("film").textContent = "Record";
    $("save").firstElementChild.textContent = "Save";
  }
}

function saveFilm() {
  if (state.film) return state.film.end();
  const seconds = Math.min(Math.max(Math.round(Number($("seconds").value)) || 20, 1), 600);
  $("seconds").value = seconds;
  try {
    state.film = new Film(seconds);
    $("save").open = false;
    if (!state.playing && !state.live) play();
  } catch (error) {
    complain(error);
  }
}

async function savePage() {
  const words = new URLSearchParams(fragment(true).slice(1));
  words.set("token", state.source.token);
  $("page").disabled = true;
  $("page").textContent = "Writing …";
  try {
    const answer = await fetch(`/run.html?${words}`);
    if (!answer.ok) throw new Error(await answer.text());
    download(await answer.blob(), "html");
  } catch (error) {
    complain(error);
  } finally {
    $("page").disabled = false;
    $("page").textContent = "Page";
    $("save").open = false;
  }
}

$("picture").addEventListener("click", savePicture);
$("film").addEventListener("click", saveFilm);
$("page").addEventListener("click", savePage);
$("page").hidden = Boolean(recordedText);

"use strict";
// What the page saves: a picture, a film of what it shows, and the page with its trial as one file.

const [WIDE, HIGH] = [1280, 720]; // pixels of a film; a picture has twice as many
const SMOOTH = 30; // pictures of a film per second
const QUALITY = 8_000_000; // bits of a film per second
const FILMS = ["video/mp4;codecs=avc1.640028", "video/mp4;codecs=avc1.42E01F", "video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];

// The swarms, the curves, the legend and the moment on one sheet, with curves of its size.
class Sheet {
  constructor(scale) {
    this.scale = scale;
    this.canvas = element("canvas", { width: WIDE * scale, height: HIGH * scale });
    this.size = state.scenes.length > 1 ? 402 : 576; // of a swarm
    this.left = 24 + state.scenes.length * (this.size + 24); // of the curves
    this.each = 196; // pixels for each of three curves and their titles
    const [width, height, big] = [WIDE - 24 - this.left, this.each - 20, 1.15].map((length) => length * scale);
    this.charts = new Charts(element("div"), state.scenes, () => {}, false, { big, width: Math.round(width), height: Math.round(height) });
    this.charts.histories = state.charts.histories;
    this.charts.build(state.charts.log, state.charts.full);
  }

  draw(crisp = false) {
    const g = this.canvas.getContext("2d");
    const text = (words, x, y, font, colour = "--ink", align = "left", width = WIDE - 48) => {
      [g.font, g.fillStyle, g.textAlign] = [`${font} system-ui, sans-serif`, tone(colour), align];
      g.fillText(words, x, y, width);
    };
    g.setTransform(this.scale, 0, 0, this.scale, 0, 0);
    g.fillStyle = tone("--ground");
    g.fillRect(0, 0, WIDE, HIGH);
    text(state.scenes.map(({ brain }) => brain).join(" and "), 24, 34, "bold 22px");
    text(state.scenes[0].title, 24, 58, "15px", "--soft");
    state.stages.forEach((stage, side) => this.drawSwarm(g, text, stage, side, crisp));
    this.drawCurves(g, text);
    drawLegend(g, text, 24, 90 + this.size + 18);
    text($("clock").textContent, WIDE - 24, 702, "bold 18px", "--ink", "right");
  }

  drawSwarm(g, text, stage, side, crisp) {
    const x = 24 + side * (this.size + 24);
    const y = state.scenes.length > 1 ? 90 : 74;
    if (state.scenes.length > 1) text(state.scenes[side].brain, x, 84, "bold 14px", SIDES[side]);
    const layers = crisp ? [stage.konva.toCanvas({ pixelRatio: (this.size * this.scale) / stage.size })] : [stage.ground, stage.swarm].map((layer) => layer.getNativeCanvasElement());
    for (const layer of layers) g.drawImage(layer, x, y, this.size, this.size);
    g.strokeStyle = tone("--line");
    g.strokeRect(x, y, this.size, this.size);
  }

  drawCurves(g, text) {
    const now = performance.now();
    this.charts.settled = state.charts.settled;
    this.charts.show(state.tick, state.charts.frames, now);
    this.charts.plots.forEach((plot, k) => {
      const { canvas } = plot.ctx;
      const title = plot.root.parentElement.querySelector("h3").textContent;
      text(title, this.left, 84 + k * this.each, "bold 14px", "--ink", "left", WIDE - 12 - this.left);
      this.drawNames(g, plot, this.left + g.measureText(title).width + 18, 84 + k * this.each);
      g.drawImage(canvas, this.left, 90 + k * this.each, plot.width / this.scale, plot.height / this.scale);
    });
  }

  // the names of lines, in their colours, where there is room
  drawNames(g, plot, left, y) {
    let x = left;
    g.font = "13px system-ui, sans-serif";
    for (const { label, stroke, class: quiet } of plot.series.slice(1)) {
      if (quiet || x + g.measureText(label).width > WIDE) continue;
      g.fillStyle = stroke(plot);
      g.fillText(label, x, y);
      x += g.measureText(label).width + 14;
    }
  }

  destroy() {
    this.charts.destroy();
  }
}

function drawLegend(g, text, x, y) {
  const [low, high] = TOLD[state.colour](state.span);
  text(low, x, y, "13px", "--soft");
  const from = x + g.measureText(low).width + 8;
  g.drawImage($("scale"), from, y - 10, 180, 10);
  text(high, from + 188, y, "13px", "--soft");
  if (state.scenes.some(({ dishonest }) => dishonest.length)) text("crossed out: it lies", x, y + 20, "13px", "--soft");
}

function download(content, ending) {
  const link = element("a", { href: URL.createObjectURL(content), download: `${nameOfFile()}.${ending}` });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

// such as commons-tick-200; of a path only the file's name
const nameOfFile = () => [...state.scenes.map(({ brain }) => brain.split(/[/\\]/).at(-1)), state.scenes[0].unit, state.tick].join("-").replace(/[^\w.=-]+/g, "-");

async function savePicture() {
  while (state.drawn !== state.tick) await new Promise(requestAnimationFrame);
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
    if (this.run !== state.run) {
      // another trial, on the canvas that is recorded
      this.sheet.destroy();
      [this.sheet, this.run] = [Object.assign(new Sheet(1), { canvas: this.sheet.canvas }), state.run];
    }
    this.sheet.draw();
  }

  tell() {
    const passed = (performance.now() - this.began) / 1000;
    $("film").textContent = `Stop (${Math.floor(passed)} of ${this.seconds} s)`;
    if (passed >= this.seconds) this.end();
  }

  end() {
    clearInterval(this.ticking);
    this.recorder.stop();
    this.sheet.destroy();
    state.film = null;
    $("film").textContent = "Record";
  }
}

function saveFilm() {
  if (state.film) return state.film.end();
  const seconds = Math.min(Math.max(Math.round(Number($("seconds").value)) || 20, 1), 600);
  $("seconds").value = seconds;
  try {
    state.film = new Film(seconds);
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
  }
}

$("picture").addEventListener("click", savePicture);
$("film").addEventListener("click", saveFilm);
$("page").addEventListener("click", savePage);
$("page").hidden = Boolean(recordedText);

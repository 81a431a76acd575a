"use strict";
// What the page saves: a picture, a film of what it shows, and the page with its trial as one file.

const [WIDE, HIGH] = [1280, 720]; // of a picture, in its own pixels; films have as many
const SMOOTH = 30; // pictures of a film per second
const QUALITY = 8_000_000; // bits of a film per second
const FILMS = ["video/mp4;codecs=avc1.640028", "video/mp4;codecs=avc1.42E01F", "video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];

// the swarms, the curves, the legend and the moment on one sheet
function compose(canvas, scale = 1) {
  [canvas.width, canvas.height] = [WIDE * scale, HIGH * scale];
  const g = canvas.getContext("2d");
  const text = (words, x, y, font, colour = "--ink", align = "left") => {
    [g.font, g.fillStyle, g.textAlign] = [`${font} system-ui, sans-serif`, tone(colour), align];
    g.fillText(words, x, y, WIDE - 48);
  };
  g.scale(scale, scale);
  g.fillStyle = tone("--ground");
  g.fillRect(0, 0, WIDE, HIGH);
  const pair = state.scenes.length > 1;
  const size = pair ? 402 : 576;
  text(state.scenes.map(({ brain }) => brain).join(" and "), 24, 34, "bold 22px");
  text(state.scenes[0].title, 24, 58, "15px", "--soft");
  state.stages.forEach((stage, side) => {
    const x = 24 + side * (size + 24);
    if (pair) text(state.scenes[side].brain, x, 82, "bold 14px");
    for (const layer of [stage.ground, stage.swarm]) g.drawImage(layer.getNativeCanvasElement(), x, pair ? 88 : 74, size, size);
    g.strokeStyle = tone("--line");
    g.strokeRect(x, pair ? 88 : 74, size, size);
  });
  const left = 24 + state.stages.length * (size + 24);
  drawCurves(g, text, left, 74, WIDE - 24 - left, pair ? 596 : 596);
  drawLegend(g, text, 24, pair ? 520 : 680);
  text($("clock").textContent, WIDE - 24, 702, "bold 18px", "--ink", "right");
}

function drawCurves(g, text, x, top, width, height) {
  const each = height / state.charts.plots.length;
  state.charts.plots.forEach((plot, k) => {
    const { canvas } = plot.ctx;
    const by = Math.min(width / canvas.width, (each - 24) / canvas.height);
    text(plot.root.parentElement.querySelector("h3").textContent, x, top + k * each + 12, "bold 13px");
    g.drawImage(canvas, x, top + k * each + 20, canvas.width * by, canvas.height * by);
  });
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

const nameOfFile = () => `${state.scenes.map(({ brain }) => brain).join("-")}-${state.scenes[0].unit}-${state.tick}`.replace(/[^\w.-]+/g, "-");

function savePicture() {
  const canvas = document.createElement("canvas");
  compose(canvas, 2);
  canvas.toBlob((content) => download(content, "png"));
}

// Films what the page shows, as it plays; every current browser can record, in MP4 or WebM.
class Film {
  constructor(seconds) {
    const kind = window.MediaRecorder && FILMS.find((one) => MediaRecorder.isTypeSupported(one));
    if (!kind) throw new Error("This browser records no films. Save a picture, or use another browser.");
    this.seconds = seconds;
    this.canvas = document.createElement("canvas");
    compose(this.canvas);
    this.parts = [];
    this.recorder = new MediaRecorder(this.canvas.captureStream(SMOOTH), { mimeType: kind, videoBitsPerSecond: QUALITY });
    this.recorder.ondataavailable = ({ data }) => this.parts.push(data);
    this.recorder.onstop = () => download(new Blob(this.parts, { type: kind }), kind.slice(6).split(";")[0]);
    this.recorder.start(1000);
    this.began = performance.now();
    this.ticking = setInterval(() => this.tell(), 200);
  }

  draw() {
    compose(this.canvas);
  }

  tell() {
    const passed = (performance.now() - this.began) / 1000;
    $("film").textContent = `Stop (${Math.floor(passed)} of ${this.seconds} s)`;
    if (passed >= this.seconds) this.end();
  }

  end() {
    clearInterval(this.ticking);
    this.recorder.stop();
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
    if (!state.playing) play();
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

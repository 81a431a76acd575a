"use strict";
// The player: what is asked for and when, what the keys do, and an address that holds the moment.

const $ = (id) => document.getElementById(id);
const SPEEDS = [1, 2, 5, 10, 20, 30, 60, 120, 300, 1000, 3000, 10000, Infinity];
const PICTURES = 60; // a second
const AHEAD = 120; // frames that wait to be shown
const BEHIND = 120; // frames that are kept
const recordedText = $("recorded");

const state = {
  source: recordedText ? new Recorded(JSON.parse(recordedText.textContent)) : new Live(),
  ask: {}, scenes: [], form: null, stages: [], charts: null, frames: new Map(),
  tick: 0, place: 0, playing: false, speed: 60, colour: "belief", chosen: null, side: 0, follow: false,
  asking: false, run: 0, drawn: -1, last: 0, pictures: [], toldAt: -1, told: 0, heldUntil: 0,
};

function complain(error) {
  $("error").hidden = !error;
  $("error").textContent = error ? error.message || String(error) : "";
}

const rounds = () => state.scenes[0]?.rounds || 0;
const step = () => Math.max(1, Math.ceil(Math.min(state.speed, 1e9) / PICTURES) || 1);
const strides = () => (state.speed === Infinity ? Math.max(1, Math.floor(rounds() / 600)) : Math.min(step(), Math.max(1, Math.floor(rounds() / 100))));

function wishOf(text) {
  const asked = Object.fromEntries(new URLSearchParams(text.replace(/^#/, "")));
  const { tick, robot, side, colour, ...ask } = asked;
  return { ask, tick: Number.parseInt(tick || "0", 10) || 0, robot: robot === undefined ? null : Number.parseInt(robot, 10), side: side === "1" ? 1 : 0, colour: colour === "error" ? "error" : "belief" };
}

function fragment() {
  const words = new URLSearchParams(state.ask);
  if (!words.has("trial") && state.form) words.set("trial", state.form.now.trial);
  if (!words.has("seed") && state.form) words.set("seed", state.form.now.seed);
  if (state.form) words.set("of", state.form.mark);
  words.set("tick", state.tick);
  if (state.chosen !== null) words.set("robot", state.chosen);
  if (state.side) words.set("side", state.side);
  if (state.colour !== "belief") words.set("colour", state.colour);
  return `#${words}`;
}

function remember() {
  history.replaceState(null, "", fragment());
}

async function begin(ask, tick = 0, robot = state.chosen) {
  const run = ++state.run;
  state.asking = true;
  $("title").textContent = "preparing … (a brain is compiled when it is watched for the first time)";
  let answer;
  try {
    answer = await state.source.begin(ask);
  } catch (error) {
    if (run === state.run) {
      complain(error);
      state.asking = false;
      if (state.form) {
        $("title").textContent = `${state.form.name}: ${state.scenes[0].title}`;
        buildControls($("controls"), state.form, change, Boolean(recordedText));
      } else {
        $("title").textContent = "";
        if (Object.keys(ask).length) await begin({}, 0, null);
        complain(error);
      }
    }
    return;
  }
  if (run !== state.run) return;
  complain(null);
  state.ask = answer.form.asked || ask;
  state.scenes = answer.scenes;
  state.form = answer.form;
  state.frames.clear();
  state.chosen = robot !== null && robot >= 0 && robot < state.scenes[0].robots ? robot : null;
  state.side = Math.min(state.side, state.scenes.length - 1);
  state.tick = state.place = Math.min(Math.max(tick, 0), rounds());
  state.drawn = -1;
  state.toldAt = -1;
  state.asking = false;
  state.ended = false;
  buildPage();
  remember();
  await fetchAt(state.tick, run);
  await fillBehind(run).catch(() => {});
}

function buildPage() {
  const { scenes, form } = state;
  $("title").textContent = `${form.name}: ${scenes[0].title}; seed ${form.now.seed}, trial ${form.now.trial}`;
  document.title = `${scenes.map((scene) => scene.brain).join(" and ")} – swarmcensus`;
  $("stages").replaceChildren();
  document.querySelector("main").classList.toggle("pair", scenes.length > 1);
  state.stages = scenes.map((scene, side) => {
    const canvas = element("canvas", { width: 600, height: 600, tabindex: 0, role: "img", "aria-label": `${scene.robots} robots with ${scene.brain}` });
    const liars = scene.dishonest.length ? `, ${scene.dishonest.length} of ${scene.robots} lie (crossed out)` : "";
    $("stages").append(element("figure", {}, element("figcaption", {}, `${scene.brain}: ${scene.memory} bytes of memory, ${scene.message} a message${liars}`), canvas));
    const stage = new Stage(canvas, scene);
    listen(canvas, stage, side);
    return stage;
  });
  $("moment").max = rounds();
  $("which").max = scenes[0].robots - 1;
  $("which").value = state.chosen ?? "";
  $("which-side").replaceChildren(...scenes.map((scene, side) => element("option", { value: side }, scene.brain)));
  $("which-side").value = state.side;
  $("which-side").hidden = scenes.length < 2;
  if (state.chosen === null) $("told").replaceChildren(element("p", { class: "note" }, "Click a robot, or type its number, to see all that it remembers, reads and hears."));
  buildControls($("controls"), form, change, Boolean(recordedText));
  state.charts = new Charts($("curves"), scenes, seek);
  state.charts.build();
  if (recordedText) $("world-note").textContent = "A recording: swarmcensus watch shows other worlds. Its estimates are rounded to four digits.";
  legend();
}

function legend() {
  const g = $("scale").getContext("2d");
  SCALES[state.colour].forEach((colour, k) => {
    g.fillStyle = colour;
    g.fillRect((k * 256) / STEPS, 0, 256 / STEPS + 1, 10);
  });
  $("legend-low").textContent = state.colour === "belief" ? "believes 0" : "right";
  $("legend-high").textContent = state.colour === "belief" ? "1" : `off by ${MOST_WRONG} or more`;
  const moves = state.scenes[0]?.moves;
  $("legend-text").textContent = moves ? "· green: who hears whom · orange ring: a wrong reading" : "· green: links that carried a message";
}

function change(key, value) {
  const ask = { ...state.ask };
  if (value === "" && key !== "beside") delete ask[key];
  else ask[key] = value;
  if (key === "beside" && value === "") delete ask[key];
  if (key === "setting" || key === "seed") delete ask.of;
  if (key === "setting") for (const other of Object.keys(ask)) if (!["setting", "trial", "seed"].includes(other)) delete ask[other];
  if (key === "topology") for (const other of ["density", "floor", "rounds"]) delete ask[other];
  begin(ask, 0);
}

// frames from a moment on, so that they are there when they are due
async function fetchAt(from, run) {
  if (state.asking || run !== state.run || from > rounds()) return;
  state.asking = true;
  try {
    const sides = await state.source.frames(from, Math.min(strides(), Math.max(rounds(), 1)), AHEAD);
    if (run !== state.run) return;
    if (sides) {
      sides.forEach((frames, side) => {
        for (const frame of frames) {
          if (!state.frames.has(frame.tick)) state.frames.set(frame.tick, []);
          state.frames.get(frame.tick)[side] = frame;
        }
      });
      forget();
    }
  } catch (error) {
    if (run === state.run) {
      complain(error);
      pause();
    }
  } finally {
    if (run === state.run) state.asking = false;
  }
}

// the curves before a moment that one came to at once, in as many points as can be told apart
async function fillBehind(run) {
  const history = state.charts.histories[0];
  const to = state.tick;
  if (state.playing || history.known(to) > 0.1) return;
  const by = Math.max(history.every, Math.ceil(to / 400 / history.every) * history.every);
  for (let from = 0; from < to && run === state.run && !state.playing; ) {
    const sides = await state.source.frames(from, by, Math.floor((to - 1 - from) / by) + 1);
    if (run !== state.run) return;
    if (!sides) continue;
    sides.forEach((frames, side) => state.charts.put(side, frames));
    from = sides[0][sides[0].length - 1].tick + by;
  }
  if (run === state.run) state.charts.refresh();
}

// what lies far behind is asked for again if anyone goes back: the page grows no larger
function forget() {
  if (state.frames.size <= 2 * AHEAD + BEHIND) return;
  const ticks = [...state.frames.keys()].sort((a, b) => a - b);
  const here = ticks.findIndex((tick) => tick >= state.tick);
  for (const tick of ticks.slice(0, Math.max(0, here - BEHIND))) state.frames.delete(tick);
  for (const tick of ticks.slice(Math.max(0, here) + 2 * AHEAD)) state.frames.delete(tick);
}

// how far frames wait without a gap, from here on
function waiting(by) {
  let tick = state.tick;
  while (state.frames.has(tick + by) && tick + by <= rounds()) tick += by;
  return tick;
}

function tickOn(now) {
  requestAnimationFrame(tickOn);
  const passed = Math.min((now - state.last) / 1000, 0.25);
  state.last = now;
  if (!state.scenes.length) return;
  const by = strides();
  if (!state.frames.has(state.tick)) fetchAt(state.tick, state.run);
  else if (state.playing) {
    const end = waiting(by);
    const pace = state.speed === Infinity ? by * PICTURES * 4 : state.speed;
    state.place = Math.min(state.place + pace * passed, end);
    let next = state.tick;
    while (next + by <= state.place && state.frames.has(next + by)) next += by;
    if (state.playing && end + by > rounds() && next + by > rounds()) next = state.frames.has(rounds()) ? rounds() : next;
    state.tick = next;
    if ((end - state.tick) / by < AHEAD / 2 && end + by <= rounds()) fetchAt(end + by, state.run);
    else if (end + by > rounds() && end < rounds() && !state.frames.has(rounds())) fetchAt(rounds(), state.run);
    if (state.tick >= rounds()) pause();
  }
  const frames = state.frames.get(state.tick);
  if (frames && frames.filter(Boolean).length === state.scenes.length && state.drawn !== state.tick) show(frames, now);
}

function show(frames, now) {
  state.drawn = state.tick;
  state.stages.forEach((stage, side) => {
    stage.colour = state.colour;
    stage.chosen = side === state.side || state.scenes.length > 1 ? state.chosen : null;
    stage.follow = state.follow;
    stage.draw(frames[side]);
  });
  const scene = state.scenes[0];
  $("moment").value = state.tick;
  const seconds = scene.seconds ? `, ${clockOf(state.tick * scene.seconds)}` : "";
  $("clock").textContent = `${scene.unit} ${state.tick.toLocaleString("en")} of ${scene.rounds.toLocaleString("en")}${seconds}`;
  $("moment").setAttribute("aria-valuetext", $("clock").textContent);
  for (const [tick, sides] of state.frames) {
    if (tick > state.tick || sides.charted) continue;
    sides.forEach((frame, side) => state.charts.put(side, [frame]));
    sides.charted = true;
  }
  state.charts.show(state.tick, now, !state.playing);
  state.pictures.push(now);
  while (state.pictures[0] < now - 1000) state.pictures.shift();
  if (!state.playing || now - state.told > 100) {
    state.told = now;
    tellNumbers($("numbers"), state.scenes, frames);
    $("rate").textContent = state.playing ? `${state.pictures.length} pictures a second` : "";
    tellChosen();
  }
}

function clockOf(seconds) {
  const whole = Math.floor(seconds);
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  return `${h ? `${h}:` : ""}${String(m).padStart(h ? 2 : 1, "0")}:${String(s).padStart(2, "0")}`;
}

async function tellChosen() {
  if (state.chosen === null || state.telling) return;
  state.telling = true;
  const [run, tick, robot, side] = [state.run, state.tick, state.chosen, state.side];
  try {
    const told = await state.source.robot(side, robot, tick);
    if (run === state.run && robot === state.chosen) {
      tellRobot($("told"), told, state.scenes[side]);
      $("told").dataset.tick = told.tick;
      $("told").dataset.robot = told.robot;
    }
  } catch (error) {
    if (run === state.run) complain(error);
  } finally {
    state.telling = false;
    if (!state.playing && run === state.run && (tick !== state.tick || robot !== state.chosen || side !== state.side)) tellChosen();
  }
}

function again() {
  state.drawn = -1;
}

function play() {
  if (state.tick >= rounds()) seek(0);
  state.playing = true;
  state.place = state.tick;
  $("play").textContent = "❚❚ Pause";
  $("play").setAttribute("aria-label", "Pause");
}

function pause() {
  state.playing = false;
  $("play").textContent = "▶ Play";
  $("play").setAttribute("aria-label", "Play");
  again();
  remember();
}

function seek(tick) {
  state.tick = state.place = Math.min(Math.max(Math.round(tick), 0), rounds());
  again();
  $("moment").value = state.tick;
  if (!state.playing) remember();
}

function hop(by) {
  if (state.playing) pause();
  seek(state.tick + by);
}

function choose(robot, side = state.side) {
  state.chosen = robot;
  state.side = side;
  $("which").value = robot ?? "";
  $("which-side").value = side;
  again();
  remember();
  tellChosen();
}

function pace(by) {
  const at = SPEEDS.indexOf(state.speed) + by;
  state.speed = SPEEDS[Math.min(Math.max(at, 0), SPEEDS.length - 1)];
  $("speed").value = String(state.speed);
}

function listen(canvas, stage, side) {
  let held = null;
  let moved = false;
  canvas.addEventListener("pointerdown", (event) => {
    held = [event.clientX, event.clientY];
    moved = false;
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held || (!moved && Math.hypot(event.clientX - held[0], event.clientY - held[1]) < 4)) return;
    moved = true;
    if (stage.zoom > 1) for (const one of state.stages) one.shift(event.clientX - held[0], event.clientY - held[1]);
    held = [event.clientX, event.clientY];
    again();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (held && !moved) {
      const robot = stage.robotAt(event.clientX, event.clientY);
      if (robot !== null) choose(robot, side);
    }
    held = null;
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    for (const one of state.stages) one.near(event.deltaY < 0 ? 1.2 : 1 / 1.2);
    again();
  }, { passive: false });
}

const KEYS = {
  " ": () => (state.playing ? pause() : play()),
  ArrowLeft: (event) => hop(event.shiftKey ? -100 : -1),
  ArrowRight: (event) => hop(event.shiftKey ? 100 : 1),
  Home: () => hop(-Infinity),
  End: () => hop(Infinity),
  "[": () => pace(-1),
  "]": () => pace(1),
  n: () => choose(state.chosen === null ? 0 : (state.chosen + 1) % state.scenes[0].robots),
  p: () => choose(state.chosen === null ? 0 : (state.chosen + state.scenes[0].robots - 1) % state.scenes[0].robots),
  f: () => $("follow").click(),
  "+": () => zoom(1.4),
  "-": () => zoom(1 / 1.4),
  0: () => zoom(0),
};

function zoom(by) {
  for (const stage of state.stages) stage.near(by);
  again();
}

document.addEventListener("keydown", (event) => {
  const typing = event.target.matches("input:not([type=range]):not([type=checkbox]), select, textarea");
  const own = event.target.matches("[type=range]") ? !event.shiftKey && ["ArrowLeft", "ArrowRight", "Home", "End"].includes(event.key) : event.key === " " && event.target.matches("button, summary, [type=checkbox]");
  if (typing || own || event.ctrlKey || event.altKey || event.metaKey || !KEYS[event.key] || !state.scenes.length) return;
  event.preventDefault();
  KEYS[event.key](event);
});

for (const speed of SPEEDS) $("speed").append(element("option", { value: String(speed) }, speed === Infinity ? "as fast as it computes" : `${speed.toLocaleString("en")} a second`));
$("speed").value = "60";
$("speed").addEventListener("change", () => {
  state.speed = Number($("speed").value);
});
function paint(colour) {
  state.colour = $("colour").value = colour;
  legend();
  again();
}
$("colour").addEventListener("change", () => {
  paint($("colour").value);
  remember();
});
$("play").addEventListener("click", () => (state.playing ? pause() : play()));
$("first").addEventListener("click", () => hop(-Infinity));
$("last").addEventListener("click", () => hop(Infinity));
$("back").addEventListener("click", (event) => hop(event.shiftKey ? -100 : -1));
$("forth").addEventListener("click", (event) => hop(event.shiftKey ? 100 : 1));
$("moment").addEventListener("input", () => seek(Number($("moment").value)));
$("moment").addEventListener("change", () => {
  remember();
  fillBehind(state.run).catch(() => {});
});
$("which").addEventListener("change", () => {
  const robot = Number.parseInt($("which").value, 10);
  if (robot >= 0 && robot < state.scenes[0].robots) choose(robot);
  else $("which").value = state.chosen ?? "";
});
$("which-side").addEventListener("change", () => choose(state.chosen, Number($("which-side").value)));
$("follow").addEventListener("change", () => {
  state.follow = $("follow").checked;
  for (const stage of state.stages) stage.zoom = state.follow ? Math.max(stage.zoom, 3) : 1;
  if (!state.follow) zoom(0);
  again();
});
$("world").addEventListener("submit", (event) => event.preventDefault());
$("copy").addEventListener("click", async () => {
  remember();
  try {
    await navigator.clipboard.writeText(recordedText ? location.hash : location.href);
    $("copy").textContent = "Copied";
  } catch {
    $("copy").textContent = "Copy it from the address bar";
  }
  setTimeout(() => ($("copy").textContent = "Copy link"), 2000);
});
window.addEventListener("resize", () => {
  again();
  state.charts?.resize();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  state.charts?.build();
  again();
});
window.addEventListener("hashchange", () => {
  const wish = wishOf(location.hash);
  if (state.playing) pause();
  state.side = wish.side;
  paint(wish.colour);
  begin(wish.ask, wish.tick, wish.robot);
});

async function start() {
  const played = recordedText ? new URLSearchParams(state.source.recording.played).toString() : "";
  const wish = wishOf(location.hash || played);
  state.side = wish.side;
  paint(wish.colour);
  try {
    await state.source.open();
    state.source.closed = (error) => complain(error);
    await begin(wish.ask, wish.tick, wish.robot);
    requestAnimationFrame(tickOn);
  } catch (error) {
    $("title").textContent = "";
    complain(error);
  }
}

start();

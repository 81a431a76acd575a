"use strict";
// The player: which frames are fetched and when, and what is shown of them.

function keep(sides) {
  sides.forEach((frames, side) => {
    for (const frame of frames) {
      if (!state.frames.has(frame.tick)) state.frames.set(frame.tick, []);
      state.frames.get(frame.tick)[side] = frame;
    }
  });
}

// fetch frames from a tick on, before they are needed
async function fetchAt(from, run) {
  if (state.asking || state.halted || from > rounds()) return;
  state.asking = true;
  try {
    const sides = await state.source.frames(from, Math.min(strides(), Math.max(rounds(), 1)), AHEAD);
    if (run !== state.run || !sides) return;
    keep(sides);
    forget();
  } catch (error) {
    if (run !== state.run) return;
    state.halted = true; // until another moment or trial is chosen
    complain(error);
    if (state.playing) pause();
  } finally {
    if (run === state.run) state.asking = false;
  }
}

// complete a moment that is looked at for longer: recent readings of the chosen robot
async function settle(run, tick) {
  const stays = () => run === state.run && tick === state.tick && !state.playing && !state.halted;
  const lately = () => Array.from({ length: LATELY }, (_, k) => tick - k).filter((one) => one >= 0 && !state.frames.has(one));
  await new Promise((soon) => setTimeout(soon, PATIENCE));
  if (stays()) sayMoment();
  if (!stays() || !state.scenes[0].moves || state.chosen === null) return;
  while (lately().length && stays()) {
    const sides = await state.source.frames(Math.min(...lately()), 1, Math.min(LATELY, AT_ONCE));
    if (stays() && sides) keep(sides);
  }
  if (stays()) again();
}

// what nobody waits for, a piece at a time: points of curves that were passed over, then K
async function work(run) {
  if (state.charts.memory?.history.missing(state.tick + 1)) {
    await fetchMemory(state.tick + 1, run);
    if (run === state.run && !state.playing) again();
    return;
  }
  const missing = state.charts.histories[0].missing(state.tick);
  const sides = missing && (await state.source.frames(missing.from, missing.by, Math.min(missing.count, AT_ONCE)));
  if (run !== state.run) return;
  sides?.forEach((frames, side) => state.charts.put(side, frames));
  if (missing) {
    if (sides && !state.playing) again();
    return;
  }
  const settled = await state.source.settled();
  if (run !== state.run || !settled) return;
  state.settled = settled;
  state.charts.settled = settled;
  again();
}

// some of the missing points before a round of the field that is drawn
async function fetchMemory(tick, run) {
  const { memory } = state.charts;
  const missing = memory.history.missing(tick);
  const rows = await state.source.memory(memory, missing.from, missing.by, Math.min(missing.count, AT_ONCE));
  if (run === state.run && memory === state.charts.memory && rows) state.charts.putMemory(rows);
}

// the field that the page's reader has chosen, of the chosen robot
function plotMemory() {
  const { fields } = state.scenes[state.side];
  if (!fields.includes(state.plot)) state.plot = "";
  $("plot").replaceChildren(...["", ...fields].map((name) => element("option", { value: name }, name || "(no field)")));
  $("plot").value = state.plot;
  state.charts.remember(state.plot && state.chosen !== null ? { side: state.side, robot: state.chosen, name: state.plot } : null);
  state.workAt = 0;
}

// drop frames far from the current one, to limit memory; they are fetched again when needed
function forget() {
  const behind = Math.min(Math.max(MEMORIES / state.scenes[0].robots, AHEAD), 10 * AHEAD);
  if (state.frames.size <= 2 * AHEAD + behind) return;
  const ticks = [...state.frames.keys()].sort((a, b) => a - b);
  const here = ticks.findIndex((tick) => tick >= state.tick);
  for (const tick of ticks.slice(0, Math.max(0, here - behind))) state.frames.delete(tick);
  for (const tick of ticks.slice(Math.max(0, here) + 2 * AHEAD)) state.frames.delete(tick);
}

// the last tick up to which frames are there without a gap
function waiting(by) {
  let tick = state.tick;
  while (state.frames.has(tick + by) && tick + by <= rounds()) tick += by;
  return tick;
}

function isIdle(now) {
  if (state.working || state.halted || state.grows || now < state.workAt) return false;
  const { histories, memory } = state.charts;
  return state.drawn >= 0 && (state.settled === null || histories[0].missing(state.tick) !== null || Boolean(memory?.history.missing(state.tick + 1)));
}

function tickOn(now) {
  requestAnimationFrame(tickOn);
  const passed = Math.min((now - state.last) / 1000, 0.25);
  state.last = now;
  const late = state.preparing || (state.drawn !== state.tick && !state.halted && state.scenes.length > 0);
  $("waiting").hidden = state.source.lost || !(late && now - state.shownAt > 700);
  if (!late) state.shownAt = now;
  dimOld(state.preparing && !state.source.lost && state.scenes.length > 0 && now - state.shownAt > DIM ? now - state.shownAt : null);
  if (!state.scenes.length) return;
  if (state.preparing) {
    showHere(now); // the old picture, after a change of size
    return;
  }
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
    if (state.tick >= rounds()) reachEnd();
  }
  showHere(now);
  if (isIdle(now)) {
    const run = state.run;
    [state.working, state.workAt] = [true, now + PAUSE];
    work(run).catch(() => (state.workAt = Infinity)).finally(() => run === state.run && (state.working = false));
  }
  const here = [state.run, state.tick, state.chosen, state.side].join();
  if (!state.playing && !state.halted && state.drawn === state.tick && state.completed !== here) {
    state.completed = here;
    settle(state.run, state.tick).catch(() => {});
  }
}

function showHere(now) {
  const frames = state.frames.get(state.tick);
  if (frames && frames.filter(Boolean).length === state.scenes.length && state.drawn !== state.tick) show(frames, now);
}

// dim the old picture, with a clock of the milliseconds for which another one has been prepared; null: show it
function dimOld(waited) {
  const main = document.querySelector("main");
  const seconds = waited === null ? "" : String(Math.floor(waited / 1000));
  if ((main.dataset.waits ?? "") === seconds) return;
  if (seconds) main.dataset.waits = seconds;
  else delete main.dataset.waits;
  main.style.setProperty("--waits", seconds || "0");
}

function show(frames, now) {
  state.drawn = state.tick;
  state.stages.forEach((stage, side) => {
    stage.colour = painted(stage.scene);
    stage.chosen = side === state.side || state.scenes.length > 1 ? state.chosen : null;
    stage.follow = state.follow;
    stage.before = state.chosen === null ? [] : [...state.frames].filter(([tick, sides]) => tick > state.tick - LATELY && tick <= state.tick && sides[side]).map(([, sides]) => sides[side]);
    stage.draw(frames[side]);
  });
  const scene = state.scenes[0];
  $("moment").value = state.tick;
  tellClock();
  for (const [tick, sides] of state.frames) {
    if (tick > state.tick || sides.charted) continue;
    sides.forEach((frame, side) => state.charts.put(side, [frame]));
    sides.charted = true;
  }
  state.charts.show(state.tick, frames, now, !state.playing && !state.live);
  state.film?.draw();
  state.pictures.push(now);
  while (state.pictures[0] < now - 1000) state.pictures.shift();
  if (!state.playing || now - state.numbersAt > 100) {
    state.numbersAt = now;
    tellNumbers($("numbers"), state.scenes, frames, state.settled);
    state.charts.tell();
    $("rate").textContent = state.playing ? `${state.pictures.length} fps` : "";
    tellChosen();
  }
}

// what a screen reader says of a moment that is looked at for longer
function sayMoment() {
  const lines = [...$("numbers").querySelectorAll("tr")].slice(0, 4).map((row) => [...row.cells].map((cell) => cell.textContent).join(" "));
  $("said").textContent = [$("clock").textContent, ...lines].join(", ");
}

function tellClock() {
  const scene = state.scenes[0];
  const seconds = scene.seconds ? `, ${clockOf(state.tick * scene.seconds)}` : "";
  const soFar = state.grows && !state.live ? " so far" : "";
  const text = `${scene.unit} ${state.tick.toLocaleString("en")} of ${scene.rounds.toLocaleString("en")}${soFar}${seconds}`;
  if ($("clock").textContent === text) return;
  $("clock").textContent = text;
  $("moment").setAttribute("aria-valuetext", text);
}

function clockOf(seconds) {
  const whole = Math.floor(seconds);
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  return `${h ? `${h}:` : ""}${String(m).padStart(h ? 2 : 1, "0")}:${String(s).padStart(2, "0")}`;
}

// the links of the chosen robot, where a frame has none because there are too many
function linkChosen(facts, side) {
  state.stages.forEach((stage, k) => {
    stage.own = k === side && facts?.hears ? facts : null;
    if (stage.frame) stage.draw(stage.frame);
  });
}

async function tellChosen() {
  if (state.chosen === null || state.telling) return;
  state.telling = true;
  const [run, tick, robot, side] = [state.run, state.tick, state.chosen, state.side];
  try {
    const facts = await state.source.robot(side, robot, tick);
    if (run === state.run && robot === state.chosen) {
      tellRobot($("told"), facts, state.scenes[side]);
      $("told").dataset.tick = facts.tick;
      $("told").dataset.robot = facts.robot;
      if (facts.hears) linkChosen(facts, side);
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
  [state.halted, state.workAt] = [false, 0];
  if (state.tick >= rounds()) seek(state.grows ? rounds() : 0);
  if (state.live) return;
  state.playing = true;
  state.place = state.tick;
  showPlay();
  remember();
}

function pause() {
  state.playing = state.live = false;
  showPlay();
  again();
  remember();
  if (state.grows) showLive();
}

// at the newest moment of logs that grow the page follows them
function reachEnd() {
  pause();
  if (state.grows) seek(rounds());
}

function toggle() {
  if (state.playing || state.live) pause();
  else play();
}

function showPlay() {
  const runs = state.playing || state.live;
  $("play").textContent = runs ? "❚❚ Pause" : "▶ Play";
  $("play").setAttribute("aria-label", runs ? "Pause" : "Play");
}

function seek(tick) {
  if (state.halted) complain(null);
  [state.halted, state.workAt] = [false, 0];
  state.tick = state.place = Math.min(Math.max(Math.round(tick), 0), rounds());
  if (state.goal?.tick !== undefined) state.goal.tick = state.tick; // of a trial that is prepared
  state.live = state.grows && !state.playing && state.tick >= rounds();
  if (state.grows) showLive();
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
  linkChosen(null, side);
  $("which").value = robot ?? "";
  legend();
  $("to-robot").textContent = robot === null ? "Robot ↓" : `Robot ${robot} ↓`;
  if (robot !== null && $("told").dataset.robot !== String(robot)) $("told").replaceChildren(element("p", { class: "note" }, `Loading robot ${robot} …`));
  $("which-side").value = side;
  plotMemory();
  again();
  remember();
  tellChosen();
}

function pace(by) {
  const at = SPEEDS.indexOf(state.speed) + by;
  playAt(SPEEDS[Math.min(Math.max(at, 0), SPEEDS.length - 1)]);
  remember();
}

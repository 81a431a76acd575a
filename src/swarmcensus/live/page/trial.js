"use strict";
// The trial that is shown, and the address of the current moment.

const $ = (id) => document.getElementById(id);
const SPEEDS = [1, 2, 5, 10, 20, 30, 60, 120, 300, 1000, 3000, 10000, Infinity];
const FASTEST = 10000; // that an address can name, but for Infinity
const USUAL = 60; // ticks per second
const PICTURES = 60; // frames drawn per second
const AHEAD = 120; // frames that are fetched in advance
const MEMORIES = 30000; // robots in all stored frames together
const LATELY = 300; // rounds for which the readings of the chosen robot are shown
const AT_ONCE = 120; // frames per request, if many are missing
const PATIENCE = 200; // milliseconds after which a moment counts as chosen, and not as passed through
const PAUSE = 150; // milliseconds between pieces of work that nobody waits for
const SOON = 150; // milliseconds after which the address holds what was changed
const DIM = 300; // milliseconds after which a picture is dimmed while another one is prepared
const COLOURS = [["off", "too high or too low"], ["belief", "estimate, 0 to 1"], ["error", "absolute error"]]; // of estimates
const LIARS = { brain: "commons", beside: "steadfast", members: '[{robots = 0.16, brain = "always-black", honest = false}]' }; // commons follows them
const recordedText = $("recorded");

const state = {
  source: recordedText ? new Recorded(JSON.parse(recordedText.textContent)) : new Live(),
  ask: {}, scenes: [], form: null, stages: [], view: new View(), charts: null, frames: new Map(),
  tick: 0, place: 0, playing: false, speed: USUAL, colour: "off", unpainted: true, chosen: null, side: 0, plot: "", follow: false,
  lie: "", next: null, goal: null, changes: [], later: [], preparing: false, asking: false, halted: false, completed: "", working: false, workAt: 0, settled: null, film: null, live: false, grows: false, run: 0, drawn: -1, shownAt: 0, last: 0, pictures: [], numbersAt: 0,
};

function complain(error) {
  $("error").hidden = !error;
  $("error").textContent = error ? error.message || String(error) : "";
  for (const input of document.querySelectorAll("#world [aria-invalid]")) input.removeAttribute("aria-invalid");
  const key = (error?.key ?? "").split(".").at(-1).replace(/^members.*|^robots\[.*/, "liars");
  const input = key && $(`control-${key}`);
  if (input && input.value !== state.form?.now[key]) input.setAttribute("aria-invalid", "true"); // not where it is as it was again
}

const rounds = () => state.scenes[0]?.rounds || 0;
const step = () => Math.max(1, Math.ceil(Math.min(state.speed, 1e9) / PICTURES) || 1);
const strides = () => (state.speed === Infinity ? Math.max(1, Math.floor(rounds() / 600)) : Math.min(step(), Math.max(1, Math.floor(rounds() / 100))));

function goalOf(text) {
  const asked = Object.fromEntries(new URLSearchParams(text.replace(/^#/, "")));
  const { tick, robot, side, plot, colour, zoom, centre, follow, log, full, speed, ...ask } = asked;
  const view = Object.fromEntries(Object.entries(asked).filter(([key]) => !(key in ask)));
  const [x, y] = (centre || "").split(",").map(Number);
  return {
    ask, view, tick: Number.parseInt(tick, 10) || (tick === undefined ? null : 0), robot: robot === undefined ? null : Number.parseInt(robot, 10),
    side: side === "1" ? 1 : 0, plot: plot || "", colour: Object.hasOwn(TOLD, colour) ? colour : null, zoom: Number(zoom) || 1,
    centre: x >= 0 && x <= 1 && y >= 0 && y <= 1 ? [x, y] : [0.5, 0.5],
    follow: follow === "1", log: log === "1", full: full === "1", speed: speed >= 1 && (speed <= FASTEST || speed === "Infinity") ? Number(speed) : USUAL,
  };
}

function viewed() {
  again();
  remember();
}

function playAt(speed) {
  if (!SPEEDS.includes(speed)) SPEEDS.splice(SPEEDS.findIndex((other) => other > speed), 0, speed);
  $("speed").replaceChildren(...SPEEDS.map((one) => element("option", { value: String(one) }, one === Infinity ? "as fast as possible" : `${one.toLocaleString("en")} per second`)));
  $("speed").value = String(speed);
  state.speed = speed;
}

// the view of an address: all but the trial and its moment
function look({ side, plot, colour, zoom, centre, follow, log, full, speed }) {
  [state.side, state.plot, state.follow, state.unpainted] = [side, plot, follow, !colour];
  playAt(speed);
  [$("follow").checked, $("log").checked, $("full").checked] = [follow, log, full];
  state.view.set(zoom, centre);
  paint(colour || "off");
}

function fragment(moving = state.live || state.playing) {
  const changes = [...state.later, ...state.changes];
  const ask = changes.reduce(changed, (state.next ?? state.goal ?? state).ask);
  const words = new URLSearchParams(ask);
  if (!words.has("trial") && state.form) words.set("trial", state.form.now.trial);
  if (!words.has("seed") && state.form) words.set("seed", state.form.now.seed);
  if (state.form && (ask.setting ?? "") === (state.ask.setting ?? "")) words.set("of", state.form.mark);
  if (!moving) words.set("tick", state.tick);
  if (state.chosen !== null) words.set("robot", state.chosen);
  if (state.side) words.set("side", state.side);
  if (state.plot && state.chosen !== null) words.set("plot", state.plot);
  if (!state.unpainted) words.set("colour", state.colour);
  const { zoom, centre } = state.view;
  if (zoom > 1) words.set("zoom", Number(zoom.toFixed(2)));
  if (zoom > 1 && !state.follow) words.set("centre", centre.map((part) => Number(part.toFixed(3))).join());
  if (state.follow) words.set("follow", 1);
  for (const id of ["log", "full"]) if ($(id).checked) words.set(id, 1);
  if (state.speed !== USUAL) words.set("speed", state.speed);
  return `#${words}`;
}

// browsers refuse too many changes of an address in a short time
function remember() {
  clearTimeout(state.remembering);
  state.remembering = setTimeout(() => history.replaceState(null, "", fragment()), SOON);
}

const titled = () => `${state.form.name}: ${state.scenes[0].title}; seed ${state.form.now.seed}, trial ${state.form.now.trial}`;

// one request at a time, so that server and page show the same trial
// where logs grow, no tick is the newest one
async function begin(ask, tick = null, robot = state.chosen, view = {}) {
  [state.next, state.changes, state.later] = [{ ask, tick, robot, view, changes: [] }, [], []];
  await prepare();
}

// changes that come while a trial is prepared wait for it, and are then made together
async function change(key, value) {
  if (key === "adversary") state.lie = value;
  if (key === "adversary" || key === "liars") return change("members", membersNow());
  state.changes = [...state.changes.filter((one) => one.key !== key), { key, value }];
  if (!state.source.lost) complain(null);
  await prepare();
}

// the members of a swarm as a study has them: those that do not lie, and the liars of the controls
function membersNow() {
  const [text, lie] = [$("control-liars").value.trim(), $("control-adversary").value || "always-black"];
  if (text === "") return "";
  const share = Number(text);
  const who = lie.startsWith("{") ? lie : JSON.stringify(lie);
  const liar = `{robots = ${Number.isInteger(share) ? share.toFixed(1) : share}, brain = ${who}, honest = false}`;
  return `[${[...state.form.honest, ...(share === 0 ? [] : [liar])].join(", ")}]`;
}

function goalOfChanges() {
  const changes = state.later.length ? [state.later.shift()] : state.changes.splice(0);
  return { ask: changes.reduce(changed, state.ask), tick: state.tick, robot: state.chosen, changes };
}

async function prepare() {
  if (state.preparing) return;
  state.preparing = true;
  if (!state.source.lost) $("title").textContent = "preparing …";
  let refused = null;
  while (state.next || state.later.length || state.changes.length) {
    const together = !state.later.length;
    const goal = (state.goal = state.next ?? goalOfChanges());
    state.next = null;
    try {
      const answer = await state.source.begin(goal.ask, goal.tick ?? 0, goal.view ?? {});
      const picture = state.form && (await firstOf(answer, goal).catch(() => null)); // what fails fails again below
      arrive(answer, goal);
      if (picture) keep(picture);
      if (together && !goal.instead) refused = null;
    } catch (error) {
      refused = error;
      // of several changes only the wrong one is lost; for an invalid link the start of its trial, or of the first one, is shown
      if (goal.changes.length > 1) state.later = goal.changes;
      else if (!state.form && (goal.view || Object.keys(goal.ask).length)) {
        look(goalOf(""));
        state.next ??= { ask: goal.view ? goal.ask : {}, tick: null, robot: null, changes: [], instead: true };
      }
    }
    state.goal = null;
  }
  state.preparing = false;
  if (refused && state.form) showFields();
  complain(refused);
  $("title").textContent = $("title").title = state.form ? titled() : "";
  if (state.form) remember();
}

// fields show what was asked for, also while it is prepared
function showFields() {
  const asked = Object.fromEntries([...state.later, ...state.changes].map(({ key, value }) => [key, value]));
  const adversary = state.form.now.adversary || state.lie;
  buildFields({ ...state.form, now: { ...state.form.now, adversary, ...asked } }, asked, change, Boolean(recordedText));
}

// the frames of the moment with which a trial begins: until then the page keeps its old picture
async function firstOf({ scenes }, goal) {
  const tick = Math.min(Math.max(goal.tick ?? 0, 0), ...scenes.map((scene) => scene.rounds));
  let sides = null;
  while (!sides && !state.next && !state.changes.length) sides = await state.source.frames(tick, 1, 1);
  return sides;
}

function arrive({ form, scenes }, { ask, tick, robot, changes }) {
  state.run += 1;
  const isOther = changes.length > 0 && form.unit !== state.form.unit; // a link names a moment of its own
  const note = noteOf(form, scenes[0], tick, isOther);
  if (isOther) {
    tick = 0;
    state.view.set(1, [0.5, 0.5]);
  }
  [state.ask, state.scenes, state.form] = [form.asked || ask, scenes, form];
  state.frames.clear();
  state.chosen = robot !== null && robot >= 0 && robot < scenes[0].robots ? robot : null;
  state.side = Math.min(state.side, scenes.length - 1);
  state.grows = form.grows && Boolean(state.source.news);
  state.live = state.grows && tick === null;
  state.tick = state.place = state.live ? rounds() : Math.min(Math.max(tick ?? 0, 0), rounds());
  [state.drawn, state.completed, state.asking, state.halted, state.shownAt] = [-1, "", false, false, performance.now()];
  [state.working, state.workAt, state.settled] = [false, 0, null];
  buildPage();
  $("world-note").textContent = note;
  remember();
  showLive();
  followLogs(state.run);
}

// what a change does to the moment, or why nothing can be changed
function noteOf(form, { unit, rounds: last }, tick, isOther = false) {
  if (recordedText) return "This is a recording; swarmcensus watch shows other worlds. Estimates are rounded to four digits.";
  if (form.fixed.length) return "This recording is in robots' logs: nothing can be chosen.";
  if (isOther) return `A ${state.form.unit} is no ${unit}, so this trial begins at ${unit} 0.`;
  return tick > last ? `This trial has no ${unit} ${shown(tick)}, so its last one is shown.` : "A change keeps the moment.";
}

// the same world with two brains, of which liars lead one astray; or with its own brain and members again
function toLiars() {
  const ask = Object.keys(LIARS).reduce((before, key) => changed(before, { key, value: isAmongLiars() ? "" : LIARS[key] }), state.ask);
  if (state.playing) pause();
  begin(ask, 0, null).then(playUnasked);
}

const isAmongLiars = () => Object.entries(LIARS).every(([key, value]) => (state.ask[key] ?? state.form.now[key])?.replaceAll(" ", "") === value.replaceAll(" ", ""));

function buildPage() {
  const { scenes, form } = state;
  form.colours.forEach((colour, side) => document.documentElement.style.setProperty(["--of-a", "--of-b"][side], colour));
  TONES.clear();
  document.title = `${scenes.map((scene) => scene.brain).join(" and ")} – swarmcensus`;
  const focused = state.stages.findIndex((stage) => stage.host === document.activeElement);
  for (const stage of state.stages) stage.destroy();
  state.charts?.destroy();
  $("stages").replaceChildren();
  document.querySelector("main").classList.toggle("pair", scenes.length > 1);
  state.stages = scenes.map((scene, side) => {
    const host = element("div", { class: "stage", tabindex: 0, role: "img", "aria-label": `${shown(scene.robots)} ${scene.robots === 1 ? "robot" : "robots"} with ${scene.brain}` });
    const size = element("span", { class: "size" }, `: ${shown(scene.memory)} bytes of memory, ${shown(scene.message)} per message`);
    $("stages").append(element("figure", {}, element("figcaption", {}, scene.brain, size), host));
    if (side === focused) host.focus({ preventScroll: true });
    return new Stage(host, scene, state.view, { choose: (robot) => choose(robot, side), changed: viewed, moved: unfollow });
  });
  placeNumbers();
  $("moment").max = rounds();
  $("which").max = scenes[0].robots - 1;
  $("which").value = state.chosen ?? "";
  $("which-side").replaceChildren(...scenes.map((scene, side) => element("option", { value: side }, scene.brain)));
  $("which-side").value = state.side;
  $("which-side").hidden = scenes.length < 2;
  paint(state.unpainted ? "off" : state.colour);
  if (state.chosen === null) $("told").replaceChildren(element("p", { class: "note" }, "Click a robot, or type its number, to see its memory, its reading and the messages that it hears."));
  showFields();
  state.charts = new Charts($("plots"), scenes, seek, state.grows);
  state.charts.build($("log").checked, $("full").checked);
  plotMemory();
  $("among").hidden = Boolean(recordedText) || form.fixed.length > 0;
  $("among").textContent = isAmongLiars() ? "As it was, without liars" : "Two brains among liars";
  showColours();
  legend();
}

function showColours() {
  $("colour").replaceChildren(...COLOURS.filter(([value]) => judged() || value === "belief").map(([value, text]) => element("option", { value }, text)));
  $("colour").value = state.colour;
}

// the numbers of a pair are at the top of the side where there is one: below the swarms they would not be seen
function placeNumbers() {
  if (state.scenes.length > 1 && WIDE.matches) $("side").prepend($("numbers"));
  else $("legend").after($("numbers"));
}

function legend() {
  const g = $("scale").getContext("2d");
  SCALES[state.colour].forEach((colour, k) => {
    g.fillStyle = colour;
    g.fillRect((k * 256) / STEPS, 0, 256 / STEPS + 1, 10);
  });
  [$("legend-low").textContent, $("legend-high").textContent] = TOLD[state.colour]();
  if (!state.scenes.length) return;
  const some = state.scenes.some(({ opinions }) => opinions);
  $("opinions").hidden = !some;
  $("estimates").hidden = $("colour").hidden = opined();
  $("full").parentElement.hidden = some; // their axis always is from 0 to 1
  $("tiles").hidden = !state.scenes[0].floor;
  tilesOf(state.scenes[0]).forEach((shade, black) => ($("tiles").children[black].style.background = named([shade])[0]));
  $("legend-text").textContent = legendWords().join(" · ");
}

function legendWords() {
  const { moves, crowd, dishonest, edges, ends, robots, wraps, floor } = state.scenes[0];
  const carried = crowd || !edges ? "green: links of the chosen robot that carried a message" : "green: links that carried a message";
  return [
    ...(moves ? [robots > MANY ? "lines, when zoomed in: who hears whom" : "lines: who hears whom", "dashed ring: a wrong reading"] : []),
    ...(moves && !floor ? ["grey: as much of the floor is black"] : []),
    ...(moves && state.chosen !== null ? ["dots: recent readings of the chosen robot", "large circle: its radio range"] : []),
    ...(crowd ? ["each square a robot"] : []),
    ...(moves ? [] : [edges || !recordedText ? carried : "too many links to draw"]),
    ...(wraps ? ["a link that leaves at one edge comes in at the opposite one"] : []),
    ...(dishonest.length ? [`crossed out: ${shown(dishonest.length)} of ${shown(robots)} lie`] : []),
    ...(ends && !crowd ? ["white dot: done"] : []),
    ...(state.form?.fixed.length ? ["pink: away"] : []),
  ];
}

// what is asked for after a change, without values that went with the old one
function changed(before, { key, value }) {
  const ask = { ...before };
  if (value === "") delete ask[key];
  else ask[key] = value;
  if (key === "setting" || key === "seed") delete ask.of;
  if (key === "setting") for (const other of Object.keys(ask)) if (!["setting", "trial", "seed"].includes(other)) delete ask[other];
  const gone = { topology: (other) => other.split(".").some((part) => state.form.bound.includes(part)), brain: (other) => other.startsWith("brain."), beside: (other) => other.startsWith("beside.") };
  for (const other of Object.keys(ask)) if (gone[key]?.(other)) delete ask[other];
  return ask;
}

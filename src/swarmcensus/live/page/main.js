"use strict";
// Actions of buttons and keys, and the start of the page.

const KEYS = {
  " ": () => toggle(),
  ArrowLeft: (event) => hop(event.shiftKey ? -100 : -1),
  ArrowRight: (event) => hop(event.shiftKey ? 100 : 1),
  Home: () => hop(-Infinity),
  End: () => hop(Infinity),
  "[": () => pace(-1),
  "]": () => pace(1),
  n: () => choose(state.chosen === null ? 0 : (state.chosen + 1) % state.scenes[0].robots),
  p: () => choose(state.chosen === null ? 0 : (state.chosen + state.scenes[0].robots - 1) % state.scenes[0].robots),
  f: () => $("follow").click(),
  l: () => $("log").click(),
  c: () => $("full").click(),
  "+": () => zoom(1.4),
  "-": () => zoom(1 / 1.4),
  0: () => whole(),
  w: () => move(0, -0.2),
  a: () => move(-0.2, 0),
  s: () => move(0, 0.2),
  d: () => move(0.2, 0),
};

// moving the view ends following a robot
function unfollow() {
  state.follow = $("follow").checked = false;
  viewed();
}

function move(right, down) {
  state.view.move(right, down);
  unfollow();
}

function whole() {
  zoom(0);
  unfollow();
}

function zoom(by) {
  state.view.near(by);
  viewed();
}

document.addEventListener("keydown", (event) => {
  const typing = event.target.matches("input:not([type=range]):not([type=checkbox]), select, textarea");
  const own = event.target.matches("[type=range]") ? !event.shiftKey && ["ArrowLeft", "ArrowRight", "Home", "End"].includes(event.key) : event.key === " " && event.target.matches("button, summary, [type=checkbox]");
  const does = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (typing || own || event.ctrlKey || event.altKey || event.metaKey || !does || !state.scenes.length) return;
  event.preventDefault();
  does(event);
});

playAt(USUAL);
$("speed").addEventListener("change", () => {
  state.speed = Number($("speed").value);
  remember();
});
function paint(colour) {
  state.colour = judged() ? colour : "belief";
  showColours();
  legend();
  again();
}
$("colour").addEventListener("change", () => {
  state.unpainted = false;
  paint($("colour").value);
  remember();
});
$("play").addEventListener("click", toggle);
$("live").addEventListener("click", () => (state.live ? pause() : hop(Infinity)));
$("first").addEventListener("click", () => hop(-Infinity));
$("last").addEventListener("click", () => hop(Infinity));
$("back").addEventListener("click", (event) => hop(event.shiftKey ? -100 : -1));
$("forth").addEventListener("click", (event) => hop(event.shiftKey ? 100 : 1));
$("moment").addEventListener("input", () => seek(Number($("moment").value)));
$("moment").addEventListener("change", remember);
$("which").addEventListener("change", () => {
  const robot = Number.parseInt($("which").value, 10);
  if (robot >= 0 && robot < state.scenes[0].robots) {
    choose(robot);
    $("which").blur(); // so that keys work again
  }
  else $("which").value = state.chosen ?? "";
});
$("plot").addEventListener("change", () => {
  state.plot = $("plot").value;
  if (state.chosen === null) choose(0);
  else plotMemory();
  again();
  remember();
});
$("which-side").addEventListener("change", () => choose(state.chosen, Number($("which-side").value)));
$("follow").addEventListener("change", () => {
  if (state.chosen === null) choose(0);
  state.follow = $("follow").checked;
  zoom(state.follow ? Math.max(1, 3 / state.view.zoom) : 0);
});
for (const id of ["log", "full"]) {
  $(id).addEventListener("change", () => {
    state.charts?.build($("log").checked, $("full").checked);
    again();
    remember();
  });
}
$("nearer").addEventListener("click", () => zoom(1.4));
$("farther").addEventListener("click", () => zoom(1 / 1.4));
$("whole").addEventListener("click", whole);
$("among").addEventListener("click", toLiars);
$("to-robot").addEventListener("click", () => $("robot").scrollIntoView());
$("world").addEventListener("submit", (event) => event.preventDefault());
$("copy").addEventListener("click", async () => {
  remember();
  try {
    await navigator.clipboard.writeText((recordedText ? "" : location.href.split("#")[0]) + fragment(false));
    $("copy").textContent = "Copied";
  } catch {
    $("copy").textContent = "Copy it from the address bar";
  }
  setTimeout(() => ($("copy").textContent = "Copy link"), 2000);
});
window.addEventListener("resize", () => {
  again();
  state.charts?.fit();
});
WIDE.addEventListener("change", placeNumbers);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  TONES.clear();
  state.charts?.build();
  again();
});
document.addEventListener("pointerdown", ({ target }) => $("save").contains(target) || ($("save").open = false));
document.addEventListener("keydown", ({ key }) => {
  if (key !== "Escape" || !$("save").open) return;
  $("save").open = false;
  $("save").firstElementChild.focus();
});
window.addEventListener("hashchange", () => {
  const goal = goalOf(location.hash);
  if (state.playing) pause();
  look(goal);
  begin(goal.ask, goal.tick, goal.robot, goal.view).then(() => goal.tick === null && playUnasked());
});

// a page opens playing, unless its address names a moment or its reader wants little motion
function playUnasked() {
  if (state.form && !state.grows && !matchMedia("(prefers-reduced-motion: reduce)").matches) play();
}

async function start() {
  document.body.classList.toggle("bare", Boolean(recordedText) && window.self !== window.top); // within another page
  const played = recordedText ? new URLSearchParams(state.source.recording.played).toString() : "";
  const goal = goalOf(location.hash || played);
  look(goal);
  try {
    state.source.closed = (error) => {
      complain(error);
      if (state.form) $("title").textContent = titled();
    };
    state.source.found = () => {
      if ([GONE, OTHER, FULL].includes($("error").textContent)) complain(null);
    };
    await state.source.open();
    requestAnimationFrame(tickOn);
    await begin(goal.ask, goal.tick, goal.robot, goal.view);
    if (goal.tick === null) playUnasked();
  } catch (error) {
    $("title").textContent = "";
    complain(error);
  }
}

start();

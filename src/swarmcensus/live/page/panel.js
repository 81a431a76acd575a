"use strict";
// The panels next to the swarm: controls of the world, numbers of the moment, and one robot in full.

const BRAINS = [["brain", "Brain"], ["beside", "Compare with"]];
const WORLD = [
  ["robots", "Robots", { type: "number", min: 1, max: 20000, step: 1 }],
  ["accuracy", "Accuracy", { type: "text" }], ["fill_ratio", "Fill ratio", { type: "number", max: 1 }],
  ["topology", "Network"], ["density", "Swarm density", { type: "number", min: 0, step: 0.5 }], ["floor", "Floor"],
  ["link_success", "Link success", { type: "number", min: 0, max: 1, step: 0.05 }],
  ["liars", "Share of liars", { type: "number", min: 0, max: 1, step: 0.05 }], ["adversary", "Their lie"],
  ["rounds", "Length, rounds", { type: "number", min: 1, step: 1 }], ["ticks", "Length, ticks", { type: "text" }], ["setting", "Setting", { type: "number", min: 0, step: 1 }],
  ["trial", "Trial", { type: "number", min: 0, step: 1 }], ["seed", "Seed", { type: "text", inputmode: "numeric" }],
];

// the values at which a slider stops; those of the fill ratio are on no edge between two bins
const steps = (from, to, by) => Array.from({ length: Math.round((to - from) / by) + 1 }, (_, k) => Number((from + k * by).toFixed(4)));
const STOPS = {
  robots: () => [1, 2, 3, 4, 5, ...[1, 10, 100, 1000].flatMap((ten) => [10, 15, 20, 25, 30, 40, 50, 60, 80].map((size) => size * ten)).filter((size) => size <= 20000)],
  accuracy: () => steps(0.5, 1, 0.01),
  fill_ratio: (bins) => {
    const found = steps(0, 1, 0.01).filter((f) => f === 0 || f === 1 || Math.abs(f * bins - Math.round(f * bins)) > 1e-9);
    return found.length > 2 ? found : steps(0.5, bins - 0.5, 1).map((k) => k / bins);
  },
  link_success: () => steps(0, 1, 0.05),
  liars: () => steps(0, 1, 0.05),
};

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

// the fields of the page: brains with their parameters, and the world
function buildFields(form, asked, change, fixed) {
  buildControls($("brains"), form, BRAINS, change, fixed);
  const several = form.parameters.some(({ key }) => key.startsWith("beside."));
  const named = ({ key, name, brain }) => [key, several ? `${name} (${brain})` : name, { type: "text", inputmode: "decimal" }];
  const values = Object.fromEntries(form.parameters.map(({ key, now }) => [key, asked[key] ?? now]));
  $("parameters-title").hidden = !form.parameters.length;
  $("parameters-title").firstElementChild.textContent = `Parameters (${form.parameters.length})`;
  buildControls($("parameters"), { ...form, now: { ...form.now, ...values } }, form.parameters.map(named), change, fixed);
  buildControls($("controls"), form, WORLD, change, fixed);
  buildOthers(form, change, fixed);
}

// keys of a study that have no control here: those that were given, each with its value, and one more
function buildOthers(form, change, fixed) {
  const shown = [...BRAINS, ...WORLD, ["of"], ["members"]].map(([key]) => key);
  const keys = Object.keys(form.asked).filter((key) => !shown.includes(key) && !/^(brain|beside)\./.test(key));
  $("others-title").hidden = fixed || form.fixed.length > 0;
  $("others-title").open ||= keys.length > 0;
  const rows = [...keys.map((key) => [key, key, { type: "text" }]), ["KEY=VALUE", "KEY=VALUE", { type: "text", placeholder: "missing_links=0.1" }]];
  const set = (key, text) => {
    const [name, value] = key === "KEY=VALUE" ? text.split(/\s*=\s*(.*)/s, 2) : [key, text];
    if (value !== undefined) change(name, value);
    else if (name) complain(new Error(`${name}: should be KEY=VALUE, such as missing_links=0.1`));
  };
  buildControls($("others"), { ...form, now: { ...form.now, ...form.asked, "KEY=VALUE": "" } }, rows, set, fixed);
}

// keeps the elements, so that typed text and focus survive
function buildControls(host, form, controls, change, fixed) {
  const rows = [];
  for (const [key, text, attributes] of controls) {
    const choices = form.choices[key];
    if (!(key in form.now)) continue; // of another kind of world
    if (key === "rounds" && form.fixed.includes(key)) continue; // robots' logs have no length of their own
    if (key === "setting" && form.settings[0] === form.settings[1]) continue;
    const id = `control-${key}`;
    const there = $(id);
    const input = there || element(choices ? "select" : "input", { id, name: key, ...attributes });
    if (!there) {
      input.setAttribute("aria-describedby", "error");
      input.addEventListener("input", () => input.removeAttribute("aria-invalid"));
      input.addEventListener("change", () => change(key, input.value.trim()));
    }
    if (choices) {
      const names = Object.entries(choices).map(([value, name]) => element("option", { value }, name));
      if (names.map((one) => one.value).join() !== [...input.options].map((one) => one.value).join()) input.replaceChildren(...names);
    }
    if (input !== document.activeElement || input.dataset.now !== form.now[key]) input.value = form.now[key];
    input.dataset.now = form.now[key];
    input.disabled = fixed || form.fixed.includes(key) || (form.fixed.length > 0 && !(key in form.choices));
    const more = { setting: `, ${form.settings.join(" to ")}`, trial: form.trials ? ` (of ${form.trials.toLocaleString("en")})` : "" }[key] || "";
    const { bins } = state.scenes[0];
    if (key === "fill_ratio") [input.min, input.step] = [0.5 / bins, 1 / bins]; // arrow keys go to the middles of bins
    const stops = STOPS[key]?.(bins);
    rows.push(there ? host.querySelector(`[for="${id}"]`) : element("label", { for: id }), stops ? slid(input, stops, text) : input);
    rows.at(-2).textContent = text + more;
  }
  if (rows.length === host.children.length && rows.every((one, k) => one === host.children[k])) return;
  const focused = document.activeElement;
  host.replaceChildren(...rows);
  if (rows.includes(focused)) focused.focus();
}

// a number with a slider, which stops at some values
function slid(input, stops, text) {
  const both = input.parentElement?.matches(".slid") ? input.parentElement : element("span", { class: "slid" }, element("input", { type: "range", min: 0, "aria-label": `${text}, slider` }), input);
  const slider = both.firstElementChild;
  const nearest = stops.reduce((best, stop, k) => (Math.abs(stop - input.value) < Math.abs(stops[best] - input.value) ? k : best), 0);
  [slider.max, slider.value, slider.disabled] = [stops.length - 1, nearest, input.disabled];
  const tell = () => slider.setAttribute("aria-valuetext", input.value);
  slider.oninput = () => {
    input.value = stops[slider.value];
    tell();
  };
  slider.onchange = () => input.dispatchEvent(new Event("change"));
  tell();
  return both;
}

function shown(value) {
  if (value === null || value === undefined) return "–";
  if (Array.isArray(value)) return value.map(shown).join(", ");
  if (typeof value !== "number") return String(value);
  if (Number.isInteger(value) && Math.abs(value) < 1e12) return value.toLocaleString("en");
  return String(Number(value.toPrecision(7)));
}

// one of several values in a cell, between which its line may break
const unbroken = (value, k) => [k ? ", " : "", element("span", {}, shown(value))];

function tableOf(caption, rows) {
  const body = element("tbody");
  for (const [name, value] of rows) body.append(element("tr", {}, element("th", { scope: "row" }, name), element("td", { "data-of": name }, ...(Array.isArray(value) ? value.flatMap(unbroken) : [shown(value)]))));
  return element("table", {}, element("caption", {}, caption), body);
}

function tellRobot(host, facts, scene) {
  const belief = facts.sensor;
  const rows = [["estimate", facts.estimate]];
  if (judged()) rows.push(["truth", facts.truth], ["error", facts.estimate === null ? null : Number(Math.abs(facts.estimate - facts.truth).toPrecision(4))]);
  if (facts.tile !== undefined) {
    rows.push(["stands on", facts.tile === null ? "–" : facts.tile ? "black" : "white"]);
    rows.push(["its sensor says", facts.reading === null ? "not looking" : `${facts.reading ? "black" : "white"}${facts.reading === facts.tile ? "" : ", wrong"}`]);
  }
  if (facts.looks !== undefined) rows.push(["its sensor says", `${shown(facts.blacks)} of ${shown(facts.looks)} black`]);
  if (belief) {
    rows.push(["sensor's b, w", `${shown(belief.b)}, ${shown(belief.w)}`]);
    rows.push(["believed b, w", `${shown(belief.believed_b)}, ${shown(belief.believed_w)}`]);
  }
  const at = facts.recorded !== undefined && facts.recorded !== facts.tick ? `, as of ${scene.unit} ${shown(facts.recorded)}` : "";
  const parts = [
    element("p", { class: "note" }, `Robot ${facts.robot}, ${facts.brain}${facts.honest ? "" : ", a liar"}, ${scene.unit} ${shown(facts.tick)}`),
    tableOf("Belief and sensor", rows),
    tableOf(`Memory${at}`, Object.entries(facts.fields)),
  ];
  if (facts.heard) {
    const when = facts.heard_at === facts.tick ? `this ${scene.unit}` : `${scene.unit} ${shown(facts.heard_at)}`;
    const caption = facts.heard.length ? `Heard in ${when}${facts.adds ? ", as added to sums" : ""}` : "No recent messages";
    parts.push(tableOf(caption, facts.heard.slice(0, 40).map(({ from, said }) => [`robot ${from}`, Object.entries(said).map(([name, value]) => `${name} ${shown(value)}`)])));
    if (facts.heard.length > 40) parts.push(element("p", { class: "note" }, `and ${shown(facts.heard.length - 40)} more`));
  }
  host.replaceChildren(...parts);
}

const NUMBERS = [
  ["truth", "fill ratio"], ["mean", "mean estimate"], ["deviation", "standard deviation"], ["black", "share for black"], ["white", "share for white"], ["right", ({ bins }) => `share in right bin (of ${bins})`],
  ["decided", "share decided"], ["decided_right", ({ options }) => `share decided right (of ${options})`], ["done", "share done"],
  ["interval_low", "mean interval from"], ["interval_high", "mean interval to"], ["sent", "messages sent"], ["heard", "messages heard"], ["bytes", "bytes sent"],
];

const ESTIMATED = ["mean", "deviation"];
const COUNTED = ["sent", "heard", "bytes"];

// K of a side as far as it is known at a moment, NaN while it is computed: nothing is shown before it happens
function settledBy(k, tick, last) {
  if (k && k <= tick) return Math.round(k).toLocaleString("en");
  if (Number.isNaN(k) || tick < last) return "not yet";
  return k === null ? "not settled" : "never learnt";
}

function tellNumbers(host, scenes, frames, settled) {
  const body = element("tbody");
  const column = (name) => scenes[0].columns.indexOf(name);
  for (const [name, text] of NUMBERS) {
    const values = frames.map((frame, side) => (ESTIMATED.includes(name) && scenes[side].opinions ? NaN : frame.numbers[column(name)]));
    if (values.every(Number.isNaN)) continue;
    const of = scenes[values.findIndex((value) => !Number.isNaN(value))]; // one that has the number
    body.append(element("tr", {}, element("th", { scope: "row" }, typeof text === "function" ? text(of) : text), ...values.map((value) => element("td", {}, Number.isNaN(value) ? "–" : COUNTED.includes(name) ? value.toLocaleString("en") : value.toFixed(4)))));
  }
  const title = `From this ${scenes[0].unit} on half of the honest robots keep their estimates; never learnt: they kept the first one`;
  const known = settled ?? scenes.map(() => NaN);
  body.append(element("tr", { title }, element("th", { scope: "row" }, `K, ${scenes[0].unit} of settling`), ...known.map((k) => element("td", {}, settledBy(k, frames[0].tick, scenes[0].rounds)))));
  const head = scenes.length > 1 ? [element("thead", {}, element("tr", {}, element("th"), ...scenes.map((scene) => element("td", {}, scene.brain))))] : [];
  host.replaceChildren(element("table", {}, ...head, body));
}

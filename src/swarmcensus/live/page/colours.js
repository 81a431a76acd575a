"use strict";
// Colour scales that people with colour blindness can distinguish, on light and dark backgrounds.

const BELIEF = [[0, 34, 78], [18, 53, 112], [59, 73, 108], [87, 93, 109], [112, 113, 115], [138, 134, 120], [165, 156, 116], [195, 179, 105], [225, 204, 85], [254, 232, 56]];
const WRONG = [[244, 243, 250], [190, 186, 224], [128, 115, 188], [84, 50, 150], [46, 10, 94]]; // one way, in none of the colours of OFF
const OFF = [[0, 60, 120], [0, 114, 178], [120, 180, 220], [232, 232, 228], [240, 170, 90], [213, 94, 0], [130, 50, 0]];
const STEPS = 64;
const OPINION = { white: [250, 250, 248], black: [24, 26, 28] };
const NONE = [204, 121, 167]; // colour of a robot without an estimate

function scaleOf(stops) {
  return Array.from({ length: STEPS }, (_, k) => {
    const place = (k / (STEPS - 1)) * (stops.length - 1);
    const low = Math.min(Math.floor(place), stops.length - 2);
    const part = place - low;
    return stops[low].map((value, c) => Math.round(value + part * (stops[low + 1][c] - value)));
  });
}

const named = (scale) => scale.map((colour) => `rgb(${colour.join(" ")})`);
// pixels of ImageData as 32-bit numbers in the byte order of this machine
const pixels = (scale) => new Uint32Array(Uint8ClampedArray.from(scale.flatMap((colour) => [...colour, 255])).buffer);

const HALVES = Array.from({ length: STEPS }, (_, k) => (k < STEPS / 2 ? OPINION.white : OPINION.black));
const MIXED = { belief: [...scaleOf(BELIEF), NONE], opinion: [...HALVES, NONE], off: [...scaleOf(OFF), NONE], error: [...scaleOf(WRONG), NONE] };
const SCALES = Object.fromEntries(Object.entries(MIXED).map(([how, scale]) => [how, named(scale)]));
const WORDS = Object.fromEntries(Object.entries(MIXED).map(([how, scale]) => [how, pixels(scale)]));
const SPANS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1]; // errors at the end of a scale
const CALM = 1.15; // a narrower span is taken when estimates fit into it with as much room

// a swarm of opinions is painted in their two colours, however estimates are painted
const opined = () => state.scenes.length > 0 && state.scenes.every(({ opinions }) => opinions);
const painted = ({ opinions }) => (opinions ? "opinion" : state.colour);

const TOLD = {
  belief: () => ["estimate 0", "1"],
  off: (span) => [`too low by ${span} or more`, `too high by ${span} or more`],
  error: (span) => ["error 0", `${span} or more`],
};

// the span that suits estimates: twice as far from the truth as three quarters of them are
function spanOf(before, scenes, frames) {
  const of = (frame, side, name) => frame.numbers[scenes[side].columns.indexOf(name)];
  const estimating = frames.map((frame, side) => [frame, side]).filter(([, side]) => !scenes[side].opinions);
  const far = estimating.flatMap(([frame, side]) => ["low", "high"].map((name) => 2 * Math.abs(of(frame, side, name) - of(frame, side, "truth"))));
  const most = Math.max(...far.filter((value) => !Number.isNaN(value)));
  const fitting = (needed) => SPANS.find((span) => span >= needed) || 1;
  if (!Number.isFinite(most)) return before;
  return fitting(most) > before ? fitting(most) : Math.min(before, fitting(CALM * most));
}

// the steps of a scale for estimates, as frames have them; the last step means no estimate
function stepsOf(how, estimates, truth, span, into) {
  const value = { belief: (x) => x, opinion: (x) => x, off: (x) => 0.5 + (x - truth) / span / 2, error: (x) => Math.abs(x - truth) / span }[how];
  for (let i = 0; i < estimates.length; i++) {
    const step = Math.floor(value(estimates[i] / MOST) * STEPS);
    into[i] = estimates[i] === NO_ESTIMATE ? STEPS : Math.min(STEPS - 1, Math.max(0, step));
  }
  return into;
}

const EDGE = pixels([[72, 76, 80]])[0]; // of small robots

// a colour of the style sheet; asking the browser in every frame takes long
const TONES = new Map();
function tone(name) {
  if (!TONES.has(name)) TONES.set(name, getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  return TONES.get(name);
}

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
const SPAN = 0.25; // the error at the end of a scale, in all trials and at all moments: robots in the right bin are pale

// a swarm of opinions is painted in their two colours, however estimates are painted
const opined = () => state.scenes.length > 0 && state.scenes.every(({ opinions }) => opinions);
// real robots may be on a floor that nobody has measured
const judged = () => !state.scenes.length || state.scenes[0].knows;
const painted = ({ opinions }) => (opinions ? "opinion" : state.colour);

const TOLD = {
  belief: () => ["estimate 0", "1"],
  off: () => [`${SPAN}+ too low`, `${SPAN}+ too high`],
  error: () => ["error 0", `${SPAN}+`],
};

// the steps of a scale for estimates, as frames have them; the last step means no estimate
function stepsOf(how, estimates, truth, into) {
  const value = { belief: (x) => x, opinion: (x) => x, off: (x) => 0.5 + (x - truth) / SPAN / 2, error: (x) => Math.abs(x - truth) / SPAN }[how];
  for (let i = 0; i < estimates.length; i++) {
    const step = Math.floor(value(estimates[i] / MOST) * STEPS);
    into[i] = estimates[i] === NO_ESTIMATE ? STEPS : Math.min(STEPS - 1, Math.max(0, step));
  }
  return into;
}

// a colour of the style sheet; asking the browser in every frame takes long
const TONES = new Map();
function tone(name) {
  if (!TONES.has(name)) TONES.set(name, getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  return TONES.get(name);
}

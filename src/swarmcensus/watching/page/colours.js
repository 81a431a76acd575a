"use strict";
// Colour scales that people with colour blindness can distinguish, on light and dark backgrounds.

const BELIEF = [[0, 34, 78], [18, 53, 112], [59, 73, 108], [87, 93, 109], [112, 113, 115], [138, 134, 120], [165, 156, 116], [195, 179, 105], [225, 204, 85], [254, 232, 56]];
const WRONG = [[0, 114, 178], [86, 180, 233], [200, 214, 220], [240, 180, 90], [213, 94, 0], [140, 30, 0]];
const OFF = [[0, 60, 120], [0, 114, 178], [120, 180, 220], [232, 232, 228], [240, 170, 90], [213, 94, 0], [130, 50, 0]];
const STEPS = 64;
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

const MIXED = { belief: [...scaleOf(BELIEF), NONE], off: [...scaleOf(OFF), NONE], error: [...scaleOf(WRONG), NONE] };
const SCALES = Object.fromEntries(Object.entries(MIXED).map(([how, scale]) => [how, named(scale)]));
const WORDS = Object.fromEntries(Object.entries(MIXED).map(([how, scale]) => [how, pixels(scale)]));
const MOST = { off: 0.1, error: 0.5 };
const TOLD = { belief: ["estimate 0", "1"], off: [`too low by ${MOST.off} or more`, `too high by ${MOST.off} or more`], error: ["error 0", `${MOST.error} or more`] };

// the step of a scale for an estimate; the last step means no estimate
function stepOf(how, estimate, truth) {
  if (estimate === null) return STEPS;
  const wrong = estimate - truth;
  const value = { belief: estimate, off: 0.5 + wrong / MOST.off / 2, error: Math.abs(wrong) / MOST.error }[how];
  return Math.min(STEPS - 1, Math.max(0, Math.floor(value * STEPS)));
}

function tone(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

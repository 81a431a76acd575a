"use strict";
// Colours that are told apart by whoever sees fewer of them, in the light and in the dark.

const BELIEF = [[0, 34, 78], [18, 53, 112], [59, 73, 108], [87, 93, 109], [112, 113, 115], [138, 134, 120], [165, 156, 116], [195, 179, 105], [225, 204, 85], [254, 232, 56]];
const WRONG = [[0, 114, 178], [86, 180, 233], [200, 214, 220], [240, 180, 90], [213, 94, 0], [140, 30, 0]];
const STEPS = 64;

function scaleOf(stops) {
  return Array.from({ length: STEPS }, (_, k) => {
    const place = (k / (STEPS - 1)) * (stops.length - 1);
    const low = Math.min(Math.floor(place), stops.length - 2);
    const part = place - low;
    return stops[low].map((value, c) => Math.round(value + part * (stops[low + 1][c] - value)));
  });
}

const named = (scale) => scale.map((colour) => `rgb(${colour.join(" ")})`);
// as a pixel of ImageData is one number, whatever the order of bytes here
const pixels = (scale) => new Uint32Array(Uint8ClampedArray.from(scale.flatMap((colour) => [...colour, 255])).buffer);

const MIXED = { belief: scaleOf(BELIEF), error: scaleOf(WRONG) };
const SCALES = { belief: named(MIXED.belief), error: named(MIXED.error) };
const WORDS = { belief: pixels(MIXED.belief), error: pixels(MIXED.error) };
const MOST_WRONG = 0.5;

// the step of a scale for an estimate (of 65535), where the truth is known
function stepOf(how, estimate, truth) {
  const value = how === "belief" ? estimate / 65535 : Math.min(Math.abs(estimate / 65535 - truth) / MOST_WRONG, 1);
  return Math.min(STEPS - 1, Math.floor(value * STEPS));
}

function tone(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

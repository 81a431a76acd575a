"use strict";
// A recording that still grows: the page asks for what is new, and shows the newest moment until another one is chosen.

const RECENT = 120; // newest rounds that are fetched again when logs have grown

const AGAIN = 2; // seconds until the page tries again after an error

// as long as this trial is shown, and its logs may grow
async function followLogs(run) {
  let [version, wait, failed] = [0, 0, false];
  while (run === state.run && state.grows) {
    try {
      const news = await state.source.news(version);
      if (run !== state.run) return;
      await take(news, run);
      [version, wait] = [news.version, news.wait];
      if (failed && run === state.run) complain(null);
      failed = false;
    } catch (error) {
      if (run === state.run) complain(error);
      [wait, failed] = [AGAIN, true];
    }
    if (wait !== null) await new Promise((soon) => setTimeout(soon, 1000 * wait));
  }
}

async function take({ changed, rounds: newest, wait }, run) {
  for (const scene of state.scenes) scene.rounds = newest;
  $("moment").max = newest;
  if (changed <= newest) {
    const from = Math.max(changed, newest - RECENT + 1);
    const sides = await state.source.frames(from, 1, newest - from + 1);
    if (run !== state.run) return;
    for (const tick of [...state.frames.keys()]) if (tick >= changed) state.frames.delete(tick);
    state.charts.grow(changed);
    if (sides) keep(sides);
    forget();
    sides?.forEach((frames, side) => state.charts.put(side, frames));
    await fillCurves(from, run);
  }
  if (run !== state.run) return;
  state.grows = wait !== null;
  if (state.live) [state.tick, state.place] = [newest, newest];
  if (changed <= state.tick) again();
  else state.charts.show(state.tick, state.charts.frames, performance.now());
  showLive();
}

// points of curves before a round, some of those that are missing
async function fillCurves(tick, run) {
  if (state.charts.memory?.history.missing(tick)) await fetchMemory(tick, run);
  const missing = state.charts.histories[0].missing(tick);
  if (!missing || run !== state.run) return;
  const sides = await state.source.frames(missing.from, missing.by, Math.min(missing.count, AT_ONCE));
  if (run === state.run) sides?.forEach((frames, side) => state.charts.put(side, frames));
}

function showLive() {
  $("live").hidden = !state.grows;
  $("live").setAttribute("aria-pressed", String(state.live));
  if (!state.grows) state.live = false;
  if (!state.playing) showPlay();
  tellClock();
}

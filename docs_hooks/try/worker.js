"use strict";
// Runs a swarm in MicroPython, some ticks at a time. Before this file stands MicroPython itself.

const TURN = 20; // ticks; garbage is collected between them
const WORD = 2n ** 64n - 1n;
const ROTATIONS = [16n, 42n, 12n, 31n, 16n, 32n, 24n, 21n];

// Threefry-2x64 with 13 rounds, as src/swarmcensus/engine/random.py has it
function block(k0, k1, a, b) {
  const keys = [k0, k1, 0x1bd11bdaa9fc1a22n ^ k0 ^ k1];
  [a, b] = [(a + k0) & WORD, (b + k1) & WORD];
  for (let r = 0; r < 13; r++) {
    const by = ROTATIONS[r % 8];
    a = (a + b) & WORD;
    b = (((b << by) | (b >> (64n - by))) & WORD) ^ a;
    if (r % 4 !== 3) continue;
    const j = (r + 1) / 4;
    [a, b] = [(a + keys[j % 3]) & WORD, (b + keys[(j + 1) % 3] + BigInt(j)) & WORD];
  }
  return [a, b];
}

const counter = (high, low) => (BigInt(high) << 32n) | BigInt(low);
const chance = (word) => (Number(word >> 12n) + 0.5) / 2 ** 52;

// me.luck of a robot in a function (0, tick, function, robot), or of a message (1, tick, receiver, sender)
function luckOf(keys) {
  return (kind, tick, high, low) => {
    const found = block(keys[2 * kind], keys[2 * kind + 1], counter(0, tick), counter(high, kind ? low : low >> 1));
    return chance(found[kind ? 0 : low & 1]);
  };
}

self.onmessage = async ({ data: { wasm, program, files, keys, rounds } }) => {
  self.WASM = wasm;
  const board = await loadMicroPython({ url: "micropython.wasm", heapsize: 2 ** 24, stdout: () => {} });
  board.registerJsModule("page", { luck: luckOf(keys.map(BigInt)) });
  for (const [name, content] of Object.entries(files)) board.FS.writeFile(name, content);
  const read = (name, kind) => new kind(board.FS.readFile(name).slice().buffer);
  self.postMessage({});
  try {
    board.runPython(program);
    for (let tick = 0; tick < rounds; tick += TURN) {
      board.runPython(`SWARM.go(${Math.min(TURN, rounds - tick)})`);
      self.postMessage({ estimates: read("estimates", Float64Array), spoke: read("spoke", Uint8Array) });
    }
  } catch (error) {
    self.postMessage({ error: String(error.message ?? error) });
  }
};

import { readFileSync } from "node:fs";
const [module, heap, files] = process.argv.slice(2);
const { loadMicroPython } = await import(module);
const board = await loadMicroPython({ heapsize: Number(heap), linebuffer: true, stdout: (line) => console.log(line) });
const texts = JSON.parse(readFileSync(files, "utf8"));
for (const [name, text] of Object.entries(texts)) board.FS.writeFile("/" + name, text);
board.runPython("import sys\nsys.path.append('/')\nimport main\nSTEPS = getattr(main, 'STEPS', 0)");
const steps = board.globals.get("STEPS");
for (let step = 0; step < steps; step++) board.runPython("main.step()"); // garbage is collected between them only

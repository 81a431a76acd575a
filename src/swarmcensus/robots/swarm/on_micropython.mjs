// Runs a robot's program on MicroPython inside Node: gives it sockets, wakes it when something is due, keeps its files.
// Arguments: MicroPython's module, the folder of the robot's files, its settings' module, the number of its life.
import dgram from "node:dgram";
import fs from "node:fs";
import path from "node:path";

const [module, folder, name, life] = process.argv.slice(2);
const settings = fs.readFileSync(path.join(folder, name + ".py"), "utf8");
const setting = (key) => settings.match(new RegExp(`^${key} = '(.*)'$`, "m"))[1];
const listens = !/^DELAY = 0$/m.test(settings); // a delay counts from a message's arrival
const { loadMicroPython } = await import(module);
const board = await loadMicroPython({ heapsize: 4e6, linebuffer: true, stdout: (line) => console.error(line) });

const sockets = [];
let wake = () => {};
for (const which of ["radio", "command"]) {
    const socket = dgram.createSocket({ type: "udp4", recvBufferSize: 1 << 18 });
    await new Promise((ready) => socket.bind(0, setting("HOST"), ready));
    const queue = [];
    socket.on("message", (data) => { queue.push(data.toString("hex")); if (which === "command" || listens) wake(); });
    socket.on("error", () => {});
    sockets.push({ socket, queue });
}
const command = Number(settings.match(/^COMMAND = (\d+)$/m)[1]);
const reports = sockets[1].socket;
await new Promise((ready) => reports.connect(command, setting("HOST"), ready));
reports.on("error", () => process.exit(0)); // nobody takes the reports: the command is gone

let opened = 0;
board.registerJsModule("desk", {
    now: () => Number(process.hrtime.bigint()) / 1e6,
    open: () => opened++,
    port: (handle) => sockets[handle].socket.address().port,
    waits: (handle) => sockets[handle].queue.length > 0,
    take: (handle) => sockets[handle].queue.shift() ?? "",
    send: (handle, text, port, host) => {
        const data = Buffer.from(text, "hex");
        if (handle === 1) reports.send(data);
        else sockets[handle].socket.send(data, port, host);
    },
});

// the board's files are in memory: what it appends to its log, and its saved memory, are copied out
const files = board.FS;
files.mkdirTree(folder);
for (const file of fs.readdirSync(folder).filter((file) => file.endsWith(".py")))
    files.writeFile("/" + file, fs.readFileSync(path.join(folder, file)));
const [log, memory, readings] = ["LOG", "MEMORY", "READINGS"].map(setting);
files.writeFile(readings, fs.readFileSync(readings));
const kept = ["", ".new", ".boot", ".boot.new"].map((end) => memory + end);
for (const file of kept) if (fs.existsSync(file)) files.writeFile(file, fs.readFileSync(file));
const changed = new Map();
let logged = 0;
function copyOut() {
    if (files.analyzePath(log).exists) {
        const text = files.readFile(log);
        if (text.length > logged) fs.appendFileSync(log, text.subarray(logged));
        logged = text.length;
    }
    for (const file of kept) {
        const there = files.analyzePath(file);
        if (!there.exists || changed.get(file) === Number(there.object.mtime ?? there.object.timestamp)) continue;
        changed.set(file, Number(there.object.mtime ?? there.object.timestamp));
        fs.writeFileSync(file + ".copy", files.readFile(file));
        fs.renameSync(file + ".copy", file);
    }
}

board.runPython(`
import sys
sys.path.append("/")
import board_sockets
sys.modules["socket"] = board_sockets
import node
node.select = node.time = board_sockets
one = node.Node(__import__("${name}"), ${Number(life)})
WAIT = 0
`);
for (;;) {
    board.runPython("one.rest(0)\nWAIT = one.step()"); // garbage is collected between such calls
    copyOut();
    const wait = board.globals.get("WAIT");
    await new Promise((due) => {
        const timer = setTimeout(due, Math.max(0, wait));
        wake = () => { clearTimeout(timer); due(); };
    });
    wake = () => {};
}

"use strict";
// The editor of the page on which brains are tried; the swarm is in a frame, whose script is arena.js.
(() => {
  const $ = (id) => document.getElementById(`try-${id}`);
  const { brains, adversaries, worlds, accuracies } = JSON.parse($("data").textContent);
  const CHOICES = ["name", "world", "accuracy", "liars", "adversary"];
  const OWN = "your own";
  let mine = "";

  const fill = (id, values) => $(id).replaceChildren(...values.map((value) => new Option(value)));
  fill("name", [...Object.keys(brains), OWN]);
  fill("accuracy", accuracies);
  fill("liars", [0, 1, 2, 3, 5, 8]);
  fill("adversary", Object.keys(adversaries));

  // what a brain cannot do, with the line of it chosen, unless it is 0
  function complain(text, line = 0) {
    const lines = $("brain").value.trimEnd().split("\n");
    line = Math.min(line, lines.length); // files that end too soon fail beyond their last line
    $("error").hidden = !text;
    $("error").textContent = line ? `Line ${line}: ${text}` : text;
    if (!line) return;
    const begin = lines.slice(0, line - 1).join("\n").length + (line > 1);
    $("brain").setSelectionRange(begin, begin + lines[line - 1].length);
    $("brain").scrollTop = ($("brain").scrollHeight / lines.length) * Math.max(line - 6, 0);
    $("brain").focus({ preventScroll: true });
  }

  // a brain in a world; only what a person does takes a complaint away
  function run(clears = true) {
    if (clears) complain("");
    $("adversary").disabled = $("liars").value === "0";
    $("status").textContent = "running …";
    const job = Object.fromEntries(CHOICES.map((id) => [id, $(id).value]));
    const adversary = adversaries[job.adversary];
    $("arena").contentWindow.postMessage({ ...job, adversary, liars: Number(job.liars), brain: $("brain").value }, "*");
  }

  const shade = () => $("arena").contentWindow.postMessage({ dark: document.body.dataset.mdColorScheme === "slate" }, "*");
  new MutationObserver(shade).observe(document.body, { attributeFilter: ["data-md-color-scheme"] });

  window.addEventListener("message", ({ source, data }) => {
    if (source !== $("arena").contentWindow) return;
    $("status").textContent = data.state === "done" ? `Computed in ${data.seconds.toFixed(1)} s.` : "";
    if (data.state === "ready") [shade(), run(false)];
    const lines = [...(data.text ?? "").matchAll(/File "brain.py", line (\d+)/g)];
    if (data.state === "failed") complain(data.text.trim().split("\n").at(-1), Number(lines.at(-1)?.[1] ?? 0));
  });

  const through = async (bytes, stream) => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());

  // the brain and the choices, in the part of an address that browsers do not send
  async function link() {
    const bytes = await through($("brain").value, new CompressionStream("deflate"));
    const brain = btoa(Array.from(bytes, (one) => String.fromCharCode(one)).join("")).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
    return `#${new URLSearchParams({ ...Object.fromEntries(CHOICES.map((id) => [id, $(id).value])), brain })}`;
  }

  // what an address asks for; if it is damaged, nothing changes
  async function follow() {
    const asked = Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
    let brain = brains[asked.name] ?? $("brain").value;
    if ("brain" in asked || asked.name === OWN) {
      const bytes = Uint8Array.from(atob((asked.brain ?? "").replaceAll("-", "+").replaceAll("_", "/")), (one) => one.charCodeAt(0));
      brain = new TextDecoder().decode(await through(bytes, new DecompressionStream("deflate")));
      if (brain !== brains[asked.name]) [asked.name, mine] = [OWN, brain];
    }
    for (const id of CHOICES) if ([...$(id).options].some(({ value }) => value === asked[id])) $(id).value = asked[id];
    $("brain").value = brain;
  }

  function save(name, text) {
    const address = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
    Object.assign(document.createElement("a"), { href: address, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(address), 1000);
  }

  function study() {
    const liars = `\n[[members]]\nrobots = ${$("liars").value}\nbrain  = "${$("adversary").value}"\nhonest = false\n`;
    return worlds[$("world").value].replace("0.75", $("accuracy").value) + ($("liars").value === "0" ? "" : liars);
  }

  $("form").addEventListener("submit", (event) => {
    event.preventDefault();
    run();
  });
  $("brain").addEventListener("input", () => ([$("name").value, mine] = [OWN, $("brain").value]));
  $("brain").addEventListener("keydown", (event) => event.key === "Enter" && (event.ctrlKey || event.metaKey) && run());
  $("name").addEventListener("change", () => ([$("brain").value, $("brain").scrollTop] = [brains[$("name").value] ?? mine, 0]));
  for (const id of CHOICES) $(id).addEventListener("change", run);
  $("file").addEventListener("click", () => save("my_brain.py", $("brain").value));
  $("study").addEventListener("click", () => save("my_world.toml", study()));
  $("share").addEventListener("click", async () => {
    history.replaceState(null, "", await link());
    const copied = navigator.clipboard?.writeText(location.href);
    $("status").textContent = await (copied ?? Promise.reject()).then(() => "Link copied.", () => "The link is in the address bar.");
  });
  const damaged = () => complain("This link is damaged.");
  window.addEventListener("hashchange", () => location.hash.includes("=") && follow().then(run, damaged));
  [$("name").value, $("accuracy").value, $("brain").value] = ["minimalistic", "0.75", brains.minimalistic];
  follow().catch(damaged).then(() => ($("arena").src = "arena.html"));
})();

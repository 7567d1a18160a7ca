// The page for the class: Python in the browser answers, the player shows.
const form = document.getElementById("form"), state = document.getElementById("state");
const fields = ["equation", "settings", "rule", "step", "duration"];
const tell = (words, wrong = false) => { state.textContent = words; state.className = wrong ? "wrong" : ""; };

// the first sheet comes with the page, so that it is there before Python is
const ready = start();
const first = await (await fetch("first.json")).json();
fill(first.fields);
choose(first.catalogue, first.scene);
form.rule.value = first.fields.rule;
show(first.sheet);
document.documentElement.dataset.first = Math.round(performance.now());
ready.then(drawAnew, error => tell(`Python could not be loaded: ${error.message}`, true));

function fill(values) { for (const name of fields) if (name in values) form[name].value = values[name]; }
function choose(catalogue, scene) {
  form.scene.replaceChildren(...Object.entries(catalogue.scenes).map(([name, title]) => new Option(title, name)));
  form.rule.replaceChildren(...catalogue.rules.map(name => new Option(name.replaceAll("_", " "), name)));
  form.scene.value = scene;
}

function show(sheet) {
  phaseplanePlayer(document.getElementById("player"), { mode: "protocol", ...sheet });
  document.documentElement.dataset.shown = sheet.title;
}

// Python goes on from the snapshot of its memory that was taken when the page was made.
async function start() {
  const memory = async () => {
    const packed = await fetch("python.gz.bin");
    const stream = packed.body.pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  };
  const [{ loadPyodide }, snapshot, archive] = await Promise.all([
    import("./pyodide/pyodide.mjs"), memory(), fetch("phaseplane.zip").then(answer => answer.arrayBuffer()),
  ]);
  const python = await loadPyodide({ indexURL: new URL("pyodide/", location.href).href, _loadSnapshot: snapshot });
  python.unpackArchive(archive, "zip"); // files are no part of the memory
  const answered = python.globals.get("answered");
  return request => JSON.parse(answered(JSON.stringify(request)));
}

// The sheet that came with the page, drawn by this Python.
function drawAnew(answered) {
  const sheet = answered({ what: "sheet", scene: first.scene, ...first.fields });
  const same = JSON.stringify(sheet) === JSON.stringify(first.sheet);
  if (!same && form.scene.value === first.scene) show(sheet);
  document.documentElement.dataset.ready = Math.round(performance.now());
  tell("Ready. Use the arrow keys to go from stage to stage.");
}

async function ask(what) {
  const request = { what, scene: form.scene.value };
  for (const name of fields) request[name] = form[name].value;
  const asked = await ready;
  tell("Working …");
  await new Promise(done => setTimeout(done));
  const began = performance.now();
  let found;
  try { found = asked(request); } catch (error) { found = { error: `${error.message}`.trim().split("\n").pop() }; }
  if (found.error) { tell(found.error, true); return null; }
  tell(`Done in ${Math.round(performance.now() - began)} ms. Use the arrow keys to go from stage to stage.`);
  return found;
}

form.onsubmit = async event => {
  event.preventDefault();
  const sheet = await ask("sheet");
  if (!sheet) return;
  show(sheet);
};

form.scene.onchange = async () => {
  const values = await ask("scene");
  if (values) { fill(values); form.requestSubmit(); }
};

document.getElementById("solve").onclick = async () => {
  const run = await ask("run");
  if (run) histories(document.getElementById("run"), run);
};

// The run over time: one line for each column.
function histories(root, { time, columns, unit, note }) {
  const colours = ["#2a7fc4", "#d95f14", "#2a9d5c", "#7a5cc4"];
  const NS = "http://www.w3.org/2000/svg", width = 60, height = 20, edge = 3;
  const values = Object.values(columns).flat();
  const low = Math.min(0, ...values), high = Math.max(0, ...values), last = time[time.length - 1];
  const x = t => edge + (width - edge - 1) * t / last;
  const y = v => height - 2 - (height - 3) * (v - low) / ((high - low) || 1);
  const svg = document.createElementNS(NS, "svg");
  svg.setAttribute("viewBox", `0 0 ${width} ${height + 1}`);
  const put = (name, attributes, words) => {
    const one = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes)) one.setAttribute(key, value);
    if (words !== undefined) one.textContent = words;
    svg.appendChild(one);
  };
  const round = v => +v.toPrecision(3);
  put("line", { x1: edge, x2: width - 1, y1: y(0), y2: y(0), stroke: "#6b7280", "stroke-width": 0.05 });
  for (const [v, words] of [[low, `${round(low)} ${unit}`], [high, `${round(high)} ${unit}`]]) put("text", { x: 0, y: y(v) + 0.3, "font-size": 0.8, fill: "#6b7280" }, words);
  put("text", { x: width - 4, y: height + 0.6, "font-size": 0.8, fill: "#6b7280" }, `t = ${round(last)} s`);
  Object.entries(columns).forEach(([name, column], i) => {
    put("polyline", { points: column.map((v, k) => `${x(time[k])},${y(v)}`).join(" "), fill: "none", stroke: colours[i % 4], "stroke-width": 0.15 });
    put("text", { x: edge + 1 + 14 * i, y: 1, "font-size": 0.9, fill: colours[i % 4] }, name);
  });
  root.replaceChildren(svg);
  if (note) { const p = document.createElement("p"); p.textContent = note; root.appendChild(p); }
}

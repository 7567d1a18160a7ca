// A construction on a page: the sheet, stage by stage with the arrow keys, and its protocol.
"use strict";
function phaseplanePlayer(root, data) {
  const NS = "http://www.w3.org/2000/svg";
  const COLOURS = {
    auxiliary: "#a6811d", trail: "#2a7fc4", line: "#2b9d9d", normal: "#d95f14", arc: "#2a9d5c",
    successor: "#2a9d5c", excitation: "#d0508f", projection: "#7a5cc4", turn: "#c23b3b",
    state: "#2a7fc4", event: "#c23b3b", axis: "#6b7280",
  };
  const colour = role => COLOURS[role] || "#6b7280";
  const make = (name, attributes, parent, text) => {
    const one = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes)) one.setAttribute(key, value);
    if (text !== undefined) one.textContent = text;
    parent.appendChild(one);
    return one;
  };
  const html = (name, parent, text, type) => {
    const one = document.createElement(name);
    if (text !== undefined) one.textContent = text;
    if (type) one.className = type;
    parent.appendChild(one);
    return one;
  };
  const xy = ([x, y]) => `${x},${-y}`;
  const minus = text => text.replace(/-(?=[\d.])/g, "\u2212");

  root.replaceChildren();
  html("h1", root, data.title);
  const paper = html("div", root, undefined, "paper"), side = html("div", root, undefined, "side");
  const seen = data.axes.flatMap(axes => [axes.x, axes.v].flatMap(axis => axis.ends))
    .concat(data.curves.filter(c => c.role !== "auxiliary").flatMap(c => c.points))
    .concat(data.steps.flatMap(s => s.stages.flatMap(g => g.marks.filter(m => !/^[SRM]/.test(m[1])).map(m => [m[2], m[3]]))));
  const xs = seen.map(p => p[0]), ys = seen.map(p => -p[1]);
  const left = Math.min(...xs), top = Math.min(...ys);
  const width = Math.max(...xs) - left, height = Math.max(...ys) - top;
  const em = Math.max(width, height) / (window.innerWidth < 736 ? 28 : 48);  // larger letters on a phone
  const svg = document.createElementNS(NS, "svg");
  const view = [left - 2 * em, top - 2 * em, width + 6 * em, height + 4 * em];  // room on the right for names
  svg.setAttribute("viewBox", view.join(" "));
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", data.title);
  paper.appendChild(svg);
  const line = (parent, role, points, weight = 1, dash = "") => points.length > 1 && make("polyline", {
    points: points.map(xy).join(" "), fill: "none", stroke: colour(role),
    "stroke-width": weight * em / 9, "stroke-dasharray": dash, "stroke-linejoin": "round",
  }, parent);
  const letters = (parent, role, words, at, size = 1) => make("text", {
    x: at[0], y: -at[1], fill: colour(role), "font-size": size * em, "font-family": "serif",
    "paint-order": "stroke", stroke: "#fff", "stroke-width": em / 6,
  }, parent, minus(words));
  const boxOf = text => {
    const { x, y, width, height } = text.getBBox();
    return { left: x, right: x + width, top: y + 0.15 * height, bottom: y + 0.85 * height };
  };
  const meet = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
  // Letters beside a point, at the nearest place about it where no other text is; a line leads to those far off.
  const around = [0.3, 1, 2, 3, 4, 5, 6].flatMap(far => [[1, -1], [-1, -1], [1, 1], [-1, 1], [1, 0], [-1, 0], [0, -1], [0, 1]].map(way => [far, ...way]));
  function beside(parent, role, words, [x, y], taken, size = 1) {
    const text = letters(parent, role, words, [x, y], size), box = boxOf(text);
    const w = box.right - box.left, h = box.bottom - box.top;
    for (const [far, across, down] of around) {
      const l = x + across * (far * em + w / 2) - w / 2, t = -y + down * (far * em + h / 2) - h / 2;
      const tried = { left: l, right: l + w, top: t, bottom: t + h };
      const within = l > view[0] && t > view[1] && l + w < view[0] + view[2] && t + h < view[1] + view[3];
      if (!within || taken.some(other => meet(tried, other))) continue;
      text.setAttribute("x", l - box.left + x);
      text.setAttribute("y", t - box.top - y);
      taken.push(tried);
      const near = (v, low, high) => Math.min(Math.max(v, low), high);
      if (far > 1) parent.insertBefore(line(parent, role, [[x, y], [near(x, l, l + w), -near(-y, t, t + h)]], 0.4), parent.firstChild);
      return;
    }
    text.remove();  // better no letters than two on one another
  }
  function value(parent, words, at, taken) {  // at its place, unless another text is there
    const text = letters(parent, "axis", words, at, 0.75), box = boxOf(text);
    if (taken.some(other => meet(box, other))) text.remove(); else taken.push(box);
  }
  const dot = (parent, role, at, size = 1) => make("circle", { cx: at[0], cy: -at[1], r: size * em / 5, fill: colour(role) }, parent);

  const still = make("g", {}, svg), fixed = [];  // the places of the texts that stay
  for (const curve of data.curves) line(still, curve.role, curve.points, curve.role === "trail" ? 1.4 : 1);
  for (const axes of data.axes) for (const key of ["v", "x"]) {
    const axis = axes[key], [x, y] = axis.ends[1];
    line(still, "axis", axis.ends, 1.2);
    beside(still, "axis", axis.label, [x, y], fixed);
    for (const [x, y, words] of axis.ticks) {
      const across = key === "x" ? [[x, y - em / 4], [x, y + em / 4]] : [[x - em / 4, y], [x + em / 4, y]];
      line(still, "axis", across);
      if (+words !== 0) value(still, words, key === "x" ? [x - em / 2, y - 1.1 * em] : [x - 1.9 * em, y - em / 3], fixed);
    }
  }
  const inside = ([x, y]) => x > left - em && x < left + width + em && -y > top - em && -y < top + height + em;
  for (const { role, label, points } of data.curves) if (label) {
    // a curve is named at the end in view that is farther from the axis, where the curves are farther
    // apart; further integral curves where they begin, as many of them end together
    const seen = role === "auxiliary" ? points.filter(inside) : [];
    const [first, last] = seen.length ? [seen[0], seen[seen.length - 1]] : [points[0], points[points.length - 1]];
    const at = role === "trail" || (seen.length && Math.abs(first[1]) > Math.abs(last[1])) ? first : last;
    if (role === "axis") value(still, label, [at[0] - em / 3, at[1] - 1.1 * em], fixed);
    else beside(still, role, label, at, fixed, 0.75);
  }
  const moving = make("g", {}, svg);

  if (data.mode === "exercise") return exercise();
  return player();

  function player() {
    const stages = data.steps.flatMap((step, i) => step.stages.map((stage, k) => [i, k]));
    let at = 0;
    const now = html("div", side, undefined, "now"), words = html("div", side, undefined, "words");
    words.setAttribute("aria-live", "polite");
    const buttons = html("div", side, undefined, "buttons");
    for (const [text, way, title] of [["|◀", "Home", "first stage"], ["◀", "ArrowLeft", "stage back"], ["▶", "ArrowRight", "next stage"], ["▶▶", "ArrowDown", "next step"], ["▶|", "End", "last stage"]]) {
      const one = html("button", buttons, text);
      one.type = "button"; one.title = `${title} (${way})`; one.setAttribute("aria-label", title);
      one.onclick = () => go(way);
    }
    const box = html("div", side, undefined, "table"), table = html("table", box);
    for (const [text, whole, title] of [["Print", false, "the sheet with its points so far"], ["Print protocol", true, "the sheet, and how every point is found"]]) {
      const print = html("button", buttons, text);
      print.type = "button"; print.title = title;
      print.onclick = () => { table.classList.toggle("whole", whole); window.print(); };
    }
    const head = html("tr", html("thead", table));
    for (const name of ["step", "point", "length, cm", "value"]) html("th", head, name);
    const body = html("tbody", table);
    const rows = data.protocol.map(([step, stage, point, length, value]) => {
      const row = html("tr", body);
      for (const cell of [step, point, length, value]) html("td", row, minus(String(cell)));
      row.dataset.state = stage === 0 && point[0] === "P" ? "state" : "";
      row.onclick = () => { at = Math.max(0, stages.findIndex(([i, k]) => data.steps[i].step === step && k === stage)); show(); };
      return [row, step, stage];
    });
    function go(way) {
      const [i] = stages[at];
      if (way === "ArrowRight") at = Math.min(at + 1, stages.length - 1);
      else if (way === "ArrowLeft") at = Math.max(at - 1, 0);
      else if (way === "ArrowDown") { const next = stages.findIndex(([j]) => j === i + 1); at = next < 0 ? stages.length - 1 : next; }
      else if (way === "ArrowUp") at = Math.max(0, stages.findIndex(([j]) => j === Math.max(0, i - 1)));
      else if (way === "Home") at = 0;
      else if (way === "End") at = stages.length - 1;
      else return false;
      show();
      return true;
    }
    function show() {
      moving.replaceChildren();
      const [i, k] = stages[at], step = data.steps[i];
      data.planes.forEach((_, n) => line(moving, "trail", data.steps.slice(0, i).flatMap(s => s.ways[n]), 1.8));
      for (const s of data.steps.slice(0, i + 1)) s.state.forEach(p => dot(moving, "state", p, 0.7));
      const taken = [...fixed];
      step.stages.slice(0, k + 1).forEach((stage, n) => {
        const weight = n === k ? 1.6 : 0.9;
        for (const [role, points] of stage.lines) line(moving, role, points, weight, role === "foot" ? `${em / 4}` : "");
        for (const [role, label, x, y] of stage.marks) {
          dot(moving, role, [x, y]);
          beside(moving, role, label, [x, y], taken);
        }
      });
      now.textContent = `Step ${step.step}, t = ${+step.time.toPrecision(6)} s, stage ${k + 1} of ${step.stages.length}` + (step.event ? ` (${step.event})` : "");
      words.textContent = step.stages[k].words;
      for (const [row, number, stage] of rows) {
        const here = number === step.step && stage === k;
        const later = number > step.step || (number === step.step && stage > k);
        row.className = [here ? "here" : later ? "later" : "", row.dataset.state].join(" ").trim();
        if (here) box.scrollTop = row.offsetTop - box.clientHeight / 2;
      }
    }
    document.onkeydown = event => {
      if (/^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
      if (go(event.key)) event.preventDefault();
    };
    show();
    return { go };
  }

  function exercise() {
    const points = [data.start.map(p => p)];
    let half = [];
    const words = html("div", side, undefined, "words");
    const buttons = html("div", side, undefined, "buttons");
    const undo = html("button", buttons, "Undo"), save = html("button", buttons, "Save readings");
    const box = html("div", side, undefined, "table"), table = html("table", box);
    const head = html("tr", html("thead", table));
    for (const name of data.heads) html("th", head, name);
    const body = html("tbody", table);
    const values = p => p.flatMap(([x, y], n) => {
      const plane = data.planes[n];
      return [plane.sense * (x - plane.origin[0]) / plane.scale, (y - plane.origin[1]) / plane.rise];
    });
    const rows = () => points.map((p, i) => [i, ...values(p).map(v => v.toPrecision(5))]);
    const csv = () => [data.columns.join(","), ...rows().map(r => r.join(",") + ",".repeat(data.planes.length))].join("\n") + "\n";
    function show() {
      moving.replaceChildren();
      const taken = [...fixed];
      points.forEach((p, i) => p.forEach(z => { dot(moving, "state", z); beside(moving, "state", String(i), z, taken, 0.8); }));
      half.forEach(z => dot(moving, "successor", z));
      const left = data.count + 1 - points.length;
      const plane = data.planes.length > 1 ? ` in plane ${data.planes[half.length].number}` : "";
      words.textContent = left > 0 ? `Click point ${points.length}${plane} (${left} to go): ${minus(data.given[points.length - 1])}. Backspace removes the last one.` : "All points are complete: save the readings.";
      body.replaceChildren();
      for (const row of rows()) { const tr = html("tr", body); row.forEach(cell => html("td", tr, minus(String(cell)))); }
    }
    svg.addEventListener("click", event => {
      if (points.length > data.count) return;
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      half.push([at.x, -at.y]);
      if (half.length === data.planes.length) { points.push(half); half = []; }
      show();
    });
    const back = () => { if (half.length) half.pop(); else if (points.length > 1) points.pop(); show(); };
    undo.type = save.type = "button";
    undo.onclick = back;
    document.onkeydown = event => { if (event.key === "Backspace") { back(); event.preventDefault(); } };
    save.onclick = () => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([csv()], { type: "text/csv" }));
      link.download = "readings.csv";
      link.click();
    };
    show();
    return { csv };
  }
}

"use strict";
(async () => {
  async function unpacked(id) {
    const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  }
  const [library, text] = await Promise.all([unpacked("plotly"), unpacked("data")]);
  const element = document.createElement("script");
  element.textContent = library;
  document.head.append(element);
  const data = JSON.parse(text);
  const state = { group: "", attack: "" };
  const picked = {};
  const hidden = {}; // figure -> names that a click in its legend has hidden
  const root = document.documentElement;
  const byId = (id) => document.getElementById(id);
  const all = (selector) => [...document.querySelectorAll(selector)];

  // Plotly takes a few tags in texts; names come from files that anybody may have made.
  const safe = (text) => String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
  const css = (name) => getComputedStyle(root).getPropertyValue(name).trim();
  const style = (number) => styleOf(number, css("--ink"));
  const colour = (number) => style(number).colour;
  const faded = (hex, alpha) => {
    const value = parseInt(hex.slice(1), 16);
    return `rgba(${value >> 16}, ${(value >> 8) & 255}, ${value & 255}, ${alpha})`;
  };

  function choices(figure) {
    const found = {};
    for (const series of figure.series) {
      if (series.where.group !== undefined && series.where.group !== state.group) continue;
      for (const [name, value] of Object.entries(series.where)) {
        if (name === "group" || name === "attack") continue;
        (found[name] ||= new Set()).add(value);
      }
    }
    return Object.fromEntries(Object.entries(found).map(([name, values]) => [name, [...values]]));
  }

  const shows = (series, current) => Object.entries(series.where).every(([name, value]) => current[name] === value);

  function errors(values, low, high) {
    if (!low || !low.some((bound) => bound !== null)) return undefined;
    const away = (bounds, sign) => values.map((value, i) => (bounds[i] === null ? 0 : Math.max(0, sign * (bounds[i] - value))));
    return { type: "data", symmetric: false, array: away(high, 1), arrayminus: away(low, -1), thickness: 1.2, width: 3 };
  }

  function traces(series, group, marked) {
    const { colour: paint, dash, mark } = style(series.colour);
    const name = safe(series.name);
    const plain = (values) => values.map((value) => (typeof value === "string" ? safe(value) : value));
    const common = { x: plain(series.x), y: plain(series.y), name, legendgroup: name + group };
    const text = series.text && series.text.map(safe);
    const line = { color: paint, width: 2, dash };
    const lines = marked && series.colour >= 0 ? { mode: "lines+markers", marker: { color: paint, symbol: mark, size: 7, maxdisplayed: 8 } } : { mode: "lines" };
    switch (series.kind) {
      case "band":
        return [
          { ...common, y: series.low, mode: "lines", line: { width: 0 }, hoverinfo: "skip", showlegend: false },
          { ...common, y: series.high, mode: "lines", line: { width: 0 }, fill: "tonexty", fillcolor: faded(paint, 0.18), hoverinfo: "skip" },
        ];
      case "step":
        return [{ ...common, ...lines, line: { ...line, shape: "hv" } }];
      case "points":
      case "trail":
        return [{ ...common, mode: series.kind === "trail" ? "lines+markers" : "markers", line, text, hovertemplate: text ? "%{text}" : typeof series.y[0] === "string" ? "%{x:.4g}" : "%{x:.4g}, %{y:.4g}",
          marker: { color: paint, size: markerSize(series), symbol: series.mark || mark, line: { color: paint, width: 1.5 } },
          error_x: errors(series.x, series.xLow, series.xHigh), error_y: errors(series.y, series.low, series.high) }];
      case "bars":
        return [{ ...common, type: "bar", marker: { color: paint }, text, textposition: "none",
          hovertemplate: "%{text} (%{y:.1%})", error_y: { ...errors(series.y, series.low, series.high), color: css("--soft") } }];
      case "road":
        return [{ ...common, mode: "lines", line: { color: css("--soft"), width: 1 }, opacity: 0.55, hoverinfo: "skip", connectgaps: false }];
      case "heat":
        return [{ ...common, mode: "lines", line: { color: `rgba(213, 94, 0, ${0.4 + 0.2 * series.colour})`, width: 3 + series.colour }, hoverinfo: "name", connectgaps: false }];
      case "area":
        return [{ ...common, mode: "lines", line: { color: paint, width: 1.5 }, fill: "toself", fillcolor: faded(paint, 0.15), hoverinfo: "name" }];
      case "span":
        return [];
      default:
        return [{ ...common, ...lines, line, connectgaps: false }];
    }
  }

  function markerSize(series) {
    if (series.mark === "x-thin-open" || series.x.length > 100) return 5;
    return series.x.length > 30 ? 7 : 9;
  }

  function span(series) {
    return { type: "rect", xref: "x", yref: "paper", x0: series.x[0], x1: series.x[1], y0: 0, y1: 1, line: { width: 0 },
      fillcolor: faded(colour(series.colour), 0.12), layer: "below", label: { text: safe(series.name), textposition: "top left", font: { size: 10 } } };
  }

  const isLabelled = (figure, width) => figure.labelled && width >= 480;
  const isLine = (series) => series.kind === "line" || series.kind === "step";

  // What the legend shows of series: each name once; bands go with their line, and what a detector did as run with it.
  function entries(shown, marked) {
    const found = new Map();
    if (shown.every((series) => series.kind === "points" && typeof series.y[0] === "string")) return []; // the axis names them
    for (const series of shown) {
      if (["band", "span", "road"].includes(series.kind) || found.has(series.name) || series.of) continue;
      const { colour, dash, mark } = style(series.colour);
      const [line, point] = [isLine(series) || ["trail", "area", "heat"].includes(series.kind), ["points", "trail"].includes(series.kind)];
      const named = point || (marked && series.colour >= 0 && line) ? series.mark || mark : "";
      found.set(series.name, { name: series.name, colour: series.kind === "heat" ? `rgba(213, 94, 0, ${0.4 + 0.2 * series.colour})` : colour, dash: line ? dash : "", mark: named });
    }
    return [...found.values()];
  }

  function layout(figure, width, spans) {
    const axis = { gridcolor: css("--line"), linecolor: css("--line"), zerolinecolor: css("--line"), automargin: true };
    const given = figure.layout;
    const title = (text) => ({ text: safe(text), standoff: 8, font: { size: 12 } });
    return {
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", barmode: "group", shapes: spans,
      font: { color: css("--ink"), family: getComputedStyle(document.body).fontFamily, size: width < 480 ? 10 : 12 },
      margin: { l: 50, r: isLabelled(figure, width) ? 150 : 12, t: 10, b: 44 }, hovermode: figure.key === "map" || figure.key === "trace_path" ? "closest" : undefined,
      hoverlabel: { namelength: -1 }, showlegend: false,
      xaxis: { ...axis, title: title(figure.xTitle), ...given.xaxis }, yaxis: { ...axis, title: title(figure.yTitle), ...given.yaxis },
      dragmode: figure.tall ? "pan" : "zoom",
    };
  }

  function current(figure) {
    const offered = choices(figure);
    const chosen = { ...state };
    for (const [name, values] of Object.entries(offered)) {
      chosen[name] = values.includes(picked[name]) ? picked[name] : values[0];
    }
    return [chosen, offered];
  }

  function pickers(figure, place, chosen, offered) {
    place.replaceChildren();
    for (const [name, values] of Object.entries(offered)) {
      const label = document.createElement("label");
      const select = document.createElement("select");
      label.append(name[0].toUpperCase() + name.slice(1), select);
      select.dataset.pick = name;
      for (const value of values) select.add(new Option(value, value, false, value === chosen[name]));
      select.addEventListener("change", () => { picked[name] = select.value; draw(); });
      place.append(label);
    }
  }

  function drawFigure(element) {
    const figure = data.figures[element.id];
    const [chosen, offered] = current(figure);
    pickers(figure, element.querySelector(".picks"), chosen, offered);
    const shown = figure.series.filter((series) => shows(series, chosen));
    const canvas = element.querySelector(".canvas");
    const why = element.querySelector(".why");
    const place = element.querySelector(".legend");
    const empty = shown.every((series) => series.kind === "road" || series.kind === "span");
    const nothing = shown.length === 0 || (empty && figure.key !== "map");
    canvas.hidden = nothing;
    why.hidden = !nothing;
    const ofEachSeed = (data.pooled || []).includes(state.group) && figure.series.length > 0;
    why.textContent = !nothing ? "" : ofEachSeed ? "Of each seed by itself: choose one as the scenario." : figure.whyEmpty;
    element.querySelector(".csv").hidden = figure.series.length === 0;
    if (nothing) { Plotly.purge(canvas); place.replaceChildren(); return Promise.resolve(); }
    const marked = shown.filter((series) => isLine(series) && series.colour >= 0).length > 3;
    const off = (hidden[figure.key] ||= new Set());
    const drawn = shown.flatMap((series, i) => traces(series, i, marked).map((trace) => ({ ...trace, visible: !off.has(series.of || series.name) })));
    const named = entries(shown, marked);
    legend(place, named, off, () => drawFigure(element));
    const spans = shown.filter((series) => series.kind === "span").map(span);
    const settings = { responsive: true, displaylogo: false, scrollZoom: figure.tall, modeBarButtonsToRemove: ["lasso2d", "select2d"] };
    const width = canvas.clientWidth;
    const ready = Plotly.react(canvas, drawn, layout(figure, width, spans), settings);
    return isLabelled(figure, width) ? ready.then(() => labelEnds(canvas, named, safe)) : ready;
  }

  const visible = (element) => element.closest("[hidden]") === null;

  function draw() {
    for (const section of all("[data-group]")) section.hidden = section.dataset.group !== state.group;
    for (const row of all("tr[data-choose]")) row.classList.toggle("chosen", row.dataset.choose === state.group);
    for (const table of all("table")) {
      const box = table.closest(".listing")?.querySelector(".every");
      for (const row of table.querySelectorAll("tr[data-attack]")) {
        row.classList.toggle("chosen", row.dataset.attack === state.attack);
        row.classList.toggle("other", Boolean(box) && !box.checked && row.dataset.attack !== state.attack);
      }
    }
    return Promise.all(all("figure.plot").filter(visible).map(drawFigure));
  }

  function open(tab) {
    for (const other of all("[role=tab]")) {
      other.setAttribute("aria-selected", String(other === tab));
      other.tabIndex = other === tab ? 0 : -1;
      byId(other.getAttribute("aria-controls")).hidden = other !== tab;
    }
    draw();
  }

  function quoted(value) {
    if (value === null || value === undefined) return "";
    const text = String(value);
    return /[",\r\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text;
  }

  function table(figure) {
    const names = [...new Set(figure.series.flatMap((series) => Object.keys(series.where)))];
    const columns = [["x", figure.xTitle || "x"], ["y", figure.yTitle || "y"], ["low", "low"], ["high", "high"], ["xLow", "x low"], ["xHigh", "x high"], ["text", "text"]]
      .filter(([key]) => figure.series.some((series) => series[key]));
    const lines = [[...names, "series", ...columns.map(([, title]) => title)]];
    for (const series of figure.series) {
      const first = [...names.map((name) => series.where[name]), series.name];
      series.x.forEach((_, i) => lines.push([...first, ...columns.map(([key]) => series[key] && series[key][i])]));
    }
    return lines.map((line) => line.map(quoted).join(",")).join("\r\n") + "\r\n";
  }

  function download(key) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([table(data.figures[key])], { type: "text/csv" }));
    link.download = `${key}.csv`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }

  for (const name of ["group", "attack"]) {
    const select = byId(name);
    if (!select) continue;
    state[name] = select.value;
    select.closest("label").hidden = select.options.length < 2;
    select.addEventListener("change", () => { state[name] = select.value; draw(); });
  }
  for (const row of all("tr[data-choose]")) {
    row.addEventListener("click", () => { state.group = row.dataset.choose; byId("group").value = state.group; draw(); });
  }
  for (const button of all(".goto")) {
    button.addEventListener("click", () => {
      const [x, y, reach] = ["x", "y", "reach"].map((name) => Number(button.dataset[name])), around = Math.max(60, 1.5 * reach);
      const canvas = byId("map").querySelector(".canvas");
      if (canvas.hidden) return;
      Plotly.relayout(canvas, { "xaxis.range": [x - around, x + around], "yaxis.range": [y - around, y + around] });
      canvas.scrollIntoView({ block: "center" });
    });
  }
  if (!state.group) state.group = data.groups[0] || "";
  const tabs = all("[role=tab]");
  tabs.forEach((tab, i) => {
    tab.addEventListener("click", () => open(tab));
    tab.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      const next = tabs[(i + step + tabs.length) % tabs.length];
      next.focus();
      open(next);
    });
  });
  for (const button of all(".csv")) button.addEventListener("click", () => download(button.dataset.figure));
  const dark = matchMedia("(prefers-color-scheme: dark)");
  byId("theme").addEventListener("click", () => {
    const isDark = root.dataset.theme ? root.dataset.theme === "dark" : dark.matches;
    root.dataset.theme = isDark ? "light" : "dark";
    draw();
  });
  dark.addEventListener("change", draw);
  // Paper is white, and has no tabs. What was drawn for another width is drawn anew.
  let former;
  const wipe = () => all(".canvas").forEach((canvas) => Plotly.purge(canvas));
  addEventListener("beforeprint", () => {
    former = root.dataset.theme;
    root.dataset.theme = "light";
    root.dataset.printing = "yes";
    document.body.style.width = "64rem"; // figures are drawn for it: a landscape page of A4 or Letter is hardly wider
    all(".panel").forEach((panel) => { panel.dataset.was = panel.hidden ? "1" : ""; panel.hidden = false; });
    wipe();
    draw();
    all("[data-group]").forEach((section) => { section.hidden = false; }); // tables of all scenarios; figures say theirs
  });
  addEventListener("afterprint", () => {
    delete root.dataset.printing;
    if (former) root.dataset.theme = former; else delete root.dataset.theme;
    document.body.style.width = "";
    all(".panel").forEach((panel) => { panel.hidden = panel.dataset.was === "1"; });
    wipe();
    draw();
  });
  for (const box of all(".every")) box.addEventListener("change", draw);
  if (tabs.length) open(tabs[0]); else await draw();
  root.dataset.ready = "yes";
})();

"use strict";
// What tells the lines of a figure apart: a style for each number, a legend below the figure that takes no room from it,
// and names at the ends of lines.
const { styleOf, legend, labelEnds } = (() => {
  // Okabe and Ito's colours, which colour-blind people can tell apart; of lines with the same colour, dash and mark differ.
  const COLOURS = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#56b4e9"];
  const DASHES = ["solid", "dash", "dot", "dashdot"];
  const STROKES = { solid: "", dash: "7 4", dot: "2 3", dashdot: "8 3 2 3" };
  const MARKS = ["circle", "square", "diamond", "triangle-up", "triangle-down", "star", "cross", "hexagram"];
  const GLYPHS = { circle: "●", square: "■", diamond: "◆", "triangle-up": "▲", "triangle-down": "▼", star: "★", cross: "✚", hexagram: "✶",
    "circle-open": "○", x: "✖", "x-thin-open": "×" };
  const SVG = "http://www.w3.org/2000/svg";
  const LINE_PX = 13;

  function styleOf(number, ink) {
    if (number < 0) return { colour: ink, dash: "solid", mark: "circle" };
    const again = Math.floor(number / COLOURS.length);
    return { colour: COLOURS[number % COLOURS.length], dash: DASHES[again % DASHES.length], mark: MARKS[(number + again) % MARKS.length] };
  }

  function drawnAs(tag, attributes, text) {
    const made = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (text) made.textContent = text;
    return made;
  }

  // `entries` have a name, a colour, and a dash, a mark or neither (a bar); `hidden` holds the names of those not shown.
  function legend(place, entries, hidden, changed) {
    place.replaceChildren();
    if (entries.length < 2) return;
    for (const entry of entries) {
      const button = document.createElement("button");
      button.type = "button";
      button.setAttribute("aria-pressed", String(!hidden.has(entry.name)));
      const sample = drawnAs("svg", { width: 34, height: 12, "aria-hidden": "true" });
      if (entry.dash) {
        const stroke = { x1: 0, y1: 6, x2: 34, y2: 6, stroke: entry.colour, "stroke-width": 2, "stroke-dasharray": STROKES[entry.dash] };
        sample.append(drawnAs("line", stroke));
      } else if (!entry.mark) sample.append(drawnAs("rect", { x: 8, y: 1, width: 18, height: 10, fill: entry.colour }));
      if (entry.mark) {
        const at = { x: 17, y: 10, "text-anchor": "middle", "font-size": 11, fill: entry.colour };
        sample.append(drawnAs("text", at, GLYPHS[entry.mark] || "●"));
      }
      button.append(sample, entry.name);
      button.addEventListener("click", () => {
        if (!hidden.delete(entry.name)) hidden.add(entry.name);
        changed();
      });
      place.append(button);
    }
  }

  // Where each label goes, in pixels from above: beside its line, or as near as the others let it.
  function spread(ends, height) {
    const ordered = [...ends].sort((a, b) => a.at - b.at);
    let lowest = 0;
    for (const end of ordered) { end.place = Math.max(end.at, lowest); lowest = end.place + LINE_PX; }
    let highest = height;
    for (const end of ordered.reverse()) { end.place = Math.min(end.place, highest); highest = end.place - LINE_PX; }
    return ordered;
  }

  function labelEnds(canvas, entries, safe) {
    const axis = canvas._fullLayout.yaxis, ends = [];
    for (const trace of canvas.data) {
      const entry = entries.find((one) => one.dash && safe(one.name) === trace.name);
      if (!entry || trace.visible === false || !trace.mode?.startsWith("lines")) continue;
      const last = trace.y.findLast((value) => value !== null && value !== undefined);
      if (last !== undefined) ends.push({ entry, name: trace.name, at: Math.min(Math.max(axis.d2p(last), 0), axis._length) });
    }
    const annotations = spread(ends, axis._length).map(({ entry, name, place }) => ({
      text: `<span style="color:${entry.colour}">${GLYPHS[entry.mark] || "–"}</span> ${name}`, showarrow: false, align: "left",
      xref: "paper", x: 1, xanchor: "left", yref: "paper", y: 1 - place / axis._length, yanchor: "middle", font: { size: 10 } }));
    return Plotly.relayout(canvas, { annotations });
  }

  return { styleOf, legend, labelEnds };
})();

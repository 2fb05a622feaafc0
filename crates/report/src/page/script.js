/** Makes the plots of a page usable: zoom, values under the pointer, explanations left out, files. Without it
 * the page is complete. A figure's numbers are in its last child; `drawing.js` comes before it. */
const HINT = "Drag over a plot to zoom in, double-click to see all. After a click, or with Ctrl, the wheel "
  + "zooms; Shift and drag moves. Two fingers zoom, one moves. Keys: + and − zoom, arrows move, Shift and "
  + "arrows read values, 0 or Escape shows all.";
const STYLED = ["fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-linejoin", "opacity",
  "fill-opacity", "stroke-opacity", "paint-order", "font-size", "font-family", "text-anchor"];

// Plots.

const plots = /** @type {Plot[]} */ ([]);

/** Plots that wait for the next frame. @type {Set<Plot>} */
const waiting = new Set();

function frame() {
  const now = [...waiting].filter(plot => plot.visible);
  waiting.clear();
  now.forEach(plot => plot.update());
}

/** Plots that move together. Spans are seconds, Unix time where it is known, or steps of the axis of a plot
 * without time. */
class Group {
  plots = /** @type {Plot[]} */ ([]);
  across = /** @type {Span | null} */ (null);
  up = /** @type {Span | null} */ (null);
  marked = /** @type {Span | null} */ (null);
  cursor = /** @type {{plot: Plot, at: number, height: number} | null} */ (null);

  /** @param {Span | null} across @param {Span | null} [up] */
  show(across, up = null) {
    const read = this.plots.filter(plot => plot.series.length);
    const rows = Math.max(1e4, ...read.flatMap(plot => plot.series.map(series => series.x.length)));
    this.across = across && within(across, union(read.map(plot => plot.seconds(plot.whole.x))), rows);
    this.up = up && within(up, read[0].whole.y, rows);
    for (const plot of this.plots) {
      plot.figure.classList.toggle("zoomed", Boolean(this.across || this.up));
      plot.ask(true);
    }
  }
}

/** A part of the whole that is not too small; null for all.
 * @param {Span} span @param {Span} whole @param {number} most @returns {Span | null} */
function within([from, to], [low, high], most) {
  const half = Math.max(to - from, (high - low) / most) / 2;
  const middle = between((from + to) / 2, [low + half, high - half]);
  return half < 0.4999 * (high - low) ? [middle - half, middle + half] : null;
}

class Plot {
  series = /** @type {Series[]} */ ([]);
  without = /** @type {Set<string>} */ (new Set());
  fingers = /** @type {Map<number, Span>} */ (new Map());
  chosen = /** @type {Span[] | null} */ (null);
  shown = /** @type {{x: Scale, y: Scale, marks: Tick[]}} */ (/** @type {unknown} */ (null));
  held = /** @type {{x: Scale, y: Scale, fingers: Span[]}} */ (/** @type {unknown} */ (null));
  whole = { x: /** @type {Span} */ ([0, 1]), y: /** @type {Span} */ ([0, 1]) };
  follow = () => {};
  broken = false;
  visible = false;
  stale = false;
  flat = false;
  left = 0;

  /** @param {Element} figure @param {Spec} spec @param {Group} group @param {() => Series[]} source */
  constructor(figure, spec, group, source) {
    const svg = figure.querySelector(":scope > svg");
    const caption = figure.querySelector("figcaption");
    const data = figure.querySelector(".data");
    if (!(svg instanceof SVGSVGElement && caption && data && spec.series)) throw new TypeError(figure.id);
    this.figure = figure;
    this.svg = svg;
    this.spec = spec;
    this.group = group;
    this.source = source;
    this.unit = spec.time?.unit_s ?? 1;
    this.epoch = spec.time?.epoch_s ?? 0;
    this.title = caption.textContent ?? "";
    this.over = document.createElementNS(SVG, "g");
    this.over.setAttribute("class", "over");
    this.readout = /** @type {HTMLElement} */ (add(figure, "div", { class: "readout", role: "status" }));
    group.plots.push(this);
    plots.push(this);
    svg.querySelector("title")?.remove();
    svg.removeAttribute("aria-labelledby");
    svg.setAttribute("tabindex", "0");
    svg.setAttribute("role", "group");
    svg.setAttribute("aria-label", `${this.title}. ${HINT}`);
    const heard = {
      pointerdown: this.press, pointermove: this.drag, pointerup: this.release, pointercancel: this.release,
      pointerleave: this.leave, wheel: this.wheel, keydown: this.key, dblclick: this.reset, focus: this.ready,
      blur: this.leave,
    };
    for (const [name, heed] of Object.entries(heard)) {
      svg.addEventListener(name, /** @type {(event: any) => void} */ (heed).bind(this));
    }
    /** @param {Element} parent @param {string} name @param {string} title @param {() => void} act */
    const button = (parent, name, title, act) => add(parent, "button", { type: "button", title }, name)
      .addEventListener("click", () => this.ready() && act());
    button(data, "SVG", "Save the drawing as SVG", () => saveDrawing(this, false));
    button(data, "PNG", "Save the drawing as PNG", () => saveDrawing(this, true));
    button(data, "CSV", "Save the values that are shown as CSV", () => saveValues(this));
    button(caption, "Show all", "Show the whole plot again", () => {
      this.reset();
      svg.focus({ preventScroll: true });
    });
    new IntersectionObserver(seen => {
      this.visible = seen[seen.length - 1].isIntersecting;
      if (this.visible) setTimeout(() => this.load());
      if (this.stale) this.ask(true);
    }).observe(figure);
  }

  /** A span of the axis as one of the group. @param {Span} across @returns {Span} */
  seconds([from, to]) {
    return [this.epoch + from * this.unit, this.epoch + to * this.unit];
  }

  /** The place of a moment of the group. @param {number} seconds */
  at(seconds) {
    return this.shown.x.at((seconds - this.epoch) / this.unit);
  }

  /** Reads the numbers on first need; where they cannot be read, the static drawing stays. */
  load() {
    if (this.series.length || this.broken) return !this.broken;
    try {
      this.series = this.source();
      this.explain();
    } catch {
      this.series = [];
      this.broken = true;
      this.svg.removeAttribute("tabindex");
      this.figure.querySelectorAll("button").forEach(button => button.remove());
    }
    return !this.broken;
  }

  /** Takes up which explanations are left out. */
  explain() {
    const { toggles = [], y, time, map } = this.spec;
    const left = toggles.filter(toggle => this.without.has(toggle.name));
    this.series.forEach((series, n) =>
      series.addBack(left.filter(toggle => toggle.series === n).map(toggle => decoded(toggle.y))));
    const values = union(this.series.map(series => series.seen([-Infinity, Infinity])));
    this.whole = { x: aired(union(this.series.map(series => series.span)), false), y: aired(values, y.log) };
    this.flat = !time && this.series.some(series => map || !series.sorted || series.kind.mark === "points");
    // Refuses what has no date.
    if (time) this.seconds(this.whole.x).forEach(moment => utc(moment, 1));
    this.follow();
  }

  /** Whether the script has drawn the plot, as it does at the first thing that a reader does with it. */
  ready() {
    if (!this.shown && this.load()) {
      this.stale = true;
      this.update();
    }
    return Boolean(this.shown);
  }

  /** @param {boolean} stale */
  ask(stale) {
    this.stale ||= stale;
    if (!waiting.size) requestAnimationFrame(frame);
    waiting.add(this);
  }

  update() {
    if (!this.load()) return;
    this.measure();
    if (this.stale) this.draw();
    this.stale = false;
    this.drawOver();
  }

  zoomed() {
    return Boolean(this.group.across || this.group.up);
  }

  /** The scales of what is shown. */
  measure() {
    const { spec: { x, y, map, time }, group, whole, epoch, unit } = this;
    const own = (/** @type {Span} */ [from, to]) => times([from - epoch, to - epoch], 1 / unit);
    let across = group.across ? own(group.across) : whole.x;
    const seen = union(this.series.map(one => one.seen(across)));
    let up = group.up ?? (group.across && seen[0] <= seen[1] ? aired(seen, y.log) : whole.y);
    if (map) {
      const half = Math.max(across[1] - across[0], up[1] - up[0]) / 2;
      [across, up] = [across, up].map(([from, to]) => [(from + to) / 2 - half, (from + to) / 2 + half]);
    }
    const marks = scaleOver(up, y.log, [0, 1]).ticks(6);
    const room = 12 + CHARACTER * Math.max(...marks.map(tick => tick.label.length));
    this.left = this.zoomed() ? Math.max(this.left, room) : room;
    const foot = map ? ABOVE + WIDTH - RIGHT - this.left : HEIGHT - BELOW;
    const scale = scaleOver(across, x.log, [this.left, WIDTH - RIGHT], time);
    this.shown = { x: scale, y: scaleOver(up, y.log, [foot, ABOVE]), marks };
  }

  draw() {
    const { svg, figure: { id }, spec, series, shown: { x, y, marks } } = this;
    const [left, right, foot] = [short(x.start), x.end, short(y.start)];
    /** @param {string} name @param {number} at @param {number} height @param {string} words */
    const text = (name, at, height, words) =>
      words && add(svg, "text", { class: name, x: at, y: height }, words);
    svg.replaceChildren();
    svg.setAttribute("viewBox", `0 0 ${WIDTH} ${foot + BELOW}`);
    add(add(svg, "clipPath", { id: `${id}_clip` }), "rect",
      { x: left, y: ABOVE, width: right - left, height: foot - ABOVE });
    for (const { at, label } of spaced(x)) {
      const place = short(x.place(at));
      const half = (CHARACTER * label.length) / 2;
      path(svg, label ? "grid" : "minor", `M${place} ${ABOVE}V${foot}`);
      text("x", place, foot + 20, place + half < WIDTH && place > half ? label : "");
    }
    for (const { at, label } of marks) {
      const place = short(y.place(at));
      path(svg, label ? "grid" : "minor", `M${left} ${place}H${right}`);
      text("y", left - 6, place + 4, label);
    }
    path(svg, "frame", `M${left} ${ABOVE}V${foot}H${right}`);
    const epoch = spec.time?.epoch_s;
    const date = epoch == null ? "" : utc(this.seconds([x.low, x.high])[0], 1).slice(0, 10);
    const below = date ? { ...spec.x, unit: `UTC, ${date}` } : spec.x;
    const cut = (/** @type {string} */ words) => (words.length > 44 ? `${words.slice(0, 44)}…` : words);
    text("label", 2, 13, cut(named(spec.y)));
    text("label x", (left + right) / 2, foot + 38, cut(named(below)));
    const data = add(svg, "g", { "clip-path": `url(#${id}_clip)` });
    series.forEach(one => drawSeries(data, one, x, y, series.length > 1));
    this.drawPlaces();
    svg.append(this.over);
  }

  /** Named intervals, with links to the words about them; a name that has no room is in the tooltip alone. */
  drawPlaces() {
    const { svg, spec: { marks = [] }, shown: { x, y } } = this;
    const rows = [-Infinity, -Infinity];
    for (const { name, from, to, id } of marks) {
      if (x.place(to) < x.start || x.place(from) > x.end) continue;
      const [start, end] = [from, to].map(value => short(between(x.place(value), [x.start, x.end])));
      path(svg, "place", `M${start} ${ABOVE}H${Math.max(end, start + 1)}V${y.start}H${start}z`);
      add(/** @type {Element} */ (svg.lastElementChild), "title", {}, name);
      const width = CHARACTER * name.length + 8;
      const at = Math.min(start, x.end - width);
      const row = rows.findIndex(taken => taken < at && at >= x.start);
      if (row < 0) continue;
      rows[row] = at + width;
      const link = add(svg, "a", { href: `#${id}` });
      add(link, "title", {}, name);
      add(link, "rect", { x: at, y: ABOVE + 28 * row, width, height: 28 });
      add(link, "text", { x: at + 4, y: ABOVE + 28 * row + 17 }, name);
    }
  }

  /** What is marked, chosen and read. */
  drawOver() {
    const { over, group: { marked, cursor }, shown: { x, y }, chosen, flat } = this;
    /** @param {string} name @param {number[]} across @param {number[]} up */
    const box = (name, [left, right], [up, down]) =>
      path(over, name, `M${left} ${up}H${Math.max(right, left + 1)}V${down}H${left}z`);
    const inside = (/** @type {number} */ place) => between(place, [x.start, x.end]);
    over.replaceChildren();
    this.readout.replaceChildren();
    if (marked) box("marked", marked.map(moment => inside(this.at(moment))), [ABOVE, y.start]);
    const [one, other] = chosen ?? [];
    if (chosen) {
      const sides = [one[0], other[0]].map(inside).sort((a, b) => a - b);
      box("chosen", sides, flat ? [one[1], other[1]] : [ABOVE, y.start]);
    }
    const place = cursor ? this.at(cursor.at) : NaN;
    if (!cursor || inside(place) !== place) return;
    path(over, "cross", `M${place} ${ABOVE}V${y.start}`);
    if (cursor.plot !== this || chosen) return;
    if (flat) path(over, "cross", `M${x.start} ${cursor.height}H${x.end}`);
    this.read(place, cursor.height);
  }

  /** The values at a place. @param {number} at @param {number} height */
  read(at, height) {
    const { shown: { x, y }, spec, unit, readout, flat, figure, svg } = this;
    const near = this.series.map(series => series.nearest(x, y, at, flat ? height : null))
      .filter(one => one.away < 24).sort((one, other) => (flat ? one.away - other.away : 0));
    const found = flat ? near.slice(0, 1) : near;
    const here = x.log ? 10 ** x.steps(at) : x.steps(at);
    const value = flat && found.length ? found[0].series.x[found[0].row] : here;
    const epoch = spec.time?.epoch_s;
    add(readout, "p", {}, `${spec.x.label} ${readable(value, x)} ${spec.x.unit}`);
    if (epoch != null) add(readout, "p", {}, utc(epoch + value * unit, ((x.high - x.low) * unit) / WIDTH));
    for (const { series, row } of found) {
      const { y: values, low, high } = series.values;
      const ends = low && high ? ` (${readable(low[row], y)} to ${readable(high[row], y)})` : "";
      const item = add(readout, "p");
      const swatch = figure.querySelectorAll(".legend .swatch")[this.series.indexOf(series)];
      item.append(swatch?.cloneNode(true) ?? "");
      item.append(`${series.kind.name} ${readable(values[row], y)} ${spec.y.unit}${ends}`);
    }
    const [box, around] = [svg.getBoundingClientRect(), figure.getBoundingClientRect()];
    readout.style.top = `${box.top - around.top + (ABOVE * box.width) / WIDTH}px`;
    readout.classList.toggle("left", at > WIDTH / 2);
  }

  /** @param {MouseEvent} event @returns {Span} */
  place(event) {
    const box = this.svg.getBoundingClientRect();
    return times([event.clientX - box.left, event.clientY - box.top], WIDTH / box.width);
  }

  /** @param {Span} across @param {Span} up */
  show(across, up) {
    this.group.show(this.seconds(across), this.flat ? up : null);
  }

  reset() {
    Object.assign(this.group, { marked: null, cursor: null });
    this.chosen = null;
    this.fingers.clear();
    this.group.show(null);
  }

  /** Puts the cursor at a place. @param {Span | null} place */
  point(place) {
    const { x } = this.shown;
    const [at] = place ? this.seconds(times([1, 1], x.steps(between(place[0], [x.start, x.end])))) : [NaN];
    this.group.cursor = place && { plot: this, at, height: place[1] };
    this.group.plots.filter(plot => plot.shown).forEach(plot => plot.ask(false));
  }

  /** A finger's values stay when it is lifted. @param {PointerEvent} event */
  leave(event) {
    if (event.pointerType !== "touch" && this.shown) this.point(null);
  }

  /** @param {PointerEvent} event */
  press(event) {
    if (event.button || /** @type {Element} */ (event.target).closest("a") || !this.ready()) return;
    const place = this.place(event);
    this.svg.focus({ preventScroll: true });
    this.svg.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, place);
    this.chosen = event.pointerType === "touch" || event.shiftKey ? null : [place, place];
    this.held = { ...this.shown, fingers: [...this.fingers.values()] };
    this.point(place);
  }

  /** @param {PointerEvent} event */
  drag(event) {
    if (!this.ready()) return;
    const place = this.place(event);
    if (this.fingers.has(event.pointerId)) this.fingers.set(event.pointerId, place);
    if (this.chosen) this.chosen = [this.chosen[0], place];
    const now = [...this.fingers.values()];
    if (this.chosen || !now.length || (now.length === 1 && !this.zoomed())) return this.point(place);
    const { x, y, fingers } = this.held;
    const mean = (/** @type {Span[]} */ all, /** @type {number} */ axis) =>
      all.reduce((sum, one) => sum + one[axis], 0) / all.length;
    const apart = (/** @type {Span[]} */ [one, other]) =>
      other ? Math.hypot(one[0] - other[0], one[1] - other[1]) : 1;
    const [across, up] = [x, y].map((scale, axis) =>
      moved(scale, mean(fingers, axis), mean(now, axis), apart(fingers) / apart(now)));
    this.show(across, up);
  }

  /** @param {PointerEvent} event */
  release(event) {
    const { chosen, shown } = this;
    this.fingers.delete(event.pointerId);
    this.chosen = null;
    if (!shown) return;
    this.held = { ...shown, fingers: [...this.fingers.values()] };
    if (event.type === "pointercancel") return this.point(null);
    if (!chosen) return;
    const { x, y } = shown;
    const [across, up] = [x, y].map(({ steps, low, high }, axis) =>
      chosen.map(one => between(steps(one[axis]), [low, high])).sort((one, other) => one - other));
    const [wide, tall] = [0, 1].map(axis => Math.abs(chosen[0][axis] - chosen[1][axis]) > 4);
    if (wide) this.show([across[0], across[1]], tall ? [up[0], up[1]] : [y.low, y.high]);
    else this.point(chosen[1]);
  }

  /** @param {number} factor @param {Span} place */
  zoom(factor, [at, height]) {
    this.show(moved(this.shown.x, at, at, factor), moved(this.shown.y, height, height, factor));
  }

  /** @param {WheelEvent} event */
  wheel(event) {
    const asked = event.ctrlKey || event.metaKey;
    const own = document.activeElement === this.svg && (event.deltaY < 0 || this.zoomed());
    if (!(asked || own) || !this.ready()) return;
    event.preventDefault();
    this.zoom(1.002 ** between(event.deltaY * (event.deltaMode ? 30 : 1), [-300, 300]), this.place(event));
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    if (event.target !== this.svg || event.ctrlKey || event.metaKey || event.altKey || !this.ready()) return;
    const { shown: { x, y }, group: { cursor } } = this;
    const middle = /** @type {Span} */ ([(x.start + x.end) / 2, (y.start + y.end) / 2]);
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    const factor = { "+": 1 / 1.5, "=": 1 / 1.5, "-": 1.5, "−": 1.5, _: 1.5 }[event.key];
    if (step && event.shiftKey) {
      const [at, height] = cursor ? [this.at(cursor.at), cursor.height] : middle;
      this.point([at + 4 * step[0], height + 4 * step[1]]);
    } else if (step && this.zoomed() && (step[0] || this.flat)) {
      this.show(moved(x, 34 * step[0], 0), moved(y, 20 * step[1], 0));
    } else if (factor) this.zoom(factor, middle);
    else if (["0", "Home", "Escape"].includes(event.key)) this.reset();
    else return;
    event.preventDefault();
  }
}

// Explanations that are left out.

/** Boxes for the explanations of a section, above its first plot that has any. @param {Plot[]} plots */
function offer(plots) {
  const { without, figure } = plots[0];
  const field = document.createElement("fieldset");
  field.className = "explanations";
  (figure.closest(".plots") ?? figure).before(field);
  add(field, "legend", {}, "Explanations");
  const all = plots.flatMap(plot => plot.spec.toggles ?? []);
  for (const { name, id } of new Map(all.map(toggle => [toggle.name, toggle])).values()) {
    const label = add(field, "label");
    const box = /** @type {HTMLInputElement} */ (add(label, "input", { type: "checkbox", checked: "" }));
    if (id) add(label, "a", { href: `#${id}` }, name);
    else label.append(name);
    box.addEventListener("change", () => {
      without[box.checked ? "delete" : "add"](name);
      plots.filter(plot => plot.load()).forEach(plot => plot.explain());
    });
  }
  add(field, "p", { class: "note" }, "An explanation that is switched off is added back to the residual; the "
    + "constants of the calibration stay as they were fitted.");
  const told = add(field, "ul", { role: "status" });
  const tell = () => told.replaceChildren(...plots.flatMap(({ spec, series, title }) => {
    const { toggles = [], y: { unit }, held_out: held } = spec;
    const own = series.filter((_, n) => toggles.some(toggle => toggle.series === n));
    const rms = own.map(({ kind, values }) =>
      `${title}, ${kind.name}: rms ${significant(rmsOf(values.y), 3)} ${unit}`);
    const left = toggles.find(toggle => without.has(toggle.name))?.held_out_nt;
    const out = without.size > 1 ? undefined : without.size ? left : held;
    return out === undefined ? rms : [...rms, `${title}: held-out rms ${significant(out, 3)} nT`];
  }).map(words => add(field, "li", {}, words)));
  for (const plot of plots) {
    const spectrum = plot.spec.spectrum ? spectrumBelow(plot) : null;
    plot.without = without;
    plot.follow = () => {
      tell();
      if (plot.shown || without.size) plot.ask(true);
      if (spectrum) spectrum.series = [];
      spectrum?.ask(true);
    };
  }
}

/** A further figure with the spectrum of what has explanations. @param {Plot} plot */
function spectrumBelow(plot) {
  const { spec: { series, toggles, y }, figure, unit, title } = plot;
  const kinds = series.filter((_, n) => toggles?.some(toggle => toggle.series === n));
  const below = document.createElement("figure");
  below.id = `${figure.id}-spectrum`;
  add(below, "figcaption", {}, `Spectrum: ${title}`);
  add(below, "svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}` });
  const legend = figure.querySelector(".legend")?.cloneNode(true);
  if (legend instanceof Element) {
    legend.replaceChildren(...[...legend.children].filter((_, n) => kinds.includes(series[n])));
    below.append(legend);
  }
  add(below, "p", { class: "data" });
  figure.after(below);

  /** @type {Spec} */
  const spec = { series: kinds, x: { label: "frequency", unit: "Hz", log: true },
    y: { label: "power spectral density", unit: `${y.unit}²/Hz`, log: true } };
  const source = () => (plot.load() ? plot.series : []).filter(one => kinds.includes(one.kind)).map(one => {
    const { kind: { name, style }, x, values } = one;
    const steps = x.slice(1).map((value, row) => value - x[row]).filter(Number.isFinite).sort();
    const density = spectrumOf(values.y, unit * steps[steps.length >> 1]);
    return new Series({ name, mark: "line", style }, density, spec);
  });
  return new Plot(below, spec, new Group(), source);
}

// Files.

/** @param {string} name @param {Blob} blob */
function save(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** The drawing with its title and style. @param {Plot} plot @param {boolean} png */
function saveDrawing({ svg, figure: { id }, title }, png) {
  const copy = /** @type {SVGSVGElement} */ (svg.cloneNode(true));
  const copies = [copy, ...copy.querySelectorAll("*")];
  [svg, ...svg.querySelectorAll("*")].forEach((element, n) => {
    const style = getComputedStyle(element);
    for (const key of STYLED) copies[n].setAttribute(key, style.getPropertyValue(key));
  });
  const [width, height] = [WIDTH, svg.viewBox.baseVal.height + 24];
  const { backgroundColor, color, fontFamily } = getComputedStyle(document.body);
  for (const [key, value] of Object.entries({ viewBox: `0 -24 ${width} ${height}`, width, height })) {
    copy.setAttribute(key, String(value));
  }
  copy.querySelector(".over")?.remove();
  copy.prepend(add(copy, "rect", { y: -24, width, height, fill: backgroundColor }));
  add(copy, "text", { x: 2, y: -7, "font-size": 13, "font-family": fontFamily, fill: color }, title);
  const text = new XMLSerializer().serializeToString(copy);
  if (!png) return save(`${id}.svg`, new Blob([text], { type: "image/svg+xml" }));
  const image = new Image(2 * width, 2 * height);
  image.addEventListener("load", () => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [2 * width, 2 * height];
    canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
    canvas.toBlob(blob => blob && save(`${id}.png`, blob));
  });
  image.src = `data:image/svg+xml,${encodeURIComponent(text)}`;
}

/** What is shown, with UTC where it is known. @param {Plot} plot */
function saveValues({ spec, series, shown: { x: { low: from, high: to } }, unit, without, figure: { id } }) {
  const quoted = (/** @type {string} */ text) =>
    /[,"\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  const number = (/** @type {number | undefined} */ value) => (Number.isFinite(value) ? String(value) : "");
  const epoch = spec.time?.epoch_s ?? null;
  const bars = series.some(one => one.ends);
  const axes = [named(spec.x), named(spec.y)].map(quoted);
  const head = ["series", ...(epoch === null ? [] : ["utc"]), ...axes, ...(bars ? ["low", "high"] : [])];
  const lines = [head.join()];
  series.forEach(({ kind, x, along, values: { y, low, high } }, n) => {
    const left = (spec.toggles ?? []).filter(toggle => toggle.series === n && without.has(toggle.name));
    const name = quoted([kind.name, ...left.map(toggle => toggle.name)].join(" without "));
    x.forEach((value, row) => {
      if (Number.isNaN(value) || along[row] < from || along[row] > to) return;
      const moment = epoch === null ? [] : [utc(epoch + value * unit, 0.001)];
      const ends = bars ? [low?.[row], high?.[row]] : [];
      lines.push([name, ...moment, ...[value, y[row], ...ends].map(number)].join());
    });
  });
  save(`${id}.csv`, new Blob([`${lines.join("\n")}\n`], { type: "text/csv" }));
}

// The page.

const groups = /** @type {Map<string, Group>} */ (new Map());
for (const data of document.querySelectorAll("figure > script.plot")) {
  try {
    const spec = /** @type {Spec} */ (JSON.parse(data.textContent ?? ""));
    const group = groups.get(spec.time?.group ?? "") ?? new Group();
    const source = () => spec.series.map(one =>
      new Series(one, [one.x, one.y, one.low, one.high].map(coded => coded && decoded(coded)), spec));
    new Plot(/** @type {Element} */ (data.parentElement), spec, group, source);
    if (spec.time) groups.set(spec.time.group, group);
  } catch { /* The static drawing stays. */ }
}
for (const section of document.querySelectorAll("section")) {
  const own = plots.filter(plot => section.contains(plot.figure) && plot.spec.toggles?.length);
  if (own.length) offer(own);
}
const hint = document.createElement("p");
hint.className = "note hint";
hint.textContent = HINT;
(plots[0]?.figure.closest(".plots") ?? plots[0]?.figure)?.before(hint);
document.addEventListener("click", event => {
  const link = /** @type {Element} */ (event.target).closest("a");
  const group = groups.get(link?.dataset.group ?? "");
  const plot = group?.plots.find(one => one.load());
  if (!group || !plot) return;
  const [from, to] = [Number(link?.dataset.from), Number(link?.dataset.to)];
  const { span, x, kind } = plot.series[0];
  const rows = (30 * plot.unit * (span[1] - span[0])) / (x.length * (kind.bin ?? 1));
  const room = Math.max((to - from) / 4, rows);
  group.marked = [from, to];
  group.show([from - room, to + room]);
});
addEventListener("beforeprint", () => plots.filter(plot => plot.stale).forEach(plot => plot.update()));

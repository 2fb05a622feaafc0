/** What a figure holds and how it is drawn, as `plot/svg.rs` draws it. `script.js` follows in one function.
 *
 * @typedef {Float64Array} Numbers
 * @typedef {[number, number]} Span
 * @typedef {{from?: number, step?: number, count?: number, f64?: string, base?: number, f32?: string}} Coded
 * @typedef {{label: string, unit: string, log: boolean}} Axis
 * @typedef {{name: string, mark: "points" | "line" | "dashes", style: number, bin?: number,
 *   x?: Coded, y?: Coded, low?: Coded, high?: Coded}} Kind
 * @typedef {{name: string, from: number, to: number, id: string}} Place
 * @typedef {{name: string, id?: string, series: number, y: Coded, held_out_nt?: number}} Toggle
 * @typedef {{group: string, unit_s: number, epoch_s: number | null}} Time
 * @typedef {{x: Axis, y: Axis, map?: boolean, time?: Time, series: Kind[], marks?: Place[],
 *   toggles?: Toggle[], held_out?: number, spectrum?: boolean}} Spec
 * @typedef {{at: number, label: string}} Tick
 * @typedef {{at: number, first: number, end: number}} Cell
 * @typedef {ReturnType<typeof scaleOver>} Scale
 */
const [WIDTH, HEIGHT, ABOVE, RIGHT, BELOW, CHARACTER, STYLES, DAY] = [400, 270, 24, 16, 44, 7.4, 6, 86400];
const CLOCK = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10800, 21600, 43200, DAY];
const SVG = "http://www.w3.org/2000/svg";

// Numbers as people read them.

/** @param {number} value @param {Span} ends */
const between = (value, [low, high]) => (value < low ? low : value > high ? high : value);

/** @param {number} power */
const raised = power => [...String(power)].map(sign => "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(sign)] ?? "⁻").join("");

/** @param {number} value @param {number} decimals */
const fixed = (value, decimals) =>
  value.toFixed(between(decimals, [0, 20])).replace(/^-(?=0\.?0*$)/, "").replace("-", "−");

/** @param {number} value @param {number} digits */
function significant(value, digits) {
  if (value === 0 || !Number.isFinite(value)) return value === 0 ? "0" : "–";
  const [mantissa, power] = value.toExponential(digits - 1).split("e").map(Number);
  const plain = power >= -4 && power < 7;
  const text = plain ? fixed(value, digits - 1 - power) : fixed(mantissa, digits - 1);
  return text.replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, "") + (plain ? "" : `·10${raised(power)}`);
}

/** A value to a thousandth of what is shown. @param {number} value @param {Scale} scale */
function readable(value, { log, low, high }) {
  const share = log ? 1 : Math.max(1, Math.abs(value) / (high - low));
  return significant(value, Math.min(15, Math.ceil(Math.log10(share)) + 4));
}

/** @param {number} seconds @param {number} step */
function utc(seconds, step) {
  const decimals = between(Math.ceil(-Math.log10(step) - 1e-9), [0, 3]);
  const text = new Date(Math.round(seconds * 10 ** decimals) * 10 ** (3 - decimals)).toISOString();
  return `${text.slice(0, decimals ? 20 + decimals : 19)}Z`;
}

/** @param {Axis} axis */
const named = ({ label, unit }) => (unit ? `${label} (${unit})` : label);

// Values and their places. Steps of a logarithmic axis are powers of ten.

/** Power of ten and size of a step of 1, 2 or 5. @param {number} rough @returns {Span} */
function stepNear(rough) {
  const power = Math.floor(Math.log10(rough));
  const ratio = rough / 10 ** power;
  const factor = ratio <= 1.5 ? 1 : ratio <= 3.2 ? 2 : ratio <= 7 ? 5 : 10;
  return [factor === 10 ? power + 1 : power, factor * 10 ** power];
}

/** @param {Span} span @param {number} step */
function multiples([low, high], step) {
  const first = Math.ceil(low / step - 1e-9);
  const count = Math.max(0, Math.floor(high / step + 1e-9) - first + 1);
  return Array.from({ length: count }, (_, n) => (first + n) * step);
}

/** @param {Span} span @param {number} wanted @returns {Tick[]} */
function linear(span, wanted) {
  const [power, step] = stepNear((span[1] - span[0]) / wanted);
  const largest = Math.max(...span.map(Math.abs));
  const digits = Math.ceil(Math.max(0, Math.log10(largest / step))) + 1;
  const plain = largest < 1e6 && power >= -4;
  const label = (/** @type {number} */ at) => (plain ? fixed(at, -power) : significant(at, digits));
  return multiples(span, step).map(at => ({ at, label: label(at) }));
}

/** @param {Span} powers @param {number} wanted @returns {Tick[]} */
function decades([low, high], wanted) {
  const stride = Math.max(1, Math.ceil((high - low) / wanted));
  const most = [0, Infinity, 2, 0.7, 0.7, 2, 0.7, 0.7, 0.7, 0.7];
  const powers = multiples([Math.floor(low), high], 1);
  const ticks = powers.flatMap(power => [1, 2, 3, 4, 5, 6, 7, 8, 9].map(factor => {
    const labelled = high - low < most[factor] && (factor > 1 || power % stride === 0);
    const at = factor * 10 ** power;
    return { at, label: !labelled ? "" : high - low < 2 ? significant(at, 2) : `10${raised(power)}` };
  }));
  const inside = (/** @type {number} */ power) => power >= low - 1e-9 && power <= high + 1e-9;
  return ticks.filter(({ at, label }) => inside(Math.log10(at)) && (label || stride === 1));
}

/** Times of day, dates at midnight. @param {Span} seconds @param {number} wanted @returns {Tick[]} */
function moments(seconds, wanted) {
  const rough = (0.7 * (seconds[1] - seconds[0])) / wanted;
  const days = DAY * Math.max(1, stepNear(rough / DAY)[1]);
  const step = rough < 0.5 ? stepNear(rough)[1] : (CLOCK.find(one => one >= rough) ?? days);
  return multiples(seconds, step).map(at => {
    const [date, time] = utc(at, step).slice(0, -1).split("T");
    return { at, label: at % DAY ? time.slice(0, step < 60 ? 12 : 5) : date };
  });
}

/** @param {number} value @param {boolean} log */
const stepsOf = (value, log) => (log ? (value > 0 ? Math.log10(value) : NaN) : value);

/** @param {Span[]} spans @returns {Span} */
const union = spans => [Math.min(...spans.map(one => one[0])), Math.max(...spans.map(one => one[1]))];

/** @param {Span} span @param {number} factor @returns {Span} */
const times = ([from, to], factor) => [from * factor, to * factor];

/** Steps with a little air. @param {Span} values @param {boolean} log @returns {Span} */
function aired(values, log) {
  const [low, high] = values.map(value => stepsOf(value, log));
  const largest = Math.max(Math.abs(low), Math.abs(high));
  const air = high - low > 1e-12 * largest ? 0.05 * (high - low) : log ? 0.5 : 0.1 * largest || 1;
  return Number.isFinite(high - low) ? [low - air, high + air] : [0, 1];
}

/** @param {Span} span @param {boolean} log @param {Span} places @param {Time} [time] */
function scaleOver([low, high], log, [start, end], time) {
  /** @param {number} steps */
  const at = steps => between(start + ((steps - low) / (high - low)) * (end - start), [-1e5, 1e5]);

  /** @param {number} value */
  const place = value => at(Number.isFinite(value) ? stepsOf(value, log) : NaN);

  /** @param {number} to */
  const steps = to => low + ((to - start) / (end - start)) * (high - low);

  /** @param {number} wanted @returns {Tick[]} */
  const ticks = wanted => {
    if (log || time?.epoch_s == null) return (log ? decades : linear)([low, high], wanted);
    const { unit_s: unit, epoch_s: epoch } = time;
    return moments([epoch + low * unit, epoch + high * unit], wanted)
      .map(({ at: moment, label }) => ({ at: (moment - epoch) / unit, label }));
  };
  return { low, high, log, start, end, at, place, steps, ticks };
}

/** The span in which what is at one place comes to another, so many times as wide.
 * @param {Scale} scale @param {number} from @param {number} to @param {number} [factor] @returns {Span} */
function moved({ low, high, start, end, steps }, from, to, factor = 1) {
  const first = steps(from) - ((to - start) / (end - start)) * (high - low) * factor;
  return [first, first + (high - low) * factor];
}

/** As many marks along x as have room for their labels. @param {Scale} x */
function spaced(x) {
  const fits = (/** @type {Tick[]} */ ticks) => ticks.filter(tick => tick.label).every((tick, n, all) => {
    const before = all[n - 1] ?? { at: NaN, label: "" };
    const apart = x.place(tick.at) - x.place(before.at);
    return !n || apart > (CHARACTER / 2) * (tick.label.length + before.label.length) + 8;
  });
  return [7, 6, 5, 4, 3, 2].map(x.ticks).find(fits) ?? x.ticks(1);
}

// Numbers of a figure.

/** @param {Coded} coded @returns {Numbers} */
function decoded({ from = 0, step = 1, count, f64, base = 0, f32 }) {
  if (count !== undefined) return new Float64Array(count).map((_, row) => from + row * step);
  const text = atob(f64 ?? f32 ?? "?");
  const bytes = new Uint8Array(text.length);
  for (let n = 0; n < text.length; n++) bytes[n] = text.charCodeAt(n);
  return f64 === undefined ? new Float64Array(new Float32Array(bytes.buffer)).map(value => base + value)
    : new Float64Array(bytes.buffer);
}

/** Smallest and largest values of any rows, from levels that each stand for four rows of the one below. */
class Extremes {
  /** @param {Numbers} low @param {Numbers} high */
  constructor(low, high) {
    this.levels = [{ low, high }];
    for (let below = this.levels[0]; below.low.length > 8; this.levels.push(below)) {
      const least = new Float64Array(Math.ceil(below.low.length / 4)).fill(Infinity);
      const most = least.map(() => -Infinity);
      for (let row = 0; row < below.low.length; row++) {
        if (below.low[row] < least[row >> 2]) least[row >> 2] = below.low[row];
        if (below.high[row] > most[row >> 2]) most[row >> 2] = below.high[row];
      }
      below = { low: least, high: most };
    }
  }

  /** @param {number} first @param {number} end @returns {Span} */
  over(first, end) {
    let [least, most] = [Infinity, -Infinity];
    for (let level = 0; first < end; level++, first >>= 2, end >>= 2) {
      const { low, high } = this.levels[level];
      const top = level + 1 === this.levels.length;
      while (first < end && (top || (first | end) & 3)) {
        const row = top || first & 3 ? first++ : --end;
        if (low[row] < least) least = low[row];
        if (high[row] > most) most = high[row];
      }
    }
    return [least, most];
  }
}

class Series {
  /** @param {Kind} kind @param {(Numbers | undefined)[]} numbers x, y, low, high @param {Spec} spec */
  constructor(kind, [x, given, low, high], spec) {
    // Entries that stand for several rows are their smallest and largest values.
    const y = given ?? low?.map((least, row) => (least + (high?.[row] ?? least)) / 2);
    const unlike = [y, low, high].some(one => one && one.length !== x?.length);
    if (!x || !y || unlike) throw new RangeError(kind.name);
    this.kind = kind;
    this.x = x;
    this.y = y;
    this.extremes = new Extremes(y, y);
    this.given = this.values = { y, low, high };
    this.log = spec.y.log;
    this.steps = spec.x.log ? x.map(value => stepsOf(value, true)) : x;
    this.span = new Extremes(this.steps, this.steps).over(0, x.length);
    // A gap has the place of the row before it, so that rows can be searched for.
    let last = this.span[0];
    this.along = this.steps.map(place => (last = Number.isNaN(place) ? last : place));
    this.sorted = this.along.every((place, row) => !row || place >= this.along[row - 1]);
    this.addBack([]);
  }

  /** Adds what explanations that are left out took off. @param {Numbers[]} explained */
  addBack(explained) {
    const sum = (/** @type {Numbers} */ values) =>
      explained.reduce((all, one) => all.map((value, row) => value + one[row]), values);
    const drawn = (/** @type {Numbers} */ values) =>
      values.map((value, row) => (Number.isNaN(this.steps[row]) || (this.log && value <= 0) ? NaN : value));
    const { y, low, high } = this.given;
    this.values = { y: sum(y), low: low && sum(low), high: high && sum(high) };
    this.y = drawn(this.values.y);
    this.ends = this.values.low && this.values.high
      && new Extremes(drawn(this.values.low), drawn(this.values.high));
    this.binned = (this.kind.bin ?? 1) > 1 && this.ends !== undefined;
    this.extremes = (this.binned && this.ends) || new Extremes(this.y, this.y);
  }

  /** The first row that is not before a place. @param {number} steps @param {number} [from] */
  rowAt(steps, from = 0) {
    const { step } = this.kind.x ?? {};
    const last = this.x.length;
    if (step && this.steps === this.x) return between(Math.ceil((steps - this.x[0]) / step), [0, last]);
    let [low, high] = [from, last];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.along[middle] < steps) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** Smallest and largest value in a span of x. @param {Span} span @returns {Span} */
  seen([from, to]) {
    const [first, end] = this.sorted ? [this.rowAt(from), this.rowAt(to)] : [0, this.x.length];
    return union([this.extremes, this.ends ?? this.extremes].map(one => one.over(first, end)));
  }

  /** The row nearest to a place, and how far it is; without a height, along x.
   * @param {Scale} x @param {Scale} y @param {number} at @param {number | null} height */
  nearest(x, y, at, height) {
    let [row, away] = [0, Infinity];
    const first = this.rowAt(x.steps(at)) - 1;
    const rows = height === null && this.sorted ? [first, first + 1] : this.x.keys();
    for (const one of rows) {
      const far = Math.hypot(x.at(this.along[one]) - at, height === null ? 0 : y.place(this.y[one]) - height);
      if (far < away) [row, away] = [one, far];
    }
    return { series: this, row, away };
  }
}

/** @param {Numbers} values */
function rmsOf(values) {
  const finite = values.filter(Number.isFinite);
  return Math.sqrt(finite.reduce((sum, value) => sum + value * value, 0) / finite.length);
}

/** Discrete Fourier transform in place, of a power of two numbers. @param {Numbers} re @param {Numbers} im */
function transform(re, im) {
  const count = re.length;
  for (let i = 1, j = 0; i < count; i++) {
    let bit = count >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) [re[i], re[j], im[i], im[j]] = [re[j], re[i], im[j], im[i]];
  }
  for (let half = 1; half < count; half *= 2) {
    for (let k = 0; k < half; k++) {
      const [cos, sin] = [Math.cos((Math.PI * k) / half), -Math.sin((Math.PI * k) / half)];
      for (let i = k; i < count; i += 2 * half) {
        const [a, b] = [re[i + half] * cos - im[i + half] * sin, re[i + half] * sin + im[i + half] * cos];
        [re[i], re[i + half], im[i], im[i + half]] = [re[i] + a, re[i] - a, im[i] + b, im[i] - b];
      }
    }
  }
}

/** One-sided power spectral density of steps of so many seconds: frequencies, and the mean of
 * segments without gaps that overlap by half, each under a Hann window.
 * @param {Numbers} values @param {number} step @param {number} [longest] @returns {Numbers[]} */
function spectrumOf(values, step, longest = 2 ** 14) {
  const length = between(2 ** Math.floor(Math.log2(values.length / 4)), [8, longest]);
  const power = new Float64Array(length / 2);
  let count = 0;
  for (let first = 0; first + length <= values.length; first += length / 2) {
    const segment = values.subarray(first, first + length);
    const mean = segment.reduce((sum, value) => sum + value, 0) / length;
    if (!Number.isFinite(mean)) continue;
    const re = segment.map((value, n) => (value - mean) * (0.5 - 0.5 * Math.cos((2 * Math.PI * n) / length)));
    const im = new Float64Array(length);
    transform(re, im);
    power.forEach((_, n) => (power[n] += re[n] ** 2 + im[n] ** 2));
    count++;
  }
  if (!count && length > 8) return spectrumOf(values, step, length / 2);
  // The mean square of the window is 3/8.
  const density = power.map(sum => (2 * step * sum) / (0.375 * length * count));
  return [power.map((_, n) => n / (length * step)).slice(1), density.slice(1)];
}

// Drawing.

/** @param {Element} parent @param {string} name @param {Record<string, string | number>} [attributes] */
function add(parent, name, attributes = {}, text = "") {
  const element = document.createElementNS(name === "svg" ? SVG : parent.namespaceURI, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.append(text);
  return parent.appendChild(element);
}

/** @param {number} place */
const short = place => Math.round(place * 10) / 10;

/** @param {Element} parent @param {string} name @param {string} d */
const path = (parent, name, d) => d && add(parent, "path", { class: name, d });

/** Single rows, or the rows of each column of the drawing where they are dense.
 * @param {Series} series @param {Scale} x @returns {Cell[]} */
function cells(series, x) {
  const { sorted, along } = series;
  let first = sorted ? Math.max(0, series.rowAt(x.low) - 1) : 0;
  const end = sorted ? Math.min(along.length, series.rowAt(x.high) + 1) : along.length;
  if (!sorted || end - first <= 2 * (x.end - x.start)) {
    const rows = Array.from({ length: Math.max(0, end - first) }, (_, n) => first + n);
    return rows.map(row => ({ at: x.at(along[row]), first: row, end: row + 1 }));
  }
  const columns = [];
  for (let at = x.start; at < x.end; at++) {
    const next = at + 1 < x.end ? series.rowAt(x.steps(at + 1), first) : end;
    if (next > first) columns.push({ at: at + 0.5, first, end: next });
    first = next;
  }
  return columns;
}

/** A line through the middle of cells, parted where a value is missing.
 * @param {Series} series @param {Scale} y @param {Cell[]} parts */
function line(series, y, parts) {
  let [d, step] = ["", "M"];
  for (const { at, first, end } of parts) {
    const [low, high] = series.extremes.over(first, end);
    const place = short(y.place((low + high) / 2));
    if (!Number.isNaN(place)) d += `${step}${short(at)} ${place}`;
    step = Number.isNaN(place) ? "M" : "L";
  }
  return d;
}

/** Places of x, low and high, so far apart at least; a lower end without a place is at the foot.
 * @param {Extremes} ends @param {Scale} y @param {Cell[]} parts @param {number} [apart] */
const bars = (ends, y, parts, apart = 0) => parts.map(({ at, first, end }) => {
  const [low, high] = ends.over(first, end).map(y.place);
  return [short(at), short((Number.isNaN(low) ? y.start : low) + apart / 2), short(high - apart / 2)];
});

/** @param {number[][]} ends */
function band(ends) {
  let [d, there, back] = ["", "", /** @type {string[]} */ ([])];
  for (const [at, low, high] of [...ends, [0, 0, NaN]]) {
    if (!Number.isNaN(high)) {
      there += `L${at} ${high}`;
      back.push(`${at} ${low}`);
    } else if (back.length) {
      d += `M${there.slice(1)}L${back.reverse().join("L")}z`;
      [there, back] = ["", []];
    }
  }
  return d;
}

/** Circle, square, triangle, diamond, plus and cross.
 * @param {number} style @param {number} x @param {number} y @param {number} size */
function shape(style, x, y, size) {
  const r = short(size * [1, 0.9, 1, 1.25, 1, 1][style]);
  const [left, up, two, atX, atY] = [x - r, y - r, 2 * r, x, y].map(short);
  return [
    `M${left} ${atY}a${r} ${r} 0 1 0 ${two} 0a${r} ${r} 0 1 0 ${-two} 0`,
    `M${left} ${up}h${two}v${two}h${-two}z`,
    `M${atX} ${short(y - 1.2 * r)}l${short(1.15 * r)} ${two}h${short(-2.3 * r)}z`,
    `M${atX} ${up}l${r} ${r}l${-r} ${r}l${-r} ${-r}z`,
    `M${left} ${atY}h${two}M${atX} ${up}v${two}`,
    `M${left} ${up}l${two} ${two}m${-two} 0l${two} ${-two}`,
  ][style];
}

/** @param {Element} parent @param {Series} series @param {Scale} x @param {Scale} y @param {boolean} signs */
function drawSeries(parent, series, x, y, signs) {
  const { mark, style } = series.kind;
  const group = add(parent, "g", { class: `s${style % STYLES}` });
  const parts = cells(series, x);
  const height = (/** @type {Cell} */ { first }) => y.place(series.y[first]);
  const inside = parts.filter(cell => cell.at >= x.start && cell.at <= x.end && !Number.isNaN(height(cell)));
  const shapes = (/** @type {Cell[]} */ some, /** @type {number} */ size) => path(group, "points",
    some.map(cell => shape(style % STYLES, cell.at, height(cell), size)).join(""));
  if (series.binned || (mark !== "dashes" && parts.some(({ first, end }) => end - first > 1))) {
    path(group, "band", series.ends ? band(bars(series.ends, y, parts)) : "");
    path(group, "extent", band(bars(series.extremes, y, parts, 1.5)));
  } else if (mark === "points") {
    const ends = series.ends ? bars(series.ends, y, inside).filter(([, , high]) => !Number.isNaN(high)) : [];
    path(group, "bars", ends.map(([at, low, high]) => `M${at} ${low}V${high}`).join(""));
    const seen = new Set();
    const places = inside.map(cell => 1000 * Math.round(cell.at) + Math.round(height(cell)));
    const apart = inside.filter((_, n) => !seen.has(places[n]) && seen.add(places[n]));
    shapes(inside.length > 2000 ? apart : inside, inside.length > 300 ? 1.6 : inside.length > 60 ? 2.4 : 3.4);
  } else {
    path(group, "band", series.ends ? band(bars(series.ends, y, parts)) : "");
    path(group, mark, line(series, y, parts));
  }
  const stride = 2 ** Math.max(0, Math.floor(Math.log2(parts.length / 7)));
  if (signs && mark === "line") shapes(inside.filter((_, n) => n % stride === stride >> 1), 3);
}

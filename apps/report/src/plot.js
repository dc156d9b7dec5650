// One plot: a figure with lines, a legend that shows values at the cursor, and an image on demand.
import uPlot from 'uplot';
import {color, element, figure} from './dom.js';
import {drawMarks, markClamped, markViolated, shadeLimits} from './plot_marks.js';

const height = 210;

/// Plots with more lines have a field that filters them by name.
const manyLines = 8;

/// At most seven powers of ten between two numbers: ticks of a logarithmic axis.
function powersOfTen(u, axis, low, high) {
  const first = Math.ceil(Math.log10(low) - 1e-9), last = Math.floor(Math.log10(high) + 1e-9);
  const step = Math.max(1, Math.ceil((last - first + 1) / 7));
  const ticks = [];
  for (let power = first; power <= last; power += step) ticks.push(Number(`1e${power}`));
  return ticks;
}

/// The width of a vertical axis: that of its widest number, at least `least`, so that the time axes
/// of most plots are aligned.
const axisWidth = least => (u, numbers, index, cycle) => {
  const axis = u.axes[index];
  if (cycle > 1) return axis._size;  // final: another width would change the ticks again
  u.ctx.font = axis.font[0];
  const widest = Math.max(0, ...(numbers ?? []).map(text => u.ctx.measureText(text).width / devicePixelRatio));
  return Math.max(least, Math.ceil(widest + axis.ticks.size + axis.gap + 2));
};

/// The range of an axis around its lines and, if `soft` is given, including that interval.
function rangeWith(soft) {
  const side = value => ({pad: 0.1, soft: value, mode: value === undefined ? 0 : 1});
  return (u, low, high) => {
    if (low === null) return [null, null];
    if (low === high && !soft) return [low - Math.max(1, Math.abs(low)), high + Math.max(1, Math.abs(high))];
    return uPlot.rangeNum(low, high, {min: side(soft?.[0]), max: side(soft?.[1])});
  };
}

/// The range of a logarithmic axis, including limits.
const rangeWithLimits = lines => (u, low, high) => {
  const tops = lines.flatMap(l => l.limit?.upper ?? []).filter(x => x > 0);
  return low === null ? [null, null] : uPlot.rangeLog(low, Math.max(high, ...tops.map(t => 10 * t)), 10, true);
};

export class Plot {
  /// `lines`: {label, values, color, dash, solution, steps, limit: {lower, upper}, clamped,
  /// violated}; a limit is one number or a list over the points. With a player, the plot shows its time, and a click sets the time. `marks`: {at,
  /// text}.
  constructor(holder, {title, unit, hint, x, xLabel, xUnit, lines, log = false, soft = null, player = null, marks = []}) {
    this.title = title;
    this.lines = lines;
    this.player = player;
    this.marks = marks;
    const save = element('button', {type: 'button', title: 'Save this plot as a picture',
                                    onclick: () => this.savePicture()}, 'PNG');
    this.caption = element('span', {}, unit ? `${title} [${unit}]` : title);
    this.figure = element('figure', {}, element('figcaption', {}, this.caption, save));
    if (hint) this.figure.append(element('div', {class: 'hint'}, hint));
    holder.append(this.figure);

    const axis = {stroke: () => color('faint'), grid: {stroke: () => color('grid'), width: 1},
                  ticks: {stroke: () => color('line'), width: 1}};
    const options = {
      width: Math.max(260, holder.clientWidth - 18),
      height,
      cursor: {sync: {key: player ? 'time' : 'iterations', setSeries: false}, drag: {x: true, y: false}},
      scales: {x: {time: false}, y: log ? {distr: 3, range: rangeWithLimits(lines)} : {range: rangeWith(soft)}},
      axes: [{...axis, label: xUnit ? `${xLabel}, ${xUnit}` : xLabel, labelSize: 18, size: 36,
              labelFont: '12px system-ui', font: '11px system-ui'},
             {...axis, size: axisWidth(58), font: '11px system-ui', splits: log ? powersOfTen : undefined, filter: log ? (u, ticks) => ticks : undefined,
              values: (_, ticks) => ticks.map(v => (v === null ? '' : String(Number(v.toPrecision(4)))))}],
      series: [{label: xLabel, value: (_, v) => (v === null ? '–' : `${figure(v)}${xUnit ? ` ${xUnit}` : ''}`)},
               ...lines.map(line => ({
                 label: line.label,
                 stroke: line.color,
                 dash: line.dash,
                 width: 1.6,
                 pxAlign: 0,
                 points: {show: line.values.filter(v => v !== null && v !== undefined).length < 60, size: 4},
                 paths: line.steps ? uPlot.paths.stepped({align: 1}) : undefined,
                 value: (_, v) => `${figure(v)}${unit && v !== null ? ` ${unit}` : ''}`,
               }))],
      legend: {live: true},
      hooks: {
        drawClear: [u => {
          shadeLimits(u, lines);
        }],
        setCursor: player ? [u => player.point(u.cursor.left >= 0 ? u.posToVal(u.cursor.left, 'x') : null)] : [],
        draw: [u => {
          markClamped(u, lines);
          markViolated(u, lines);
          drawMarks(u, marks);
        }],
      },
    };
    this.u = new uPlot(options, [x, ...lines.map(l => l.values)], this.figure);
    if (player) this.addNeedle();
    if (lines.length > manyLines) this.addFilter(save);
    this.observer = new ResizeObserver(() => this.resize(holder));
    this.observer.observe(holder);
  }

  /// Adds a field before a button: it shows only lines whose names contain its text, and without text
  /// those of before.
  addFilter(button) {
    let before = null;
    const field = element('input', {type: 'search', placeholder: 'filter', 'aria-label': 'Show lines whose names contain',
                                    oninput: () => {
      const rows = [...this.figure.querySelectorAll('.u-legend .u-series')].slice(1);
      before ??= this.lines.map((_, i) => this.u.series[i + 1].show);
      this.lines.forEach((line, i) => {
        const match = line.label.toLowerCase().includes(field.value.toLowerCase());
        rows[i].hidden = !match;
        this.u.setSeries(i + 1, {show: field.value ? match : before[i]});
      });
      if (!field.value) before = null;
    }});
    button.before(field);
  }

  addNeedle() {
    this.needle = element('div', {class: 'needle'});
    this.u.over.append(this.needle);
    let pressed = null;
    this.u.over.addEventListener('mousedown', event => { pressed = event.clientX; });
    this.u.over.addEventListener('mouseup', event => {
      if (pressed === null || Math.abs(event.clientX - pressed) > 3) return;
      const box = this.u.over.getBoundingClientRect();
      this.player.seek(this.u.posToVal(event.clientX - box.left, 'x'));
    });
    this.player.listen(() => {
      this.moveNeedle();
      this.readLater();
    });
    this.moveNeedle();
    this.readLater();
  }

  /// Once the time rests, the legend shows its values until the pointer enters the plot.
  readLater() {
    clearTimeout(this.reading);
    this.reading = setTimeout(() => {
      if (this.player.playing || this.u.cursor.left >= 0) return;
      this.u.setLegend({idx: this.u.valToIdx(this.player.time)});
    }, 120);
  }

  moveNeedle() {
    const x = this.u.valToPos(this.player.time, 'x');
    const inside = x >= -1 && x <= this.u.over.clientWidth + 1;
    this.needle.style.display = inside ? '' : 'none';
    if (inside) this.needle.style.transform = `translateX(${x}px)`;
  }

  resize(holder) {
    const width = Math.max(260, holder.clientWidth - 18);
    if (width === this.u.width) return;
    this.u.setSize({width, height});
    if (this.player) this.moveNeedle();
  }

  /// Hides lines of invisible solutions.
  setVisible(visible) {
    this.lines.forEach((line, i) => {
      if (line.solution !== undefined) this.u.setSeries(i + 1, {show: visible[line.solution]});
    });
  }

  setTheme() {
    this.u.redraw(false, true);
  }

  /// An image of the plot with its title and the names of its lines.
  picture() {
    const scale = devicePixelRatio, plot = this.u.ctx.canvas;
    const shown = this.lines.filter((_, i) => this.u.series[i + 1].show);
    const columns = Math.max(1, Math.floor(plot.width / (190 * scale)));
    const rows = Math.ceil(shown.length / columns);
    const top = 26 * scale, row = 17 * scale;
    const canvas = element('canvas', {width: plot.width, height: plot.height + top + row * rows + 6 * scale});
    const ctx = canvas.getContext('2d');
    ctx.fillStyle = color('ground');
    ctx.fillRect(0, 0, canvas.width, canvas.height);
    ctx.fillStyle = color('text');
    ctx.font = `600 ${14 * scale}px system-ui`;
    ctx.fillText(this.caption.textContent, 8 * scale, 18 * scale);
    ctx.drawImage(plot, 0, top);
    ctx.font = `${12 * scale}px system-ui`;
    shown.forEach((line, i) => {
      const x = (i % columns) * (plot.width / columns) + 8 * scale;
      const y = top + plot.height + row * (Math.floor(i / columns) + 0.7);
      ctx.strokeStyle = line.color;
      ctx.lineWidth = 2 * scale;
      ctx.setLineDash((line.dash ?? []).map(d => d * scale));
      ctx.beginPath();
      ctx.moveTo(x, y - 4 * scale);
      ctx.lineTo(x + 18 * scale, y - 4 * scale);
      ctx.stroke();
      ctx.fillText(line.label, x + 23 * scale, y);
    });
    return canvas;
  }

  savePicture() {
    const name = this.title.replace(/[^\w-]+/g, '_');
    element('a', {href: this.picture().toDataURL('image/png'), download: `${name}.png`}).click();
  }
}

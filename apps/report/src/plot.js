// One plot: a figure with lines, a legend that reads values at the cursor, and a picture of it on
// demand.
import uPlot from 'uplot';
import {color, element, figure} from './dom.js';

const height = 210;

/// At most seven powers of ten between two numbers: ticks of a logarithmic axis.
function powersOfTen(u, axis, low, high) {
  const first = Math.ceil(Math.log10(low) - 1e-9), last = Math.floor(Math.log10(high) + 1e-9);
  const step = Math.max(1, Math.ceil((last - first + 1) / 7));
  const ticks = [];
  for (let power = first; power <= last; power += step) ticks.push(Number(`1e${power}`));
  return ticks;
}

/// Where a value lies outside everything that lines in view may take.
function shadeLimits(u, limits) {
  const {ctx, bbox} = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  const shown = limits.filter((limit, i) => limit && u.series[i + 1].show);
  const bottoms = shown.map(l => l.lower).filter(x => x !== null);
  const tops = shown.map(l => l.upper).filter(x => x !== null);
  ctx.fillStyle = color('grid');
  if (bottoms.length === shown.length && bottoms.length > 0) {
    const y = u.valToPos(Math.min(...bottoms), 'y', true);
    ctx.fillRect(bbox.left, y, bbox.width, bbox.top + bbox.height - y);
  }
  if (tops.length === shown.length && tops.length > 0) {
    const y = u.valToPos(Math.max(...tops), 'y', true);
    ctx.fillRect(bbox.left, bbox.top, bbox.width, y - bbox.top);
  }
  ctx.strokeStyle = color('faint');
  ctx.setLineDash([4, 4]);
  ctx.lineWidth = 1;
  for (const value of new Set([...bottoms, ...tops])) {
    const y = u.valToPos(value, 'y', true);
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
  }
  ctx.restore();
}

/// Spans in which a value is at its limit, drawn thick.
function markClamped(u, lines) {
  const {ctx, bbox} = u;
  const [x] = u.data;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.lineCap = 'round';
  lines.forEach((line, i) => {
    if (!line.clamped || !u.series[i + 1].show) return;
    ctx.strokeStyle = line.color;
    ctx.lineWidth = 5 * devicePixelRatio;
    line.clamped.forEach((at, k) => {
      const y = u.data[i + 1][k];
      if (!at || y === null || y === undefined || k + 1 >= x.length) return;
      ctx.beginPath();
      ctx.moveTo(u.valToPos(x[k], 'x', true), u.valToPos(y, 'y', true));
      ctx.lineTo(u.valToPos(x[k + 1], 'x', true), u.valToPos(y, 'y', true));
      ctx.stroke();
    });
  });
  ctx.restore();
}

export class Plot {
  /// `lines`: {label, values, color, dash, solution, steps, limit: {lower, upper}, clamped}. With a
  /// player, the plot shows its time and a click sets it.
  constructor(holder, {title, unit, hint, x, xLabel, xUnit, lines, log = false, player = null, marks = []}) {
    this.title = title;
    this.lines = lines;
    this.player = player;
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
      scales: {x: {time: false}, y: log ? {distr: 3} : {range: {min: {pad: 0.1, soft: null}, max: {pad: 0.1}}}},
      axes: [{...axis, label: xUnit ? `${xLabel}, ${xUnit}` : xLabel, labelSize: 18, size: 36,
              labelFont: '12px system-ui', font: '11px system-ui'},
             {...axis, size: 58, font: '11px system-ui', splits: log ? powersOfTen : undefined,
              values: (_, ticks) => ticks.map(v => (v === null ? '' : String(Number(v.toPrecision(4)))))}],
      series: [{label: xLabel, value: (_, v) => (v === null ? '–' : `${figure(v)}${xUnit ? ` ${xUnit}` : ''}`)},
               ...lines.map(line => ({
                 label: line.label,
                 stroke: line.color,
                 dash: line.dash,
                 width: 1.6,
                 pxAlign: 0,
                 points: {show: x.length < 60, size: 4},
                 paths: line.steps ? uPlot.paths.stepped({align: 1}) : undefined,
                 value: (_, v) => `${figure(v)}${unit && v !== null ? ` ${unit}` : ''}`,
               }))],
      legend: {live: true},
      hooks: {
        drawClear: [u => {
          if (lines.some(l => l.limit)) shadeLimits(u, lines.map(l => l.limit ?? null));
        }],
        draw: [u => {
          markClamped(u, lines);
          this.drawMarks(u, marks);
        }],
      },
    };
    this.u = new uPlot(options, [x, ...lines.map(l => l.values)], this.figure);
    if (player) this.addNeedle();
    this.observer = new ResizeObserver(() => this.resize(holder));
    this.observer.observe(holder);
  }

  /// Vertical lines with a name: where a stage of a solver begins.
  drawMarks(u, marks) {
    const {ctx, bbox} = u;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = color('faint');
    ctx.font = `${11 * devicePixelRatio}px system-ui`;
    for (const {at, text} of marks) {
      const x = u.valToPos(at, 'x', true);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      ctx.fillText(text, x + 4, bbox.top + 12 * devicePixelRatio);
    }
    ctx.restore();
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
    this.player.listen(() => this.moveNeedle());
    this.moveNeedle();
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

  /// Lines of solutions that are not in view are hidden.
  setVisible(visible) {
    this.lines.forEach((line, i) => {
      if (line.solution !== undefined) this.u.setSeries(i + 1, {show: visible[line.solution]});
    });
  }

  setTheme() {
    this.u.redraw(false, true);
  }

  /// The plot with its title and the names of its lines.
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

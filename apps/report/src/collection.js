// Plots of all solutions together: lines on a common axis, one color per name.
import uPlot from 'uplot';
import {stageMarks} from './convergence.js';
import {element} from './dom.js';
import {lineColor, lineDash, solutionDash} from './palette.js';
import {Plot} from './plot.js';

/// Maximum number of initially visible lines; the legend contains the others.
const lineLimit = 16;

/// Separates nodes at the same time (an impulse): the second one is shifted by an instant.
function apart(x) {
  const axis = x.slice();
  for (let i = 1; i < axis.length; ++i)
    if (axis[i] <= axis[i - 1]) axis[i] = axis[i - 1] + 1e-9 * Math.max(1, Math.abs(axis[i - 1]));
  return axis;
}

/// Resamples lines of several solutions to one axis, with their flags at its points.
function join(parts) {
  const axes = parts.map(({x}) => apart(x));
  const lines = parts.flatMap(({lines}, i) => lines.map(line => ({line, axis: axes[i]})));
  if (parts.length === 1) return {x: axes[0], lines: lines.map(({line}) => line)};
  const [x, ...values] = uPlot.join(parts.map(({lines}, i) => [axes[i], ...lines.map(l => l.values)]),
                                    parts.map(({lines}) => [0, ...lines.map(() => 2)]));
  const place = new Map(x.map((value, i) => [value, i]));
  const spread = (list, axis) => {
    if (!Array.isArray(list)) return list;
    const all = Array(x.length).fill(null);
    list.forEach((value, k) => { all[place.get(axis[k])] = value; });
    return all;
  };
  return {x, lines: lines.map(({line, axis}, i) => {
    const of = list => spread(list, axis);
    const limit = line.limit && {lower: of(line.limit.lower), upper: of(line.limit.upper)};
    return {...line, values: values[i], clamped: of(line.clamped), violated: of(line.violated), limit};
  })};
}

/// Pads a list with null at missing nodes: controls end before the last node.
const filled = (values, length) =>
    values.length >= length ? values : values.concat(Array(length - values.length).fill(null));

export class Collection {
  constructor(holder, solutions, player) {
    this.holder = holder;
    this.solutions = solutions;
    this.player = player;
    this.plots = [];
  }

  heading(text) {
    this.holder.append(element('h2', {}, text));
  }

  /// `of(solution)` returns [{name, values, ...}] or nothing. Lines with the same name share their
  /// color, lines of the same solution their dashes.
  add({title, unit, hint, xOf, xLabel, xUnit, of, log, soft, overTime, marks = []}) {
    const names = [];
    const parts = this.solutions.map((solution, i) => {
      const x = xOf(solution);
      const lines = (of(solution) ?? []).filter(l => l.values.some(v => v !== null && v !== undefined));
      for (const line of lines) if (!names.includes(line.name)) names.push(line.name);
      return {x, lines: lines.map(line => ({
        ...line,
        values: filled(line.values, x.length),
        label: this.solutions.length > 1 ? `${line.name} · ${solution.label}` : line.name,
        solution: i,
      }))};
    });
    if (names.length === 0) return;
    for (const {lines} of parts)
      for (const line of lines) {
        line.rank = names.indexOf(line.name);
        line.color = lineColor(line.rank);
        line.dash = this.solutions.length > 1 ? solutionDash(line.solution) : lineDash(line.rank);
      }
    const joined = join(parts);
    const plot = new Plot(this.holder, {title, unit, hint, ...joined, xLabel, xUnit, log, soft, marks,
                                        player: overTime ? this.player : null});
    joined.lines.forEach((line, i) => {
      if (line.rank >= lineLimit) plot.u.setSeries(i + 1, {show: false});
    });
    this.plots.push(plot);
  }

  overTime(options) {
    this.add({...options, xOf: s => s.curves.t, xLabel: 'time', xUnit: 's', overTime: true});
  }

  overIterations(options) {
    this.add({...options, xOf: s => s.head.log.map(row => row.iteration), xLabel: 'iteration',
              marks: stageMarks(this.solutions[0].head.log)});
  }
}

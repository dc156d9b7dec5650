// Which plots there are: the curves of all solutions over time, then over iterations.
import uPlot from 'uplot';
import {element} from './dom.js';
import {forceParts} from './data.js';
import {lineColor, lineDash, solutionDash} from './palette.js';
import {Plot} from './plot.js';

/// Most lines that a plot begins with; the legend has the others.
const lineLimit = 16;

/// "q/hip" belongs to group "q", "base/vx" to "base linear velocity" by its unit and kind.
function groupOf(name, unit) {
  const slash = name.indexOf('/');
  const family = slash < 0 ? '' : name.slice(0, slash);
  const rest = slash < 0 ? name : name.slice(slash + 1);
  const titles = {q: 'Joint positions', v: 'Joint velocities', u: 'Controls', base: 'Base'};
  if (family === 'base') {
    if (/^q[xyzw]$/.test(rest)) return 'Base orientation (quaternion)';
    if (/^v/.test(rest)) return 'Base velocity';
    if (/^w/.test(rest)) return 'Base angular velocity';
    return 'Base position';
  }
  return titles[family] ? titles[family] : family || (unit ? `States in ${unit}` : 'States');
}

/// Brings lines of several solutions to one axis. Nodes at the same time (an impulse) stay two
/// nodes: the second one comes an instant later.
function join(parts) {
  const axes = parts.map(({x, lines}) => {
    const apart = x.slice();
    for (let i = 1; i < apart.length; ++i)
      if (apart[i] <= apart[i - 1]) apart[i] = apart[i - 1] + 1e-9 * Math.max(1, Math.abs(apart[i - 1]));
    return [apart, ...lines.map(l => l.values)];
  });
  const lines = parts.flatMap(({lines}) => lines);
  const data = axes.length === 1 ? axes[0] : uPlot.join(axes, axes.map(a => a.map(() => 2)));
  return {x: data[0], lines: lines.map((line, i) => ({...line, values: data[i + 1]}))};
}

const filled = (values, length) =>
    values.length >= length ? values : values.concat(Array(length - values.length).fill(null));

class Collection {
  constructor(holder, solutions, player) {
    this.holder = holder;
    this.solutions = solutions;
    this.player = player;
    this.plots = [];
  }

  heading(text) {
    this.holder.append(element('h2', {}, text));
  }

  /// `of(solution)` gives [{name, values, ...}] or nothing; lines of one name share their colour,
  /// those of one solution their dashes.
  add({title, unit, hint, xOf, xLabel, xUnit, of, log, overTime, marksOf}) {
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
        const index = names.indexOf(line.name);
        line.color = lineColor(index);
        line.dash = this.solutions.length > 1 ? solutionDash(line.solution) : lineDash(index);
      }
    const joined = join(parts);
    const marks = marksOf ? this.solutions.flatMap(marksOf) : [];
    const plot = new Plot(this.holder, {title, unit, hint, ...joined, xLabel, xUnit, log, marks,
                                        player: overTime ? this.player : null});
    joined.lines.forEach((line, i) => {
      if (names.indexOf(line.name) >= lineLimit) plot.u.setSeries(i + 1, {show: false});
    });
    this.plots.push(plot);
  }

  overTime(options) {
    this.add({...options, xOf: s => s.curves.t, xLabel: 'time', xUnit: 's', overTime: true});
  }

  overIterations(options) {
    this.add({...options, xOf: s => s.head.log.map(row => row.iteration), xLabel: 'iteration',
              marksOf: s => stageMarks(s.head.log)});
  }
}

/// Where the log says that another stage of the solver begins.
function stageMarks(log) {
  const marks = [];
  log.forEach((row, i) => {
    if (row.stage !== undefined && row.stage !== null && (i === 0 || log[i - 1].stage !== row.stage))
      marks.push({at: row.iteration, text: String(row.stage)});
  });
  return marks.length > 1 ? marks : [];
}

function addColumns(collection, key, {steps, limits}) {
  const groups = new Map();
  for (const {curves} of collection.solutions)
    curves[key].names.forEach((name, c) => {
      const unit = curves[key].units[c] ?? '';
      const id = `${groupOf(name, unit)}|${unit}`;
      if (!groups.has(id)) groups.set(id, {title: groupOf(name, unit), unit});
    });
  for (const {title, unit} of groups.values())
    collection.overTime({
      title: key === 'u' && title.startsWith('States') ? 'Controls' : title,
      unit,
      hint: limits ? 'Shaded: beyond the limits. Thick: at a limit.' : null,
      of: ({curves}) => {
        const {names, units, values, lower, upper} = curves[key];
        return names.map((name, c) => ({name, c})).filter(({name, c}) =>
            groupOf(name, units[c] ?? '') === title && (units[c] ?? '') === unit).map(({name, c}) => {
          const line = {name: name.replace(/^(q|v|u|base)\//, ''), values: values[c], steps};
          if (limits && lower) Object.assign(line, limitOf(values[c], lower[c], upper[c]));
          return line;
        });
      },
    });
}

/// The tightest limits of a column over all knots, and the knots at which it is at one.
function limitOf(values, lower, upper) {
  const numbers = list => list.filter(v => v !== null);
  const low = numbers(lower), high = numbers(upper);
  if (low.length === 0 && high.length === 0) return {};
  return {
    limit: {lower: low.length ? Math.max(...low) : null, upper: high.length ? Math.min(...high) : null},
    clamped: values.map((v, k) => v !== null && [lower[k], upper[k]].some(bound =>
        bound !== null && bound !== undefined && Math.abs(v - bound) <= 1e-6 * Math.max(1, Math.abs(bound)))),
  };
}

function addForces(collection) {
  if (!collection.solutions.some(s => s.contacts.length > 0)) return;
  collection.heading('Contacts');
  const part = pick => s => s.contacts.map(entry => ({
    name: entry.name,
    steps: true,
    values: entry.forces.map((_, k) => {
      const t = s.curves.t;
      if (t[k + 1] === t[k]) return null;  // an impulse is in Ns
      return pick(forceParts(entry, k));
    }),
  }));
  collection.overTime({title: 'Normal force', unit: 'N', of: part(p => p?.normal ?? null)});
  collection.overTime({
    title: 'Share of the friction cone',
    hint: 'Tangential force over μ times normal force: above 1 the foot slides.',
    of: s => part(p => p?.use ?? null)(s).map(line => ({...line, limit: {lower: null, upper: 1}})),
  });
}

function addLog(collection) {
  const column = (name, keep = v => v) => s => s.head.log.map(row => {
    const value = row[name];
    return value === null || value === undefined ? null : keep(value);
  });
  const positive = v => (v > 0 ? v : null);
  const line = (name, key, keep) => s => ({name, values: column(key, keep)(s)});
  const lines = (...makers) => s => makers.map(make => make(s));
  collection.heading('Convergence');
  collection.overIterations({title: 'Cost and merit', of: lines(line('cost', 'cost'), line('merit', 'merit'))});
  collection.overIterations({title: 'Residuals', log: true, hint: 'Logarithmic; zero is left out.',
    of: lines(line('stationarity', 'stationarity', positive), line('gap', 'gap', positive),
              line('violation', 'constraint', positive),
              line('complementarity', 'complementarity', positive))});
  collection.overIterations({title: 'Step length', of: lines(line('step', 'step'))});
  collection.overIterations({title: 'Regularisation and penalty', log: true,
    of: lines(line('regularisation', 'regularization', positive), line('penalty', 'penalty', positive))});
  collection.overIterations({title: 'Changes of the active set', of: lines(
    line('clamped', 'clamped'), line('active set changes', 'active_set_changes'))});
}

export function makePlots(holder, solutions, player) {
  const collection = new Collection(holder, solutions, player);
  collection.heading('Motion');
  addColumns(collection, 'x', {steps: false, limits: false});
  collection.heading('Controls');
  addColumns(collection, 'u', {steps: true, limits: true});
  addForces(collection);
  collection.heading('Costs');
  collection.overTime({
    title: 'Cost of each knot by name',
    hint: 'Rates are multiplied by the time step.',
    of: ({curves}) => Object.entries(curves.costs ?? {}).map(([name, values]) =>
        ({name, values, steps: !name.startsWith('terminal/')})),
  });
  if (solutions.some(s => s.curves.constraints)) {
    collection.heading('Constraints');
    collection.overTime({title: 'Violation by name',
      of: ({curves}) => Object.entries(curves.constraints ?? {}).map(([name, values]) => ({name, values}))});
  }
  collection.heading('Multipliers and gains');
  collection.overTime({title: 'Largest co-state', of: ({curves}) => [{name: 'max |λ|', values: curves.costates ?? []}]});
  collection.overTime({title: 'Multipliers of control limits', of: ({curves}) => ['lower', 'upper'].flatMap(side =>
      (curves.u[`control_${side}_multipliers`] ?? []).map((values, c) =>
          ({name: `${curves.u.names[c]} ${side}`, values, steps: true})).filter(l => l.values.some(v => v > 0)))});
  collection.overTime({title: 'Largest feedback gain', of: ({curves}) => [{name: 'max |K|', values: curves.gain ?? [], steps: true}]});
  addLog(collection);
  return collection.plots;
}

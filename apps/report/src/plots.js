// The plots: curves of all solutions over time, then over iterations.
import {Collection} from './collection.js';
import {addConstraints} from './constraints.js';
import {addConvergence} from './convergence.js';
import {forceParts} from './data.js';
import {addTicks} from './loop.js';

/// Column families of implicit steps in addition to the controls.
const ofImplicitSteps = {a: 'Accelerations', contact: 'Contact variables', stop: 'Stops of joints',
                         friction: 'Dry friction of joints'};
const isOfImplicitSteps = name => name.includes('/') && name.slice(0, name.indexOf('/')) in ofImplicitSteps;

/// Linear controls are state columns at the nodes; columns of u are the controls at the ends of
/// knots.
const endOf = 'end/';
const isLinear = (curves, name) => curves.u.names.includes(endOf + name);

/// The limits of a column at the times of its values.
function limitsOf(curves, key, name, c) {
  const {lower, upper} = curves.u;
  if (!lower) return null;
  if (key === 'u') return [lower[c], upper[c]];
  const end = curves.u.names.indexOf(endOf + name);
  return end < 0 ? null : [[null, ...lower[end]], [null, ...upper[end]]];
}

/// The plot of a column: "q/hip" belongs to joint positions, "base/vx" to the base's velocity, ...
function groupOf(name) {
  const slash = name.indexOf('/');
  const family = slash < 0 ? '' : name.slice(0, slash);
  const rest = slash < 0 ? name : name.slice(slash + 1);
  const titles = {q: 'Joint positions', v: 'Joint velocities', u: 'Controls', base: 'Base', ...ofImplicitSteps};
  if (family === 'base') {
    if (/^q[xyzw]$/.test(rest)) return 'Base orientation (quaternion)';
    if (/^v/.test(rest)) return 'Base velocity';
    if (/^w/.test(rest)) return 'Base angular velocity';
    return 'Base position';
  }
  return titles[family] ?? (family || 'States');
}

/// The unit of a column, empty if dimensionless.
const unitOf = ({units}, c) => (units[c] === '1' ? '' : units[c] ?? '');

/// Adds plots of the selected columns.
function addColumns(collection, key, {steps, limits, controls = limits, wanted = () => true}) {
  const groups = new Map();
  for (const {curves} of collection.solutions)
    curves[key].names.forEach((name, c) => {
      if (!wanted(name, curves)) return;
      const unit = unitOf(curves[key], c);
      const id = `${groupOf(name)}|${unit}`;
      if (!groups.has(id)) groups.set(id, {title: groupOf(name), unit});
    });
  for (const {title, unit} of groups.values())
    collection.overTime({
      title: controls && title.startsWith('States') ? 'Controls' : title,
      unit,
      hint: limits ? 'Shaded: beyond the limits. Thick: at a limit.' : null,
      of: ({curves}) => {
        const {names, values} = curves[key];
        return names.map((name, c) => ({name, c})).filter(({name, c}) =>
            wanted(name, curves) && groupOf(name) === title && unitOf(curves[key], c) === unit).map(({name, c}) => {
          const line = {name: name.replace(/^(q|v|u|base)\//, ''), values: values[c], steps};
          const bounds = limits ? limitsOf(curves, key, name, c) : null;
          if (bounds) Object.assign(line, limitOf(values[c], ...bounds));
          return line;
        });
      },
    });
}

/// The limits of a column, and the knots at a limit.
function limitOf(values, lower, upper) {
  if ([...lower, ...upper].every(v => v === null)) return {};
  return {
    limit: {lower, upper},
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
    soft: [0, 1.1],
    of: s => part(p => p?.use ?? null)(s).map(line => ({...line, limit: {lower: null, upper: 1}})),
  });
}

/// `loop`: the closed loop whose plant is the solution.
export function makePlots(holder, solutions, player, loop) {
  const collection = new Collection(holder, solutions, player);
  collection.heading('Motion');
  addColumns(collection, 'x',
      {steps: false, limits: false, wanted: (name, curves) => !isLinear(curves, name)});
  collection.heading('Controls');
  addColumns(collection, 'x',
      {steps: false, limits: true, wanted: (name, curves) => isLinear(curves, name)});
  addColumns(collection, 'u', {steps: true, limits: true,
      wanted: name => !isOfImplicitSteps(name) && !name.startsWith(endOf)});
  if (loop) {
    addForces(collection);
    addTicks(collection, loop);
    return collection.plots;
  }
  addForces(collection);
  if (solutions.some(({curves}) => curves.u.names.some(isOfImplicitSteps))) {
    collection.heading('Variables of implicit steps');
    addColumns(collection, 'u',
        {steps: true, limits: false, controls: true, wanted: isOfImplicitSteps});
  }
  collection.heading('Costs');
  collection.overTime({
    title: 'Cost of each knot by name',
    hint: 'Rates are multiplied by the time step.',
    of: ({curves}) => Object.entries(curves.costs ?? {}).map(([name, values]) =>
        ({name, values, steps: !name.startsWith('terminal/')})),
  });
  addConstraints(collection);
  collection.heading('Multipliers and gains');
  collection.overTime({title: 'Largest co-state', of: ({curves}) => [{name: 'max |λ|', values: curves.costates ?? []}]});
  collection.overTime({title: 'Multipliers of control limits', of: ({curves}) => ['lower', 'upper'].flatMap(side =>
      (curves.u[`control_${side}_multipliers`] ?? []).map((values, c) =>
          ({name: `${curves.u.names[c]} ${side}`, values, steps: true})).filter(l => l.values.some(v => v > 0)))});
  collection.overTime({title: 'Largest multiplier of each constraint', of: ({curves}) =>
      Object.entries(curves.constraint_multipliers ?? {}).map(([name, values]) => ({name, values}))});
  collection.overTime({title: 'Largest feedback gain', of: ({curves}) => [{name: 'max |K|', values: curves.gain ?? [], steps: true}]});
  addConvergence(collection);
  return collection.plots;
}

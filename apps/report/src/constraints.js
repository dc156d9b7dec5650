// Constraints: their violations, and their values between bounds.
import {figure, table} from './dom.js';

/// Minimum drawn violation, so that satisfied constraints also have a line.
const floor = 1e-16;

const curvesOf = solution => solution.curves.constraints ?? [];

/// The violation tolerance of the solver.
const toleranceOf = solution => solution.head.problem.options?.tolerances?.constraint ?? 1e-6;

function violationLines(solution) {
  const tolerance = toleranceOf(solution);
  return curvesOf(solution).map(({name, violation}) => ({
    name,
    values: violation.map(v => (v === null ? null : Math.max(v, floor))),
    violated: violation.map(v => v > tolerance),
    limit: {lower: null, upper: solution.curves.t.map(() => tolerance)},
  }));
}

/// The rows of a constraint; time-varying bounds are separate lines.
function rowLines(solution, constraint) {
  const tolerance = toleranceOf(solution);
  return constraint.rows.flatMap(({name, values, lower, upper}) => {
    const at = (bound, k) => (Array.isArray(bound) ? bound[k] : bound);
    const beyond = (v, k) => Math.max((at(lower, k) ?? -Infinity) - v, v - (at(upper, k) ?? Infinity));
    const fixed = !Array.isArray(lower) && !Array.isArray(upper);
    const line = {
      name, values,
      violated: values.map((v, k) => v !== null && beyond(v, k) > tolerance),
      clamped: values.map((v, k) => v !== null && Math.abs(beyond(v, k)) <= tolerance),
    };
    if (fixed) return [{...line, limit: {lower, upper}}];
    return [line, ...[['lower', lower], ['upper', upper]].filter(([, bound]) => bound !== null).map(
        ([side, bound]) => ({name: `${name}, ${side} bound`, values: values.map((v, k) => v === null ? null : at(bound, k))}))];
  });
}

/// A table with the values of constraints at a single node, which have no curve.
function momentTable(solutions) {
  const violated = [];
  const rows = solutions.flatMap(solution => curvesOf(solution).filter(c => c.nodes === 1).flatMap(c =>
      c.rows.map(row => {
        violated.push(c.violation[c.first] > toleranceOf(solution));
        const cells = [c.name, row.name === c.name ? '' : row.name, `${figure(solution.curves.t[c.first])} s`,
                       figure(row.lower), figure(row.values[c.first]), figure(row.upper)];
        return solutions.length > 1 ? [solution.label, ...cells] : cells;
      })));
  if (rows.length === 0) return null;
  const names = ['constraint', 'row', 'time', 'lower', 'value', 'upper'];
  return table('moments', solutions.length > 1 ? ['solution', ...names] : names, rows, i => violated[i]);
}

export function addConstraints(collection) {
  const {solutions} = collection;
  if (!solutions.some(s => curvesOf(s).length > 0)) return;
  collection.heading('Constraints');
  collection.overTime({
    title: 'Violation of each constraint',
    hint: `Logarithmic, at least ${floor}. Shaded: beyond the tolerance. Rings: violated.`,
    log: true,
    of: violationLines,
  });
  const names = new Set(solutions.flatMap(s => curvesOf(s).filter(c => c.nodes > 1).map(c => c.name)));
  for (const name of names) {
    const find = solution => curvesOf(solution).find(c => c.name === name && c.nodes > 1);
    const margin = solutions.some(s => find(s)?.margin);
    collection.overTime({
      title: name,
      hint: margin ? 'Distance from the nearest bound, negative outside. Rings: violated.'
                   : 'Shaded: outside the bounds. Thick: at a bound. Rings: violated.',
      of: solution => {
        const constraint = find(solution);
        return constraint ? rowLines(solution, constraint) : [];
      },
    });
  }
  const table = momentTable(solutions);
  if (table) collection.holder.append(table);
}

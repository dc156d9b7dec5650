// Convergence of the solver: the columns of its log over iterations, its stages, and the diagnosis of
// a success.
import {element} from './dom.js';
import {diagnoses} from './summary.js';

/// Iterations at which a homotopy advances, a restoration of feasibility begins, a solver updates
/// its multipliers, or Newton's method begins.
export function stageMarks(log) {
  const marks = [];
  log.forEach((row, i) => {
    if (i === 0) return;
    const before = log[i - 1];
    if (row.homotopy !== before.homotopy) marks.push({at: row.iteration, text: `s ${+row.homotopy.toFixed(3)}`});
    if (row.restoration > before.restoration) marks.push({at: row.iteration, text: 'restoration'});
    if (row.outer > before.outer) marks.push({at: row.iteration, text: String(row.outer)});
    if (row.newton > 0 && before.newton === 0) marks.push({at: row.iteration, text: 'Newton'});
  });
  return marks;
}

/// Lines of log columns: [name, column], or [name, column, true] without values that are not
/// positive.
const columns = (...list) => ({head}) => list.map(([name, key, positive]) => ({
  name,
  values: head.log.map(row => {
    const value = row[key] ?? null;
    return positive && !(value > 0) ? null : value;
  }),
}));

const used = key => ({head}) => head.log.some(row => row[key] > 0);

export function addConvergence(collection) {
  const {solutions} = collection;
  const staged = stageMarks(solutions[0].head.log).length > 0;
  collection.heading('Convergence');
  collection.holder.append(diagnoses(solutions, true) ?? '');
  if (staged)
    collection.holder.append(element('p', {class: 'hint'},
        'Upright lines: updates of the multipliers with their number, where Newton’s method begins, s of a homotopy, and restorations of feasibility' +
        (solutions.length > 1 ? ` (${solutions[0].label}).` : '.')));
  collection.overIterations({title: 'Cost and merit',
    of: columns(['cost', 'cost'], ['merit', 'merit'])});
  collection.overIterations({title: 'Residuals', log: true, hint: 'Logarithmic; zero is left out.',
    of: columns(['stationarity', 'stationarity', true], ['gap', 'gap', true],
                ['violation', 'constraint', true], ['complementarity', 'complementarity', true])});
  collection.overIterations({title: 'Step length', of: columns(['step', 'step'])});
  collection.overIterations({title: 'Regularization and penalties', log: true,
    hint: 'Logarithmic; zero is left out.',
    of: columns(['regularization', 'regularization', true], ['penalty of gaps', 'penalty', true],
                ['penalty of constraints', 'constraint_penalty', true])});
  collection.overIterations({title: 'Decrease of the merit', log: true,
    hint: 'Logarithmic; what is not a decrease is left out.',
    of: columns(['expected', 'expected_decrease', true], ['actual', 'actual_decrease', true])});
  const counts = [['clamped controls', 'clamped_controls'], ['changes of the active set', 'active_set_changes'],
                  ['active rows', 'active_rows']].filter(([, key]) => solutions.some(used(key)));
  collection.overIterations({title: 'Active set', of: columns(...counts)});
}

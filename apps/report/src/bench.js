// Measurements of `conddp bench` on the page's problems.
import {element, figure, table} from './dom.js';

const percent = share => (share === null || share === undefined ? '–' : `${figure(100 * share, 3)} %`);

function cellsOf(run) {
  const time = run.time_s ?? {}, residuals = run.residuals ?? {};
  const milliseconds = value => figure(value === undefined ? null : 1e3 * value, 3);
  return [run.problem, run.solver, run.seed ?? '', run.solved ? 'solved' : run.status, run.iterations,
          milliseconds(time.median), percent(time.spread), milliseconds(time.differentiate),
          milliseconds(time.sweep), milliseconds(time.rollout), figure(run.cost, 9), percent(run.cost_excess),
          ...['stationarity', 'gap', 'constraint'].map(name => figure(residuals[name], 2)),
          (run.dropped_constraints ?? []).map(c => c.name).join(', ')];
}

const solves = repeat => (repeat > 0 ? `Median of timed solves (${repeat}) after one to warm up` : 'One solve');

export function benchTable({machine, request, runs}) {
  const names = ['problem', 'solver', 'instance', 'end', 'iterations', 'time, ms', 'spread', 'differentiate',
                 'sweep', 'rollout', 'cost', 'above the best', 'stationarity', 'gap', 'violation', 'without'];
  const on = machine.processor ? ` on ${machine.processor}` : '';
  return element('div', {id: 'bench'}, element('h2', {}, 'Measured by bench'),
      element('p', {class: 'hint'}, `${solves(request.repeat)}${on}; every answer measured by the ` +
          'same check, from its trajectory alone.'),
      table(null, names, runs.map(cellsOf), i => !runs[i].solved && runs[i].status !== 'refused'));
}

// The parts of a closed loop's page besides the motion of its plant.
import {element, figure, table} from './dom.js';
import {histogram} from './histogram.js';

const fact = (name, value) => element('li', {}, `${name} `, element('b', {}, value));

export function writeLoopHead(holder, {head}, themeButton) {
  const {name} = head.problem;
  const failed = head.ticks - head.outcomes.planned;
  document.title = `${name} – conddp`;
  holder.append(themeButton, element('h1', {}, name),
      element('span', {class: `status ${head.end === 'finished' ? 'good' : ''}`, id: 'status'}, head.end),
      element('ul', {class: 'facts'},
          fact('closed loop until', `${figure(head.end_time_s, 4)} s`), fact('solver', head.solver),
          fact('clock', head.clock), fact('ticks', String(head.ticks)), fact('failed', String(failed)),
          fact('cost', figure(head.cost, 8)), fact('violation', figure(head.violation, 2))));
}

/// Outcomes and durations of the ticks.
export function loopSection({head}, {ticks}) {
  const known = list => list.filter(value => value !== null);
  const outcomes = Object.entries(head.outcomes).filter(([, count]) => count > 0);
  return element('section', {id: 'loop', 'aria-label': 'Ticks'}, element('h2', {}, 'Ticks'),
      table('outcomes', ['outcome', 'ticks'], outcomes),
      element('div', {class: 'side-by-side'},
          histogram('Preparation', 'ms', known(ticks.preparation_ms)),
          histogram('Feedback', 'ms', known(ticks.feedback_ms))));
}

/// Figures of the ticks over time.
export function addTicks(collection, {ticks}) {
  const plot = (title, unit, names, hint) => collection.add({
    title, unit, hint, xOf: () => ticks.t, xLabel: 'time', xUnit: 's', overTime: true,
    of: () => Object.entries(names).map(([name, key]) => ({name, values: ticks[key]})),
  });
  collection.heading('Ticks');
  plot('Cost of plans', '', {cost: 'cost'});
  plot('Violation and gap of plans', '', {violation: 'violation', gap: 'gap'});
  plot('Age of the plan in force', 's', {age: 'plan_age'}, 'Above 0 a tick has failed.');
  plot('Time of a tick', 'ms', {preparation: 'preparation_ms', feedback: 'feedback_ms'});
}

export function writeLoopFoot(holder, {head}) {
  const {problem, tool} = head;
  const rows = [['problem', `${problem.file} (SHA-256 ${problem.sha256})`],
                ['settings', problem.overrides.map(setting => `--set ${setting}`).join(' ')],
                ['conddp', `${tool.version}, revision ${tool.revision}${tool.modified ? ' with changes' : ''}`]];
  holder.append(element('h2', {}, 'To reproduce it'),
      table('reproduction', [], rows.filter(([, text]) => text !== '')),
      element('details', {}, element('summary', {}, 'The problem with every default'),
              element('pre', {}, JSON.stringify(problem.configuration, null, 2))));
}

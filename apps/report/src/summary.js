// What stands above and below motion and plots: results, diagnosis, certificate, how to reproduce.
import {element, figure} from './dom.js';

const fact = (name, value) => element('li', {}, `${name} `, element('b', {}, value));

export function writeHead(holder, solutions, themeButton) {
  const {head} = solutions[0];
  document.title = `${head.problem.name} – conddp`;
  holder.append(themeButton, element('h1', {}, head.problem.name));
  if (solutions.length === 1) {
    const good = head.status === 'converged';
    holder.append(element('span', {class: `status ${good ? 'good' : ''}`, id: 'status'}, head.status));
    const r = head.residuals;
    holder.append(element('ul', {class: 'facts'},
        fact('solver', head.solver), fact('cost', figure(head.cost, 8)),
        fact('iterations', String(head.iterations)),
        fact('time', `${figure(head.time_s.total, 3)} s`),
        fact('stationarity', figure(r.stationarity, 2)), fact('gap', figure(r.gap, 2)),
        fact('violation', figure(r.constraint, 2)),
        fact('motion', `${figure(head.problem.duration_s, 4)} s in ${head.problem.knots} knots`)));
  }
  for (const {label, remark} of solutions)
    if (remark) holder.append(element('p', {class: 'remark'}, `${label}: ${remark}`));
  if (solutions.length === 1 && head.message)
    holder.append(element('p', {id: 'message'}, head.message));
}

/// One row a solution, with switches for their lines and robots.
export function comparisonTable(solutions, changeVisible) {
  const visible = solutions.map(() => true);
  const names = ['', 'solution', 'solver', 'status', 'cost', 'iterations', 'time, s', 'differentiate',
                 'sweep', 'rollout', 'stationarity', 'gap', 'violation'];
  const rows = solutions.map(({label, head}, i) => {
    const box = element('input', {type: 'checkbox', 'aria-label': `Show ${label}`, onchange: () => {
      visible[i] = box.checked;
      changeVisible(visible);
    }});
    box.checked = true;
    const t = head.time_s, r = head.residuals;
    const cells = [label, head.solver, head.status, figure(head.cost, 9), head.iterations,
                   figure(t.total, 3), figure(t.differentiate, 3), figure(t.sweep, 3),
                   figure(t.rollout, 3), figure(r.stationarity, 2), figure(r.gap, 2),
                   figure(r.constraint, 2)];
    return element('tr', {}, element('td', {}, box), ...cells.map(c => element('td', {}, String(c))));
  });
  return element('div', {class: 'wide'}, element('table', {id: 'comparison'},
      element('thead', {}, element('tr', {}, ...names.map(n => element('th', {}, n)))),
      element('tbody', {}, ...rows)));
}

/// Any value as nested lists of keys and values.
function tree(value) {
  if (value === null || typeof value !== 'object') return document.createTextNode(String(value ?? '–'));
  const entries = Object.entries(value);
  return element('table', {}, element('tbody', {}, ...entries.map(([key, part]) =>
      element('tr', {}, element('th', {}, key), element('td', {}, tree(part))))));
}

function block(title, id, value) {
  if (value === undefined || value === null) return null;
  const content = typeof value === 'string' ? element('p', {}, value) : tree(value);
  return element('div', {}, element('h2', {}, title), element('div', {class: 'wide', id}, content));
}

export function writeFoot(holder, solutions) {
  for (const {label, head} of solutions) {
    if (solutions.length > 1) holder.append(element('h2', {}, label));
    for (const part of [block('Diagnosis', 'diagnosis', head.diagnosis),
                        block('Certificate', 'certificate', head.certificate)])
      if (part) holder.append(part);
    const {configuration, options, ...problem} = head.problem;
    holder.append(element('h2', {}, 'To reproduce it'),
        element('div', {class: 'wide'}, tree({problem, tool: head.tool, guess: head.initial_guess_used})),
        element('details', {}, element('summary', {}, 'The problem with every default'),
                element('pre', {}, JSON.stringify(configuration, null, 2))));
  }
  holder.append(element('p', {class: 'keys'}, 'Keys: ', element('kbd', {}, 'space'), ' play or pause, ',
      element('kbd', {}, '←'), ' ', element('kbd', {}, '→'), ' knot by knot, ', element('kbd', {}, 'Home'),
      ' ', element('kbd', {}, 'End'), ', ', element('kbd', {}, '['), ' ', element('kbd', {}, ']'),
      ' speed, ', element('kbd', {}, 'F'), ' follow, ', element('kbd', {}, 'D'), ' dark or light.'));
}

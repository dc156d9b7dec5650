// The parts above and below motion and plots: results, diagnosis, certificate, reproduction.
import {element, figure, table} from './dom.js';

const fact = (name, value) => element('li', {}, `${name} `, element('b', {}, value));

const isGood = ({head}) => head.status === 'converged' || head.status === 'cost_settled';

/// What the solver's log says about solutions that succeeded or failed, and what to try.
export function diagnoses(solutions, succeeded) {
  const said = solutions.filter(solution => isGood(solution) === succeeded && solution.head.diagnosis?.message);
  if (said.length === 0) return null;
  return element('div', {class: 'diagnosis'}, ...said.map(({label, head}) => {
    const sentences = [head.diagnosis.message, head.diagnosis.remedy].filter(part => part)
        .map(part => `${part[0].toUpperCase()}${part.slice(1)}.`);
    return element('p', {}, solutions.length > 1 ? element('b', {}, `${label}: `) : null, sentences.join(' '));
  }));
}

/// `batch`: the name of the batch that contains the solutions, if any.
export function writeHead(holder, batch, solutions, themeButton) {
  const name = batch ?? solutions[0].head.problem.name;
  document.title = `${name} – conddp`;
  holder.append(themeButton, element('h1', {}, name));
  const {head} = solutions.length === 1 && batch === undefined ? solutions[0] : {};
  if (head) {
    const good = isGood(solutions[0]) ? 'good' : '';
    holder.append(element('span', {class: `status ${good}`, id: 'status'}, head.status));
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
  if (head?.message)
    holder.append(element('p', {id: 'message'}, head.message));
  holder.append(diagnoses(solutions, false) ?? '');
}

/// One row per solution, with switches for their lines and robots.
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
    return [box, ...cells];
  });
  return table('comparison', names, rows);
}

/// The checks of an answer, without passed checks that have no figures.
function certificate({checks, holds}) {
  const shown = checks.filter(check => !check.holds || (check.claimed ?? check.found ?? null) !== null);
  const failed = checks.filter(check => !check.holds).length;
  const text = holds ? `All ${checks.length} statements of the answer hold, evaluated by code that no solver uses.`
                     : `${failed} of ${checks.length} statements of the answer do not hold.`;
  return element('div', {id: 'certificate'}, element('h2', {}, 'Certificate'), element('p', {}, text),
      table(null, ['statement', 'claimed', 'found', 'tolerance', 'where', ''],
            shown.map(c => [c.name, figure(c.claimed, 9), figure(c.found, 9), figure(c.tolerance, 2), c.place,
                            c.holds ? 'holds' : c.message || 'does not hold']),
            i => !shown[i].holds));
}

/// Notable properties of the motion, even if its problem does not mention them.
function findings(list) {
  return element('div', {id: 'findings'}, element('h2', {}, 'Findings'),
      table(null, ['what', 'where', 'try'],
            list.map(f => [f.message, f.knot === undefined ? '' : `knot ${f.knot}, ${figure(f.time_s, 3)} s`, f.remedy ?? ''])));
}

/// Links that are not drawn by their visual shapes, with the reasons: a line, and a table with the
/// files.
export function standIns(solutions) {
  const list = solutions.find(s => s.scene)?.scene.stand_ins ?? [];
  if (list.length === 0) return null;
  const groups = new Map();
  for (const {link, drawn_by, reasons} of list) {
    const key = `${drawn_by} (${[...new Set(reasons.map(r => r.why))].join(', ')})`;
    groups.set(key, [...(groups.get(key) ?? []), link]);
  }
  const line = [...groups].map(([key, links]) => `${links.join(', ')} – ${key}`).join('; ');
  return element('details', {id: 'stand-ins'}, element('summary', {}, `Drawn by stand-ins: ${line}`),
      table(null, ['link', 'drawn by', 'why'], list.map(({link, drawn_by, reasons}) =>
          [link, drawn_by, reasons.map(({why, what}) => (what ? `${why}: ${what}` : why)).join('; ')])));
}

const listed = object => Object.entries(object ?? {}).map(([name, value]) => `${name} ${value}`).join(', ');

/// Information for reproducing the answer: rows of names and texts.
function reproduction({problem, tool, solver, initial_guess_used: guess, dropped_constraints: dropped = []}) {
  const file = ({file: name, sha256}) => `${name} (SHA-256 ${sha256})`;
  const settings = [...(problem.overrides ?? []).map(setting => `--set ${setting}`), ...dropped.map(c => `--drop ${c.name}`)];
  return [
    ['problem', file(problem)],
    ...(problem.robots ?? []).map(robot => ['robot', file(robot)]),
    ...(problem.data_files ?? []).map(data => ['data', file(data)]),
    ['settings', settings.join(' ')],
    ['solver', solver],
    ['first guess', `states: ${guess.states}; controls: ${guess.controls}; used: ${guess.used}`],
    ['random seed', guess.seed],
    ['conddp', `${tool.version}, revision ${tool.revision}${tool.modified ? ' with changes' : ''}`],
    ['build', listed(tool.build)],
    ['libraries', listed(tool.libraries)],
  ].filter(([, text]) => text !== '' && text !== null && text !== undefined);
}

export function writeFoot(holder, solutions) {
  if (solutions.length === 0) return;
  for (const {label, head} of solutions) {
    if (solutions.length > 1) holder.append(element('h2', {}, label));
    if (head.findings?.length) holder.append(findings(head.findings));
    if (head.certificate?.checks) holder.append(certificate(head.certificate));
    holder.append(element('h2', {}, 'To reproduce it'),
        table('reproduction', [], reproduction(head).map(([name, text]) => [element('b', {}, name), text])),
        element('details', {}, element('summary', {}, 'The problem with every default'),
                element('pre', {}, JSON.stringify(head.problem.configuration, null, 2))));
  }
  holder.append(element('p', {class: 'keys'}, 'Keys: ', element('kbd', {}, 'space'), ' play or pause, ',
      element('kbd', {}, '←'), ' ', element('kbd', {}, '→'), ' knot by knot, ', element('kbd', {}, 'Home'),
      ' ', element('kbd', {}, 'End'), ', ', element('kbd', {}, '['), ' ', element('kbd', {}, ']'),
      ' speed, ', element('kbd', {}, 'F'), ' follow, ', element('kbd', {}, 'D'), ' dark or light.'));
}

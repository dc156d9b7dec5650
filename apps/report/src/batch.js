// A run of `conddp batch`: counts of the items by status, and the items that stand out.
import {batchMap, titleOf} from './batch_map.js';
import {element, figure, table} from './dom.js';
import {histogram} from './histogram.js';
import {overlay} from './overlay.js';

const percent = (part, all) => (all > 0 ? `${figure(100 * part / all, 3)} %` : '–');

function counts(batch) {
  return table('batch-status', ['status', 'items', 'share'],
      batch.by_status.map(({status, count}) => [status, count, percent(count, batch.items)]));
}

/// Links to the files of an item, which are in the folder of the page.
const links = ({files}) => element('span', {}, ...(files ?? []).flatMap((file, i) =>
    [i > 0 ? ' ' : '', element('a', {href: file}, file.slice(file.lastIndexOf('/') + 1))]));

function outstanding(batch, {title, items}) {
  if (items.length === 0) return null;
  const reasons = items.some(item => item.message), files = items.some(item => item.files?.length);
  const rows = items.map(item => [item.item, item.id, item.status, ...item.figures.map(v => figure(v, 6)),
      ...item.values.map(v => (typeof v === 'number' ? figure(v) : v)),
      ...(reasons ? [item.message] : []), ...(files ? [links(item)] : [])]);
  const names = ['item', 'id', 'status', ...batch.figures.map(titleOf), ...batch.columns.map(c => c.name),
                 ...(reasons ? ['message'] : []), ...(files ? ['files'] : [])];
  return element('section', {}, element('h2', {}, title), table(null, names, rows));
}

const capital = text => text[0].toUpperCase() + text.slice(1);

function distributions({rows, figures}) {
  const solved = rows.solved.map((is, i) => (is ? i : -1)).filter(i => i >= 0);
  const of = values => solved.map(i => values[i]).filter(v => v !== null);
  return element('div', {class: 'side-by-side'},
      ...figures.map(({key, title, unit}) => histogram(capital(title), unit, of(rows[key]))));
}

export function batchSection(batch) {
  const {items, solved, every, success_word: word} = batch;
  return element('section', {id: 'batch', 'aria-label': 'Batch'},
      element('p', {}, `${solved} of ${items} items ${word === 'solved' ? 'are ' : ''}${word} (${percent(solved, items)}).`),
      counts(batch),
      every > 1 ? element('p', {class: 'hint'}, `Maps and distributions show one item of ${every}.`) : null,
      batchMap(batch), element('h2', {}, `Items that ${word === 'solved' ? 'are ' : ''}${word}`), distributions(batch), overlay(batch.trajectories),
      ...batch.lists.map(list => outstanding(batch, list)));
}

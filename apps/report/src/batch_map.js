// Results over two of the varied values.
import {choice, element, figure, shape} from './dom.js';
import {mix} from './palette.js';

/// With more values, cells are shared.
const mostCells = 30;
const cell = 34, left = 84, bottom = 46, top = 8;

const median = list => {
  const sorted = list.filter(v => v !== null).sort((a, b) => a - b);
  return sorted.length === 0 ? null : sorted[sorted.length >> 1];
};
const solvedOnly = (rows, items) => items.filter(i => rows.solved[i]);

/// A figure of items, with its unit.
export const titleOf = ({title, unit}) => (unit ? `${title}, ${unit}` : title);

/// Measures of a cell's items.
const measuresOf = ({success_word: word, figures}) => [
  {name: `share ${word}`, of: (rows, items) => solvedOnly(rows, items).length / items.length, range: [0, 1]},
  ...figures.map(f => ({name: `median ${titleOf(f)}`,
                        of: (rows, items) => median(solvedOnly(rows, items).map(i => rows[f.key][i]))})),
];

const label = value => (typeof value === 'number' ? figure(value, 4) : String(value));

/// The cells of one axis: their names, and the cell of each item.
function axisOf(values) {
  const distinct = [...new Set(values)];
  const numeric = distinct.every(v => typeof v === 'number');
  if (numeric) distinct.sort((a, b) => a - b);
  if (distinct.length <= mostCells) {
    const place = new Map(distinct.map((value, i) => [value, i]));
    return {names: distinct.map(label), places: values.map(v => place.get(v))};
  }
  if (!numeric) {
    const place = new Map(distinct.map((value, i) => [value, Math.min(i, mostCells - 1)]));
    return {names: [...distinct.slice(0, mostCells - 1).map(label), 'others'], places: values.map(v => place.get(v))};
  }
  const [low, high] = [distinct[0], distinct[distinct.length - 1]], count = 20;
  const step = (high - low) / count;
  return {names: Array.from({length: count}, (_, i) => `${figure(low + i * step, 3)} …`),
          places: values.map(v => Math.min(count - 1, Math.floor((v - low) / step)))};
}

/// The items with a result in each cell, by "column row".
function groups(rows, x, y) {
  const cells = new Map();
  x.places.forEach((column, i) => {
    if (rows.solved[i] === null) return;
    const key = `${column} ${y.places[i]}`;
    if (!cells.has(key)) cells.set(key, []);
    cells.get(key).push(i);
  });
  return cells;
}

function rangeOf(values) {
  const known = values.filter(v => v !== null);
  return [Math.min(...known), Math.max(...known)];
}

function drawCells(rows, x, y, measure, word) {
  const cells = [...groups(rows, x, y)].map(([key, items]) => ({key, items, value: measure.of(rows, items)}));
  const [low, high] = measure.range ?? rangeOf(cells.map(c => c.value));
  return cells.map(({key, items, value}) => {
    const [column, row] = key.split(' ').map(Number);
    const at = {x: left + column * cell, y: top + (y.names.length - 1 - row) * cell};
    const share = value === null ? null : high > low ? (value - low) / (high - low) : 1;
    const text = shape('text', {x: at.x + cell / 2, y: at.y + cell / 2 + 4, 'text-anchor': 'middle',
                                fill: share !== null && share > 0.45 ? '#ffffff' : '#1c2127'},
                       value === null ? '–' : figure(value, 2));
    const title = shape('title', {}, `${x.names[column]}, ${y.names[row]}: ${measure.name} ` +
        `${figure(value)}, ${solvedOnly(rows, items).length} of ${items.length} ${word}`);
    return shape('g', {class: 'cell', 'data-column': column, 'data-row': row, 'data-value': value},
        shape('rect', {...at, width: cell - 1, height: cell - 1, fill: share === null ? '#d5dae0' : mix(share)}),
        text, title);
  });
}

function draw(batch, chosen) {
  const {rows} = batch, one = batch.columns.length === 1;
  const x = axisOf(rows.values[chosen.x]);
  const y = one ? {names: [''], places: x.places.map(() => 0)} : axisOf(rows.values[chosen.y]);
  const width = left + x.names.length * cell + 10, height = top + y.names.length * cell + bottom;
  const names = [
    ...x.names.map((name, i) => shape('text', {x: left + (i + 0.5) * cell, y: height - bottom + 14, 'text-anchor': 'end',
        transform: `rotate(-35 ${left + (i + 0.5) * cell} ${height - bottom + 14})`, fill: 'currentColor'}, name)),
    ...y.names.map((name, i) => shape('text', {x: left - 6, y: top + (y.names.length - i - 0.5) * cell + 4,
        'text-anchor': 'end', fill: 'currentColor'}, name)),
  ];
  return shape('svg', {width, height, viewBox: `0 0 ${width} ${height}`, role: 'img'},
      ...drawCells(rows, x, y, measuresOf(batch)[chosen.measure], batch.success_word), ...names);
}

export function batchMap(batch) {
  const names = batch.columns.map(c => c.name);
  if (names.length === 0) return null;
  // Values that vary are more informative than the seeds of random starts.
  const chosen = {x: 0, y: Math.min(1, names.length - 1), measure: 0};
  const picture = element('div', {class: 'wide'});
  const show = change => {
    Object.assign(chosen, change);
    picture.replaceChildren(draw(batch, chosen));
  };
  show({});
  return element('section', {id: 'batch-map'}, element('h2', {}, 'Over what was varied'),
      element('p', {class: 'choices'}, choice('Show', measuresOf(batch).map(m => m.name), 0, measure => show({measure})),
              choice('across', names, chosen.x, x => show({x})),
              names.length > 1 ? choice('upwards', names, chosen.y, y => show({y})) : null),
      picture);
}

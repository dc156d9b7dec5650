// One column of many trajectories overlaid, colored by their cost.
import {choice, element, figure, shape} from './dom.js';
import {mix} from './palette.js';

const width = 720, height = 260, left = 60, bottom = 24, top = 8;

function extent(lists) {
  let low = Infinity, high = -Infinity;
  for (const list of lists)
    for (const value of list) {
      if (value === null) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  return high > low ? [low, high] : [low - 1, high + 1];
}

function draw({lines, columns, units}, column) {
  const [t0, t1] = extent(lines.map(l => l.t)), [low, high] = extent(lines.map(l => l.values[column]));
  const costs = lines.map(l => l.cost).filter(c => c !== null);
  const [least, most] = extent([costs]);
  const x = t => left + (width - left - 8) * (t - t0) / (t1 - t0);
  const y = v => top + (height - bottom - top) * (high - v) / (high - low);
  const text = (at, anchor, words) => shape('text', {...at, 'text-anchor': anchor, fill: 'currentColor'}, words);
  const unit = units[column] === '1' ? '' : ` ${units[column]}`;
  return shape('svg', {width, height, viewBox: `0 0 ${width} ${height}`, role: 'img'},
      ...lines.map(({item, cost, t, values}) => shape('polyline', {
        class: 'trajectory', fill: 'none', 'stroke-width': 1.2, 'stroke-opacity': 0.75,
        stroke: cost === null ? '#7f7f7f' : mix(0.15 + 0.85 * (cost - least) / (most - least)),
        points: t.map((time, k) => (values[column][k] === null ? '' : `${x(time).toFixed(1)},${y(values[column][k]).toFixed(1)}`)).join(' '),
      }, shape('title', {}, `item ${item}, cost ${figure(cost, 6)}`))),
      text({x: left - 6, y: top + 10}, 'end', figure(high, 4)), text({x: left - 6, y: height - bottom}, 'end', figure(low, 4)),
      text({x: left, y: height - 6}, 'start', `${figure(t0, 3)} s`), text({x: width - 8, y: height - 6}, 'end', `${figure(t1, 3)} s`),
      text({x: left + 8, y: top + 10}, 'start', `${columns[column]}${unit}`));
}

export function overlay(trajectories) {
  if (!trajectories) return null;
  const picture = element('div', {class: 'wide'});
  const show = column => picture.replaceChildren(draw(trajectories, column));
  show(0);
  return element('section', {id: 'overlay'}, element('h2', {}, 'Trajectories'),
      element('p', {class: 'choices'}, choice('Column', trajectories.columns, 0, show)),
      element('p', {class: 'hint'}, `${trajectories.lines.length} items, spread over all; the darker, the higher their cost.`), picture);
}

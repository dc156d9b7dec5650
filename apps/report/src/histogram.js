// Histograms of values.
import {element, figure, shape} from './dom.js';

const width = 320, height = 130, bottom = 20, bars = 24;

/// Numbers over several powers of ten are counted by their logarithm.
function scaleOf(low, high) {
  return low > 0 && high > 100 * low ? {to: Math.log10, from: v => 10 ** v} : {to: v => v, from: v => v};
}

/// The number of values in each bar.
export function binned(values) {
  const low = Math.min(...values), high = Math.max(...values), scale = scaleOf(low, high);
  const first = scale.to(low), step = (scale.to(high) - first) / bars;
  const heights = Array(bars).fill(0);
  for (const value of values)
    ++heights[step > 0 ? Math.min(bars - 1, Math.floor((scale.to(value) - first) / step)) : 0];
  return {heights, edges: heights.map((_, i) => scale.from(first + i * step)), low, high};
}

export function histogram(title, unit, values) {
  if (values.length === 0) return null;
  const {heights, edges, low, high} = binned(values);
  const most = Math.max(...heights), bar = width / bars;
  const label = (x, anchor, value) => shape('text', {x, y: height - 5, 'text-anchor': anchor, fill: 'currentColor'}, figure(value, 4));
  const sorted = [...values].sort((a, b) => a - b);
  return element('figure', {class: 'histogram'},
      element('figcaption', {}, `${title}${unit ? ` [${unit}]` : ''}`),
      element('div', {class: 'hint'}, `median ${figure(sorted[sorted.length >> 1])}, ` +
          `95 % below ${figure(sorted[Math.ceil(0.95 * sorted.length) - 1])}`),
      shape('svg', {width, height, viewBox: `0 0 ${width} ${height}`, role: 'img'},
          ...heights.map((count, i) => {
            const size = (height - bottom - 4) * count / most;
            return shape('rect', {x: i * bar, y: height - bottom - size, width: bar - 1, height: size, fill: '#0072b2'},
                shape('title', {}, `from ${figure(edges[i])}: ${count}`));
          }),
          label(0, 'start', low), label(width, 'end', high)));
}

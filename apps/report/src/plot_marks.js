// Drawings in a plot besides its lines: limits, values at and beyond them, stages.
import {color} from './dom.js';

/// Clips drawing to the plot area.
function inside(u, draw) {
  const {ctx, bbox} = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  draw(ctx, bbox);
  ctx.restore();
}

/// Shades the area outside the limits of all visible lines.
export const shadeLimits = (u, limits) => inside(u, (ctx, bbox) => {
  const shown = limits.filter((limit, i) => limit && u.series[i + 1].show);
  const bottoms = shown.map(l => l.lower).filter(x => x !== null);
  const tops = shown.map(l => l.upper).filter(x => x !== null);
  ctx.fillStyle = color('grid');
  if (bottoms.length === shown.length && bottoms.length > 0) {
    const y = u.valToPos(Math.min(...bottoms), 'y', true);
    ctx.fillRect(bbox.left, y, bbox.width, bbox.top + bbox.height - y);
  }
  if (tops.length === shown.length && tops.length > 0) {
    const y = u.valToPos(Math.max(...tops), 'y', true);
    ctx.fillRect(bbox.left, bbox.top, bbox.width, y - bbox.top);
  }
  ctx.strokeStyle = color('faint');
  ctx.setLineDash([4, 4]);
  ctx.lineWidth = 1;
  for (const value of new Set([...bottoms, ...tops])) {
    const y = u.valToPos(value, 'y', true);
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
  }
});

/// Draws intervals with a value at its limit as thick lines.
export const markClamped = (u, lines) => inside(u, ctx => {
  const [x] = u.data;
  ctx.lineCap = 'round';
  lines.forEach((line, i) => {
    if (!line.clamped || !u.series[i + 1].show) return;
    ctx.strokeStyle = line.color;
    ctx.lineWidth = 5 * devicePixelRatio;
    const values = u.data[i + 1];
    line.clamped.forEach((at, k) => {
      const y = values[k];
      if (!at || y === null || y === undefined) return;
      // Controls are constant until the next node; other values are at a limit between two nodes at
      // the limit.
      let end = k + 1;
      while (end < x.length && values[end] === undefined) ++end;
      if (end >= x.length || !(line.steps || line.clamped[end])) end = k;
      ctx.beginPath();
      ctx.moveTo(u.valToPos(x[k], 'x', true), u.valToPos(y, 'y', true));
      ctx.lineTo(u.valToPos(x[end], 'x', true), u.valToPos(y, 'y', true));
      ctx.stroke();
    });
  });
});

/// Draws rings around values that violate a constraint.
export const markViolated = (u, lines) => inside(u, ctx => {
  ctx.strokeStyle = color('bad');
  ctx.lineWidth = 1.5 * devicePixelRatio;
  lines.forEach((line, i) => {
    if (!line.violated || !u.series[i + 1].show) return;
    line.violated.forEach((bad, k) => {
      const y = u.data[i + 1][k];
      if (!bad || y === null || y === undefined) return;
      ctx.beginPath();
      ctx.arc(u.valToPos(u.data[0][k], 'x', true), u.valToPos(y, 'y', true), 4 * devicePixelRatio, 0, 2 * Math.PI);
      ctx.stroke();
    });
  });
});

/// Draws labeled vertical lines at the beginnings of solver stages.
export function drawMarks({ctx, bbox, valToPos}, marks) {
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = color('faint');
  ctx.font = `${11 * devicePixelRatio}px system-ui`;
  ctx.textAlign = 'center';
  let free = -Infinity;  // end of the last label
  for (const {at, text} of marks) {
    const x = valToPos(at, 'x', true);
    if (x < bbox.left || x > bbox.left + bbox.width) continue;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    const half = ctx.measureText(text).width / 2;
    if (x - half < free) continue;
    ctx.fillText(text, x, bbox.top - 3 * devicePixelRatio);
    free = x + half + 4;
  }
  ctx.restore();
}

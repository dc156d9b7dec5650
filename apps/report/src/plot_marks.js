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

const isNumber = value => value !== null && value !== undefined;

/// A line's lower or upper limit at each point of the axis; null where it has none. A limit that is
/// one number holds where the line has values.
function courseOf(u, i, limit) {
  if (Array.isArray(limit)) return u.data[0].map((_, k) => limit[k] ?? null);
  return u.data[i + 1].map(value => (isNumber(value) ? limit ?? null : null));
}

/// The weakest of the lines' limits at each point; null where a line has values but no limit.
function weakest(u, indices, courses, upper) {
  return u.data[0].map((_, k) => {
    const here = indices.map((_, c) => c).filter(c => isNumber(courses[c][k]) || isNumber(u.data[indices[c] + 1][k]))
        .map(c => courses[c][k]);
    if (here.length === 0 || here.includes(null)) return null;
    return upper ? Math.max(...here) : Math.min(...here);
  });
}

/// Calls draw(left, right, y) for each interval with the same value, in pixels. A value at a single
/// point is drawn around it. `steps`: values hold until the next point.
function forRuns(u, values, steps, draw) {
  const x = u.data[0], at = k => u.valToPos(x[k], 'x', true);
  for (let k = 0; k < x.length; ++k) {
    if (values[k] === null) continue;
    let last = k;
    while (last + 1 < x.length && values[last + 1] === values[k]) ++last;
    const end = steps ? Math.min(last + 1, x.length - 1) : last;
    const half = end > k ? 0 : 3 * devicePixelRatio;
    draw(at(k) - half, at(end) + half, u.valToPos(values[k], 'y', true));
    k = last;
  }
}

/// Shades the area outside the limits of all visible lines, where and when they hold.
export const shadeLimits = (u, lines) => inside(u, (ctx, bbox) => {
  const indices = [...lines.keys()].filter(i => lines[i].limit && u.series[i + 1].show);
  for (const side of ['lower', 'upper']) {
    const courses = indices.map(i => courseOf(u, i, lines[i].limit[side]));
    const edge = side === 'upper' ? bbox.top : bbox.top + bbox.height;
    const steps = indices.some(i => lines[i].steps);
    ctx.fillStyle = color('grid');
    forRuns(u, weakest(u, indices, courses, side === 'upper'), steps,
            (left, right, y) => ctx.fillRect(left, Math.min(y, edge), right - left, Math.abs(edge - y)));
    ctx.strokeStyle = color('faint');
    ctx.setLineDash([4, 4]);
    ctx.lineWidth = 1;
    for (const course of courses)
      forRuns(u, course, steps, (left, right, y) => {
        ctx.beginPath();
        ctx.moveTo(left, y);
        ctx.lineTo(right, y);
        ctx.stroke();
      });
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

// Okabe and Ito's colors, distinguishable with any color vision. Lines beyond the last color are
// also dashed.
const colors = ['#0072b2', '#e69f00', '#009e73', '#d55e00', '#56b4e9', '#cc79a7', '#8f8a00', '#7f7f7f'];
const dashes = [[], [7, 4], [2, 3], [9, 3, 2, 3]];

export const lineColor = i => colors[i % colors.length];
export const lineDash = i => dashes[Math.floor(i / colors.length) % dashes.length];
/// Dashes for the lines of one solution among others.
export const solutionDash = i => dashes[i % dashes.length];

const pale = [222, 235, 247], deep = [8, 69, 130];
/// From pale to deep blue, for a share from 0 to 1.
export const mix = share => `rgb(${pale.map((p, i) => Math.round(p + share * (deep[i] - p))).join(' ')})`;

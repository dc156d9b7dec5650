// The report's data and derived quantities without drawing.

export function readData() {
  const data = JSON.parse(document.getElementById('report-data').textContent);
  for (const solution of data.solutions) prepare(solution);
  return data;
}

function prepare(solution) {
  const t = solution.curves.t;
  solution.duration = t[t.length - 1] - t[0];
  const forces = solution.curves.contact_forces ?? {};
  const contacts = solution.scene?.contacts ?? [];
  solution.contacts = Object.keys(forces).map(name => {
    const contact = contacts.find(c => c.name === name) ?? null;
    return {name, contact, forces: forces[name]};
  });
  for (const constraint of solution.curves.constraints ?? []) spread(constraint, t.length);
}

/// Expands the lists of a constraint to all nodes.
function spread(constraint, nodes) {
  const {first, violation, rows} = constraint;
  const over = list => Array(first).fill(null).concat(list, Array(nodes - first - list.length).fill(null));
  constraint.nodes = violation.filter(v => v !== null).length;
  constraint.violation = over(violation);
  for (const row of rows)
    for (const key of ['values', 'lower', 'upper'])
      if (Array.isArray(row[key])) row[key] = over(row[key]);
}

/// The last node at or before a time, and the relative position to the next one (0 to 1). At an
/// impulse, with nodes at the same time, the last of these nodes.
export function nodeAt(t, time) {
  let low = 0, high = t.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (t[middle] <= time) low = middle;
    else high = middle - 1;
  }
  if (low === t.length - 1) return {k: low, share: 0};
  const step = t[low + 1] - t[low];
  return {k: low, share: step > 0 ? Math.min(1, Math.max(0, (time - t[low]) / step)) : 0};
}

export const phaseAt = (solution, k) =>
    solution.curves.phases.find(p => k >= p.first_knot && k < p.first_knot + p.knots) ??
    solution.curves.phases[solution.curves.phases.length - 1];

/// The state at whose configuration the force of a knot acts on a contact.
export const forceNode = (contact, k) => k + contact.acts_after;

/// Normal force and used share of the friction cone, for a contact at a knot.
export function forceParts(entry, k) {
  const f = entry.forces[k];
  if (!f || f[0] === null) return null;
  if (!entry.contact) return {normal: null, use: null, force: f};
  const at = 3 * forceNode(entry.contact, k);
  const n = entry.contact.normals.slice(at, at + 3);
  const normal = f[0] * n[0] + f[1] * n[1] + f[2] * n[2];
  const tangential = Math.hypot(f[0] - normal * n[0], f[1] - normal * n[1], f[2] - normal * n[2]);
  const limit = entry.contact.friction * normal;
  return {normal, use: limit > 1e-9 ? tangential / limit : null, force: f};
}

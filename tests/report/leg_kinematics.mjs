// Foot positions from the text of a URDF: kinematics independent of the tool’s.

/// Joints and fixed placements from the base to a link, read from the text of a URDF.
export function legChain(urdf, link) {
  const chain = [];
  while (true) {
    const joint = [...urdf.matchAll(/<joint name="([^"]+)" type="([^"]+)">([\s\S]*?)<\/joint>/g)].find(
        ([, , , body]) => body.includes(`<child link="${link}"`));
    if (!joint) return chain;
    const [, name, type, body] = joint;
    const numbers = (tag, attribute, otherwise) => {
      const found = body.match(new RegExp(`<${tag}[^>]*${attribute}="([^"]+)"`));
      return found ? found[1].split(/\s+/).map(Number) : otherwise;
    };
    chain.unshift({name, type, xyz: numbers('origin', 'xyz', [0, 0, 0]), rpy: numbers('origin', 'rpy', [0, 0, 0]),
                   axis: numbers('axis', 'xyz', [1, 0, 0])});
    link = body.match(/<parent link="([^"]+)"/)[1];
  }
}

function rotation([x, y, z, w]) {
  return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
          [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
          [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]];
}

const about = (axis, angle) => {
  const s = Math.sin(angle / 2) / Math.hypot(...axis);
  return rotation([...axis.map(a => a * s), Math.cos(angle / 2)]);
};
const times = (A, B) => A.map(row => B[0].map((_, j) => row.reduce((sum, a, i) => sum + a * B[i][j], 0)));
const turn = (A, v) => A.map(row => row.reduce((sum, a, i) => sum + a * v[i], 0));

export function footPosition(chain, value) {
  let R = rotation(['qx', 'qy', 'qz', 'qw'].map(c => value(`base/${c}`)));
  let p = ['x', 'y', 'z'].map(c => value(`base/${c}`));
  for (const {name, type, xyz, rpy, axis} of chain) {
    p = turn(R, xyz).map((d, i) => d + p[i]);
    for (const [unit, angle] of [[[0, 0, 1], rpy[2]], [[0, 1, 0], rpy[1]], [[1, 0, 0], rpy[0]]])
      R = times(R, about(unit, angle));
    if (type !== 'fixed') R = times(R, about(axis, value(`q/${name}`)));
  }
  return p;
}

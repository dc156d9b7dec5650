// Obstacles of a motion, and bounds on positions.
import * as THREE from 'three';
import {ConvexGeometry} from 'three/examples/jsm/geometries/ConvexGeometry.js';
import {mergeGeometries} from 'three/examples/jsm/utils/BufferGeometryUtils.js';

const outsideColor = '#d55e00', insideColor = '#56b4e9', terrainColor = '#b9a77c', sceneryColor = '#9aa3ad';
const up = new THREE.Vector3(0, 0, 1), along = new THREE.Vector3(0, 1, 0);

const vector = numbers => new THREE.Vector3(...numbers);

/// A convex body, also a robot's: sphere, capsule, or the hull of points.
export function convexForm(shape) {
  if (shape.kind === 'hull') return new ConvexGeometry(shape.points.map(vector));
  if (shape.kind === 'sphere')
    return new THREE.SphereGeometry(shape.radius, 28, 18).translate(...shape.center);
  const from = vector(shape.from), to = vector(shape.to), way = to.clone().sub(from);
  const turn = new THREE.Quaternion().setFromUnitVectors(along, way.clone().normalize());
  const middle = from.add(to).multiplyScalar(0.5);
  return new THREE.CapsuleGeometry(shape.radius, way.length(), 8, 24).applyQuaternion(turn)
      .translate(middle.x, middle.y, middle.z);
}

/// The ground: opaque, so that feet inside it are hidden.
function ground() {
  return new THREE.MeshStandardMaterial({color: terrainColor, side: THREE.DoubleSide, roughness: 1,
                                         flatShading: true});
}

/// Triangles between the heights of a map.
function heightsForm({origin, cell, columns, heights}) {
  const rows = heights.length / columns;
  const form = new THREE.PlaneGeometry(cell * (columns - 1), cell * (rows - 1), columns - 1, rows - 1);
  const position = form.getAttribute('position');
  heights.forEach((height, i) => position.setXYZ(
      i, origin[0] + cell * (i % columns), origin[1] + cell * Math.floor(i / columns), origin[2] + height));
  form.computeVertexNormals();
  return form;
}

/// Scenery is solid, since nothing has to avoid it.
function surface({inside, scenery}) {
  if (scenery) return new THREE.MeshStandardMaterial({color: sceneryColor, roughness: 0.9});
  return new THREE.MeshStandardMaterial({
    color: inside ? insideColor : outsideColor, transparent: true, opacity: inside ? 0.15 : 0.5,
    side: inside ? THREE.DoubleSide : THREE.FrontSide, depthWrite: !inside, roughness: 0.8});
}

function half(shape, view) {
  const size = 1.3 * view.getSize(new THREE.Vector3()).length();
  const normal = vector(shape.normal);
  const material = surface(shape);
  if (shape.terrain) material.color.set(terrainColor);
  material.side = THREE.DoubleSide;
  material.opacity = 0.16;
  material.depthWrite = false;
  const mesh = new THREE.Mesh(new THREE.PlaneGeometry(size, size), material);
  mesh.quaternion.setFromUnitVectors(up, normal);
  // A square of the plane, located nearest to the motion.
  const center = view.getCenter(new THREE.Vector3());
  const height = normal.dot(center.clone().sub(vector(shape.point)));
  mesh.position.copy(center.addScaledVector(normal, -height));
  return mesh;
}

function disc(shape) {
  const form = new THREE.CylinderGeometry(shape.radius, shape.radius, 0.3 * shape.radius, 40)
      .rotateX(Math.PI / 2);
  const mesh = new THREE.Mesh(form, surface(shape));
  mesh.quaternion.setFromUnitVectors(up, vector(shape.normal));
  return mesh;
}

/// The bounded faces of a box of which others are missing, around its center.
function openBox({lower, upper}, size, center) {
  const turned = [form => form.rotateY(Math.PI / 2), form => form.rotateX(Math.PI / 2), form => form];
  const sides = [[2, 1], [0, 2], [0, 1]];
  const faces = [0, 1, 2].flatMap(axis => [...new Set([lower[axis], upper[axis]])].filter(end => end !== null).map(end => {
    const at = [0, 0, 0];
    at[axis] = end - center[axis];
    return turned[axis](new THREE.PlaneGeometry(...sides[axis].map(side => size[side]))).translate(...at);
  }));
  return mergeGeometries(faces);
}

/// A box; along an unbounded axis it is open and extends as far as the motion. Two equalities become
/// a thin bar.
function box(shape, view) {
  const thin = 0.008 * view.getSize(new THREE.Vector3()).length();
  const low = ['x', 'y', 'z'].map((axis, i) => shape.lower[i] ?? view.min[axis]);
  const high = ['x', 'y', 'z'].map((axis, i) => shape.upper[i] ?? view.max[axis]);
  const size = low.map((l, i) => Math.max(thin, high[i] - l)), center = low.map((l, i) => (l + high[i]) / 2);
  const ends = [...shape.lower, ...shape.upper];
  const solid = !ends.includes(null) || low.filter((l, i) => l === high[i]).length > 1;
  const form = solid ? new THREE.BoxGeometry(...size) : openBox(shape, size, center);
  const mesh = new THREE.Mesh(form, surface(shape));
  mesh.position.set(...center);
  mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(form),
                                  new THREE.LineBasicMaterial({color: insideColor})));
  return mesh;
}

function objectOf(shape, view) {
  switch (shape.kind) {
    case 'half_space':
      return half(shape, view);
    case 'heights':
      return new THREE.Mesh(heightsForm(shape), ground());
    case 'box':
      return box(shape, view);
    case 'disc':
      return disc(shape);
    case 'sphere': {
      const mesh = new THREE.Mesh(convexForm({...shape, center: [0, 0, 0]}), surface(shape));
      return mesh;
    }
    default:
      return new THREE.Mesh(convexForm(shape), shape.terrain ? ground() : surface(shape));
  }
}

export class Obstacles {
  /// `view`: the bounding box of the motion, expanded by obstacles of finite size.
  constructor(shapes, view) {
    this.root = new THREE.Group();
    this.moving = [];
    const sized = shapes.filter(s => s.kind !== 'half_space' && s.kind !== 'box');
    const rest = shapes.filter(s => !sized.includes(s));
    const bounds = new Set();
    for (const shape of [...sized, ...rest]) {
      const object = objectOf(shape, view);
      object.name = shape.name;
      // Feet often have the same bounds; drawn once, they stay transparent.
      const same = JSON.stringify([shape.lower, shape.upper]);
      object.visible = shape.kind !== 'box' || !bounds.has(same);
      bounds.add(same);
      if (shape.center) object.position.fromArray(shape.center);
      if (shape.centers) {
        object.position.fromArray(shape.centers);
        this.moving.push({object, centers: shape.centers});
      }
      this.root.add(object);
      if (sized.includes(shape)) view.expandByObject(object);
    }
  }

  /// Moves the moving obstacles to a position between two nodes.
  show(k, share) {
    for (const {object, centers} of this.moving) {
      const next = Math.min(3 * k + 3, centers.length - 3);
      object.position.fromArray(centers, 3 * k).lerp(new THREE.Vector3().fromArray(centers, next), share);
    }
  }
}

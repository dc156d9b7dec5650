// The ground: marks at contacts, the planes of the contacts, and a grid.
import * as THREE from 'three';
import {forceNode} from './data.js';
import {color} from './dom.js';

const up = new THREE.Vector3(0, 0, 1);
const sand = '#b9a77c';

/// All places and normals of a contact while it is closed: {point, normal, begins}.
function* holds(solution) {
  for (const {contact, forces} of solution.contacts) {
    if (!contact?.ground) continue;
    let before = false;
    for (let k = 0; k < forces.length; ++k) {
      const now = forces[k] !== null;
      const at = 3 * forceNode(contact, k);
      if (now)
        yield {point: new THREE.Vector3().fromArray(contact.positions, at),
               normal: new THREE.Vector3().fromArray(contact.normals, at).normalize(), begins: !before};
      before = now;
    }
  }
}

/// Planes of the contacts, each with its points; planes within 2 cm are merged.
export function surfacesOf(solution) {
  const planes = [];
  for (const {point, normal} of holds(solution)) {
    let plane = planes.find(p => p.normal.dot(normal) > 0.9998 && Math.abs(p.normal.dot(point) - p.height) < 0.02);
    if (!plane) planes.push(plane = {normal, height: normal.dot(point), points: []});
    plane.points.push(point);
  }
  return planes;
}

function footprints(solution, markSize) {
  const group = new THREE.Group();
  const form = new THREE.CircleGeometry(0.07 * markSize, 32);
  const material = new THREE.MeshStandardMaterial(
      {color: sand, side: THREE.DoubleSide, transparent: true, opacity: 0.55});
  for (const {point, normal, begins} of holds(solution)) {
    if (!begins) continue;
    const mark = new THREE.Mesh(form, material);
    mark.position.copy(point).addScaledVector(normal, -0.003);
    mark.quaternion.setFromUnitVectors(up, normal);
    group.add(mark);
  }
  return group;
}

/// A rectangle that covers all points of a plane.
function slab(plane) {
  const turn = new THREE.Quaternion().setFromUnitVectors(up, plane.normal);
  const back = turn.clone().invert();
  const box = new THREE.Box3().setFromPoints(plane.points.map(p => p.clone().applyQuaternion(back)));
  const size = box.getSize(new THREE.Vector3()).addScalar(0.3);
  const mesh = new THREE.Mesh(
      new THREE.PlaneGeometry(size.x, size.y),
      new THREE.MeshStandardMaterial({color: sand, side: THREE.DoubleSide, transparent: true, opacity: 0.4}));
  mesh.quaternion.copy(turn);
  mesh.position.copy(box.getCenter(new THREE.Vector3()).setZ(box.min.z - 0.005).applyQuaternion(turn));
  return mesh;
}

/// The smallest of 1, 2 and 5 times a power of ten that is at least a size.
function roundedUp(size) {
  const power = 10 ** Math.floor(Math.log10(size));
  return power * [1, 2, 5, 10].find(factor => factor * power >= size * (1 - 1e-9));
}

export class Ground {
  /// `view`: the bounding box of what is drawn. `cell`: the size of the grid's squares.
  constructor(solution, view, markSize) {
    this.root = new THREE.Group();
    this.view = view;
    this.planar = solution.scene.planar ?? false;
    this.surfaces = surfacesOf(solution);
    // Where the grid would cut the picture and is not the ground, it lies below.
    this.below = this.surfaces.length === 0 || solution.scene.obstacles.some(o => o.kind === 'heights');
    // The grid lies on the slope if all contacts share one, else at height zero.
    const [only] = this.surfaces;
    this.slope = this.surfaces.length === 1 && only.normal.z > 0.5 && only.normal.z < 0.9998 ? only : null;
    this.root.add(footprints(solution, markSize));
    for (const plane of this.surfaces)
      if (plane !== this.slope && (plane.normal.z < 0.9998 || Math.abs(plane.height) > 0.02))
        this.root.add(slab(plane));
    this.setTheme();
  }

  /// Creates the grid again, because its vertices contain the theme's colors.
  setTheme() {
    const size = this.view.getSize(new THREE.Vector3()), center = this.view.getCenter(new THREE.Vector3());
    const span = 2.5 * Math.max(size.x, size.y, size.z) || 2;
    this.cell = this.planar ? roundedUp(span / 50) : Math.max(0.5, roundedUp(span / 60));
    const cells = 2 * Math.ceil(Math.max(span, this.planar ? 0 : 2) / (2 * this.cell));
    this.grid?.removeFromParent();
    this.grid?.dispose();
    this.grid = new THREE.GridHelper(cells * this.cell, cells, color('line'), color('grid'));
    this.grid.rotateX(Math.PI / 2);
    const near = x => this.cell * Math.round(x / this.cell);
    const under = this.view.min.z - 1e-3 * span;
    this.grid.position.set(near(center.x), near(center.y),
                           this.planar ? under : this.below ? Math.min(0, under) : 0);
    if (this.slope) {
      const {normal, height} = this.slope;
      this.grid.quaternion.premultiply(new THREE.Quaternion().setFromUnitVectors(up, normal));
      this.grid.position.set(center.x, center.y, (height - normal.x * center.x - normal.y * center.y) / normal.z);
    }
    this.root.add(this.grid);
  }
}

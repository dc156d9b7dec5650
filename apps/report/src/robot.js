// A robot's bodies, contacts and paths as three.js objects, moved along a trajectory.
import * as THREE from 'three';
import {forceNode, forceParts, nodeAt} from './data.js';
import {MovingLine, polyline} from './lines.js';
import {convexForm} from './obstacles.js';
import {lineColor} from './palette.js';
import {place, shapeObject} from './shapes.js';

/// An arrow of unit length along +z, visible through objects in front of it.
function arrow(color) {
  const group = new THREE.Group();
  const surface = new THREE.MeshStandardMaterial({color, roughness: 0.5});
  const shaft = new THREE.Mesh(
      new THREE.CylinderGeometry(0.008, 0.008, 1, 10).rotateX(Math.PI / 2).translate(0, 0, 0.5),
      surface);
  const tip = new THREE.Mesh(
      new THREE.ConeGeometry(0.024, 0.06, 14).rotateX(Math.PI / 2).translate(0, 0, 0.03), surface);
  const through = new THREE.MeshBasicMaterial({color, transparent: true, opacity: 0.4, depthTest: false});
  for (const part of [shaft, tip]) part.add(new THREE.Mesh(part.geometry, through));
  group.add(shaft, tip);
  group.userData = {shaft, tip};
  return group;
}

const up = new THREE.Vector3(0, 0, 1);

export class Robot {
  /// `ghost` robots are transparent and tinted.
  constructor(solution, {ghost = false, tint = '#0072b2'} = {}) {
    this.solution = solution;
    this.scene = solution.scene;
    this.root = new THREE.Group();
    this.bodies = this.scene.bodies.map(body => {
      const group = new THREE.Group();
      group.name = body.name;
      for (const shape of body.shapes) {
        const color = shape.placement ? undefined : this.pathColor(body.name);
        const object = shapeObject(shape, {ghost, tint, color}, this.scene.meshes);
        if (object) group.add(object);
      }
      this.root.add(group);
      return group;
    });
    this.bodies.forEach((body, i) => place(body, this.scene.poses, 7 * i));
    this.markSize = this.sizeOfMarks();
    this.addBones(tint);
    this.addShapes(tint);
    this.addContacts(ghost);
    this.addPaths(tint);
    this.addLines(ghost, tint);
    this.next = {position: new THREE.Vector3(), quaternion: new THREE.Quaternion()};
    this.show(0);
  }

  /// The size of footprints, cones and arrows: 1 for robots that are as large as a dog, less for
  /// smaller ones.
  sizeOfMarks() {
    const box = new THREE.Box3();
    for (const body of this.bodies.slice(1)) box.expandByObject(body);
    const large = 1.2;
    return box.isEmpty() ? 1 : Math.min(1, box.getSize(new THREE.Vector3()).length() / large);
  }

  /// Adds lines from every joint to its parent, for bodies with few visible shapes.
  addBones(tint) {
    const bones = this.scene.bodies.map((body, i) => [i, body.parent]).filter(([, p]) => p > 0);
    const form = new THREE.BufferGeometry();
    form.setAttribute('position', new THREE.Float32BufferAttribute(6 * bones.length, 3));
    this.bones = {
      pairs: bones,
      lines: new THREE.LineSegments(form, new THREE.LineBasicMaterial({color: tint})),
    };
    this.bones.lines.frustumCulled = false;
    this.bones.lines.visible = false;
    this.root.add(this.bones.lines);
  }

  /// Adds the collision shapes.
  addShapes(color) {
    this.shapes = (this.scene.collision_shapes ?? []).map(shape => {
      const mesh = new THREE.Mesh(convexForm(shape), new THREE.MeshBasicMaterial(
          {color, wireframe: true, transparent: true, opacity: 0.35}));
      mesh.name = shape.name;
      mesh.visible = false;
      this.bodies[shape.body].add(mesh);
      return mesh;
    });
  }

  addContacts(ghost) {
    this.forces = new THREE.Group();
    this.cones = new THREE.Group();
    this.feet = this.scene.contacts.map(contact => {
      const marker = new THREE.Mesh(
          contact.half_size ? new THREE.BoxGeometry(2 * contact.half_size[0], 2 * contact.half_size[1], 0.004)
                            : new THREE.SphereGeometry(0.012 * this.markSize, 16, 12),
          new THREE.MeshStandardMaterial({color: '#d55e00'}));
      place(marker, contact.placement, 0);
      this.bodies[contact.body].add(marker);
      return marker;
    });
    if (ghost) for (const foot of this.feet) foot.visible = false;
    this.contacts = this.solution.contacts.filter(entry => entry.contact).map(entry => {
      const force = arrow('#009e73');
      const slope = entry.contact.friction;
      const height = 0.14 * this.markSize;
      const cone = new THREE.Mesh(
          new THREE.ConeGeometry(slope * height, height, 28, 1, true)
              .rotateX(-Math.PI / 2).translate(0, 0, height / 2),
          new THREE.MeshBasicMaterial({color: '#56b4e9', transparent: true, opacity: 0.28,
                                       side: THREE.DoubleSide, depthWrite: false}));
      this.forces.add(force);
      this.cones.add(cone);
      return {...entry, force, cone};
    });
    const weight = this.largestForce();
    this.metresPerNewton = weight > 0 ? 0.45 * this.markSize / weight : 0;
    this.root.add(this.forces, this.cones);
    if (ghost) this.forces.visible = this.cones.visible = false;
  }

  /// The largest force of all contacts and knots with a duration; impulses are in Ns and would
  /// dwarf forces.
  largestForce() {
    const t = this.solution.curves.t;
    let largest = 0;
    for (const {forces} of this.solution.contacts)
      forces.forEach((f, k) => {
        if (f && f[0] !== null && t[k + 1] > t[k])
          largest = Math.max(largest, Math.hypot(f[0], f[1], f[2]));
      });
    return largest;
  }

  /// The color of the path with this name, and of a drawing that leaves it; undefined without one.
  pathColor(name) {
    const i = Object.keys(this.scene.paths).indexOf(name);
    return i < 0 ? undefined : lineColor(this.scene.contacts.length + i);
  }

  /// Adds the lines of drawings.
  addLines(ghost, tint) {
    this.lines = (this.scene.lines ?? []).map(line => new MovingLine(line, ghost ? tint : '#7f7f7f'));
    for (const line of this.lines) this.root.add(line.object);
    if (!this.scene.planar) return;
    // In the plane, lines are not hidden by the shapes that they cross.
    for (const object of [...this.paths.children, ...this.lines.map(line => line.object)]) {
      object.material.depthTest = false;
      object.renderOrder = 1;
    }
  }

  addPaths(tint) {
    this.paths = new THREE.Group();
    const ways = [...this.scene.contacts.map(contact => contact.positions), ...Object.values(this.scene.paths)];
    ways.forEach((way, i) => this.paths.add(polyline(way, lineColor(i))));
    this.com = new THREE.Group();
    this.comMarker = new THREE.Mesh(new THREE.SphereGeometry(0.018 * this.markSize, 18, 12),
                                    new THREE.MeshStandardMaterial({color: tint}));
    if (this.scene.com.length > 0) this.com.add(polyline(this.scene.com, tint), this.comMarker);
    this.root.add(this.paths, this.com);
  }

  /// Moves everything to a time: positions are interpolated linearly between two nodes, rotations
  /// on the shortest arc.
  show(time) {
    const {k, share} = nodeAt(this.solution.curves.t, time);
    const n = 7 * this.bodies.length, poses = this.scene.poses;
    const after = Math.min(k + 1, this.solution.curves.t.length - 1);
    this.bodies.forEach((body, i) => {
      place(body, poses, k * n + 7 * i);
      if (share > 0) {
        place(this.next, poses, after * n + 7 * i);
        body.position.lerp(this.next.position, share);
        body.quaternion.slerp(this.next.quaternion, share);
      }
    });
    const com = this.scene.com;
    if (com.length > 0)
      this.comMarker.position.fromArray(com, 3 * k)
          .lerp(this.next.position.fromArray(com, 3 * after), share);
    else
      this.comMarker.position.copy((this.bodies[1] ?? this.bodies[0]).position);
    for (const line of this.lines) line.show(k, share);
    if (this.bones.lines.visible) this.moveBones();
    for (const entry of this.contacts) this.showForce(entry, k);
  }

  moveBones() {
    const position = this.bones.lines.geometry.attributes.position;
    this.bones.pairs.forEach(([child, parent], i) => {
      this.bodies[child].position.toArray(position.array, 6 * i);
      this.bodies[parent].position.toArray(position.array, 6 * i + 3);
    });
    position.needsUpdate = true;
  }

  /// Shows the force between two nodes at the contact's place on the drawn body.
  showForce(entry, k) {
    const parts = k < entry.forces.length ? forceParts(entry, k) : null;
    entry.force.visible = parts !== null;
    entry.cone.visible = parts !== null && entry.contact.friction > 0;
    if (!parts) return;
    const index = this.scene.contacts.indexOf(entry.contact);
    const normal = new THREE.Vector3().fromArray(entry.contact.normals, 3 * forceNode(entry.contact, k)).normalize();
    const at = this.contactPosition(index).addScaledVector(normal, -entry.contact.radius);
    entry.force.position.copy(at);
    entry.cone.position.copy(at);
    const f = new THREE.Vector3(...parts.force.slice(0, 3));
    const length = Math.max(f.length() * this.metresPerNewton, 1e-4);
    entry.force.quaternion.setFromUnitVectors(up, f.normalize());
    const {shaft, tip} = entry.force.userData;
    const head = Math.min(0.06 * this.markSize, length);
    shaft.scale.set(this.markSize, this.markSize, Math.max(length - head, 1e-4));
    tip.position.z = length - head;
    tip.scale.setScalar(head / 0.06);
    entry.cone.quaternion.setFromUnitVectors(up, normal);
  }

  /// The position of a contact's frame in the scene, from the body that carries it.
  contactPosition(index) {
    const foot = this.feet[index];
    const body = this.bodies[this.scene.contacts[index].body];
    return foot.position.clone().applyQuaternion(body.quaternion).add(body.position);
  }

  /// The bounding box of the robot at a time.
  boundsAt(time) {
    const box = new THREE.Box3(), one = new THREE.Box3();
    this.show(time);
    for (const body of this.bodies.slice(1)) {
      body.updateMatrixWorld(true);
      box.union(one.setFromObject(body));
    }
    for (const line of this.lines) line.expand(box);
    return box;
  }

  /// The bounding box of the motion, sampled at some times.
  bounds() {
    const box = new THREE.Box3();
    const samples = 12;
    for (let i = 0; i <= samples; ++i) box.union(this.boundsAt(this.solution.duration * i / samples));
    return box;
  }
}

// The 3-D scene: robots, ground, obstacles, camera.
import * as THREE from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {nodeAt} from './data.js';
import {color, element, figure, toggle} from './dom.js';
import {Ground} from './ground.js';
import {Obstacles} from './obstacles.js';
import {lineColor} from './palette.js';
import {PlanGhost} from './plan_ghost.js';
import {savePicture, videoButton} from './recording.js';
import {Robot} from './robot.js';

/// Directions from the motion to the camera. The one from above leans a little, so that y points
/// upwards on the screen.
const directions = {
  first: [0.5, -0.8, 0.35], front: [1, 0, 0], side: [0, -1, 0], top: [0, -1e-4, 1],
};

function litScene() {
  const scene = new THREE.Scene();
  scene.add(new THREE.HemisphereLight('#ffffff', '#8d8478', 1.7));
  const sun = new THREE.DirectionalLight('#ffffff', 1.8);
  sun.position.set(3, -4, 8);
  scene.add(sun);
  return scene;
}

export class Viewer {
  /// `plans`: of a closed loop, whose plant is the first solution.
  constructor(holder, solutions, player, plans) {
    this.holder = holder;
    this.solutions = solutions;
    this.player = player;
    this.ready = false;
    this.name = solutions[0].head.problem.name;
    const first = solutions.find(s => s.scene);
    if (!first) {
      const reason = solutions.map(s => s.remark).find(remark => remark) ||
          'The file says nothing to draw; its curves are beside. The key draw makes a picture.';
      holder.append(element('p', {class: 'note'}, reason));
      return;
    }
    try {
      this.renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
    } catch (error) {
      holder.append(element('p', {class: 'note'}, 'This browser cannot draw in 3-D (WebGL).'));
      return;
    }
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    holder.append(this.renderer.domElement);
    this.scene = litScene();

    let shown = 0;
    this.robots = solutions.map((solution, i) => {
      if (!solution.scene) return null;
      const robot = new Robot(solution, {ghost: shown > 0, tint: lineColor(i)});
      ++shown;
      this.scene.add(robot.root);
      return robot;
    });
    this.robot = this.robots.find(robot => robot);
    this.box = this.robot.bounds();
    this.first = first;
    this.obstacles = new Obstacles(first.scene.obstacles, this.box);
    this.ground = new Ground(first, this.box, this.robot.markSize);
    this.scene.add(this.obstacles.root, this.ground.root);
    this.plan = plans?.poses ? new PlanGhost(first, plans) : null;
    if (this.plan) this.scene.add(this.plan.root);
    this.planar = first.scene.planar ?? false;
    this.resetView();
    this.follow = this.speck;
    this.addSwitches();
    holder.append(element('div', {class: 'scale'}, `grid ${figure(this.ground.cell)}${this.planar ? '' : ' m'}`));
    this.ready = true;
    this.resize();
    new ResizeObserver(() => this.resize()).observe(holder);
    player.listen(() => this.show());
    this.show();
  }

  /// Aims a new camera at the motion, from afar if it is in the plane: heights then hardly show. It
  /// sees all of it, or if the robot would be too small, only the robot, which it then follows.
  /// Motions in the plane are first seen from above.
  resetView(from = this.planar ? 'top' : 'first') {
    this.controls?.dispose();
    this.camera = new THREE.PerspectiveCamera(this.planar ? 12 : 40, this.aspect());
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener('change', () => this.draw());
    const robot = this.robot.boundsAt(this.player.time);
    const length = box => box.getSize(new THREE.Vector3()).length();
    this.speck = !this.planar && length(robot) > 0 && length(this.box) > 15 * length(robot);
    const box = this.speck ? robot.expandByScalar(length(robot)) : this.box;
    const center = box.getCenter(new THREE.Vector3());
    const back = new THREE.Vector3(...directions[from]).normalize();
    this.controls.target.copy(center);
    const distance = this.distance(box, back);
    this.camera.position.copy(center).addScaledVector(back, distance);
    this.camera.near = distance / 200;
    this.camera.far = 50 * distance;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.lastCom = null;
    this.draw();
  }

  /// The distance from which a camera aimed at the center of a box sees all of it.
  distance(box, back) {
    const right = new THREE.Vector3().crossVectors(this.camera.up, back).normalize();
    const up = new THREE.Vector3().crossVectors(back, right);
    const center = box.getCenter(new THREE.Vector3());
    const vertical = Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2));
    const horizontal = vertical * this.camera.aspect;
    let distance = 0;
    for (const x of [box.min.x, box.max.x])
      for (const y of [box.min.y, box.max.y])
        for (const z of [box.min.z, box.max.z]) {
          const corner = new THREE.Vector3(x, y, z).sub(center);
          distance = Math.max(distance, corner.dot(back) + (this.planar ? 1.25 : 1.12) * Math.max(
              Math.abs(corner.dot(right)) / horizontal, Math.abs(corner.dot(up)) / vertical));
        }
    return distance || 1;
  }

  aspect() {
    return this.holder.clientWidth / Math.max(1, this.holder.clientHeight) || 1;
  }

  addSwitches() {
    const all = change => on => {
      for (const robot of this.robots) if (robot) change(robot, on);
      this.show();
    };
    const {contacts, com, collision_shapes: shapes = [], obstacles} = this.first.scene;
    const one = (object, on) => { object.visible = on; this.draw(); };
    const button = (label, title, onclick) => element('button', {type: 'button', title, onclick}, label);
    const parts = [
      ...(contacts.length === 0 ? [] : [
        toggle('Forces', 'Contact forces', true, on => one(this.robot.forces, on)),
        toggle('Cones', 'Friction cones', true, on => one(this.robot.cones, on))]),
      toggle('Paths', 'Ways of feet and other frames', true, all((r, on) => { r.paths.visible = on; })),
      ...(com.length === 0 ? [] : [
        toggle('CoM', 'Centre of mass and its way', true, all((r, on) => { r.com.visible = on; })),
        toggle('Joints', 'Lines between joints', false, all((r, on) => { r.bones.lines.visible = on; }))]),
      ...(!this.plan ? [] : [
        toggle('Plan', 'Where the plan in force ends, and the way there', true, on => one(this.plan.root, on))]),
      ...(obstacles.length === 0 ? [] : [
        toggle('Obstacles', 'Obstacles and bounds on positions', true, on => one(this.obstacles.root, on))]),
      ...(shapes.length === 0 ? [] : [
        toggle('Shapes', 'Shapes that keep clear of obstacles', false,
               all((r, on) => { for (const shape of r.shapes) shape.visible = on; }))]),
      this.followButton = toggle('Follow', 'The camera goes with the robot (F)', this.follow,
                                 on => { this.follow = on; this.lastCom = null; this.show(); }),
      ...Object.keys(directions).slice(1).map(from => button(
          from[0].toUpperCase() + from.slice(1), `The motion from the ${from}`, () => this.resetView(from))),
      button('Reset', 'Back to the first view', () => this.resetView()),
      button('PNG', 'Save this view as a picture', () => savePicture(this.renderer.domElement, this.name)),
      videoButton(this.renderer.domElement, this.player, this.name),
    ];
    this.holder.append(element('div', {class: 'switches'}, ...parts));
  }

  /// Sets the visible solutions; the first one is solid, the others are ghosts.
  setVisible(visible) {
    if (!this.ready) return;
    this.robots.forEach((robot, i) => { if (robot) robot.root.visible = visible[i]; });
    this.draw();
  }

  setTheme() {
    if (!this.ready) return;
    this.ground.setTheme();
    this.draw();
  }

  resize() {
    if (!this.ready) return;
    const {clientWidth: w, clientHeight: h} = this.holder;
    if (w === 0 || h === 0) return;
    this.renderer.setSize(w, h, false);
    this.camera.aspect = this.aspect();
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  show() {
    for (const robot of this.robots) robot?.show(this.player.time);
    this.plan?.show(this.player.time);
    const {k, share} = nodeAt(this.first.curves.t, this.player.time);
    this.obstacles.show(k, share);
    if (this.follow) {
      const com = this.robot.comMarker.position;
      if (this.lastCom) {
        const step = com.clone().sub(this.lastCom);
        this.camera.position.add(step);
        this.controls.target.add(step);
      }
      this.lastCom = com.clone();
      this.controls.update();
    }
    this.draw();
  }

  draw() {
    this.renderer.setClearColor(color('sky'));
    this.renderer.render(this.scene, this.camera);
  }
}

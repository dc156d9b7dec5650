// The scene in 3-D: robots, ground, obstacles, camera.
import * as THREE from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {nodeAt} from './data.js';
import {color, element, toggle} from './dom.js';
import {Ground} from './ground.js';
import {Obstacles} from './obstacles.js';
import {lineColor} from './palette.js';
import {Robot} from './robot.js';

export class Viewer {
  constructor(holder, solutions, player) {
    this.holder = holder;
    this.solutions = solutions;
    this.player = player;
    this.ready = false;
    const first = solutions.find(s => s.scene);
    if (!first) {
      const reason = solutions.map(s => s.remark).find(remark => remark) ||
          'This system has no robot model to draw; its curves are beside.';
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
    this.scene = new THREE.Scene();
    this.scene.add(new THREE.HemisphereLight('#ffffff', '#8d8478', 1.7));
    const sun = new THREE.DirectionalLight('#ffffff', 1.8);
    sun.position.set(3, -4, 8);
    this.scene.add(sun);

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
    this.ground = new Ground(first, this.box);
    this.scene.add(this.obstacles.root, this.ground.root);
    this.addCamera();
    this.addSwitches();
    this.follow = false;
    this.ready = true;
    this.resize();
    new ResizeObserver(() => this.resize()).observe(holder);
    player.listen(() => this.show());
    this.show();
  }

  addCamera() {
    const box = this.box;
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.01, 200);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener('change', () => this.draw());
    const center = box.getCenter(new THREE.Vector3());
    const distance = 1.55 * box.getSize(new THREE.Vector3()).length();
    this.controls.target.copy(center);
    this.camera.position.copy(center).add(
        new THREE.Vector3(0.5, -0.8, 0.35).normalize().multiplyScalar(Math.max(0.5, distance)));
    this.controls.update();
    this.lastCom = null;
  }

  addSwitches() {
    const all = change => on => {
      for (const robot of this.robots) if (robot) change(robot, on);
      this.show();
    };
    const {contacts, com, collision_shapes: shapes = [], obstacles} = this.first.scene;
    const one = (object, on) => { object.visible = on; this.draw(); };
    const parts = [
      ...(contacts.length === 0 ? [] : [
        toggle('Forces', 'Contact forces', true, on => one(this.robot.forces, on)),
        toggle('Cones', 'Friction cones', true, on => one(this.robot.cones, on))]),
      toggle('Paths', 'Ways of feet and other frames', true, all((r, on) => { r.paths.visible = on; })),
      ...(com.length === 0 ? [] : [
        toggle('CoM', 'Centre of mass and its way', true, all((r, on) => { r.com.visible = on; })),
        toggle('Joints', 'Lines between joints', false, all((r, on) => { r.bones.lines.visible = on; }))]),
      ...(obstacles.length === 0 ? [] : [
        toggle('Obstacles', 'Obstacles and bounds on positions', true, on => one(this.obstacles.root, on))]),
      ...(shapes.length === 0 ? [] : [
        toggle('Shapes', 'Shapes that keep clear of obstacles', false,
               all((r, on) => { for (const shape of r.shapes) shape.visible = on; }))]),
      this.followButton = toggle('Follow', 'The camera goes with the robot (F)', false,
                                 on => { this.follow = on; this.lastCom = null; this.show(); }),
      element('button', {type: 'button', title: 'Back to the first view', onclick: () => {
        const old = this.controls;
        this.addCamera();
        old.dispose();
        this.resize();
      }}, 'Reset'),
    ];
    this.holder.append(element('div', {class: 'switches'}, ...parts));
  }

  /// Which solutions are seen; the first of them is solid, the others are ghosts.
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
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  show() {
    for (const robot of this.robots) robot?.show(this.player.time);
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

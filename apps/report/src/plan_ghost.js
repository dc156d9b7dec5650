// The plan in force at a time: its end as a ghost of the robot, and the path to it.
import * as THREE from 'three';
import {LineGeometry} from 'three/examples/jsm/lines/LineGeometry.js';
import {polyline} from './lines.js';
import {Robot} from './robot.js';

const tint = '#d55e00';

/// The last plan that begins no later than a time; before all plans, the first one.
export function planAt(list, time) {
  let low = 0, high = list.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (list[middle].from <= time + 1e-9) low = middle;
    else high = middle - 1;
  }
  return list[low];
}

export class PlanGhost {
  constructor(solution, plans) {
    this.plans = plans;
    this.numbers = 7 * solution.scene.bodies.length;
    this.plan = null;
    const scene = {...solution.scene, contacts: [], paths: {}, com: [], collision_shapes: [], lines: [],
                   poses: plans.poses.slice(0, this.numbers)};
    this.robot = new Robot({curves: {t: [0]}, contacts: [], scene}, {ghost: true, tint});
    this.way = polyline([0, 0, 0, 0, 0, 0], tint);
    this.root = new THREE.Group();
    this.root.add(this.robot.root, this.way);
  }

  show(time) {
    const plan = planAt(this.plans.list, time);
    if (plan === this.plan) return;
    this.plan = plan;
    this.robot.root.visible = plan.nodes > 0;
    this.way.visible = plan.nodes > 1;
    if (plan.nodes === 0) return;
    const last = plan.first + plan.nodes - 1;
    this.robot.scene.poses = this.plans.poses.slice(last * this.numbers, (last + 1) * this.numbers);
    this.robot.show(0);
    if (plan.nodes === 1) return;
    this.way.geometry.dispose();
    this.way.geometry = new LineGeometry().setPositions(this.plans.track.slice(3 * plan.first, 3 * (last + 1)));
  }
}

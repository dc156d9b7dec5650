// Lines: paths, and lines whose corners move.
import * as THREE from 'three';
import {Line2} from 'three/examples/jsm/lines/Line2.js';
import {LineGeometry} from 'three/examples/jsm/lines/LineGeometry.js';
import {LineMaterial} from 'three/examples/jsm/lines/LineMaterial.js';

/// A line with the same width in pixels at any distance.
export function polyline(numbers, color, linewidth = 2) {
  const line = new Line2(new LineGeometry().setPositions(numbers), new LineMaterial({color, linewidth}));
  line.frustumCulled = false;
  return line;
}

/// A line through corners with positions at each node.
export class MovingLine {
  constructor({name, corners, positions}, color) {
    this.size = 3 * corners;
    this.positions = positions;
    this.now = positions.slice(0, this.size);
    this.object = polyline(this.now, color, 3);
    this.object.name = name;
  }

  /// Moves the corners to a position between two nodes.
  show(k, share) {
    const next = Math.min(k + 1, this.positions.length / this.size - 1);
    for (let i = 0; i < this.size; ++i) {
      const from = this.positions[k * this.size + i], to = this.positions[next * this.size + i];
      this.now[i] = from + share * (to - from);
    }
    // The geometry stores both ends of each segment.
    const ends = this.object.geometry.attributes.instanceStart.data;
    for (let i = 0; i + 3 < this.size; i += 3) ends.array.set(this.now.slice(i, i + 6), 2 * i);
    ends.needsUpdate = true;
  }

  /// Expands a box by the corners.
  expand(box) {
    const corner = new THREE.Vector3();
    for (let i = 0; i < this.size; i += 3) box.expandByPoint(corner.fromArray(this.now, i));
  }
}

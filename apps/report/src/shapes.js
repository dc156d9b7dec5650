// Shapes of a body: primitives and meshes as three.js objects.
import * as THREE from 'three';
import {STLLoader} from 'three/examples/jsm/loaders/STLLoader.js';
import {OBJLoader} from 'three/examples/jsm/loaders/OBJLoader.js';
import {convexForm} from './obstacles.js';

const defaultColor = '#8a929b';

/// Places an object by seven numbers of a list: position and quaternion x y z w.
export function place(object, numbers, at) {
  object.position.fromArray(numbers, at);
  object.quaternion.fromArray(numbers, at + 3);
}

function material(shape, {ghost, tint, color: own}) {
  const [r, g, b, a] = shape.color ?? [];
  const color = shape.color ? new THREE.Color().setRGB(r, g, b, THREE.SRGBColorSpace)
                            : new THREE.Color(own ?? defaultColor);
  if (ghost) color.lerp(new THREE.Color(tint), 0.6);
  const opacity = (shape.color ? a : 1) * (ghost ? 0.3 : 1);
  return new THREE.MeshStandardMaterial(
      {color, roughness: 0.65, metalness: 0.1, transparent: opacity < 1, opacity, depthWrite: !ghost});
}

function bytes(base64) {
  const text = atob(base64);
  const data = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) data[i] = text.charCodeAt(i);
  return data;
}

/// Computes normals of facets without one (zeros, which would be black) from their corners.
function completeNormals(form) {
  const given = form.getAttribute('normal');
  const missing = [];
  for (let i = 0; i < given.count; ++i) {
    const square = given.getX(i) ** 2 + given.getY(i) ** 2 + given.getZ(i) ** 2;
    if (!(square > 0.25 && square < 4)) missing.push(i);
  }
  if (missing.length === 0) return form;
  const computed = form.clone();
  computed.computeVertexNormals();  // each facet has its own three corners: flat shading
  const corners = computed.getAttribute('normal');
  for (const i of missing) given.setXYZ(i, corners.getX(i), corners.getY(i), corners.getZ(i));
  return form;
}

/// A round dot nine pixels wide, in front of everything.
function dot(color) {
  const form = new THREE.BufferGeometry().setAttribute('position', new THREE.Float32BufferAttribute([0, 0, 0], 3));
  const surface = new THREE.PointsMaterial({color, size: 9, sizeAttenuation: false, depthTest: false});
  surface.onBeforeCompile = shader => {
    shader.fragmentShader = shader.fragmentShader.replace('void main() {',
        'void main() {\n  if (distance(gl_PointCoord, vec2(0.5)) > 0.5) discard;');
  };
  const points = new THREE.Points(form, surface);
  points.renderOrder = 2;
  return points;
}

function geometry(shape) {
  if (!shape.placement) return convexForm(shape);
  switch (shape.kind) {
    case 'box':
      return new THREE.BoxGeometry(...shape.size);
    case 'sphere':
      return new THREE.SphereGeometry(shape.radius, 24, 16);
    case 'cylinder':
      return new THREE.CylinderGeometry(shape.radius, shape.radius, shape.length, 24)
          .rotateX(Math.PI / 2);
    case 'ellipsoid':
      return new THREE.SphereGeometry(1, 24, 16).scale(...shape.radii);
    case 'stl':
      return completeNormals(new STLLoader().parse(bytes(shape.data).buffer)).scale(...shape.scale);
    default:
      return null;
  }
}

/// An object of a shape with its placement, or with its coordinates in the body's axes. `look`:
/// whether it is a ghost, the tint of ghosts, and the color of a shape without its own.
export function shapeObject(shape, look) {
  if (shape.kind === 'dot') return dot(look.color ?? defaultColor);
  const surface = material(shape, look);
  let object = null;
  try {
    if (shape.kind === 'obj') {
      object = new OBJLoader().parse(new TextDecoder().decode(bytes(shape.data)));
      object.scale.set(...shape.scale);
      object.traverse(part => { if (part.isMesh) part.material = surface; });
    } else {
      const form = geometry(shape);
      if (form) object = new THREE.Mesh(form, surface);
    }
  } catch (error) {
    console.warn(`a mesh of ${shape.link} cannot be read`);
  }
  if (!object) return null;
  if (shape.placement) place(object, shape.placement, 0);
  return object;
}

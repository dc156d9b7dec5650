// Shapes of a body: primitives and meshes as three.js objects.
import * as THREE from 'three';
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

/// The surface of a part of a mesh (see scene_meshes.hpp).
function partForm({low, step, positions, triangles}) {
  const cells = new Uint16Array(bytes(positions).buffer), indices = bytes(triangles).buffer;
  const vertices = Float32Array.from(cells, (cell, i) => low[i % 3] + step * cell);
  const wide = cells.length / 3 > 65536;
  return new THREE.BufferGeometry()
      .setAttribute('position', new THREE.BufferAttribute(vertices, 3))
      .setIndex(new THREE.BufferAttribute(wide ? new Uint32Array(indices) : new Uint16Array(indices), 1));
}

const forms = new WeakMap();

/// A mesh of a scene, with flat facets; its parts keep the file's colors.
function meshObject(mesh, shape, look) {
  if (!forms.has(mesh)) forms.set(mesh, mesh.map(partForm));
  const object = new THREE.Group();
  mesh.forEach((part, i) => {
    const surface = material({color: part.color ?? shape.color}, look);
    surface.flatShading = true;
    object.add(new THREE.Mesh(forms.get(mesh)[i], surface));
  });
  object.scale.set(...shape.scale);
  return object;
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
    default:
      return null;
  }
}

/// An object of a shape with its placement, or with its coordinates in the body's axes. `look`:
/// whether it is a ghost, the tint of ghosts, and the color of a shape without its own. `meshes`: of
/// its scene.
export function shapeObject(shape, look, meshes) {
  if (shape.kind === 'dot') return dot(look.color ?? defaultColor);
  let object = null;
  if (shape.kind === 'mesh') {
    object = meshObject(meshes[shape.mesh], shape, look);
  } else {
    const form = geometry(shape);
    if (form) object = new THREE.Mesh(form, material(shape, look));
  }
  if (object && shape.placement) place(object, shape.placement, 0);
  return object;
}

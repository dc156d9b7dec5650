// Obstacles and constraints in reports: node --test constraints.test.mjs
// browser.mjs lists the requirements.
import assert from 'node:assert/strict';
import {join} from 'node:path';
import {test} from 'node:test';
import {open, ours, solve, source} from './browser.mjs';

const problem = name => join(source, 'problems', `${name}.yaml`);

/// An obstacle in the scene: its centre and extent.
const obstacle = (page, name) => page.evaluate(wanted => {
  const object = window.conddp.viewer.obstacles.root.getObjectByName(wanted);
  object.geometry.computeBoundingBox();
  const {min, max} = object.geometry.boundingBox;
  const center = min.clone().add(max).multiplyScalar(0.5).applyQuaternion(object.quaternion).add(object.position);
  return {center: center.toArray(), half: max.sub(min).multiplyScalar(0.5).toArray()};
}, name);

/// Lines of a plot: names, values, marks.
const plot = (page, title) => page.evaluate(wanted => {
  const found = window.conddp.plots.find(p => p.title === wanted);
  return found && {x: Array.from(found.u.data[0]), marks: found.marks,
                   lines: found.lines.map(({name, values, limit, violated, clamped}, i) =>
                       ({name, values: Array.from(found.u.data[i + 1]), given: values, limit, violated, clamped}))};
}, title);

const near = (a, b, tolerance, what) => assert.ok(Math.abs(a - b) <= tolerance, `${what}: ${a} ${b}`);

function distances(solution, center) {
  const columns = solution.trajectory.columns.x;
  return solution.trajectory.x.map(x => Math.hypot(x[columns.indexOf('x')] - center[0],
                                                   x[columns.indexOf('y')] - center[1]));
}

test('discs to drive around stand in the scene, and their constraint is drawn', async () => {
  const {solution, page: file} = solve(problem('unicycle_obstacles'), 'discs');
  const {page, context, complaints, requests} = await open(file);
  for (const [name, at] of [['disc_1', 0.75], ['disc_2', 1.5], ['disc_3', 2.25]]) {
    const {center, half} = await obstacle(page, name);
    near(center[0], at, 1e-6, name);
    near(center[1], at, 1e-6, name);
    near(half[0], 0.425, 1e-3, name);
    const expected = distances(solution, [at, at]);
    const {lines: [line]} = await plot(page, name);
    assert.deepEqual(line.limit, {lower: 0.425, upper: null});
    assert.ok(!line.violated.includes(true));
    assert.equal(line.values[0], null, 'the first state is given');
    for (let k = 1; k < 100; ++k) near(line.values[k], expected[k], 1e-6, `${name} at node ${k}`);
  }
  const moments = await page.locator('#moments tbody tr').allTextContents();
  assert.equal(moments.length, 3);
  assert.ok(moments[0].startsWith('terminal/goal'));
  const multipliers = await plot(page, 'Largest multiplier of each constraint');
  const largest = Math.max(...solution.multipliers.constraints.filter(c => c.name === 'disc_1').flatMap(
      c => c.multiplier.map(Math.abs)));
  const drawn = multipliers.lines.find(l => l.name === 'disc_1').values.filter(v => v !== null);
  near(Math.max(...drawn), largest, 1e-6 * largest, 'multiplier of disc_1');
  assert.ok(largest > 0);

  await page.getByRole('button', {name: 'Obstacles', exact: true}).click();
  assert.equal(await page.evaluate(() => window.conddp.viewer.obstacles.root.visible), false);
  assert.deepEqual(ours(complaints), []);
  assert.deepEqual(requests, []);
  await context.close();
});

test('a constraint that was left out is drawn with its violations marked', async () => {
  const {solution, page: file} = solve(problem('unicycle_obstacles'), 'left_out',
                                       ...['disc_1', 'disc_2', 'disc_3'].flatMap(name => ['--drop', name]));
  const {page, context, complaints} = await open(file);
  const {lines: [line]} = await plot(page, 'disc_2 (left out)');
  const expected = distances(solution, [1.5, 1.5]);
  assert.ok(expected.some(d => d < 0.425), 'the way leads through the disc');
  for (let k = 1; k < 100; ++k) assert.equal(line.violated[k], expected[k] < 0.425 - 1e-8, `node ${k}`);
  const {lines} = await plot(page, 'Violation of each constraint');
  const violation = lines.find(l => l.name === 'disc_2 (left out)').values;
  for (let k = 1; k < 100; ++k)
    near(violation[k], Math.max(1e-16, 0.425 - expected[k]), 1e-7, `violation at node ${k}`);
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

test('obstacles and the shapes of an arm stand in its scene', async () => {
  const {page: file} = solve(problem('arm_obstacles'), 'arm');
  const {page, context, complaints, requests} = await open(file);
  const ball = await obstacle(page, 'ball');
  [0.6, 0, 0.4].forEach((at, i) => near(ball.center[i], at, 1e-6, 'ball'));
  near(ball.half[0], 0.2, 1e-6, 'ball');
  const pole = await obstacle(page, 'pole');
  [0.6, 0, 0.8].forEach((at, i) => near(pole.center[i], at, 1e-6, 'pole'));
  near(pole.half[2], 0.4 + 0.12, 1e-6, 'pole');
  near((await obstacle(page, 'table')).center[2], 0, 1e-6, 'table');
  const shapes = () => page.evaluate(() => window.conddp.viewer.robot.shapes.map(s => [s.name, s.visible]));
  assert.deepEqual(await shapes(), [['column', false], ['upper_arm', false], ['forearm', false], ['hand', false]]);
  await page.getByRole('button', {name: 'Shapes'}).click();
  assert.ok((await shapes()).every(([, visible]) => visible));
  assert.deepEqual(ours(complaints), []);
  assert.deepEqual(requests, []);
  await context.close();
});

test('the stages of a solver are marked, its counts drawn and its diagnosis is in words', async () => {
  const {solution, page: file} = solve(problem('arm_waypoint'), 'stages');
  const {page, context, complaints} = await open(file);
  const {log} = solution;
  const {marks} = await plot(page, 'Residuals');
  const last = log[log.length - 1];
  assert.ok(last.outer > 0 && last.newton > 0);
  assert.deepEqual(marks.filter(m => m.text !== 'Newton').map(m => Number(m.text)),
                   [...new Set(log.map(row => row.outer))].slice(1));
  const [newton] = marks.filter(m => m.text === 'Newton');
  assert.equal(newton.at, log.find(row => row.newton > 0).iteration);
  const penalties = await plot(page, 'Regularization and penalties');
  assert.deepEqual(penalties.lines.find(l => l.name === 'penalty of constraints').values,
                   log.map(row => (row.constraint_penalty > 0 ? row.constraint_penalty : null)));
  const active = await plot(page, 'Active set');
  assert.deepEqual(active.lines.find(l => l.name === 'active rows').values, log.map(row => row.active_rows));
  const words = (await page.textContent('.diagnosis')).toLowerCase();
  assert.ok(words.includes(solution.diagnosis.message.toLowerCase()), words);
  assert.ok((await page.textContent('#certificate')).includes(`All ${solution.certificate.checks.length} statements`));
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

test('the ground lies where the feet stand: on a slope, and under steps', async () => {
  const slope = await open(solve(problem('quadruped_trot_slope'), 'slope').page);
  const up = await slope.page.evaluate(() => {
    const {grid} = window.conddp.viewer.ground;
    return grid.up.clone().set(0, 1, 0).applyQuaternion(grid.quaternion).toArray();  // the grid's own normal
  });
  const angle = 15 * Math.PI / 180;
  [-Math.sin(angle), 0, Math.cos(angle)].forEach((n, i) => near(up[i], n, 1e-3, 'normal of the slope'));
  assert.deepEqual(ours(slope.complaints), []);
  await slope.context.close();

  const step = await open(solve(problem('hopper_jump'), 'step').page);
  const heights = await step.page.evaluate(() => window.conddp.viewer.ground.surfaces.map(s => s.height));
  assert.equal(heights.length, 2);
  near(heights[1] - heights[0], 0.15, 5e-3, 'the step');
  await step.context.close();
});

test('bounds on one side are a plane, and equal ones are drawn once', async () => {
  const {page: file} = solve(problem('planar_biped_gait'), 'one_side');
  const {page, context, complaints} = await open(file);
  const {center, half} = await obstacle(page, 'left_clear');
  near(center[2], 0.05, 1e-6, 'height of the feet');
  assert.equal(half[2], 0);
  assert.ok(half[0] > 0.3, 'as long as the motion');
  const shown = await page.evaluate(() => ['left_clear', 'right_clear'].map(
      name => window.conddp.viewer.obstacles.root.getObjectByName(name).visible));
  assert.deepEqual(shown, [true, false]);
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

test('small robots have small marks, and the grid cuts neither hills nor floating bodies', async () => {
  const seen = async name => {
    const {page, context} = await open(solve(problem(name), name).page);
    const found = await page.evaluate(() => {
      const {robot, ground, box} = window.conddp.viewer;
      const cone = robot.contacts[0].cone.geometry.parameters;
      return {size: robot.markSize, cone: cone.height, grid: ground.grid.position.z, low: box.min.z};
    });
    await context.close();
    return found;
  };
  const dog = await seen('quadruped_hills'), insect = await seen('hexapod_tripod'), pushed = await seen('push_box');
  assert.equal(dog.size, 1);
  near(dog.cone, 0.14, 1e-9, 'cone of a large robot');
  assert.ok(insect.size > 0.2 && insect.size < 0.8, String(insect.size));
  near(insect.cone, 0.14 * insect.size, 1e-9, 'cone of a small robot');
  assert.equal(insect.grid, 0);
  for (const {grid, low} of [dog, pushed]) assert.ok(low < -0.01 && grid < low, `${grid} ${low}`);
});

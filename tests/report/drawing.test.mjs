// Drawings of the problem file, views and files of the scene: node --test drawing.test.mjs
// browser.mjs lists the requirements.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';
import {test} from 'node:test';
import {folder, open, ours, run, solve, source, watch} from './browser.mjs';

const problem = name => join(source, 'problems', `${name}.yaml`);

/// Direction from the motion to the camera.
const direction = page => page.evaluate(() => {
  const {camera, controls} = window.conddp.viewer;
  return camera.position.clone().sub(controls.target).normalize().toArray().map(x => Math.round(x * 100) / 100 + 0);
});

test('drawings follow the motion in the plane, which is seen from above', async () => {
  const {solution, page: file} = solve(problem('trailer_parking'), 'trailer');
  const {page, context, complaints, requests} = await open(file);
  assert.deepEqual(await direction(page), [0, 0, 1]);
  const columns = solution.trajectory.columns.x;
  const k = 50, x = name => solution.trajectory.x[k][columns.indexOf(name)];
  await page.evaluate(t => window.conddp.player.seek(t), solution.trajectory.t[k]);
  const shown = await page.evaluate(() => {
    const {bodies, lines} = window.conddp.viewer.robot;
    const car = bodies.find(body => body.name === 'car');
    const shaft = lines.find(line => line.object.name === 'shaft');
    const ends = shaft.object.geometry.attributes;
    return {at: car.position.toArray(), angle: 2 * Math.atan2(car.quaternion.z, car.quaternion.w), corners: shaft.now,
            last: [ends.instanceEnd.getX(1), ends.instanceEnd.getY(1)]};
  });
  const near = (found, expected) => assert.ok(Math.abs(found - expected) < 1e-5, `${found} ${expected}`);
  near(shown.at[0], x('x'));
  near(shown.at[1], x('y'));
  near(shown.angle, x('theta'));
  near(shown.corners[3], x('x') - Math.cos(x('theta')));
  near(shown.last[0], x('x') - Math.cos(x('theta')) - 4 * Math.cos(x('psi')));
  near(shown.last[1], shown.corners[7]);
  // Scenery is in the picture, and is no obstacle of the problem.
  const opaque = await page.evaluate(() =>
      window.conddp.viewer.obstacles.root.getObjectByName('left_car').material.transparent);
  assert.equal(opaque, false);
  assert.deepEqual(ours(complaints), []);
  assert.deepEqual(requests, []);
  await context.close();
});

test('buttons show the motion from the front, the side and the top', async () => {
  const {page: file} = solve(problem('cartpole_swingup'), 'views');
  const {page, context} = await open(file);
  const first = await direction(page);
  for (const [name, expected] of [['Front', [1, 0, 0]], ['Side', [0, -1, 0]], ['Top', [0, 0, 1]], ['Reset', first]]) {
    await page.getByRole('button', {name, exact: true}).click();
    assert.deepEqual(await direction(page), expected, name);
  }
  await context.close();
});

test('the view is saved as a picture and the motion as a video', async () => {
  const {page: file} = solve(problem('hopper_jump'), 'saved');
  const {page, context, complaints} = await open(file);
  const button = name => page.locator('.switches').getByRole('button', {name, exact: true});
  const [picture] = await Promise.all([page.waitForEvent('download'), button('PNG').click()]);
  assert.equal(picture.suggestedFilename(), 'hopper_jump.png');
  assert.equal(readFileSync(await picture.path()).subarray(1, 4).toString(), 'PNG');
  const [video] = await Promise.all([page.waitForEvent('download'), button('Video').click()]);
  assert.equal(video.suggestedFilename(), 'hopper_jump.webm');
  assert.deepEqual(await watch(readFileSync(await video.path())), await page.evaluate(() => {
    const {viewer: {renderer: {domElement: canvas}}, player} = window.conddp;
    return {width: canvas.width & ~1, height: canvas.height & ~1, frames: Math.ceil(30 * player.duration) + 1, changes: true};
  }));
  assert.equal(await button('Video').count(), 1);
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

test('the tool records a motion, and players find its moments', async () => {
  const {solution, json} = solve(problem('hopper_jump'), 'recorded');
  const file = join(folder, 'recorded.webm');
  run('report', json, '--video', file);
  const frames = Math.ceil(30 * solution.trajectory.t.at(-1)) + 1;
  assert.deepEqual(await watch(readFileSync(file)), {width: 1280, height: 720, frames, changes: true});
});

test('impulses are marked on the time line', async () => {
  const {solution, page: file} = solve(problem('hopper_jump'), 'impulses');
  const {page, context} = await open(file);
  const {t, contact_forces: forces} = solution.trajectory;
  const expected = Object.entries(forces).map(([name, list]) => [name, list.filter((f, k) => f && t[k + 1] === t[k]).length]);
  const marks = await page.evaluate(() => [...document.querySelectorAll('#band .row')].slice(1).map(
      row => [row.querySelector('.name').textContent, row.querySelectorAll('.impulse').length]));
  assert.deepEqual(marks, expected);
  assert.ok(expected.some(([, count]) => count > 0));
  assert.match(await page.locator('#band .impulse').first().getAttribute('title'), /impulse of [\d.]+ Ns at/);
  await context.close();
});

test('limits are shaded when they hold', async () => {
  const {page: file} = solve(problem('car_parking_goal'), 'limits', '--set',
      'constraints.late={bounds: control, upper: {acceleration: 1.5}, phases: b}', '--set',
      'phases=[{name: a, knots: 50, dt: 0.15}, {name: b, knots: 50, dt: 0.15}]');
  const {page, context} = await open(file);
  const limits = await page.evaluate(() => {
    const {lines} = window.conddp.plots.find(p => p.lines.some(l => l.name === 'acceleration'));
    return lines.find(l => l.name === 'acceleration').limit;
  });
  assert.equal(limits.upper.length, 100);
  limits.upper.forEach((limit, k) => assert.equal(limit, k < 50 ? 2 : 1.5, `knot ${k}`));
  assert.ok(limits.lower.every(limit => limit === -2));
  await context.close();
});

// The page of a closed loop in a real browser.
import assert from 'node:assert/strict';
import {writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {test} from 'node:test';
import {folder, open, ours, run, source} from './browser.mjs';

/// Simulates a loop; returns its page.
function loop(problem, name, ...options) {
  const page = join(folder, `${name}.html`);
  run('mpc', problem, '-o', join(folder, name), '--report', page, ...options);
  return page;
}

/// Positions of the plant's bodies and of the ghost of its plan.
const places = page => page.evaluate(() => {
  const {viewer} = window.conddp;
  return {robot: viewer.robot.bodies[1].position.toArray(), plan: viewer.plan.robot.bodies[1].position.toArray()};
});

test('a closed loop has its plant, the plan of each tick, events and times of ticks', async () => {
  const file = loop(join(source, 'problems/quadruped_trot.yaml'), 'trot', '--set',
      'mpc={horizon: 0.3, tick: 0.02, duration: 0.4, repeat: gait, disturbances: [{at: 0.1, frame: trunk, ' +
      'force: [0, 30, 0], duration: 0.05}]}');
  const {page, context, complaints, requests} = await open(file);
  assert.match(await page.title(), /quadruped_trot/);
  assert.equal(await page.textContent('#status'), 'finished');
  assert.equal(await page.locator('#view canvas').count(), 1);
  assert.equal(await page.locator('#loop .histogram').count(), 2);
  assert.deepEqual(await page.locator('#outcomes tbody tr').allTextContents(), ['planned20']);
  assert.match(await page.locator('.events .bar').first().getAttribute('title'), /^push on trunk: 0.1 to 0.15 s/);

  // The plan leads away from the robot and changes over time.
  const early = await places(page);
  assert.ok(Math.hypot(...early.plan.map((x, i) => x - early.robot[i])) > 0.01, JSON.stringify(early));
  await page.keyboard.press('End');
  const late = await places(page);
  assert.ok(late.plan[0] > early.plan[0] + 0.01, JSON.stringify(late));
  // It ends with the plan.
  const {list, poses} = await page.evaluate(() => window.conddp.loop.plans);
  const last = list[list.length - 1], bodies = poses.length / 7 / list.reduce((sum, p) => sum + p.nodes, 0);
  const at = 7 * (bodies * (last.first + last.nodes - 1) + 1);
  assert.deepEqual(late.plan, poses.slice(at, at + 3));
  await page.locator('button', {hasText: /^Plan$/}).click();
  assert.equal(await page.evaluate(() => window.conddp.viewer.plan.root.visible), false);

  const titles = await page.evaluate(() => window.conddp.plots.map(plot => plot.title));
  assert.ok(titles.includes('Time of a tick') && titles.includes('Joint positions'), titles.join());
  assert.ok(titles.includes('Normal force') && titles.includes('Share of the friction cone'), titles.join());
  await page.locator('#theme').click();
  assert.deepEqual(ours(complaints), []);
  assert.deepEqual(requests, []);
  await context.close();
});

test('a closed loop without a picture of its system has its curves and events', async () => {
  const problem = join(folder, 'mass.yaml');
  writeFileSync(problem, `conddp: 1
name: mass
system: {states: {h: m, v: m/s}, controls: {u: N}, rate: {h: v, v: u}}
initial_state: {values: {h: 1}}
integrator: rk4
phases: [{name: only, knots: 10, dt: 0.05}]
costs: {state: {residual: state}, effort: {residual: control, weight: 0.1}}
solver: {name: box_fddp}
mpc:
  horizon: 0.5
  tick: 0.05
  duration: 1
  disturbances: [{at: 0.5, jump: {v: 9}}]
  stop_when: {fast: {residual: state, columns: v, lower: -8, upper: 8}}
`);
  const {page, context, complaints} = await open(loop(problem, 'mass'));
  assert.equal(await page.textContent('#status'), 'stopped');
  assert.equal(await page.locator('.events').count(), 2);
  assert.equal(await page.locator('#view canvas').count(), 0);
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

test('a closed loop on simulated contacts has the forces of its feet, in the view and over time', async () => {
  const file = loop(join(source, 'problems/quadruped_trot.yaml'), 'simulated', '--set',
      'mpc={horizon: 0.4, tick: 0.02, duration: 0.4, repeat: gait, plant: {contacts: simulated, dt: 0.002}}');
  const {page, context, complaints, requests} = await open(file);
  const feet = time => page.evaluate(at => {
    const {viewer, player} = window.conddp;
    player.seek(at);
    return viewer.robot.contacts.map(({name, force}) => ({name, visible: force.visible, up: force.userData.shaft.scale.z}));
  }, time);
  const standing = await feet(0.1), trotting = await feet(0.3);
  assert.deepEqual(standing.map(foot => foot.visible), [true, true, true, true]);
  assert.ok(standing.every(foot => foot.up > 1e-3), JSON.stringify(standing));
  assert.equal(trotting.filter(foot => foot.visible).length, 2, JSON.stringify(trotting));
  // The feet lift the robot of 50 kg.
  const carried = await page.evaluate(() => {
    const {solutions} = window.conddp, k = solutions[0].curves.t.findIndex(t => t >= 0.1);
    return solutions[0].contacts.reduce((sum, {forces}) => sum + forces[k][2], 0);
  });
  assert.ok(carried > 50 * 9.81 && carried < 1.3 * 50 * 9.81, String(carried));
  await page.locator('button', {hasText: /^Forces$/}).click();
  assert.equal(await page.evaluate(() => window.conddp.viewer.robot.forces.visible), false);
  assert.deepEqual(ours(complaints), []);
  assert.deepEqual(requests, []);
  await context.close();
});

// The page of a batch in a real browser.
import assert from 'node:assert/strict';
import {existsSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {test} from 'node:test';
import {folder, open, ours, run, source} from './browser.mjs';

/// A batch over two masses and four goals; three iterations cannot reach the last goal.
function batch(name, keep, ...options) {
  const plan = join(folder, `${name}.yaml`);
  writeFileSync(plan, `conddp_batch: 1
name: ${name}
problem: ${join(source, 'problems/pendulum_swingup.yaml')}
vary:
  weight: {key: costs.effort.weight, values: [0.01, 0.02]}
  angle: {key: initial_state.values.theta, values: [0.1, 0.2, 0.3]}
  most: {key: solver.max_iterations, values: [2, 300]}
keep: {solutions: ${keep}}
`);
  const out = join(folder, `${name}_run`);
  run('batch', 'plan', plan, '-o', out);
  run('batch', 'run', out, ...options);
  run('batch', 'report', out);
  return join(out, 'report.html');
}

test('a batch has counts, a map, distributions, trajectories and links to files that are there', async () => {
  const file = batch('swings', 'all');
  const {page, context, complaints, requests} = await open(file);
  assert.equal(await page.title(), 'swings – conddp');
  assert.match(await page.textContent('#batch'), /6 of 12 items are solved/);
  assert.deepEqual(await page.locator('#batch-status tbody tr').allTextContents(), ['converged650 %', 'max_iterations650 %']);

  // The map: two weights by three angles, half of each cell solved.
  const cells = () => page.locator('#batch-map .cell').evaluateAll(list => list.map(c => [c.dataset.column, c.dataset.row, Number(c.dataset.value)]));
  const byAngle = await cells();
  assert.equal(byAngle.length, 6);
  assert.ok(byAngle.every(([, , share]) => share === 0.5), JSON.stringify(byAngle));
  // Horizontal axis: the iteration limit, which decides.
  await page.locator('#batch-map select').nth(1).selectOption('2');
  const byLimit = await cells();
  assert.deepEqual(byLimit.map(([column, , share]) => `${column} ${share}`).sort(),
                   ['0 0', '0 0', '0 0', '1 1', '1 1', '1 1']);
  // Colour: cost of solved items only.
  await page.locator('#batch-map select').first().selectOption('1');
  assert.equal((await cells()).filter(([, , cost]) => cost > 0).length, 3);

  assert.equal(await page.locator('#batch .histogram').count(), 3);
  assert.equal(await page.locator('#overlay polyline.trajectory').count(), 12);
  await page.locator('#overlay select').selectOption('1');
  assert.equal(await page.locator('#overlay polyline.trajectory').count(), 12);

  const links = await page.locator('#batch a').evaluateAll(list => list.map(a => a.getAttribute('href')));
  assert.ok(links.some(link => link.endsWith('solution.json')));
  for (const link of links) assert.ok(existsSync(join(dirname(file), link)), link);
  // Outliers are overlaid in scene and plots.
  assert.ok(await page.evaluate(() => window.conddp.solutions.length) > 1);
  assert.equal(await page.locator('#view canvas').count(), 1);
  await page.locator('#theme').click();
  assert.deepEqual(ours(complaints), []);
  assert.deepEqual(requests, []);
  await context.close();
});

test('a batch that keeps no solutions has a page without motion', async () => {
  const {page, context, complaints} = await open(batch('bare', 'none'));
  assert.match(await page.textContent('#batch'), /6 of 12 items are solved/);
  assert.equal(await page.locator('#overlay').count(), 0);
  assert.equal(await page.locator('main').count(), 0);
  assert.equal(await page.evaluate(() => window.conddp.batch.items), 12);
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

test('a map leaves out items without a result, and what is not solved says why', async () => {
  // Every second item: the ones with two iterations.
  const {page, context, complaints} = await open(batch('half', 'none', '--shard', '1/2'));
  await page.locator('#batch-map select').nth(1).selectOption('2');
  const columns = await page.locator('#batch-map .cell').evaluateAll(list => list.map(c => c.dataset.column));
  assert.deepEqual(columns, ['0', '0', '0']);
  const table = page.locator('#batch section', {has: page.locator('h2', {hasText: 'Not solved'})}).locator('table');
  assert.ok((await table.locator('th').allTextContents()).includes('message'));
  assert.match(await table.locator('tbody tr').first().textContent(), /iterations/);
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

test('a batch of closed loops has a map of those that survived', async () => {
  const problem = join(folder, 'loop.yaml');
  writeFileSync(problem, `conddp: 1
system: {type: pendulum}
initial_state: {values: {theta: 0.1}}
phases: [{name: only, knots: 10, dt: 0.05}]
costs: {state: {residual: state}, effort: {residual: control, weight: 0.1}}
solver: {name: box_fddp}
mpc:
  horizon: 0.5
  tick: 0.05
  duration: 0.5
  disturbances: [{at: 0.2, jump: {omega: 1}}]
  stop_when: {fast: {residual: state, columns: omega, lower: -5, upper: 5}}
`);
  const plan = join(folder, 'loops.yaml');
  writeFileSync(plan, `conddp_batch: 1
name: loops
command: mpc
problem: ${problem}
vary:
  push: {key: mpc.disturbances.0.jump.omega, values: [1, 2, 10]}
`);
  const out = join(folder, 'loops_run');
  run('batch', 'plan', plan, '-o', out);
  run('batch', 'run', out);
  run('batch', 'report', out);
  const {page, context, complaints} = await open(join(out, 'report.html'));
  assert.match(await page.textContent('#batch'), /2 of 3 items survived/);
  assert.match(await page.textContent('#batch'), /Did not survive/);
  const cells = await page.locator('#batch-map .cell').evaluateAll(list => list.map(c => Number(c.dataset.value)));
  assert.deepEqual(cells, [1, 1, 0]);
  assert.equal(await page.locator('main').count(), 0);
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

// Reports in a real browser: node --test report.test.mjs
// browser.mjs lists the requirements.
import assert from 'node:assert/strict';
import {readFileSync, statSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {test} from 'node:test';
import {folder, open, ours, run, solve, source, until} from './browser.mjs';
import {footPosition, legChain} from './leg_kinematics.mjs';

/// World position of a contact's frame in the scene.
const contactInScene = (page, index) => page.evaluate(i =>
    window.conddp.viewer.robot.contactPosition(i).toArray(), index);

const problems = ['quadruped_trot', 'biped_squat', 'hopper_jump', 'arm_reach', 'cartpole_swingup'];

for (const name of problems) {
  test(`${name}: plays, scrubs, carries the trajectory, asks nobody and complains of nothing`, async () => {
    const {solution, page: file} = solve(join(source, 'problems', `${name}.yaml`), name);
    const {page, context, complaints, requests} = await open(file);
    assert.match(await page.title(), new RegExp(solution.problem.name));
    assert.equal(await page.textContent('#status'), solution.status);
    assert.equal(await page.locator('#view canvas').count(), 1, 'there is a scene');

    // Scrubbing by key: one knot, and the end.
    await page.keyboard.press('ArrowRight');
    const times = solution.trajectory.t;
    assert.ok(Math.abs(await page.evaluate(() => window.conddp.player.time) - times[1]) < 1e-9);
    await page.keyboard.press('End');
    assert.equal(await page.evaluate(() => window.conddp.player.time), times[times.length - 1]);

    // By pointer, in the middle of the band.
    const band = await page.locator('#band').boundingBox();
    await page.mouse.click(band.x + band.width / 2, band.y + 6);
    const middle = await page.evaluate(() => window.conddp.player.time);
    assert.ok(Math.abs(middle - times[times.length - 1] / 2) < 0.02 * times[times.length - 1], String(middle));

    // A pointer in a plot shows its time in the band.
    assert.equal(await page.locator('#band .pointer').isVisible(), false);
    const over = await page.locator('#plots .u-over').first().boundingBox();
    await page.mouse.move(over.x + over.width / 2, over.y + over.height / 2);
    const pointed = await page.evaluate(() => window.conddp.player.pointed);
    const mark = await page.locator('#band .pointer').boundingBox();
    assert.ok(Math.abs((mark.x - band.x) / band.width - pointed / times[times.length - 1]) < 0.01);
    await page.mouse.move(0, 0);

    // Playback advances and pauses, slowly enough for the shortest motion.
    await page.keyboard.press('Home');
    for (let i = 0; i < 3; i++) await page.keyboard.press('[');
    await page.keyboard.press('Space');
    await until(page, () => window.conddp.player.time > 0.005);
    assert.equal(await page.evaluate(() => window.conddp.player.playing), true);
    await page.keyboard.press('Space');
    assert.equal(await page.evaluate(() => window.conddp.player.playing), false);
    for (let i = 0; i < 3; i++) await page.keyboard.press(']');

    // The curves match the solution.
    const controls = await page.evaluate(() => {
      const plot = window.conddp.plots.find(p => p.lines.some(l => l.clamped) || /Control/.test(p.title));
      return {names: plot.lines.map(l => l.label), values: plot.u.data.slice(1)};
    });
    const columns = solution.trajectory.columns.u;
    controls.names.forEach((label, i) => {
      const column = columns.findIndex(c => c.replace(/^u\//, '') === label);
      assert.ok(column >= 0, label);
      solution.trajectory.u.forEach((u, k) => {
        if (u.length === 0) return;
        assert.ok(Math.abs(controls.values[i][k] - u[column]) <= 1e-6 * Math.max(1, Math.abs(u[column])));
      });
    });
    assert.deepEqual(ours(complaints), []);
    assert.deepEqual(requests, []);
    await context.close();
  });
}

test('feet in the scene are where the trajectory says, to a millimetre', async () => {
  const {solution, page: file} = solve(join(source, 'problems/quadruped_trot.yaml'), 'feet');
  const {page, context} = await open(file);
  const columns = solution.trajectory.columns.x;
  // Forward kinematics of the robot's left fore leg, from its URDF: hip, thigh and shank.
  const urdf = readFileSync(join(source, 'problems/robots/quadruped.urdf'), 'utf8');
  const chain = legChain(urdf, 'lf_foot');
  const index = await page.evaluate(() =>
      window.conddp.solutions[0].scene.contacts.findIndex(c => c.name === 'LF'));
  for (const k of [0, 9, 20, 33, 47, 64]) {
    const x = solution.trajectory.x[k];
    const value = name => x[columns.indexOf(name)];
    const expected = footPosition(chain, value);
    await page.evaluate(t => window.conddp.player.seek(t), solution.trajectory.t[k]);
    const found = await contactInScene(page, index);
    for (let i = 0; i < 3; ++i) assert.ok(Math.abs(found[i] - expected[i]) < 1e-3, `knot ${k}: ${found} ${expected}`);
  }
  await context.close();
});

test('the trot is smaller than 1.5 MB and opens', async t => {
  const {page: file} = solve(join(source, 'problems/quadruped_trot.yaml'), 'size');
  assert.ok(statSync(file).size < 1.5e6, String(statSync(file).size));
  const {page, context} = await open(file);
  const there = await page.evaluate(
      () => performance.getEntriesByType('navigation')[0].domContentLoadedEventEnd);
  await context.close();
  assert.ok(there > 0, String(there));
  t.diagnostic(`there after ${there.toFixed(0)} ms`);
});

test('no script or style runs but those of the page, whose hashes its policy names', async () => {
  const {page: file} = solve(join(source, 'problems/pendulum_swingup.yaml'), 'policy');
  const text = readFileSync(file, 'utf8');
  assert.ok(!text.includes('unsafe-inline'));
  const foreign = join(folder, 'policy/foreign.html');
  const parts = text.split('</body>');
  const end = parts.pop();
  writeFileSync(foreign, `${parts.join('</body>')}<script>window.hacked = 1</script>` +
      `<style>footer { display: none }</style></body>${end}`);
  const {page, context, complaints} = await open(foreign);
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.equal(await page.locator('#foot').isVisible(), true);
  assert.equal(complaints.filter(text => /Content Security Policy/.test(text)).length, 2, complaints.join());
  await context.close();
});

test('a Collada mesh has its colors, its unit and flat facets', async () => {
  writeFileSync(join(folder, 'cube.dae'), `<COLLADA><asset><unit meter="0.001"/><up_axis>Y_UP</up_axis></asset>
<library_effects><effect id="red_effect"><profile_COMMON><technique><phong><diffuse><color>1 0 0 1</color></diffuse></phong>
</technique></profile_COMMON></effect></library_effects>
<library_materials><material id="red"><instance_effect url="#red_effect"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="s"><float_array>0 0 0 200 0 0 0 200 0 0 0 100</float_array></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles material="m"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 0 1 3</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="scene"><node><translate>0 0 50</translate>
<instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="m" target="#red"/></technique_common>
</bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>`);
  const urdf = readFileSync(join(source, 'problems/robots/arm7.urdf'), 'utf8');
  writeFileSync(join(folder, 'meshes.urdf'), urdf.replace('<link name="link_1">',
      '<link name="link_1"><visual><geometry><mesh filename="cube.dae"/></geometry></visual>'));
  const problem = join(folder, 'meshes.yaml');
  writeFileSync(problem, readFileSync(join(source, 'problems/arm_reach.yaml'), 'utf8')
      .replace('robots/arm7.urdf', 'meshes.urdf'));
  const {page: file} = solve(problem, 'meshes');
  const {page, context} = await open(file);
  const found = await page.evaluate(() => {
    const meshes = [];
    window.conddp.viewer.robot.root.traverse(part => {
      if (!part.isMesh || !part.geometry.index || part.geometry.index.count !== 6) return;
      part.geometry.computeBoundingBox();
      meshes.push({flat: part.material.flatShading, color: part.material.color.getHexString(),
                   box: [part.geometry.boundingBox.min, part.geometry.boundingBox.max].map(p => p.toArray())});
    });
    return meshes;
  });
  assert.equal(found.length, 1);
  assert.equal(found[0].flat, true);
  assert.equal(found[0].color, 'ff0000');
  const expected = [[0, 0, 0.05], [0.2, 0.2, 0.15]];
  found[0].box.forEach((corner, i) => corner.forEach((x, axis) => assert.ok(Math.abs(x - expected[i][axis]) < 1e-5)));
  await context.close();
});

test('hostile names stay text', async () => {
  const name = '</script><script>window.hacked=1</script>"\'&<img src=x onerror=window.hacked=2>😀';
  const problem = join(folder, 'hostile.yaml');
  writeFileSync(problem, `conddp: 1
name: hostile
description: ${JSON.stringify(name)}
system: {type: double_integrator, dimension: 1}
initial_state: {state: [1, 0]}
phases: [{name: ${JSON.stringify(name)}, knots: 20, dt: 0.1}]
costs: {${JSON.stringify(name)}: {residual: control}}
constraints: {${JSON.stringify(name)}: {residual: state, columns: [q/0], at_most: 2}}
terminal: {costs: {goal: {residual: state, weight: 10}}}
solver: {name: altro}
`);
  const {page: file} = solve(problem, 'hostile');
  const {page, context, complaints, requests} = await open(file);
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.equal(await page.locator('img').count(), 0);
  assert.ok((await page.textContent('#band')).includes(name));
  assert.ok((await page.locator('#plots figcaption').allTextContents()).some(text => text.includes(name)));
  assert.deepEqual(ours(complaints), []);
  assert.deepEqual(requests, []);
  await context.close();
});

test('two solutions share plots, a table and the scene; one of them can be hidden', async () => {
  const a = solve(join(source, 'problems/hopper_jump.yaml'), 'pair_a');
  const b = solve(join(source, 'problems/hopper_jump.yaml'), 'pair_b', '--set', 'costs.effort.weight=0.1');
  const file = join(folder, 'pair.html');
  run('bench', join(source, 'problems/hopper_jump.yaml'), '--solvers', 'box_fddp,ilqr', '--repeat', '0',
      '-o', join(folder, 'pair_bench'));
  run('report', a.json, b.json, '--bench', join(folder, 'pair_bench/bench.json'), '-o', file);
  const {page, context, complaints, requests} = await open(file);
  assert.equal(await page.locator('#comparison tbody tr').count(), 2);
  const measured = await page.locator('#bench tbody tr').allTextContents();
  assert.equal(measured.length, 2);
  assert.match(measured[0], /hopper_jump.*box_fddp.*solved/);
  assert.match(measured[1], /ilqr.*refused/);
  assert.equal(await page.locator('#view canvas').count(), 1);
  const shown = () => page.evaluate(() => ({
    robots: window.conddp.viewer.robots.map(r => r.root.visible),
    lines: window.conddp.plots[0].u.series.slice(1).map(s => s.show),
    solutions: window.conddp.plots[0].lines.map(l => l.solution),
  }));
  const before = await shown();
  assert.ok(before.lines.every(show => show) && before.solutions.includes(1));
  await page.locator('#comparison input').nth(1).uncheck();
  const after = await shown();
  assert.deepEqual(after.robots, [true, false]);
  after.lines.forEach((show, i) => assert.equal(show, after.solutions[i] === 0));
  assert.deepEqual(ours(complaints), []);
  assert.deepEqual(requests, []);
  await context.close();
});

test('2000 knots are drawn without complaint', async t => {
  const {page: file} = solve(join(source, 'problems/quadruped_stand.yaml'), 'long',
                             '--set', 'phases=[{name: stand, knots: 2000, dt: 0.005, contacts: all}]');
  const {page, context, complaints} = await open(file);
  const scripted = await page.evaluate(() => {
    const {player, viewer} = window.conddp;
    viewer.draw = () => {};  // excludes the time of the software renderer
    const start = performance.now();
    for (let i = 0; i < 100; ++i) player.seek(player.duration * i / 100);
    return (performance.now() - start) / 100;
  });
  t.diagnostic(`${scripted.toFixed(1)} ms a frame besides drawing`);
  assert.ok(scripted < 8, 'half of what sixty frames a second leave');
  assert.equal(await page.evaluate(() => window.conddp.plots[0].u.data[0].length), 2001);
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

test('at the width of a phone nothing sticks out, in the dark too', async () => {
  const {page: file} = solve(join(source, 'problems/hopper_jump.yaml'), 'phone');
  const {page, context} = await open(file, {viewport: {width: 375, height: 740}, colorScheme: 'dark'});
  assert.equal(await page.getAttribute('html', 'data-theme'), 'dark');
  const overflow = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  assert.ok(overflow <= 0, `${overflow} px`);
  await page.keyboard.press('d');
  assert.equal(await page.getAttribute('html', 'data-theme'), 'light');
  await context.close();
});

test('a plot is saved as a picture by one click', async () => {
  const {page: file} = solve(join(source, 'problems/cartpole_swingup.yaml'), 'picture');
  const {page, context} = await open(file);
  const [download] = await Promise.all([page.waitForEvent('download'),
                                        page.locator('figcaption button').first().click()]);
  const png = readFileSync(await download.path());
  assert.equal(png.subarray(1, 4).toString(), 'PNG');
  assert.ok(png.length > 3000);
  await context.close();
});

test('a click in the legend hides a line', async () => {
  const {page: file} = solve(join(source, 'problems/cartpole_swingup.yaml'), 'legend');
  const {page, context} = await open(file);
  const shown = () => page.evaluate(() => window.conddp.plots[0].u.series.map(s => s.show));
  await page.locator('#plots figure').first().locator('.u-legend .u-series').nth(1).locator('th').click();
  assert.equal((await shown())[1], false);
  // Without a pointer, the legend shows the values at the player's time.
  await page.keyboard.press('End');
  await page.mouse.move(0, 0);
  await page.waitForTimeout(300);
  const read = await page.evaluate(() => window.conddp.plots[0].u.legend.idx);
  assert.equal(read, await page.evaluate(() => window.conddp.plots[0].u.data[0].length - 1));
  await context.close();
});

test('a field shows the lines of many joints by name', async () => {
  const {page: file} = solve(join(source, 'problems/biped_squat.yaml'), 'filter');
  const {page, context, complaints} = await open(file);
  const shown = () => page.evaluate(() => {
    const plot = window.conddp.plots.find(p => p.title === 'Joint positions');
    return plot.lines.filter((_, i) => plot.u.series[i + 1].show).map(line => line.label);
  });
  const before = await shown();
  const figure = page.locator('figure', {hasText: 'Joint positions'});
  await figure.locator('input').fill('knee');
  assert.deepEqual(await shown(), ['l_knee', 'r_knee']);
  assert.equal(await figure.locator('.u-legend .u-series:visible').count(), 3, 'with the time');
  await page.keyboard.type('d');
  assert.equal(await page.getAttribute('html', 'data-theme'), 'light', 'keys are text there');
  await figure.locator('input').fill('');
  assert.deepEqual(await shown(), before);
  assert.equal(await page.locator('figure', {hasText: 'Base position'}).locator('input').count(), 0);
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

test('on paper the page is light and has no buttons', async () => {
  const {page: file} = solve(join(source, 'problems/hopper_jump.yaml'), 'paper');
  const {page, context, complaints} = await open(file, {colorScheme: 'dark'});
  await page.emulateMedia({media: 'print'});
  assert.equal(await page.locator('#play').isVisible(), false);
  assert.equal(await page.locator('figcaption button').first().isVisible(), false);
  const theme = () => page.getAttribute('html', 'data-theme');
  await page.evaluate(() => window.dispatchEvent(new Event('beforeprint')));
  assert.equal(await theme(), 'light');
  await page.evaluate(() => window.dispatchEvent(new Event('afterprint')));
  assert.equal(await theme(), 'dark');
  assert.ok((await page.pdf()).length > 20000);
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

test('meshes beside the URDF are drawn', async () => {
  writeFileSync(join(folder, 'wedge.obj'), 'v 0 0 0\nv 0.5 0 0\nv 0 0.25 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n');
  const inertial = '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>';
  writeFileSync(join(folder, 'wedge.urdf'), `<robot name="wedge"><link name="world"/><link name="arm">${inertial}
<visual><origin xyz="0 0 -1"/><geometry><mesh filename="wedge.obj" scale="2 2 1"/></geometry></visual></link>
<joint name="j" type="continuous"><parent link="world"/><child link="arm"/><axis xyz="0 0 1"/></joint></robot>`);
  const problem = join(folder, 'wedge.yaml');
  writeFileSync(problem, `conddp: 1
name: wedge
robot: {urdf: wedge.urdf, base: fixed}
initial_state: {joints: {j: 0.1}}
phases: [{name: swing, knots: 10, dt: 0.02}]
costs: {effort: {residual: control}}
`);
  const {page: file} = solve(problem, 'wedge');
  const {page, context, complaints, requests} = await open(file);
  const size = await page.evaluate(() => {
    const mesh = [];
    window.conddp.viewer.robot.bodies[1].traverse(part => { if (part.isMesh) mesh.push(part); });
    mesh[0].geometry.computeBoundingBox();
    const max = mesh[0].geometry.boundingBox.max.toArray().map(x => Math.round(x * 5e4) / 5e4);
    return {count: mesh.length, max, scale: mesh[0].parent.scale.toArray(),
            at: mesh[0].parent.position.toArray()};
  });
  assert.deepEqual(size, {count: 1, max: [0.5, 0.25, 1], scale: [2, 2, 1], at: [0, 0, -1]});
  assert.deepEqual(ours(complaints), []);
  assert.deepEqual(requests, []);
  await context.close();
});

/// A one-joint arm whose link has the visuals of the URDF; returns its problem.
function swingingArm(name, {looks, angle = 0.1}) {
  const inertial = '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>';
  writeFileSync(join(folder, `${name}.urdf`), `<robot name="${name}"><link name="world"/><link name="arm">${inertial}
${looks}</link><joint name="j" type="continuous"><parent link="world"/><child link="arm"/><axis xyz="0 0 1"/></joint></robot>`);
  const problem = join(folder, `${name}.yaml`);
  writeFileSync(problem, `conddp: 1
name: ${name}
robot: {urdf: ${name}.urdf, base: fixed}
initial_state: {joints: {j: ${angle}}}
phases: [{name: swing, knots: 10, dt: 0.02}]
costs: {effort: {residual: control}}
`);
  return problem;
}

test('links that are drawn by stand-ins are named, with the reason', async () => {
  const looks = '<visual><geometry><mesh filename="package://nobody/arm.stl"/></geometry></visual>' +
      '<collision><geometry><box size="1 0.2 0.1"/></geometry></collision>';
  const {page: file} = solve(swingingArm('meshless', {looks}), 'meshless');
  const {page, context, complaints} = await open(file);
  assert.equal(await page.textContent('#stand-ins summary'),
               'Drawn by stand-ins: arm – collision shape (mesh not found)');
  assert.deepEqual(await page.locator('#stand-ins tbody td').allTextContents(),
                   ['arm', 'collision shape', 'mesh not found: package://nobody/arm.stl']);
  const sides = await page.evaluate(() => window.conddp.viewer.robot.bodies[1].children.filter(
      part => part.isMesh && part.geometry.type === 'BoxGeometry').map(part => part.geometry.parameters.width));
  assert.deepEqual(sides, [1]);
  assert.deepEqual(ours(complaints), []);
  await context.close();

  const whole = await open(solve(join(source, 'problems/cartpole_swingup.yaml'), 'whole').page);
  assert.equal(await whole.page.locator('#stand-ins').count(), 0);
  await whole.context.close();
});

test('numbers of axes have room, however wide they are', async () => {
  const {page: file} = solve(swingingArm('wide', {looks: '', angle: -1.0e+9}), 'wide');
  const {page, context} = await open(file);
  const axes = await page.evaluate(() => window.conddp.plots.map(({title, u}) => {
    const axis = u.axes[1];
    u.ctx.font = axis.font[0];
    const widths = axis._values.map(text => u.ctx.measureText(text).width / devicePixelRatio);
    return {title, needed: Math.max(...widths) + axis.ticks.size + axis.gap, given: u.bbox.left / devicePixelRatio};
  }));
  for (const {title, needed, given} of axes) assert.ok(given >= needed, `${title}: ${given} of ${needed}`);
  assert.ok(axes.some(({needed}) => needed > 70), 'one of them is wide');
  await context.close();
});

test('a motion that found its contacts shows their forces and when they hold', async () => {
  const {page: file, solution} = solve(join(source, 'problems/block_slope.yaml'), 'found');
  assert.equal(solution.status, 'converged');
  const {page, context, complaints} = await open(file);
  const columns = solution.trajectory.columns.u;
  const names = columns.flatMap(c => c.match(/^contact\/(.*)\/fn$/)?.[1] ?? []);
  assert.ok(names.length > 0);
  // The time line: one row per candidate, with bars while it has a force.
  const rows = await page.evaluate(() => [...document.querySelectorAll('#band .row:not(.phases)')].map(
      row => ({name: row.querySelector('.name').textContent, bars: row.querySelectorAll('.bar').length})));
  assert.deepEqual(rows.map(row => row.name), names);
  const force = (name, k) => solution.trajectory.u[k][columns.indexOf(`contact/${name}/fn`)];
  const peak = Math.max(...names.flatMap(name => solution.trajectory.u.map((_, k) => force(name, k))));
  for (const {name, bars} of rows)
    assert.equal(bars > 0, solution.trajectory.u.some((_, k) => force(name, k) > 1e-3 * peak), name);
  // The plot: normal forces of the solution.
  const plots = await page.evaluate(() => window.conddp.plots.map(({title, u, lines}) => ({
    title, lines: lines.map(({label}, i) => ({label, values: Array.from(u.data[i + 1])}))})));
  const normal = plots.find(({title}) => title === 'Normal force');
  for (const {label, values} of normal.lines)
    solution.trajectory.u.forEach((_, k) => {
      const expected = force(label, k);
      if (expected > 1e-3 * peak) assert.ok(Math.abs(values[k] - expected) < 1e-6 * peak, `${label} at ${k}`);
    });
  assert.deepEqual(plots.filter(({title}) => title === 'Controls').flatMap(({lines}) => lines).filter(
      ({label}) => /^contact/.test(label)), []);
  // The scene: an arrow at each contact that pushes.
  const pushing = names.filter(name => force(name, 1) > 1e-3 * peak);
  assert.ok(pushing.length > 0);
  await page.evaluate(t => window.conddp.player.seek(t), (solution.trajectory.t[1] + solution.trajectory.t[2]) / 2);
  assert.deepEqual(await page.evaluate(() => window.conddp.viewer.robot.contacts.filter(
      c => c.force.visible).map(c => c.name)), pushing);
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

test('an answer that diverged is shown without complaint', async () => {
  const {page: file, solution} = solve(
      join(source, 'problems/quadruped_trot.yaml'), 'diverged', '--solver', 'ilqr', '--drop', 'torque',
      '--set', 'initial_guess={controls: {constant: 1.0e+200}}');
  assert.equal(solution.status, 'diverged');
  const {page, context, complaints} = await open(file);
  assert.equal(await page.textContent('#status'), 'diverged');
  assert.ok((await page.textContent('#head .diagnosis')).length > 20);
  await page.keyboard.press('End');
  assert.deepEqual(ours(complaints), []);
  await context.close();
});

// Play controls, and the bands of phases and contacts on a common time axis.
import {element, figure, isTyping} from './dom.js';
import {nodeAt, phaseAt} from './data.js';

const speeds = [0.1, 0.25, 0.5, 1, 2];

const percent = (value, duration) => `${(duration > 0 ? 100 * value / duration : 0).toFixed(3)}%`;

function bar(from, to, duration, attributes, text = '') {
  const node = element('div', {class: 'bar', ...attributes}, text);
  node.style.left = percent(from, duration);
  node.style.width = percent(to - from, duration);
  return node;
}

/// The time intervals with a contact force.
function stances(t, forces) {
  const spans = [];
  forces.forEach((force, k) => {
    if (!force || t[k + 1] === t[k]) return;
    const last = spans[spans.length - 1];
    if (last && last[1] === t[k]) last[1] = t[k + 1];
    else spans.push([t[k], t[k + 1]]);
  });
  return spans;
}

/// The impulses on a contact, Ns: forces at knots without duration.
function impulses(t, forces) {
  const list = [];
  forces.forEach((force, k) => {
    if (force && force[0] !== null && t[k + 1] === t[k])
      list.push({at: t[k], size: Math.hypot(force[0], force[1], force[2])});
  });
  return list;
}

/// The row of a contact: when it holds, and its impulses.
function contactRow({name, forces}, t, duration) {
  const row = element('div', {class: 'row'}, element('span', {class: 'name', title: name}, name));
  for (const [from, to] of stances(t, forces))
    row.append(bar(from, to, duration, {title: `${name} holds from ${figure(from)} to ${figure(to)} s`}));
  for (const {at, size} of impulses(t, forces))
    row.append(bar(at, at, duration, {class: 'bar impulse', title: `${name}: impulse of ${figure(size)} Ns at ${figure(at)} s`}));
  return row;
}

export class Timeline {
  /// `events`: {row, from, to, text} of a closed loop; events of the same row are next to each
  /// other.
  constructor(holder, solution, player, events = []) {
    this.solution = solution;
    this.player = player;
    const t = solution.curves.t, duration = solution.duration || 1;

    this.button = element('button', {type: 'button', id: 'play', title: 'Play or pause (space)',
                                     onclick: () => player.play(!player.playing)}, '▶ Play');
    const speed = element('select', {title: 'Speed ([ and ])', id: 'speed', onchange: () => {
      player.speed = Number(speed.value);
    }}, ...speeds.map(s => element('option', {value: s}, `${s}×`)));
    speed.value = '1';
    this.speed = speed;
    this.read = element('output', {id: 'time'});
    const step = (label, title, by) => element('button', {type: 'button', title,
                                                         onclick: () => this.step(by)}, label);
    holder.append(element('div', {class: 'player'}, this.button,
        step('◀', 'One knot back (←)', -1), step('▶', 'One knot on (→)', 1), speed, this.read));

    const band = element('div', {class: 'band', id: 'band'});
    const phases = element('div', {class: 'row phases'}, element('span', {class: 'name'}, 'phase'));
    this.phaseBars = solution.curves.phases.map(phase => {
      const from = t[phase.first_knot], to = t[phase.first_knot + phase.knots];
      const node = bar(from, to, duration, {title: `${phase.name}: ${phase.knots} knots, ` +
          `${figure(from)} to ${figure(to)} s`}, to > from ? phase.name : '');
      phases.append(node);
      return {phase, node};
    });
    // Bars occupy the part to the right of the names.
    band.append(phases);
    for (const entry of solution.contacts) band.append(contactRow(entry, t, duration));
    for (const name of new Set(events.map(event => event.row))) {
      const row = element('div', {class: 'row events'}, element('span', {class: 'name', title: name}, name));
      for (const {from, to, text} of events.filter(event => event.row === name))
        row.append(bar(from, to, duration, {title: `${text}: ${figure(from)} to ${figure(to)} s`}));
      band.append(row);
    }
    this.needle = element('div', {class: 'needle'});
    this.pointer = element('div', {class: 'pointer'});
    this.track = element('div', {class: 'track'}, this.needle, this.pointer);
    band.append(this.track);
    const seek = event => {
      const box = this.track.getBoundingClientRect();
      player.seek(duration * (event.clientX - box.left) / box.width);
    };
    band.addEventListener('pointerdown', event => {
      band.setPointerCapture(event.pointerId);
      seek(event);
    });
    band.addEventListener('pointermove', event => {
      if (event.buttons & 1) seek(event);
    });
    holder.append(band);
    this.addKeys();
    player.listen(() => this.show());
    player.onPoint = time => {
      this.pointer.hidden = time === null || time < 0 || time > duration;
      this.pointer.style.left = percent(time ?? 0, duration);
    };
    player.onPoint(null);
    this.show();
  }

  /// Moves to the next or previous node at another time.
  step(by) {
    const t = this.solution.curves.t;
    let {k, share} = nodeAt(t, this.player.time + 1e-9);
    if (by < 0 && share > 1e-6) by += 1;
    k = Math.min(t.length - 1, Math.max(0, k + by));
    while (by < 0 && k > 0 && t[k] >= this.player.time - 1e-12) --k;
    while (by > 0 && k < t.length - 1 && t[k] <= this.player.time + 1e-12) ++k;
    this.player.play(false);
    this.player.seek(t[k]);
  }

  addKeys() {
    const actions = {
      ' ': () => this.player.play(!this.player.playing),
      ArrowLeft: () => this.step(-1),
      ArrowRight: () => this.step(1),
      Home: () => this.player.seek(0),
      End: () => this.player.seek(this.player.duration),
      '[': () => this.changeSpeed(-1),
      ']': () => this.changeSpeed(1),
    };
    document.addEventListener('keydown', event => {
      if (event.ctrlKey || event.metaKey || event.altKey || isTyping(event)) return;
      if (event.key === ' ' && event.target.tagName === 'BUTTON') return;
      const action = actions[event.key];
      if (!action) return;
      event.preventDefault();
      action();
    });
  }

  changeSpeed(by) {
    const now = speeds.indexOf(this.player.speed);
    this.player.speed = speeds[Math.min(speeds.length - 1, Math.max(0, now + by))];
    this.speed.value = String(this.player.speed);
  }

  show() {
    const {time, duration, playing} = this.player;
    this.button.textContent = playing ? '❚❚ Pause' : '▶ Play';
    this.needle.style.left = percent(time, duration);
    const {k} = nodeAt(this.solution.curves.t, time);
    const phase = phaseAt(this.solution, k);
    this.read.textContent = `${time.toFixed(3)} s · knot ${k} · ${phase?.name ?? ''}`;
    for (const entry of this.phaseBars)
      entry.node.classList.toggle('now', entry.phase === phase);
  }
}

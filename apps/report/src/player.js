// The time shared by all views.

export class Player {
  constructor(duration) {
    this.duration = duration;
    this.time = 0;
    this.speed = 1;
    this.playing = false;
    this.listeners = [];
    this.pointed = null;  // time under the pointer in a plot
    this.onPoint = () => {};
    this.last = null;
  }

  listen(listener) {
    this.listeners.push(listener);
  }

  notify() {
    for (const listener of this.listeners) listener(this);
  }

  point(time) {
    if (time === this.pointed) return;
    this.pointed = time;
    this.onPoint(time);
  }

  seek(time) {
    this.time = Math.min(this.duration, Math.max(0, time));
    this.notify();
  }

  play(on = true) {
    if (on && this.time >= this.duration) this.time = 0;
    this.playing = on;
    this.last = null;
    if (on) requestAnimationFrame(now => this.advance(now));
    this.notify();
  }

  advance(now) {
    if (!this.playing) return;
    if (this.last !== null) this.time += this.speed * (now - this.last) / 1000;
    this.last = now;
    if (this.time >= this.duration) {
      this.time = this.duration;
      this.playing = false;
    }
    this.notify();
    if (this.playing) requestAnimationFrame(next => this.advance(next));
  }
}

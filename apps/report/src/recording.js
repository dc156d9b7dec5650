// Files of the scene: a picture of the view, and a video of the motion.
import {element} from './dom.js';

function save(blob, name) {
  const href = URL.createObjectURL(blob);
  element('a', {href, download: name}).click();
  setTimeout(() => URL.revokeObjectURL(href), 10000);
}

/// A problem's name as part of a file name.
const fileName = name => name.replace(/[^\w.-]+/g, '_');

export function savePicture(canvas, name) {
  canvas.toBlob(blob => save(blob, `${fileName(name)}.png`), 'image/png');
}

const videoType = 'video/webm';

/// Plays the motion once, at the player's speed, and saves what the canvas shows.
export class MotionRecorder {
  /// `button` starts and stops it; null in browsers that do not record WebM.
  constructor(canvas, player, name) {
    this.canvas = canvas;
    this.player = player;
    this.name = `${fileName(name)}.webm`;
    const supported = globalThis.MediaRecorder?.isTypeSupported(videoType) && canvas.captureStream;
    this.button = supported ? element('button', {type: 'button', onclick: () => this.toggle()}) : null;
    this.show();
    player.listen(() => {
      if (this.recorder && !player.playing) this.stop();
    });
  }

  show() {
    if (!this.button) return;
    this.button.textContent = this.recorder ? '■ Stop' : 'Video';
    this.button.title = this.recorder ? 'Stop recording and save' : 'Record the motion as a WebM video';
  }

  toggle() {
    if (this.recorder) this.player.play(false);
    else this.start();
  }

  start() {
    const parts = [];
    const recorder = new MediaRecorder(this.canvas.captureStream(60), {mimeType: videoType, videoBitsPerSecond: 8e6});
    recorder.addEventListener('dataavailable', event => parts.push(event.data));
    recorder.addEventListener('stop', () => save(new Blob(parts, {type: videoType}), this.name));
    // The recorder comes after the first frame has been set: seeking stops a recording.
    this.player.play(false);
    this.player.seek(0);
    recorder.start();
    this.player.play();
    this.recorder = recorder;
    this.show();
  }

  /// The last frame stays for a moment, so that the recorder sees it.
  stop() {
    const {recorder} = this;
    this.recorder = null;
    this.show();
    setTimeout(() => recorder.stop(), 200);
  }
}

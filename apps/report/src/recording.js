// Files of the scene: a picture of the view, and a video of the motion.
import {element} from './dom.js';
import {webmFile} from './webm.js';

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

const framesPerSecond = 30;

/// Shows the motion frame by frame at the player's speed and encodes what the canvas shows. Frames are
/// evenly spaced, however long the browser takes to draw them. Yields the share that is done after
/// each second of the video, and returns the file.
export async function* recordMotion(canvas, player) {
  // Encoders take even sizes.
  const width = canvas.width & ~1, height = canvas.height & ~1;
  const frames = Math.ceil(framesPerSecond * player.duration / player.speed) + 1;
  const time = frame => Math.round(1e3 * frame / framesPerSecond);
  let encoded = [], failure = null;
  const encoder = new VideoEncoder({
    output: chunk => {
      const data = new Uint8Array(chunk.byteLength);
      chunk.copyTo(data);
      encoded.push({data, time: Math.round(chunk.timestamp / 1e3), key: chunk.type === 'key'});
    },
    error: error => { failure = error; },
  });
  encoder.configure({codec: 'vp8', width, height, bitrate: 8e6, framerate: framesPerSecond});
  const clusters = [];
  player.play(false);
  for (let frame = 0; frame < frames; ++frame) {
    player.seek(frame * player.speed / framesPerSecond);
    const picture = new VideoFrame(canvas, {timestamp: 1e3 * time(frame), visibleRect: {x: 0, y: 0, width, height}});
    encoder.encode(picture, {keyFrame: frame % framesPerSecond === 0});
    picture.close();
    if ((frame + 1) % framesPerSecond !== 0 && frame + 1 !== frames) continue;
    await encoder.flush();
    if (failure) throw failure;
    clusters.push(encoded);
    encoded = [];
    yield (frame + 1) / frames;
  }
  encoder.close();
  const file = webmFile({codec: 'V_VP8', width, height, duration: time(frames), clusters});
  return new Blob(file, {type: 'video/webm'});
}

/// The motion for `conddp report --video`, in a picture of this size; returns base64.
export async function* recordForTool(viewer, width, height) {
  if (!viewer.ready) throw new Error('the page shows no picture');
  Object.assign(viewer.holder.style, {position: 'fixed', border: 'none', width: `${width}px`, height: `${height}px`});
  viewer.resize();
  viewer.resetView();
  const file = yield* recordMotion(viewer.renderer.domElement, viewer.player);
  const reader = new FileReader();
  await new Promise((done, fail) => {
    Object.assign(reader, {onload: done, onerror: () => fail(reader.error)});
    reader.readAsDataURL(file);
  });
  return reader.result.slice(reader.result.indexOf(',') + 1);
}

/// The button that saves the motion as a video; null in browsers that do not encode.
export function videoButton(canvas, player, name) {
  if (!globalThis.VideoEncoder) return null;
  const label = 'Video';
  const button = element('button', {type: 'button', title: 'Save the motion as a WebM video'}, label);
  button.addEventListener('click', async () => {
    button.disabled = true;
    try {
      const recording = recordMotion(canvas, player);
      let step;
      while (!(step = await recording.next()).done) button.textContent = `${Math.round(100 * step.value)} %`;
      save(step.value, `${fileName(name)}.webm`);
      button.textContent = label;
    } catch (error) {
      button.textContent = 'No video';
      button.title = String(error);
    }
    button.disabled = false;
  });
  return button;
}

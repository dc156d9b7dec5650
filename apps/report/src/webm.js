// A WebM file of one video track, in memory: the subset of EBML that players need to seek.
// https://www.matroska.org/technical/elements.html lists the elements.

const size = parts => parts.reduce((sum, part) => sum + part.length, 0);

/// `count` bytes of a number, most significant first.
const bytes = (number, count) =>
    Uint8Array.from({length: count}, (_, i) => Math.floor(number / 2 ** (8 * (count - 1 - i))) % 256);

const text = ascii => Uint8Array.from(ascii, letter => letter.charCodeAt(0));

function float(number) {
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, number);
  return new Uint8Array(view.buffer);
}

/// An element as a list of byte arrays: its identifier, its size in eight bytes, its contents.
function element(id, ...parts) {
  const contents = parts.flat();
  const length = bytes(size(contents), 8);
  length[0] = 0x01;  // marks a size of eight bytes
  return [bytes(id, id > 0xffffff ? 4 : id > 0xffff ? 3 : id > 0xff ? 2 : 1), length, ...contents];
}

/// The parts of a file. `clusters`: lists of frames {data, time, key}, each beginning with a key
/// frame; times in milliseconds.
export function webmFile({codec, width, height, duration, clusters}) {
  const head = element(0x1a45dfa3,
      element(0x4286, bytes(1, 1)), element(0x42f7, bytes(1, 1)),  // version of EBML
      element(0x42f2, bytes(4, 1)), element(0x42f3, bytes(8, 1)),  // longest identifier and size
      element(0x4282, text('webm')), element(0x4287, bytes(4, 1)), element(0x4285, bytes(2, 1)));
  const info = element(0x1549a966,
      element(0x2ad7b1, bytes(1e6, 4)),  // nanoseconds in a unit of time
      element(0x4489, float(duration)), element(0x4d80, text('conddp')), element(0x5741, text('conddp')));
  const tracks = element(0x1654ae6b, element(0xae,
      element(0xd7, bytes(1, 1)), element(0x73c5, bytes(1, 1)),  // number and identifier
      element(0x9c, bytes(0, 1)),                                // no lacing
      element(0x83, bytes(1, 1)), element(0x86, text(codec)),
      element(0xe0, element(0xb0, bytes(width, 2)), element(0xba, bytes(height, 2)))));
  const written = clusters.map(frames => element(0x1f43b675, element(0xe7, bytes(frames[0].time, 4)),
      ...frames.map(({data, time, key}) => element(0xa3, Uint8Array.of(
          0x81, ...bytes(time - frames[0].time, 2), key ? 0x80 : 0), data))));
  // Cues point to clusters behind them: their own size does not depend on the positions.
  const cues = positions => element(0x1c53bb6b, ...clusters.map((frames, i) => element(0xbb,
      element(0xb3, bytes(frames[0].time, 4)),
      element(0xb7, element(0xf7, bytes(1, 1)), element(0xf1, bytes(positions[i], 8))))));
  let position = size(info) + size(tracks) + size(cues(clusters.map(() => 0)));
  const positions = written.map(cluster => {
    position += size(cluster);
    return position - size(cluster);
  });
  return [...head, ...element(0x18538067, info, tracks, cues(positions), ...written)];
}

// The state of the charge frame by frame, as the page carries it: a description in JSON and one packed piece of bytes.
async function bytesOf(base64) {
  const packed = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const plain = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Response(plain).arrayBuffer();
}

const kinds = { u1: Uint8Array, i1: Int8Array, u2: Uint16Array, i2: Int16Array, u4: Uint32Array, f4: Float32Array };

// Numbers of two bytes that were written as what changed since the frame before, all low bytes before all high ones.
function undone(block, buffer) {
  const bytes = new Uint8Array(buffer, block.at, 2 * block.count), numbers = new Uint16Array(block.count);
  for (let k = 0; k < block.count; ++k) numbers[k] = (bytes[k] | (bytes[k + block.count] << 8)) + (k < block.stride ? 0 : numbers[k - block.stride]);
  return numbers;
}

// → the description with every block of bytes replaced by its numbers.
export async function unpacked(description, base64) {
  const buffer = await bytesOf(base64);
  const open = (value) => {
    if (Array.isArray(value)) return value.map(open);
    if (value === null || typeof value !== 'object') return value;
    if (value.kind === 'delta') return undone(value, buffer);
    if (value.kind) return new kinds[value.kind](buffer, value.at, value.count);
    return Object.fromEntries(Object.entries(value).map(([key, inner]) => [key, open(inner)]));
  };
  return open(description);
}

export const absent = 65535;

// Where the particles are in a frame [m], three numbers each; those that are not there are not-a-number.
export function positionsAt(scene, frame, into) {
  const { count, lower, upper, position } = scene.particles;
  for (let k = 0, at = 3 * count * frame; k < 3 * count; ++k, ++at) {
    const axis = k % 3;
    into[k] = position[at] === absent ? NaN : lower[axis] + (position[at] / (absent - 1)) * (upper[axis] - lower[axis]);
  }
  return into;
}

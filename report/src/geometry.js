// Small geometry that the stage needs: turns, poses, edges.

// A unit quaternion (w, x, y, z) written in bytes → the columns of its rotation, as vtk.js takes them.
export function rotationOf(list, at) {
  let [w, x, y, z] = [list[at], list[at + 1], list[at + 2], list[at + 3]];
  const size = Math.hypot(w, x, y, z) || 1;
  w /= size, x /= size, y /= size, z /= size;
  return [
    1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y),
  ];
}

// A quaternion and a translation → a matrix, column by column.
export function matrixOf(poses, at) {
  const r = rotationOf(poses, at);
  return [r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0, poses[at + 4], poses[at + 5], poses[at + 6], 1];
}

// For each point the first that stands where it does.
function welded(points) {
  const first = new Map();
  return Array.from({ length: points.length / 3 }, (_, k) => {
    const place = [0, 1, 2].map((c) => points[3 * k + c].toPrecision(6)).join();
    if (!first.has(place)) first.set(place, k);
    return first.get(place);
  });
}

// Pairs of points: where a surface ends or bends by more than 30°.
export function edgesOf(points, given) {
  const same = welded(points), triangles = Array.from(given, (corner) => same[corner]);
  const found = new Map(), sharp = Math.cos(Math.PI / 6);
  const normalOf = (a, b, c) => {
    const [u, v] = [b, c].map((p) => [0, 1, 2].map((k) => points[3 * p + k] - points[3 * a + k]));
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const size = Math.hypot(...n) || 1;
    return n.map((x) => x / size);
  };
  for (let t = 0; t < triangles.length; t += 3) {
    const corner = [triangles[t], triangles[t + 1], triangles[t + 2]];
    if (new Set(corner).size < 3) continue;
    const normal = normalOf(...corner);
    for (let k = 0; k < 3; ++k) {
      const [a, b] = [corner[k], corner[(k + 1) % 3]].sort((p, q) => p - q), key = a * 4294967296 + b;
      const edge = found.get(key);
      if (!edge) found.set(key, { a, b, normal, shown: true });
      else edge.shown = Math.abs(edge.normal[0] * normal[0] + edge.normal[1] * normal[1] + edge.normal[2] * normal[2]) < sharp;
    }
  }
  return [...found.values()].filter((edge) => edge.shown).flatMap(({ a, b }) => [a, b]);
}

// The ends of the bonds that hold in a frame.
export function segments({ pairs, frames }, places, frame) {
  const out = [];
  for (let k = 0; k < pairs.length / 2; ++k) {
    if (frame < frames[2 * k] || frame > frames[2 * k + 1]) continue;
    for (const end of [pairs[2 * k], pairs[2 * k + 1]]) out.push(places[3 * end], places[3 * end + 1], places[3 * end + 2]);
  }
  return Float32Array.from(out);
}

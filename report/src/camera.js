// From where all of a scene is seen.
import { matrixOf } from './geometry.js';

const shots = 12; // of the motion, at which walls are looked at

// Places that the scene reaches: corners of the room that the particles take, and points of the walls. A wall of four points is a plane without
// an end, shown as far as the rest reaches.
export function cornersOf(scene) {
  const { lower, upper } = scene.particles, out = [];
  for (let k = 0; k < 8; ++k) out.push([0, 1, 2].map((c) => (k & (1 << c) ? upper[c] : lower[c])));
  const last = scene.times.length - 1;
  for (const wall of scene.walls) {
    const count = wall.points.length / 3 / wall.shots;
    if (count <= 4) continue;
    const every = Math.max(1, Math.floor(count / 200));
    for (let shot = 0; shot < (wall.poses ? shots : 1); ++shot) {
      const m = wall.poses ? matrixOf(wall.poses, 7 * Math.round((last * shot) / (shots - 1))) : null;
      for (let k = 0; k < count; k += every) {
        const [x, y, z] = wall.points.subarray(3 * k, 3 * k + 3);
        out.push(m ? [0, 1, 2].map((c) => m[c] * x + m[4 + c] * y + m[8 + c] * z + m[12 + c]) : [x, y, z]);
      }
    }
  }
  return out;
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.hypot(...a));

// Where to look at, and from how far, with a view of an angle in degrees and of an aspect (width over height).
export function seenWhole(places, forward, up, angle, aspect) {
  const right = unit(cross(forward, up)), above = cross(right, forward), axes = [right, above, forward];
  const least = [Infinity, Infinity, Infinity], most = least.map((x) => -x);
  for (const place of places) axes.forEach((axis, c) => { least[c] = Math.min(least[c], dot(place, axis)), most[c] = Math.max(most[c], dot(place, axis)); });
  const middle = least.map((x, c) => 0.5 * (x + most[c]));
  const centre = [0, 1, 2].map((k) => axes.reduce((sum, axis, c) => sum + middle[c] * axis[k], 0));
  const reach = Math.tan((angle * Math.PI) / 360);
  let distance = 0;
  for (const place of places) {
    const [x, y, z] = axes.map((axis, c) => dot(place, axis) - middle[c]);
    distance = Math.max(distance, Math.abs(x) / (reach * aspect) - z, Math.abs(y) / reach - z);
  }
  return { centre, distance: 1.06 * distance };
}

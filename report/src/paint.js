// What the particles may be coloured by in a scene, with the words and the scale that go with it.
import { fragmentColour, gradient, kindColour, scaleTable } from './colours.js';
import { spoken } from './numbers.js';

const byScale = (value, into) => into.set(scaleTable.subarray(3 * value, 3 * value + 3));

const bar = (from, to, unit) => `<span>${from}</span><i style="background:${gradient()}"></i><span>${to} ${unit}</span>`;
const swatches = (names, colourOf) => names.map((name, k) => `<span class="swatch"><b style="background:rgb(${colourOf(k)})"></b>${name}</span>`).join('');
const safe = (name) => name.replace(/[&<>]/g, (c) => `&#${c.charCodeAt(0)};`);

// → by name: {fill(frame, colours), key: HTML of the scale}
export function paintsOf({ particles }) {
  const { count, radius, species, names, speed, topSpeed, fragment } = particles;
  const paints = {};
  const each = (colourOf) => (frame, colours) => {
    for (let k = 0; k < count; ++k) colours.set(colourOf(k, frame), 3 * k);
  };
  if (fragment) {
    paints.fragment = { fill: each((k, frame) => fragmentColour(fragment[frame * count + k])), key: swatches(['heaviest', 'second', 'third …'], fragmentColour) + `<span class="swatch"><b style="background:rgb(70,70,76)"></b>no bonds</span>` };
  }
  paints.speed = {
    fill(frame, colours) {
      for (let k = 0; k < count; ++k) byScale(speed[frame * count + k], colours.subarray(3 * k, 3 * k + 3));
    },
    key: bar('0', `${spoken(topSpeed, 3)}`, 'm/s or more'),
  };
  const [least, most] = radius.reduce(([a, b], r) => [Math.min(a, r), Math.max(b, r)], [Infinity, 0]);
  if (most > 1.001 * least) {
    const table = Uint8Array.from(radius, (r) => Math.round((255 * (r - least)) / (most - least)));
    paints.diameter = { fill: each((k) => scaleTable.subarray(3 * table[k], 3 * table[k] + 3)), key: bar(spoken(2000 * least, 3), spoken(2000 * most, 3), 'mm') };
  }
  if (names.length > 1) paints.species = { fill: each((k) => kindColour(species[k])), key: swatches(names.map(safe), kindColour) };
  return paints;
}

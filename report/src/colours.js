// What particles are coloured by: a list of three bytes for a number from 0 to 1, or for a thing of several.
// Viridis (Smith & van der Walt 2015) at nine places; Okabe & Ito 2008 for kinds.
const viridis = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];
const kinds = [[0, 114, 178], [230, 159, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [213, 94, 0], [240, 228, 66]];

export const scaleTable = (() => {
  const table = new Uint8Array(3 * 256);
  for (let k = 0; k < 256; ++k) {
    const at = (k / 255) * (viridis.length - 1), low = Math.min(Math.floor(at), viridis.length - 2);
    for (let c = 0; c < 3; ++c) table[3 * k + c] = Math.round(viridis[low][c] + (at - low) * (viridis[low + 1][c] - viridis[low][c]));
  }
  return table;
})();

export const kindColour = (k) => kinds[k % kinds.length];

// By mass: the ten heaviest fragments apart, the others paler, single grains grey, what never had a bond dark.
export function fragmentColour(rank) {
  if (rank < 0) return [70, 70, 76];
  const [r, g, b] = kinds[rank % kinds.length], pale = rank < 10 ? 0 : 0.5;
  return [r, g, b].map((c) => Math.round(c + pale * (235 - c)));
}

export const gradient = () => `linear-gradient(90deg,${viridis.map((c) => `rgb(${c})`).join(',')})`;

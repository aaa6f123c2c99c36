// Curves with places of their own on x, brought onto common ones: what uPlot takes.
const usable = (value, log) => Number.isFinite(value) && (!log || value > 0);

// → {data: [x, then y, lower, upper of each curve], own: per curve the places in x where it has points}
export function aligned(panel) {
  // A curve may have several points at one x: that x stands there as often.
  const most = new Map();
  for (const curve of panel.curves) {
    const times = new Map();
    for (const x of curve.x) if (usable(x, panel.logX)) times.set(x, (times.get(x) ?? 0) + 1);
    for (const [x, count] of times) most.set(x, Math.max(count, most.get(x) ?? 0));
  }
  const x = [...most.keys()].sort((a, b) => a - b).flatMap((value) => Array(most.get(value)).fill(value));
  const first = new Map();
  x.forEach((value, k) => first.has(value) || first.set(value, k));
  const data = [x], own = [];
  for (const curve of panel.curves) {
    const y = Array(x.length).fill(null), lower = Array(x.length).fill(null), upper = Array(x.length).fill(null), at = [], next = new Map(first);
    for (let k = 0; k < curve.x.length; ++k) {
      if (!usable(curve.x[k], panel.logX) || !usable(curve.y[k], panel.logY)) continue;
      const place = next.get(curve.x[k]);
      next.set(curve.x[k], place + 1);
      y[place] = curve.y[k];
      at.push(place);
      if (!curve.lower || curve.lower[k] == null || curve.upper[k] == null) continue;
      // An interval that reaches down to nothing has no end on a log axis.
      lower[place] = panel.logY ? Math.max(curve.lower[k], 0.1 * curve.y[k]) : curve.lower[k];
      upper[place] = curve.upper[k];
    }
    data.push(y, lower, upper);
    own.push(at.sort((a, b) => a - b));
  }
  return { data, own };
}

// The entry of an ascending list that is nearest to a place, by a measure of distance.
export function nearest(list, place, distance) {
  let low = 0, high = list.length - 1;
  if (high < 0) return null;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle] <= place) low = middle;
    else high = middle;
  }
  return distance(list[low]) <= distance(list[high]) ? list[low] : list[high];
}

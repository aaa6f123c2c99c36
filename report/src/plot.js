// One panel of a chart: drawn by uPlot; drag to zoom, double click for all of it, the numbers under the pointer stand below it.
import uPlot from 'uplot';
import { aligned, nearest } from './aligned.js';
import { decade, spoken } from './numbers.js';

const ink = '#222226', faint = '#e6e6e8', shade = '#e69f0026';
const pale = (colour, part) => colour + Math.round(255 * part).toString(16).padStart(2, '0');

// Of the ticks of a log axis, the powers of ten.
const decades = (u, ticks) => ticks.map((tick) => (decade(tick) ? tick : null));

function axis(label, log, size) {
  return {
    label, size, labelSize: 22, labelGap: 0, gap: 4, stroke: ink, font: '12px system-ui, sans-serif', labelFont: '12px system-ui, sans-serif',
    grid: { stroke: faint, width: 1, ...(log ? { filter: decades } : {}) }, ticks: { stroke: faint, width: 1, size: 5, ...(log ? { filter: decades } : {}) },
    values: (u, ticks) => ticks.map((tick) => (tick == null ? '' : log ? decade(tick) : spoken(tick, 6))),
    ...(log ? { filter: (u, ticks) => ticks } : {}),
  };
}

function scale(log, padded) {
  if (log) return { time: false, distr: 3, range: (u, from, to) => (from == null ? [1, 10] : uPlot.rangeLog(from, to, 10, false)) };
  return padded ? { time: false } : { time: false, range: (u, from, to) => (from == null ? [0, 1] : from < to ? [from, to] : [from - 0.5, to + 0.5]) };
}

// Bars of the curves that have marks, and the stretch of x that is pointed out.
function extras(panel) {
  const clipped = (u, draw) => {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    draw(ctx, bbox);
    ctx.restore();
  };
  return {
    drawClear: (u) => panel.marked && clipped(u, (ctx, bbox) => {
      const [from, to] = panel.marked.map((x) => u.valToPos(x, 'x', true));
      ctx.fillStyle = shade;
      ctx.fillRect(from, bbox.top, Math.max(2, to - from), bbox.height);
    }),
    draw: (u) => clipped(u, (ctx) => {
      panel.curves.forEach((curve, c) => {
        if (!curve.marks || !u.series[1 + 3 * c].show) return;
        const [x, lower, upper] = [u.data[0], u.data[2 + 3 * c], u.data[3 + 3 * c]];
        ctx.strokeStyle = curve.colour;
        ctx.lineWidth = devicePixelRatio;
        ctx.beginPath();
        for (let k = 0; k < x.length; ++k) {
          if (lower[k] == null) continue;
          const at = u.valToPos(x[k], 'x', true);
          ctx.moveTo(at, u.valToPos(lower[k], 'y', true));
          ctx.lineTo(at, u.valToPos(upper[k], 'y', true));
        }
        ctx.stroke();
      });
    }),
  };
}

// Names of the curves, and beside them their numbers under the pointer.
function legend(panel, own) {
  const box = document.createElement('div');
  box.className = 'legend';
  const x = box.appendChild(document.createElement('span'));
  x.className = 'x';
  const entries = panel.curves.map((curve) => {
    const entry = box.appendChild(document.createElement('button'));
    entry.type = 'button';
    entry.innerHTML = '<i></i><span></span> <b></b>';
    entry.firstChild.style.background = curve.colour;
    entry.children[1].textContent = curve.name;
    entry.hidden = !curve.name;
    return entry;
  });
  if (panel.marked) {
    const shaded = box.appendChild(document.createElement('span'));
    shaded.innerHTML = '<i></i>where they differ';
    shaded.firstChild.style.background = shade;
  }
  const unit = (label) => label.match(/\[([^\]]+)\]$/)?.[1] ?? '';
  const [xName, xUnit, yUnit] = [panel.x.replace(/ *\[[^\]]*\]$/, ''), unit(panel.x), unit(panel.y)];
  const show = (u) => {
    const { idx, left } = u.cursor;
    const over = idx != null && left >= 0;
    const at = over ? u.posToVal(left, 'x') : null;
    x.textContent = over ? `${xName} ${spoken(at)} ${xUnit}` : panel.hint;
    entries.forEach((entry, c) => {
      const far = (place) => Math.abs(u.valToPos(u.data[0][place], 'x') - left);
      const place = over ? nearest(own[c], idx, far) : null;
      const known = place != null && far(place) < 40;
      let text = '';
      if (known) {
        const [y, lower, upper] = [1, 2, 3].map((k) => u.data[k + 3 * c][place]);
        text = `${spoken(y)}${lower == null ? '' : ` (${spoken(lower, 3)} … ${spoken(upper, 3)})`} ${yUnit}`;
      }
      entry.lastChild.textContent = text;
    });
  };
  return { box, entries, show };
}

// A finger that moves across, for uPlot, which knows mice alone; up and down still moves the page.
function feelFingers(over) {
  over.style.touchAction = 'pan-y';
  const as = { pointerdown: 'mousedown', pointermove: 'mousemove', pointerup: 'mouseup' };
  for (const [kind, mouse] of Object.entries(as)) {
    over.addEventListener(kind, (event) => {
      if (event.pointerType !== 'touch') return;
      const { clientX, clientY } = event;
      const send = (type, on) => on.dispatchEvent(new MouseEvent(type, { bubbles: true, clientX, clientY, button: 0 }));
      if (kind === 'pointerdown') send('mouseenter', over), send('mousemove', over);
      send(mouse, mouse === 'mouseup' ? document : over);
    });
  }
}

// → the uPlot. `linked`: a key that panels of one chart share, whose pointers and zooms go together.
export function plot(into, panel, { height, linked, xLabel }) {
  const { data, own } = aligned(panel);
  const names = legend(panel, own);
  const whole = document.createElement('button');
  whole.type = 'button', whole.className = 'whole', whole.textContent = 'show all', whole.hidden = true;
  const series = [{}], bands = [];
  for (const curve of panel.curves) {
    const joined = !curve.marks || curve.joined;
    series.push({
      label: curve.name, stroke: curve.colour, width: curve.marks ? 0.7 : 1.5, spanGaps: true, ...(joined ? {} : { paths: () => null }),
      points: { show: curve.marks, size: curve.small ? 3 : 6, fill: curve.colour, width: 0 },
    });
    for (let k = 0; k < 2; ++k) series.push({ stroke: 'transparent', width: 0, spanGaps: true, points: { show: false }, ...(curve.marks ? { paths: () => null } : {}) });
    if (curve.lower && !curve.marks) bands.push({ series: [series.length - 1, series.length - 2], fill: pale(curve.colour, 0.2) });
  }
  const { drawClear, draw } = extras(panel);
  let full = null;
  const options = {
    width: into.clientWidth, height, series, bands, legend: { show: false }, padding: [12, 14, 0, 0],
    scales: { x: scale(panel.logX, false), y: scale(panel.logY, true) },
    axes: [axis(xLabel ? panel.x : '', panel.logX, xLabel ? 28 : 24), axis(panel.y, panel.logY, 58)],
    cursor: { drag: { x: true, y: true, uni: 24 }, points: { show: false }, ...(linked ? { sync: { key: linked, scales: ['x', null] } } : {}) },
    hooks: {
      drawClear: [drawClear], draw: [draw], setCursor: [names.show],
      setScale: [(u) => {
        const now = ['x', 'y'].map((key) => `${u.scales[key].min} ${u.scales[key].max}`).join();
        if (full) whole.hidden = now === full;
      }],
      ready: [(u) => {
        full = ['x', 'y'].map((key) => `${u.scales[key].min} ${u.scales[key].max}`).join();
        names.show(u);
      }],
    },
  };
  if (!xLabel) delete options.axes[0].label;
  const drawn = new uPlot(options, data, into);
  names.entries.forEach((entry, c) => entry.addEventListener('click', () => {
    const show = !drawn.series[1 + 3 * c].show;
    entry.classList.toggle('off', !show);
    for (let k = 1; k < 4; ++k) drawn.setSeries(k + 3 * c, { show });
  }));
  whole.addEventListener('click', () => drawn.setData(drawn.data, true));
  into.append(whole, names.box);
  feelFingers(drawn.over);
  return drawn;
}

// Every chart of the page becomes one that zooms, and every table sorts where it may. What stands there without a script stays for print.
import css from 'uplot/dist/uPlot.min.css';
import { plot } from './plot.js';
import { sortable } from './sortable.js';

document.head.appendChild(document.createElement('style')).textContent = css;

// A phone has fingers; both can be told of.
const hint = matchMedia('(pointer: coarse)').matches ? 'slide across to zoom, tap for numbers' : 'drag to zoom, point for numbers';

function draw(figure, number) {
  const chart = JSON.parse(figure.querySelector('script.chart').textContent);
  const live = document.createElement('div');
  live.className = 'live';
  figure.classList.add('drawn');
  figure.append(live);
  const oneLabel = chart.panels.every((panel) => panel.x === chart.panels[0].x);
  const plots = chart.panels.map((panel, k) => {
    const home = live.appendChild(document.createElement('div'));
    const last = k + 1 === chart.panels.length;
    panel.hint = last || !oneLabel ? hint : '';
    return plot(home, panel, { height: k === 0 ? 290 : 210, linked: oneLabel && chart.panels.length > 1 ? `chart ${number}` : null, xLabel: last || !oneLabel });
  });
  new ResizeObserver(() => plots.forEach((one) => {
    const width = one.root.parentNode.clientWidth;
    if (width > 0 && width !== one.width) one.setSize({ width, height: one.height });
  })).observe(live);
  figure.plots = plots;
}

// Only what is near the screen: a sweep may have a hundred.
const coming = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    if (!entry.isIntersecting) continue;
    coming.unobserve(entry.target);
    draw(entry.target, entry.target.dataset.number);
  }
}, { rootMargin: '600px' });
document.querySelectorAll('figure.chart').forEach((figure, number) => {
  figure.dataset.number = number;
  coming.observe(figure);
});
document.querySelectorAll('table.sorts').forEach(sortable);

// The charge in 3-D, where the page carries one: turns under the pointer, plays, says the time.
import { positionsAt, unpacked } from './frames.js';
import { makeStage } from './stage.js';
import { paintsOf } from './paint.js';
import { spoken } from './numbers.js';

const framesPerSecond = 25;

function controls(scene, paints) {
  const box = document.createElement('div');
  box.className = 'controls';
  const option = (value, text) => `<option value="${value}">${text}</option>`;
  const last = scene.times.length - 1;
  box.innerHTML = `<div class="row"><button type="button" class="play" aria-label="play or pause">▶</button>
    <input type="range" min="0" max="${last}" value="0" step="1" aria-label="frame"><output></output></div>
    <div class="row"><label>colour <select class="by">${Object.keys(paints).map((name) => option(name, name)).join('')}</select></label><span class="key"></span></div>
    <div class="row"><label>pace <select class="pace">${[0.25, 0.5, 1, 2, 4].map((x) => option(x, `× ${x}`)).join('')}</select></label>
    <label><input type="checkbox" class="walls" checked> walls</label>${scene.bonds ? '<label><input type="checkbox" class="bonds" checked> bonds</label>' : ''}
    <button type="button" class="reset">reset view</button><span class="note real"></span></div>`;
  box.querySelector('.pace').value = '1';
  return box;
}

async function open(figure) {
  const scene = await unpacked(JSON.parse(figure.querySelector('script.scene').textContent), figure.querySelector('script.bytes').textContent);
  const home = figure.insertBefore(document.createElement('div'), figure.firstChild);
  home.className = 'stage';
  figure.classList.add('drawn');
  const stage = makeStage(home, scene);
  const paints = paintsOf(scene), box = controls(scene, paints);
  home.after(box);
  const find = (name) => box.querySelector(name);
  const [play, slider, time, by, key, pace] = ['.play', 'input[type=range]', 'output', '.by', '.key', '.pace'].map(find);
  const places = new Float32Array(3 * scene.particles.count), colours = new Uint8Array(3 * scene.particles.count);
  const last = scene.times.length - 1;

  const show = (frame) => {
    paints[by.value].fill(frame, colours);
    stage.show(frame, positionsAt(scene, frame, places), colours);
    slider.value = frame;
    time.textContent = `t = ${scene.times[frame].toFixed(scene.decimals)} s`;
    stage.draw();
  };
  const describe = () => {
    key.innerHTML = paints[by.value].key;
    const step = last > 0 ? (scene.times[last] - scene.times[0]) / last : 0;
    const rate = step * framesPerSecond * Number(pace.value);
    find('.real').textContent = last > 0 ? `${rate > 1 ? `${spoken(rate, 2)} times as fast as it is` : `${spoken(1 / rate, 2)} times slower than it is`}` : '';
  };

  let since = null, from = 0;
  const tick = (now) => {
    if (since === null) return;
    // A browser's frame may have begun before the click that starts it.
    const frame = from + Math.floor((Math.max(0, now - since) / 1000) * framesPerSecond * Number(pace.value));
    if (frame > last) since = now, from = 0, show(0);
    else if (frame !== Number(slider.value)) show(frame);
    requestAnimationFrame(tick);
  };
  const setPlaying = (on) => {
    play.textContent = on ? '❚❚' : '▶';
    from = Number(slider.value) >= last ? 0 : Number(slider.value);
    since = on ? performance.now() : null;
    if (on) requestAnimationFrame(tick);
  };
  play.addEventListener('click', () => setPlaying(since === null));
  slider.addEventListener('input', () => { setPlaying(false); show(Number(slider.value)); });
  by.addEventListener('change', () => { describe(); show(Number(slider.value)); });
  pace.addEventListener('change', () => { if (since !== null) setPlaying(true); describe(); });
  find('.walls').addEventListener('change', (event) => { stage.setWalls(event.target.checked); stage.draw(); });
  find('.bonds')?.addEventListener('change', (event) => { stage.setBonds(event.target.checked); stage.draw(); });
  find('.reset').addEventListener('click', () => { stage.reset(); stage.draw(); });
  new ResizeObserver(() => { if (home.clientWidth > 0) stage.resize(), stage.draw(); }).observe(home);
  if (last === 0) find('.row').hidden = true;

  describe();
  stage.resize();
  show(last);
  stage.reset();
  stage.draw();
  figure.dataset.drawnAfter = performance.now().toFixed(0);
}

const figure = document.querySelector('figure.charge3d');
if (figure) {
  open(figure).catch((error) => {
    figure.classList.remove('drawn');
    figure.querySelector('.stage')?.remove();
    figure.append(Object.assign(document.createElement('p'), { className: 'note', textContent: `This browser cannot show the charge in 3-D (${error.message}).` }));
  });
}

// Opens pages of quern in headless Chromium and does what a person would: node browser.js PACKAGES CHROMIUM RUN.html [SWEEP.html [DIAGNOSIS.html …]]
// PACKAGES: the folder with node_modules.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [packages, chromiumPath, runPage, sweepPage, ...diagnoses] = process.argv.slice(2);
const { chromium } = createRequire(join(resolve(packages), 'package.json'))('playwright-core');
const patience = 120000; // [ms], of machines that do much beside
const address = (file) => pathToFileURL(resolve(file)).href;

// The pixels of the 3-D canvas after a call that draws, in the same breath: how many colours, and a sum that tells pictures apart.
const look = (page, frame) => page.evaluate((to) => {
  const slider = document.querySelector('.charge3d input[type=range]'), canvas = document.querySelector('.stage canvas');
  if (to !== null) slider.value = to;
  slider.dispatchEvent(new Event('input'));
  const copy = Object.assign(document.createElement('canvas'), { width: canvas.width, height: canvas.height }), context = copy.getContext('2d');
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, copy.width, copy.height), colours = new Set();
  let sum = 0;
  for (let k = 0; k < data.length; k += 4) {
    colours.add((data[k] << 16) | (data[k + 1] << 8) | data[k + 2]);
    sum = (sum * 31 + data[k] + 7 * data[k + 1] + 13 * data[k + 2]) % 4294967291;
  }
  return { colours: colours.size, sum };
}, frame);

const range = (page, of) => page.evaluate((n) => {
  const { min, max } = document.querySelectorAll('figure.chart')[n].plots[0].scales.x;
  return [min, max];
}, of);

async function opened(context, file, threeD, complaints) {
  const page = await context.newPage();
  page.setDefaultTimeout(patience);
  page.on('console', (message) => { if (message.type() === 'error' || message.type() === 'warning') complaints.push(message.text()); });
  page.on('pageerror', (error) => complaints.push(String(error)));
  page.on('request', (request) => { if (!/^(file|data|blob):/.test(request.url())) complaints.push(`asks the network for ${request.url()}`); });
  const begun = Date.now();
  await page.goto(address(file));
  if (threeD) await page.waitForSelector('figure.charge3d[data-drawn-after]', { timeout: patience, state: 'attached' });
  else await page.waitForSelector('figure.chart.drawn', { timeout: patience, state: 'attached' });
  console.log(`${file}: ${(readFileSync(file).length / 1e6).toFixed(2)} MB, drawn after ${Date.now() - begun} ms`);
  return page;
}

async function checkPlot(page) {
  const figure = page.locator('figure.chart').first();
  await figure.scrollIntoViewIfNeeded();
  const area = figure.locator('.u-over').first();
  await area.waitFor();
  const box = await area.boundingBox();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
  await page.waitForFunction(() => /\d/.test(document.querySelector('figure.chart .legend .x').textContent + document.querySelector('figure.chart .legend button b').textContent));
  const told = await figure.locator('.legend').first().textContent();
  assert.match(told, /\d/, 'the pointer over a plot gives its numbers');
  const before = await range(page, 0);
  await page.mouse.move(box.x + 0.3 * box.width, box.y + 0.4 * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.6 * box.width, box.y + 0.42 * box.height, { steps: 4 });
  await page.mouse.up();
  await page.waitForFunction(([from, to]) => { const { min, max } = document.querySelector('figure.chart').plots[0].scales.x; return min > from && max < to; }, before);
  await figure.locator('.whole').first().click();
  await page.waitForFunction(([from, to]) => { const { min, max } = document.querySelector('figure.chart').plots[0].scales.x; return min === from && max === to; }, before);
}

async function checkRun(context, complaints) {
  const page = await opened(context, runPage, true, complaints);
  const last = Number(await page.locator('.charge3d input[type=range]').getAttribute('max'));
  const [first, end] = [await look(page, 0), await look(page, last)];
  assert.ok(first.colours > 200, `the charge is drawn (${first.colours} colours)`);
  assert.notEqual(first.sum, end.sum, 'frames differ');
  await page.locator('.play').click();
  const frame = () => page.locator('.charge3d input[type=range]').inputValue();
  const [was, time] = [await frame(), await page.locator('.charge3d output').textContent()];
  await page.waitForFunction((old) => document.querySelector('.charge3d input[type=range]').value !== old, was);
  assert.notEqual(await page.locator('.charge3d output').textContent(), time, 'playing, the time goes on');
  await page.locator('.play').click();
  const steady = await look(page, 0);
  const canvas = await page.locator('.stage canvas').boundingBox();
  await page.mouse.move(canvas.x + 200, canvas.y + 200);
  await page.mouse.down();
  await page.mouse.move(canvas.x + 320, canvas.y + 240, { steps: 6 });
  await page.mouse.up();
  assert.notEqual((await look(page, 0)).sum, steady.sum, 'dragged, it turns');
  await page.locator('.reset').click();
  assert.equal((await look(page, 0)).sum, steady.sum, 'the view is reset');
  await page.locator('.walls').uncheck();
  assert.notEqual((await look(page, 0)).sum, steady.sum, 'walls go');
  await checkPlot(page);

  // In print pictures stand where things moved.
  await page.emulateMedia({ media: 'print' });
  assert.equal(await page.locator('.stage').isVisible(), false, 'no 3-D in print');
  assert.ok(await page.locator('.charge3d .still img').isVisible(), 'a picture of the charge in print');
  assert.ok(await page.locator('figure.chart .still svg').first().isVisible(), 'plots in print');
  const pdf = (await page.pdf({ format: 'A4' })).toString('latin1');
  const pages = pdf.match(/\/Type\s*\/Page\b/g)?.length ?? 0;
  assert.ok(pages >= 2 && pages < 40, `${pages} pages in print`);
  await page.close();
}

async function checkPhone(browser, file, threeD, complaints) {
  const context = await browser.newContext({ viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true, offline: true });
  const page = await opened(context, file, threeD, complaints);
  const width = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 390, `nothing is wider than a phone (${width} px)`);
  const figure = page.locator('figure.chart').first();
  await figure.scrollIntoViewIfNeeded();
  await figure.locator('.u-over').first().tap();
  await page.waitForFunction(() => /\d/.test(document.querySelector('figure.chart .legend .x').textContent));
  await context.close();
}

async function checkSweep(context, complaints) {
  const page = await opened(context, sweepPage, false, complaints);
  await checkPlot(page);
  const column = () => page.locator('table.sorts tbody tr td:first-child').allTextContents();
  const before = await column();
  const head = page.locator('table.sorts th button').first();
  await head.click();
  await head.click();
  assert.deepEqual(await column(), before.reverse(), 'the table sorts');
  await page.close();
}

async function checkDiagnosis(context, file, complaints) {
  const page = await opened(context, file, false, complaints);
  await checkPlot(page);
  // Every recorded point is in the plot, those at one x too.
  const kept = await page.evaluate(() => [...document.querySelectorAll('figure.chart.drawn')].every((figure) => {
    const { panels } = JSON.parse(figure.querySelector('script.chart').textContent);
    return panels.every(({ curves }, p) => curves.every(({ y }, c) => figure.plots[p].data[1 + 3 * c].filter((value) => value != null).length === y.filter((value) => value != null).length));
  }));
  assert.ok(kept, 'no point is lost');
  await page.emulateMedia({ media: 'print' });
  assert.ok(await page.locator('figure.chart .still svg').first().isVisible(), 'plots in print');
  assert.equal(await page.locator('.live').first().isVisible(), false, 'none that zooms in print');
  await page.close();
}

const browser = await chromium.launch({ executablePath: chromiumPath, args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });
try {
  const complaints = [];
  const context = await browser.newContext({ viewport: { width: 1200, height: 900 }, offline: true });
  await checkRun(context, complaints);
  await checkPhone(browser, runPage, true, complaints);
  if (sweepPage) await checkSweep(context, complaints), await checkPhone(browser, sweepPage, false, complaints);
  for (const file of diagnoses) await checkDiagnosis(context, file, complaints), await checkPhone(browser, file, false, complaints);
  for (const notice of ['Kitware', 'uplot', 'Leon Sorokin']) assert.ok(readFileSync(runPage, 'utf8').includes(notice), `the notice of ${notice}`);
  assert.deepEqual(complaints, [], 'no error, no warning, no request to the network');
  console.log('The report opens, draws, plays, zooms, prints and fits a phone.');
} finally {
  await browser.close();
}

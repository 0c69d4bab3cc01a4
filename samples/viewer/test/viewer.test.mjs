// The page in a real headless Chromium: node test/viewer.test.mjs HEAD.glb [EXPRESSIONS.glb] [--pictures FOLDER] [--json]
// HEAD.glb is a head asset, EXPRESSIONS.glb what `phiz retarget` or `phiz export --rig` made of the same subject.
import { execFileSync } from 'node:child_process';
import { mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const words = process.argv.slice(2), files = [];
let pictures = null, isJson = false;
while (words.length > 0) {
  const word = words.shift();
  if (word === '--pictures') pictures = words.shift();
  else if (word === '--json') isJson = true;
  else files.push(word);
}
const [headFile, expressionsFile] = files;
const results = [];
const check = (what, holds, detail = '') => {
  results.push({ what, ok: Boolean(holds), detail });
  if (!isJson) console.log(`${holds ? 'ok  ' : 'FAIL'} ${what}${detail ? `: ${detail}` : ''}`);
};

const folder = await mkdtemp(join(tmpdir(), 'phiz-viewer-'));
const page = join(folder, 'viewer.html');
execFileSync(process.execPath, [join(dirname(fileURLToPath(import.meta.url)), '..', 'build.mjs'), '-o', page, headFile, ...(expressionsFile ? [expressionsFile] : [])]);
const browser = await chromium.launch({
  executablePath: process.env.PHIZ_CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--hide-scrollbars'],
});
const figures = {};
try {
  const view = await browser.newPage({ viewport: { width: 1000, height: 700 } });
  const complaints = [];
  view.on('console', (message) => ['error', 'warning'].includes(message.type()) && !/GPU stall|GL Driver/.test(message.text()) && complaints.push(message.text()));
  view.on('pageerror', (error) => complaints.push(String(error)));
  await view.goto(pathToFileURL(page).href);
  await view.waitForFunction(() => window.phizViewer?.asset && window.phizViewer.asset.levels.length === window.phizViewer.asset.levelCount, null, { timeout: 60000 });
  const count = await view.evaluate(() => window.phizViewer.asset.levelCount);
  check('loads offline from one file', count > 0, `${count} levels`);
  const settle = () => view.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  // What is drawn, as grey bytes, without the panel and the words.
  const grab = async (name) => {
    await settle();
    if (pictures) await view.screenshot({ path: join(pictures, `${name}.png`) });
    return view.evaluate(() => {
      const source = document.querySelector('#stage canvas'), copy = document.createElement('canvas');
      copy.width = source.width, copy.height = source.height;
      const pen = copy.getContext('2d');
      pen.drawImage(source, 0, 0);
      const { data } = pen.getImageData(0, 0, copy.width, copy.height), grey = [];
      for (let i = 0; i < data.length; i += 4) grey.push((data[i] + data[i + 1] + data[i + 2]) / 3);
      return { width: copy.width, height: copy.height, grey };
    });
  };
  const difference = (a, b) => {
    let differing = 0, top = a.height, bottom = -1;
    for (let i = 0; i < a.grey.length; ++i) {
      if (Math.abs(a.grey[i] - b.grey[i]) < 6) continue;
      ++differing;
      top = Math.min(top, (i / a.width) | 0);
      bottom = Math.max(bottom, (i / a.width) | 0);
    }
    return { share: differing / a.grey.length, top, bottom };
  };
  const neutral = await grab('neutral');
  const background = neutral.grey[0];
  const covered = neutral.grey.filter((x) => Math.abs(x - background) > 8).length / neutral.grey.length;
  check('shows a head', covered > 0.1 && covered < 0.8, `${(100 * covered).toFixed(0)} % of the picture`);
  const stillThere = difference(neutral, await grab('again'));
  check('the same picture twice', stillThere.share === 0);

  await view.check('#wire');
  check('wireframe changes the picture', difference(neutral, await grab('wireframe')).share > 0.005);
  await view.uncheck('#wire');
  await view.selectOption('#paint', 'adaptive');
  check('adaptive mesh has fewer triangles', await view.evaluate(() => {
    const shown = Number(document.getElementById('state').textContent.match(/([\d,]+) triangles/)[1].replaceAll(',', ''));
    const { asset, level } = window.phizViewer;
    return shown > 0 && shown < asset.levels[level].corners.length / 3;
  }));
  await grab('adaptive');
  await view.selectOption('#paint', 'displacement');
  check('heat map changes the picture', difference(neutral, await grab('heat')).share > 0.05);
  await view.selectOption('#paint', 'clay');
  check('back to the first picture', difference(neutral, await grab('clay')).share === 0);
  await view.locator('#level').fill('1');
  check('coarser level on demand', (await view.evaluate(() => window.phizViewer.level)) === 1);
  await grab('level1');
  await view.locator('#level').fill(String(count - 1));

  if (expressionsFile) {
    const names = await view.evaluate(() => window.phizViewer.face.targets.map((t) => t.name));
    check('has expressions by name', names.includes('jawOpen') || names.includes('jaw_open'), names.slice(0, 4).join(' '));
    const name = names.includes('jawOpen') ? 'jawOpen' : 'jaw_open';
    const slide = async (value) => view.locator(`#sliders input[data-name="${name}"]`).fill(String(value));
    await slide(1);
    const open = await grab('jaw');
    const changed = difference(neutral, open);
    check('a slider moves the picture', changed.share > 0.005, `${(100 * changed.share).toFixed(1)} % of it`);
    // Where the target moves nothing, nothing may change: everything above its highest moved vertex.
    const highest = await view.evaluate((wanted) => {
      const { face, asset, level } = window.phizViewer, target = face.targets.find((t) => t.name === wanted);
      const rest = asset.positions[face.targetLevel], moved = window.phizViewer.face.positions(level), still = asset.positions[level];
      let top = -Infinity, largest = 0;
      for (let v = 0; v < still.length; v += 3) {
        const way = Math.hypot(moved[v] - still[v], moved[v + 1] - still[v + 1], moved[v + 2] - still[v + 2]);
        largest = Math.max(largest, way);
        if (way > 0.02) top = Math.max(top, still[v + 1]);
      }
      let all = -Infinity;
      for (let v = 1; v < rest.length; v += 3) all = Math.max(all, rest[v]);
      return { top, all, largest, vertices: target.vertices.length };
    }, name);
    check('the slider moves what it should', highest.largest > 5 && highest.top < highest.all - 40, `up to ${highest.largest.toFixed(1)} mm, ${highest.vertices} vertices`);
    const row = await view.evaluate((y) => {
      const { camera } = window.phizViewer, canvas = document.querySelector('#stage canvas');
      return window.phizViewer.rowOf(y, canvas.height);
    }, highest.top);
    check('and nothing above it', changed.top >= row - 0.06 * neutral.height, `first changed row ${changed.top}, moved below row ${row.toFixed(0)}`);
    await view.click('#neutral');
    check('neutral gives the first picture back', difference(neutral, await grab('neutral2')).share === 0);
    const hasMotion = await view.evaluate(() => !document.getElementById('motion').hidden);
    if (hasMotion) {
      await view.evaluate(() => window.phizViewer.seek(0.5));
      const half = await view.evaluate(() => window.phizViewer.face.weights.some((w) => w !== 0));
      check('motion sets the expressions', half);
      await view.click('#neutral');
    }
  }
  await view.setViewportSize({ width: 390, height: 780 });
  const narrow = await view.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth);
  check('fits a phone', narrow);
  if (pictures) await view.screenshot({ path: join(pictures, 'phone.png') });
  await view.locator('#stage canvas').focus();
  await view.keyboard.press('ArrowRight');
  check('keys turn the head', difference(await grab('phone'), neutral).share !== 0);
  await view.setViewportSize({ width: 1000, height: 700 });

  // Times in the browser, best of five, and the first picture from the shortest prefix.
  const bytes = await readFile(headFile);
  Object.assign(figures, await view.evaluate(async (text) => {
    const data = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const times = [];
    for (let k = 0; k < 5; ++k) times.push(window.phizViewer.measure(data));
    let low = 0, high = data.length;
    while (low + 1 < high) {
      const middle = (low + high) >> 1;
      if (window.phizViewer.levelsIn(data.subarray(0, middle)) > 0) high = middle;
      else low = middle;
    }
    return { decode_ms: Math.min(...times), first_bytes: high, bytes: data.length };
  }, bytes.toString('base64')));
  check('no complaint on the console', complaints.length === 0, complaints.join(' | '));
} finally {
  await browser.close();
  await rm(folder, { recursive: true });
}
const failed = results.filter((result) => !result.ok);
if (isJson) console.log(JSON.stringify({ ...figures, checks: results.length, failed: failed.map((f) => f.what) }));
else console.log(`${results.length - failed.length} of ${results.length}; decoded in ${figures.decode_ms?.toFixed(0)} ms, first picture from ${figures.first_bytes} of ${figures.bytes} bytes`);
if (pictures) await writeFile(join(pictures, 'figures.json'), JSON.stringify(figures));
process.exit(failed.length === 0 ? 0 : 1);

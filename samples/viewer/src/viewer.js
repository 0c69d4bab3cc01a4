import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { Face, readTargets, vertexNormals } from './face.js';
import { HeadAsset, isHeadAsset, readDocument } from './head_asset.js';

const find = (id) => document.getElementById(id);
const stage = find('stage'), state = find('state');
const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
stage.append(renderer.domElement);
renderer.domElement.tabIndex = 0;
renderer.domElement.setAttribute('aria-label', 'the head; arrows turn it');
const scene = new THREE.Scene();
scene.background = new THREE.Color(0x20242a);
const camera = new THREE.PerspectiveCamera(28, 1, 10, 5000);
camera.position.set(120, 60, 620);
scene.add(camera, new THREE.HemisphereLight(0xffffff, 0x444850, 1.4));
const key = new THREE.DirectionalLight(0xffffff, 2.2);
key.position.set(-200, 260, 320);
camera.add(key);
const controls = new OrbitControls(camera, renderer.domElement);
controls.enableDamping = false;
controls.keyPanSpeed = 0;
const geometry = new THREE.BufferGeometry();
const material = new THREE.MeshStandardMaterial({ color: 0xd8c3b2, roughness: 0.75, side: THREE.DoubleSide });
const mesh = new THREE.Mesh(geometry, material);
mesh.visible = false;
const wires = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0x203040, transparent: true, opacity: 0.45 }));
wires.visible = false;
scene.add(mesh, wires);

let draco = null, asset = null, face = null, motion = null, confidences = null, bytes = null, pending = null;
let level = 0, wanted = Infinity, playing = false, startedAt = 0, frameWanted = true;
const timings = {};

function ask() {
  frameWanted = true;
}
function resize() {
  const { clientWidth: w, clientHeight: h } = stage;
  renderer.setSize(w, h);
  camera.aspect = w / h;
  camera.updateProjectionMatrix();
  ask();
}

/** Where each corner went when flat places keep the triangles of a coarser level (the adaptive view). */
function adaptiveCorners(fineLevel) {
  const { levels, positions } = asset, kept = [];
  const flat = (t, k) => {
    if (k >= fineLevel) return true;
    const at = levels[k + 1], p = positions[k + 1];
    for (let i = 0; i < 3; ++i) {
      const middle = at.corners[3 * (4 * t + 3) + i], a = at.corners[3 * (4 * t + i)], b = at.corners[3 * (4 * t + ((i + 1) % 3))];
      let off = 0;
      for (let c = 0; c < 3; ++c) off += (p[3 * middle + c] - 0.5 * (p[3 * a + c] + p[3 * b + c])) ** 2;
      if (off > 0.15 ** 2) return false;
    }
    return true;
  };
  const visit = (t, k) => {
    if (flat(t, k)) {
      for (let i = 0; i < 3; ++i) kept.push(levels[k].corners[3 * t + i]);
    } else {
      for (let child = 4 * t; child < 4 * t + 4; ++child) visit(child, k + 1);
    }
  };
  for (let t = 0; t < levels[0].corners.length / 3; ++t) visit(t, 0);
  return Int32Array.from(kept);
}

const ramp = [[59, 76, 192], [221, 221, 221], [180, 4, 38]].map((c) => c.map((x) => (x / 255) ** 2.2));
function rampAt(x, out, at) {
  const s = Math.min(Math.max(x, 0), 1) * 2, k = Math.min(1, Math.floor(s));
  for (let c = 0; c < 3; ++c) out[at + c] = ramp[k][c] + (s - k) * (ramp[k + 1][c] - ramp[k][c]);
}

/** Colours of the level's vertices, or null for clay; sets the legend. */
function paint() {
  const mode = find('paint').value, count = asset.levels[level].vertexCount, legend = find('legend');
  let values = null, low = 0, high = 1, unit = '';
  if (mode === 'confidence' && confidences) {
    values = Float32Array.from({ length: count }, (_, v) => 1 - confidences[v] / 255);
    [low, high] = ['measured', 'invented'];
  } else if (mode === 'displacement') {
    values = new Float32Array(count);
    const smooth = asset.smoothPositions(level), shaped = asset.positions[level];
    for (let v = 0; v < count; ++v)
      values[v] = Math.hypot(...[0, 1, 2].map((c) => shaped[3 * v + c] - smooth[3 * v + c])) / 1.5;
    [low, high, unit] = [0, 1.5, ' mm'];
  }
  legend.style.display = values ? 'block' : 'none';
  if (!values) return null;
  const spans = legend.querySelectorAll('span');
  spans[0].textContent = `${low}${unit}`;
  spans[1].textContent = `${high}${unit}`;
  const colours = new Float32Array(3 * count);
  for (let v = 0; v < count; ++v) rampAt(values[v], colours, 3 * v);
  return colours;
}

/** Puts the wanted level with its colours and expression on the screen. */
function show() {
  if (!asset || asset.levels.length === 0) return;
  level = Math.min(asset.levels.length - 1, wanted);
  const positions = face.positions(level);
  const isAdaptive = find('paint').value === 'adaptive';
  const corners = isAdaptive ? adaptiveCorners(level) : asset.levels[level].corners;
  geometry.setAttribute('position', new THREE.BufferAttribute(Float32Array.from(positions), 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(vertexNormals(positions, asset.levels[level].corners), 3));
  geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from(corners), 1));
  const colours = paint();
  if (colours) geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
  else geometry.deleteAttribute('color');
  material.vertexColors = colours !== null;
  material.color.set(colours ? 0xffffff : 0xd8c3b2);
  material.needsUpdate = true;
  wires.visible = find('wire').checked || isAdaptive;
  if (wires.visible) {
    const lines = new Uint32Array(2 * corners.length);
    for (let h = 0; h < corners.length; ++h) {
      lines[2 * h] = corners[h];
      lines[2 * h + 1] = corners[h % 3 === 2 ? h - 2 : h + 1];
    }
    wires.geometry.setAttribute('position', geometry.getAttribute('position'));
    wires.geometry.setIndex(new THREE.BufferAttribute(lines, 1));
  }
  if (!mesh.visible) frame(positions);
  mesh.visible = true;
  find('level').max = asset.levelCount - 1;
  find('level').value = level;
  const count = asset.levels[level].vertexCount.toLocaleString('en');
  state.textContent = `level ${level} of ${asset.levelCount - 1}: ${count} vertices` +
    (isAdaptive ? `, ${(corners.length / 3).toLocaleString('en')} triangles` : '');
  ask();
}

function frame(positions) {
  const box = new THREE.Box3().setFromArray(positions);
  const centre = box.getCenter(new THREE.Vector3()), size = box.getSize(new THREE.Vector3()).length();
  controls.target.copy(centre);
  camera.position.copy(centre).add(new THREE.Vector3(0.35, 0.12, 1).setLength(1.9 * size));
  controls.update();
}

HeadAsset.prototype.smoothPositions = function smoothPositions(to) {
  let positions = this.controlPositions;
  for (let k = 1; k <= to; ++k) positions = this.refineOnly(k, positions);
  return positions;
};

const nextFrame = () => new Promise((done) => requestAnimationFrame(done));

/** Takes what has come of a file; shows each level as soon as it is decoded. */
async function refineAll(isWhole) {
  while (asset.levels.length < asset.levelCount) {
    const begin = performance.now();
    if (asset.advance(bytes, 1) === 0) break;
    timings[`level ${asset.levels.length - 1}`] = performance.now() - begin;
    timings['first picture bytes'] ??= bytes.length;
    show();
    if (isWhole && asset.levels.length < asset.levelCount) await nextFrame();
  }
  if (isWhole) {
    confidences = asset.readConfidences(bytes);
    find('paint').querySelector('[value=confidence]').disabled = confidences === null;
    show();
  }
}

function openTargets(json, begin, data) {
  const found = readTargets(json, data.subarray(begin));
  if (!found) throw new Error('holds neither a head asset nor morph targets');
  if (!face) {
    pending = [json, begin, data];
    state.textContent = 'These are expressions: now choose the head asset they belong to.';
    return;
  }
  if (!face.setTargets(found.targets, found.vertexCount)) throw new Error('these expressions are of another head');
  motion = found.motion;
  find('shapes').hidden = false;
  find('motion').hidden = motion === null;
  const sliders = find('sliders');
  sliders.replaceChildren(...found.targets.map(({ name }, k) => {
    const label = document.createElement('label'), text = document.createElement('span'), slider = document.createElement('input');
    text.textContent = text.title = name;
    Object.assign(slider, { type: 'range', min: 0, max: 1, step: 0.01, value: 0 });
    slider.dataset.name = name;
    slider.setAttribute('aria-label', name);
    slider.addEventListener('input', () => {
      playing = false;
      face.weights[k] = Number(slider.value);
      show();
    });
    label.append(text, slider);
    return label;
  }));
  if (motion) find('time').max = motion.times[motion.times.length - 1];
}

function setWeights(weights) {
  face.weights = weights;
  find('sliders').querySelectorAll('input').forEach((slider, k) => (slider.value = weights[k]));
  show();
}

function seek(time) {
  const { times, weights } = motion, n = face.targets.length;
  let k = 0;
  while (k + 2 < times.length && times[k + 1] <= time) ++k;
  const span = times[k + 1] - times[k] || 1, s = Math.min(Math.max((time - times[k]) / span, 0), 1);
  setWeights(Array.from({ length: n }, (_, i) => (1 - s) * weights[k * n + i] + s * (weights[(k + 1) * n + i] ?? weights[k * n + i])));
  find('time').value = time;
}

/** Opens a file's bytes: a head asset, or an animated head whose expressions are laid on the asset shown. */
async function open(data, isWhole = true) {
  draco ??= await window.phizDraco();
  const document = readDocument(data);
  if (document === null) {
    if (isWhole) throw new Error('ends early');
    return;
  }
  const { json, begin } = document;
  if (!isHeadAsset(json)) {
    openTargets(json, begin, data);
    return;
  }
  bytes = data;
  if (asset === null || asset.key !== JSON.stringify(json.extensions)) {
    asset = new HeadAsset(json, begin, draco);
    asset.key = JSON.stringify(json.extensions);
    face = new Face(asset);
    confidences = motion = null;
    mesh.visible = false;
    wanted = Infinity;
    find('shapes').hidden = find('motion').hidden = true;
  }
  await refineAll(isWhole);
  if (pending) {
    const targets = pending;
    pending = null;
    openTargets(...targets);
  }
}

/** Fetches and shows while bytes arrive. */
async function openUrl(url) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status}`);
  const chunks = [], reader = response.body.getReader();
  let length = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    chunks.push(value);
    length += value.length;
    const all = new Uint8Array(length);
    chunks.reduce((at, chunk) => (all.set(chunk, at), at + chunk.length), 0);
    await open(all, false);
    chunks.splice(0, chunks.length, all);
  }
  await open(chunks[0] ?? new Uint8Array(0));
}

async function attempt(work) {
  try {
    await work();
  } catch (error) {
    state.textContent = `Cannot open: ${error.message}`;
  }
}

const openFiles = (files) => attempt(async () => {
  for (const file of files) await open(new Uint8Array(await file.arrayBuffer()));
});
find('file').addEventListener('change', (event) => openFiles(event.target.files));
stage.addEventListener('dragover', (event) => (event.preventDefault(), stage.classList.add('drop')));
stage.addEventListener('dragleave', () => stage.classList.remove('drop'));
stage.addEventListener('drop', (event) => {
  event.preventDefault();
  stage.classList.remove('drop');
  openFiles(event.dataTransfer.files);
});
find('level').addEventListener('input', (event) => ((wanted = Number(event.target.value)), show()));
for (const id of ['paint', 'wire']) find(id).addEventListener('change', show);
find('neutral').addEventListener('click', () => ((playing = false), setWeights(face.targets.map(() => 0))));
find('time').addEventListener('input', (event) => ((playing = false), seek(Number(event.target.value))));
const togglePlay = () => {
  if (!motion) return;
  playing = !playing;
  startedAt = performance.now() - 1000 * Number(find('time').value);
};
find('play').addEventListener('click', togglePlay);
controls.addEventListener('change', ask);
window.addEventListener('resize', resize);
window.addEventListener('keydown', (event) => {
  if (event.target.matches('input, select, button')) return;
  const turn = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
  const offset = camera.position.clone().sub(controls.target);
  if (turn) {
    const round = new THREE.Spherical().setFromVector3(offset);
    round.theta += turn[0];
    round.phi += turn[1];
    offset.setFromSpherical(round.makeSafe());
  } else if (event.key === '+' || event.key === '-') offset.multiplyScalar(event.key === '+' ? 0.9 : 1.1);
  else if (event.key === 'w') find('wire').click();
  else if (event.key === 'n' && face) find('neutral').click();
  else if (event.key === ' ') togglePlay();
  else return;
  event.preventDefault();
  camera.position.copy(controls.target).add(offset);
  controls.update();
  ask();
});

function draw(now) {
  requestAnimationFrame(draw);
  if (playing && motion) {
    const end = motion.times[motion.times.length - 1];
    seek(((now - startedAt) / 1000) % (end || 1));
  }
  if (!frameWanted) return;
  frameWanted = false;
  renderer.render(scene, camera);
}

resize();
requestAnimationFrame(draw);

/** For tests and figures: milliseconds from bytes to the finest level's positions, and levels in a prefix. */
function measure(data) {
  const begin = performance.now(), { json, begin: at } = readDocument(data);
  new HeadAsset(json, at, draco).advance(data);
  return performance.now() - begin;
}
function levelsIn(data) {
  const document = readDocument(data);
  return document === null ? 0 : new HeadAsset(document.json, document.begin, draco).advance(data, 1);
}
/** The row of the picture in which the highest point of height y (mm) may stand. */
function rowOf(y, height) {
  let row = height;
  geometry.computeBoundingBox();
  const { min, max } = geometry.boundingBox, point = new THREE.Vector3();
  for (const x of [min.x, max.x]) for (const z of [min.z, max.z]) row = Math.min(row, ((1 - point.set(x, y, z).project(camera).y) / 2) * height);
  return row;
}
window.phizViewer = { measure, levelsIn, rowOf, open, openUrl, timings, show, get asset() { return asset; }, get face() { return face; }, get level() { return level; }, seek };
attempt(async () => {
  for (const data of window.phizFiles ?? []) await open(Uint8Array.from(atob(data), (c) => c.charCodeAt(0)));
  const url = new URLSearchParams(location.search).getAll('open');
  for (const each of url) await openUrl(each);
});

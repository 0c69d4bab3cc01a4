// Reads PHIZ_displaced_subdivision (formats/HEAD_ASSET.md): level by level, from a whole file or as it arrives.
import { ResidualModel } from './residual_model.js';
import { displace, makeStencils, refinePositions } from './subdivision.js';
import { makeControl, refine } from './topology.js';

const EXTENSION = 'PHIZ_displaced_subdivision';

/** The JSON and where the second chunk begins, or null where the bytes end before both are known. */
export function readDocument(bytes) {
  if (bytes.length < 20) return null;
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (view.getUint32(0, true) !== 0x46546c67) throw new Error('is not a glb');
  const length = view.getUint32(12, true);
  if (bytes.length < 28 + length) return null;
  const json = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
  return { json, begin: 28 + length };
}

export const isHeadAsset = (json) => json.extensions?.[EXTENSION]?.schema === 2;

const table = Uint32Array.from({ length: 256 }, (_, i) => {
  for (let k = 0; k < 8; ++k) i = i & 1 ? (i >>> 1) ^ 0xedb88320 : i >>> 1;
  return i >>> 0;
});
function sumOf(bytes) {
  let sum = 0xffffffff;
  for (let i = 0; i < bytes.length; ++i) sum = (sum >>> 8) ^ table[(sum ^ bytes[i]) & 255];
  return ~sum >>> 0;
}

/** A head that grows by levels. `draco` is a decoder module of draco3d. */
export class HeadAsset {
  constructor(json, begin, draco) {
    this.json = json;
    this.begin = begin;
    this.draco = draco;
    this.extension = json.extensions[EXTENSION];
    if (this.extension.scheme !== 'modified-butterfly' || this.extension.coder !== 'phiz-residual-1')
      throw new Error('holds another scheme or coder');
    this.model = new ResidualModel();
    this.levels = []; // topology of each
    this.stencils = []; // of each but the first
    this.positions = []; // mm
    this.confidences = null;
  }

  get levelCount() {
    return this.extension.levels.length;
  }

  streamOf(bytes, viewIdx, crc32) {
    const view = this.json.bufferViews[viewIdx];
    const begin = this.begin + (view.byteOffset ?? 0), end = begin + view.byteLength;
    if (bytes.length < end) return null;
    const stream = bytes.subarray(begin, end);
    if (crc32 !== undefined && sumOf(stream) !== crc32) throw new Error('a stream is damaged');
    return stream;
  }

  /** Takes as many levels out of `bytes` as they hold whole, at most `most` more; returns how many. */
  advance(bytes, most = Infinity) {
    let added = 0;
    while (added < most && this.levels.length < this.levelCount) {
      const k = this.levels.length, entry = this.extension.levels[k];
      const stream = this.streamOf(bytes, entry.displacements, entry.crc32);
      if (stream === null || (k === 0 && !this.readControl(bytes))) break;
      const topology = k === 0 ? this.control : refine(this.levels[k - 1]);
      if (topology.vertexCount !== entry.vertices) throw new Error(`level ${k} has another number of vertices`);
      let positions = this.controlPositions.slice();
      if (k > 0) {
        const stencils = makeStencils(this.levels[k - 1], topology);
        this.stencils[k] = stencils;
        positions = refinePositions(stencils, topology, this.positions[k - 1]);
      }
      const numbers = this.model.decode(topology, stream);
      displace(topology, k === 0 ? null : this.levels[k - 1], positions, numbers, entry.step_mm);
      this.levels.push(topology);
      this.positions.push(positions);
      ++added;
    }
    return added;
  }

  /** Undisplaced positions of level k from positions of the level before. */
  refineOnly(k, positions) {
    return refinePositions(this.stencils[k], this.levels[k], positions);
  }

  readControl(bytes) {
    const control = this.extension.control;
    const stream = this.streamOf(bytes, control.bufferView, control.crc32);
    if (stream === null) return false;
    const { positions, corners } = decodeDraco(this.draco, stream);
    const step = control.position_step_mm;
    this.controlPositions = Float64Array.from(positions, (x) => Math.fround(Math.round(x / step) * step));
    this.control = makeControl(corners, control.vertices);
    return true;
  }

  /** One byte a vertex of the finest level, 255 measured; null where the file holds none or not all yet. */
  readConfidences(bytes) {
    const { levels, confidence_step: step } = this.extension;
    if (step === undefined) return null;
    const all = [];
    for (const entry of levels) {
      const stream = this.streamOf(bytes, entry.confidences);
      if (stream === null) return null;
      for (const value of decodeDracoIntegers(this.draco, stream)) all.push(Math.min(255, value * step));
    }
    return Uint8Array.from(all);
  }
}

function decodeDraco(draco, stream) {
  const decoder = new draco.Decoder(), mesh = new draco.Mesh();
  try {
    const status = decoder.DecodeArrayToMesh(new Int8Array(stream), stream.length, mesh);
    if (!status.ok()) throw new Error(`control mesh: ${status.error_msg()}`);
    const points = mesh.num_points(), faces = mesh.num_faces();
    const rows = new draco.DracoFloat32Array();
    decoder.GetAttributeFloatForAllPoints(mesh, decoder.GetAttributeByUniqueId(mesh, 0), rows);
    const positions = new Float32Array(3 * points);
    for (let i = 0; i < positions.length; ++i) positions[i] = rows.GetValue(i);
    draco.destroy(rows);
    const face = new draco.DracoInt32Array(), corners = new Int32Array(3 * faces);
    for (let t = 0; t < faces; ++t) {
      decoder.GetFaceFromMesh(mesh, t, face);
      for (let k = 0; k < 3; ++k) corners[3 * t + k] = face.GetValue(k);
    }
    draco.destroy(face);
    return { positions, corners };
  } finally {
    draco.destroy(mesh);
    draco.destroy(decoder);
  }
}

function decodeDracoIntegers(draco, stream) {
  const decoder = new draco.Decoder(), cloud = new draco.PointCloud();
  const status = decoder.DecodeArrayToPointCloud(new Int8Array(stream), stream.length, cloud);
  if (!status.ok()) throw new Error(`confidences: ${status.error_msg()}`);
  const rows = new draco.DracoInt32Array();
  decoder.GetAttributeInt32ForAllPoints(cloud, decoder.GetAttributeByUniqueId(cloud, 0), rows);
  const numbers = new Int32Array(cloud.num_points());
  for (let i = 0; i < numbers.length; ++i) numbers[i] = rows.GetValue(i);
  draco.destroy(rows);
  draco.destroy(cloud);
  draco.destroy(decoder);
  return numbers;
}

// A head that moves: the finest decoded level, or a coarser one, with morph targets of any coarser level on top.
// Vertex k is the same place at every level, so that offsets of a coarse level are refined like positions.
import { refinePositions } from './subdivision.js';

export class Face {
  constructor(asset) {
    this.asset = asset;
    this.targets = []; // {name, vertices: Int32Array, offsets: Float32Array} in mm
    this.targetLevel = -1;
    this.weights = [];
  }

  /** Morph targets for all vertices of the level that has as many; false where none has. */
  setTargets(targets, vertexCount) {
    const level = this.asset.extension.levels.findIndex((entry) => entry.vertices === vertexCount);
    if (level < 0) return false;
    this.targets = targets;
    this.targetLevel = level;
    this.weights = targets.map(() => 0);
    return true;
  }

  /** Positions in mm of a level under the present weights. */
  positions(level) {
    const rest = this.asset.positions[level];
    if (this.weights.every((w) => w === 0) || this.targetLevel >= this.asset.levels.length) return rest;
    let offsets = new Float64Array(3 * this.asset.levels[this.targetLevel].vertexCount);
    this.targets.forEach(({ vertices, offsets: moves }, k) => {
      const w = this.weights[k];
      if (w === 0) return;
      for (let i = 0; i < vertices.length; ++i)
        for (let c = 0; c < 3; ++c) offsets[3 * vertices[i] + c] += w * moves[3 * i + c];
    });
    for (let k = this.targetLevel + 1; k <= level; ++k)
      offsets = refinePositions(this.asset.stencils[k], this.asset.levels[k], offsets);
    const moved = new Float64Array(rest.length);
    for (let i = 0; i < moved.length; ++i) moved[i] = rest[i] + offsets[i];
    return moved;
  }
}

/** Unit normals, averaged by area. */
export function vertexNormals(positions, corners) {
  const normals = new Float32Array(positions.length);
  for (let t = 0; t < corners.length; t += 3) {
    const a = 3 * corners[t], b = 3 * corners[t + 1], c = 3 * corners[t + 2];
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1], uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1], vz = positions[c + 2] - positions[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    for (const v of [a, b, c]) {
      normals[v] += x;
      normals[v + 1] += y;
      normals[v + 2] += z;
    }
  }
  for (let v = 0; v < normals.length; v += 3) {
    const length = Math.sqrt(normals[v] ** 2 + normals[v + 1] ** 2 + normals[v + 2] ** 2) || 1;
    normals[v] /= length;
    normals[v + 1] /= length;
    normals[v + 2] /= length;
  }
  return normals;
}

/** What an animated .glb of phiz holds: its targets (sparse accessors) and the motion of their weights. */
export function readTargets(json, bin) {
  const mesh = json.meshes?.[0], primitive = mesh?.primitives?.[0];
  if (!primitive?.targets) return null;
  const names = mesh.extras?.targetNames ?? [];
  const viewOf = (idx) => json.bufferViews[idx];
  const floats = (idx, count, offset = 0) => {
    const view = viewOf(idx), begin = bin.byteOffset + (view.byteOffset ?? 0) + offset;
    return new Float32Array(bin.buffer.slice(begin, begin + 4 * count));
  };
  const integers = (idx, count, type, offset = 0) => {
    const view = viewOf(idx), begin = bin.byteOffset + (view.byteOffset ?? 0) + offset;
    const Kind = { 5121: Uint8Array, 5123: Uint16Array, 5125: Uint32Array }[type];
    return Int32Array.from(new Kind(bin.buffer.slice(begin, begin + Kind.BYTES_PER_ELEMENT * count)));
  };
  const targets = primitive.targets.map(({ POSITION }, k) => {
    const accessor = json.accessors[POSITION], sparse = accessor.sparse;
    const name = names[k] ?? `target ${k}`;
    if (sparse) {
      return {
        name,
        vertices: integers(sparse.indices.bufferView, sparse.count, sparse.indices.componentType, sparse.indices.byteOffset),
        offsets: floats(sparse.values.bufferView, 3 * sparse.count, sparse.values.byteOffset),
      };
    }
    if (accessor.bufferView === undefined) return { name, vertices: new Int32Array(0), offsets: new Float32Array(0) };
    return {
      name,
      vertices: Int32Array.from({ length: accessor.count }, (_, i) => i),
      offsets: floats(accessor.bufferView, 3 * accessor.count, accessor.byteOffset),
    };
  });
  let motion = null;
  const animation = json.animations?.[0];
  const channel = animation?.channels.find((c) => c.target.path === 'weights');
  if (channel) {
    const sampler = animation.samplers[channel.sampler], input = json.accessors[sampler.input], output = json.accessors[sampler.output];
    motion = { times: floats(input.bufferView, input.count, input.byteOffset), weights: floats(output.bufferView, output.count, output.byteOffset) };
  }
  return { targets, motion, vertexCount: json.accessors[primitive.attributes.POSITION].count };
}

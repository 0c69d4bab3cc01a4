// Modified Butterfly (Zorin, Schröder, Sweldens 1996; border rules: Zorin 1997) and displacement along normals,
// as in stages/subdivide. Positions are Float64Array, three numbers a vertex, mm.

const nextOf = (h) => (h % 3 === 2 ? h - 2 : h + 1);
const before = (h) => (h % 3 === 0 ? h + 2 : h - 1);

/** What the rules ask of a level's vertices: valence, border neighbours, an outgoing half-edge each. */
function describeVertices(level) {
  const { corners, twins, vertexCount } = level;
  const valence = new Int32Array(vertexCount), outgoing = new Int32Array(vertexCount).fill(-1);
  const borderNext = new Int32Array(vertexCount).fill(-1), borderPrev = new Int32Array(vertexCount).fill(-1);
  for (let h = 0; h < corners.length; ++h) {
    const a = corners[h], b = corners[nextOf(h)];
    ++valence[a];
    if (outgoing[a] < 0) outgoing[a] = h;
    if (twins[h] < 0) {
      ++valence[b];  // the edge has no half-edge that leaves b
      borderNext[a] = b;
      borderPrev[b] = a;
    }
  }
  for (let h = 0; h < corners.length; ++h) if (twins[h] < 0) outgoing[corners[h]] = h;
  return { valence, outgoing, borderNext, borderPrev };
}

function ringOf(level, outgoing, v) {
  const { corners, twins } = level, ring = [];
  let h = outgoing[v];
  const first = h;
  do {
    ring.push(corners[nextOf(h)]);
    const back = before(h);
    if (twins[back] < 0) {
      ring.push(corners[back]);
      break;
    }
    h = twins[back];
  } while (h !== first);
  return ring;
}

function innerWeight(j, valence) {
  if (valence === 3) return j === 0 ? 5 / 12 : -1 / 12;
  if (valence === 4) return j === 0 ? 3 / 8 : j === 2 ? -1 / 8 : 0;
  return (0.25 + Math.cos((2 * Math.PI * j) / valence) + 0.5 * Math.cos((4 * Math.PI * j) / valence)) / valence;
}

function borderWeight(i, j, k) {
  const sin = (n) => Math.sin((Math.PI * n) / k), cos = (n) => Math.cos((Math.PI * n) / k);
  if (j === 0 || j === k) {
    const along = 0.25 * cos(i) - (sin(2) * sin(2 * i)) / (4 * k * (cos(1) - cos(2)));
    return j === 0 ? along : -along;
  }
  return (sin(i) * sin(j) + 0.5 * sin(2 * i) * sin(2 * j)) / k;
}

/**
 * Rows of weights for the new vertices of `fine`, a level that `refine` made of `level`: eight entries for a
 * regular edge stand in `regular` (vertices only: their weights are always the same), others in `rows`.
 */
export function makeStencils(level, fine) {
  const { corners, twins } = level, { firsts } = fine;
  const { valence, outgoing, borderNext, borderPrev } = describeVertices(level);
  const isBorder = (v) => borderNext[v] >= 0;
  const isRegular = (v) => valence[v] === (isBorder(v) ? 4 : 6);
  const count = firsts.length, regular = new Int32Array(8 * count), rows = new Map();
  for (let e = 0; e < count; ++e) {
    const h = firsts[e], t = twins[h], a = corners[h], b = corners[nextOf(h)];
    if (t >= 0 && isRegular(a) && isRegular(b)) {
      const w0 = twins[nextOf(h)], w1 = twins[before(h)], w2 = twins[nextOf(t)], w3 = twins[before(t)];
      if (w0 >= 0 && w1 >= 0 && w2 >= 0 && w3 >= 0) {
        const at = 8 * e;
        regular[at] = a;
        regular[at + 1] = b;
        regular[at + 2] = corners[before(h)];
        regular[at + 3] = corners[before(t)];
        regular[at + 4] = corners[before(w0)];
        regular[at + 5] = corners[before(w1)];
        regular[at + 6] = corners[before(w2)];
        regular[at + 7] = corners[before(w3)];
        continue;
      }
    }
    regular[8 * e] = -1;
    const row = new Map(), add = (v, w) => row.set(v, (row.get(v) ?? 0) + w);
    if (t < 0) {
      add(a, 9 / 16), add(b, 9 / 16), add(borderPrev[a], -1 / 16), add(borderNext[b], -1 / 16);
    } else if (isRegular(a) && isRegular(b)) {
      add(a, 0.5), add(b, 0.5);
      for (const half of [h, t]) {
        add(corners[before(half)], 1 / 8);
        for (const side of [nextOf(half), before(half)]) {
          if (twins[side] >= 0) {
            add(corners[before(twins[side])], -1 / 16);
          } else {
            add(corners[side], -1 / 16), add(corners[nextOf(side)], -1 / 16), add(corners[before(side)], 1 / 16);
          }
        }
      }
    } else {
      const share = isRegular(a) || isRegular(b) ? 1 : 0.5;
      for (const [v, towards] of [[a, b], [b, a]]) {
        if (isRegular(v)) continue;
        const ring = ringOf(level, outgoing, v), n = ring.length, split = ring.indexOf(towards);
        let ofRing = 0;
        if (!isBorder(v) && n === 2) {
          add(towards, 0.5 * share);
          ofRing = 0.5;
        } else {
          for (let k = 0; k < n; ++k) {
            const w = isBorder(v) ? borderWeight(split, k, n - 1) : innerWeight((k - split + n) % n, n);
            ofRing += w;
            add(ring[k], w * share);
          }
        }
        add(v, (1 - ofRing) * share);
      }
    }
    rows.set(e, [...row]);
  }
  return { regular, rows };
}

/** Appends the undisplaced new vertices of `fine` to positions of the level before. */
export function refinePositions(stencils, fine, coarse) {
  const positions = new Float64Array(3 * fine.vertexCount);
  positions.set(coarse);
  const { regular, rows } = stencils, count = fine.firsts.length;
  for (let e = 0; e < count; ++e) {
    const at = 8 * e, out = 3 * (fine.firstNew + e);
    if (regular[at] >= 0) {
      const a = 3 * regular[at], b = 3 * regular[at + 1], c = 3 * regular[at + 2], d = 3 * regular[at + 3];
      const e0 = 3 * regular[at + 4], e1 = 3 * regular[at + 5], e2 = 3 * regular[at + 6], e3 = 3 * regular[at + 7];
      for (let k = 0; k < 3; ++k) {
        positions[out + k] = 0.5 * (coarse[a + k] + coarse[b + k]) + 0.125 * (coarse[c + k] + coarse[d + k]) -
          0.0625 * (coarse[e0 + k] + coarse[e1 + k] + coarse[e2 + k] + coarse[e3 + k]);
      }
    } else {
      for (const [v, w] of rows.get(e)) for (let k = 0; k < 3; ++k) positions[out + k] += w * coarse[3 * v + k];
    }
  }
  return positions;
}

/** Adds step * number along the angle-weighted normal of each new vertex, normals taken before any moves. */
export function displace(level, coarseLevel, positions, numbers, step) {
  const moved = new Float64Array(3 * numbers.length);
  if (coarseLevel === null) {
    const normals = angleNormals(level, positions);
    for (let i = 0; i < moved.length; ++i) moved[i] = Math.fround(step * numbers[(i / 3) | 0]) * normals[i];
  } else {
    const { edges, twins, corners } = coarseLevel, first = level.firstNew, ring = new Int32Array(7);
    for (let e = 0; e < numbers.length; ++e) {
      if (numbers[e] === 0) continue;
      const h = level.firsts[e], t = twins[h], centre = 3 * (first + e);
      ring[0] = corners[nextOf(h)];
      ring[1] = first + edges[nextOf(h)];
      ring[2] = first + edges[before(h)];
      ring[3] = corners[h];
      let n = 4;
      if (t >= 0) {
        ring[4] = first + edges[nextOf(t)];
        ring[5] = first + edges[before(t)];
        ring[6] = ring[0];
        n = 7;
      }
      let nx = 0, ny = 0, nz = 0;
      const cx = positions[centre], cy = positions[centre + 1], cz = positions[centre + 2];
      let ux = positions[3 * ring[0]] - cx, uy = positions[3 * ring[0] + 1] - cy, uz = positions[3 * ring[0] + 2] - cz;
      for (let k = 1; k < n; ++k) {
        const v = 3 * ring[k];
        const vx = positions[v] - cx, vy = positions[v + 1] - cy, vz = positions[v + 2] - cz;
        const fx = uy * vz - uz * vy, fy = uz * vx - ux * vz, fz = ux * vy - uy * vx;
        const length = Math.sqrt(fx * fx + fy * fy + fz * fz);
        if (length > 0) {
          const w = Math.atan2(length, ux * vx + uy * vy + uz * vz) / length;
          nx += w * fx;
          ny += w * fy;
          nz += w * fz;
        }
        ux = vx;
        uy = vy;
        uz = vz;
      }
      const length = Math.sqrt(nx * nx + ny * ny + nz * nz);
      const way = length > 0 ? Math.fround(step * numbers[e]) / length : 0;
      moved[3 * e] = way * nx;
      moved[3 * e + 1] = way * ny;
      moved[3 * e + 2] = way * nz;
    }
  }
  const base = 3 * level.firstNew;
  for (let i = 0; i < moved.length; ++i) positions[base + i] += moved[i];
}

function angleNormals(level, positions) {
  const normals = new Float64Array(positions.length), { corners } = level;
  for (let t = 0; t < corners.length; t += 3) {
    for (let k = 0; k < 3; ++k) {
      const a = 3 * corners[t + k], b = 3 * corners[t + ((k + 1) % 3)], c = 3 * corners[t + ((k + 2) % 3)];
      const u = [0, 1, 2].map((i) => positions[b + i] - positions[a + i]);
      const v = [0, 1, 2].map((i) => positions[c + i] - positions[a + i]);
      const f = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      const length = Math.hypot(...f);
      if (length === 0) continue;
      const w = Math.atan2(length, u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) / length;
      for (let i = 0; i < 3; ++i) normals[a + i] += w * f[i];
    }
  }
  for (let v = 0; v < normals.length; v += 3) {
    const length = Math.hypot(normals[v], normals[v + 1], normals[v + 2]) || 1;
    for (let i = 0; i < 3; ++i) normals[v + i] /= length;
  }
  return normals;
}

// Connectivity of the levels: the numbering of formats/level_topology.h. Half-edge 3 t + i runs from corner i to
// corner i+1 of triangle t; new vertices are numbered by the first half-edge that runs along their edge.

const nextOf = (h) => (h % 3 === 2 ? h - 2 : h + 1);
const before = (h) => (h % 3 === 0 ? h + 2 : h - 1);

function numberEdges(level) {
  const { twins } = level;
  const edges = new Int32Array(twins.length);
  let count = 0;
  for (let h = 0; h < twins.length; ++h) edges[h] = twins[h] >= 0 && twins[h] < h ? edges[twins[h]] : count++;
  level.edges = edges;
  level.edgeCount = count;
}

/** Level 0 from corners (three a triangle). */
export function makeControl(corners, vertexCount) {
  const twins = new Int32Array(corners.length).fill(-1);
  const open = new Map();
  const pairs = [];
  for (let h = 0; h < corners.length; ++h) {
    const a = corners[h], b = corners[nextOf(h)];
    if (a === b || a >= vertexCount) throw new Error(`triangle ${(h / 3) | 0} is no triangle`);
    const twin = open.get(b * vertexCount + a);
    if (twin !== undefined) {
      twins[h] = twin;
      twins[twin] = h;
    } else {
      open.set(a * vertexCount + b, h);
      pairs.push([Math.max(a, b), Math.min(a, b)]);
    }
  }
  pairs.sort((x, y) => x[0] - y[0] || x[1] - y[1]);
  const offsets = new Int32Array(vertexCount + 1);
  const earlier = new Int32Array(pairs.length);
  pairs.forEach(([late, early], i) => {
    ++offsets[late + 1];
    earlier[i] = early;
  });
  for (let v = 0; v < vertexCount; ++v) offsets[v + 1] += offsets[v];
  const level = { corners: Int32Array.from(corners), twins, vertexCount, firstNew: 0, offsets, earlier, parents: null };
  numberEdges(level);
  return level;
}

/** The next finer level: triangle t becomes 4t .. 4t+3, its corners in order and then the middle one. */
export function refine(level) {
  const { corners, twins, edges, edgeCount, vertexCount } = level;
  const fine = {
    corners: new Int32Array(4 * corners.length), twins: new Int32Array(4 * corners.length),
    vertexCount: vertexCount + edgeCount, firstNew: vertexCount,
    offsets: new Int32Array(edgeCount + 1), earlier: new Int32Array(4 * edgeCount),
    parents: new Int32Array(2 * edgeCount), firsts: new Int32Array(edgeCount),
  };
  const c = fine.corners, w = fine.twins;
  for (let h = 0; h < corners.length; ++h) {
    const t = (h / 3) | 0, i = h - 3 * t, child = 3 * (4 * t + i), middle = 3 * (4 * t + 3);
    c[child] = corners[h];
    c[child + 1] = vertexCount + edges[h];
    c[child + 2] = vertexCount + edges[before(h)];
    c[middle + i] = vertexCount + edges[h];
    const twin = twins[h], nextChild = 3 * (4 * t + ((i + 1) % 3)) + 2;
    if (twin < 0) {
      w[child] = w[nextChild] = -1;
    } else {
      const other = 3 * (4 * ((twin / 3) | 0) + (((twin % 3) + 1) % 3)) + 2;
      w[child] = other;
      w[other] = child;
    }
    w[child + 1] = middle + ((i + 2) % 3);
    w[middle + ((i + 2) % 3)] = child + 1;
  }
  numberEdges(fine);
  let at = 0, edge = 0;
  for (let h = 0; h < corners.length; ++h) {
    if (edges[h] !== edge) continue;
    const twin = twins[h];
    fine.firsts[edge] = h;
    fine.parents[2 * edge] = corners[h];
    fine.parents[2 * edge + 1] = corners[nextOf(h)];
    const n = edges[nextOf(h)], p = edges[before(h)];
    if (n < edge) fine.earlier[at++] = n;
    if (p < edge) fine.earlier[at++] = p;
    if (twin >= 0) {
      const n2 = edges[nextOf(twin)], p2 = edges[before(twin)];
      if (n2 < edge) fine.earlier[at++] = n2;
      if (p2 < edge) fine.earlier[at++] = p2;
    }
    fine.offsets[++edge] = at;
  }
  return fine;
}

// The decoder of formats/residual_coder.h: whole numbers throughout, the same arithmetic as there.

const CLASSES = 32, SIGNS = 17, FINE_CLASSES = 64;
const SIZES = [CLASSES * 5, SIGNS * CLASSES, CLASSES * CLASSES, FINE_CLASSES];
const NODES = 20, UNARY = 18, MOST_ESCAPE_BITS = 24;
const LIMIT = 2047, LEAST = 32, MOST = 65536 - 32, SLOWEST = 128, MOST_WEIGHT = 1 << 18;

const squash = new Uint16Array(2 * LIMIT + 1), stretch = new Int16Array(4096), rate = new Int32Array(SLOWEST);
{
  const limited = (x) => Math.min(Math.max(x, LEAST), MOST);
  let e = 0, term = 1;
  for (let k = 1; k < 12; ++k) {
    e += term;
    term /= 256 * k;
  }
  let power = 1;
  for (let s = 0; s <= LIMIT; ++s) {
    squash[LIMIT + s] = limited(Math.floor((65536 * power) / (1 + power) + 0.5));
    squash[LIMIT - s] = limited(Math.floor(65536 / (1 + power) + 0.5));
    power *= e;
  }
  let s = -LIMIT;
  for (let i = 0; i < 4096; ++i) {
    while (s < LIMIT && squash[LIMIT + s] < 16 * i + 8) ++s;
    stretch[i] = s;
  }
  for (let n = 0; n < SLOWEST; ++n) rate[n] = Math.floor(131072 / (2 * n + 3));
}

const classOf = (x) => {
  const width = 32 - Math.clz32(x + 8);
  const found = 4 * (width - 4) + (((x + 8) >> (width - 3)) & 3);
  return found < CLASSES ? found : CLASSES - 1;
};
const fineClassOf = (x) => {
  const width = 32 - Math.clz32(x + 8);
  const found = 8 * (width - 4) + (((x + 8) >> (width - 4)) & 7);
  return found < FINE_CLASSES ? found : FINE_CLASSES - 1;
};
const magnitudeOf = (x) => Math.min(x < 0 ? -x : x, 4095);
const clamp = (x, low, high) => (x < low ? low : x > high ? high : x);

export class ResidualModel {
  constructor() {
    const count = (SIZES[0] + SIZES[1] + SIZES[2] + SIZES[3]) * NODES;
    this.one = new Uint16Array(count).fill(32768);
    this.seen = new Uint8Array(count);
    this.weights = new Int32Array(4 * NODES * 16).fill(65536 / 4);
    this.restOne = new Uint16Array(8).fill(32768);
    this.restSeen = new Uint8Array(8);
    this.activities = new Int32Array(0);
    this.isFine = new Uint8Array(0);
    this.places = new Int32Array(4);
  }

  /** Numbers of the new vertices of the next level; `level` is of topology.js. */
  decode(level, bytes) {
    const count = level.vertexCount - level.firstNew;
    if (count > 32768 * (bytes.length + 8)) throw new Error('a stream is too short for its numbers');
    this.bytes = bytes;
    this.at = 0;
    this.low = 0;
    this.high = 0xffffffff;
    this.value = 0;
    for (let i = 0; i < 4; ++i) this.value = ((this.value << 8) | this.nextByte()) >>> 0;
    const numbers = new Int32Array(count), slow = new Int32Array(count);
    const { offsets, earlier, parents } = level;
    const { activities, isFine, places } = this;
    let lastSlow = 0;
    for (let i = 0; i < count; ++i) {
      const begin = offsets[i], end = Math.min(offsets[i + 1], begin + 4), n = end - begin;
      let size = 0, sum = 0, mean = 0, fine = 0;
      for (let k = begin; k < end; ++k) {
        const u = earlier[k], whole = numbers[u] >> 1;
        size += magnitudeOf(whole);
        sum += clamp(whole, -4095, 4095);
        mean += slow[u];
        fine += numbers[u] & 1;
      }
      const near = n > 0 ? ((16 * size) / n) | 0 : 0, sign = n > 0 ? ((2 * sum) / n) | 0 : 0;
      mean = n > 0 ? (mean / n) | 0 : lastSlow;
      let coarse = mean;
      if (parents !== null) {
        const a = parents[2 * i], b = parents[2 * i + 1];
        coarse = (activities[a] + activities[b]) >> 1;
        fine += isFine[a] + isFine[b];
      }
      const around = classOf(((16 * size + coarse) / (n + 1)) | 0);
      places[0] = (around * 5 + n) * NODES;
      places[1] = (SIZES[0] + (clamp(sign, -8, 8) + 8) * CLASSES + classOf(near)) * NODES;
      places[2] = (SIZES[0] + SIZES[1] + classOf(mean) * CLASSES + classOf(coarse)) * NODES;
      places[3] = (SIZES[0] + SIZES[1] + SIZES[2] + fineClassOf((2 * mean + near + coarse) >> 2)) * NODES;
      const whole = this.readNumber(around >> 1, clamp(sign, -7, 7) + 7);
      const rest = this.readPlainBit((fine < 3 ? fine : 3) * 2 + (whole === 0 ? 1 : 0));
      numbers[i] = 2 * whole + rest;
      slow[i] = lastSlow = ((115 * 16 * magnitudeOf(whole) + 141 * mean) / 256) | 0;
    }
    this.closeLevel(level, numbers);
    return numbers;
  }

  closeLevel(level, numbers) {
    const { firstNew, vertexCount, parents } = level;
    const activities = new Int32Array(vertexCount), isFine = new Uint8Array(vertexCount);
    isFine.set(this.isFine);
    if (parents !== null) {
      const counts = new Int32Array(firstNew);
      for (let i = 0; i < numbers.length; ++i) {
        const size = 8 * magnitudeOf(numbers[i] >> 1);
        for (let k = 2 * i; k < 2 * i + 2; ++k) {
          activities[parents[k]] += size;
          ++counts[parents[k]];
          if (numbers[i] & 1) isFine[parents[k]] = 1;
        }
      }
      for (let v = 0; v < firstNew; ++v) activities[v] = (activities[v] / Math.max(counts[v], 1)) | 0;
    }
    for (let i = 0; i < numbers.length; ++i) {
      activities[firstNew + i] = 8 * magnitudeOf(numbers[i] >> 1);
      if (numbers[i] & 1) isFine[firstNew + i] = 1;
    }
    this.activities = activities;
    this.isFine = isFine;
  }

  nextByte() {
    return this.at < this.bytes.length ? this.bytes[this.at++] : 0;
  }

  readBit(one) {
    const range = (this.high - this.low) >>> 0;
    const middle = (this.low + (range >>> 16) * one + (((range & 0xffff) * one) >>> 16)) >>> 0;
    const bit = this.value <= middle ? 1 : 0;
    if (bit) this.high = middle;
    else this.low = (middle + 1) >>> 0;
    while (((this.low ^ this.high) & 0xff000000) === 0) {
      this.low = (this.low << 8) >>> 0;
      this.high = ((this.high << 8) | 255) >>> 0;
      this.value = ((this.value << 8) | this.nextByte()) >>> 0;
    }
    return bit;
  }

  readMixedBit(node, mixer) {
    const { one, seen, weights, places } = this;
    const base = 4 * (node * 16 + mixer);
    const p0 = places[0] + node, p1 = places[1] + node, p2 = places[2] + node, p3 = places[3] + node;
    const s0 = stretch[one[p0] >> 4], s1 = stretch[one[p1] >> 4], s2 = stretch[one[p2] >> 4], s3 = stretch[one[p3] >> 4];
    const sum = ((weights[base] * s0) >> 8) + ((weights[base + 1] * s1) >> 8) + ((weights[base + 2] * s2) >> 8) +
      ((weights[base + 3] * s3) >> 8);
    const chance = squash[LIMIT + clamp(sum >> 8, -LIMIT, LIMIT)];
    const bit = this.readBit(chance), aim = bit ? 65535 : 0, error = aim - chance;
    weights[base] = clamp(weights[base] + ((s0 * error + 8192) >> 14), -MOST_WEIGHT, MOST_WEIGHT);
    weights[base + 1] = clamp(weights[base + 1] + ((s1 * error + 8192) >> 14), -MOST_WEIGHT, MOST_WEIGHT);
    weights[base + 2] = clamp(weights[base + 2] + ((s2 * error + 8192) >> 14), -MOST_WEIGHT, MOST_WEIGHT);
    weights[base + 3] = clamp(weights[base + 3] + ((s3 * error + 8192) >> 14), -MOST_WEIGHT, MOST_WEIGHT);
    one[p0] += Math.floor(((aim - one[p0]) * rate[seen[p0]]) / 65536);
    one[p1] += Math.floor(((aim - one[p1]) * rate[seen[p1]]) / 65536);
    one[p2] += Math.floor(((aim - one[p2]) * rate[seen[p2]]) / 65536);
    one[p3] += Math.floor(((aim - one[p3]) * rate[seen[p3]]) / 65536);
    if (seen[p0] < SLOWEST - 1) ++seen[p0];
    if (seen[p1] < SLOWEST - 1) ++seen[p1];
    if (seen[p2] < SLOWEST - 1) ++seen[p2];
    if (seen[p3] < SLOWEST - 1) ++seen[p3];
    return bit;
  }

  readPlainBit(k) {
    const bit = this.readBit(clamp(this.restOne[k], LEAST, MOST));
    this.restOne[k] += Math.floor((((bit ? 65535 : 0) - this.restOne[k]) * rate[this.restSeen[k]]) / 65536);
    if (this.restSeen[k] < SLOWEST - 1) ++this.restSeen[k];
    return bit;
  }

  readNumber(mixer, signMixer) {
    if (this.readMixedBit(0, mixer) === 0) return 0;
    const positive = this.readMixedBit(1, signMixer);
    let found = 1;
    while (found <= UNARY && this.readMixedBit(1 + found, mixer)) ++found;
    if (found > UNARY) {
      let bits = 1, value = 1;
      while (this.readBit(32768)) if (++bits > MOST_ESCAPE_BITS) throw new Error('a displacement is out of range');
      for (let k = bits - 2; k >= 0; --k) value = 2 * value + this.readBit(32768);
      found = UNARY + value;
    }
    return positive ? found : -found;
  }
}

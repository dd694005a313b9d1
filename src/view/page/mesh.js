// Tets as a complex: who is whose neighbour, angles, and which faces show when some tets are left out.

// The faces of a tet (a, b, c, d), counter-clockwise seen from outside.
export const FACES = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

// The number of the tet across each face, -1 at the boundary: 4 a tet.
export function neighbours_of(T) {
  const tets = T.length / 4, neighbours = new Int32Array(4 * tets).fill(-1);
  let size = 16;
  while (size < 6 * tets) size *= 2;
  const slots = new Int32Array(size).fill(-1);  // an open face, by its three vertices
  const three = [0, 0, 0];
  const sorted = face => {
    const tet = face >> 2, f = FACES[face & 3];
    let a = T[4 * tet + f[0]], b = T[4 * tet + f[1]], c = T[4 * tet + f[2]], x;
    if (a > b) { x = a; a = b; b = x; }
    if (b > c) { x = b; b = c; c = x; }
    if (a > b) { x = a; a = b; b = x; }
    three[0] = a; three[1] = b; three[2] = c;
  };
  for (let face = 0; face < 4 * tets; ++face) {
    sorted(face);
    const [a, b, c] = three;
    let at = (Math.imul(a, 73856093) ^ Math.imul(b, 19349663) ^ Math.imul(c, 83492791)) & (size - 1);
    for (;; at = (at + 1) & (size - 1)) {
      const other = slots[at];
      if (other === -1) { slots[at] = face; break; }
      if (other < -1) continue;  // both sides are known
      sorted(other);
      if (three[0] !== a || three[1] !== b || three[2] !== c) continue;
      neighbours[face] = other >> 2;
      neighbours[other] = face >> 2;
      slots[at] = -2;
      break;
    }
  }
  return neighbours;
}

export function centroids_of(V, T) {
  const tets = T.length / 4, C = new Float32Array(3 * tets);
  for (let t = 0; t < tets; ++t)
    for (let k = 0; k < 3; ++k)
      C[3 * t + k] = (V[3 * T[4 * t] + k] + V[3 * T[4 * t + 1] + k] + V[3 * T[4 * t + 2] + k] + V[3 * T[4 * t + 3] + k]) / 4;
  return C;
}

// The smallest dihedral angle of each tet in degrees, and how many of all angles lie in each of 36 parts of 5 degrees.
export function angles_of(V, T) {
  const tets = T.length / 4, least = new Float32Array(tets), histogram = new Int32Array(36);
  const n = [new Float64Array(3), new Float64Array(3), new Float64Array(3), new Float64Array(3)];
  for (let t = 0; t < tets; ++t) {
    for (let f = 0; f < 4; ++f) {
      const a = 3 * T[4 * t + FACES[f][0]], b = 3 * T[4 * t + FACES[f][1]], c = 3 * T[4 * t + FACES[f][2]];
      const ux = V[b] - V[a], uy = V[b + 1] - V[a + 1], uz = V[b + 2] - V[a + 2];
      const vx = V[c] - V[a], vy = V[c + 1] - V[a + 1], vz = V[c + 2] - V[a + 2];
      const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
      const length = Math.sqrt(x * x + y * y + z * z) || 1;
      n[f][0] = x / length; n[f][1] = y / length; n[f][2] = z / length;
    }
    let most = -1;
    for (let f = 0; f < 4; ++f)
      for (let g = f + 1; g < 4; ++g) {
        const cosine = -(n[f][0] * n[g][0] + n[f][1] * n[g][1] + n[f][2] * n[g][2]);
        const angle = Math.acos(Math.max(-1, Math.min(1, cosine))) * 180 / Math.PI;
        ++histogram[Math.min(35, Math.floor(angle / 5))];
        if (cosine > most) most = cosine;
      }
    least[t] = Math.acos(Math.max(-1, Math.min(1, most))) * 180 / Math.PI;
  }
  return {least, histogram};
}

// How far each vertex is from one end of the solid, inside it and along edges, from 0 to 1. Where the solid overlaps
// itself, its layers have different distances: this is what pulls them apart.
export function along_of(V, cells, corners) {
  const vertices = V.length / 3;
  const count = new Int32Array(vertices + 1);
  const pairs = corners === 4 ? [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] : [[0, 1], [1, 2], [2, 0]];
  const each = visit => {
    for (let i = 0; i < cells.length; i += corners)
      for (const [p, q] of pairs) visit(cells[i + p], cells[i + q]);
  };
  each((a, b) => { ++count[a + 1]; ++count[b + 1]; });
  for (let v = 0; v < vertices; ++v) count[v + 1] += count[v];
  const to = new Int32Array(count[vertices]), at = count.slice(0, vertices);
  each((a, b) => { to[at[a]++] = b; to[at[b]++] = a; });
  const distances_from = start => {
    // Rounds over a queue of vertices whose distance has become smaller: few are visited more than twice.
    const d = new Float32Array(vertices).fill(Infinity), waiting = new Uint8Array(vertices);
    let now = [start];
    d[start] = 0;
    while (now.length > 0) {
      const next = [];
      for (const v of now) {
        waiting[v] = 0;
        for (let i = count[v]; i < count[v + 1]; ++i) {
          const w = to[i];
          const x = V[3 * v] - V[3 * w], y = V[3 * v + 1] - V[3 * w + 1], z = V[3 * v + 2] - V[3 * w + 2];
          const length = d[v] + Math.sqrt(x * x + y * y + z * z);
          if (length >= d[w] * (1 - 1e-6)) continue;
          d[w] = length;
          if (!waiting[w]) { waiting[w] = 1; next.push(w); }
        }
      }
      now = next;
    }
    return d;
  };
  const along = new Float32Array(vertices).fill(-1);
  for (let v = 0; v < vertices; ++v) {  // each component by itself
    if (along[v] >= 0 || count[v] === count[v + 1]) continue;
    let far = v;
    const first = distances_from(v);
    for (let w = 0; w < vertices; ++w) if (first[w] < Infinity && first[w] > first[far]) far = w;
    const d = distances_from(far);
    let most = 0;
    for (let w = 0; w < vertices; ++w) if (d[w] < Infinity && d[w] > most) most = d[w];
    for (let w = 0; w < vertices; ++w) if (d[w] < Infinity) along[w] = most > 0 ? d[w] / most : 0;
  }
  return along;
}

// The faces between tets that are kept and those that are not, or nothing: 4 * tet + face, in order.
export function shown_faces(kept, neighbours) {
  let count = 0;
  const each = visit => {
    for (let t = 0, face = 0; t < kept.length; ++t, face += 4) {
      if (kept[t] === 0) continue;
      for (let f = face; f < face + 4; ++f) {
        const other = neighbours[f];
        if (other < 0 || kept[other] === 0) visit(f);
      }
    }
  };
  each(() => { ++count; });
  const faces = new Int32Array(count);
  count = 0;
  each(f => { faces[count++] = f; });
  return faces;
}

// How many of the sorted numbers are at most x.
export function upper_bound(sorted, x) {
  let low = 0, high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= x) low = middle + 1;
    else high = middle;
  }
  return low;
}

// Where a plane across an axis cuts the mesh, for any place of it: tets whose centroid is beyond it are left out. What is
// computed once for an axis makes each place cost about as much as the faces that it shows.
export class Cutter {
  constructor(neighbours, centroids, axis) {
    const tets = neighbours.length / 4;
    this.neighbours = neighbours;
    this.key = new Float32Array(tets);
    for (let t = 0; t < tets; ++t) this.key[t] = centroids[3 * t + axis];
    let low = Infinity, high = -Infinity;
    for (const x of this.key) { low = Math.min(low, x); high = Math.max(high, x); }
    this.low = low;
    this.scale = high > low ? Cutter.SLABS / (high - low) : 0;
    // Boundary faces, those of the first tets along the axis first.
    let outer = 0;
    for (let f = 0; f < neighbours.length; ++f) if (neighbours[f] < 0) ++outer;
    const boundary = new Int32Array(outer);
    outer = 0;
    for (let f = 0; f < neighbours.length; ++f) if (neighbours[f] < 0) boundary[outer++] = f;
    boundary.sort((f, g) => this.key[f >> 2] - this.key[g >> 2] || f - g);
    this.boundary = boundary;
    this.boundary_keys = Float32Array.from(boundary, f => this.key[f >> 2]);
    // Inner faces, seen from the tet that comes first, in every slab that lies between its two tets.
    const slabs = Cutter.SLABS, first = new Int32Array(slabs + 1);
    const each = visit => {
      for (let f = 0; f < neighbours.length; ++f) {
        const other = neighbours[f];
        if (other < 0 || !(this.key[f >> 2] < this.key[other])) continue;
        for (let s = this.slab(this.key[f >> 2]), last = this.slab(this.key[other]); s <= last; ++s) visit(s, f);
      }
    };
    each(s => { ++first[s + 1]; });
    for (let s = 0; s < slabs; ++s) first[s + 1] += first[s];
    const at = first.slice(0, slabs);
    this.inner = new Int32Array(first[slabs]);
    each((s, f) => { this.inner[at[s]++] = f; });
    this.first = first;
  }
  static SLABS = 128;

  slab(x) { return Math.max(0, Math.min(Cutter.SLABS - 1, Math.floor((x - this.low) * this.scale))); }

  // How many of the boundary faces belong to kept tets.
  outside(limit) { return upper_bound(this.boundary_keys, limit); }

  // The faces between tets that are kept and those that are not.
  inside(limit) {
    const s = this.slab(limit), found = [];
    for (let i = this.first[s]; i < this.first[s + 1]; ++i) {
      const f = this.inner[i];
      if (this.key[f >> 2] <= limit && this.key[this.neighbours[f]] > limit) found.push(f);
    }
    return Int32Array.from(found);
  }
}

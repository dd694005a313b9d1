// What goes to the graphics card: corners that faces share once, faces that are turned away not at all, and while the picture
// moves a coarser mesh. (A software renderer takes a microsecond for a triangle, and turns a picture of 50,000 at once.)
import {BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshLambertMaterial} from "three";
import {upper_bound} from "./mesh.js";

const MANY = 40000;  // faces from which on there is a coarser mesh
export const GRID = 80;  // cells of it, in each direction

export class FaceMesh {
  constructor() {
    this.mesh = new Mesh(new BufferGeometry(), new MeshLambertMaterial({vertexColors: true, flatShading: true, side: DoubleSide,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1}));  // lines on faces stay visible
    this.mesh.frustumCulled = false;
    this.clear();
  }

  clear() {
    this.count = 0;  // faces to show, the first ones
    this.edge = 0;   // those from here on are beside the last ones: no coarser mesh there
    this.faces = new Int32Array(0);
    this.fine = this.coarse = null;
    this.drawn = new Int32Array(0);  // of each triangle that was drawn last, which of the faces it is
    this.mesh.geometry.setDrawRange(0, 0);
  }

  // faces: numbers; corners(face, out): its vertices; colour(face): a number in the palette of [red, green, blue];
  // closed: nobody sees a face from behind; shrunken(face, corner, out): a place of its own for each corner, or null.
  set({faces, corners, places, colour, palette, closed, shrunken}) {
    const n = faces.length, index = new Uint32Array(3 * n), own = new Int32Array(3);
    const P = new Float32Array(9 * n), kind = new Uint8Array(3 * n);
    // Of each vertex the corners of the drawing that it is, one for each colour: a chain.
    const head = shrunken ? null : new Int32Array(places.length / 3).fill(-1), next = shrunken ? null : new Int32Array(3 * n);
    let count = 0;
    for (let i = 0; i < n; ++i) {
      const c = colour(faces[i]);
      corners(faces[i], own);
      for (let k = 0; k < 3; ++k) {
        const v = own[k];
        let at = head ? head[v] : -1;
        while (at >= 0 && kind[at] !== c) at = next[at];
        if (at < 0) {
          at = count++;
          kind[at] = c;
          if (head) {
            next[at] = head[v];
            head[v] = at;
            for (let j = 0; j < 3; ++j) P[3 * at + j] = places[3 * v + j];
          } else {
            shrunken(faces[i], v, P, 3 * at);
          }
        }
        index[3 * i + k] = at;
      }
    }
    this.coarse = n > MANY ? coarse_of(P, count, index) : null;
    const means = this.coarse ? this.coarse.means : [];  // of cells: further corners, after the others
    const all = new Float32Array(3 * count + means.length), C = new Float32Array(3 * count + means.length);
    all.set(P.subarray(0, 3 * count));
    all.set(means, 3 * count);
    for (let i = 0; i < count; ++i) C.set(palette[kind[i]], 3 * i);
    for (let i = 0; i < means.length / 3; ++i) C.set(palette[kind[this.coarse.first[i]]], 3 * (count + i));
    this.faces = faces;
    this.count = this.edge = n;
    this.fine = {index, planes: closed ? planes_of(P, index) : null, from: null};
    if (this.coarse && closed) this.coarse.planes = planes_of(all, this.coarse.index);
    const drawn_coarse = this.coarse ? this.coarse.from.length : 0, geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(all, 3));
    geometry.setAttribute("color", new BufferAttribute(C, 3));
    geometry.setIndex(new BufferAttribute(new Uint32Array(3 * (n + drawn_coarse)), 1));
    this.mesh.geometry.dispose();
    this.mesh.geometry = geometry;
    this.drawn = new Int32Array(n + drawn_coarse);
  }

  // Chooses the triangles for the next picture.
  prepare(eye, moving) {
    if (!this.fine) return;
    let n = 0;
    if (moving && this.coarse) {
      n = this.add(this.coarse, 0, upper_bound(this.coarse.from, this.count - 1), eye, n);
      n = this.add(this.fine, this.edge, this.count, eye, n);
    } else {
      n = this.add(this.fine, 0, this.count, eye, n);
    }
    const buffer = this.mesh.geometry.index;
    buffer.clearUpdateRanges();
    buffer.addUpdateRange(0, 3 * n);
    buffer.needsUpdate = true;
    this.mesh.geometry.setDrawRange(0, 3 * n);
  }

  // Those of the triangles that face the eye; n: how many there are already.
  add({index, planes, from}, begin, end, {x, y, z}, n) {
    const out = this.mesh.geometry.index.array;
    for (let i = begin; i < end; ++i) {
      if (planes && planes[4 * i] * x + planes[4 * i + 1] * y + planes[4 * i + 2] * z < planes[4 * i + 3]) continue;
      out[3 * n] = index[3 * i]; out[3 * n + 1] = index[3 * i + 1]; out[3 * n + 2] = index[3 * i + 2];
      this.drawn[n++] = from ? from[i] : i;
    }
    return n;
  }

  face_of(triangle) { return this.faces[this.drawn[triangle]]; }
}

// Of each triangle its normal and how far along that it lies.
function planes_of(P, index) {
  const planes = new Float32Array(index.length / 3 * 4);
  for (let i = 0, at = 0; i < index.length; i += 3, at += 4) {
    const a = 3 * index[i], b = 3 * index[i + 1], c = 3 * index[i + 2];
    const ux = P[b] - P[a], uy = P[b + 1] - P[a + 1], uz = P[b + 2] - P[a + 2];
    const vx = P[c] - P[a], vy = P[c + 1] - P[a + 1], vz = P[c + 2] - P[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    planes[at] = x; planes[at + 1] = y; planes[at + 2] = z;
    planes[at + 3] = x * P[a] + y * P[a + 1] + z * P[a + 2];
  }
  return planes;
}

// All corners in one cell of a grid become one, in their middle (Rossignac and Borrel 1993). index counts these after the
// given ones; from: the face that a triangle was, in order; first: a corner of each cell.
function coarse_of(P, count, index) {
  const low = [Infinity, Infinity, Infinity];
  let size = 0;
  for (let i = 0; i < 3 * count; ++i) low[i % 3] = Math.min(low[i % 3], P[i]);
  for (let i = 0; i < 3 * count; ++i) size = Math.max(size, P[i] - low[i % 3]);
  const cells = new Int32Array(GRID ** 3).fill(-1), cell_of = new Uint32Array(count), scale = size > 0 ? .9999 * GRID / size : 0;
  const first = [], sums = [], members = [];
  for (let i = 0; i < count; ++i) {
    const x = Math.floor(scale * (P[3 * i] - low[0])), y = Math.floor(scale * (P[3 * i + 1] - low[1])), z = Math.floor(scale * (P[3 * i + 2] - low[2]));
    const at = (x * GRID + y) * GRID + z;
    let cell = cells[at];
    if (cell < 0) {
      cell = cells[at] = first.length;
      first.push(i);
      members.push(0);
      sums.push(0, 0, 0);
    }
    cell_of[i] = cell;
    ++members[cell];
    for (let k = 0; k < 3; ++k) sums[3 * cell + k] += P[3 * i + k];
  }
  const out = new Uint32Array(index.length), from = new Int32Array(index.length / 3);
  let n = 0;
  for (let i = 0; i < index.length; i += 3) {
    const a = cell_of[index[i]], b = cell_of[index[i + 1]], c = cell_of[index[i + 2]];
    if (a === b || b === c || c === a) continue;
    out[3 * n] = count + a; out[3 * n + 1] = count + b; out[3 * n + 2] = count + c;
    from[n++] = i / 3;
  }
  return {index: out.slice(0, 3 * n), from: from.slice(0, n), planes: null, first, means: sums.map((x, i) => x / members[Math.floor(i / 3)])};
}

// The page: a picture of a tet mesh or a surface, and what can be done with it.
import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, LineBasicMaterial, LineSegments, PerspectiveCamera, Points, PointsMaterial, Raycaster, Scene, Vector2, Vector3, WebGLRenderer,
} from "three";
import {OrbitControls} from "three/examples/jsm/controls/OrbitControls.js";
import {angle_colour, css, group_colour, INSIDE, layer_colour, PLAIN} from "./colours.js";
import {read_page} from "./data.js";
import {FaceMesh, GRID} from "./drawing.js";
import {along_of, angles_of, centroids_of, Cutter, FACES, neighbours_of, shown_faces} from "./mesh.js";

const data = read_page();
const {info, V, T, F} = data;
const is_tets = info.kind === "tets";
const tets = is_tets ? T.length / 4 : 0, triangles = F.length / 3, vertices = V.length / 3;
const element = id => document.getElementById(id);
const numbers = new Intl.NumberFormat("en");

// ---- the mesh

const neighbours = is_tets ? neighbours_of(T) : null;
const centroids = is_tets ? centroids_of(V, T) : null;
const angles = is_tets ? angles_of(V, T) : null;
let along = null;  // computed when it is first wanted

// Of each face of a tet that is on the boundary, the number of its triangle; else -1.
const triangle_of = is_tets ? boundary_numbers() : null;
function boundary_numbers() {
  const sorted = (a, b, c) => [a, b, c].sort((x, y) => x - y);
  const by_edge = new Map();  // the two smaller vertices (a number below 2^53): the largest one and the triangle, in turn
  for (let i = 0; i < triangles; ++i) {
    const [a, b, c] = sorted(F[3 * i], F[3 * i + 1], F[3 * i + 2]), key = a * vertices + b, list = by_edge.get(key);
    if (list) list.push(c, i);
    else by_edge.set(key, [c, i]);
  }
  const numbers = new Int32Array(4 * tets).fill(-1);
  for (let face = 0; face < 4 * tets; ++face) {
    if (neighbours[face] >= 0) continue;
    const f = FACES[face & 3], t = 4 * (face >> 2), [a, b, c] = sorted(T[t + f[0]], T[t + f[1]], T[t + f[2]]);
    const list = by_edge.get(a * vertices + b) ?? [];
    for (let i = 0; i < list.length; i += 2) if (list[i] === c) numbers[face] = list[i + 1];
  }
  return numbers;
}

let radius = 0;
for (let v = 0; v < vertices; ++v) radius = Math.max(radius, Math.hypot(V[3 * v], V[3 * v + 1], V[3 * v + 2]));
radius ||= 1;

// ---- what the user has chosen

const state = {colour: "", axis: 0, cut: 1, shrink: 0, apart: 0, worse: 180, lines: true};

const choices = [];
if (is_tets && data.layers && data.layers.some(n => n > 1)) choices.push(["layers", "layers: how often the solid is there"]);
if (data.labels) choices.push(["label", "labels of the boundary"]);
if (is_tets && data.regions) choices.push(["region", "regions"]);
if (is_tets) choices.push(["angle", "smallest dihedral angle"]);
choices.push(["plain", "one colour"]);
state.colour = choices[0][0];

function control(label, input) {
  const l = document.createElement("label");
  l.append(label, input);
  element("controls").append(l);
  return input;
}
function select(label, options, chosen) {
  const s = document.createElement("select");
  for (const [value, text] of options) s.add(new Option(text, value));
  s.addEventListener("change", () => chosen(s.value));
  return control(label, s);
}
function slider(id, label, low, high, step, value, moved) {
  const s = Object.assign(document.createElement("input"), {type: "range", id, min: low, max: high, step, value});
  s.addEventListener("input", () => moved(+s.value));
  return control(label, s);
}

element("title").textContent = info.title;
element("counts").textContent = is_tets
  ? `${numbers.format(vertices)} vertices, ${numbers.format(tets)} tets, ${numbers.format(triangles)} boundary triangles`
  : `${numbers.format(vertices)} vertices, ${numbers.format(triangles)} faces`;

select("Colours", choices, value => { state.colour = value; rebuild(); });
let cut_slider = null;
if (is_tets) {
  select("Cut across", [[0, "x"], [1, "y"], [2, "z"]], value => { state.axis = +value; rebuild(); });
  cut_slider = slider("cut", "Cutting plane", 0, 1, .002, 1, value => { state.cut = value; rebuild(); });
  slider("worse", "Only tets with an angle below", 0, 90, .5, 90, value => { state.worse = value >= 90 ? 180 : value; rebuild(); });
  slider("shrink", "Shrink tets", 0, .6, .02, 0, value => { state.shrink = value; rebuild(); });
}
slider("apart", "Pull layers apart", 0, 1, .01, 0, value => { state.apart = value; rebuild(); });
if (data.lines) {
  const box = Object.assign(document.createElement("input"), {type: "checkbox", id: "lines", checked: true});
  box.addEventListener("change", () => { state.lines = box.checked; rebuild(); });
  control("Where the surface crosses itself ", box);
}

// ---- the picture

const canvas = element("scene");
const renderer = new WebGLRenderer({canvas, antialias: false, preserveDrawingBuffer: true});  // smooth when it stands still
const scene = new Scene();
const dark = matchMedia("(prefers-color-scheme: dark)");
const set_background = () => { scene.background = new Color(dark.matches ? 0x11151a : 0xffffff); draw(); };
const camera = new PerspectiveCamera(35, 1, radius / 100, radius * 100);
camera.position.set(.9 * radius, .8 * radius, 3.4 * radius);
camera.up.set(0, 1, 0);
const head_light = new DirectionalLight(0xffffff, 2.2);
camera.add(head_light);
scene.add(camera, new AmbientLight(0xffffff, 1.1));
const controls = new OrbitControls(camera, canvas);
controls.addEventListener("change", () => draw());

const outside = new FaceMesh(), inside = new FaceMesh();  // of the boundary; what a cut shows, or tets chosen one by one
scene.add(outside.mesh, inside.mesh);
const picked_outline = new LineSegments(new BufferGeometry(), new LineBasicMaterial({color: 0xff0066, depthTest: false}));
picked_outline.renderOrder = 2;
scene.add(picked_outline);
// What is marked shines through faintly where it is hidden.
const RED = 0xd01040, marked = [];
function mark(Kind, Material, array, options) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(array, 3));
  for (const hidden of [false, true]) {
    const object = new Kind(geometry, new Material({color: RED, ...options, ...(hidden ? {depthTest: false, transparent: true, opacity: .35} : {})}));
    object.renderOrder = 1;
    marked.push(object);
    scene.add(object);
  }
}
if (data.lines) mark(LineSegments, LineBasicMaterial, data.lines, {});
if (data.marks) mark(Points, PointsMaterial, data.marks, {size: 7, sizeAttenuation: false});

// Where the layers go: along the axis in which the mesh is thinnest, by how far they are along the solid.
const extent = [0, 1, 2].map(k => {
  let low = Infinity, high = -Infinity;
  for (let v = k; v < V.length; v += 3) { low = Math.min(low, V[v]); high = Math.max(high, V[v]); }
  return [low, high];
});
const thin_axis = [0, 1, 2].reduce((a, b) => extent[b][1] - extent[b][0] < extent[a][1] - extent[a][0] ? b : a);
let places = V;
function update_places() {
  if (state.apart === 0) { places = V; return; }
  along ??= is_tets ? along_of(V, T, 4) : along_of(V, F, 3);
  places = V.slice();
  for (let v = 0; v < vertices; ++v) places[3 * v + thin_axis] += 3 * radius * state.apart * (along[v] - .5);
}

// Colours of faces, as numbers in a palette.
const palette = [PLAIN, INSIDE, ...[1, 2, 3, 4].map(layer_colour), ...[0, 1, 2, 3, 4, 5, 6, 7].map(group_colour),
  ...Array.from({length: 41}, (_, i) => angle_colour(i))];
const of_layers = n => 1 + Math.max(1, Math.min(4, n)), of_group = n => 6 + ((n % 8) + 8) % 8, of_angle = x => 14 + Math.round(Math.min(40, x));
function colour_of(face) {
  if (!is_tets) return state.colour === "label" ? of_group(data.labels[face]) : 0;
  const tet = face >> 2, triangle = triangle_of[face];
  switch (state.colour) {
    case "layers": return of_layers(data.layers[tet]);
    case "region": return of_group(data.regions[tet]);
    case "angle": return of_angle(angles.least[tet]);
    case "label": return triangle >= 0 ? of_group(data.labels[triangle]) : 1;
    default: return triangle >= 0 ? 0 : 1;
  }
}

const cut_limit = () => { const [low, high] = extent[state.axis]; return low + state.cut * (high - low) + 1e-6 * radius; };
function kept_tets() {
  const kept = new Uint8Array(tets), limit = cut_limit();
  for (let t = 0; t < tets; ++t) kept[t] = centroids[3 * t + state.axis] <= limit && angles.least[t] < state.worse ? 1 : 0;
  return kept;
}

function corners(face, out) {
  if (!is_tets) { for (let k = 0; k < 3; ++k) out[k] = F[3 * face + k]; return; }
  const f = FACES[face & 3], t = 4 * (face >> 2);
  for (let k = 0; k < 3; ++k) out[k] = T[t + f[k]];
}
function corners_of(face) {
  const out = [0, 0, 0];
  corners(face, out);
  return out;
}

// Of tets that are chosen one by one.
function faces_to_show() {
  const faces = shown_faces(kept_tets(), neighbours);
  if (state.shrink === 0) return faces;
  const own = new Set();  // shrunken tets show all their sides
  for (const face of faces) own.add(face >> 2);
  return Int32Array.from([...own].flatMap(t => [4 * t, 4 * t + 1, 4 * t + 2, 4 * t + 3]));
}

function shrunken(face, v, P, at) {
  const t = 4 * (face >> 2);
  for (let k = 0; k < 3; ++k) {
    const middle = (places[3 * T[t] + k] + places[3 * T[t + 1] + k] + places[3 * T[t + 2] + k] + places[3 * T[t + 3] + k]) / 4;
    P[at + k] = places[3 * v + k] + state.shrink * (middle - places[3 * v + k]);
  }
}

const cutters = [null, null, null];
let outside_is = "";  // the state of which the boundary's faces are
function rebuild() {
  update_places();
  // Pulled apart, faces may be turned over; surfaces need not be closed.
  const common = {corners, places, colour: colour_of, palette, closed: is_tets && state.apart === 0, shrunken: null};
  const one_by_one = is_tets && (state.shrink > 0 || state.worse < 180);
  if (one_by_one) {
    outside.clear();
    outside_is = "";
    inside.set({...common, faces: faces_to_show(), shrunken: state.shrink > 0 ? shrunken : null});
  } else {
    const cutter = is_tets ? cutters[state.axis] ??= new Cutter(neighbours, centroids, state.axis) : null;
    const now = `${state.colour} ${state.axis} ${state.apart}`;
    if (outside_is !== now) outside.set({...common, faces: cutter ? cutter.boundary : Int32Array.from({length: triangles}, (_, i) => i)});
    outside_is = now;
    if (cutter) {
      outside.count = cutter.outside(cut_limit());
      outside.edge = state.cut < 1 ? cutter.outside(cut_limit() - 4 * radius / GRID) : outside.count;
      inside.set({...common, faces: cutter.inside(cut_limit())});
    }
  }
  picked_outline.visible = false;
  for (const object of marked) object.visible = state.lines && state.apart === 0;
  legend();
  draw();
}

// While it moves quickly, and when it has stood still for a moment as it should be: each pixel is the mean of four.
let next_frame = 0, still_soon = 0;
function render(moving) {
  const ratio = moving ? Math.min(devicePixelRatio, outside.count + inside.count > 40000 ? 1 : 2) : 2;
  if (renderer.getPixelRatio() !== ratio) renderer.setPixelRatio(ratio);
  for (const part of [outside, inside]) part.prepare(camera.position, moving);
  renderer.render(scene, camera);
}
function draw() {
  clearTimeout(still_soon);
  still_soon = setTimeout(() => render(false), 250);
  if (next_frame === 0) next_frame = requestAnimationFrame(() => { next_frame = 0; render(true); });
}

function resize() {
  renderer.setSize(innerWidth, innerHeight, false);
  camera.aspect = innerWidth / innerHeight;
  // The panel covers the left; the picture's middle is in what is free.
  const panel = innerWidth > 700 ? element("panel").offsetWidth : 0;
  camera.setViewOffset(innerWidth, innerHeight, -panel / 2, 0, innerWidth, innerHeight);
  camera.updateProjectionMatrix();
  draw();
}

// ---- what colours mean

let legend_is = "";
function legend() {
  if (legend_is === state.colour) return;
  legend_is = state.colour;
  const list = element("legend"), entries = [];
  const named = (names, n, word) => names?.[n] ? `${names[n]} (${n})` : `${word} ${n}`;
  const distinct = values => [...new Set(values)].sort((a, b) => a - b).slice(0, 12);
  if (state.colour === "layers") for (const n of distinct(data.layers)) entries.push([layer_colour(n), n === 1 ? "1 layer" : `${n} layers`]);
  if (state.colour === "label") for (const n of distinct(data.labels)) entries.push([group_colour(n), named(info.label_names, n, "label")]);
  if (state.colour === "region") for (const n of distinct(data.regions)) entries.push([group_colour(n), named(info.region_names, n, "region")]);
  if (state.colour === "angle") for (const n of [0, 10, 20, 30, 40]) entries.push([angle_colour(n), `${n} degrees${n === 40 ? " and more" : ""}`]);
  list.replaceChildren(...entries.map(([colour, text]) => {
    const item = document.createElement("li"), box = document.createElement("i");
    box.style.background = css(colour);
    item.append(box, text);
    return item;
  }));
}

// ---- what is there

function describe(face) {
  const place = v => `(${[0, 1, 2].map(k => (V[3 * v + k] + info.middle[k]).toPrecision(6)).join(", ")})`;
  const own = corners_of(face);
  const lines = [];
  if (is_tets) {
    const tet = face >> 2, triangle = triangle_of[face];
    lines.push(`Tet ${tet}: vertices ${[0, 1, 2, 3].map(k => T[4 * tet + k]).join(", ")}`);
    lines.push(`smallest dihedral angle ${angles.least[tet].toPrecision(4)} degrees`);
    if (data.regions) lines.push(`region ${info.region_names?.[data.regions[tet]] ?? data.regions[tet]}`);
    if (data.layers) lines.push(`layers of the solid here: ${data.layers[tet]}`);
    if (triangle >= 0) {
      lines.push(`boundary triangle ${triangle}`);
      if (data.labels) lines.push(`label ${info.label_names?.[data.labels[triangle]] ?? data.labels[triangle]}`);
    }
  } else {
    lines.push(`Face ${face}: vertices ${own.join(", ")}`);
    if (data.labels) lines.push(`label ${info.label_names?.[data.labels[face]] ?? data.labels[face]}`);
  }
  lines.push(`near ${place(own[0])}`);
  return lines.join("\n");
}

function pick(face) {
  const own = is_tets ? [0, 1, 2, 3].map(k => T[4 * (face >> 2) + k]) : corners_of(face);
  const P = [];
  for (let i = 0; i < own.length; ++i)
    for (let j = i + 1; j < own.length; ++j)
      for (const v of [own[i], own[j]]) P.push(places[3 * v], places[3 * v + 1], places[3 * v + 2]);
  picked_outline.geometry.dispose();
  picked_outline.geometry = new BufferGeometry();
  picked_outline.geometry.setAttribute("position", new BufferAttribute(Float32Array.from(P), 3));
  picked_outline.visible = true;
  element("picked").textContent = describe(face);
  draw();
}

const raycaster = new Raycaster();
function pick_at(x, y) {
  const box = canvas.getBoundingClientRect();
  raycaster.setFromCamera(new Vector2(2 * (x - box.left) / box.width - 1, 1 - 2 * (y - box.top) / box.height), camera);
  for (const part of [outside, inside]) part.prepare(camera.position, false);
  const hit = raycaster.intersectObjects([outside.mesh, inside.mesh])[0];
  if (hit) pick((hit.object === outside.mesh ? outside : inside).face_of(hit.faceIndex));
}
let pressed = null;
canvas.addEventListener("pointerdown", e => { pressed = [e.clientX, e.clientY]; });
canvas.addEventListener("pointerup", e => {
  if (pressed && Math.hypot(e.clientX - pressed[0], e.clientY - pressed[1]) < 4) pick_at(e.clientX, e.clientY);
});

canvas.addEventListener("keydown", e => {
  const turn = (dx, dy) => {
    const offset = camera.position.clone().sub(controls.target);
    offset.applyAxisAngle(new Vector3(0, 1, 0), dx);
    const side = new Vector3().crossVectors(camera.up, offset).normalize(), tilted = offset.clone().applyAxisAngle(side, dy);
    if (Math.abs(tilted.clone().normalize().y) < .999) offset.copy(tilted);
    camera.position.copy(controls.target).add(offset);
  };
  const zoom = factor => camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
  const step = {ArrowLeft: () => turn(-.1, 0), ArrowRight: () => turn(.1, 0), ArrowUp: () => turn(0, -.1), ArrowDown: () => turn(0, .1),
    "+": () => zoom(.9), "=": () => zoom(.9), "-": () => zoom(1.1), ",": () => move_cut(-.02), ".": () => move_cut(.02)}[e.key];
  if (!step) return;
  e.preventDefault();
  step();
  controls.update();
  draw();
});
function move_cut(by) {
  if (!cut_slider) return;
  cut_slider.value = Math.max(0, Math.min(1, state.cut + by));
  state.cut = +cut_slider.value;
  rebuild();
}

if (is_tets) {
  element("quality").hidden = false;
  const most = Math.max(1, ...angles.histogram);
  element("histogram").setAttribute("viewBox", "0 0 180 70");
  element("histogram").innerHTML = [...angles.histogram].map((n, i) =>
    `<rect x="${5 * i + .3}" y="${58 - 56 * n / most}" width="4.4" height="${56 * n / most}"><title>${5 * i} to ${5 * i + 5} degrees: ${n}</title></rect>`).join("") +
    [0, 60, 120, 180].map(x => `<text x="${x}" y="68" text-anchor="${x === 0 ? "start" : x === 180 ? "end" : "middle"}">${x}</text>`).join("");
  // The worst ones, without sorting a million.
  const worst = [];
  for (let t = 0; t < tets; ++t) {
    if (worst.length === 6 && angles.least[t] >= angles.least[worst[5]]) continue;
    worst.push(t);
    worst.sort((a, b) => angles.least[a] - angles.least[b]);
    if (worst.length > 6) worst.pop();
  }
  element("worst").append("Worst: ", ...worst.map(t => {
    const button = Object.assign(document.createElement("button"), {textContent: `${angles.least[t].toPrecision(3)}°`, title: `tet ${t}`});
    button.addEventListener("click", () => pick(4 * t));
    return button;
  }));
}

addEventListener("resize", resize);
dark.addEventListener("change", set_background);
set_background();
resize();
rebuild();
// For tests, and for whoever wants to script the page.
window.overtet = {state, pick, pick_at, rebuild, shown: () => outside.count + inside.count,
  frame: (moving = false) => {  // now, and none after it; reading a pixel waits for the picture
    cancelAnimationFrame(next_frame);
    clearTimeout(still_soon);
    next_frame = 0;
    render(moving);
    const gl = renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }};
document.documentElement.dataset.ready = "yes";

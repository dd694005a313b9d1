// What the page shows, read from the blocks that the program has put into it: base64 of little-endian arrays.

function bytes_of(id) {
  const element = document.getElementById(id);
  if (!element) return null;
  const text = atob(element.textContent.trim());
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  element.textContent = "";  // the text is no longer needed
  return bytes.buffer;
}

// null: there is no such block, as it would be empty.
const array_of = (id, Type) => {
  const buffer = bytes_of(id);
  return buffer ? new Type(buffer) : null;
};

// info: {kind: "surface" | "tets", title, names of labels and regions, ...} as src/view writes it.
export function read_page() {
  return {
    info: JSON.parse(document.getElementById("info").textContent),
    V: array_of("V", Float32Array) ?? new Float32Array(0),  // 3 numbers a vertex, about the middle of the bounding box
    T: array_of("T", Int32Array) ?? new Int32Array(0),      // 4 a tet
    F: array_of("F", Int32Array) ?? new Int32Array(0),      // 3 a boundary triangle, or a face of the surface
    labels: array_of("labels", Int32Array),      // a triangle
    regions: array_of("regions", Int32Array),    // a tet
    layers: array_of("layers", Int32Array),      // a tet
    lines: array_of("lines", Float32Array),      // 6 a segment: the curves in which the surface crosses itself
    marks: array_of("marks", Float32Array),      // 3 a marked place: hinges, witnesses
  };
}

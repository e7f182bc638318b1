// The shaders fetch what they draw from tables (table.ts): no attribute is uploaded for a mesh.
import { STAMP_BITS, STAMP_MASK, STAMPS_PER_SECOND } from './stamps.js';
import { LINE } from './table.js';

const common = `
precision highp float;
precision highp int;
precision highp usampler2D;
uniform usampler2D vertices; // two texels a vertex: higher halves and kind, lower halves
uniform vec3 cameraHi;
uniform vec3 cameraLo;
uniform mat4 project;
uniform vec2 size; // of the picture, in pixels
uniform uint now;

ivec2 at(uint row) { return ivec2(int(row % ${LINE}u), int(row / ${LINE}u)); }

uvec4 upperTexel(uint vertex) { return texelFetch(vertices, at(2u * vertex), 0); }

// Relative to the camera: exact for what is near it.
vec3 relative(uint vertex) {
  vec3 hi = uintBitsToFloat(upperTexel(vertex).xyz);
  vec3 lo = uintBitsToFloat(texelFetch(vertices, at(2u * vertex + 1u), 0).xyz);
  return (hi - cameraHi) + (lo - cameraLo);
}

// 1 for what has just changed, 0 after some seconds.
uniform float fadeSeconds;
float freshness(uint stamp) {
  if (stamp == 0u) return 0.0;
  uint age = (now - stamp) & ${STAMP_MASK}u;
  return clamp(1.0 - float(age) / (${STAMPS_PER_SECOND}.0 * fadeSeconds), 0.0, 1.0);
}
// What is above the plane is not drawn; without a plane the normal is 0.
uniform vec3 clipNormal;
uniform float clipOffset; // from the camera
out float above;
float aboveClip(vec3 position) { return dot(position, clipNormal) - clipOffset; }
const vec4 NOWHERE = vec4(2.0, 2.0, 2.0, 1.0);
`;

const colours = `
uniform int fill;
uniform vec3 plain;
uniform vec3 ramp[9];
uniform vec3 regions[8];
uniform vec2 range; // of the figure that is the colour

vec3 rampAt(float value) {
  float place = clamp(value, 0.0, 1.0) * 8.0;
  int index = min(int(place), 7);
  return mix(ramp[index], ramp[index + 1], place - float(index));
}
`;

export const triangles = {
  vertexShader: `${common}
uniform usampler2D rows;
${colours}uniform vec3 glow;
uniform bool solid;
uniform vec3 eye; // direction to it
uniform vec3 hoverColour;
uniform uint hovered; // row + 1
flat out vec3 colour;
out vec3 corner;

// Of a triangle with these edges, from its corners a, b and c in turn.
float figure(vec3 ab, vec3 bc, vec3 ca) {
  float l = length(bc), m = length(ca), n = length(ab);
  float shortest = min(l, min(m, n));
  float doubleArea = length(cross(ab, ca));
  if (fill == 1) return l * m * n / (2.0 * doubleArea * shortest);
  if (fill == 2) {
    vec3 cosines = vec3(-dot(ab, ca) / (m * n), -dot(ab, bc) / (l * n), -dot(bc, ca) / (l * m));
    return degrees(acos(clamp(max(cosines.x, max(cosines.y, cosines.z)), -1.0, 1.0)));
  }
  return log2(max(l, max(m, n)));
}

void main() {
  uint row = uint(gl_VertexID) / 3u;
  int which = gl_VertexID % 3;
  uvec4 texel = texelFetch(rows, at(row), 0);
  if (texel.x == 0u) {
    gl_Position = NOWHERE;
    return;
  }
  vec3 a = relative(texel.x - 1u), b = relative(texel.y - 1u), c = relative(texel.z - 1u);
  vec3 own = which == 0 ? a : which == 1 ? b : c;
  gl_Position = project * vec4(own, 1.0);
  above = aboveClip(own);
  corner = vec3(which == 0, which == 1, which == 2);
  uint region = texel.w >> ${STAMP_BITS}u;
  vec3 base = plain;
  if (fill == 4) {
    if (region != 0u) base = regions[(region - 1u) % 8u];
  } else if (fill != 0) {
    base = rampAt((figure(b - a, c - b, a - c) - range.x) / (range.y - range.x));
  }
  if (solid) {
    // A light at the eye.
    base *= 0.55 + 0.45 * abs(dot(normalize(cross(b - a, c - a)), eye));
  }
  colour = mix(base, glow, freshness(texel.w & ${STAMP_MASK}u));
  if (row + 1u == hovered) colour = mix(colour, hoverColour, 0.5);
}`,
  fragmentShader: `
precision highp float;
uniform vec3 line;
uniform bool edges;
flat in vec3 colour;
in vec3 corner;
in float above;
out vec4 pixel;
void main() {
  if (above > 0.0) discard;
  float edge = 0.0;
  if (edges) {
    vec3 step = fwidth(corner);
    vec3 distances = corner / step;
    float distance = min(distances.x, min(distances.y, distances.z));
    // Lines of triangles that are as small as the lines would hide the colours.
    float height = 1.0 / max(step.x, max(step.y, step.z));
    edge = (1.0 - smoothstep(0.2, 1.0, distance)) * smoothstep(3.0, 10.0, height);
  }
  pixel = vec4(mix(colour, line, edge), 1.0);
}`,
};

export const segments = {
  vertexShader: `${common}
uniform usampler2D rows;
uniform vec3 segment;
uniform vec3 border;
uniform vec3 glow;
uniform float width; // in pixels
flat out vec3 colour;
void main() {
  uint row = uint(gl_VertexID) / 6u;
  int which = gl_VertexID % 6;
  uvec4 texel = texelFetch(rows, at(row), 0);
  if (texel.x == 0u) {
    gl_Position = NOWHERE;
    return;
  }
  vec3 from = relative(texel.x - 1u), to = relative(texel.y - 1u);
  vec4 p = project * vec4(from, 1.0);
  vec4 q = project * vec4(to, 1.0);
  // Two triangles along the segment, of a width in pixels.
  bool atEnd = which == 1 || which == 2 || which == 4;
  float side = which == 0 || which == 1 || which == 3 ? 1.0 : -1.0;
  vec2 along = (q.xy / q.w - p.xy / p.w) * size;
  vec2 across = length(along) > 0.0 ? normalize(vec2(-along.y, along.x)) : vec2(0.0);
  vec4 end = atEnd ? q : p;
  above = aboveClip(atEnd ? to : from);
  end.xy += across * side * width / size * end.w;
  end.z -= 1e-5 * end.w;
  gl_Position = end;
  vec3 base = texel.z == 0u ? segment : border;
  colour = mix(base, glow, freshness(texel.w));
}`,
  fragmentShader: `
precision highp float;
flat in vec3 colour;
in float above;
out vec4 pixel;
void main() {
  if (above > 0.0) discard;
  pixel = vec4(colour, 1.0);
}`,
};

/** Counts the input points in each cell of the picture, in 255ths. */
export const density = {
  vertexShader: `${common}
uniform float cell; // in pixels
uniform vec2 cells;
void main() {
  uint vertex = uint(gl_VertexID);
  gl_PointSize = 1.0;
  gl_Position = NOWHERE;
  if (upperTexel(vertex).w != 1u) return;
  vec3 own = relative(vertex);
  above = aboveClip(own);
  vec4 position = project * vec4(own, 1.0);
  if (position.w <= 0.0) return;
  vec2 pixel = (0.5 * position.xy / position.w + 0.5) * size;
  gl_Position = vec4(2.0 * pixel / cell / cells - 1.0, 0.0, 1.0);
}`,
  fragmentShader: `
precision highp float;
in float above;
out vec4 count;
void main() {
  if (above > 0.0) discard;
  count = vec4(1.0 / 255.0);
}`,
};

/** Input points: dots that are smaller where points are dense, and none where they would be a blot. */
export const points = {
  vertexShader: `${common}
uniform vec3 point;
uniform float width;
uniform float cell;
uniform vec2 cells;
uniform sampler2D density;
flat out vec3 colour;

float countIn(ivec2 place) {
  ivec2 inside = clamp(place, ivec2(0), ivec2(cells) - 1);
  return 255.0 * texelFetch(density, inside, 0).x;
}

void main() {
  uint vertex = uint(gl_VertexID);
  gl_PointSize = width;
  colour = point;
  if (upperTexel(vertex).w != 1u) {
    gl_Position = NOWHERE;
    return;
  }
  vec3 own = relative(vertex);
  gl_Position = project * vec4(own, 1.0);
  above = aboveClip(own);
  gl_Position.z -= 2e-5 * gl_Position.w;
  // The four cells about the point; of points on a line, this is the distance from one to the next.
  vec2 pixel = (0.5 * gl_Position.xy / gl_Position.w + 0.5) * size;
  ivec2 low = ivec2(floor(pixel / cell - 0.5));
  float count = countIn(low) + countIn(low + ivec2(1, 0)) + countIn(low + ivec2(0, 1)) +
    countIn(low + 1);
  float distance = 2.0 * cell / max(count, 1.0);
  gl_PointSize = min(width, distance);
  if (distance < width / 3.0) gl_Position = NOWHERE;
}`,
  fragmentShader: `
precision highp float;
flat in vec3 colour;
in float above;
out vec4 pixel;
void main() {
  if (above > 0.0 || length(gl_PointCoord - 0.5) > 0.5) discard;
  pixel = vec4(colour, 1.0);
}`,
};

/** Of a cut through tetrahedra (cut/cutter.ts), whose triangles are attributes. */
export const cut = {
  vertexShader: `${common}${colours}
in vec3 position;
in vec4 figures;
in vec3 edges;
flat out vec3 colour;
out vec3 corner;
void main() {
  gl_Position = project * vec4((position - cameraHi) - cameraLo, 1.0);
  above = 0.0;
  corner = edges;
  colour = plain * 0.92;
  int region = int(figures.w);
  if (fill == 4) {
    if (region != 0) colour = regions[(region - 1) % 8];
  } else if (fill != 0) {
    float figure = fill == 1 ? figures.x : fill == 2 ? figures.y : figures.z;
    colour = rampAt((figure - range.x) / (range.y - range.x));
  }
}`,
  fragmentShader: triangles.fragmentShader,
};

// The picture of a mesh: tables of its vertices and of what is drawn (triangles, in 3D subfacets;
// subsegments), and the passes over them. An update uploads what has changed and nothing else.
import {
  AddEquation,
  BufferAttribute,
  BufferGeometry,
  Camera,
  CustomBlending,
  DoubleSide,
  GLSL3,
  Matrix4,
  Mesh,
  NearestFilter,
  NoBlending,
  OneFactor,
  Points,
  RawShaderMaterial,
  Scene,
  Vector2,
  Vector3,
  WebGLRenderer,
  WebGLRenderTarget,
  type IUniform,
} from 'three';
import type { CutTriangles } from '../cut/cutter.js';
import type { Rows } from '../model/rows.js';
import type { SlotMesh } from '../model/slot_mesh.js';
import { halves } from './camera.js';
import { ramps, regionColours, type Colour, type Theme } from './palette.js';
import * as shaders from './shaders.js';
import { eraOf, STAMP_BITS, STAMP_MASK, stampBits } from './stamps.js';
import { LINE, Table, TableWriter } from './table.js';

export const fills = ['change', 'quality', 'angle', 'size', 'region'] as const;
export type Fill = (typeof fills)[number];

/** What to draw, and how. */
export interface Look {
  fill: Fill;
  theme: Theme;
  ramp: keyof typeof ramps;
  /** Of the figure that is the colour. */
  range: readonly [number, number];
  edges: boolean;
  segments: boolean;
  points: boolean;
  fadeSeconds: number;
}

/** From where; positions are relative to the origin. */
export interface Eye {
  /** What positions are relative to in shaders, from the origin. */
  position: readonly [number, number, number];
  /** From there to clip space. */
  project: Matrix4;
  /** Direction to the eye, for light. */
  direction: Vector3;
  /** What is above this plane is left out; from the origin. */
  clip: { axis: number; offset: number } | undefined;
}

/** The number of a region's colour: 0 for none. A function of its id, so that links show the same. */
export function regionNumber(lo: number, hi: number): number {
  return lo === 0 && hi === 0 ? 0 : 1 + (((lo ^ hi) >>> 0) % regionColours.length);
}

function isBorder(lo: number, hi: number): boolean {
  return lo === 0xffffffff && hi === 0xffffffff;
}

/** Pixels of a dot, and of the sides of the cells in which points are counted. */
const DOT = 3;
const CELL = 4;

type Uniforms = Record<string, IUniform>;

/** A table of rows of a kind, and the object that draws them. */
class Layer {
  table = new Table(1);
  /** The table has to be filled again. */
  #isNew = true;
  #count = 0;

  constructor(
    readonly object:
      | Mesh<BufferGeometry, RawShaderMaterial>
      | Points<BufferGeometry, RawShaderMaterial>,
    private readonly verticesARow: number,
  ) {
    object.frustumCulled = false;
    this.setCount(0);
  }

  /** Of another mesh, whose rows will all be written. */
  reset(isSpace: boolean): void {
    this.table.dispose();
    this.table = new Table(1);
    this.#isNew = true;
    this.setCount(0);
    const { material } = this.object;
    material.depthTest = material.depthWrite = isSpace;
  }

  setCount(rows: number): void {
    this.#count = rows;
    this.object.geometry.setDrawRange(0, rows * this.verticesARow);
  }

  /** All rows will be written again. */
  renew(): void {
    this.#isNew = true;
  }

  /** Makes the table as long as the rows; true if all of them have to be written. */
  prepare(rows: Rows, most: number): boolean {
    this.setCount(rows.length);
    const spare = Math.min(rows.corners.length / rows.width, most);
    const all = this.table.reserve(spare, most) || this.#isNew;
    this.#isNew = false;
    return all;
  }

  show(isWanted: boolean): void {
    this.object.visible = isWanted && this.#count > 0; // a table without a row has no texture yet
    this.object.material.uniforms.rows.value = this.table.texture;
  }
}

function shaderMaterial(
  shader: { vertexShader: string; fragmentShader: string },
  uniforms: Uniforms,
): RawShaderMaterial {
  return new RawShaderMaterial({
    ...shader,
    glslVersion: GLSL3,
    uniforms: { ...uniforms, rows: { value: null } },
    blending: NoBlending,
    side: DoubleSide,
  });
}

/** Adds up the points of each cell. */
function counterOf(geometry: BufferGeometry, uniforms: Uniforms): Points {
  const material = shaderMaterial(shaders.density, uniforms);
  material.setValues({
    blending: CustomBlending,
    blendEquation: AddEquation,
    blendSrc: OneFactor,
    blendDst: OneFactor,
    depthTest: false,
    depthWrite: false,
  });
  const result = new Points(geometry, material);
  result.frustumCulled = false;
  return result;
}

export class Picture {
  readonly renderer: WebGLRenderer;
  readonly writer: TableWriter;

  readonly #scene = new Scene();
  readonly #camera = new Camera();
  readonly #uniforms: Uniforms = {
    vertices: { value: null },
    cameraHi: { value: new Vector3() },
    cameraLo: { value: new Vector3() },
    project: { value: new Matrix4() },
    size: { value: new Vector2(1, 1) },
    now: { value: 0 },
    fadeSeconds: { value: 1 },
    fill: { value: 0 },
    plain: { value: [0, 0, 0] },
    line: { value: [0, 0, 0] },
    glow: { value: [0, 0, 0] },
    segment: { value: [0, 0, 0] },
    border: { value: [0, 0, 0] },
    point: { value: [0, 0, 0] },
    hoverColour: { value: [0, 0, 0] },
    hovered: { value: 0 },
    ramp: { value: [] },
    regions: { value: regionColours.flat() },
    range: { value: [0, 1] },
    edges: { value: true },
    solid: { value: false },
    clipNormal: { value: new Vector3() },
    clipOffset: { value: 0 },
    eye: { value: new Vector3(0, 0, 1) },
    density: { value: null },
    cell: { value: 1 },
    cells: { value: new Vector2(1, 1) },
  };
  #vertices = new Table(1);
  readonly #triangles: Layer;
  readonly #segments: Layer;
  readonly #points: Layer;
  readonly #density = new WebGLRenderTarget(1, 1, {
    minFilter: NearestFilter,
    magFilter: NearestFilter,
    depthBuffer: false,
    generateMipmaps: false,
  });
  readonly #densityScene = new Scene();
  readonly #cut: Mesh<BufferGeometry, RawShaderMaterial>;
  #mesh: SlotMesh | undefined;
  #origin: readonly number[] = [0, 0, 0];
  #verticesAreNew = true;
  /** Rows that a table can have. */
  readonly #most: number;
  /** Of the stamps in the tables. */
  #era = 0;

  constructor(canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: false, powerPreference: 'default' });
    this.renderer.autoClear = false;
    this.#most = LINE * this.renderer.capabilities.maxTextureSize;
    this.writer = new TableWriter(this.renderer);
    const mesh = (shader: typeof shaders.triangles, uniforms: Uniforms): Layer['object'] =>
      new Mesh(new BufferGeometry(), shaderMaterial(shader, uniforms));
    const ofWidth = (pixels: number): Uniforms => ({
      ...this.#uniforms,
      width: { value: pixels * devicePixelRatio },
    });
    this.#triangles = new Layer(mesh(shaders.triangles, this.#uniforms), 3);
    this.#segments = new Layer(mesh(shaders.segments, ofWidth(2)), 6);
    const points = new Points(new BufferGeometry(), shaderMaterial(shaders.points, ofWidth(DOT)));
    this.#points = new Layer(points, 1);
    this.#uniforms.density.value = this.#density.texture;
    this.#densityScene.add(counterOf(points.geometry, this.#uniforms));
    [this.#triangles, this.#segments, this.#points].forEach(({ object }, order) => {
      object.renderOrder = order;
      this.#scene.add(object);
    });
    this.#cut = new Mesh(new BufferGeometry(), shaderMaterial(shaders.cut, this.#uniforms));
    this.#cut.frustumCulled = this.#cut.visible = false;
    this.#scene.add(this.#cut);
    this.#warmUp();
  }

  /** Shows the cut of a 3D mesh by a plane. */
  setCut(triangles: CutTriangles | undefined): void {
    const { geometry } = this.#cut;
    geometry.dispose();
    this.#cut.visible = triangles !== undefined && triangles.positions.length > 0;
    if (triangles === undefined) return;
    geometry.setAttribute('position', new BufferAttribute(triangles.positions, 3));
    geometry.setAttribute('figures', new BufferAttribute(triangles.figures, 4));
    geometry.setAttribute('edges', new BufferAttribute(triangles.edges, 3));
    geometry.setDrawRange(0, triangles.positions.length / 3);
  }

  resize(width: number, height: number, ratio: number): void {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    const size = this.#uniforms.size.value as Vector2;
    this.renderer.getDrawingBufferSize(size);
    const cell = CELL * ratio;
    this.#uniforms.cell.value = cell;
    const cells = this.#uniforms.cells.value as Vector2;
    cells.copy(size).divideScalar(cell).ceil();
    this.#density.setSize(cells.x, cells.y);
  }

  /** The graphics card is away: what it had is not there any more, and must not be deleted later. */
  lost(): void {
    this.setMesh(undefined, this.#origin);
    this.#density.dispose();
  }

  /** Shows another mesh, with positions relative to the origin. */
  setMesh(mesh: SlotMesh | undefined, origin: readonly number[]): void {
    const isSpace = mesh?.dimension === 3;
    for (const layer of this.#layers()) layer.reset(isSpace);
    this.#vertices.dispose();
    this.#vertices = new Table(1);
    this.#verticesAreNew = true;
    this.#mesh = mesh;
    this.#origin = origin;
    this.#uniforms.solid.value = isSpace;
    this.setCut(undefined);
  }

  /** The graphics card is away, and what it had. */
  get isLost(): boolean {
    return this.renderer.getContext().isContextLost();
  }

  /** Stamps in the tables are so old that they have to be written again. */
  isOld(now: number): boolean {
    return this.#mesh !== undefined && eraOf(now) !== this.#era;
  }

  /** Uploads what has changed in the mesh; false if it has more rows than a table can have. */
  update(now: number): boolean {
    const mesh = this.#mesh;
    if (mesh === undefined) return true;
    const { vertices, subsegments } = mesh;
    const surface = mesh.dimension === 2 ? mesh.cells : mesh.subfacets;
    if (Math.max(2 * vertices.length, surface.length, subsegments.length) > this.#most) {
      this.#hide();
      mesh.settle();
      return false;
    }
    if (this.isOld(now)) for (const layer of this.#layers()) layer.renew();
    this.#era = eraOf(now);
    this.#updateVertices(mesh);
    this.#updateLayer(this.#triangles, surface, (row) => this.#writeTriangle(surface, row, now));
    this.#updateLayer(this.#segments, subsegments, (row) => {
      this.#writeSegment(subsegments, row, now);
    });
    mesh.settle();
    return true;
  }

  /** Draws nothing of the mesh. Its rows do not become fewer. */
  #hide(): void {
    for (const layer of this.#layers()) {
      layer.setCount(0);
      layer.renew();
    }
    this.#verticesAreNew = true;
  }

  draw(eye: Eye, look: Look, now: number, hovered: number): void {
    const uniforms = this.#uniforms;
    const hi = uniforms.cameraHi.value as Vector3;
    const lo = uniforms.cameraLo.value as Vector3;
    const [x, y, z] = eye.position.map(halves);
    hi.set(x[0], y[0], z[0]);
    lo.set(x[1], y[1], z[1]);
    (uniforms.project.value as Matrix4).copy(eye.project);
    (uniforms.eye.value as Vector3).copy(eye.direction);
    this.#setClip(eye);
    uniforms.now.value = now & STAMP_MASK;
    uniforms.fadeSeconds.value = look.fadeSeconds;
    uniforms.fill.value = fills.indexOf(look.fill);
    const { theme } = look;
    uniforms.plain.value = theme.plain;
    uniforms.line.value = theme.line;
    uniforms.glow.value = theme.glow;
    uniforms.segment.value = theme.segment;
    uniforms.border.value = theme.border;
    uniforms.point.value = theme.point;
    uniforms.hoverColour.value = theme.hover;
    uniforms.hovered.value = hovered + 1;
    uniforms.ramp.value = ramps[look.ramp].flat();
    uniforms.range.value = look.range;
    uniforms.edges.value = look.edges;
    this.#triangles.show(true);
    this.#segments.show(look.segments);
    this.#points.show(look.points);
    if (this.#points.object.visible) this.#countPoints();
    // In sRGB as they are: the renderer would take a Color for a linear one.
    this.#clearTo(theme.background);
    this.renderer.render(this.#scene, this.#camera);
  }

  /** Leaves out the side of the plane that the eye is on, so that the cut is seen. */
  #setClip({ clip, direction, position }: Eye): void {
    const normal = this.#uniforms.clipNormal.value as Vector3;
    normal.set(0, 0, 0);
    this.#uniforms.clipOffset.value = 0;
    if (clip === undefined) return;
    const sign = direction.getComponent(clip.axis) < 0 ? -1 : 1;
    normal.setComponent(clip.axis, sign);
    this.#uniforms.clipOffset.value = sign * (clip.offset - position[clip.axis]);
  }

  #countPoints(): void {
    const gl = this.renderer.getContext();
    this.renderer.setRenderTarget(this.#density);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    this.renderer.render(this.#densityScene, this.#camera);
  }

  #clearTo(colour: Colour): void {
    const gl = this.renderer.getContext();
    this.renderer.setRenderTarget(null);
    gl.clearColor(colour[0], colour[1], colour[2], 1);
    this.renderer.state.buffers.depth.setMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  #updateVertices(mesh: SlotMesh): void {
    const { vertices } = mesh;
    const spare = Math.min(2 * vertices.isLive.length, this.#most);
    const moved = this.#vertices.reserve(spare, this.#most);
    this.#uniforms.vertices.value = this.#vertices.texture;
    this.#points.setCount(vertices.length);
    this.writer.begin(this.#vertices);
    if (moved || this.#verticesAreNew) {
      for (let slot = 0; slot < vertices.length; ++slot) this.#writeVertex(mesh, slot);
    } else {
      for (const slot of vertices.changed) this.#writeVertex(mesh, slot);
    }
    this.writer.end();
    this.#verticesAreNew = false;
  }

  #updateLayer(layer: Layer, rows: Rows, write: (row: number) => void): void {
    const all = layer.prepare(rows, this.#most);
    this.writer.begin(layer.table);
    if (all) for (let row = 0; row < rows.length; ++row) write(row);
    else for (const row of rows.changed) write(row);
    this.writer.end();
  }

  #writeVertex(mesh: SlotMesh, slot: number): void {
    const { vertices, dimension } = mesh;
    for (let k = 0; k < dimension; ++k) {
      const value = vertices.coordinates[slot * dimension + k] - this.#origin[k];
      position[k] = value;
      position[4 + k] = value - position[k];
    }
    for (let k = dimension; k < 3; ++k) position[k] = position[4 + k] = 0;
    const { owners } = vertices;
    const isInput =
      vertices.isLive[slot] !== 0 &&
      vertices.containingDimensions[slot] === 0 &&
      !isBorder(owners[2 * slot], owners[2 * slot + 1]);
    const [x, y, z] = [positionBits[0], positionBits[1], positionBits[2]];
    this.writer.write(2 * slot, x, y, z, isInput ? 1 : 0);
    const [p, q, r] = [positionBits[4], positionBits[5], positionBits[6]];
    this.writer.write(2 * slot + 1, p, q, r, 0);
  }

  #writeTriangle(rows: Rows, row: number, now: number): void {
    const { corners, tags, stamps } = rows;
    // In 3D the facets of the border would hide everything in them.
    const isHidden = rows.width === 3 && isBorder(tags[2 * row], tags[2 * row + 1]);
    if (!rows.isLive(row) || isHidden) {
      this.writer.write(row, 0, 0, 0, 0);
      return;
    }
    const region = regionNumber(tags[2 * row], tags[2 * row + 1]);
    this.writer.write(
      row,
      corners[3 * row] + 1,
      corners[3 * row + 1] + 1,
      corners[3 * row + 2] + 1,
      (region << STAMP_BITS) | stampBits(stamps[row], now),
    );
  }

  #writeSegment(rows: Rows, row: number, now: number): void {
    const { corners, tags, stamps } = rows;
    if (!rows.isLive(row)) {
      this.writer.write(row, 0, 0, 0, 0);
      return;
    }
    this.writer.write(
      row,
      corners[2 * row] + 1,
      corners[2 * row + 1] + 1,
      isBorder(tags[2 * row], tags[2 * row + 1]) ? 1 : 0,
      stampBits(stamps[row], now),
    );
  }

  #layers(): Layer[] {
    return [this.#triangles, this.#segments, this.#points];
  }

  /** Draws a row of zeros of each kind, which is nothing: shaders are ready when a mesh comes. */
  #warmUp(): void {
    this.#uniforms.ramp.value = ramps.cividis.flat();
    this.#uniforms.vertices.value = this.#vertices.texture;
    for (const layer of this.#layers()) {
      this.writer.begin(layer.table);
      this.writer.write(0, 0, 0, 0, 0);
      this.writer.end();
      layer.setCount(1);
      layer.show(true);
    }
    this.writer.begin(this.#vertices);
    this.writer.write(0, 0, 0, 0, 0);
    this.writer.end();
    this.#countPoints();
    this.renderer.setRenderTarget(null);
    this.renderer.render(this.#scene, this.#camera);
    this.setMesh(undefined, this.#origin);
  }
}

/** Higher halves at 0, lower ones at 4. */
const position = new Float32Array(8);
const positionBits = new Uint32Array(position.buffer);

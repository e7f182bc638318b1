// A table of texels that shaders read by row: RGBA32UI, four words a texel. Rows change all over it, so
// what is uploaded is a list of rows, which a pass of points writes to their texels. That takes 20
// bytes a row and one call for a diff, however scattered its rows are.
import {
  BufferAttribute,
  BufferGeometry,
  Camera,
  GLSL3,
  NearestFilter,
  NoBlending,
  Points,
  RawShaderMaterial,
  RGBAIntegerFormat,
  Scene,
  UnsignedIntType,
  WebGLRenderTarget,
  type Texture,
  type WebGLRenderer,
} from 'three';

/** Texels a line, also in the shaders. */
export const LINE = 2048;
/** Rows that one pass writes. */
const BATCH = 1 << 15;

const vertexShader = `
precision highp float;
precision highp int;
in uint row;
in uvec4 texel;
uniform vec2 size;
flat out uvec4 value;
void main() {
  value = texel;
  vec2 place = vec2(float(row % ${LINE}u), float(row / ${LINE}u)) + 0.5;
  gl_Position = vec4(2.0 * place / size - 1.0, 0.0, 1.0);
  gl_PointSize = 1.0;
}`;

const fragmentShader = `
precision highp int;
flat in uvec4 value;
layout(location = 0) out highp uvec4 texel;
void main() { texel = value; }`;

/** Writes rows of tables; one is enough for all tables of a renderer. */
export class TableWriter {
  /** Bytes that were sent to the graphics card, ever. */
  bytes = 0;

  readonly #rows = new BufferAttribute(new Uint32Array(BATCH), 1);
  readonly #texels = new BufferAttribute(new Uint32Array(4 * BATCH), 4);
  readonly #geometry = new BufferGeometry();
  readonly #material: RawShaderMaterial;
  readonly #scene = new Scene();
  readonly #camera = new Camera();
  #count = 0;
  #target: WebGLRenderTarget | undefined;

  /** The renderer must not clear by itself (`autoClear`). */
  constructor(private readonly renderer: WebGLRenderer) {
    this.#geometry.setAttribute('row', this.#rows);
    this.#geometry.setAttribute('texel', this.#texels);
    this.#material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader,
      fragmentShader,
      uniforms: { size: { value: [1, 1] } },
      blending: NoBlending,
      depthTest: false,
      depthWrite: false,
    });
    const points = new Points(this.#geometry, this.#material);
    points.frustumCulled = false;
    this.#scene.add(points);
  }

  /** What follows goes to this table, until `end`. */
  begin(table: Table): void {
    this.#target = table.target;
    this.#material.uniforms.size.value = [table.target.width, table.target.height];
  }

  write(row: number, a: number, b: number, c: number, d: number): void {
    if (this.#count === BATCH) this.#flush();
    const at = this.#count++;
    const texels = this.#texels.array;
    this.#rows.array[at] = row;
    texels[4 * at] = a;
    texels[4 * at + 1] = b;
    texels[4 * at + 2] = c;
    texels[4 * at + 3] = d;
  }

  end(): void {
    this.#flush();
    this.#target = undefined;
  }

  #flush(): void {
    if (this.#count === 0 || this.#target === undefined) return;
    for (const attribute of [this.#rows, this.#texels]) {
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, this.#count * attribute.itemSize);
      attribute.needsUpdate = true;
    }
    this.#geometry.setDrawRange(0, this.#count);
    this.renderer.setRenderTarget(this.#target);
    this.renderer.render(this.#scene, this.#camera);
    this.renderer.setRenderTarget(null);
    this.bytes += 20 * this.#count;
    this.#count = 0;
  }
}

export class Table {
  target: WebGLRenderTarget;
  /** Rows that fit. */
  capacity: number;

  constructor(rows: number) {
    const height = Math.max(1, Math.ceil(rows / LINE));
    this.capacity = height * LINE;
    this.target = new WebGLRenderTarget(LINE, height, {
      format: RGBAIntegerFormat,
      type: UnsignedIntType,
      internalFormat: 'RGBA32UI',
      minFilter: NearestFilter,
      magFilter: NearestFilter,
      depthBuffer: false,
      generateMipmaps: false,
    });
  }

  get texture(): Texture {
    return this.target.texture;
  }

  /**
   * Makes room for that many rows, of `most` that the graphics card allows. True if the table is
   * another one then, and empty.
   */
  reserve(rows: number, most: number): boolean {
    if (rows <= this.capacity) return false;
    const { capacity } = this;
    this.dispose();
    const larger = new Table(Math.min(Math.max(rows, 2 * capacity), most));
    this.target = larger.target;
    this.capacity = larger.capacity;
    return true;
  }

  dispose(): void {
    this.target.dispose();
  }
}

// What is seen of a mesh: the picture, the camera, and what pointers do with them. Draws when there
// is something to draw: a change, a movement, or a glow that fades.
import { Matrix4, Vector3 } from 'three';
import { PlaneCamera, type Pixel, type Place } from './draw/camera.js';
import { OrbitCamera } from './draw/orbit.js';
import { CutClient } from './cut/client.js';
import { Picture, type Eye, type Look } from './draw/picture.js';
import { stampNow, STAMPS_PER_SECOND } from './draw/stamps.js';
import { triangleAt } from './model/picking.js';
import type { SlotMesh } from './model/slot_mesh.js';

export interface Box {
  lo: readonly number[];
  hi: readonly number[];
}

export interface ViewListener {
  /** The pointer is over another triangle; -1: over none. */
  hovered(row: number): void;
  clicked(row: number, place: Place): void;
  /** The camera stands still again. */
  settled(): void;
  /** Why there is no picture, or only a part of it; empty if all is drawn. */
  undrawn(reason: string): void;
  /** A frame was drawn. */
  drawn(): void;
  /** True if something but the camera takes the drag that begins here. */
  grabbed(place: Place): boolean;
  dragged(place: Place): void;
  dropped(): void;
  /** The browser has taken the drag away. */
  cancelled(): void;
}

const NO_WEBGL = 'There is no picture: this browser has no WebGL 2, or does not allow it.';
const LOST_WEBGL = 'There is no picture: the browser has lost the graphics card.';
const TOO_LARGE = 'There is no picture: the mesh is larger than this graphics card can draw.';

/** Pixels that a pointer may move in a click. */
const CLICK = 4;
/** In a mesh of more triangles, the one under the pointer is looked for when the pointer rests. */
const MANY = 100_000;
const REST_MS = 80;

export class View {
  readonly plane = new PlaneCamera();
  readonly orbit = new OrbitCamera();
  /** Undefined without WebGL 2. */
  readonly picture: Picture | undefined;
  readonly #cut: CutClient;
  /** An axis, and where between the sides of the box the plane is. */
  #clip: { axis: number; share: number } | undefined;
  hovered = -1;
  /** JavaScript time of the last frame that changed the mesh: uploads and drawing. */
  updateMs = 0;
  frames = 0;

  #mesh: SlotMesh | undefined;
  #box: Box = { lo: [0, 0, 0], hi: [1, 1, 1] };
  #isScheduled = false;
  #meshChanged = false;
  /** Until when something glows, in milliseconds. */
  #glowsUntil = 0;
  #frozenAt: number | undefined;
  /** The picture has all of the mesh. */
  #isWhole = true;
  readonly #pointers = new Map<number, Pixel>();
  #moved = 0;
  /** The button that was pressed first. */
  #button = 0;
  #pointer: Pixel | undefined;
  #isGrabbed = false;
  #rest: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    public look: Look,
    private readonly listener: ViewListener,
  ) {
    this.picture = pictureOn(canvas);
    if (this.picture === undefined) listener.undrawn(NO_WEBGL);
    this.#cut = new CutClient(
      () => this.#origin(),
      (triangles) => {
        this.picture?.setCut(this.#cut.isOn ? triangles : undefined);
        this.invalidate();
      },
    );
    new ResizeObserver(() => this.#resize()).observe(canvas);
    this.#resize();
    canvas.addEventListener('pointerdown', (event) => this.#down(event));
    canvas.addEventListener('pointermove', (event) => this.#move(event));
    canvas.addEventListener('pointerup', (event) => this.#up(event));
    canvas.addEventListener('pointercancel', (event) => this.#cancel(event));
    canvas.addEventListener('pointerleave', () => this.#leave());
    canvas.addEventListener('wheel', (event) => this.#wheel(event), { passive: false });
    // What the graphics card had is gone with its context, and comes again from the mesh.
    canvas.addEventListener('webglcontextlost', () => {
      this.picture?.lost();
      listener.undrawn(LOST_WEBGL);
    });
    canvas.addEventListener('webglcontextrestored', () => {
      listener.undrawn('');
      this.#isWhole = true;
      this.#fill();
    });
  }

  get isSpace(): boolean {
    return this.#mesh?.dimension === 3;
  }

  /** The least scale of the picture is that of the whole box. */
  setBox(box: Box): void {
    this.#box = box;
    this.fit();
  }

  get box(): Box {
    return this.#box;
  }

  setMesh(mesh: SlotMesh | undefined): void {
    this.#mesh = mesh;
    this.hovered = -1;
    this.#fill();
  }

  /** Gives the picture all of the mesh. */
  #fill(): void {
    this.picture?.setMesh(this.#mesh, this.#origin());
    this.#meshChanged = true;
    this.setClip(this.#clip);
  }

  /** Cuts a 3D mesh open. */
  setClip(clip: { axis: number; share: number } | undefined): void {
    this.#clip = clip;
    const offset = this.#clipOffset();
    this.#cut.set(
      this.#mesh,
      clip && offset !== undefined ? { axis: clip.axis, offset } : undefined,
    );
    if (!this.#cut.isOn) this.picture?.setCut(undefined);
    this.invalidate();
  }

  meshChanged(): void {
    this.#meshChanged = true;
    this.#glowsUntil = performance.now() + 1000 * this.look.fadeSeconds;
    this.invalidate();
  }

  setLook(look: Look): void {
    this.look = look;
    this.invalidate();
  }

  fit(): void {
    if (this.plane.width === 1) return; // there is no picture yet
    const { lo, hi } = this.#box;
    this.plane.fit({ lo: { x: lo[0], y: lo[1] }, hi: { x: hi[0], y: hi[1] } });
    const low = new Vector3(lo[0], lo[1], lo[2] ?? 0);
    const high = new Vector3(hi[0], hi[1], hi[2] ?? 0);
    const radius = low.distanceTo(high) / 2;
    this.orbit.fit(low.add(high).multiplyScalar(0.5), radius);
    this.invalidate();
    this.listener.settled();
  }

  /** Makes things `factor` times as large, about the middle. */
  zoom(factor: number): void {
    const middle = { x: this.plane.width / 2, y: this.plane.height / 2 };
    if (this.isSpace) this.orbit.zoom(middle, factor);
    else this.plane.zoom(middle, factor);
    this.invalidate();
    this.listener.settled();
  }

  pan(dx: number, dy: number): void {
    if (this.isSpace) this.orbit.pan(dx, dy);
    else this.plane.pan(dx, dy);
    this.invalidate();
    this.listener.settled();
  }

  /** Draws in the next frame. */
  invalidate(): void {
    if (this.#isScheduled) return;
    this.#isScheduled = true;
    requestAnimationFrame(() => {
      this.#isScheduled = false;
      this.drawNow();
    });
  }

  /** The time that what changes now gets. */
  stamp(): number {
    return this.#frozenAt ?? stampNow();
  }

  /** Stops the clock of the glow. */
  freeze(isFrozen: boolean): void {
    this.#frozenAt = isFrozen ? stampNow() : undefined;
    this.invalidate();
  }

  drawNow(): void {
    const begin = performance.now();
    const { picture } = this;
    const now = this.stamp();
    const changed = this.#meshChanged;
    if (changed) {
      this.#meshChanged = false;
      this.#cut.changed();
      this.#hoverSoon();
    }
    if (picture === undefined) this.#mesh?.settle();
    else if (!picture.isLost) {
      if (changed || picture.isOld(now)) this.#update(picture, now);
      picture.draw(this.#eye(), this.look, now, this.hovered);
    }
    ++this.frames;
    this.listener.drawn();
    if (changed) this.updateMs = performance.now() - begin;
    // One frame more than the glow lasts shows that it is over.
    const last = this.#glowsUntil + 2000 / STAMPS_PER_SECOND;
    if (this.#frozenAt === undefined && performance.now() < last) this.invalidate();
  }

  #update(picture: Picture, now: number): void {
    const isWhole = picture.update(now);
    if (isWhole !== this.#isWhole) this.listener.undrawn(isWhole ? '' : TOO_LARGE);
    this.#isWhole = isWhole;
  }

  /** Where the plane is; undefined if there is none. */
  #clipOffset(): number | undefined {
    if (this.#clip === undefined || !this.isSpace) return undefined;
    const { axis, share } = this.#clip;
    const low = this.#box.lo[axis];
    return low + share * (this.#box.hi[axis] - low);
  }

  #origin(): number[] {
    return [0, 1, 2].map((k) => ((this.#box.lo[k] ?? 0) + (this.#box.hi[k] ?? 0)) / 2);
  }

  #eye(): Eye {
    const [x, y, z] = this.#origin();
    if (this.isSpace) {
      const offset = this.#clipOffset();
      const axis = this.#clip?.axis ?? 0;
      const position = this.orbit.position();
      return {
        position: [position.x - x, position.y - y, position.z - z],
        project: this.orbit.projection(),
        direction: this.orbit.direction(),
        clip: offset === undefined ? undefined : { axis, offset: offset - this.#origin()[axis] },
      };
    }
    const { centre, scale, width, height } = this.plane;
    return {
      position: [centre.x - x, centre.y - y, 0],
      project: new Matrix4().makeScale((2 * scale) / width, (2 * scale) / height, 1),
      direction: new Vector3(0, 0, 1),
      clip: undefined,
    };
  }

  #resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    const isFirst = this.plane.width === 1;
    this.plane.resize(clientWidth, clientHeight);
    this.orbit.resize(clientWidth, clientHeight);
    this.picture?.resize(clientWidth, clientHeight, devicePixelRatio);
    if (isFirst) this.fit();
    else this.drawNow(); // a canvas of another size is empty
  }

  #pixelOf(event: MouseEvent): Pixel {
    const frame = this.canvas.getBoundingClientRect();
    return { x: event.clientX - frame.left, y: event.clientY - frame.top };
  }

  #down(event: PointerEvent): void {
    this.canvas.setPointerCapture(event.pointerId);
    const pixel = this.#pixelOf(event);
    // One that is still here was released elsewhere, as over a menu.
    if (event.isPrimary) this.#pointers.clear();
    if (this.#pointers.size === 0) {
      this.#moved = 0;
      this.#button = event.button;
      this.#isGrabbed =
        !this.isSpace && event.button === 0 && this.listener.grabbed(this.plane.placeOf(pixel));
    }
    this.#pointers.set(event.pointerId, pixel);
  }

  #move(event: PointerEvent): void {
    const pixel = this.#pixelOf(event);
    // A button that was released over a menu is noticed here.
    if (event.buttons === 0) this.#cancel(event);
    const before = this.#pointers.get(event.pointerId);
    if (before === undefined) {
      this.#pointer = pixel;
      this.#hoverSoon();
      return;
    }
    const dx = pixel.x - before.x;
    const dy = pixel.y - before.y;
    this.#moved += Math.hypot(dx, dy);
    const [other] = [...this.#pointers].filter(([id]) => id !== event.pointerId);
    this.#pointers.set(event.pointerId, pixel);
    if (this.#isGrabbed) {
      if (this.#moved > CLICK) this.listener.dragged(this.plane.placeOf(pixel));
    } else if ((other as typeof other | undefined) !== undefined) {
      this.#pinch(before, pixel, other[1]);
    } else if (this.isSpace && event.buttons === 1 && !event.shiftKey) {
      this.orbit.turn(dx, dy);
    } else if (this.isSpace) {
      this.orbit.pan(dx, dy);
    } else {
      this.plane.pan(dx, dy);
    }
    this.invalidate();
  }

  /** Two fingers: one has moved, the other stays. */
  #pinch(before: Pixel, after: Pixel, other: Pixel): void {
    const distance = (pixel: Pixel): number => Math.hypot(pixel.x - other.x, pixel.y - other.y);
    const factor = distance(after) / Math.max(1, distance(before));
    const dx = (after.x - before.x) / 2;
    const dy = (after.y - before.y) / 2;
    if (this.isSpace) {
      this.orbit.zoom(other, factor);
      this.orbit.pan(dx, dy);
    } else {
      this.plane.zoom({ x: (after.x + other.x) / 2, y: (after.y + other.y) / 2 }, factor);
      this.plane.pan(dx, dy);
    }
  }

  #up(event: PointerEvent): void {
    if (!this.#pointers.delete(event.pointerId) || this.#pointers.size > 0) return;
    if (this.#isGrabbed) {
      this.#isGrabbed = false;
      this.listener.dropped();
      return;
    }
    if (this.#moved > CLICK) {
      this.listener.settled();
      return;
    }
    if (this.#button !== 0) return;
    const pixel = this.#pixelOf(event);
    const place = this.plane.placeOf(pixel);
    this.listener.clicked(this.#rowAt(place), place);
  }

  #cancel(event: PointerEvent): void {
    this.#pointers.delete(event.pointerId);
    if (!this.#isGrabbed || this.#pointers.size > 0) return;
    this.#isGrabbed = false;
    this.listener.cancelled();
  }

  #leave(): void {
    this.#pointer = undefined;
    this.#hoverAgain();
  }

  #wheel(event: WheelEvent): void {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    const factor = Math.exp(-event.deltaY * lines * 0.0015);
    const pixel = this.#pixelOf(event);
    if (this.isSpace) this.orbit.zoom(pixel, factor);
    else this.plane.zoom(pixel, factor);
    this.invalidate();
    this.listener.settled();
  }

  #rowAt(place: Place): number {
    const mesh = this.#mesh;
    if (mesh?.dimension !== 2) return -1;
    return triangleAt(mesh, place.x, place.y, this.hovered);
  }

  /** The mesh or the pointer may have moved. */
  #hoverSoon(): void {
    if (this.#pointer === undefined && this.hovered < 0) return;
    clearTimeout(this.#rest);
    if ((this.#mesh?.cells.length ?? 0) <= MANY) this.#hoverAgain();
    else this.#rest = setTimeout(() => this.#hoverAgain(), REST_MS);
  }

  #hoverAgain(): void {
    const row = this.#pointer === undefined ? -1 : this.#rowAt(this.plane.placeOf(this.#pointer));
    const changed = row !== this.hovered;
    this.hovered = row;
    if (changed) this.invalidate();
    if (changed || row >= 0) this.listener.hovered(row);
  }
}

function pictureOn(canvas: HTMLCanvasElement): Picture | undefined {
  try {
    return new Picture(canvas);
  } catch {
    return undefined; // three has said why in the console
  }
}

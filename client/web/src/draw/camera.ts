// The view of a plane: a place in the middle of the picture, and a scale. Coordinates are relative to
// an origin in doubles, and go to shaders as two floats each, so that a picture of 10^-9 of the box
// does not tremble: subtracting the camera from a position leaves what is near it exact.

/** Pixels from the left upper corner. */
export interface Pixel {
  x: number;
  y: number;
}

export interface Place {
  x: number;
  y: number;
}

export interface Rectangle {
  lo: Place;
  hi: Place;
}

/** The least width of a picture, as a share of the fitted one: doubles have no more to show. */
const CLOSEST = 1e-11;
const FARTHEST = 100;

export class PlaneCamera {
  /** In the middle of the picture. */
  centre: Place = { x: 0, y: 0 };
  /** Pixels a unit. */
  scale = 1;
  width = 1;
  height = 1;
  #fitted = 1;

  resize(width: number, height: number): void {
    this.width = Math.max(1, width);
    this.height = Math.max(1, height);
  }

  /** Shows all of the rectangle, with a margin. */
  fit(rectangle: Rectangle): void {
    const { lo, hi } = rectangle;
    this.centre = { x: (lo.x + hi.x) / 2, y: (lo.y + hi.y) / 2 };
    const side = Math.max(hi.x - lo.x, hi.y - lo.y);
    const width = Math.max(hi.x - lo.x, side * 1e-6);
    const height = Math.max(hi.y - lo.y, side * 1e-6);
    this.#fitted = 0.92 * Math.min(this.width / width, this.height / height);
    this.scale = this.#fitted;
  }

  /** The scale of `fit`, in pixels a unit. */
  get fittedScale(): number {
    return this.#fitted;
  }

  setScale(scale: number): void {
    this.scale = Math.min(Math.max(scale, this.#fitted / FARTHEST), this.#fitted / CLOSEST);
  }

  /** Makes things `factor` times as large, and keeps what is at the pixel there. */
  zoom(pixel: Pixel, factor: number): void {
    const before = this.scale;
    this.setScale(before * factor);
    const change = 1 / before - 1 / this.scale;
    this.centre = {
      x: this.centre.x + (pixel.x - this.width / 2) * change,
      y: this.centre.y - (pixel.y - this.height / 2) * change,
    };
  }

  /** Moves what is seen by that many pixels. */
  pan(dx: number, dy: number): void {
    this.centre = { x: this.centre.x - dx / this.scale, y: this.centre.y + dy / this.scale };
  }

  placeOf(pixel: Pixel): Place {
    return {
      x: this.centre.x + (pixel.x - this.width / 2) / this.scale,
      y: this.centre.y - (pixel.y - this.height / 2) / this.scale,
    };
  }

  pixelOf(place: Place): Pixel {
    return {
      x: this.width / 2 + (place.x - this.centre.x) * this.scale,
      y: this.height / 2 - (place.y - this.centre.y) * this.scale,
    };
  }
}

/** The two floats of a number, the second what the first leaves. */
export function halves(value: number): [number, number] {
  const hi = Math.fround(value);
  return [hi, Math.fround(value - hi)];
}

// The view of a space: an eye that looks at a target from some distance, and turns around it.
import { Matrix4, Vector3 } from 'three';
import type { Pixel } from './camera.js';

const FIELD = (40 * Math.PI) / 180;
const STEEPEST = Math.PI / 2 - 0.01;

export class OrbitCamera {
  target = new Vector3();
  distance = 1;
  /** Around the axis z, and above the plane of x and y; in radians. */
  yaw = 0.6;
  pitch = 0.5;
  width = 1;
  height = 1;
  #fitted = 1;

  resize(width: number, height: number): void {
    this.width = Math.max(1, width);
    this.height = Math.max(1, height);
  }

  /** Shows all of a ball. */
  fit(centre: Vector3, radius: number): void {
    this.target.copy(centre);
    const narrow = Math.min(1, this.width / this.height);
    this.#fitted = (1.05 * radius) / Math.sin(FIELD / 2) / narrow;
    this.distance = this.#fitted;
  }

  turn(dx: number, dy: number): void {
    this.yaw -= dx * 0.008;
    this.pitch = Math.min(Math.max(this.pitch + dy * 0.008, -STEEPEST), STEEPEST);
  }

  pan(dx: number, dy: number): void {
    const unit = (2 * this.distance * Math.tan(FIELD / 2)) / this.height;
    const [right, up] = this.#axes();
    this.target.addScaledVector(right, -dx * unit).addScaledVector(up, dy * unit);
  }

  zoom(_pixel: Pixel, factor: number): void {
    this.distance = Math.min(
      Math.max(this.distance / factor, this.#fitted * 1e-6),
      this.#fitted * 20,
    );
  }

  /** From the target to the eye. */
  direction(): Vector3 {
    const level = Math.cos(this.pitch);
    return new Vector3(
      level * Math.sin(this.yaw),
      -level * Math.cos(this.yaw),
      Math.sin(this.pitch),
    );
  }

  position(): Vector3 {
    return this.direction().multiplyScalar(this.distance).add(this.target);
  }

  /** From positions relative to the eye to clip space. */
  projection(): Matrix4 {
    const [right, up, back] = this.#axes();
    const near = this.distance * 0.01;
    const far = this.distance + 4 * this.#fitted;
    const top = near * Math.tan(FIELD / 2);
    const side = (top * this.width) / this.height;
    const view = new Matrix4().makeBasis(right, up, back).transpose();
    return new Matrix4().makePerspective(-side, side, top, -top, near, far).multiply(view);
  }

  #axes(): [Vector3, Vector3, Vector3] {
    const back = this.direction();
    const right = new Vector3(Math.cos(this.yaw), Math.sin(this.yaw), 0);
    return [right, back.clone().cross(right), back];
  }
}

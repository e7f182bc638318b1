// Figures of a triangle, as the shaders compute them, for people and histograms.

export interface TriangleFigures {
  /** Circumradius / shortest edge. */
  quality: number;
  /** Degrees. */
  leastAngle: number;
  longestEdge: number;
  area: number;
}

/** Of the triangle with these corners, rows of `coordinates`. */
export function triangleFigures(
  coordinates: Float64Array,
  dimension: number,
  a: number,
  b: number,
  c: number,
): TriangleFigures {
  const edge = (p: number, q: number): number[] => {
    const difference = [0, 0, 0];
    for (let k = 0; k < dimension; ++k) {
      difference[k] = coordinates[q * dimension + k] - coordinates[p * dimension + k];
    }
    return difference;
  };
  const ab = edge(a, b);
  const ac = edge(a, c);
  const l = Math.hypot(...edge(b, c));
  const m = Math.hypot(...ac);
  const n = Math.hypot(...ab);
  const doubleArea = Math.hypot(
    ab[1] * ac[2] - ab[2] * ac[1],
    ab[2] * ac[0] - ab[0] * ac[2],
    ab[0] * ac[1] - ab[1] * ac[0],
  );
  const [shortest, middle, longest] = [l, m, n].sort((p, q) => p - q);
  const circumradius = (l * m * n) / (2 * doubleArea);
  return {
    quality: circumradius / shortest,
    // Opposite to the shortest edge; the sine of a small angle is more exact than its cosine.
    leastAngle: (Math.asin(Math.min(1, doubleArea / (middle * longest))) * 180) / Math.PI,
    longestEdge: longest,
    area: doubleArea / 2,
  };
}

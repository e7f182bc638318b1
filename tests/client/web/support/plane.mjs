// A 2D mesh as the server gives it: what the page should show, computed without the page's code.

export class Plane {
  /** Coordinates by id. */
  places = new Map();
  /** Rows of three ids, and the region of each. */
  triangles = [];

  static async of(server, mesh) {
    const result = new Plane();
    for (const chunk of await server.stream('GetSnapshot', { mesh })) result.#take(chunk);
    return result;
  }

  #take({ vertices = {}, simplices = {} }) {
    (vertices.ids ?? []).forEach((id, i) => {
      this.places.set(id, [vertices.coordinates[2 * i], vertices.coordinates[2 * i + 1]]);
    });
    const ids = simplices.vertexIds ?? [];
    for (let i = 0; i < ids.length; i += 3) {
      this.triangles.push({
        ids: ids.slice(i, i + 3),
        region: simplices.regions?.[i / 3] ?? '0',
      });
    }
  }

  corners({ ids }) {
    return ids.map((id) => this.places.get(id));
  }

  /** The middle of the inscribed circle, and its radius. */
  inside(triangle) {
    const [a, b, c] = this.corners(triangle);
    const distance = (p, q) => Math.hypot(p[0] - q[0], p[1] - q[1]);
    const [l, m, n] = [distance(b, c), distance(c, a), distance(a, b)];
    const around = l + m + n;
    const area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
    return {
      x: (l * a[0] + m * b[0] + n * c[0]) / around,
      y: (l * a[1] + m * b[1] + n * c[1]) / around,
      radius: (2 * area) / around,
      quality: (l * m * n) / (4 * area) / Math.min(l, m, n),
    };
  }
}

/** The triangles that are large enough on the page to have a colour of their own, with a pixel. */
export async function visible(page, plane, pixels = 5) {
  const insides = plane.triangles.map((triangle) => plane.inside(triangle));
  const seen = await page.evaluate(async (places) => {
    // A change of the layout reaches the picture in the next frame.
    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    const canvas = document.getElementById('picture').getBoundingClientRect();
    const scale = window.__dynmesh.pixelOf(1, 0).x - window.__dynmesh.pixelOf(0, 0).x;
    return places.map(({ x, y, radius }) => {
      const pixel = window.__dynmesh.pixelOf(x, y);
      const isIn = pixel.x > 0 && pixel.y > 0 && pixel.x < canvas.width && pixel.y < canvas.height;
      return { pixel, size: isIn ? radius * scale : 0 };
    });
  }, insides);
  return plane.triangles
    .map((triangle, i) => ({ ...triangle, ...insides[i], ...seen[i] }))
    .filter(({ size }) => size >= pixels);
}

// Scripts of golden cases (dynmesh_golden_hashes --scripts) through the package.

// What the C interface has no function for.
const isLeftOut = (words) =>
  words.at(-1) === "unsplit" ||
  (words[1] === "size" && words[3] !== "point" && words[3] !== "disc");

// {name, header, batches} of each case: a batch is the words of its lines.
export function casesOf(text) {
  const cases = [];
  for (const line of text.split("\n")) {
    const words = line.split(" ");
    const last = cases.at(-1);
    if (words[0] === "case") cases.push({ name: words[1], batches: [], open: [], isWhole: true });
    else if (words[0] === "mesh") last.header = Object.fromEntries(words.slice(1).map((w) => w.split("=")));
    else if (words[0] === "commit") last.batches.push(last.open), (last.open = []);
    else if (line !== "") last.open.push(words), (last.isWhole &&= !isLeftOut(words));
  }
  return cases;
}

function optionsOf(header) {
  const box = header.box.split(",").map(Number);
  const dimension = Number(header.dim);
  const options = { dimension, low: box.slice(0, dimension), high: box.slice(dimension) };
  if (header.kind) options.kind = header.kind;
  if (header.rho) options.quality = Number(header.rho);
  if (header.criterion) options.criterion = header.criterion;
  if (header.hmax) options.maxEdge = Number(header.hmax);
  if (header.min_dihedral) options.minDihedral = Number(header.min_dihedral);
  return options;
}

function append(batch, words, d) {
  const [action, kind] = words;
  const id = BigInt(words[action === "remove" ? 1 : 2]);
  const numbers = words.slice(3).map(Number);
  if (action === "remove") batch.remove([id]);
  else if (action === "move") batch.movePoints([id], numbers);
  else if (kind === "point") batch.addPoints([id], numbers, { action });
  else if (kind === "segment") batch.addSegments([id], words.slice(3).map(BigInt), { action });
  else if (kind === "polygon") {
    const rings = words.slice(3).join(" ").split(" / ").map((ring) => ring.split(" ").map(BigInt));
    batch.addPolygon(id, rings, { action });
  } else if (kind === "size") {
    const given = numbers.slice(1);
    const radii = words[3] === "disc" ? [given[d]] : [];
    batch.addSizes([id], given.slice(0, d), [given.at(-1)], { radii, action });
  } else throw new Error(`what is ${words.join(" ")}?`);
}

// The hash after all batches; those that are refused change nothing.
export function hashOf(dynmesh, { header, batches }, isError) {
  const options = optionsOf(header);
  const mesh = dynmesh.open(options);
  const batch = dynmesh.batch(options.dimension);
  for (const lines of batches) {
    batch.clear();
    for (const words of lines) append(batch, words, options.dimension);
    try {
      mesh.apply(batch);
    } catch (error) {
      if (!isError(error)) throw error;
    }
  }
  const { hash } = mesh;
  batch.close();
  mesh.close();
  return hash;
}

// Editing with the pointer: tools, of which one is chosen, and undo.
import type { Place } from '../draw/camera.js';
import { wordAt } from '../model/columns.js';
import { randomId } from '../model/ids.js';
import { inputPointAt } from '../model/picking.js';
import type { SlotMesh } from '../model/slot_mesh.js';
import type { Editor } from '../service/editor.js';
import { element } from './dom.js';
import { noDraft, type Draft } from './overlay.js';

export const tools = ['look', 'points', 'remove', 'segments', 'polygon', 'size'] as const;
export type Tool = (typeof tools)[number];

const names: Record<Tool, string> = {
  look: 'Look around',
  points: 'Add and drag points',
  remove: 'Remove points',
  segments: 'Draw segments',
  polygon: 'Draw a polygon',
  size: 'Size in a disc',
};

/** Pixels around a point that are still it. */
const REACH = 9;

export interface ToolsListener {
  drafted(draft: Draft): void;
  /** Where an edit happens, for what the server says of it. */
  editedAt(place: Place): void;
}

/** An end of a line: a point that is there, or a new one. */
interface End {
  id: bigint;
  place: Place;
  isNew: boolean;
}

export class Tools {
  tool: Tool = 'look';
  readonly #section = element('section', { hidden: true });
  readonly #choice = element('select');
  readonly #target = element('input', {
    type: 'number',
    min: '0',
    step: 'any',
    placeholder: 'auto',
  });
  readonly #undo = element('button', { type: 'button' }, 'Undo');
  readonly #redo = element('button', { type: 'button' }, 'Redo');
  #mesh: SlotMesh | undefined;
  #editor: Editor | undefined;
  #ends: End[] = [];
  #dragged: bigint | undefined;
  #disc: { centre: Place; radius: number } | undefined;

  constructor(
    parent: HTMLElement,
    private readonly listener: ToolsListener,
  ) {
    for (const tool of tools) this.#choice.append(element('option', { value: tool }, names[tool]));
    this.#section.append(
      element('h2', {}, 'Edit'),
      element('label', {}, 'Tool ', this.#choice),
      element('label', {}, 'Longest edge of a size ', this.#target),
      this.#undo,
      ' ',
      this.#redo,
    );
    parent.append(this.#section);
    this.#choice.addEventListener('change', () => {
      this.tool = tools.find((tool) => tool === this.#choice.value) ?? 'look';
      this.#drop();
    });
    this.#undo.addEventListener('click', () => this.undo());
    this.#redo.addEventListener('click', () => this.redo());
  }

  /** Meshes in 2D are edited. */
  setMesh(mesh: SlotMesh | undefined, editor: Editor | undefined): void {
    if (mesh !== this.#mesh) this.#drop();
    this.#mesh = mesh?.dimension === 2 ? mesh : undefined;
    this.#editor = editor;
    this.#section.hidden = this.#mesh === undefined;
    this.update();
  }

  update(): void {
    this.#undo.disabled = !(this.#editor?.canUndo ?? false);
    this.#redo.disabled = !(this.#editor?.canRedo ?? false);
  }

  undo(): void {
    this.#dropLine();
    this.#editor?.undo();
  }

  redo(): void {
    this.#editor?.redo();
  }

  /** Ends what is being drawn: a polygon is closed, a line is left. */
  finish(): void {
    if (this.tool === 'polygon') this.#closePolygon();
    else this.#drop();
  }

  cancel(): void {
    this.#drop();
  }

  /** An edit was refused: the line does not go on from a point that may not be there. */
  refused(): void {
    this.#dropLine();
  }

  /** A new point has got another id. */
  renamed(from: bigint, to: bigint): void {
    for (const end of this.#ends) if (end.id === from) end.id = to;
  }

  /** True if the tool takes the drag that begins here. */
  down(place: Place, scale: number): boolean {
    const mesh = this.#mesh;
    if (mesh === undefined) return false;
    if (this.tool === 'points') {
      const slot = inputPointAt(mesh, place.x, place.y, REACH / scale);
      if (slot < 0) return false;
      this.#dragged = wordAt(mesh.vertices.owners, slot);
      this.#editor?.beginGesture();
      return true;
    }
    if (this.tool !== 'size') return false;
    this.#disc = { centre: place, radius: 0 };
    return true;
  }

  drag(place: Place): void {
    if (this.#dragged !== undefined) {
      this.listener.editedAt(place);
      this.#editor?.apply({
        action: { case: 'move', value: { id: this.#dragged, to: { x: place.x, y: place.y } } },
      });
    } else if (this.#disc !== undefined) {
      const { centre } = this.#disc;
      this.#disc = { centre, radius: Math.hypot(place.x - centre.x, place.y - centre.y) };
      this.listener.drafted({ line: [], disc: this.#disc });
    }
  }

  /** The drag ends. */
  up(): void {
    if (this.#dragged !== undefined) {
      this.#endDrag();
      return;
    }
    const disc = this.#disc;
    this.#drop();
    if (disc === undefined || disc.radius === 0 || this.#mesh === undefined) return;
    const given = Number(this.#target.value);
    const target = given > 0 ? given : disc.radius / 4;
    this.listener.editedAt(disc.centre);
    this.#editor?.apply({
      action: {
        case: 'add',
        value: {
          id: randomId(),
          geometry: {
            case: 'size',
            value: { region: { case: 'disc', value: disc }, target },
          },
        },
      },
    });
  }

  click(place: Place, scale: number): void {
    const mesh = this.#mesh;
    if (mesh === undefined || this.tool === 'look' || this.tool === 'size') return;
    this.listener.editedAt(place);
    const slot = inputPointAt(mesh, place.x, place.y, REACH / scale);
    if (this.tool === 'points') {
      if (slot < 0) this.#editor?.apply(addPoint(randomId(), place));
      return;
    }
    if (this.tool === 'remove') {
      if (slot < 0) return;
      const id = wordAt(mesh.vertices.owners, slot);
      this.#editor?.apply({ action: { case: 'remove', value: id } });
      return;
    }
    const near = this.#ends.find(
      (end) => Math.hypot(end.place.x - place.x, end.place.y - place.y) * scale < REACH,
    );
    if (this.tool === 'polygon' && near !== undefined && near === this.#ends[0]) {
      this.#closePolygon();
      return;
    }
    this.#ends.push(near ?? this.#endAt(mesh, slot, place));
    if (this.tool === 'segments' && this.#ends.length === 2) this.#addSegment();
    this.listener.drafted({ line: this.#ends.map((end) => end.place), disc: undefined });
  }

  #endAt(mesh: SlotMesh, slot: number, place: Place): End {
    if (slot < 0) return { id: randomId(), place, isNew: true };
    const { coordinates, owners } = mesh.vertices;
    return {
      id: wordAt(owners, slot),
      place: { x: coordinates[2 * slot], y: coordinates[2 * slot + 1] },
      isNew: false,
    };
  }

  /** The next segment goes on from this one's end. */
  #addSegment(): void {
    const [p, q] = this.#ends;
    this.#editor?.apply(...newPoints(this.#ends), {
      action: {
        case: 'add',
        value: {
          id: randomId(),
          geometry: { case: 'segment', value: { p: p.id, q: q.id } },
        },
      },
    });
    this.#ends = [{ ...q, isNew: false }];
  }

  #closePolygon(): void {
    const ends = this.#ends;
    this.#drop();
    if (ends.length < 3 || this.#mesh === undefined) return;
    this.#editor?.apply(...newPoints(ends), {
      action: {
        case: 'add',
        value: {
          id: randomId(),
          geometry: { case: 'polygon', value: { rings: [{ points: ends.map(({ id }) => id) }] } },
        },
      },
    });
  }

  #dropLine(): void {
    if (this.tool === 'segments') this.#drop();
  }

  #endDrag(): void {
    if (this.#dragged === undefined) return;
    this.#dragged = undefined;
    this.#editor?.endGesture();
  }

  #drop(): void {
    this.#ends = [];
    this.#disc = undefined;
    this.#endDrag();
    this.listener.drafted(noDraft);
  }
}

function addPoint(id: bigint, { x, y }: Place) {
  return {
    action: {
      case: 'add' as const,
      value: { id, geometry: { case: 'point' as const, value: { x, y } } },
    },
  };
}

function newPoints(ends: readonly End[]) {
  return [...new Set(ends)]
    .filter(({ isNew }) => isNew)
    .map(({ id, place }) => addPoint(id, place));
}

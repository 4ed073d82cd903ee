"""Which curve of a face every stroke of a sketch draws."""

from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from caricli.errors import InputError
from caricli.methods.sketch.find_outline import find_outline
from caricli.methods.sketch.fit_lines import fit_lines, line_camera
from caricli.methods.sketch.lay_over import faces_over, mouths_over
from caricli.methods.sketch.line_handles import LineHandles, lines_by_curve, with_own_names
from caricli.methods.sketch.nameless_strokes import NamelessStrokes, rejoined
from caricli.methods.sketch.names_in_order import names_in_order
from caricli.methods.sketch.settings import (
    ALONE,
    BESIDE,
    MIDDLE,
    MOUTH,
    PARTS,
    PIECED,
    SELDOM,
    LineFitSettings,
    NamingSettings,
)
from caricli.methods.sketch.stroke_candidates import Candidate, candidates_at, split_ring, stroke_costs
from caricli.methods.sketch.strokes_read import Read
from caricli.models.shape_model import ShapeModel
from caricli.structures import Face
from caricli.structures.sketch import Sketch, Stroke
from caricli.template.feature_curves import SILHOUETTE

_QUICK = LineFitSettings(rounds=3)
_NEARLY = 1.1
"""Of the least cost: up to this an overlay comes first that names all strokes."""
_APART = 0.02
"""Share of a face's diagonal: so far below another line, one is not taken for what lies above. Lips of generated faces
cross by less."""
_NEARLY_ALL = 0.9
"""Of the length of the strokes that find curves: a network's face that finds curves for less does not count."""
_SURELY = 0.9
"""Of the cost above which a stroke draws no curve: what one costs at most that is surely an eye."""
_PIECES = 4
"""Strokes that continue a nose before others have found their curves, at most."""
_ALONG = 0.04
"""Share of a face's diagonal: as near such a stroke lies to the nose, nearer where a network finds it unlikely. A side
of it with its wing does not."""
_TRIALS = 8
"""Strokes of which the best is sought, at most."""


def name_strokes(
    sketch: Sketch,
    handles: LineHandles,
    model: ShapeModel,
    settings: NamingSettings = NamingSettings(),  # noqa: B008 (frozen)
    see: Callable[[Sketch], Face] | None = None,
    read: Read | None = None,
) -> Sketch:
    """Find the curve of every stroke that does not name one.

    The curves of the mean face are laid over the sketch, once for every box that this may be of; strokes and curves are
    then assigned to each other for the least sum of costs (the Hungarian method), a stroke that is dear everywhere to
    none; camera and latent of the model follow the strokes so named, and all again. The same begins with the faces that
    networks tell, what one sees and what goes with the names that another one reads, each of which counts where it
    costs less in the end. Where strokes are left, parts go where these faces have them, and the mouth over what is left
    below the nose, if that costs less. The cost is the mean distance of the stroke from the curve, and, counting less,
    of the curve from the stroke, their difference in direction, and how unlikely the network that reads strokes finds
    it. Brows, lids and lips that clearly lie one below the other change their names accordingly, and what would be
    drawn beside a lid or nose that is not drawn is this. Then strokes continue curves that others have drawn in part,
    and one that goes around all features is the outline where none is. Of a closed stroke that is both lids, or both
    lips, two are made, and of one that draws several curves as many as are read. Names that are given stay; wrinkles
    without a name stay without, and irises and pupils become such.

    sketch: Sketch. handles: LineHandles of the model's template. model: any ShapeModel. settings: NamingSettings. see:
    gives a network's face of the same topology with its camera, as ``see_sketch`` does, or None. read: tells what a
    network reads, as ``read_strokes`` does, or None.
    Returns the Sketch with names; strokes of no curve stay as they were.
    """
    nameless = NamelessStrokes.of(with_own_names(sketch, handles), read)
    if not nameless.numbers:
        return nameless.sketch
    mean = model.decode_points(model.prior.mean, handles.vertices)
    laid = _laid_over(nameless, handles, mean)
    # One size for all, so that costs compare.
    unit = float(np.median([np.linalg.norm(np.ptp(own, axis=0)) for own in laid]))
    faces = [] if see is None else [see(nameless.sketch)]
    with suppress(InputError):
        faces.append(fit_lines(lines_by_curve(nameless.told), handles, model, _QUICK))
    seen = [_own(face, handles) for face in faces]
    starts = [_likeliest([_Naming(nameless, handles, own, unit, settings) for own in laid])]
    starts += [_Naming(nameless, handles, own, unit, settings) for own in seen]
    best = _best([start.settled(handles, model, unit).by_parts(seen, handles, model, unit) for start in starts])
    return rejoined(best.named(), sketch)


def _laid_over(nameless: NamelessStrokes, handles: LineHandles, mean: np.ndarray) -> list[np.ndarray]:
    """(H, 2) pixels of the handles of a face (H, 3), where enough strokes have names for the camera that these tell, or
    else for all that the others may be."""
    with suppress(InputError):
        return [line_camera(lines_by_curve(nameless.sketch), handles, mean).project(mean)]
    return faces_over([stroke.points for stroke in nameless.strokes], handles, mean)


def _own(face: Face, handles: LineHandles) -> np.ndarray:
    """(H, 2) pixels of the handles of a face with a camera."""
    return face.require_camera().project(face.vertices[handles.vertices])


def _with_rows(own: np.ndarray, rows: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(H, 2) with some rows of another."""
    mixed = own.copy()
    mixed[rows] = other[rows]
    return mixed


def _likeliest(namings: Sequence["_Naming"]) -> "_Naming":
    """Of several the cheapest, or one that names all strokes for hardly more: that one stroke fits well is no reason to
    leave all others where a face has room for every one."""
    floor = namings[0].floor
    dearest = _NEARLY * (min(each.cost for each in namings) - floor)
    return min(namings, key=lambda each: (each.cost - floor > dearest, not each.complete, each.cost))


def _best(namings: Sequence["_Naming"]) -> "_Naming":
    """The first, or one after it that costs less and finds curves for nearly as long strokes: for short ones alone,
    beside an outline that is left, is no better."""
    best, *others = namings
    for other in others:
        if other.cost < best.cost and other.length > _NEARLY_ALL * best.length:
            best = other
    return best


class _Naming:
    """What the strokes of a sketch draw of a face that lies somewhere. cost: sum over those that do not name it, below
    zero where they draw what a network finds likely."""

    def __init__(
        self, nameless: NamelessStrokes, handles: LineHandles, own: np.ndarray, unit: float, settings: NamingSettings
    ) -> None:
        """own: (H, 2) pixels of the handles. unit: pixels, diagonal of a face."""
        self.nameless = nameless
        self.own = own
        self.sketch = nameless.sketch
        self.settings = settings
        self.candidates = candidates_at(handles, own)
        self.numbers = nameless.numbers
        self.costs = stroke_costs(nameless.shapes, self.candidates, unit, settings)
        surprise = settings.unlikely * nameless.surprise([each.names for each in self.candidates])
        self.costs.whole[:] += surprise
        self.costs.part[:] += surprise
        names = [each.names[0] for each in self.candidates]
        unlikely = np.outer(nameless.mirrored, [name.startswith(MIDDLE) for name in names])
        self.costs.whole[unlikely] = np.inf
        along = np.array([name == PIECED for name in names]) & (self.costs.part <= _ALONG)
        self.costs.part[unlikely & ~along] = np.inf
        self._keep_eyes(nameless.eyes)
        taken = {stroke.curve for stroke in self.sketch.strokes}
        self.blocked = np.array([not taken.isdisjoint(each.names) for each in self.candidates])
        self.seldom = settings.seldom * np.array([each.names[0].startswith(SELDOM) for each in self.candidates])
        self.chosen: dict[int, Candidate] = {}
        self.cost = self._assign()
        self._put_in_order(_APART * unit)
        self._let_none_stand_alone()
        self._continue(nameless.shapes.lengths)
        self._find_outline()

    def settled(self, handles: LineHandles, model: ShapeModel, unit: float) -> "_Naming":
        """What strokes draw of a face of the model that follows the names, again and again, while that costs less."""
        best = self
        for _ in range(self.settings.rounds):
            try:
                face = fit_lines(lines_by_curve(best.named()), handles, model, _QUICK)
            except InputError:
                break
            again = _Naming(self.nameless, handles, _own(face, handles), unit, self.settings)
            if again.cost > best.cost:
                break
            best = again
        return best

    def by_parts(self, seen: Sequence[np.ndarray], handles: LineHandles, model: ShapeModel, unit: float) -> "_Naming":
        """What strokes draw of a face whose parts lie where a network sees them, and whose mouth where strokes are left
        below the nose, each where that costs less: on caricatures parts may be far from where a face has them. Where
        all strokes draw a curve, nothing is moved.

        seen: (H, 2) pixels of the handles of the network's face, if there is one.
        """
        if self.complete:
            return self
        best = self
        for part in PARTS:
            rows = handles.rows_of(part)
            laid = [_with_rows(best.own, rows, own) for own in seen]
            if part == MOUTH:
                laid += mouths_over(best._left(), best.own, handles)
            trials = [_Naming(self.nameless, handles, own, unit, self.settings) for own in laid]
            # Halves of irises are no lids where these are left instead.
            whole = [each for each in trials if each.length >= best.length]
            best = min([best, *whole], key=lambda each: each.cost)
        return self if best is self else best.settled(handles, model, unit)

    def _left(self) -> list[np.ndarray]:
        """(N, 2) pixels of strokes that draw no curve, or a lip."""
        numbers = [n for n in self.numbers if n not in self.chosen or self.chosen[n].names[0].startswith(MOUTH)]
        return [self.sketch.strokes[number].points for number in numbers]

    def _keep_eyes(self, eyes: np.ndarray) -> None:
        """Let strokes (S,) bool that go around an iris draw an eye, the nearer one, however much larger they are."""
        lids = np.array([each.loop and each.names[0].startswith("eye") for each in self.candidates])
        eyes = eyes & np.isfinite(self.costs.whole[:, lids]).all(1)
        if not eyes.any() or not lids.any():
            return
        self.costs.whole[np.outer(eyes, ~lids)] = np.inf
        self.costs.part[eyes] = np.inf
        drawn = np.ix_(eyes, lids)
        dearest = float(self.costs.whole[drawn].max())
        self.costs.whole[drawn] *= min(1.0, _SURELY * self.settings.dearest / dearest)

    @property
    def floor(self) -> float:
        """What it costs at least, from which shares of a cost count."""
        return self.settings.unlikely * self.nameless.most_likely

    @property
    def length(self) -> float:
        """Pixels of all strokes that draw a curve."""
        return sum(self.sketch.strokes[number].length for number in self.chosen)

    @property
    def complete(self) -> bool:
        """Whether every stroke that may draw a curve draws one."""
        return len(self.chosen) == len(self.numbers)

    def named(self) -> Sketch:
        """The sketch with the names, and with two strokes for every one that is a loop."""
        strokes: list[Stroke] = []
        for number, stroke in enumerate(self.sketch.strokes):
            candidate = self.chosen.get(number)
            if candidate is None:
                strokes.append(stroke)
            elif candidate.loop:
                strokes += split_ring(stroke, candidate)
            else:
                strokes.append(replace(stroke, curve=candidate.names[0], kind=candidate.kind))
        return self.sketch.with_strokes(strokes)

    def _assign(self) -> float:
        """Give every stroke one candidate or none; returns the sum of the costs. Where a loop is drawn, its two curves
        are not drawn as well; without loops, if that costs less."""
        loops = np.array([each.loop for each in self.candidates])
        blocked = self.blocked
        pairs, total = self._pairs(blocked)
        rings = {name for _, c in pairs for name in self.candidates[c].names if loops[c]}
        if rings:
            drawn = np.array([not each.loop and each.names[0] in rings for each in self.candidates])
            pairs, total, blocked = min(
                ((*self._pairs(also), also) for also in (blocked | drawn, blocked | loops)), key=lambda way: way[1]
            )
        pairs, total = self._with_pieces(pairs, total, blocked)
        for s, c in pairs:
            self.chosen[self.numbers[s]] = self.candidates[c]
        return total

    def _pairs(self, blocked: np.ndarray, but: Collection[int] = ()) -> tuple[list[tuple[int, int]], float]:
        """Strokes, without some, and candidates of the least sum of costs. blocked: (C,) bool."""
        dearest = self.settings.dearest
        strokes = [s for s in range(len(self.numbers)) if s not in but]
        costs = np.where(blocked, np.inf, self.costs.whole + self.seldom)[strokes]
        count = len(costs)
        table = np.concatenate([np.minimum(costs, 10 * dearest), np.full((count, count), dearest)], axis=1)
        rows, columns = linear_sum_assignment(table)
        pairs = [(s, c) for s, c in zip(rows.tolist(), columns.tolist(), strict=True) if c < costs.shape[1]]
        return [(strokes[s], c) for s, c in pairs if costs[s, c] < dearest], float(table[rows, columns].sum())

    def _with_pieces(
        self, pairs: list[tuple[int, int]], total: float, blocked: np.ndarray
    ) -> tuple[list[tuple[int, int]], float]:
        """Pairs of strokes and candidates, and the sum of their costs, where several strokes may draw a nose, one after
        the other, when all together cost less so. pairs, total: without that, as ``_pairs`` gives them."""
        nose = next((c for c, each in enumerate(self.candidates) if each.names == (PIECED,)), None)
        pieces: list[int] = []
        while nose is not None and len(pieces) < _PIECES:
            part = self.costs.part[:, nose] + self.settings.seldom
            gains = {s: self.costs.whole[s, c] + self.seldom[c] - part[s] for s, c in pairs if c != nose}
            trials = []
            along = [s for s, gain in gains.items() if gain > 0 and self.costs.part[s, nose] < _ALONG]
            for s in sorted(along, key=lambda s: -gains[s])[:_TRIALS]:
                others, rest = self._pairs(blocked, {*pieces, s})
                if self._share([t for t, c in others if c == nose], [*pieces, s], nose):
                    trials.append((rest + float(part[[*pieces, s]].sum()), s, others))
            if not trials or min(trials)[0] >= total:
                break
            total, piece, pairs = min(trials)
            pieces.append(piece)
        return pairs + [(s, nose) for s in pieces if nose is not None], total

    def _share(self, whole: list[int], pieces: list[int], c: int) -> bool:
        """Whether strokes draw a candidate, and each of some others a piece of it where no other does."""
        drawn = np.zeros((len(self.numbers), self.candidates[c].line.shape[0]), bool)
        for s in whole + pieces:
            drawn[s, self.costs.nearest[s, c]] = True
        twice = drawn.sum(0) > 1
        covered = max(float(twice[self.costs.nearest[s, c]].mean()) for s in pieces)
        return bool(whole) and covered < self.settings.covered

    def _put_in_order(self, least: float) -> None:
        """Let strokes that lie one below the other draw such curves. least: pixels that are clearly below."""
        single = {each.names[0]: each for each in self.candidates if not each.loop}
        numbers = {each.names[0]: number for number, each in self.chosen.items() if not each.loop}
        lines = {name: self.sketch.strokes[number].points for name, number in numbers.items()}
        for name, right in names_in_order(lines, least).items():
            self.chosen[numbers[name]] = single[right]

    def _let_none_stand_alone(self) -> None:
        """Let what would be drawn beside a curve that is not drawn draw that curve, if it may."""
        single = {each.names[0]: c for c, each in enumerate(self.candidates) if not each.loop}
        drawn = {name for each in self.chosen.values() for name in each.names}
        drawn |= {stroke.curve for stroke in self.sketch.strokes if stroke.curve is not None}
        for number, each in self.chosen.items():
            other = ALONE.get(each.names[0])
            if other not in single or other in drawn:
                continue
            if self.costs.whole[self.numbers.index(number), single[other]] < self.settings.dearest:
                self.chosen[number] = self.candidates[single[other]]

    def _continue(self, lengths: np.ndarray) -> None:
        """Let strokes that are left continue what others draw, the longest first. lengths: (S,) pixels."""
        drawn = np.zeros((len(self.candidates), self.candidates[0].line.shape[0]), bool)
        for s, number in enumerate(self.numbers):
            if number in self.chosen:
                c = self.candidates.index(self.chosen[number])
                drawn[c, self.costs.nearest[s, c]] = True
        for s in sorted(range(len(self.numbers)), key=lambda s: -lengths[s]):
            if self.numbers[s] in self.chosen:
                continue
            covered = np.take_along_axis(drawn, self.costs.nearest[s], 1).mean(1)
            free = (covered < self.settings.covered) & drawn.any(1) & ~self.blocked
            costs = np.where(free, self.costs.part[s], np.inf)
            c = int(costs.argmin())
            if costs[c] < self.settings.piece:
                self.chosen[self.numbers[s]] = self.candidates[c]
                drawn[c, self.costs.nearest[s, c]] = True

    def _find_outline(self) -> None:
        """Let a stroke that is left and goes around all features be the outline, where none is."""
        c = next((c for c, each in enumerate(self.candidates) if each.names == (SILHOUETTE,)), None)
        drawn = {name for each in self.chosen.values() for name in each.names}
        if c is None or self.blocked[c] or SILHOUETTE in drawn:
            return
        strokes = self.sketch.strokes
        names = {number: stroke.curve for number, stroke in enumerate(strokes) if stroke.curve is not None}
        names |= {number: each.names[0] for number, each in self.chosen.items()}
        inner = [strokes[number].points for number, name in names.items() if not name.startswith(BESIDE)]
        may = np.isfinite(self.costs.part[:, c])
        left = [number for s, number in enumerate(self.numbers) if number not in self.chosen and may[s]]
        number = find_outline([strokes[number].points for number in left], inner)
        if number is not None:
            self.chosen[left[number]] = self.candidates[c]

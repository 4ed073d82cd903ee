"""The 52 expressions of the open head, with lids and lips that stop where they meet."""

from dataclasses import astuple, dataclass
from functools import cache

import numpy as np

from caricli.geometry.deformation.deformation_transfer import DeformationTransfer
from caricli.geometry.repair.contact_pairs import closes, touching_pairs
from caricli.geometry.repair.contact_solver import Conditions, ContactSolver
from caricli.io.kept import kept_arrays
from caricli.methods.rig.expression_templates import ExpressionTemplates, contact_normals
from caricli.template.head import Head, load_head
from caricli.template.head_parts import part_lips
from caricli.template.template import Template

BLINKS = ("eyeBlinkLeft", "eyeBlinkRight")

SEALED = ("mouthPressLeft", "mouthPressRight", "cheekPuff")
"""Actions of lips that stay as near to each other as at rest, as ARKit means them: the base mesh parts them."""


@dataclass(frozen=True)
class MendSettings:
    """How the open head's own expressions are mended.

    blink: weight at which the head's blinks are taken, because the lids close there; all others are taken whole.
    touch: metres that lips which lie on each other keep apart.
    noticed: metres; a pair that the mending parts by less was sound.
    """

    blink: float = 0.8
    touch: float = 2e-4
    noticed: float = 5e-5


@cache
def open_head_expressions() -> ExpressionTemplates:
    """The expressions of the open head in its usual shape, mended once."""
    head = load_head()
    return head_expressions(head, head.template())


def head_expressions(head: Head, template: Template) -> ExpressionTemplates:
    """The 52 expressions of the open head, its lids and lips stopped where they meet.

    The head's blinks close the lids at about 0.8, sooner at the outer than at the inner corner, and pierce beyond: at
    that strength the margins are brought together. Elsewhere lips that push through each other are held apart, and
    those of ``SEALED`` actions together. They part for the tongue that comes out.

    template: Template of its neutral face.
    """
    settings = MendSettings()
    raw = ExpressionTemplates(head.action_names, template, head.actions.astype(float))
    curves = [
        template.annotation.curves[f"eye_{lid}_{side}"] for lid in ("upper", "lower") for side in ("left", "right")
    ]
    given = ("\n".join(raw.names), template.vertices, template.faces, head.actions, *curves, *astuple(settings))
    mended = kept_arrays("expressions", given, lambda: {"deltas": _mend(raw, template, settings)})
    return ExpressionTemplates(raw.names, template, mended["deltas"])


def _mend(raw: ExpressionTemplates, template: Template, settings: MendSettings) -> np.ndarray:
    """(K, V, 3) metres."""
    margins = _Margins(raw, template, settings)
    deltas = np.zeros_like(raw.deltas)
    for k, name in enumerate(raw.names):
        moved = (settings.blink if name in BLINKS else 1.0) * raw.deltas[k]
        deltas[k] = moved + margins.correction(name, raw.start(k) - raw.neutral, moved)
    if "tongueOut" in raw.names:
        deltas[raw.names.index("tongueOut")] += part_lips(raw.names, deltas)
    return deltas


class _Margins:
    """Pairs of vertices of lids and lips that meet, and the solver that keeps them from passing each other."""

    def __init__(self, raw: ExpressionTemplates, template: Template, settings: MendSettings):
        curves = template.annotation.curves
        groups = {
            side: np.stack([curves[f"eye_{lid}_{side}"][1:-1] for lid in ("upper", "lower")], 1)
            for side in ("left", "right")
        }
        groups["lips"] = touching_pairs(raw.neutral, raw.faces, raw.reach)
        self.raw = raw
        self.settings = settings
        self.pairs = np.concatenate([*groups.values()])
        self.kinds = np.repeat([*groups], [len(rows) for rows in groups.values()])
        self.solver = ContactSolver(DeformationTransfer(raw.neutral, raw.faces, raw.still), self.pairs)
        self.normals = contact_normals(raw.mesh, self.pairs, raw.reach)
        self.offsets = self._between(raw.neutral)
        gaps = (self.offsets * self.normals).sum(1)
        self.floors = np.minimum(gaps, settings.touch) - gaps
        # Margins of lids meet in a line; lips lie on each other, and what is between their vertices sideways stays.
        self.met = np.where(self.kinds[:, None] == "lips", self.floors[:, None] * self.normals, -self.offsets)

    def correction(self, name: str, start: np.ndarray, moved: np.ndarray) -> np.ndarray:
        """What an action has to do besides, (V, 3), so that lids and lips stop where they meet.

        start, moved: (V, 3) displacements of what it starts from and its own.
        """
        closed = np.array([name.lower() == f"eyeblink{kind}" for kind in self.kinds])
        # mouthClose alone pushes the lips through each other: it undoes an opening that is not there.
        if name == "mouthClose":
            closed = self._closing(start, start + moved) & (self.kinds == "lips")
        met = self.met
        if name in SEALED:
            closed = self.kinds == "lips"
            met = self._between(moved)
            met = met - (met * self.normals).sum(1, keepdims=True) * self.normals
        solved = self.solver.solve(start + moved, Conditions(closed, met, self.normals, self.floors))
        correction = solved - start - moved
        # What the condition moves apart or together, and what the action moves by itself; the rest of the head stays.
        parted = np.linalg.norm(self._between(correction), axis=1) > self.settings.noticed
        seeds = (np.abs(start + moved) > self.raw.settings.still * self.raw.mesh.height).any(1)
        seeds[self.pairs[parted]] = True
        return self.raw.fade(seeds)[:, None] * correction

    def _closing(self, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        """(P,) bool: pairs that come together from one displacement (V, 3) to another."""
        then, now = (np.linalg.norm(self.offsets + self._between(moved), axis=1) for moved in (before, after))
        return closes(then, now, self.raw.reach)

    def _between(self, values: np.ndarray) -> np.ndarray:
        """(P, 3) differences of (V, 3) over pairs."""
        return values[self.pairs[:, 0]] - values[self.pairs[:, 1]]

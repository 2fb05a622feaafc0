"""Kinds of physics, and which of them may be looked at while a program is developed, and which are scored.

The rule: a kind that an earlier generator of this project had in the same form, or that anybody has looked at case by case,
is `looked_at`: in the group `develop`. Every other kind is scored. A kind that is looked at after a page is marked before the
next one, for which at least a third of the scored kinds are new.
"""
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .effect import Effect

NAMELESS = ("unnamed", "undecidable")


@dataclass(frozen=True)
class Kind:
    """A kind of physics in one of its forms; the family is the catalogue's, or "" where no name is right."""

    name: str
    form: str
    family: str
    # Of a campaign and an axis, or of a pair.
    make: Callable[..., Effect]
    source: str
    looked_at: bool
    # Names that are right on what the effect acts on, each alone or a set of them; absent: its own.
    right: tuple[str, ...] = ()

    def truth(self, effect: Effect, size: float, strength: float, left_nt: float) -> dict[str, Any]:
        names = self.right or (self.name,) * bool(self.family)
        return dict(kind=self.name, form=self.form, family=self.family, source=self.source, strength=strength,
                    right=[(name, target) for name in names for target in effect.on], undecidable=self.name == "undecidable", left_nt=left_nt,
                    parameters={k: v * size if k.endswith("nt") or "_nt_per" in k else v for k, v in effect.truth.items()})


def of_group(kinds: list[Kind], of: str, sort: str) -> list[Kind]:
    """Those of the group `develop` or `score`: unnamed, undecidable, or those that have a name."""
    own = [kind for kind in kinds if kind.looked_at == (of == "develop")]
    return [kind for kind in own if (kind.name == sort if sort in NAMELESS else kind.name not in NAMELESS)]

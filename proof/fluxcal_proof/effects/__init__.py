"""Kinds of physics, family by family."""
from . import follows, late, own_field, surroundings, times, unnamed

KINDS = [*late.KINDS, *follows.KINDS, *own_field.KINDS, *surroundings.KINDS, *times.KINDS, *unnamed.KINDS]

"""Kinds of physics, family by family; to import this package fills the table of kinds."""
from . import late as late
from . import follows as follows
from . import own_field as own_field
from . import surroundings as surroundings
from . import times as times
from . import unnamed as unnamed
from . import undecidable as undecidable

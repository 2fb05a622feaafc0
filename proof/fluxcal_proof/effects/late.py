"""Late responses to the field: loops, filters, clocks, eddy currents."""
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from .. import response
from ..campaign import AXES, Campaign, Parts, Run
from ..effect import Draw, Effect, drawn, in_geo, one_sensor
from ..groups import Kind
from ..response import Response

FAMILY = "late_response"
LOOP = ("loop_bandwidth", "delay")


def loop(c: Campaign, axis: int, of: Callable[..., Response], draws: Sequence[Draw] = ()) -> Effect:
    """The reading follows its field through a response, coil by coil, whose time is the size, in hundredths of a step."""
    numbers = drawn(c, draws)

    def act(size: float) -> Parts:
        what = of(0.01 * c.step * size, *numbers)
        slow = lambda run: c.mu[:, axis] @ run.turn @ c.eta @ c.along(run, through=lambda _, x: x.through(what))
        return one_sensor(c, axis, lambda x: slow(x.run) - x.nt)

    return Effect(act, (AXES[axis],))


def shifted(c: Campaign, seconds: Callable[[Run], np.ndarray | float]) -> Effect:
    """Readings taken at another time than is written; a held drive is set after a reading, so that a late one misses it."""
    return Effect(lambda size: [c.plain(run, run.at - seconds(run) * size) - c.plain(run) for run in c.runs])


def clock(c: Campaign, axis: int, early: bool = False) -> Effect:
    """Off in one recording, or in all until it is set."""
    number, sign = int(c.rng.choice([run.number for run in c.runs if not run.held])), c.rng.choice([-1, 1])
    return shifted(c, lambda run: sign * 0.01 * c.step * (run.number <= number if early else run.number == number))


def quartz(c: Campaign, axis: int) -> Effect:
    bend = c.rng.uniform(0, 0.2)

    def seconds(run: Run) -> np.ndarray:
        t = run.at - c.runs[0].at[0]
        return 1e-6 * (t + bend * c.length * (t / (2 * c.length)) ** 2)

    return shifted(c, seconds)


def eddy(c: Campaign, axis: int, of: Callable[[float], Response], steps: tuple[float, float]) -> Effect:
    """Metal about one coil keeps back a share of its changes, dB_c = -s (B_c - what B_c), its time between so many steps."""
    what = of(c.step * c.rng.uniform(*steps))
    less = replace(what, direct=what.direct - 1)
    change = lambda k, x: x.through(less).times(1e-3 if k == axis else 0.0)
    return in_geo(c, lambda run: c.eta @ (c.along(run, through=change) - c.bias[:, None]), AXES[axis])


KINDS = [Kind(*row) for row in [
    ("loop_bandwidth", "one pole", FAMILY, partial(loop, of=response.relaxation), "Primdahl 1979, J. Phys. E 12, 241", True, LOOP),
    ("delay", "filter of a converter", FAMILY, partial(loop, of=response.late), "Oppenheim and Schafer 1989, Discrete-Time Signal Processing", True, LOOP),
    ("loop_bandwidth", "two unlike poles", FAMILY, partial(loop, of=lambda tau, ratio: response.poles([tau, ratio * tau]), draws=[(0.2, 0.7)]),
     "Auster et al. 2008, Space Sci. Rev. 141, 235", True, LOOP),
    ("loop_bandwidth", "three poles", FAMILY, partial(loop, of=lambda tau: response.poles([tau, 0.8 * tau, 0.6 * tau])),
     "Oppenheim and Schafer 1989, Discrete-Time Signal Processing: a cascade of RC filters", True, LOOP),
    ("loop_bandwidth", "damped second order", FAMILY, partial(loop, of=response.damped, draws=[(0.6, 0.95)]),
     "Franklin, Powell and Emami-Naeini, Feedback Control of Dynamic Systems", True, LOOP),
    ("clock_offset", "one recording", FAMILY, clock, "INTERMAGNET Technical Reference Manual", True),
    ("clock_rate", "quartz with a temperature coefficient", FAMILY, quartz, "Vig 1992, Introduction to Quartz Frequency Standards", True,
     ("clock_rate", "clock_offset")),
    ("delay", "all-pass section", FAMILY, partial(loop, of=lambda tau: Response(-1.0, np.array([2.0]), np.array([tau]))),
     "Oppenheim and Schafer 1989: (1 - s tau) / (1 + s tau), an equaliser of delay", False, LOOP),
    ("clock_offset", "until it was set", FAMILY, partial(clock, early=True), "RFC 5905: a clock that is stepped", False),
    ("eddy_currents", "cylinder", FAMILY, partial(eddy, of=response.cylinder, steps=(2, 25)), "Knoepfel 2000, Magnetic Fields, 4.2", False),
    ("eddy_currents", "plate", FAMILY, partial(eddy, of=response.plate, steps=(2, 25)),
     "Carslaw and Jaeger 1959, Conduction of Heat in Solids, 3.4", True),
    ("eddy_currents", "sphere", FAMILY, partial(eddy, of=response.sphere, steps=(2, 25)),
     "Wait 1951, Geophysics 16, 666: a conducting sphere in a field that changes", False),
]]

"""Effects injected into real recordings: physics from published equations, acting in what was recorded.

Fields between readings are cubic splines through them, temperatures straight lines. Several members act in a form a
little finer than the catalogue's equation (two poles, two bodies, a ring after a spike), so that a name is not right
for the sake of an equation that both sides share. Equations and sources stand with each member.
"""
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from .hosts import Host
from .series import AXES

STRENGTHS = (3.0, 1.0, 10.0, 0.3)  # times the scatter of the host
CLOSE = 0.1  # accepted departure from the wanted strength
LEAST_LEFT = 0.05  # of the changes of an effect a fresh calibration must leave so much
LEAST_ALONG = 0.1  # of the field, in the sensor, where the length alone is seen
MOST_NT = 60_000.0  # the most that may be added to a reading
TRIES = 12
DAY_S = 86_400.0


@dataclass
class Effect:
    """What is added by a size, and what the catalogue's parameters should then be."""

    act: Callable[[float], np.ndarray]  # rows × 3, nT
    parameters: Callable[[float], dict[str, float]] = lambda size: {}
    also: tuple[str, ...] = ()  # other names that are right
    sensor: int | None = None  # None: all


class Member(NamedTuple):
    family: str
    needs: set[str]
    make: Callable[[Host, np.random.Generator], Effect]


class Injection(NamedTuple):
    document: dict
    truth: dict
    untouched: dict


MEMBERS: dict[str, Member] = {}


def member(family: str, *needs: str) -> Callable:
    """Adds what follows to the table, under its name."""
    def add(make: Callable[[Host, np.random.Generator], Effect]) -> Callable:
        MEMBERS[make.__name__] = Member(family, set(needs), make)
        return make
    return add


def in_sensor(host: Host, rng: np.random.Generator, act: Callable[[int], Callable[[float], np.ndarray]],
              parameters: Callable[[float], dict[str, float]] = lambda size: {}, also: tuple[str, ...] = ()) -> Effect:
    """In one sensor, drawn; `act` makes of a sensor what a size adds to it."""
    sensor = int(rng.integers(3))
    of_size = act(sensor)
    return Effect(lambda size: np.outer(of_size(size), np.eye(3)[sensor]), parameters, also, sensor)


def shaped(host: Host, rng: np.random.Generator, shape: np.ndarray, **further: object) -> Effect:
    """In one sensor, in proportion to a shape of the rows."""
    return in_sensor(host, rng, lambda sensor: lambda size: size * shape, **further)


def relaxed(t: np.ndarray, x: np.ndarray, tau: float) -> np.ndarray:
    """τ dy/dt = x − y, exact for x straight between rows; at rest in the first row."""
    y = np.array(x, float)
    step = np.diff(t)
    decay = np.exp(-step / tau)
    for row, (h, e) in enumerate(zip(step, decay)):
        slope = (x[row + 1] - x[row]) / h
        y[row + 1] = x[row + 1] - slope * tau + (y[row] - x[row] + slope * tau) * e
    return y


def elapsed(host: Host) -> np.ndarray:
    return host.time_s - host.time_s[0]


def moved(host: Host, late_s: np.ndarray | float) -> np.ndarray:
    """The fields so much earlier, less the fields; held before the first reading."""
    t = np.clip(host.time_s - late_s, host.time_s[0], host.time_s[-1])
    return CubicSpline(host.time_s, host.fields)(t) - host.fields


def sample(host: Host) -> float:
    return float(np.median(np.diff(host.time_s)))


@member("late_response", "field")
def loop_bandwidth(host: Host, rng: np.random.Generator) -> Effect:
    """Two equal poles, τ in sum (Auster et al. 2008, Space Sci. Rev. 141, 235)."""
    def act(sensor: int) -> Callable[[float], np.ndarray]:
        b = host.fields[:, sensor]
        return lambda tau: relaxed(host.time_s, relaxed(host.time_s, b, tau / 2), tau / 2) - b
    return in_sensor(host, rng, act, lambda tau: {"lag_s": tau, "delay_s": tau}, ("delay",))


@member("late_response", "field")
def delay(host: Host, rng: np.random.Generator) -> Effect:
    """dB = B(t − d) − B(t) (Primdahl 1979, J. Phys. E 12, 241)."""
    return in_sensor(host, rng, lambda sensor: lambda d: moved(host, d)[:, sensor],
                     lambda d: {"delay_s": d, "lag_s": d}, ("loop_bandwidth",))


@member("late_response", "field")
def clock_offset(host: Host, rng: np.random.Generator) -> Effect:
    """dB = B(t − Δt) − B(t), all sensors (INTERMAGNET Technical Reference Manual)."""
    sign = rng.choice([-1, 1])
    return Effect(lambda s: moved(host, sign * s), lambda s: {"offset_s": sign * s})


@member("late_response", "field")
def clock_rate(host: Host, rng: np.random.Generator) -> Effect:
    """dB = B(t − r t) − B(t), all sensors; the quartz warms, r grows by a tenth (Vig 1992, quartz standards)."""
    t = elapsed(host)
    return Effect(lambda ppm: moved(host, 1e-6 * ppm * t * (0.95 + 0.1 * t / t[-1])), lambda ppm: {"rate_ppm": ppm})


@member("late_response", "pair")
def induction_difference(host: Host, rng: np.random.Generator) -> Effect:
    """dB = C (B − L), τ dL/dt = B − L, the vertical most (Parkinson 1959, Geophys. J. 2, 1)."""
    tau = np.ptp(host.time_s) * rng.uniform(0.01, 0.1)
    fast = host.fields - np.column_stack([relaxed(host.time_s, b, tau) for b in host.fields.T])
    c = rng.normal(size=(3, 3)) * np.array([0.2, 0.2, 1.0])
    return Effect(lambda size: size * fast @ c, lambda size: {"time_constant_s": tau})


def warmth(host: Host, column: str) -> np.ndarray:
    return host.series[column] - host.series[column].mean()


def of_temperature(name: str, column: str, late: bool) -> None:
    """dB = c (T − T_ref), T the column or late by a relaxation of two bodies (NASA CR-156638, eq. 29)."""
    def make(host: Host, rng: np.random.Generator) -> Effect:
        t, fixed = warmth(host, column), {}
        if late:
            fixed["lag_s"] = tau = np.ptp(host.time_s) * rng.uniform(0.03, 0.2)
            t = 0.9 * relaxed(host.time_s, t, tau) + 0.1 * relaxed(host.time_s, t, 0.2 * tau)
        else:
            t = t * (1 + 0.02 * t / np.abs(t).max())
        return shaped(host, rng, t, parameters=lambda c: {"coefficient_nt_per_k": c, **fixed})
    MEMBERS[name] = Member("follows_column", {column}, make)


of_temperature("offset_temperature", "sensor_temperature_c", late=False)
of_temperature("offset_temperature_lag", "sensor_temperature_c", late=True)
of_temperature("offset_electronics_temperature", "electronics_temperature_c", late=False)
of_temperature("offset_electronics_temperature_lag", "electronics_temperature_c", late=True)


@member("own_field", "drive")
def hysteresis(host: Host, rng: np.random.Generator) -> Effect:
    """Eight plays side by side, y = max(x − r, min(x + r, y)) (Krasnosel'skii and Pokrovskii 1989)."""
    def act(sensor: int) -> Callable[[float], np.ndarray]:
        x = host.fields[:, sensor]
        total = np.zeros(len(x))
        for r in np.ptp(x) * np.linspace(0.02, 0.16, 8):
            y = x[0]
            for row, value in enumerate(x):
                y = max(value - r, min(value + r, y))
                total[row] += (y - value) / (8 * r)
        return lambda size: size * total
    return in_sensor(host, rng, act)


@member("time")
def warm_up(host: Host, rng: np.random.Generator) -> Effect:
    """dB = a exp(−t/τ), with a tenth of it in a quicker body (Jankowski and Sucksdorff 1996, IAGA Guide)."""
    tau = np.ptp(host.time_s) * rng.uniform(0.05, 0.25)
    shape = 0.9 * np.exp(-elapsed(host) / tau) + 0.1 * np.exp(-elapsed(host) / (0.2 * tau))
    return shaped(host, rng, shape, parameters=lambda a: {"amplitude_nt": a, "time_constant_s": tau})


@member("time")
def ageing(host: Host, rng: np.random.Generator) -> Effect:
    """dB = b t, a tenth slower at the end than at the beginning (NASA CR-156638, drift of offsets)."""
    t = elapsed(host)
    shape = (t - 0.05 * t**2 / t[-1]) / DAY_S
    return shaped(host, rng, shape, parameters=lambda b: {"rate_nt_per_day": b})


@member("time")
def reading_step(host: Host, rng: np.random.Generator) -> Effect:
    """dB = h from a moment on (Jankowski and Sucksdorff 1996)."""
    at = host.time_s[int(host.rows * rng.uniform(0.2, 0.8))]
    return shaped(host, rng, 1.0 * (host.time_s >= at), parameters=lambda h: {"height_nt": h, "time_s": at})


@member("time", "day")
def working_hours(host: Host, rng: np.random.Generator) -> Effect:
    """A field from 7 to 17 h, Monday to Friday, that comes and goes in half an hour (Lowes 2009, DC railways)."""
    moment = host.series.start_s + host.time_s
    hour, weekday = moment / 3600 % 24, (moment // DAY_S + 3) % 7
    on = np.clip((hour - 7) * 2, 0, 1) * np.clip((17 - hour) * 2, 0, 1) * (weekday < 5)
    v = rng.normal(size=3)
    return Effect(lambda size: size * np.outer(on, v / np.linalg.norm(v)))


@member("moments")
def spike(host: Host, rng: np.random.Generator) -> Effect:
    """One reading jumps, and rings by a tenth in the next (Jankowski and Sucksdorff 1996)."""
    row, shape = int(host.rows * rng.uniform(0.1, 0.9)), np.zeros(host.rows)
    shape[row:row + 2] = 1, -0.1
    return shaped(host, rng, shape, parameters=lambda h: {"height_nt": h, "time_s": host.time_s[row]})


@member("moments")
def dropout(host: Host, rng: np.random.Generator) -> Effect:
    """A channel holds its value for a while, of so many samples (Jankowski and Sucksdorff 1996)."""
    first = int(host.rows * rng.uniform(0.1, 0.6))

    def act(sensor: int) -> Callable[[float], np.ndarray]:
        readings = host.readings[:, sensor]
        held = np.arange(host.rows) >= first
        return lambda samples: (readings[first] - readings) * (held & (np.arange(host.rows) < first + 20 * samples))
    return in_sensor(host, rng, act, lambda samples: {"time_s": host.time_s[first]})


@member("moments", "quick")
def vehicle_pass(host: Host, rng: np.random.Generator) -> Effect:
    """A dipole m on a straight path: B = (3 (m·r) r / r⁵ − m / r³), r the way to the sensor (Jackson)."""
    at, d = host.time_s[int(host.rows * rng.uniform(0.2, 0.8))], sample(host) * rng.uniform(4, 12)
    along, across = np.linalg.qr(rng.normal(size=(3, 2)))[0].T
    r = np.outer((host.time_s - at) / d, along) + across
    m, length = rng.normal(size=3), np.linalg.norm(r, axis=1)[:, None]
    return Effect(lambda size: size * (3 * (r @ m)[:, None] * r / length**5 - m / length**3))


@member("lines")
def periodic_field(host: Host, rng: np.random.Generator) -> Effect:
    """One frequency of a machine near by, in all sensors (Jankowski and Sucksdorff 1996)."""
    hertz, v = 1 / (sample(host) * rng.uniform(5, 50)), rng.normal(size=3)
    wave = np.sin(2 * np.pi * hertz * host.time_s + rng.uniform(0, 2 * np.pi))
    return Effect(lambda size: size * np.outer(wave, v / np.linalg.norm(v)), lambda size: {"frequency_hz": hertz},
                  ("mains", "traction_power"))


@member("codes")
def quantisation(host: Host, rng: np.random.Generator) -> Effect:
    """dB = q round(M / q) − M (IEEE Std 1241)."""
    def act(sensor: int) -> Callable[[float], np.ndarray]:
        m = host.readings[:, sensor]
        return lambda q: q * np.round(m / q) - m
    return in_sensor(host, rng, act, lambda q: {"width_nt": q})


@member("codes", "field")
def differential_nonlinearity(host: Host, rng: np.random.Generator) -> Effect:
    """A bit of a converter with a wrong weight: so much more wherever it is set (IEEE Std 1241)."""
    def act(sensor: int) -> Callable[[float], np.ndarray]:
        m, period = host.readings[:, sensor], np.ptp(host.readings[:, sensor]) / rng.uniform(3, 8)
        bit = (m / period % 1 > 0.5) - 0.5
        return lambda size: size * bit
    return in_sensor(host, rng, act)


def shows(host: Host, added: np.ndarray) -> bool:
    """Whether a fresh calibration leaves enough of it, and it is no more than there can be."""
    if not np.isfinite(added).all() or np.abs(added).max() > MOST_NT:
        return False
    changes = added.std(axis=0).max()
    return changes > 0 and host.size_nt(added) >= LEAST_LEFT * changes


def sized(host: Host, effect: Effect, wanted_nt: float) -> float:
    """The size of which so much is left."""
    size = 1.0
    for _ in range(60):
        left = host.size_nt(effect.act(size))
        if abs(left / wanted_nt - 1) < 0.01:
            break
        size *= min(max(wanted_nt / max(left, 1e-12), 0.1), 10) ** 0.7
    return size


def inject(host: Host, name: str, strength: float, rng: np.random.Generator) -> Injection | None:
    """An effect of so many times the scatter of the host; None where it does not show, or cannot be reached."""
    along = np.abs(host.fields.mean(axis=0)) / np.linalg.norm(host.fields.mean(axis=0)) if host.kind == "scalar" else None
    wanted_nt = strength * host.scatter_nt
    for _ in range(TRIES):
        effect = MEMBERS[name].make(host, rng)
        if along is not None and effect.sensor is not None and along[effect.sensor] < LEAST_ALONG:
            continue
        size = sized(host, effect, wanted_nt)
        added = effect.act(size)
        if abs(host.size_nt(added) / wanted_nt - 1) < CLOSE and shows(host, added):
            return Injection(document(host, added), truth(host, name, effect, size, strength), host.document)
    return None


def document(host: Host, added: np.ndarray) -> dict:
    """The host's with something added to its readings; those that were read code by code are codes again, and what
    nothing was added to stays as it was printed."""
    code = host.code_nt or 1e-6
    sums = np.where(added == 0, host.readings, np.round(np.round((host.readings + added) / code) * code, 9))
    recording = host.document["recordings"][0]
    columns = recording["columns"] | {f"{host.quantity}_{axis}_nt": sums[:, k].tolist() for k, axis in enumerate(AXES)}
    return host.document | {"recordings": [recording | {"columns": columns}]}


def truth(host: Host, name: str, effect: Effect, size: float, strength: float) -> dict:
    """What is right. The length of a vector that points one way does not tell in which sensor something is: there the
    name is right on any of them and without one, and parameters that grow with the size say nothing."""
    names, own, twice = (name, *effect.also), effect.parameters(size), effect.parameters(2 * size)
    if host.kind == "scalar":
        accepted = [f"{one} {axis}".strip() for one in names for axis in ("", *AXES)]
        own = {key: value for key, value in own.items() if value == twice[key]}
    else:
        accepted = [one if effect.sensor is None else f"{one} {AXES[effect.sensor]}" for one in names]
    blind = host.kind == "scalar" or effect.sensor is None
    return {"host": host.name, "kind": host.kind, "family": MEMBERS[name].family, "member": name,
            "sensors": [] if blind else [AXES[effect.sensor]], "accepted": accepted,
            "parameters": {key: float(value) for key, value in own.items()}, "strength": strength,
            "left_nt": host.size_nt(effect.act(size)), "scatter_nt": host.scatter_nt}


def injections(hosts: list[Host], seed: int, number: int) -> list[Injection]:
    """Hosts by turns, each with its members in a drawn order, strengths by turns; rounds until there are enough, or
    until a whole round adds none."""
    found, rounds, added = [], 0, True
    while len(found) < number and added:
        orders = [np.random.default_rng([seed, rounds, k]) for k in range(len(hosts))]
        queues = [[str(name) for name in rng.permutation(host.suits)] for host, rng in zip(hosts, orders)]
        added = False
        for turn in range(max(map(len, queues))):
            for k, (host, rng, queue) in enumerate(zip(hosts, orders, queues)):
                if turn < len(queue) and len(found) < number:
                    one = inject(host, queue[turn], STRENGTHS[(turn + k + rounds) % len(STRENGTHS)], rng)
                    found += [one] if one else []
                    added |= one is not None
        rounds += 1
    return found

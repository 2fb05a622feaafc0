"""Effects injected into real recordings: physics from published equations, acting in what was recorded.

Fields between readings are cubic splines through them, temperatures straight lines. Most members are a little finer than the catalogue's
equation (two poles, two bodies, a ring after a spike): what is found is not what the finder itself would have added.
"""
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from .hosts import Host
from .series import AXES, DAY_S, relaxed

STRENGTHS = (3.0, 1.0, 10.0, 0.3)  # times the scatter of the host
CLOSE = 0.1  # accepted departure from the wanted strength
LEAST_LEFT = 0.05  # a fresh calibration leaves at least so much of the changes of an effect
LEAST_ALONG = 0.1  # least share of the field in the sensor, where the length alone is seen
MOST_NT = 60_000.0  # the most that may be added to a reading
TRIES = 12


class Effect(NamedTuple):
    """What a size s adds to the readings, nT (one column for a sensor, three for all), and what is then right."""

    family: str
    needs: set[str]  # of what a host has
    act: Callable[[float], np.ndarray]
    parameters: Callable[[float], dict[str, float]] = lambda s: {}
    also: tuple[str, ...] = ()  # other names that are right


class Injection(NamedTuple):
    """A document, what is true of it, and the document as it came."""

    document: dict
    truth: dict
    untouched: dict


def effects(host: Host, sensor: int, rng: np.random.Generator) -> dict[str, Effect]:
    """One of each member, with what is random in it drawn; t from the first row, b the field and m the readings of the sensor."""
    t, b, m, rows = host.time_s - host.time_s[0], host.fields[:, sensor], host.readings[:, sensor], np.arange(host.rows)
    span, step, row = t[-1], np.median(np.diff(t)), int(host.rows * rng.uniform(0.2, 0.8))
    tau, at, sign, vector, turns = span * rng.uniform(0.05, 0.25), host.time_s[row], rng.choice([-1, 1]), rng.normal(size=3), rng.uniform(3, 8)

    def moved(late_s: np.ndarray | float) -> np.ndarray:
        """The fields so much earlier, less the fields; held before the first reading."""
        return CubicSpline(t, host.fields)(np.clip(t - late_s, 0, span)) - host.fields

    def induced(s: float) -> np.ndarray:
        fast = host.fields - np.column_stack([relaxed(t, one, 0.3 * tau) for one in host.fields.T])
        return s * fast @ (vector[:, None] * [0.2, 0.2, 1.0])

    def two_bodies(x: np.ndarray) -> np.ndarray:
        return 0.9 * relaxed(t, x, tau) + 0.1 * relaxed(t, x, 0.2 * tau)

    def works(s: float) -> np.ndarray:
        moment = host.series.start_s + host.time_s
        return s * np.outer(np.clip(2 * (5 - np.abs(moment / 3600 % 24 - 12)), 0, 1) * ((moment // DAY_S + 3) % 7 < 5), vector)

    def passes(s: float) -> np.ndarray:
        along, across = np.linalg.qr(np.outer(vector, [1, 0]) + [[0, 1], [0, 0], [0, turns]])[0].T
        r = np.outer((host.time_s - at) / (2 * turns * step), along) + across
        length = np.linalg.norm(r, axis=1)[:, None]
        return s * (3 * (r @ vector)[:, None] * r / length**5 - vector / length**3)
    late, follows, time, moments, field = "late_response", "follows_column", "time", "moments", {"field"}
    both = lambda s: {"lag_s": s, "delay_s": s}  # noqa: E731
    members = {
        # Two equal poles of s in sum: Auster et al. 2008, Space Sci. Rev. 141, 235.
        "loop_bandwidth": Effect(late, field, lambda s: relaxed(t, relaxed(t, b, s / 2), s / 2) - b, both, ("delay",)),
        # δ = B(t − s) − B(t): Primdahl 1979, J. Phys. E 12, 241; of all sensors: INTERMAGNET Technical Reference Manual.
        "delay": Effect(late, field, lambda s: moved(s)[:, sensor], both, ("loop_bandwidth",)),
        "clock_offset": Effect(late, field, lambda s: moved(sign * s), lambda s: {"offset_s": sign * s}),
        # δ = B(t − r t) − B(t); r, s ppm, grows by a tenth as the quartz warms: Vig 1992, quartz frequency standards.
        "clock_rate": Effect(late, field, lambda s: moved(1e-6 * s * t * (0.95 + 0.1 * t / span)), lambda s: {"rate_ppm": s}),
        # δ = s C (B − L), τ dL/dt = B − L, the vertical most: Parkinson 1959, Geophys. J. 2, 1.
        "induction_difference": Effect(late, {"pair"}, induced, lambda s: {"time_constant_s": 0.3 * tau}),
        # δ = s exp(−t/τ), a tenth of it in a quicker body; s a day, slower by a tenth at the end; s from a moment on: Jankowski and
        # Sucksdorff 1996, IAGA Guide for Magnetic Measurements and Observatory Practice, as of steps, spikes and gaps below.
        "warm_up": Effect(time, set(), lambda s: s * (0.9 * np.exp(-t / tau) + 0.1 * np.exp(-5 * t / tau)),
                          lambda s: {"amplitude_nt": s, "time_constant_s": tau}),
        "ageing": Effect(time, set(), lambda s: s / DAY_S * (t - 0.05 * t**2 / span), lambda s: {"rate_nt_per_day": s}),
        "reading_step": Effect(time, set(), lambda s: s * (rows >= row), lambda s: {"height_nt": s, "time_s": at}),
        # A field from 7 to 17 h, Monday to Friday, that comes and goes in half an hour: Lowes 2009, Earth Planets Space 61, i.
        "working_hours": Effect(time, {"day"}, works),
        # One reading jumps, and the next rings by a tenth; a channel holds its value for 20 s samples.
        "spike": Effect(moments, set(), lambda s: s * ((rows == row) - 0.1 * (rows == row + 1)), lambda s: {"height_nt": s, "time_s": at}),
        "dropout": Effect(moments, set(), lambda s: (m[row] - m) * ((rows >= row) & (rows < row + 20 * s)), lambda s: {"time_s": at}),
        # A dipole p on a straight path, r the way to the sensor: 3 (p·r) r / r⁵ − p / r³: Jackson, Classical Electrodynamics.
        "vehicle_pass": Effect(moments, {"quick"}, passes),
        # One frequency of a machine near by; what it is an alias of is open.
        "periodic_field": Effect("lines", set(), lambda s: s * np.outer(np.sin(2 * np.pi * t / (3 * turns * step)), vector),
                                 lambda s: {"frequency_hz": 1 / (3 * turns * step)}, ("mains", "traction_power")),
        # δ = s round(M / s) − M; a bit of a wrong weight, s more wherever it is set: IEEE Std 1241.
        "quantisation": Effect("codes", set(), lambda s: s * np.round(m / s) - m, lambda s: {"width_nt": s}),
        "differential_nonlinearity": Effect("codes", field, lambda s: s * (m * turns / np.ptp(m) % 1 > 0.5)),
    }
    # δ = s (T − T_ref), a little bent, or late by two bodies: NASA CR-156638, eq. 29; Primdahl 1979.
    for name, column in (("offset_temperature", "sensor_temperature_c"), ("offset_electronics_temperature", "electronics_temperature_c")):
        if column in host.has:
            warm = host.series[column] - host.series[column].mean()
            members[name] = Effect(follows, {column}, lambda s, x=warm: s * (x + 0.02 * x**2 / np.abs(x).max()),
                                   lambda s: {"coefficient_nt_per_k": s})
            members[f"{name}_lag"] = Effect(follows, {column}, lambda s, x=warm: s * two_bodies(x),
                                            lambda s: {"coefficient_nt_per_k": s, "lag_s": tau})
    return {name: one for name, one in members.items() if one.needs <= host.has}


def inject(host: Host, name: str, strength: float, rng: np.random.Generator) -> Injection | None:
    """An effect of so many times the scatter of the host; None where it does not show there, or cannot be reached."""
    wanted_nt, along = strength * host.scatter_nt, np.abs(host.fields.mean(axis=0))
    for _ in range(TRIES):
        sensor = int(rng.integers(3))
        effect, size = effects(host, sensor, rng)[name], 1.0
        one = effect.act(size).ndim == 1

        def added(size: float) -> np.ndarray:
            return np.outer(effect.act(size), np.eye(3)[sensor]) if one else effect.act(size)
        for _ in range(20):  # what is left need not be in proportion to the size
            left_nt = host.size_nt(added(size))
            if abs(left_nt / wanted_nt - 1) < 0.1 * CLOSE:
                break
            size *= np.clip(wanted_nt / max(left_nt, 1e-12), 0.01, 100)
        nt = added(size)
        left_nt = host.size_nt(nt)
        sees = host.kind != "scalar" or not one or along[sensor] >= LEAST_ALONG * np.linalg.norm(along)
        shows = left_nt >= LEAST_LEFT * nt.std(axis=0).max() and np.abs(nt).max() <= MOST_NT
        if sees and shows and abs(left_nt / wanted_nt - 1) < CLOSE:
            truth = {"host": host.name, "kind": host.kind, "family": effect.family, "member": name, "strength": strength,
                     "left_nt": left_nt, "scatter_nt": host.scatter_nt, **right(host, name, effect, sensor if one else None, size)}
            return Injection(document(host, nt), truth, host.document)
    return None


def right(host: Host, name: str, effect: Effect, sensor: int | None, size: float) -> dict:
    """Sensors, names and parameters. The length of a vector that points one way does not tell in which sensor something is: there the
    name is right on any of them and without one, and parameters that grow with the size say nothing."""
    blind, own, twice = host.kind == "scalar", effect.parameters(size), effect.parameters(2 * size)
    sensors = [] if blind or sensor is None else [AXES[sensor]]
    targets = ["", *AXES] if blind else sensors or [""]
    return {"sensors": sensors, "accepted": [f"{one} {axis}".strip() for one in (name, *effect.also) for axis in targets],
            "parameters": {key: float(value) for key, value in own.items() if not blind or value == twice[key]}}


def document(host: Host, nt: np.ndarray) -> dict:
    """The host's with something added to its readings; those that were read code by code are codes again, and what nothing was added to
    stays as it was printed."""
    code = host.code_nt or 1e-6
    sums = np.where(nt == 0, host.readings, np.round(np.round((host.readings + nt) / code) * code, 9))
    recording = host.document["recordings"][0]
    columns = {f"{host.instrument}_{axis}_nt": column.tolist() for axis, column in zip(AXES, sums.T)}
    return host.document | {"recordings": [recording | {"columns": recording["columns"] | columns}]}


def suits(host: Host) -> list[str]:
    """The members of which a host has the inputs."""
    return list(effects(host, 0, np.random.default_rng(0)))


def injections(hosts: list[Host], seed: int, number: int) -> list[Injection]:
    """So many, if the hosts carry them: hosts by turns, each with its members in a drawn order, strengths by turns."""
    found, members = [], [suits(host) for host in hosts]
    for turn in range(10 * number):
        for k, host in enumerate(hosts):
            around, place = divmod(turn, len(members[k]))
            name = np.random.default_rng([seed, k, around]).permutation(members[k])[place]
            one = inject(host, str(name), STRENGTHS[(turn + k + around) % len(STRENGTHS)], np.random.default_rng([seed, k, around, place]))
            found += [one] if one else []
            if len(found) == number:
                return found
    return found

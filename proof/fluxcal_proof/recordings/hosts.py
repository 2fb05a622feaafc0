"""Real recordings at rest as hosts for injected effects, and effects that act in what was recorded.

Nobody chooses by what is found in them later: of each instrument that lay still, the quiet stretches that its notes name. Physics is from
published equations, most a little finer than the catalogue's; fields between readings are cubic splines, temperatures straight lines.
"""
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from ..basic import spanned
from ..plan import Case
from . import alone, lengths, pairs
from .by_hand import affine, least_squares, left, test
from .lengths import CONRAD_NT, NONE, VERNADSKY_NT
from .programs import AXES, DAY_S, TOML, Programs, Series, relaxed, rms

INJECTED, RECORDED, COUNT = 1_000_000, 2_000_000, 250  # numbers of cases from which on, and how many injections
STRENGTHS = (3.0, 1.0, 10.0, 0.3)  # times the scatter of the host
CLOSE = 0.1  # accepted departure from the wanted strength
LEAST_LEFT = 0.05  # a fresh calibration leaves at least so much of the changes of an effect
LEAST_ALONG = 0.1  # least share of the field in the sensor, where the length alone is seen
MOST_NT = 60_000.0  # the most that may be added to a reading
COBENZL_EARLY_S = 18.38  # what the LEMI stamps its minutes too early by: diffmag --correct-clock over twelve days
# By kind a column that tells it, the instrument, and what its field is known from.
KINDS = {"pair": ("test_x_nt", "test", "reference"), "scalar": ("reference_nt", "sensor", "sensor"), "ambient": ("ambient_x_nt", "sensor", "ambient"),
         "single": ("time_s", "sensor", "sensor")}


class Host:
    """A recording as a document, with what a calibration can take up of an effect that is added to it."""

    def __init__(self, name: str, series: Series, offset_nt: np.ndarray, code_nt: float) -> None:
        self.name, self.series, self.code_nt = name, series, code_nt
        self.rows, self.time_s = len(series), series.time_s
        self.kind, self.instrument, known = next((kind, *roles) for kind, (column, *roles) in KINDS.items() if column in series.frame)
        self.readings, field, procedure, conditions = series.vectors(self.instrument), series.vectors(known), "free_run", {}
        if self.kind == "single":  # what the field is nobody knows; its level is taken off by the offset
            offset_nt, field = -self.readings.mean(axis=0), 0 * self.readings
        self.fields = field + offset_nt * (self.kind == "scalar")
        calibration = {"sensors": {axis: {"offset_nt": nt} for axis, nt in zip(AXES, offset_nt)}}
        if self.kind == "pair":
            d_nt, *eta = least_squares(affine("reference")(series), self.readings)
            self.fields, procedure = field @ np.array(eta), "differential"
            calibration = {"differential": {"matrix": np.array(eta).tolist(), "offset_nt": dict(zip(AXES, d_nt))}}
        elif self.kind == "ambient":
            conditions = {"orientation": np.eye(3).tolist()}
        self.document = {"fluxcal": 1, "title": "a recording", "calibration": calibration,
                         "recordings": [series.recording("run", procedure, **conditions)]}
        self._basis = spanned(np.column_stack([np.ones(self.rows), field - field.mean(axis=0)]))
        residual = lengths.mismatch(series, offset_nt)[:, None] if self.kind == "scalar" else self.readings
        self.scatter_nt = float(rms(self._without_constants(residual), axis=None))

    def _without_constants(self, columns: np.ndarray) -> np.ndarray:
        return columns - self._basis @ (self._basis.T @ columns)

    def size_nt(self, added: np.ndarray) -> float:
        """The measure of strengths: rms of what is left of what is added to the readings (rows × 3, nT) when all constants of the basic
        model are fitted to it, δM_i = Σ_j a_ij B_j + o_i, in the sensor that keeps most. Beside a scalar magnetometer: of the change of
        the vector's length, less a level and slopes along the readings."""
        if self.kind == "scalar":
            added = (np.linalg.norm(self.fields + added, axis=1) - np.linalg.norm(self.fields, axis=1))[:, None]
        return float(rms(self._without_constants(added)).max())

    def case(self, sort: str, document: dict, effects: list[dict]) -> Case:
        """What its documents predict is not held against a truth, which nobody knows."""
        return Case(document, dict(sort=sort, effects=effects, noise_nt=0.0, rows=self.rows, manners=[self.name]), np.zeros(0))

    def with_added(self, nt: np.ndarray) -> dict:
        """The document with something added; what was read code by code is codes again, and the rest stays as it was printed."""
        code = self.code_nt or 1e-6
        sums = np.where(nt == 0, self.readings, np.round(np.round((self.readings + nt) / code) * code, 9))
        recording = self.document["recordings"][0]
        columns = recording["columns"] | {f"{self.instrument}_{axis}_nt": nt.tolist() for axis, nt in zip(AXES, sums.T)}
        return self.document | {"recordings": [recording | {"columns": columns}]}

    @property
    def has(self) -> set[str]:
        """What members may need: a field that is known as it moves, a kind, a temperature that moves, a whole day, or quick readings."""
        rules = {"field": self.kind != "single", "day": np.ptp(self.time_s) > 85_000 and self.series.start_s > 0,
                 "quick": np.median(np.diff(self.time_s)) <= 10}
        rules |= {name: np.ptp(self.series[name]) > 0.1 for name in self.series.frame if name.endswith("temperature_c")}
        return {self.kind} | {name for name, holds in rules.items() if holds}


def between(series: Series, from_s: float, to_s: float) -> Series:
    """What lies between two moments, on a clock that is zero at the first."""
    cut = series.between(from_s, to_s)
    return cut.on_clock(series.start_s + from_s) if series.start_s else cut


def pair(p: Programs, *names: str) -> Series:
    reference, test = pairs.read(p, *names)
    return reference.joined(test).complete()


def conrad_vectors(p: Programs) -> Series:
    """The test instrument of the pair in the field that the other one tells it has, by least squares."""
    both = pair(p, "fge-2022-08-10", "lemi036").means(60)
    ambient = both.vectors("test") - left(affine("reference"), test, both, both)
    return both.only("test", "sensor").assign(**{f"ambient_{axis}_nt": column for axis, column in zip(AXES, ambient.T)})


def cobenzl_night(p: Programs) -> Series:
    reference, test = pairs.read(p, "didd", "lemi025")
    test = test.at(reference.time_s - COBENZL_EARLY_S).assign(time_s=reference.time_s)
    return between(reference.joined(test).complete(), DAY_S - 2 * 3600, DAY_S + 7.5 * 3600)


# Folder, how it is read, what maker or logger state as offset (nT), and the width of a code (nT; 0 where readings are means).
CANDIDATES = {
    "conrad-scalar-20s": ("wic-conrad-2022-08", lambda p: lengths.read_conrad(p, "2022-08-03", 20), CONRAD_NT, 0.0),
    "conrad-scalar-60s": ("wic-conrad-2022-08", lambda p: lengths.read_conrad(p, "2022-08-10", 60), CONRAD_NT, 0.0),
    "conrad-vectors": ("wic-conrad-2022-08", conrad_vectors, NONE, 0.0),
    "conrad-fge": ("wic-conrad-2022-08", lambda p: between(p.read("fge-2022-08-10"), 7200, 8100), NONE, 0.001),
    "vernadsky": ("aia-vernadsky-2020-03-03", lambda p: p.read("vernadsky").complete(), VERNADSKY_NT, 0.01),
    **{f"boulder-{day}": ("usgs-bou-2016-01", lambda p, day=day: between(p.read("boulder-raw").complete(), (day - 1) * DAY_S, day * DAY_S),
                          NONE, 0.01) for day in (8, 16, 25)},
    "hmc5883l": ("marg-hmc5883l-sunsided", lambda p: alone.read_marg(p, 0.2), NONE, 0.0),
    "w2naf-night": ("hamsci-w2naf-2024-05-10", lambda p: between(p.read("w2naf"), 7200, 28_800).means(30, 0).complete(), NONE, 0.0),
    "conrad-pair": ("wic-conrad-2022-08", lambda p: pair(p, "fge-2022-08-10", "lemi036").means(120), NONE, 0.0),
    "boulder-published": ("usgs-bou-2016-01", lambda p: between(pair(p, "boulder-raw", "boulder-adjusted"), 7 * DAY_S, 8 * DAY_S), NONE, 0.01),
    "cobenzl-night": ("wik-cobenzl-2011-09a", cobenzl_night, NONE, 0.0),
    "meson-hall": ("tucan-fluxgates-2019-08-09-quiet", lambda p: between(p.read("meson-hall").complete(), 408, 1060), NONE, 0.0),
}


def hosts(data: Path, programs: Path) -> list[Host]:
    """The candidates whose folder is there."""
    stages, found = Programs(programs, data), []
    for name, (folder, read, offset_nt, code_nt) in CANDIDATES.items():
        if (data / folder).is_dir():
            found.append(Host(name, read(stages), offset_nt, code_nt))
        else:
            print(f"{name}: no host, no folder {folder} with the recordings")
    return found


class Effect(NamedTuple):
    """What a size s adds to the readings, nT (one column for a sensor, three for all), and what is then right."""

    family: str
    needs: set[str]  # of what a host has
    act: Callable[[float], np.ndarray]
    parameters: Callable[[float], dict[str, float]] = lambda s: {}
    also: tuple[str, ...] = ()  # other names that are right


def effects(host: Host, sensor: int, rng: np.random.Generator) -> dict[str, Effect]:
    """One of each member, with what is random in it drawn; t from the first row, b the field and m the readings of the sensor."""
    t, b, m, rows = host.time_s - host.time_s[0], host.fields[:, sensor], host.readings[:, sensor], np.arange(host.rows)
    span, step, row = t[-1], np.median(np.diff(t)), int(host.rows * rng.uniform(0.2, 0.8))
    tau, at, sign, vector, turns = span * rng.uniform(0.05, 0.25), host.time_s[row], rng.choice([-1, 1]), rng.normal(size=3), rng.uniform(3, 8)
    along, across = np.linalg.qr(rng.normal(size=(3, 2)))[0].T

    def moved(late_s: np.ndarray | float) -> np.ndarray:
        """The fields so much earlier, less the fields; held before the first reading."""
        return CubicSpline(t, host.fields)(np.clip(t - late_s, 0, span)) - host.fields

    def induced(s: float) -> np.ndarray:
        fast = host.fields - np.column_stack([relaxed(t, one, 0.3 * tau) for one in host.fields.T])
        return s * fast @ (vector[:, None] * [0.2, 0.2, 1.0])

    def works(s: float) -> np.ndarray:
        moment = host.series.start_s + host.time_s
        hour = moment / 3600 % 24
        runs = np.clip(2 * (4.25 - np.abs(hour - 12.25)), 0, 1) - np.clip(4 * (0.5 - np.abs(hour - 12.5)), 0, 1)
        return s * np.outer(runs * ((moment // DAY_S + 3) % 7 < 5), vector)

    def passes(s: float) -> np.ndarray:
        r = np.outer((host.time_s - at) / (2 * turns * step), along) + across
        length = np.linalg.norm(r, axis=1)[:, None]
        return s * (3 * (r @ vector)[:, None] * r / length**5 - vector / length**3)
    late, follows, time, moments, field = "late_response", "follows_column", "time", "moments", {"field"}
    members = {
        # Three equal poles of s in sum: Auster et al. 2008, Space Sci. Rev. 141, 235.
        "loop_bandwidth": Effect(late, field, lambda s: relaxed(t, relaxed(t, relaxed(t, b, s / 3), s / 3), s / 3) - b,
                                 lambda s: {"lag_s": s, "delay_s": s}, ("delay",)),
        # δ = B(t − s) − B(t): Primdahl 1979, J. Phys. E 12, 241; of all sensors: INTERMAGNET Technical Reference Manual.
        "delay": Effect(late, field, lambda s: moved(s)[:, sensor], lambda s: {"lag_s": s, "delay_s": s}, ("loop_bandwidth",)),
        "clock_offset": Effect(late, field, lambda s: moved(sign * s), lambda s: {"offset_s": sign * s}),
        # δ = B(t − r t) − B(t); r, s ppm, grows by a tenth as the quartz warms: Vig 1992, quartz frequency standards.
        "clock_rate": Effect(late, field, lambda s: moved(1e-6 * s * t * (0.95 + 0.1 * t / span)), lambda s: {"rate_ppm": s}, ("clock_offset",)),
        # δ = s C (B − L), τ dL/dt = B − L, the vertical most: Parkinson 1959, Geophys. J. 2, 1.
        "induction_difference": Effect(late, {"pair"}, induced, lambda s: {"time_constant_s": 0.3 * tau}),
        # δ = s exp(−t/τ), a tenth quicker; s t, slower at the end; s from a moment on: Jankowski and Sucksdorff 1996, IAGA Guide.
        "warm_up": Effect(time, set(), lambda s: s * (0.9 * np.exp(-t / tau) + 0.1 * np.exp(-5 * t / tau)),
                          lambda s: {"amplitude_nt": s, "time_constant_s": tau}),
        "ageing": Effect(time, set(), lambda s: s / DAY_S * (t - 0.05 * t**2 / span), lambda s: {"rate_nt_per_day": s}),
        "reading_step": Effect(time, set(), lambda s: s * (rows >= row), lambda s: {"height_nt": s, "time_s": at}),
        # A field from 8 to 16.5 h with a break at noon, Monday to Friday, that comes and goes: Lowes 2009, Earth Planets Space 61, i.
        "working_hours": Effect(time, {"day"}, works),
        # One reading jumps, and the next rings by a tenth; a channel holds its value twice, for 10 s samples each.
        "spike": Effect(moments, set(), lambda s: s * ((rows == row) - 0.1 * (rows == row + 1)), lambda s: {"height_nt": s, "time_s": at}),
        "dropout": Effect(moments, set(), lambda s: sum((m[r] - m) * ((rows >= r) & (rows < r + 10 * s)) for r in (row // 2, row)),
                          lambda s: {"time_s": at}),
        # A dipole p on a straight path, r the way to the sensor: 3 (p·r) r / r⁵ − p / r³: Jackson, Classical Electrodynamics.
        "vehicle_pass": Effect(moments, {"quick"}, passes),
        # One frequency of a machine near by, with a third of it at its double; what it is an alias of is open.
        "periodic_field": Effect("lines", set(), lambda s: s * np.outer(sum(np.sin(k * 2 * np.pi * t / (3 * turns * step) + k**2) / (2 * k - 1)
                                                                           for k in (1, 2)), vector),
                                 lambda s: {"frequency_hz": 1 / (3 * turns * step)}, ("mains", "traction_power")),
        # δ = s floor(M / s) − M; the fine part of a converter in two steps is s too long: IEEE Std 1241.
        "quantisation": Effect("codes", set(), lambda s: s * np.floor(m / s) - m, lambda s: {"width_nt": s}),
        "differential_nonlinearity": Effect("codes", field, lambda s: s * (m * turns / np.ptp(m) % 1)),
    }
    # δ = s (T − T_ref), a little bent, or late by two bodies: NASA CR-156638, eq. 29; Primdahl 1979.
    for name, column in (("offset_temperature", "sensor_temperature_c"), ("offset_electronics_temperature", "electronics_temperature_c")):
        if column in host.has:
            warm = host.series[column] - host.series[column].mean()
            members[name] = Effect(follows, {column}, lambda s, x=warm: s * (x + 0.02 * x**2 / np.abs(x).max()),
                                   lambda s: {"coefficient_nt_per_k": s})
            members[f"{name}_lag"] = Effect(follows, {column}, lambda s, x=warm: s * (0.9 * relaxed(t, x, tau) + 0.1 * relaxed(t, x, tau / 5)),
                                            lambda s: {"coefficient_nt_per_k": s, "lag_s": tau})
    return {name: one for name, one in members.items() if one.needs <= host.has}


def inject(host: Host, name: str, strength: float, rng: np.random.Generator) -> Case | None:
    """An effect that leaves so many times the scatter of the host; None where it does not show there, or cannot be reached."""
    wanted_nt, along, blind = strength * host.scatter_nt, np.abs(host.fields.mean(axis=0)), host.kind == "scalar"
    for _ in range(12):  # sensors and moments are drawn until one shows
        sensor, size = int(rng.integers(3)), 1.0
        effect = effects(host, sensor, rng)[name]
        one = effect.act(size).ndim == 1
        for _ in range(20):  # what is left need not be in proportion to the size
            nt = np.outer(effect.act(size), np.eye(3)[sensor]) if one else effect.act(size)
            left_nt = host.size_nt(nt)
            if abs(left_nt / wanted_nt - 1) < 0.1 * CLOSE:
                break
            size *= np.clip(wanted_nt / max(left_nt, 1e-12), 0.01, 100)
        sees = not (blind and one) or along[sensor] >= LEAST_ALONG * np.linalg.norm(along)
        shows = left_nt >= LEAST_LEFT * nt.std(axis=0).max() and np.abs(nt).max() <= MOST_NT
        if sees and shows and abs(left_nt / wanted_nt - 1) < CLOSE:
            # The length of a vector that points one way shows no sensor, nor sizes: a name is right on any of them and without one, and
            # a late sensor is a late clock.
            targets, own, twice = ["", *AXES] if blind else [AXES[sensor] if one else ""], effect.parameters(size), effect.parameters(2 * size)
            late = ("delay", "loop_bandwidth", "clock_offset")
            also = (*effect.also, *late) if blind and name in late else effect.also
            return host.case("injected", host.with_added(nt), [dict(
                kind=name, form="in a real recording", family=effect.family, source=host.name, strength=strength, undecidable=False, left_nt=left_nt,
                right=[(known, axis) for known in dict.fromkeys((name, *also)) for axis in targets],
                parameters={key: float(value) for key, value in own.items() if not blind or value == twice[key]})])
    return None


def injections(hosts: list[Host], seed: int, number: int) -> list[Case]:
    """So many, if the hosts carry them: hosts by turns, each with its members in a drawn order, strengths by turns."""
    found, members = [], [list(effects(host, 0, np.random.default_rng(0))) for host in hosts]
    for turn in range(10 * number):
        for k, host in enumerate(hosts):
            around, place = divmod(turn, len(members[k]))
            name = np.random.default_rng([seed, k, around]).permutation(members[k])[place]
            one = inject(host, str(name), STRENGTHS[(turn + k + around) % len(STRENGTHS)], np.random.default_rng([seed, k, around, place]))
            found += [one] if one else []
            if len(found) == number:
                return found
    return found


def cases(data: Path, programs: Path, seed: int) -> list[tuple[int, Case]]:
    """The injections, where the hosts carry them, then the hosts as they came, where nothing may be claimed; with their numbers."""
    found = hosts(data, programs)
    return [*enumerate(injections(found, seed, COUNT), INJECTED), *enumerate([host.case("recorded", host.document, []) for host in found], RECORDED)]

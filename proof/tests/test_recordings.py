"""Real recordings: arithmetic by hand, and injections, on recordings that are made up."""
import tempfile
import unittest
from pathlib import Path

import numpy as np
import pandas as pd

from fluxcal_proof.recordings import by_hand
from fluxcal_proof.recordings.__main__ import SETS, run, whole
from fluxcal_proof.recordings.alone import drive
from fluxcal_proof.recordings.hosts import STRENGTHS, Host, effects, injections
from fluxcal_proof.recordings.page import figures, plus_minus, three
from fluxcal_proof.recordings.programs import Programs, Series, relaxed, rms

T, LEVEL = 60.0 * np.arange(1500), np.array([20_000, 300, 43_000.0])
NOISE = 0.1 * np.random.default_rng(1).normal(size=(len(T), 3))


def columns(instrument: str, vectors: np.ndarray) -> dict[str, np.ndarray]:
    return {f"{instrument}_{axis}_nt": column for axis, column in zip("xyz", vectors.T)}


def field(t: np.ndarray) -> np.ndarray:
    return np.column_stack([40 * np.sin(t / 900), 30 * np.cos(t / 1300), 20 * np.sin(t / 700)])


class RealRecordings(unittest.TestCase):
    def test_series_are_averaged_joined_and_read_between_rows(self) -> None:
        one = Series(pd.DataFrame({"time_s": [0, 1, 2, 3, 4, 6, 7, 8.0], "a": np.arange(1, 9.0)}), 100.0)
        assert one.means(3).frame.to_numpy().tolist() == [[1.5, 2], [7.5, 7]]
        other = Series(pd.DataFrame({"time_s": [-9, -8.0], "b": [20, 30.0]}), 110.0)
        assert one.joined(other).frame.to_numpy().tolist() == [[1, 2, 20], [2, 3, 30]]
        np.testing.assert_equal(one.at(np.array([-1, 0.5, 4, 5, 9.0]))["a"], [np.nan, 1.5, 5, np.nan, np.nan])
        recording = Series(pd.DataFrame({"time_s": [0.0], "a": [np.nan]}), 100.5).recording("a", "free_run")
        assert recording["columns"]["a"] == [None] and Series.of({"recordings": [recording]}).start_s == 100.5

    def test_numbers_have_the_figures_that_they_mean(self) -> None:
        assert (three(0.0978), three(17.2254), three(2926.9), three(0.0)) == ("0.098", "17.2", "2927", "0")
        assert (plus_minus(0.990179, 0.001308), plus_minus(-736.1, 173.4)) == ("0.9902 ± 0.0013", "-736 ± 173")
        assert (figures(17_998.0), figures(0.00409)) == ("18000", "0.00409")

    def test_the_best_by_hand_finds_a_clock_and_a_drift(self) -> None:
        def part(late_s: float, number: int) -> Series:
            test = field(T + late_s - 30) @ [[1, -0.05, 0], [0.05, 1, 0], [0, 0, 1]] + NOISE + np.outer(T / 3600, [1, 0, 0])
            return Series(pd.DataFrame({"time_s": T, **columns("reference", field(T)), **columns("test", test)})).split(share=0.6)[number]
        fitted, held_out = (lambda late_s, number=number: part(late_s, number) for number in (0, 1))
        ways, left = by_hand.best_of_pair(fitted, held_out, by_hand.lag(fitted))
        assert "straight drift" in ways[0] and all("clock 30.000 s late" in way for way in ways)
        assert max(rms(one) for one in left) < 0.12

    def test_an_ellipsoid_becomes_a_sphere_and_a_lag_is_exact_for_a_ramp(self) -> None:
        sphere = 50_000 * (NOISE / np.linalg.norm(NOISE, axis=1)[:, None])
        readings = sphere @ [[1.1, 0, 0.02], [0.05, 0.9, 0], [0, 0, 1]] + [9000, -5000, 0]
        series = Series(pd.DataFrame(columns("sensor", readings)).assign(reference_nt=50_000.0))
        assert rms(by_hand.ellipsoid(series, series, np.zeros(3))) < 1e-6
        np.testing.assert_allclose(relaxed(T, T, 300.0), T - 300 * (1 - np.exp(-T / 300)))

    def test_the_drive_of_a_square_wave_is_unknown_beside_a_switching(self) -> None:
        z = np.array([-900, *[700.0] * 4, *[0.0] * 5, *[700.0] * 5])
        assert np.isnan(drive(z)).nonzero()[0].tolist() == [4, 5, 9, 10]

    def test_injections_have_their_strength_and_change_readings_alone(self) -> None:
        scalar = {"reference_nt": np.linalg.norm(field(T) + LEVEL, axis=1)}
        for kind, beside in (("pair", columns("reference", field(T))), ("ambient", columns("ambient", field(T))), ("single", {}), ("scalar", scalar)):
            own = columns("test" if kind == "pair" else "sensor", NOISE + (0 if kind == "single" else field(T)))
            series = Series(pd.DataFrame({"time_s": T, **own, **beside, "sensor_temperature_c": np.sin(T / 9000)}), 1.0e9)
            host = Host("made up", series, LEVEL * (kind == "scalar"), 0.0)
            assert host.kind == kind and abs(host.scatter_nt / 0.1 - 1) < 0.1
            some = injections([host], 3, 20)
            assert [one.truth for one in some] == [one.truth for one in injections([host], 3, 20)] and len(some) == 20
            for one in some:
                (effect,) = one.truth["effects"]
                assert effect["kind"] in effects(host, 0, np.random.default_rng(0)) and effect["strength"] in STRENGTHS
                assert abs(effect["left_nt"] / (effect["strength"] * host.scatter_nt) - 1) < 0.1
                before, after = (document["recordings"][0]["columns"] for document in (host.document, one.document))
                assert {name for name in before if before[name] != after[name]} <= set(own)

    def test_every_set_says_that_its_folder_is_missing(self) -> None:
        with tempfile.TemporaryDirectory() as nowhere:
            text = whole([run(Programs(Path(nowhere), Path(nowhere)), name) for name in SETS])
        assert text.count("\nNot run: no folder `") == len(SETS) and nowhere not in text

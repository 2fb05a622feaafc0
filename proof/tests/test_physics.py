"""The physics, the noise and the size of effects, each against a number that is known otherwise."""
import unittest

import numpy as np
from scipy.special import iv

from fluxcal_proof import cases, noise, response, signal
from fluxcal_proof.basic import Basic
from fluxcal_proof.campaign import Campaign
from fluxcal_proof.effects.own_field import plays
from fluxcal_proof.effects.surroundings import ring
from fluxcal_proof.signal import Signal


def integrated(x: np.ndarray, dt: float, tau: float) -> np.ndarray:
    """tau dy/dt = x - y by the trapezoidal rule."""
    y = np.zeros_like(x)
    y[0] = x[0]
    for i in range(1, len(x)):
        y[i] = y[i - 1] + dt / (tau + dt / 2) * ((x[i] + x[i - 1]) / 2 - y[i - 1])
    return y


class Responses(unittest.TestCase):
    def test_relaxation_from_rest_is_the_differential_equation(self) -> None:
        rng, t = np.random.default_rng(1), np.arange(0, 100, 0.01)
        x = signal.smooth(rng, 80, 5, 1.0).plus(Signal(at=np.array([20.0, 50.0]), height=np.array([2.0, -1.0]), shape=response.relaxation(4.0)))
        y = x.through(response.relaxation(7.0), rest=0.0)(t)
        np.testing.assert_allclose(y, integrated(x(t), 0.01, 7.0), atol=2e-5)

    def test_modes_of_plate_and_cylinder_sum_to_the_closed_form(self) -> None:
        omega = np.array([0.01, 0.1, 1.0])
        z = np.sqrt(1j * omega * 3.0)
        np.testing.assert_allclose(response.plate(3.0, 200).gain(omega), np.tanh(z) / z, atol=2e-3)
        np.testing.assert_allclose(response.cylinder(3.0, 400).gain(omega), 2 * iv(1, z) / (z * iv(0, z)), atol=2e-3)

    def test_a_damped_response_is_second_order(self) -> None:
        omega, tau = np.array([0.1, 1.0, 4.0]), 0.7
        s = 1j * omega
        np.testing.assert_allclose(response.damped(tau, 0.6).gain(omega), 1 / (1 + 1.2 * tau * s + (tau * s) ** 2))
        step = Signal(at=np.array([0.0]), height=np.array([1.0]), shape=response.damped(tau, 0.6))(np.array([0.0, 1e3]))
        np.testing.assert_allclose(step, [0, 1], atol=1e-9)


class Fields(unittest.TestCase):
    def test_a_ring_on_its_axis(self) -> None:
        radius, z = 1.3, 0.4
        expected = np.pi * radius**2 / (radius**2 + z**2) ** 1.5
        self.assertAlmostEqual(ring(np.array([1e-9, 0, z]), radius, 0.0)[1 + 1], expected, places=9)

    def test_a_ring_has_no_sources(self) -> None:
        p, h = np.array([0.2, -0.1, 0.3]), 1e-4
        flux = sum((ring(p + h * e, 1.0, 0.0)[i] - ring(p - h * e, 1.0, 0.0)[i]) / (2 * h) for i, e in enumerate(np.eye(3)))
        self.assertAlmostEqual(flux, 0, places=5)

    def test_a_play_lags_by_its_width_on_the_way_up(self) -> None:
        way = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, -1, 100)])[:, None]
        lag = plays(way, np.array([0.2]), 0.0) - way
        np.testing.assert_allclose(lag[[49, -1], 0], [-0.2, 0.2])


class Noises(unittest.TestCase):
    def test_flicker_has_the_density_that_is_declared(self) -> None:
        own, step = noise.Noise(0.0, flicker=2e-3), 5.0
        rng, n, power = np.random.default_rng(3), 1024, 0.0
        for _ in range(200):
            x = own.draw(rng, n, step) * np.hanning(n)
            power = power + np.mean(np.abs(np.fft.rfft(x)) ** 2, 0) * 2 * step / np.sum(np.hanning(n) ** 2)
        f = np.fft.rfftfreq(n, step)
        part = slice(20, 300)
        self.assertAlmostEqual(float(np.mean((power / 200)[part] * f[part])), 2e-3, delta=1e-4)


class Sizes(unittest.TestCase):
    def test_constants_take_up_what_is_theirs(self) -> None:
        c = Campaign(np.random.default_rng(2), 900, together=False, averages=True, uneven=True, gaps=True)
        basic = Basic(c)
        gain = [0.01 * c.plain(run) for run in c.runs]
        self.assertLess(basic.left(gain), 1e-4)
        bias = [c.geo_to_reading(run, np.outer(c.eta[:, 1], np.ones(len(run.at)))) for run in c.runs]
        self.assertLess(basic.left(bias), 1e-6)

    def test_effects_have_the_size_that_is_asked_for(self) -> None:
        for number in range(12):
            for effect in cases.make(4, number, "develop").truth["effects"]:
                wanted = effect["strength"] * cases.make(4, number, "develop").truth["noise_nt"]
                self.assertLess(abs(effect["left_nt"] / wanted - 1), 0.05, effect["form"])

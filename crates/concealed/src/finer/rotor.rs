//! Magnets on the rim of a wheel.

use nalgebra::Vector3;

use super::dipole;

/// A wheel whose centre is a distance of 1 away.
#[derive(Clone, Debug)]
pub struct Rotor {
    /// Way from the sensors to the wheel's centre, of length 1.
    pub place: Vector3<f64>,
    /// Two directions across the wheel's axle, at right angles.
    pub across: [Vector3<f64>; 2],
    /// Radius of the rim.
    pub radius: f64,
}

impl Rotor {
    fn magnet(&self, phase: f64) -> Vector3<f64> {
        let out = self.across[0] * phase.cos() + self.across[1] * phase.sin();
        dipole::field(&out, &-(self.place + out * self.radius))
    }

    /// Field of a magnet on the rim that points outwards, when the wheel has turned by a phase, rad.
    pub fn one(&self, phase: f64) -> Vector3<f64> {
        self.magnet(phase)
    }

    /// Field of two such magnets opposite each other: what goes with the phase itself cancels.
    pub fn two(&self, phase: f64) -> Vector3<f64> {
        self.magnet(phase) + self.magnet(phase + std::f64::consts::PI)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn rotor(radius: f64) -> Rotor {
        let place = Vector3::new(0.6, 0.0, 0.8);
        Rotor { place, across: [Vector3::x(), Vector3::y()], radius }
    }

    fn harmonic(of: impl Fn(f64) -> Vector3<f64>, number: f64) -> f64 {
        let turn = |k: i32| TAU * f64::from(k) / 64.0;
        let [cosine, sine] = [f64::cos, f64::sin].map(|wave: fn(f64) -> f64| {
            (0..64).map(|k| of(turn(k)) * (wave(number * turn(k)) / 32.0)).sum::<Vector3<f64>>()
        });
        cosine.norm().hypot(sine.norm())
    }

    /// A magnet at the centre is a dipole that turns: one harmonic and no other.
    #[test]
    fn a_small_rotor_has_one_harmonic() {
        let rotor = rotor(1e-9);
        assert!(harmonic(|p| rotor.one(p), 1.0) > 0.5 && harmonic(|p| rotor.one(p), 2.0) < 1e-6);
    }

    /// Two magnets have even harmonics alone, which grow with the radius.
    #[test]
    fn two_magnets_have_even_harmonics() {
        let (small, large) = (rotor(0.05), rotor(0.1));
        for number in [1.0, 3.0] {
            assert!(harmonic(|p| large.two(p), number) < 1e-12);
        }
        let growth = harmonic(|p| large.two(p), 2.0) / harmonic(|p| small.two(p), 2.0);
        assert!((growth - 2.0).abs() < 0.1, "{growth}");
    }
}

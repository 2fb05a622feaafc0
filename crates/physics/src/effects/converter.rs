use super::prelude::*;
use std::f64::consts::TAU;

/// What a converter gets is the output, B without the offset O, nT.
fn offset<T: Real>(around: &Surroundings<'_, T>) -> T {
    around.basic.sensors[around.axis.index()].offset_nt
}

impl Effect for Quantisation {
    const ABOUT: About = About {
        name: "quantisation",
        title: "readings are coarsely quantised",
        physics: "The converter has fewer bits than the field asks for, and the reading is a staircase.",
        equation: "dB = q round(M / q) - M, M = B - O what the converter gets",
        source: "Kester (ed.) 2005, Data Conversion Handbook; IEEE Std 1241",
        parameters: &[ParameterInfo::shape("width_nt", 0.02, 4000.0)],
        ..About::of(Family::Codes, Place::Electronics, Stage::Converter, Acts::OneSensor)
    };
    const INVERTIBLE: bool = false;

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let offset = offset(around);
        for own in around.own(signal) {
            let reading = *own - offset;
            let codes = (reading.re() / parameters[0].re()).round();
            *own = offset + parameters[0] * codes;
        }
        Ok(())
    }
}

/// An amplitude of a harmonic, none where a document does not give it.
const fn harmonic(name: &'static str, high: f64) -> ParameterInfo {
    ParameterInfo::amplitude(name, 0.01, high).or_zero()
}

/// A bit of the wrong weight errs like a square wave, which these harmonics follow to 93 % of its energy.
impl Effect for DifferentialNonlinearity {
    const ABOUT: About = About {
        name: "differential_nonlinearity",
        title: "converter codes differ in width",
        physics: "A bit of the converter has a wrong weight, and the reading errs periodically along its own range.",
        equation: "dB = sum over k from 1 to 5 of a_k sin(2 pi k M / p) + b_k cos(2 pi k M / p), M = B - O",
        parameters: &[
            ParameterInfo::amplitude("sine_nt", 0.02, 5.0),
            ParameterInfo::amplitude("cosine_nt", 0.02, 5.0),
            ParameterInfo::shape("period_nt", 2.0, 20_000.0),
            harmonic("sine_2_nt", 2.5),
            harmonic("cosine_2_nt", 2.5),
            harmonic("sine_3_nt", 1.7),
            harmonic("cosine_3_nt", 1.7),
            harmonic("sine_4_nt", 1.3),
            harmonic("cosine_4_nt", 1.3),
            harmonic("sine_5_nt", 1.0),
            harmonic("cosine_5_nt", 1.0),
        ],
        ..Quantisation::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let offset = offset(around);
        let amplitudes = [&parameters[..2], &parameters[3..]].concat();
        for own in around.own(signal) {
            let phase = (*own - offset) / parameters[2] * TAU;
            for (pair, k) in amplitudes.chunks_exact(2).zip(1..) {
                let phase = phase * f64::from(k);
                *own += pair[0] * phase.sin() + pair[1] * phase.cos();
            }
        }
        Ok(())
    }
}

/// Share of the level below which nothing saturates.
const NOTHING: f64 = 1e-6;

impl Effect for Saturation {
    const ABOUT: About = About {
        name: "saturation",
        title: "reading saturates near the end of the range",
        physics: "The feedback runs out of current near the end of the range, and the reading flattens.",
        equation: "dB = M / (1 + |M / L|^s)^(1/s) - M, M = B - O",
        family: Family::OwnField,
        parameters: &[
            ParameterInfo::shape("level_nt", 30_000.0, 200_000.0),
            ParameterInfo { absent: Some(8.0), ..ParameterInfo::shape("sharpness", 3.0, 16.0) },
        ],
        ..Quantisation::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let offset = offset(around);
        for own in around.own(signal) {
            let reading = *own - offset;
            let share = if reading.re() < 0.0 { -reading } else { reading } / parameters[0];
            if share.re() > NOTHING {
                let power = (share.ln() * parameters[1]).exp() + 1.0;
                *own = offset + reading * (power.ln() / -parameters[1]).exp();
            }
        }
        Ok(())
    }
}

impl Effect for Clipping {
    const ABOUT: About = About {
        name: "clipping",
        title: "reading is clipped at a level",
        physics: "The amplifier or the converter ends before the field does: beyond the level every field reads \
            the same.",
        equation: "dB = min(max(M, -L), L) - M, M = B - O",
        parameters: &[ParameterInfo::shape("level_nt", 1_000.0, 100_000.0)],
        ..Saturation::ABOUT
    };
    const INVERTIBLE: bool = false;

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let offset = offset(around);
        for own in around.own(signal) {
            let reading = (*own - offset).re();
            if reading.abs() > parameters[0].re() {
                *own = offset + parameters[0] * reading.signum();
            }
        }
        Ok(())
    }
}

use super::prelude::*;
use common::time::{hour_of_day, is_weekday};

/// u, v, w follow from the dipole's moment and its straight line, x is the way over the smallest distance.
impl Effect for VehiclePass {
    const ABOUT: About = About {
        name: "vehicle_pass",
        title: "a vehicle passes",
        physics: "A car or a train is a moving dipole, whose field rises, turns and falls as it goes by.",
        equation: "dB_geo = (u + v x + w x^2) / (1 + x^2)^(5/2), x = (t - t0) / d",
        source: "Jackson, Classical Electrodynamics (field of a dipole); Jankowski and Sucksdorff 1996, IAGA Guide for \
            Magnetic Measurements and Observatory Practice",
        parameters: amplitudes!(
            0.1 to 200.0: "north_first_nt", "east_first_nt", "down_first_nt",
                          "north_second_nt", "east_second_nt", "down_second_nt",
                          "north_third_nt", "east_third_nt", "down_third_nt";
            ParameterInfo::epoch("time_s"), ParameterInfo::shape("duration_s", 1.0, 1000.0)
        ),
        needs: &["time_s"],
        ..About::of(Family::Moments, Place::Environment, Stage::Geo, Acts::Everything)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let time = around.times()?;
        let part = |number: usize| Vector3::from_column_slice(&parameters[3 * number..3 * number + 3]);
        let (first, second, third) = (part(0), part(1), part(2));
        for (field, t) in signal.iter_mut().zip(time) {
            let x = (-parameters[9] + *t) / parameters[10];
            let square = x * x + 1.0;
            *field += (first + second * x + third * (x * x)) / (square * square * square.sqrt());
        }
        Ok(())
    }
}

/// Whether machines run at a local time, s: from Monday to Friday, from 7 h to 17 h or so many hours later and earlier.
pub fn machines_run(local_s: f64, slack_h: f64) -> bool {
    is_weekday(local_s) && (7.0 + slack_h..17.0 - slack_h).contains(&hour_of_day(local_s))
}

impl Effect for WorkingHours {
    const ABOUT: About = About {
        name: "working_hours",
        title: "field of machines in working hours",
        physics: "Machines, lifts and direct-current railways run by day from Monday to Friday and add a field while \
            they do.",
        equation: "dB_geo = v from Monday to Friday, 7 h + s to 17 h - s by the clock of `start`",
        source: "NASA CR-156638, test of the Earth field nulling system (site conditions); Lowes 2009, DC railways and \
            the magnetic fields they produce, Earth Planets Space 61, i",
        parameters: amplitudes!(
            0.1 to 200.0: "north_nt", "east_nt", "down_nt"; ParameterInfo::span("slack_s", 60.0, 3600.0)
        ),
        needs: &["time_s", "start"],
        ..About::of(Family::Time, Place::Environment, Stage::Geo, Acts::Everything)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let time = around.times()?;
        let start = around
            .context
            .local_start_s
            .ok_or_else(|| around.missing("the recording's `start`, with its offset from UTC"))?;
        let vector = Vector3::from_column_slice(&parameters[..3]);
        let slack_h = parameters[3].re() / 3600.0;
        for (field, t) in signal.iter_mut().zip(time) {
            if machines_run(start + t, slack_h) {
                *field += vector;
            }
        }
        Ok(())
    }
}

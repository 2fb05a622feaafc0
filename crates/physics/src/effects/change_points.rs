use super::prelude::*;

impl Effect for ReadingStep {
    const ABOUT: About = About {
        name: "reading_step",
        title: "reading steps at one moment",
        physics: "A knock, a changed range or a restart of the logger moves one channel by a constant from then on.",
        equation: "dB = h for t >= t0",
        source: "Jankowski and Sucksdorff 1996, IAGA Guide for Magnetic Measurements and Observatory Practice \
            (steps, spikes and gaps in records)",
        parameters: &[ParameterInfo::amplitude("height_nt", 0.1, 1000.0), ParameterInfo::epoch("time_s")],
        needs: &["time_s"],
        ..About::of(Family::Time, Place::Logger, Stage::Logger, Acts::OneSensor)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let time = around.times()?;
        let after = |(_, t): &(&mut T, &f64)| **t >= parameters[1].re();
        around.own(signal).zip(time).filter(after).for_each(|(own, _)| *own += parameters[0]);
        Ok(())
    }
}

impl Effect for Spike {
    const ABOUT: About = About {
        name: "spike",
        title: "one reading jumps",
        physics: "A bit error or a switching transient falls into one sample.",
        equation: "dB = h in the row nearest to t0",
        family: Family::Moments,
        parameters: &[ParameterInfo::amplitude("height_nt", 1.0, 100_000.0), ParameterInfo::epoch("time_s")],
        ..ReadingStep::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let time = around.times()?;
        let when = parameters[1].re();
        let after = time.partition_point(|t| *t < when);
        let nearest = [after.saturating_sub(1), after.min(time.len().saturating_sub(1))]
            .into_iter()
            .filter(|row| *row < time.len())
            .min_by(|a, b| (time[*a] - when).abs().total_cmp(&(time[*b] - when).abs()));
        // Beyond half a step from every row it falls between the rows.
        let step = |row: usize| {
            let before = row.checked_sub(1).map(|before| time[row] - time[before]);
            let after = time.get(row + 1).map(|after| after - time[row]);
            before.into_iter().chain(after).fold(0.0, f64::max)
        };
        let hit = nearest.filter(|row| (time[*row] - when).abs() <= step(*row) / 2.0);
        if let Some(row) = hit {
            signal[row][around.axis.index()] += parameters[0];
        }
        Ok(())
    }
}

impl Effect for Dropout {
    const ABOUT: About = About {
        name: "dropout",
        title: "reading freezes for a while",
        physics: "The connection fails and the logger stores the last value until it is back.",
        equation: "dB = B(t0) - B(t) for t0 <= t < t0 + d",
        parameters: &[ParameterInfo::epoch("time_s"), ParameterInfo::epoch("duration_s")],
        ..Spike::ABOUT
    };
    const INVERTIBLE: bool = false;

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let time = around.times()?;
        let (from, to) = (parameters[0].re(), parameters[0].re() + parameters[1].re());
        let mut held = None;
        for (own, t) in around.own(signal).zip(time) {
            match held {
                Some(last) if (from..to).contains(t) => *own = last,
                _ if own.re().is_finite() => held = Some(*own),
                _ => {}
            }
        }
        Ok(())
    }
}

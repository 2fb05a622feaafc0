//! k and O against the temperatures of sensor and electronics (NASA eq. 28 and 29).

use common::{
    Axis, CommonExtremum, Document, FitNoise, PerAxis, Quantity, SensorCalibration, TemperatureFit,
    TemperatureOfPart, procedure,
};
use estimate::stats;
use physics::{EffectInstance, Parameter};

use crate::Error;
use crate::allowed::Allowed;
use crate::conditions::Conditions;
use crate::departure::{self, Candidate, FOUND_BELOW};
use crate::fit::{self, Fit, Problem, Unknown};
use crate::heated::{Heated, Part, distinct, parts};
use crate::lag;
use crate::levels::{self, Level};
use crate::readings::{Run, along, code_width, runs};
use crate::shape::{Place, Shape};
use crate::sizes::Sized;

/// Coefficients of a sensor, and what the other procedures need of them; None without a recording.
pub fn coefficients(
    document: &Document,
    sensor: Axis,
    noise: &dyn Fn(f64) -> Shape,
) -> Result<Option<(TemperatureFit, Conditions)>, Error> {
    let runs = runs(document, procedure::TEMPERATURE_RUN, sensor)?;
    if runs.is_empty() {
        return Ok(None);
    }
    let warmer: Vec<[Vec<f64>; 2]> = runs
        .iter()
        .map(|run| Ok([Part::Sensor.warmer(run)?, Part::Electronics.warmer(run)?]))
        .collect::<Result<_, Error>>()?;
    let mut found = TemperatureFit {
        recordings: runs.iter().map(|run| run.context.recording.id.clone()).collect(),
        reference_c: Part::ALL.map(|part| part.reference(&runs[0])),
        ..TemperatureFit::default()
    };
    let parts = parts(sensor, &runs, &warmer, &mut found.findings)?;
    let heated = Heated { runs, warmer, parts };
    if heated.parts.is_empty() {
        return Ok(Some((found, Conditions::none())));
    }
    let k = heated.runs[0].basic.sensors[sensor.index()].sensitivity;
    let code_nt = heated.runs.iter().find_map(|run| code_width(document, run)).unwrap_or(0.0) * k;
    let shape = noise(code_nt);
    let allowed = fit::noise(&heated.runs, &shape)?;
    let candidates = candidates(&heated);
    let (effects, asked) = effects(&heated, sensor);
    let problem = problem(document, &heated, effects, &asked, &allowed)?;
    let allowed = departure::noise_called_for(&problem, &candidates)?;
    let problem = Problem { allowed: &allowed, ..problem };
    let lags = lag::look(&problem, &heated, sensor)?;
    // A lag that was found explains what noise of the field had to explain without it.
    let allowed = departure::noise_called_for(&lags.problem, &candidates)?;
    let lagged = Problem { allowed: &allowed, ..lags.problem.with(lags.problem.unknowns.clone()) };
    let first = lagged.solve()?;
    let effect = |at: &usize| matches!(lagged.unknowns[*at], Unknown::Chain(Parameter::Effect(..), _));
    let places: Vec<usize> = (0..lagged.unknowns.len()).filter(effect).collect();
    let sized = Sized::of(allowed.clone(), &first, &heated.runs, (&shape, Place::Coils))?;
    let mut extended = departure::extend(&Problem { allowed: &sized.allowed, ..lagged }, &candidates)?;
    let (degrees_of_freedom, coverage_factor_95) = sized.freedom(&extended.fit, &places)?;
    extended.fit.noise = FitNoise { degrees_of_freedom, coverage_factor_95, ..extended.fit.noise };
    let (levels, each) = levels::at_temperatures(&heated, &shape)?;
    describe(&heated, &lags, &extended.fit, (&levels, &each), &mut found);
    found.departures = extended.departures;
    found.levels = levels::columns(&levels, &heated);
    found.noise = extended.fit.noise.clone();
    for name in &extended.found {
        let text = format!(
            "besides the polynomials, the readings show {}, fitted jointly with them",
            name.replace('_', " ")
        );
        found.findings.push(text);
    }
    let conditions = lags.conditions(&extended.fit, sensor);
    found.covariance = common::covariance::rows(&conditions.covariance);
    found.covariance_order = lags.names();
    Ok(Some((found, conditions)))
}

/// Effects of the parts that moved, and which of their parameters are sought: a curvature from three
/// temperatures on.
fn effects(heated: &Heated<'_>, sensor: Axis) -> (Vec<EffectInstance>, Vec<Parameter>) {
    let (mut effects, mut asked) = (Vec::new(), Vec::new());
    for part in &heated.parts {
        // The sensitivity first, then the offset.
        for (kinds, driven) in part.kinds().into_iter().zip([true, false]) {
            let at = effects.len();
            effects.push(EffectInstance::new(kinds[0], Some(sensor), vec![0.0; 2]));
            asked.push(Parameter::Effect(at, 0));
            if distinct(heated, *part, driven) > 2 {
                asked.push(Parameter::Effect(at, 1));
            }
        }
    }
    (effects, asked)
}

/// Each run with its own k and O, the polynomial of the sensor, and the effects of temperature common to all.
fn problem<'p, 'b>(
    document: &Document,
    heated: &'p Heated<'b>,
    effects: Vec<EffectInstance>,
    asked: &[Parameter],
    allowed: &'p Allowed,
) -> Result<Problem<'p, 'b>, Error> {
    let sensor = heated.runs[0].sensor;
    let mut unknowns: Vec<Unknown> =
        asked.iter().map(|parameter| Unknown::Chain(*parameter, (0..heated.runs.len()).collect())).collect();
    unknowns.extend(levels::own_constants(&heated.runs, sensor));
    let known = fit::coils(document, &heated.runs)?;
    Ok(Problem { runs: &heated.runs, effects, unknowns, known, allowed })
}

/// A series of a run and its temperatures.
type Of<'f> = &'f dyn Fn(&Run<'_>, &[Vec<f64>; 2]) -> Vec<f64>;

/// What the polynomials in temperature may leave out.
fn candidates(heated: &Heated<'_>) -> Vec<Candidate> {
    let series = |of: Of<'_>| -> Vec<Vec<f64>> {
        heated.runs.iter().zip(&heated.warmer).map(|(run, both)| of(run, both)).collect()
    };
    let times_field = |run: &Run<'_>, column: Vec<f64>| -> Vec<f64> {
        along(run).iter().zip(column).map(|(b, c)| b * c * 1e-6).collect()
    };
    let mut all = Vec::new();
    let names = [
        [
            "sensor_offset_cubic",
            "sensor_sensitivity_cubic",
            "sensor_offset_branches",
            "sensor_sensitivity_branches",
        ],
        [
            "electronics_offset_cubic",
            "electronics_sensitivity_cubic",
            "electronics_offset_branches",
            "electronics_sensitivity_branches",
        ],
    ];
    for part in &heated.parts {
        let at = usize::from(*part == Part::Electronics);
        let cubic = |both: &[Vec<f64>; 2]| -> Vec<f64> { both[at].iter().map(|t| t.powi(3)).collect() };
        let branch = |both: &[Vec<f64>; 2]| levels::branches(&both[at]);
        let [offset_cubic, sensitivity_cubic, offset_branches, sensitivity_branches] = names[at];
        all.extend([
            Candidate {
                name: offset_cubic,
                parameter: "cubic_nt_per_k3",
                column: series(&|_, both| cubic(both)),
            },
            Candidate {
                name: sensitivity_cubic,
                parameter: "cubic_ppm_per_k3",
                column: series(&|run, both| times_field(run, cubic(both))),
            },
            Candidate {
                name: offset_branches,
                parameter: "warming_less_cooling_nt",
                column: series(&|_, both| branch(both)),
            },
            Candidate {
                name: sensitivity_branches,
                parameter: "warming_less_cooling_ppm",
                column: series(&|run, both| times_field(run, branch(both))),
            },
        ]);
    }
    let product =
        |both: &[Vec<f64>; 2]| -> Vec<f64> { both[0].iter().zip(&both[1]).map(|(s, e)| s * e).collect() };
    all.push(Candidate {
        name: "offset_product",
        parameter: "product_nt_per_k2",
        column: series(&|_, both| product(both)),
    });
    all.push(Candidate {
        name: "sensitivity_product",
        parameter: "product_ppm_per_k2",
        column: series(&|run, both| times_field(run, product(both))),
    });
    all
}

fn describe(
    heated: &Heated<'_>,
    lags: &lag::Lagged<'_, '_>,
    fit: &Fit,
    (levels, each): (&[Level], &Fit),
    found: &mut TemperatureFit,
) {
    for part in &heated.parts {
        let at = usize::from(*part == Part::Electronics);
        let values = || {
            let each = heated.runs.iter().zip(&heated.warmer);
            each.flat_map(|(run, both)| run.rows.iter().map(|row| both[at][*row]).collect::<Vec<_>>())
        };
        let reference = found.reference_c[at].unwrap_or(0.0);
        let mut result = TemperatureOfPart {
            range_c: [
                reference + values().fold(f64::INFINITY, f64::min),
                reference + values().fold(f64::NEG_INFINITY, f64::max),
            ],
            three_point: levels::three_point(levels, each, *part),
            ..TemperatureOfPart::default()
        };
        for (number, kinds) in part.kinds().into_iter().enumerate() {
            let linear = lags.linear(kinds).map(|at| fit.quantity(at)).unwrap_or_default();
            let curvature = lags.index(kinds[0], 1);
            let quadratic = curvature.map(|at| fit.quantity(at));
            let p = curvature
                .map(|at| stats::two_sided_p(fit.values[at] / fit.type_a(at), fit.noise.degrees_of_freedom));
            let lag = lags.index(kinds[1], 1).map(|at| fit.quantity(at));
            if let (Some(c), Some(q)) = (lags.linear(kinds), curvature)
                && p.is_some_and(|p| p < FOUND_BELOW)
                && lag.is_none()
            {
                let (value, std) = extremum(fit, c, q);
                let quantity = Quantity::new(reference + value, std);
                if (result.range_c[0]..=result.range_c[1]).contains(&quantity.value()) {
                    let name = ["sensitivity", "offset"][number].to_string();
                    result.extrema_c.insert(name, quantity);
                }
            }
            result.lag_s = result.lag_s.or(lag);
            if number == 0 {
                (result.sensitivity_ppm_per_k, result.sensitivity_ppm_per_k2) = (linear, quadratic);
                result.sensitivity_curvature_p = p;
            } else {
                (result.offset_nt_per_k, result.offset_nt_per_k2) = (linear, quadratic);
                result.offset_curvature_p = p;
            }
        }
        result.lag = lags.words(*part);
        match part {
            Part::Sensor => found.sensor = Some(result),
            Part::Electronics => found.electronics = Some(result),
        }
    }
}

/// Where c ΔT + q ΔT² stands still: −c/(2q), K from the reference, with its standard uncertainty.
fn extremum(fit: &Fit, c: usize, q: usize) -> (f64, f64) {
    let (linear, quadratic) = (fit.values[c], fit.values[q]);
    let at = -linear / (2.0 * quadratic);
    let by = [-0.5 / quadratic, 0.5 * linear / quadratic.powi(2)];
    let variance = by[0].powi(2) * fit.covariance(c, c)
        + by[1].powi(2) * fit.covariance(q, q)
        + 2.0 * by[0] * by[1] * fit.covariance(c, q);
    (at, variance.max(0.0).sqrt())
}

/// Temperatures at which k or O of all sensors stand still, within the uncertainty of each.
pub fn common_extrema(sensors: &PerAxis<SensorCalibration>) -> Vec<CommonExtremum> {
    let mut common = Vec::new();
    for part in Part::ALL {
        for quantity in ["sensitivity", "offset"] {
            let fits = sensors.iter().filter_map(|(_, sensor)| sensor.temperature.as_ref());
            let parts: Vec<&TemperatureOfPart> = fits
                .filter_map(|fit| match part {
                    Part::Sensor => fit.sensor.as_ref(),
                    Part::Electronics => fit.electronics.as_ref(),
                })
                .collect();
            let extrema: Vec<(f64, f64)> = parts
                .iter()
                .filter_map(|of| of.extrema_c.get(quantity))
                .filter_map(|at| Some((at.value(), at.std()?)))
                .collect();
            if extrema.len() < 2 || extrema.len() < parts.len() {
                continue;
            }
            let sum: f64 = extrema.iter().map(|(_, std)| std.powi(-2)).sum();
            let mean = extrema.iter().map(|(at, std)| at / (std * std)).sum::<f64>() / sum;
            let chi = extrema.iter().map(|(at, std)| ((at - mean) / std).powi(2)).sum();
            let p_value = stats::chi_squared_p(chi, extrema.len() as f64 - 1.0);
            if p_value >= FOUND_BELOW {
                common.push(CommonExtremum {
                    part: part.name().into(),
                    quantity: quantity.into(),
                    temperature_c: Quantity::new(mean, sum.recip().sqrt()),
                    p_value,
                });
            }
        }
    }
    common
}

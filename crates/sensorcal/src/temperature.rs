//! k and O against the temperatures of sensor and electronics (NASA eq. 28 and 29).

use common::{
    Code, CommonExtremum, Document, FitNoise, PerAxis, Quantity, SensorCalibration, TemperatureFit,
    TemperatureOfPart, procedure,
};
use estimate::stats;
use physics::{EffectInstance, Kind, Parameter};

use crate::Result;
use crate::allowed::Allowed;
use crate::conditions::Conditions;
use crate::departure::{self, Candidate, FOUND_BELOW};
use crate::fit::{self, Fit, Problem, Unknown};
use crate::heated::{self, Heated, KINDS, Lagged, distinct};
use crate::levels::{self, Level};
use crate::readings::{Run, along, code_width, runs};
use crate::shape::{Place, Subject};
use crate::sizes::Sized;

/// Coefficients of a sensor, and what the other procedures need of them; None without a recording.
pub fn coefficients(of: Subject<'_>) -> Result<Option<(TemperatureFit, Conditions)>> {
    let Subject { document, references, sensor, .. } = of;
    let runs = runs(document, references, procedure::TEMPERATURE_RUN, sensor)?;
    if runs.is_empty() {
        return Ok(None);
    }
    let references = runs[0].context.references;
    let mut found = TemperatureFit {
        recordings: runs.iter().map(|run| run.context.recording.id.clone()).collect(),
        reference_c: [references.sensor_c, references.electronics_c],
        ..TemperatureFit::default()
    };
    let heated = Heated::of(runs, &mut found.findings)?;
    if heated.parts.is_empty() {
        return Ok(Some((found, Conditions::none())));
    }
    let first = &heated.runs[0];
    let shape = of.shape(code_width(document, first) * first.basic.sensors[sensor.index()].sensitivity);
    let allowed = fit::noise(&heated.runs, &shape, Place::Coils)?;
    let candidates = candidates(&heated);
    let problem = problem(document, &heated, &allowed)?;
    let allowed = departure::noise_called_for(&problem, &candidates)?;
    let problem = Problem { allowed: &allowed, ..problem };
    let lags = heated::look(&problem, &heated, sensor)?;
    // A lag that was found explains what noise of the field had to explain without it.
    let allowed = departure::noise_called_for(&lags.problem, &candidates)?;
    let lagged = Problem { allowed: &allowed, ..lags.problem.clone() };
    let first = lagged.solve()?;
    let effect = |at: &usize| matches!(lagged.unknowns[*at], Unknown::Chain(Parameter::Effect(..), _));
    let places: Vec<usize> = (0..lagged.unknowns.len()).filter(effect).collect();
    let sized = Sized::of(allowed.clone(), &first, &heated.runs, (&shape, Place::Coils))?;
    let mut extended = departure::extend(&Problem { allowed: &sized.allowed, ..lagged }, &candidates)?;
    let (degrees_of_freedom, coverage_factor_95) = sized.freedom(&extended.fit, &places)?;
    extended.fit.noise = FitNoise { degrees_of_freedom, coverage_factor_95, ..extended.fit.noise };
    let (levels, each, columns) = levels::at_temperatures(&heated, &shape)?;
    describe(&heated, &lags, &extended.fit, (&levels, &each), &mut found);
    found.departures = extended.departures;
    found.levels = columns;
    found.noise = extended.fit.noise.clone();
    for name in &extended.found {
        let text = Code::Departure.about(name).said(format!(
            "besides the polynomials, the readings show {}, fitted jointly with them",
            name.replace('_', " ")
        ));
        found.findings.push(text);
    }
    let (conditions, order) = heated::conditions(&lags.problem, &extended.fit, sensor);
    found.covariance = common::covariance::rows(&conditions.covariance);
    found.covariance_order = order;
    Ok(Some((found, conditions)))
}

/// The effects of temperature, common to all runs, each run with its own k and O, and the polynomial of the
/// sensor. Of the effects of the parts that moved, a curvature is sought from three temperatures on.
fn problem<'p, 'b>(
    document: &Document,
    heated: &'p Heated<'b>,
    allowed: &'p Allowed,
) -> Result<Problem<'p, 'b>> {
    let sensor = heated.runs[0].sensor;
    let all: Vec<usize> = (0..heated.runs.len()).collect();
    let (mut effects, mut unknowns) = (Vec::new(), Vec::new());
    for part in &heated.parts {
        // The sensitivity first, then the offset.
        for (kinds, driven) in KINDS[*part].into_iter().zip([true, false]) {
            let at = effects.len();
            effects.push(EffectInstance::new(kinds[0], Some(sensor), vec![0.0; 2]));
            unknowns.push(Unknown::Chain(Parameter::Effect(at, 0), all.clone()));
            if distinct(heated, *part, driven) > 2 {
                unknowns.push(Unknown::Chain(Parameter::Effect(at, 1), all.clone()));
            }
        }
    }
    for run in all {
        unknowns.push(Unknown::Chain(Parameter::Sensitivity(sensor), vec![run]));
        unknowns.push(Unknown::Chain(Parameter::SensorOffset(sensor), vec![run]));
    }
    unknowns.extend(levels::polynomial(&heated.runs));
    let known = fit::coils(document, &heated.runs)?;
    Ok(Problem { runs: &heated.runs, effects, unknowns, known, allowed })
}

/// What the polynomials in temperature may leave out: offset and sensitivity with the cube of the temperature
/// of sensor and of electronics, with the way that it had gone, and with both's product.
const CUBES: [[&str; 2]; 2] = [
    ["sensor_offset_cubic", "sensor_sensitivity_cubic"],
    ["electronics_offset_cubic", "electronics_sensitivity_cubic"],
];
const BRANCHES: [[&str; 2]; 2] = [
    ["sensor_offset_branches", "sensor_sensitivity_branches"],
    ["electronics_offset_branches", "electronics_sensitivity_branches"],
];
const PRODUCTS: [&str; 2] = ["offset_product", "sensitivity_product"];

fn candidates(heated: &Heated<'_>) -> Vec<Candidate> {
    let mut all = Vec::new();
    for at in heated.parts.iter().copied() {
        let cubes = |both: &[Vec<f64>; 2]| both[at].iter().map(|t| t.powi(3)).collect();
        all.extend(both_candidates(heated, CUBES[at], ["cubic_nt_per_k3", "cubic_ppm_per_k3"], cubes));
        let parameters = ["warming_less_cooling_nt", "warming_less_cooling_ppm"];
        let branches = |both: &[Vec<f64>; 2]| levels::branches(&both[at]);
        all.extend(both_candidates(heated, BRANCHES[at], parameters, branches));
    }
    let product = |both: &[Vec<f64>; 2]| both[0].iter().zip(&both[1]).map(|(s, e)| s * e).collect();
    all.extend(both_candidates(heated, PRODUCTS, ["product_nt_per_k2", "product_ppm_per_k2"], product));
    all
}

/// A function of both temperatures as part of the offset, nT, and of the sensitivity, ppm.
fn both_candidates(
    heated: &Heated<'_>,
    names: [&'static str; 2],
    parameters: [&'static str; 2],
    of: impl Fn(&[Vec<f64>; 2]) -> Vec<f64>,
) -> [Candidate; 2] {
    let offset: Vec<Vec<f64>> = heated.warmer.iter().map(of).collect();
    let times_field = |(run, column): (&Run<'_>, &Vec<f64>)| {
        along(run).iter().zip(column).map(|(b, c)| b * c * 1e-6).collect::<Vec<f64>>()
    };
    let sensitivity = heated.runs.iter().zip(&offset).map(times_field).collect();
    [
        Candidate { name: names[0], parameter: parameters[0], column: offset },
        Candidate { name: names[1], parameter: parameters[1], column: sensitivity },
    ]
}

fn describe(
    heated: &Heated<'_>,
    lags: &Lagged<'_, '_>,
    fit: &Fit,
    (levels, each): (&[Level], &Fit),
    found: &mut TemperatureFit,
) {
    for at in heated.parts.iter().copied() {
        let runs = heated.runs.iter().zip(&heated.warmer);
        let values = runs.flat_map(|(run, both)| run.rows.iter().map(move |row| both[at][*row]));
        let reference = found.reference_c[at].unwrap_or(0.0);
        let mut result = TemperatureOfPart {
            range_c: [
                reference + values.clone().fold(f64::INFINITY, f64::min),
                reference + values.fold(f64::NEG_INFINITY, f64::max),
            ],
            three_point: levels::three_point(levels, each, at),
            ..TemperatureOfPart::default()
        };
        for (number, kinds) in KINDS[at].into_iter().enumerate() {
            let place = |kind: Kind, parameter: usize| lags.problem.place(kind, parameter);
            // At once, or with a lag.
            let slope = place(kinds[0], 0).or_else(|| place(kinds[1], 0));
            let linear = slope.map(|at| fit.quantity(at)).unwrap_or_default();
            let curvature = place(kinds[0], 1);
            let quadratic = curvature.map(|at| fit.quantity(at));
            let p = curvature
                .map(|at| stats::two_sided_p(fit.values[at] / fit.type_a(at), fit.noise.degrees_of_freedom));
            let lag = place(kinds[1], 1).map(|at| fit.quantity(at));
            if let (Some(c), Some(q)) = (slope, curvature)
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
        result.lag = lags.words[at].clone();
        *[&mut found.sensor, &mut found.electronics][at] = Some(result);
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
    let fits: Vec<&TemperatureFit> =
        sensors.iter().filter_map(|(_, sensor)| sensor.temperature.as_deref()).collect();
    let of_sensor = fits.iter().filter_map(|fit| fit.sensor.as_ref()).collect::<Vec<_>>();
    let of_electronics = fits.iter().filter_map(|fit| fit.electronics.as_ref()).collect();
    for (part, parts) in [("sensor", of_sensor), ("electronics", of_electronics)] {
        for quantity in ["sensitivity", "offset"] {
            let known = parts.iter().filter_map(|of| of.extrema_c.get(quantity));
            let extrema: Vec<(f64, f64)> = known.filter_map(|at| Some((at.value(), at.std()?))).collect();
            if extrema.len() < 2 || extrema.len() < parts.len() {
                continue;
            }
            let sum: f64 = extrema.iter().map(|(_, std)| std.powi(-2)).sum();
            let mean = extrema.iter().map(|(at, std)| at / (std * std)).sum::<f64>() / sum;
            let chi = extrema.iter().map(|(at, std)| ((at - mean) / std).powi(2)).sum();
            let p_value = stats::chi_squared_p(chi, extrema.len() as f64 - 1.0);
            if p_value >= FOUND_BELOW {
                common.push(CommonExtremum {
                    part: part.into(),
                    quantity: quantity.into(),
                    temperature_c: Quantity::new(mean, sum.recip().sqrt()),
                    p_value,
                });
            }
        }
    }
    common
}

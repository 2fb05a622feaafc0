//! One instrument by itself, without anything to compare it with: what can be said of its temperature, and
//! what not.

use serde_json::{Value, json};

use crate::Error;
use crate::page::{Page, three, verdict};
use crate::series::{Series, mean, rms};
use crate::stages::Stages;

const HAMSCI: &str = include_str!("../../../../fixtures/ingest/real/hamsci.json");
const MARG: &str = include_str!("../../../../fixtures/ingest/real/marg.json");
const MARG_TEMPERATURE: &str = include_str!("../../../../fixtures/real/marg-temperature.json");

/// The mean of each sensor as what its offset is to take away: nothing says what the field is, so only
/// changes are looked at.
fn levels(series: &Series) -> Value {
    let sensors: Value = ["x", "y", "z"]
        .into_iter()
        .map(|axis| {
            let level = mean(series.column(&format!("sensor_{axis}_nt")).iter().copied());
            (axis.to_string(), json!({"offset_nt": -level}))
        })
        .collect();
    json!({"calibration": {"sensors": sensors}})
}

fn spread(series: &Series, column: &str) -> f64 {
    let values = series.column(column);
    let level = mean(values.iter().copied());
    rms(values.iter().map(|value| value - level))
}

fn ask(stages: &Stages, page: &mut Page, id: &str, series: &Series) -> Result<(), Error> {
    match stages.stage("diagnose", &[], vec![series.recording(id, "free_run")], &levels(series))? {
        Ok(document) => {
            page.head(format!("{id}: {}.", verdict(&document)));
            page.diagnosis(&document);
        }
        Err(words) => page.refused("diagnose", &words),
    }
    Ok(())
}

/// W2NAF: sixteen hours before the storm, then the whole day.
pub fn w2naf(stages: &Stages) -> Result<Page, Error> {
    let file = stages.file("hamsci-w2naf-2024-05-10/w2naf-20240510-runmag.csv")?;
    let day = stages.ingest(&[file], Some(HAMSCI))?.means(120.0);
    let time = day.column("time_s").to_vec();
    let quiet = day.filter(|row| time[row] < 16.0 * 3600.0);
    let mut page = Page::default();
    page.say(format!(
        "Means of two minutes. Before the storm (0 to 16 h) x, y, z change by {}, {}, {} nT rms, the sensor's temperature by {} K and the electronics' by {} K rms.",
        three(spread(&quiet, "sensor_x_nt")),
        three(spread(&quiet, "sensor_y_nt")),
        three(spread(&quiet, "sensor_z_nt")),
        three(spread(&quiet, "sensor_temperature_c")),
        three(spread(&quiet, "electronics_temperature_c")),
    ));
    page.say("The quiet hours:");
    ask(stages, &mut page, "quiet", &quiet)?;
    page.say("The whole day, with the storm:");
    ask(stages, &mut page, "day", &day)?;
    page.undecided(
        "a temperature coefficient of any size that is plausible for an RM3100: the daily variation of the field, the Sun and the \
        temperature have the same period, the temperature of the sensor changed by half a degree, and there is no second instrument. Any \
        effect named here would be a guess; data from an observatory, or a heater, would decide.",
    );
    Ok(page)
}

/// HMC5883L at rest.
pub fn marg(stages: &Stages) -> Result<Page, Error> {
    let file = |name: &str| stages.file(&format!("marg-hmc5883l-sunsided/{name}"));
    let field = stages.ingest(&[file("set2_static_10min_mag.csv")?], Some(MARG))?.means_of_all(1.0);
    let thermometer = stages
        .ingest(&[file("set2_static_10min_temp_decim10.csv")?], Some(MARG_TEMPERATURE))?
        .means_of_all(1.0);
    let both = field.joined(&thermometer).complete();
    let mut page = Page::default();
    page.say(format!(
        "Means of a second of {} s; the thermometer of another chip on the board moves by {} K rms, the readings by {}, {}, {} nT rms; a code is about 92 nT.",
        both.rows(),
        three(spread(&both, "sensor_temperature_c")),
        three(spread(&both, "sensor_x_nt")),
        three(spread(&both, "sensor_y_nt")),
        three(spread(&both, "sensor_z_nt")),
    ));
    ask(stages, &mut page, "static", &both)?;
    page.undecided(
        "whether the slow change of some tens of nT is slow noise, the warming chip, the current of the board, or something moved indoors: \
        the temperature falls with time, and nothing else measures the field.",
    );
    Ok(page)
}

//! Golden documents, a line a case. BLESS=1 writes them anew; read the difference before it is kept. The
//! values themselves are held against the made-up field from which the files were written.

use common::{Document, to_text};
use ingest::{Mapping, Options, Readings, run};
use std::path::PathBuf;

fn of(files: &[&str], options: Options) -> Document {
    let files: Vec<PathBuf> = files.iter().map(|name| testkit::fixture("ingest").join(name)).collect();
    let document = Document { fluxcal: 1, ..Document::default() };
    run(document, &files, &options).unwrap_or_else(|error| panic!("{files:?}: {error}")).document
}

fn mapped(by: &str) -> Options {
    let mapping = testkit::read_fixture(&format!("ingest/{by}-map.json"));
    Options { mapping: Some(Mapping::parse(&mapping).expect("a mapping")), ..Options::default() }
}

fn outside() -> Options {
    Options { quantity: "outside".into(), id: Some("station".into()), ..Options::default() }
}

const MINUTES: [&str; 2] = ["flx20240310b.min", "flx20240310a.min"];

#[test]
fn golden() {
    let case = |name: &str, files: &[&str], options: Options| {
        testkit::golden(&format!("ingest/{name}"), "ingest/counts-map.json", |_| {
            to_text(&of(files, options))
        });
    };
    case("minutes", &MINUTES, Options::default());
    case("horizontal", &["flx20240310v.min"], outside());
    case("half-seconds", &["lemi.sec"], Options::default());
    case("logger", &["logger.csv"], Options::default());
    case("counts", &["counts.txt"], mapped("counts"));
    case("ndjson", &["field.ndjson"], Options::default());
    case("parquet", &["field.parquet"], Options::default());
    case("spreadsheet", &["spreadsheet.csv"], Options::default());
    case("codes", &["codes.csv"], mapped("codes"));
    case("imagcdf", &["imagcdf.cdf"], Options::default());
    case("imagcdf-hdz", &["imagcdf-hdz.cdf"], Options::default());
    case("mission", &["mission.cdf"], Options::default());
    case("mission-compressed", &["mission-compressed.cdf"], Options::default());
    case("pcdcp", &["bou20241101.pcdcp"], Options::default());
    case("usgs", &["usgs.json"], Options::default());
    case("magpy-pystr", &["magpy-pystr.txt"], Options::default());
    case("magpy-pyascii", &["magpy-pyascii.txt"], Options::default());
    case("iaf", &["iaf.bin"], Options { readings: Readings::Beside(None), ..Options::default() });
    case("iaf-hdzf", &["iaf-hdzf.bin"], Options { readings: Readings::Beside(None), ..outside() });
    case("imf", &["flx20240310.imf"], Options::default());
    case("ibf", &["flx2024.blv"], Options::default());
    case("ibf-old", &["flx99.blv"], Options::default());
    case("absolute", &["absolute-deg.txt", "absolute-null.txt"], Options::default());
    case("absolute-usgs", &["absolute.json"], Options::default());
    case("hapi", &["hapi.csv"], Options::default());
    case("beside", &["lemi.sec"], Options { readings: Readings::Beside(None), ..Options::default() });
}

/// X, Y, Z and F of the made-up field, nT, two decimals.
fn field(row: f64) -> [f64; 4] {
    let cents = |value: f64| (100.0 * value).round() / 100.0;
    let (x, y, z) = (
        20_900.0 + 8.0 * (row / 9.0).sin(),
        1400.0 + 5.0 * (row / 7.0).cos(),
        43_800.0 + 3.0 * (row / 11.0).sin(),
    );
    [cents(x), cents(y), cents(z), cents((x * x + y * y + z * z).sqrt() + 1.5)]
}

/// Columns in that order against the field at each time; the number of values that are there.
fn against(document: &Document, names: [&str; 4], step_s: f64, off_nt: f64) -> usize {
    let recording = &document.recordings[0];
    let times = recording.column("time_s").expect("times");
    let mut count = 0;
    for (axis, name) in names.into_iter().enumerate() {
        let Some(values) = recording.column(name) else { continue };
        for (time, value) in times.iter().zip(values).filter(|(_, value)| !value.is_nan()) {
            let expected = field((time / step_s).round())[axis];
            assert!((value - expected).abs() <= off_nt, "{name} at {time} s: {value} and {expected}");
            count += 1;
        }
    }
    count
}

#[test]
fn the_field_comes_back() {
    let sensor = ["sensor_x_nt", "sensor_y_nt", "sensor_z_nt", "reference_nt"];
    let outside_names = ["outside_x_nt", "outside_y_nt", "outside_z_nt", "reference_nt"];
    assert_eq!(against(&of(&MINUTES, Options::default()), sensor, 60.0, 0.0), 4 * 65 - 2);
    // H to a hundredth of a nanotesla, D to a hundredth of a minute of arc: 0.06 nT.
    assert_eq!(against(&of(&["flx20240310v.min"], outside()), outside_names, 60.0, 0.04), 40);
    assert_eq!(against(&of(&["lemi.sec"], Options::default()), sensor, 1.0, 0.0), 60);
    // Five decimals of a microtesla.
    assert_eq!(against(&of(&["logger.csv"], Options::default()), sensor, 30.0, 1e-10), 3 * 24);
    assert_eq!(against(&of(&["field.ndjson"], Options::default()), sensor, 0.5, 0.0), 63);
    assert_eq!(against(&of(&["field.parquet"], Options::default()), sensor, 0.5, 0.0), 63);
    assert_eq!(against(&of(&["spreadsheet.csv"], Options::default()), sensor, 60.0, 0.0), 3 * 30);
    // The scalar has every other second, and a component one fill value.
    assert_eq!(against(&of(&["imagcdf.cdf"], Options::default()), sensor, 1.0, 0.0), 3 * 30 - 1 + 15);
    assert_eq!(against(&of(&["imagcdf-hdz.cdf"], Options::default()), sensor, 1.0, 1e-9), 3 * 12 - 2);
    assert_eq!(against(&of(&["bou20241101.pcdcp"], Options::default()), sensor, 60.0, 0.0), 4 * 20 - 1);
    assert_eq!(against(&of(&["usgs.json"], Options::default()), sensor, 60.0, 1e-8), 4 * 20 - 1);
    // Tenths of a nanotesla, and of a minute of arc: 0.3 nT.
    assert_eq!(against(&of(&["iaf.bin"], inline()), sensor, 60.0, 0.1), 4 * 2880 - 6);
    assert_eq!(against(&of(&["iaf-hdzf.bin"], inline()), sensor, 60.0, 0.35), 4 * 1440 - 2);
    assert_eq!(against(&of(&["flx20240310.imf"], Options::default()), sensor, 60.0, 0.07), 4 * 119);
    assert_eq!(against(&of(&["hapi.csv"], Options::default()), sensor, 60.0, 0.0), 4 * 20 - 1);
    // Single precision.
    assert_eq!(against(&of(&["mission.cdf"], Options::default()), sensor, 0.25, 0.002), 3 * 40 - 1);
    let codes = of(&["codes.csv"], mapped("codes"));
    assert_eq!(against(&codes, sensor, 1.0, 0.005_000_001), 3 * 20 - 1);
    assert_eq!(codes.recordings[0].start.as_deref(), Some("2025-03-14T23:59:50Z"));
    let temperature = codes.recordings[0].column("sensor_temperature_c").expect("a temperature");
    assert!(temperature[5].is_nan() && temperature.iter().filter(|value| **value == 21.5).count() == 19);
    // Half a count of 13.5 nT; z is 20 000 nT above what was recorded.
    let counts = of(&["counts.txt"], mapped("counts"));
    assert_eq!(counts.recordings[0].column("sensor_z_nt").expect("z")[0], 3244.0 * 13.5 + 20_000.0);
    assert_eq!(counts.recordings[0].column("sensor_x_nt").expect("x")[0], 1548.0 * 13.5);
    assert!(counts.recordings[0].column("sensor_y_nt").expect("y")[3].is_nan());
}

fn inline() -> Options {
    Options { readings: Readings::Inline, ..Options::default() }
}

/// Files of INTERMAGNET's formats as MagPy reads them (fixtures/reference/ingest/intermagnet.py).
#[test]
fn as_magpy_reads_intermagnet() {
    let expected: serde_json::Value =
        serde_json::from_str(&testkit::read_fixture("reference/ingest/intermagnet.json")).expect("JSON");
    let mut count = 0;
    for (file, columns) in expected["files"].as_object().expect("files") {
        let document = of(&[file], inline());
        for (name, values) in columns.as_object().expect("columns") {
            let found = document.recordings[0].column(name).unwrap_or_else(|| panic!("{file}: {name}"));
            for pair in values.as_array().expect("values") {
                let found = found[pair[0].as_u64().expect("a row") as usize];
                let close = pair[1].as_f64().map_or(found.is_nan(), |value| (value - found).abs() < 1e-9);
                assert!(close, "{file}, {name}: {found} for {pair}");
                count += 1;
            }
        }
    }
    assert_eq!(count, 374);
}

/// Files that MagPy wrote, as MagPy reads them (fixtures/reference/ingest/agencies.py).
#[test]
fn as_magpy_reads_its_own() {
    let expected: serde_json::Value =
        serde_json::from_str(&testkit::read_fixture("reference/ingest/magpy.json")).expect("JSON");
    let names = ["sensor_x_nt", "sensor_y_nt", "sensor_z_nt", "reference_nt", "sensor_temperature_c"];
    let mut count = 0;
    for (file, columns) in expected["files"].as_object().expect("files") {
        let document = of(&[file], Options::default());
        let recording = &document.recordings[0];
        assert_eq!(recording.start.as_deref(), Some("2024-11-01T00:00:00Z"), "{file}");
        // Keys of PYASCII are MagPy's in the order of the columns, not the names that the file states.
        for (values, name) in columns.as_object().expect("columns").values().zip(names) {
            let values = values.as_array().expect("values");
            let found = recording.column(name).unwrap_or_else(|| panic!("{file}: {name}"));
            assert_eq!(found.len(), values.len(), "{file}");
            for (found, expected) in found.iter().zip(values) {
                assert!(
                    expected.as_f64().map_or(found.is_nan(), |value| *found == value),
                    "{file}, {name}: {found} {expected}"
                );
                count += 1;
            }
        }
    }
    assert_eq!(count, 300);
}

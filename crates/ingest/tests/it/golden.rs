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
        let name = format!("ingest/{name}");
        testkit::golden(&name, "ingest/counts-map.json", |_| to_text(&of(files, options)));
    };
    for (name, file) in [
        ("half-seconds", "lemi.sec"),
        ("logger", "logger.csv"),
        ("ndjson", "field.ndjson"),
        ("parquet", "field.parquet"),
        ("spreadsheet", "spreadsheet.csv"),
        ("imagcdf", "imagcdf.cdf"),
        ("imagcdf-hdz", "imagcdf-hdz.cdf"),
        ("mission", "mission.cdf"),
        ("mission-compressed", "mission-compressed.cdf"),
        ("pcdcp", "bou20241101.pcdcp"),
        ("usgs", "usgs.json"),
        ("magpy-pystr", "magpy-pystr.txt"),
        ("magpy-pyascii", "magpy-pyascii.txt"),
        ("imf", "flx20240310.imf"),
        ("ibf", "flx2024.blv"),
        ("ibf-old", "flx99.blv"),
        ("absolute-usgs", "absolute.json"),
        ("hapi", "hapi.csv"),
    ] {
        case(name, &[file], Options::default());
    }
    let beside = || Options { readings: Readings::Beside(None), ..Options::default() };
    case("minutes", &MINUTES, Options::default());
    case("horizontal", &["flx20240310v.min"], outside());
    case("counts", &["counts.txt"], mapped("counts"));
    case("codes", &["codes.csv"], mapped("codes"));
    case("iaf", &["iaf.bin"], beside());
    case("iaf-hdzf", &["iaf-hdzf.bin"], Options { readings: Readings::Beside(None), ..outside() });
    case("absolute", &["absolute-deg.txt", "absolute-null.txt"], Options::default());
    case("beside", &["lemi.sec"], beside());
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
    let of_file = |files: &[&str], step_s: f64, off_nt: f64, count: usize| {
        let names = ["sensor_x_nt", "sensor_y_nt", "sensor_z_nt", "reference_nt"];
        assert_eq!(against(&of(files, inline()), names, step_s, off_nt), count, "{files:?}");
    };
    of_file(&MINUTES, 60.0, 0.0, 4 * 65 - 2);
    of_file(&["lemi.sec"], 1.0, 0.0, 60);
    // Five decimals of a microtesla.
    of_file(&["logger.csv"], 30.0, 1e-10, 3 * 24);
    of_file(&["field.ndjson"], 0.5, 0.0, 63);
    of_file(&["field.parquet"], 0.5, 0.0, 63);
    of_file(&["spreadsheet.csv"], 60.0, 0.0, 3 * 30);
    // The scalar has every other second, and a component one fill value.
    of_file(&["imagcdf.cdf"], 1.0, 0.0, 3 * 30 - 1 + 15);
    of_file(&["imagcdf-hdz.cdf"], 1.0, 1e-9, 3 * 12 - 2);
    of_file(&["bou20241101.pcdcp"], 60.0, 0.0, 4 * 20 - 1);
    of_file(&["usgs.json"], 60.0, 1e-8, 4 * 20 - 1);
    // Tenths of a nanotesla, and of a minute of arc: 0.3 nT.
    of_file(&["iaf.bin"], 60.0, 0.1, 4 * 2880 - 6);
    of_file(&["iaf-hdzf.bin"], 60.0, 0.35, 4 * 1440 - 2);
    of_file(&["flx20240310.imf"], 60.0, 0.07, 4 * 119);
    of_file(&["hapi.csv"], 60.0, 0.0, 4 * 20 - 1);
    // Single precision.
    of_file(&["mission.cdf"], 0.25, 0.002, 3 * 40 - 1);
    // H to a hundredth of a nanotesla, D to a hundredth of a minute of arc: 0.06 nT.
    let names = ["outside_x_nt", "outside_y_nt", "outside_z_nt", "reference_nt"];
    assert_eq!(against(&of(&["flx20240310v.min"], outside()), names, 60.0, 0.04), 40);
    let names = ["sensor_x_nt", "sensor_y_nt", "sensor_z_nt", "reference_nt"];
    let codes = of(&["codes.csv"], mapped("codes"));
    assert_eq!(against(&codes, names, 1.0, 0.005_000_001), 3 * 20 - 1);
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

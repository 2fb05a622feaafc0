//! The report's Table 4: the values that were misprinted are located, and nothing else is claimed.

use common::Document;
use diagnose::Options;

#[test]
fn the_wrong_values_of_table_4_are_located() {
    let document =
        Document::parse(&testkit::read_fixture("nasa-1977/table-4.json")).expect("a good document");
    let document = axescal::run(document, &axescal::Options::default()).expect("directions");
    let found = diagnose::run(document, &Options::default()).expect("diagnosed");
    println!("{}", diagnose::summary(&found));
    let entry = found.diagnosis.expect("a diagnosis").remove(0);
    let readings: Vec<(String, String, usize)> = entry
        .places
        .iter()
        .flat_map(|share| &share.readings)
        .map(|reading| (reading.recording.clone(), reading.column.clone(), reading.row))
        .collect();
    // The 29th: orientation 4, coil 1, sensor 2. The 4th, which the scan has wrong: orientation 1, coil 2,
    // sensor 1.
    assert!(readings.contains(&("orientation-4".into(), "sensor_y_v".into(), 0)), "{readings:?}");
    assert!(readings.contains(&("orientation-1".into(), "sensor_x_v".into(), 1)), "{readings:?}");
    let [spikes] = &entry.effects[..] else { panic!("{:?}", entry.effects) };
    assert_eq!(spikes.list.len(), readings.len(), "{:?}", spikes.list);
}

//! Numbers from outside: measurements whose readings and results were published (`fixtures/reference/absolute_usgs.py`).

use absolute::run;
use common::Document;
use serde_json::{Value, json};
use testkit::reference::{list, number, reference};

/// Two solvers of one problem of least squares agree to this, degrees.
const SOLVERS_DEG: f64 = 5e-8;
/// The same of MagPy's results as they are written there.
const MAGPY_DEG: f64 = 5e-7;
/// The same, nT.
const SOLVERS_NT: f64 = 1e-5;

/// The baseline values of a recording with 3″ for each circle.
fn found(one: &Value) -> Value {
    let document =
        json!({"fluxcal": 1, "facility": {"theodolite_arcsec": 3.0}, "recordings": [one["recording"]]});
    let document = Document::parse(&document.to_string()).expect("a document");
    let document = run(document).unwrap_or_else(|error| panic!("{error}"));
    let set = document.calibration.and_then(|all| all.absolute).expect("measurements").sets.remove(0);
    set.baseline.iter().map(|(key, quantity)| (key.clone(), json!(quantity.value()))).collect()
}

fn unit(key: &str) -> &str {
    key.rsplit_once('_').expect("a unit").1
}

/// Within a tolerance in degrees or in nT, by the key.
fn near(id: &Value, key: &str, found: f64, expected: f64, [deg, nt]: [f64; 2]) {
    let tolerance = if unit(key) == "deg" { deg } else { nt };
    assert!((found - expected).abs() <= tolerance, "{id} {key}: {found} where {expected} is expected");
}

#[test]
fn readings_and_results_of_observatories() {
    let all = reference("absolute_usgs");
    assert_eq!((list(&all["usgs"]).len(), list(&all["wic"]).len()), (3, 2));
    let [usgs, wic] = ["usgs", "wic"].map(|of| list(&all[of]).iter().map(move |one| (one, of == "usgs")));
    for (one, is_usgs) in usgs.chain(wic) {
        let (id, found) = (&one["recording"]["id"], found(one));
        for key in ["h_nt", "d_deg", "z_nt"] {
            let of = |what: &str| number(&one[what][key]);
            let bound = number(&one["bound"][unit(key)]);
            // The same problem by SciPy, then the exact formulas of four positions, which agree to first order; the script
            // derives the bound, and that the linear formulas give the published values.
            near(id, key, number(&found[key]), of("least_squares"), [SOLVERS_DEG, SOLVERS_NT]);
            near(id, key, number(&found[key]), of("exact"), [bound, bound]);
            if !is_usgs {
                near(id, key, number(&found[key]), of("published"), [MAGPY_DEG + bound, bound]);
            }
        }
    }
}

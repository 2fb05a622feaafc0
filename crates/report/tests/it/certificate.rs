//! The certificate: as it stands, what is blank, what is pointed out, and its results against the document.

use common::Certificate;
use report::certificate::{Asked, Sheet};
use roxmltree::{Document as Xml, ParsingOptions};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;

use crate::{REPORT, fixture, magsat, parsed, same};

/// The campaign of MAGSAT with all administrative data.
fn complete() -> Value {
    let mut complete = fixture("specs/calibrated/input.json");
    complete["certificate"] = fixture("certificate/magsat.json");
    complete
}

fn sheet(document: &Value) -> Sheet {
    report::certificate::run(&parsed(document), &Asked::default()).expect("a certificate")
}

fn html(document: &Value) -> String {
    report::certificate::render(&sheet(document), None).expect("HTML")
}

/// The certificate of a document with these administrative data alone.
fn with(certificate: Value) -> String {
    html(&json!({"fluxcal": 1, "certificate": certificate}))
}

/// A blank line for a clause.
fn blank(clause: &str) -> String {
    format!("________________</span> <span class=\"clause\">({clause})")
}

/// The campaign of MAGSAT with all administrative data and a specification, a rotation in a meadow and an observatory
/// with none.
#[test]
fn golden() {
    let spec = magsat();
    let schema = jsonschema::validator_for(&common::schema::document()).expect("a schema");
    assert!(schema.is_valid(&complete()));
    for (name, document, spec, blank) in [
        ("magsat.html", complete(), Some((&spec, Some("1e"))), 0),
        ("blank.html", fixture("scalarcal/meadow/expected.json"), None, 25),
        ("observatory.html", fixture("report/observatory.json"), None, 25),
    ] {
        let document = parsed(&document);
        let findings = report::findings(&document).expect("findings");
        let asked = Asked { document_sha256: Some("0f"), findings: &findings, spec, ..Asked::default() };
        let sheet = report::certificate::run(&document, &asked).expect("a certificate");
        assert_eq!(sheet.blank().len(), blank, "{:?}", sheet.blank());
        assert!(blank > 0 || sheet.notes.is_empty(), "{:?}", sheet.notes);
        let found = report::certificate::render(&sheet, None).expect("HTML");
        let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
        Xml::parse_with_options(&found, options).unwrap_or_else(|error| panic!("{name}: {error}"));
        same(&format!("certificate/{name}"), &found);
    }
}

/// Each letter of 7.8.2.1 and of 7.8.4.1 stands on a certificate, filled in or blank.
#[test]
fn every_clause_is_answered() {
    for document in [complete(), fixture("scalarcal/meadow/expected.json"), json!({"fluxcal": 1})] {
        let html = html(&document);
        // The clauses as they are marked: "7.8.2.1 c, e, g to j" has five letters; what counts here is each
        // by itself.
        for letter in 'a'..='p' {
            let own = format!("(7.8.2.1 {letter})");
            assert!(html.contains(&own) || (letter == 'm' && html.contains("(7.8.2.1 m, p,")), "{own}");
        }
        for letter in 'b'..='f' {
            assert!(html.contains(&format!("7.8.4.1 {letter}")), "7.8.4.1 {letter}");
        }
        for clause in ["7.8.2.2", "7.8.4.1 a", "7.8.4.2", "7.8.4.3", "7.8.6", "7.8.7"] {
            assert!(html.contains(clause), "{clause}");
        }
    }
}

#[test]
fn an_empty_text_says_none_and_an_absent_one_is_blank() {
    assert!(with(json!({"deviations": "", "external_results": []})).matches("<p>None.</p>").count() == 2);
    let absent = with(json!({"number": "  "}));
    assert!(!absent.contains("None.") && absent.contains(&blank("7.8.2.1 n")));
    assert!(absent.contains("No. <span class=\"blank\">"));
}

#[test]
fn sampling_by_the_laboratory_has_its_fields_or_a_blank() {
    assert!(with(json!({})).contains(&blank("7.8.4.2")));
    assert!(with(json!({"sampling": "by the customer"})).contains(&blank("7.8.4.2")));
    for none in [json!({"sampling": ""}), json!({"sampling": "by the customer", "sampled": []})] {
        let page = with(none);
        assert!(!page.contains(&blank("7.8.4.2")) && page.contains("as it was received (7.8.2.2)"));
    }
    let page =
        with(json!({"sampling": "by the laboratory", "sampled": [{"date": "2026-06-12", "conditions": ""}]}));
    for letter in ["b", "c", "d", "f"] {
        assert!(page.contains(&blank(&format!("7.8.5 {letter}"))), "{letter}");
    }
    assert!(page.contains("2026-06-12"));
    assert!(!page.contains("(7.8.4.2)") && !page.contains("as it was received"));
    let notes = sheet(&json!({"fluxcal": 1, "certificate": {"sampled": [{"dat": "2026-06-12"}]}})).notes;
    assert_eq!(notes, ["`certificate.sampled[0].dat` is not a key of the certificate; is `date` meant?"]);
}

/// u = 1e-5, and k = 2.228 of ten degrees of freedom (Student's t, 97.5 %), 1.96 where none are counted.
#[test]
fn an_element_of_a_pair_has_the_factor_of_its_degrees_of_freedom() {
    let page = |freedom: Value| {
        let identity = json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        html(&json!({"fluxcal": 1, "calibration": {"differential": {"matrix": identity,
            "covariance": [[1e-10]], "covariance_order": ["matrix[0][0]"], "fit": {"elements": {"xx": {
                "least_squares": 1.0, "std_independent": 1e-5, "std_noise": 1e-5, "weighted": 1.0, "weighted_std": 1e-5,
                "degrees_of_freedom": freedom}}}}}}))
    };
    assert!(page(json!(10.0)).contains("1.000000 ± 0.000022"));
    assert!(page(Value::Null).contains("1.000000 ± 0.000020"));
}

/// The offset of x: 0.308456 nT of sensorcal and −0.001082 nT of axescal, which states u of the sum, 0.004621 nT.
/// Between x and y 8413.871 arcsec from 90°, u = 0.555747 arcsec, k = 1.983: U = 1.10 arcsec = 0.00031°.
#[test]
fn results_are_those_of_the_document_with_their_expanded_uncertainty() {
    let page = html(&fixture("specs/calibrated/input.json"));
    for (row, result, k) in [
        ("sensor x, offset", "0.3074 ± 0.0097", "2.11"),
        ("between sensors x and y", "87.66281 ± 0.00031", "1.98"),
    ] {
        let (_, rest) = page.split_once(&format!("{row}</th>")).expect(row);
        let (cells, _) = rest.split_once("</tr>").expect("a row");
        assert!(cells.contains(&format!(">{result}<")) && cells.contains(&format!(">{k}<")), "{cells}");
    }
    // An instrument that gives field has a scale factor.
    let scale = json!({"value": 1.001, "std": 1e-5, "coverage_factor_95": 2.0});
    let field = json!({"fluxcal": 1, "calibration": {"sensors": {"x": {"sensitivity_nt_per_nt": scale}}}});
    let field = html(&field);
    assert!(field.contains("1.001000 ± 0.000020</td><td class=\"day\" data-label=\"unit\">nT/nT"), "{field}");
}

#[test]
fn coils_are_the_item_where_nothing_else_was_calibrated() {
    let page = html(&fixture("coilcal/every-procedure/expected.json"));
    for there in ["<p>Coil system</p>", "coil z, constant</th>", "nT/A"] {
        assert!(page.contains(there), "{there}");
    }
    assert!(!page.contains("<th scope=\"row\">coil system</th>"), "no reference of itself");
}

#[test]
fn keys_that_look_alike_are_pointed_out() {
    let document = json!({"fluxcal": 1, "costumer": "A", "instrument": {"serial_number": "7", "turns": 3},
        "facility": {"voltmeter": {"serial": "9"}},
        "recordings": [{"id": "a", "procedure": "free_run", "operator": "B"}, {"id": "b", "procedure": "free_run", "operator": "C"}],
        "certificate": {"isued": "2026-01-02", "item": {"serail": "7"}, "received": "yesterday"}});
    let notes = sheet(&document).notes;
    let expected = [
        "certificate.received is not a day in the form YYYY-MM-DD.",
        "`certificate.isued` is not a key of the certificate; is `issued` meant?",
        "`certificate.item.serail` is not a key of the certificate; is `serial` meant?",
        "`costumer` is not read; is it meant for `certificate.customer`?",
        "`facility.voltmeter.serial` is not read; is it meant for `certificate.item.serial`?",
        "`instrument.serial_number` is not read; is it meant for `certificate.item.serial`?",
        "`recordings[0].operator` (and 1 more) is not read; is it meant for `certificate.authorised_by`?",
    ];
    assert_eq!(BTreeSet::from_iter(notes.iter().map(String::as_str)), BTreeSet::from(expected));
    assert_eq!(notes.len(), expected.len());
    // What the certificate has already is not asked for.
    let given = json!({"fluxcal": 1, "customer": "A", "certificate": {"customer": {"name": "A"}}});
    assert!(sheet(&given).notes.is_empty());
}

#[test]
fn days_out_of_order_are_pointed_out() {
    let days = |received: &str, calibrated: Value, issued: &str| {
        sheet(&json!({"fluxcal": 1, "certificate": {"received": received, "calibrated": calibrated, "issued": issued}})).notes
    };
    assert!(days("2026-01-02", json!(["2026-01-03", "2026-01-05"]), "2026-01-05").is_empty());
    assert_eq!(days("2026-01-04", json!(["2026-01-03", "2026-01-05"]), "2026-01-04").len(), 2);
}

#[test]
fn data_beside_the_document_are_put_over_its_own() {
    let data = |number: &str, serial: &str| -> Certificate {
        let item = json!({"serial": serial, "model": "M"});
        serde_json::from_value(json!({"number": number, "item": item, "mood": "fair"})).expect("data")
    };
    let own = data("1", "7");
    let merged = own.overlaid(r#"{"number": "2", "item": {"serial": "8"}}"#).expect("data");
    assert_eq!(merged, data("2", "8"));
    let wrong = own.overlaid(r#"{"references": [{"kind": "ruler"}]}"#).expect_err("no such kind").to_string();
    assert!(wrong.starts_with("references[0].kind: found"), "{wrong}");
}

/// The certificate goes to its file; the page to standard output no longer, and to a file where -o names one.
#[test]
fn a_certificate_by_the_program() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_string();
    let document = testkit::fixture("scalarcal/meadow/expected.json");
    let document = document.to_str().expect("UTF-8");
    let run = testkit::run(REPORT, &["--certificate", &path("c.html"), document], "");
    assert_eq!((run.code, run.stdout.as_str()), (0, ""));
    let said = run.stderr;
    assert!(said.starts_with("report: certificate: 25 fields blank: number (7.8.2.1 d); "), "{said}");
    let read = |name: &str| fs::read_to_string(path(name)).expect("there");
    let first = read("c.html");
    assert!(!first.contains("@page { size:") && first.contains("counter(page) \" of \" counter(pages)"));
    let again =
        ["-q", "--paper", "letter", "--certificate", &path("d.html"), "-o", &path("page.html"), document];
    assert_eq!(testkit::run(REPORT, &again, "").code, 0);
    assert_eq!(first.replacen("@page {", "@page { size: letter;", 1), read("d.html"));
    assert!(read("page.html").contains("Sensors by the magnitude"));
    // Nothing that is read is written over, and the two outputs are two files.
    fs::copy(document, path("own.json")).expect("copied");
    let own = testkit::run(REPORT, &["--certificate", &path("own.json"), &path("own.json")], "");
    assert_eq!(own.code, 2, "{}", own.stderr);
    let lost = ["--certificate", &path("e.html"), "-o", &path("absent/page.html"), document];
    assert_eq!(testkit::run(REPORT, &lost, "").code, 2);
    assert!(fs::metadata(path("e.html")).is_err(), "all or nothing");
    for (one, words) in [("new.html", "name two files"), ("page.html", "name another file")] {
        let both = testkit::run(REPORT, &["--certificate", &path(one), "-o", &path(one), document], "");
        assert!(both.code == 2 && both.stderr.contains(words), "{}", both.stderr);
    }
    let page = with(json!({"number": "</style><script>x</script>\" }"}));
    assert!(!page.contains("<script") && page.matches("</style>").count() == 1);
}

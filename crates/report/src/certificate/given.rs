//! What the template of the certificate is given beside the document.

use crate::conformity::{Joint, Spec, axes, offset_path};
use crate::page::number;
use crate::page::template::part;
use common::{Axis, Certificate, Document, PerAxis, Quantity, procedure};
use minijinja::{Value, context};

use crate::certificate::sheet::BLANK;
use crate::certificate::{days, directions};

/// What is asked of a certificate.
#[derive(Clone, Debug, Default)]
pub struct Asked<'a> {
    /// SHA-256 of the document's text, in hexadecimal.
    pub document_sha256: Option<&'a str>,
    /// SHA-256 of the text of administrative data beside the document.
    pub data_sha256: Option<&'a str>,
    /// What the stages found striking, a sentence each, for the remarks.
    pub findings: &'a [String],
    /// The specification of a statement of conformity, with the SHA-256 of its text.
    pub spec: Option<(&'a Spec, Option<&'a str>)>,
}

pub fn context(document: &Document, data: &Certificate, joint: &Joint, asked: &Asked<'_>) -> Value {
    let offsets: PerAxis<(Quantity, f64)> =
        Axis::ALL.into_iter().filter_map(|axis| Some((axis, offset(document, joint, axis)?))).collect();
    let findings: Vec<String> = asked.findings.iter().map(|words| words.replace('`', "")).collect();
    let mut columns = document.recordings.iter().flat_map(|recording| recording.columns.keys());
    context! {
        data,
        instrument => part(&document.instrument),
        facility => part(&document.facility),
        calibration => part(&document.calibration),
        model => part(&document.model),
        history => document.history,
        version => env!("CARGO_PKG_VERSION"),
        blank => BLANK,
        asked => context! {
            document => asked.document_sha256,
            data => asked.data_sha256,
            spec => asked.spec.and_then(|(_, hash)| hash),
            conformity => asked.spec.is_some(),
        },
        days => context! { words => days::days(document, data).map(|days| days.words) },
        temperatures => context! {
            sensor => recorded(document, "sensor"),
            electronics => recorded(document, "electronics"),
            coil => recorded(document, "coil"),
        },
        drives => columns.any(|name| name.starts_with("coil_")),
        side_by_side => document.recordings.iter().any(|one| one.procedure == procedure::DIFFERENTIAL),
        offsets,
        directions => context! {
            sensors => directions::tables(document, joint, "sensors", "SEN"),
            coils => directions::tables(document, joint, "coils", "GEO"),
        },
        findings,
    }
}

/// O of a sensor and its factor; where axescal found more of the offset, O is the sum, with its uncertainty.
fn offset(document: &Document, joint: &Joint, axis: Axis) -> Option<(Quantity, f64)> {
    let stated = document.calibration.as_ref()?.sensor(axis)?.offset_nt.as_ref()?;
    let factor = joint.factor(&offset_path(document, axis));
    let Some(added) = axes(document).and_then(|axes| axes.offsets_nt.as_ref()?.get(axis)) else {
        return Some((stated.clone(), factor));
    };
    let sum = stated.value() + added.value();
    let sum = added.std().or(stated.std()).map_or(Quantity::Bare(sum), |std| Quantity::new(sum, std));
    Some((sum, added.coverage_factor_95().unwrap_or(factor)))
}

/// The lowest and the highest temperature that was recorded of a part, in columns and as conditions.
fn recorded(document: &Document, part: &str) -> Option<[f64; 2]> {
    let key = format!("{part}_temperature_c");
    let all = document.recordings.iter().flat_map(|recording| {
        let condition = recording.conditions.extra.get(&key).and_then(serde_json::Value::as_f64);
        recording.column(&key).unwrap_or_default().iter().copied().chain(condition)
    });
    number::ends(all)
}

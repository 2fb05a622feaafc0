//! Another choice of the frame that is fixed in the laboratory.

use common::covariance::rows;
use faer::{ColRef, Mat};
use serde_json::{Map, Value, json};

use super::draw::Draw;
use super::walk::{covariance, matrix, objects, recordings};

type Rotation = [[f64; 3]; 3];

/// A rotation by up to about two rad about an axis, both drawn from a seed.
pub fn rotation(seed: u64) -> Rotation {
    let mut draw = Draw::new(seed);
    let [w, x, y, z] = [1.0, draw.even(), draw.even(), draw.even()];
    let n = w * w + x * x + y * y + z * z;
    [
        [1.0 - 2.0 * (y * y + z * z) / n, 2.0 * (x * y - w * z) / n, 2.0 * (x * z + w * y) / n],
        [2.0 * (x * y + w * z) / n, 1.0 - 2.0 * (x * x + z * z) / n, 2.0 * (y * z - w * x) / n],
        [2.0 * (x * z - w * y) / n, 2.0 * (y * z + w * x) / n, 1.0 - 2.0 * (x * x + y * y) / n],
    ]
}

/// GEO turned by Q, B' = Q B: R' = R Qᵀ, η' = Q η, and so every vector in GEO. An orientation or η that is
/// not stated is the identity, and is stated then. Standard uncertainties of vectors in GEO are taken out,
/// since their covariance is not stated.
/// Panics: of theodolite angles, which count from the vertical: state orientations as matrices.
pub fn rotate_geo(document: &Value, q: &Rotation) -> Value {
    let mut turned = document.clone();
    let q = Mat::from_fn(3, 3, |i, j| q[i][j]);
    for recording in recordings(&mut turned) {
        let conditions = recording.entry("conditions").or_insert_with(|| json!({}));
        let conditions = conditions.as_object_mut().expect("conditions");
        assert!(!conditions.contains_key("theodolite"), "orientations as matrices");
        let orientation = conditions.get("orientation").and_then(matrix);
        let orientation = orientation.unwrap_or_else(|| Mat::identity(3, 3)) * q.transpose();
        conditions.insert("orientation".into(), json!(rows(&orientation)));
        if let Some(columns) = recording.get_mut("columns").and_then(Value::as_object_mut) {
            ["ambient", "outside", "field_geo"].iter().for_each(|quantity| series(columns, quantity, &q));
        }
    }
    if let Some(calibration) = turned.get_mut("calibration").and_then(Value::as_object_mut) {
        calibrated(calibration, &q);
    }
    objects(&mut turned, "", &mut |_, object| vectors(object, &q));
    turned
}

/// η and what is found with it.
fn calibrated(calibration: &mut Map<String, Value>, q: &Mat<f64>) {
    if calibration.contains_key("coils") {
        let axes = calibration.entry("axes").or_insert_with(|| json!({}));
        let nominal = || json!({"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]});
        axes.as_object_mut().expect("axes").entry("coils").or_insert_with(nominal);
    }
    let Some(axes) = calibration.get_mut("axes").and_then(Value::as_object_mut) else { return };
    let names = axes["coils"].as_object().and_then(covariance).map(|(_, names)| names);
    if let (Some(names), Some(cross)) = (names, axes.get("cross_covariance").and_then(matrix)) {
        axes.insert("cross_covariance".into(), json!(rows(&(cross * turn_of(&names, q).transpose()))));
    }
    for part in ["coils", "known_coils"] {
        let Some(coils) = axes.get_mut(part).and_then(Value::as_object_mut) else { continue };
        coils.insert("matrix".into(), json!(rows(&(q * matrix(&coils["matrix"]).expect("a matrix")))));
        if let Some((covariance, names)) = covariance(coils) {
            let turn = turn_of(&names, q);
            coils.insert("covariance".into(), json!(rows(&(&turn * covariance * turn.transpose()))));
        }
    }
}

/// How the entries of Q η follow from those of η, both by the names `matrix[i][j]`.
fn turn_of(names: &[String], q: &Mat<f64>) -> Mat<f64> {
    let places = |name: &String| {
        let digits: Vec<usize> = name.chars().filter_map(|c| c.to_digit(10)).map(|d| d as usize).collect();
        (digits[0], digits[1])
    };
    Mat::from_fn(names.len(), names.len(), |to, from| {
        let ((i, j), (k, l)) = (places(&names[to]), places(&names[from]));
        if j == l { q[(i, k)] } else { 0.0 }
    })
}

fn series(columns: &mut Map<String, Value>, quantity: &str, q: &Mat<f64>) {
    let names = ["x", "y", "z"].map(|axis| format!("{quantity}_{axis}_nt"));
    if names.iter().all(|name| !columns.contains_key(name)) {
        return;
    }
    let of = |name: &String| {
        columns[name].as_array().expect("all three").iter().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
    };
    let before: Vec<Vec<f64>> = names.iter().map(of).collect();
    for (name, row) in names.iter().zip(rows(&(q * common::covariance::matrix(&before)))) {
        columns.insert(name.clone(), json!(row));
    }
}

/// Fields that an object states for x, y and z, or north, east and down.
fn vectors(object: &mut Map<String, Value>, q: &Mat<f64>) {
    for names in [["ambient_x_nt", "ambient_y_nt", "ambient_z_nt"], ["north_nt", "east_nt", "down_nt"]] {
        turn(object, names, q);
    }
    if let Some(field) = object.get_mut("residual_field_nt").and_then(Value::as_object_mut) {
        turn(field, ["x", "y", "z"], q);
    }
}

fn turn(object: &mut Map<String, Value>, names: [&str; 3], q: &Mat<f64>) {
    let value = |value: &Value| value.as_f64().or_else(|| value.get("value")?.as_f64());
    let Some(vector) =
        names.iter().map(|name| object.get(*name).and_then(value)).collect::<Option<Vec<f64>>>()
    else {
        return;
    };
    for (name, turned) in names.iter().zip((q * ColRef::from_slice(&vector)).iter()) {
        object.insert((*name).into(), (*turned).into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_of_a_turn_about_the_diagonal() {
        let q = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let document = json!({
            "recordings": [{"id": "a", "columns": {"ambient_x_nt": [1.0], "ambient_y_nt": [2.0], "ambient_z_nt": [3.0]}}],
            "calibration": {"coils": {}, "axes": {"residual_field_nt": {"x": {"value": 1.0, "std": 9.0}, "y": 2.0, "z": 3.0}}}
        });
        let turned = rotate_geo(&document, &q);
        let recording = &turned["recordings"][0];
        let orientation = json!([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
        let columns = json!({"ambient_x_nt": [3.0], "ambient_y_nt": [1.0], "ambient_z_nt": [2.0]});
        assert_eq!(recording["conditions"]["orientation"], orientation);
        assert_eq!(recording["columns"], columns);
        assert_eq!(turned["calibration"]["axes"]["coils"]["matrix"], json!(q));
        assert_eq!(turned["calibration"]["axes"]["residual_field_nt"], json!({"x": 3.0, "y": 1.0, "z": 2.0}));
        let q = rotation(7);
        let q = Mat::from_fn(3, 3, |i, j| q[i][j]);
        assert!((&q * q.transpose() - Mat::<f64>::identity(3, 3)).norm_max() < 1e-15);
    }
}

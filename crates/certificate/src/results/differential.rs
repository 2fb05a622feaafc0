//! A magnetometer against a reference magnetometer: the matrix and the offsets.

use common::{Axis, Document};
use estimate::stats;

use crate::expanded::Expanded;
use crate::sheet::Sheet;

/// η and d of T = R η + d.
pub fn tables(sheet: &mut Sheet, document: &Document) {
    let found = document.calibration.as_ref().and_then(|calibration| calibration.differential.as_ref());
    let Some(found) = found else { return };
    let variance = |name: &str| {
        let place = found.covariance_order.as_ref()?.iter().position(|key| key == name)?;
        found.covariance.as_ref()?.get(place)?.get(place).copied()
    };
    let mut table = Expanded::table(
        "Matrix η and offset d of T = R η + d: test readings T by reference readings R, rows are samples",
    );
    for test in Axis::ALL {
        for reference in Axis::ALL {
            let (row, column) = (reference.index(), test.index());
            let Some(matrix) = &found.matrix else { continue };
            let std = variance(&format!("matrix[{row}][{column}]")).map(f64::sqrt);
            let what = format!("test axis {test} from reference axis {reference}");
            let element = found.fit.as_ref().and_then(|fit| fit.elements.get(&format!("{reference}{test}")));
            let freedom = element.and_then(|element| element.degrees_of_freedom);
            let factor = freedom.map(|freedom| stats::coverage_factor(0.95, freedom));
            Expanded::new(matrix[row][column], std, factor).row(&mut table, &what, "nT/nT");
        }
        if let Some(offset) = found.offset_nt.as_ref().and_then(|all| all.get(test)) {
            Expanded::of(offset, None).row(&mut table, &format!("test axis {test}, offset"), "nT");
        }
    }
    sheet.table(table);
}

//! Haar variances against SciPy's integrals (fixtures/reference/haar_scipy.py).

use estimate::haar::power_law_variances;
use testkit::reference::{list, number, reference};

#[test]
fn scipy_has_the_same() {
    for case in list(&reference("haar_scipy")["cases"]) {
        let level = number(&case["level"]) as usize;
        let found = power_law_variances(number(&case["exponent"]), level + 1)[level];
        let off = (found / number(&case["variance"]) - 1.0).abs();
        assert!(off < 1e-7, "{case}: {off}");
    }
}

use nalgebra::{DMatrix, DVector};

/// The x ≥ 0 that minimises |A x − b|: Lawson and Hanson 1974, chapter 23 (NNLS).
fn not_negative(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let columns = a.ncols();
    let mut x = DVector::zeros(columns);
    let mut free: Vec<usize> = Vec::new();
    let scale = a.column_iter().map(|column| column.norm()).fold(0.0, f64::max) * b.norm();
    for _ in 0..3 * columns {
        let gradient = a.tr_mul(&(b - a * &x));
        let held = (0..columns).filter(|column| !free.contains(column));
        let Some(best) = held.max_by(|i, j| gradient[*i].total_cmp(&gradient[*j])) else { break };
        if gradient[best] <= 1e-13 * scale {
            break;
        }
        free.push(best);
        loop {
            let solution = solve(&a.select_columns(&free), b);
            if solution.iter().all(|value| *value > 0.0) {
                x.fill(0.0);
                free.iter().zip(solution.iter()).for_each(|(column, value)| x[*column] = *value);
                break;
            }
            // As far towards the solution as all stay at zero or above; what reaches zero is held there.
            let share = free
                .iter()
                .zip(solution.iter())
                .filter(|(_, value)| **value <= 0.0)
                .map(|(column, value)| x[*column] / (x[*column] - value))
                .fold(1.0, f64::min);
            for (column, value) in free.iter().zip(solution.iter()) {
                x[*column] += share * (value - x[*column]);
                if *value <= 0.0 && x[*column] <= 1e-15 * value.abs() {
                    x[*column] = 0.0;
                }
            }
            let before = free.len();
            free.retain(|column| x[*column] > 0.0);
            if free.is_empty() || free.len() == before {
                break;
            }
        }
    }
    x
}

/// The x that minimises |A x − b|, by Householder's QR.
fn solve(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let (q, r) = a.clone().qr().unpack();
    r.solve_upper_triangular(&q.tr_mul(b)).unwrap_or_else(|| DVector::zeros(a.ncols()))
}

/// The x that minimises |A x − b| with G x ≥ h, none where no x keeps them: Lawson and Hanson 1974, chapter
/// 23 (LSI, by way of the least distance with inequalities).
pub fn above(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    bounds: &DMatrix<f64>,
    least: &DVector<f64>,
) -> Option<DVector<f64>> {
    let (q, r) = a.clone().qr().unpack();
    let reached = q.tr_mul(b);
    // z = R x − Qᵀb: the shortest z with (G R⁻¹) z ≥ h − (G R⁻¹) Qᵀb.
    let across = r.tr_solve_upper_triangular(&bounds.transpose())?;
    let short = least - across.tr_mul(&reached);
    let (unknowns, count) = (a.ncols(), bounds.nrows());
    let mut dual = DMatrix::zeros(unknowns + 1, count);
    for column in 0..count {
        // A bound's own size changes nothing but the rounding.
        let size = across.column(column).norm().max(f64::MIN_POSITIVE);
        for row in 0..unknowns {
            dual[(row, column)] = across[(row, column)] / size;
        }
        dual[(unknowns, column)] = short[column] / size;
    }
    let mut one = DVector::zeros(unknowns + 1);
    one[unknowns] = 1.0;
    let rest = &dual * not_negative(&dual, &one) - one;
    if rest[unknowns].abs() < 1e-12 {
        return None;
    }
    let shortest = rest.rows(0, unknowns) / -rest[unknowns];
    r.solve_upper_triangular(&(shortest + reached))
}

use partial::{Partial, merge, parse, to_line};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::ops::Range;

/// Pieces at most into which a series is cut.
const PIECES: usize = 7;

/// The contract of statistics that are merged ([`partial::Partial`]), for pieces of a series of so many rows:
/// in any order and grouping, with a piece of no rows among them and each written and read again, they give
/// what `same` holds to be that of one pass, which also judges two ways of merging. A piece of no rows
/// changes no byte of another.
///
/// `piece` makes the statistics of some rows of the series of a seed.
pub fn partials_merge<P: Partial>(
    cases: u32,
    rows: usize,
    piece: impl Fn(u64, Range<usize>) -> P,
    same: impl Fn(&P, &P) -> Result<(), String>,
) {
    let cuts = prop::collection::vec(1..rows, 1..PIECES);
    let order = Just((0..=PIECES).collect::<Vec<usize>>()).prop_shuffle();
    let groups = prop::collection::vec(0..PIECES, PIECES);
    let given = (any::<u64>(), cuts, order, groups);
    let mut runner = TestRunner::new(Config { failure_persistence: None, ..Config::with_cases(cases) });
    let hold = |one: &P, other: &P| same(one, other).map_err(TestCaseError::fail);
    let joined = |pieces: Vec<P>| merge(pieces).unwrap_or_else(|error| panic!("{}", error.into()));
    runner
        .run(&given, |(seed, mut cuts, order, groups)| {
            cuts.extend([0, rows]);
            cuts.sort_unstable();
            cuts.dedup();
            let lines: Vec<String> =
                cuts.windows(2).map(|cut| to_line(&piece(seed, cut[0]..cut[1]))).collect();
            let read =
                |line: &String| parse::<P>(line).map_err(|error| TestCaseError::fail(error.to_string()));
            let whole = piece(seed, 0..rows);
            // An identity, on either side.
            let nothing = to_line(&piece(seed, 0..0));
            for pair in [[&nothing, &lines[0]], [&lines[0], &nothing]] {
                let changed = to_line(&joined(pair.into_iter().map(read).collect::<Result<_, _>>()?));
                prop_assert_eq!(&changed, &lines[0], "a piece of no rows changes another");
            }
            // Associative: two by two, neighbours of a random order, until one is left; commutative, since
            // neighbours in time come in any order.
            let order = order.into_iter().filter(|at| *at <= lines.len());
            let mut left: Vec<String> = order.map(|at| lines.get(at).unwrap_or(&nothing).clone()).collect();
            for at in groups {
                if left.len() > 1 {
                    let at = at % (left.len() - 1);
                    let mut first = read(&left[at])?;
                    let next = read(&left.remove(at + 1))?;
                    first.join(next).map_err(|error| TestCaseError::fail(error.into().to_string()))?;
                    left[at] = to_line(&first);
                    prop_assert_eq!(
                        &to_line(&read(&left[at])?),
                        &left[at],
                        "what is read is not what was written"
                    );
                    prop_assert!(!left[at].contains('\n'));
                }
            }
            let grouped = joined(left.iter().map(read).collect::<Result<_, _>>()?);
            let at_once = joined(lines.iter().rev().map(read).collect::<Result<_, _>>()?);
            hold(&whole, &grouped)?;
            hold(&grouped, &at_once)
        })
        .unwrap_or_else(|error| panic!("{error}"));
}

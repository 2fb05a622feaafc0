//! Values that begin with a minus sign.

use fluxcal::PROGRAMS;

use crate::{beside, commands, run};

/// The options of a help that take a value, and whether they take several with commas, as far as it tells.
fn options(help: &str) -> Vec<String> {
    let named = help.lines().filter_map(|line| {
        let line = line.trim_start();
        let short = line.get(..4).filter(|short| short.starts_with('-') && short.ends_with(' '));
        let line = short.map_or(line, |short| &line[short.len()..]);
        let (name, rest) = line.strip_prefix("--")?.split_once(' ')?;
        rest.starts_with('<').then(|| format!("--{name}"))
    });
    named.filter(|name| name != "--completions" && name != "--man").collect()
}

/// Whatever an option takes, a negative number is its value and not another option: it is taken, or refused
/// as a value.
#[test]
fn a_negative_number_is_the_value_of_an_option() {
    let (mut tried, mut numbers) = (0, 0);
    for program in PROGRAMS {
        let path = beside(program.name);
        for command in commands(&path) {
            for option in options(&run(&path, &command, &["--help"], "").stdout) {
                let nothing =
                    run(&path, &command, &[&option, "nothing", "-q", "--no-such-option"], "").stderr;
                let is_number = nothing.contains("a number") || nothing.contains("invalid float");
                let values = if is_number { &["-3", "-0.5", "-1e-3", "-.5"][..] } else { &["-3", "-0.5"] };
                numbers += usize::from(is_number);
                for value in values {
                    // The option that there is not ends the program before it does anything.
                    let said = run(&path, &command, &[option.as_str(), value, "--no-such-option"], "");
                    let taken = said.stderr.contains("'--no-such-option'")
                        || said.stderr.contains(&format!("invalid value '{value}' for '{option} <"));
                    assert!(taken && said.code == 2, "{path} {command:?} {option}: {}", said.stderr);
                    tried += 1;
                }
            }
        }
    }
    assert!(tried > 200 && numbers > 20, "{tried} {numbers}");
}

#[test]
fn lists_may_begin_with_a_negative_number() {
    let path = beside("sensorcal");
    for option in ["--budget-field-nt", "--budget-warmer-k"] {
        let said = run(&path, &[], &[option, "-50000,0,-1.5e4", "--no-such-option"], "");
        assert!(said.stderr.contains("'--no-such-option'"), "{}", said.stderr);
    }
    let said = run(&beside("axescal"), &["design".into()], &["--drive-nt", "-1,2,3"], "");
    assert!(said.stderr.contains("found -1; expected a number above zero"), "{}", said.stderr);
}

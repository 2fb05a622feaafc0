//! `sensorcal`: each sensor by itself.

use clap::Parser;
use program::pipe::{self, Program, StageIo};
use program::{manual, number};
use sensorcal::Options;
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "sensorcal", version: env!("CARGO_PKG_VERSION"), takes: &sensorcal::PROCEDURES };

/// Find sensitivity, offset, noise, drift and coefficients of each sensor, with their uncertainty
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    simulate campaign fixtures/plans/magsat.json | coilcal | sensorcal > result.json\n\n\
    Exit codes: 0 done; 1 the recordings do not determine the answer; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(flatten)]
    stage: StageIo,
    /// How far the turn of a reversal may miss 180°, deg
    #[arg(long, value_name = "DEG", default_value_t = 3.0, value_parser = number::not_negative)]
    turn_deg: f64,
    /// How far axes may be from nominal where the document does not give them (standard deviation), deg
    #[arg(long, value_name = "DEG", default_value_t = 3.0, value_parser = number::not_negative)]
    axes_std_deg: f64,
    /// Fields along the sensor for the error budget, nT [default: zero, half and all of what was applied]
    #[arg(long, value_name = "NT", value_delimiter = ',', value_parser = number::finite)]
    budget_field_nt: Vec<f64>,
    /// Temperatures less the reference for the error budget, K [default: 0, and 10 where coefficients are known]
    #[arg(long, value_name = "K", value_delimiter = ',', value_parser = number::finite)]
    budget_warmer_k: Vec<f64>,
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(manual::parse::<Cli>()))
}

fn run(cli: Cli) -> anyhow::Result<()> {
    let mut arguments =
        vec![format!("--turn-deg={}", cli.turn_deg), format!("--axes-std-deg={}", cli.axes_std_deg)];
    let lists = [("--budget-field-nt", &cli.budget_field_nt), ("--budget-warmer-k", &cli.budget_warmer_k)];
    for (name, values) in lists.into_iter().filter(|(_, values)| !values.is_empty()) {
        let values: Vec<String> = values.iter().map(f64::to_string).collect();
        arguments.push(format!("{name}={}", values.join(",")));
    }
    let options = Options {
        turn_deg: cli.turn_deg,
        axes_std_deg: cli.axes_std_deg,
        budget_field_nt: cli.budget_field_nt,
        budget_warmer_k: cli.budget_warmer_k,
    };
    pipe::stage(
        PROGRAM,
        &cli.stage,
        arguments,
        |document| sensorcal::run(document, &options),
        sensorcal::summary,
    )?;
    Ok(())
}

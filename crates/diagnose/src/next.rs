//! The recording that would decide between two explanations, in words.

use physics::{Kind, Place};

/// What separates two effects, by their names with their targets.
pub fn between(first: &str, second: &str) -> String {
    let kinds = [first, second].map(|name| Kind::named(name.split(' ').next().unwrap_or(name)));
    let [Some(a), Some(b)] = kinds else {
        return "record more of what each follows, so that the two no longer run together".into();
    };
    let either = |test: fn(Kind) -> bool| test(a) || test(b);
    let both = |test: fn(Kind) -> bool| test(a) && test(b);
    let electronics = |kind: Kind| kind.about().needs.contains(&"electronics_temperature_c");
    let thermal = |kind: Kind| kind.about().needs.iter().any(|need| need.contains("temperature"));
    let time = |kind: Kind| {
        matches!(
            kind,
            Kind::WarmUp | Kind::Ageing | Kind::SensitivityAgeing | Kind::PillarSettling | Kind::ReadingStep
        )
    };
    let lagged = |kind: Kind| {
        matches!(
            kind,
            Kind::OffsetTemperatureLag
                | Kind::SensitivityTemperatureLag
                | Kind::AxisCreep
                | Kind::OffsetElectronicsTemperatureLag
                | Kind::SensitivityElectronicsTemperatureLag
        )
    };
    let rate = |kind: Kind| {
        matches!(
            kind,
            Kind::LoopBandwidth
                | Kind::Delay
                | Kind::ClockOffset
                | Kind::ClockRate
                | Kind::EddyCurrents
                | Kind::InductionDifference
        )
    };
    let sensitivity = |kind: Kind| kind.name().starts_with("sensitivity");
    if either(electronics) && either(thermal) && electronics(a) != electronics(b) {
        return "heat the electronics alone, then the sensor alone".into();
    }
    if either(thermal) && either(time) {
        return "ramp the temperature up and down again, without switching the instrument off: what follows temperature turns back, what \
                follows time does not"
            .into();
    }
    if both(time) {
        return "record for several times as long, and switch the instrument off and on once in between"
            .into();
    }
    if both(rate) {
        return "repeat the same drive at half and at twice the rate, one coil at a time, and once with the drive held between steps: a \
                delay, a loop's lag and eddy currents differ in how they depend on the rate and on the coil"
            .into();
    }
    if both(thermal) && either(|kind| kind == Kind::OffsetTemperatureInflection) {
        return "take the temperature farther to both sides: a coefficient that changes once is constant there, one that bends goes on \
                bending"
            .into();
    }
    if both(thermal) && lagged(a) != lagged(b) {
        return "ramp the temperature up and down at twice the rate: a lag opens the loop".into();
    }
    if both(thermal) && sensitivity(a) != sensitivity(b) {
        return "repeat the temperature run at zero field and at two opposite fields".into();
    }
    let facility = |kind: Kind| matches!(kind.place(), Place::Facility | Place::Environment);
    if facility(a) != facility(b) {
        return "turn the sensor block by 90° and repeat: what belongs to the sensor turns with it, what belongs to the facility does not; \
                and record once without drive"
            .into();
    }
    if both(facility) {
        return "drive each coil by itself in both directions, and record once without drive".into();
    }
    if both(|kind| kind.place() == Place::Sensor) {
        return "reverse the sensor in the field, and drive the coils across it one at a time, up and down"
            .into();
    }
    "repeat with the sensor reversed and at half the rate".into()
}

/// What to record where structure has no name.
pub fn unexplained(covariate: &str) -> String {
    match covariate {
        "time_s" => "repeat the recording at another hour with all temperatures recorded and the drive held: what follows time alone comes \
                     back at the same time after switching on"
            .into(),
        name if name.contains("temperature") => {
            "ramp that temperature up and down at two rates with everything else held".into()
        }
        name if name.contains("across") => {
            "drive the coil across the sensor up and down with the others at zero, in two orientations of the block".into()
        }
        name if name.contains("along") => {
            "drive the coil along the sensor up and down at two rates with the others at zero, and with the sensor reversed".into()
        }
        name => format!("change {name} alone, with the drive held"),
    }
}

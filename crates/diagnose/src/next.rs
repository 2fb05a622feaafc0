//! What to record next, in words.

/// What to record where no variation of a recording that was made decides.
pub const MORE: &str =
    "record more of what each of the names follows, so that the two no longer run together";

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

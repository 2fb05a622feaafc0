//! Families of effects: what their forms have in common, and the recording that tells their members apart.

use crate::Kind;
use crate::words::words;

words! {
    /// What kind of physics an effect is, whatever its form.
    pub enum Family {
        /// The reading comes after the field: a causal response, or a clock.
        LateResponse = "late_response",
        /// Offset, scale or axis go with something recorded, late or not.
        FollowsColumn = "follows_column",
        /// The reading is no straight line of the field at the sensor, now or earlier.
        OwnField = "own_field",
        /// A field of the surroundings that the facility does not cancel, or adds.
        OutsideField = "outside_field",
        /// The field is not the same everywhere.
        Position = "position",
        /// Fields of a frequency.
        Lines = "lines",
        /// What goes on with time.
        Time = "time",
        /// What happens at moments.
        Moments = "moments",
        /// What the converter makes of a reading.
        Codes = "codes",
    }
}

impl Family {
    /// In words.
    pub fn title(self) -> &'static str {
        match self {
            Family::LateResponse => "a late response to the field",
            Family::FollowsColumn => "a dependence on something recorded",
            Family::OwnField => "a nonlinear or history-dependent response to the field",
            Family::OutsideField => "a field of the surroundings",
            Family::Position => "a field that depends on the position",
            Family::Lines => "periodic fields",
            Family::Time => "a change with time",
            Family::Moments => "events at moments",
            Family::Codes => "unequal or coarse codes",
        }
    }

    /// The recording that tells its members apart.
    pub fn told_apart_by(self) -> &'static str {
        match self {
            Family::LateResponse => {
                "Drive one coil at a time with steps, then with sines of several frequencies: a delay has a phase in proportion to the frequency, a loop falls off at high ones, eddy currents belong to the coil that is driven whatever the sensor, and a clock is off for slow housekeeping too."
            }
            Family::FollowsColumn => {
                "Move one cause at a time: warm sensor, electronics and coils one after another, in zero field and in a strong one (an offset or a scale), quickly and slowly (a lag), and switch each load by itself."
            }
            Family::OwnField => {
                "Step the field along one axis up and down again over the whole range, the others at zero, then the transverse ones with this at zero: even and odd parts, saturation and the width of a loop show by themselves."
            }
            Family::OutsideField => {
                "Repeat with the coils off and with the nulling off, in several orientations of the sensor block, beside a magnetometer outside."
            }
            Family::Position => {
                "Repeat with the sensor block moved by some centimetres along each axis, one coil driven."
            }
            Family::Lines => {
                "Sample faster for some minutes, so that no line is an alias, with each machine on and off in turn."
            }
            Family::Time => {
                "Record at a constant field and temperature, from switching on, over days, and once more after it was off."
            }
            Family::Moments => {
                "Record the same span with a second instrument beside it, and log what is moved and switched."
            }
            Family::Codes => "Sweep the field slowly over some codes and take the counts themselves.",
        }
    }

    /// Its members, in the order of the catalogue.
    pub fn members(self) -> impl Iterator<Item = Kind> {
        Kind::ALL.iter().copied().filter(move |kind| kind.about().family == self)
    }
}

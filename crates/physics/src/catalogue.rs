//! The catalogue: every effect by name. A new effect is one file and one line here.

use common::{AdoptedEffect, Axis, Document};
use nalgebra::Vector3;

use crate::effects::{CoilHeating, OffsetTemperatureLag};
use crate::{Effect, EffectInstance, Error, ParameterInfo, Place, Real, Surroundings};

macro_rules! catalogue {
    ($($effect:ident),+ $(,)?) => {
        /// The effects that fluxcal knows.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Kind {
            $(#[doc = concat!("See the effect `", stringify!($effect), "`.")] $effect,)+
        }

        impl Kind {
            /// All of them.
            pub const ALL: &'static [Kind] = &[$(Kind::$effect),+];

            /// Name in documents.
            pub fn name(self) -> &'static str {
                match self { $(Kind::$effect => $effect::NAME),+ }
            }

            /// In the field's words.
            pub fn title(self) -> &'static str {
                match self { $(Kind::$effect => $effect::TITLE),+ }
            }

            /// One sentence of physics.
            pub fn physics(self) -> &'static str {
                match self { $(Kind::$effect => $effect::PHYSICS),+ }
            }

            /// The equation of its contribution.
            pub fn equation(self) -> &'static str {
                match self { $(Kind::$effect => $effect::EQUATION),+ }
            }

            /// Where that is written.
            pub fn source(self) -> &'static str {
                match self { $(Kind::$effect => $effect::SOURCE),+ }
            }

            /// Where in the chain it acts.
            pub fn place(self) -> Place {
                match self { $(Kind::$effect => $effect::PLACE),+ }
            }

            /// Its parameters.
            pub fn parameters(self) -> &'static [ParameterInfo] {
                match self { $(Kind::$effect => $effect::PARAMETERS),+ }
            }

            /// Adds its contribution to a signal; see [`Effect::apply`].
            pub fn apply<T: Real>(
                self,
                parameters: &[T],
                axis: Axis,
                signal: &mut [Vector3<T>],
                around: &Surroundings<'_, T>,
            ) -> Result<(), Error> {
                match self { $(Kind::$effect => $effect::apply(parameters, axis, signal, around)),+ }
            }
        }
    };
}

catalogue![OffsetTemperatureLag, CoilHeating];

/// The effects that a document's model has adopted.
pub fn adopt(document: &Document) -> Result<Vec<EffectInstance>, Error> {
    let adopted = document.model.iter().flat_map(|model| &model.effects);
    adopted.enumerate().map(|(index, effect)| instance(index, effect)).collect()
}

fn instance(index: usize, adopted: &AdoptedEffect) -> Result<EffectInstance, Error> {
    let refuse = |found: String, expected: String| Error::Unknown { index, found, expected };
    let kind = Kind::ALL.iter().copied().find(|kind| kind.name() == adopted.effect).ok_or_else(|| {
        let names: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
        refuse(format!("the effect \"{}\"", adopted.effect), format!("one of {}", names.join(", ")))
    })?;
    let (part, axis) = match kind.place() {
        Place::Coil => ("coil", adopted.coil),
        _ => ("sensor", adopted.sensor),
    };
    let axis = axis.ok_or_else(|| {
        refuse(format!("{} without \"{part}\"", kind.name()), format!("\"{part}\": \"x\", \"y\" or \"z\""))
    })?;
    let parameters = kind
        .parameters()
        .iter()
        .map(|info| {
            let found = adopted.parameters.get(info.name).map(common::Quantity::value);
            let value = found.ok_or_else(|| {
                refuse(
                    format!("{} without the parameter {}", kind.name(), info.name),
                    format!("a number for {}", info.name),
                )
            })?;
            if info.positive && value <= 0.0 {
                return Err(refuse(format!("{} = {value}", info.name), "a positive number".into()));
            }
            Ok(value)
        })
        .collect::<Result<_, _>>()?;
    Ok(EffectInstance { kind, axis, parameters })
}
